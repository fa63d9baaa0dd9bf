"""Charts of ``bsdftree info``: on a terminal that shows them, nowhere else, and with the right heights."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from bsdftree import Bsdf, Tree
from bsdftree.cli._info_charts import can_chart, leaves_chart, lying, totals_chart, upright

BLOCKS = "▁▂▃▄▅▆▇█▏▎▍▌▋▊▉"


@pytest.fixture
def bsdf() -> Bsdf:
    grid = np.full((4, 4, 4, 4), 0.2)
    grid[0, 0] = 0.1
    return Bsdf.from_trees({"reflection_back": Tree.from_grid(grid)})


@pytest.fixture
def path(bsdf: Bsdf, tmp_path: Path) -> str:
    bsdf.save(tmp_path / "b.xml")
    return str(tmp_path / "b.xml")


def info(path: str, terminal: bool, **environment: str) -> str:
    """What the command prints, into a terminal of its own or a pipe."""
    command = [sys.executable, "-m", "bsdftree", "info", path]
    kept = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR", "TERM", "PYTHONIOENCODING")}
    env = {**kept, "TERM": "xterm-256color", "PYTHONUTF8": "1", **environment}
    if not terminal:
        return subprocess.run(command, env=env, stdout=subprocess.PIPE, check=True).stdout.decode()
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    with subprocess.Popen(command, env=env, stdin=theirs, stdout=theirs, stderr=theirs, close_fds=True) as process:
        os.close(theirs)
        pieces = []
        while True:
            try:
                piece = os.read(ours, 65536)
            except OSError:  # Linux's word for the end
                break
            if not piece:
                break
            pieces.append(piece)
    os.close(ours)
    assert process.returncode == 0
    return b"".join(pieces).decode(errors="replace").replace("\r\n", "\n")


def has_blocks(text: str) -> bool:
    return any(c in BLOCKS for c in text)


def test_terminal_shows_charts_and_pipes_do_not(path: str) -> None:
    shown, piped = info(path, True), info(path, False)
    assert "█" in shown and "Leaves by depth" in shown
    assert not has_blocks(piped) and "\x1b" not in piped and "Leaves by depth" not in piped
    plain = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    # The charts are added; all else is as it is piped.
    assert set(map(str.strip, piped.splitlines())) <= set(map(str.strip, plain.splitlines()))


@pytest.mark.parametrize(
    "environment", [{"NO_COLOR": "1"}, {"TERM": "dumb"}, {"PYTHONIOENCODING": "latin-1:replace", "PYTHONUTF8": "0"}]
)
def test_terminals_that_ask_for_plain_text_get_it(path: str, environment: dict[str, str]) -> None:
    shown = info(path, True, **environment)
    assert not has_blocks(shown) and "Leaves by depth" not in shown
    assert "reflection_back" in shown


def test_charts_need_an_encoding_that_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for encoding, there in (("utf-8", True), ("ascii", False), ("latin-1", False)):
        file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
        assert can_chart(Console(file=file, force_terminal=True)) == there
    assert not can_chart(Console(file=io.StringIO()))


def test_bars_are_as_long_as_values() -> None:
    assert upright([0.0, 0.125, 0.5, 1.0, 1e-9], 1.0) == " ▁▄█▁"
    assert lying(1.0, 4) == "████" and lying(0.0, 4) == "    "
    assert lying(0.5, 4) == "██  " and lying(0.53125, 4) == "██▏ "
    assert upright([0.0, 0.0], 0.0) == "  "


def test_charts_have_totals_and_leaves(bsdf: Bsdf) -> None:
    level = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1,) * 4, 0.5 / np.pi))})
    curve, axis = totals_chart(level, "Visible")
    assert "█" * 30 in curve and curve.endswith("50.0..50.0 %") and axis.endswith("full: 50.0 %")
    assert leaves_chart(level.to_klems("quarter"), "Visible") == []
    head, *rows = leaves_chart(bsdf, "Visible")
    tree = bsdf.components["reflection_back"]
    assert isinstance(tree, Tree) and "refl._back" in head
    assert [row.split()[0] for row in rows] == [f"2^{k}" for k in range(tree.depth + 1)]
    assert sum(int(row.split()[-1].replace(",", "")) for row in rows) == tree.n_leaves
    assert all(len(line) <= 80 for line in (*rows, curve, axis))


def test_black_has_no_chart() -> None:
    black = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.zeros((1,) * 4))})
    assert totals_chart(black, "Visible") == []
