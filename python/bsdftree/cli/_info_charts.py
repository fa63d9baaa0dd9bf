"""Charts of block characters that ``bsdftree info`` adds on a terminal.

Enters a BSDF, leave lines of text at most 80 columns wide: totals against the incident angle, and leaves by depth.
"""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike
from rich.console import Console

from bsdftree import Bsdf, Tree
from bsdftree._cells import cells_of
from bsdftree._sides import SIDES
from bsdftree._totals import totals_by_azimuth

_UP = " ▁▂▃▄▅▆▇█"
_RIGHT = " ▏▎▍▌▋▊▉█"
# A column for every three degrees.
_THETA_DEG = np.arange(0.0, 90.0, 3.0) + 1.5
_BAR = 10


def can_chart(console: Console) -> bool:
    """Whether a console is a terminal that shows block characters, and nobody asked for plain text."""
    if not console.is_terminal or console.is_dumb_terminal or os.environ.get("NO_COLOR"):
        return False
    try:
        (_UP + _RIGHT).encode(console.encoding)
    except (LookupError, UnicodeEncodeError):
        return False
    return True


def upright(values: ArrayLike, highest: float) -> str:
    """One character for each value, eighths of a line high; what is more than nothing is seen."""
    parts = np.asarray(values, float) / (highest or 1.0)
    eighths = np.where(parts > 0.0, np.clip(np.round(8.0 * parts), 1, 8), 0).astype(int)
    return "".join(_UP[k] for k in eighths)


def lying(part: float, width: int) -> str:
    """A bar of ``width`` characters for 1, to an eighth of one; what is more than nothing is seen."""
    eighths = int(np.clip(round(8 * width * part), 1 if part > 0.0 else 0, 8 * width))
    bar = "█" * (eighths // 8) + (_RIGHT[eighths % 8] if eighths % 8 else "")
    return bar.ljust(width)


def totals_chart(bsdf: Bsdf, band: str) -> list[str]:
    """Hemispherical totals of each component against the incident angle, mean over azimuth; one scale for all."""
    curves = {
        key: totals_by_azimuth(bsdf, sides.incident, sides.kind, _THETA_DEG, band).mean(axis=1)
        for key, sides in SIDES.items()
    }
    curves = {key: curve for key, curve in curves.items() if curve.max() > 0.0}
    if not curves:
        return []
    highest = max(float(curve.max()) for curve in curves.values())
    lines = [
        f"{key:<18} {SIDES[key]!s:<17} {upright(curve, highest)} {100 * curve.min():4.1f}..{100 * curve.max():4.1f} %"
        for key, curve in curves.items()
    ]
    n = len(_THETA_DEG)
    axis = "0°" + "45°".center(n - 5) + "90°"
    return [*lines, " " * 37 + axis + f" full: {100 * highest:.1f} %"]


def leaves_chart(bsdf: Bsdf, band: str) -> list[str]:
    """Leaves of each tree by depth: bars of the part of all, and numbers; nothing for matrices."""
    trees = {key: c for key, c in bsdf.components_of(band).items() if isinstance(c, Tree)}
    if not trees:
        return []
    counts = {key: cells_of(tree).counts.astype(int) for key, tree in trees.items()}
    short = {key: key.replace("reflection", "refl.").replace("transmission", "trans.") for key in trees}
    lines = ["depth".ljust(7) + "".join(short[key].ljust(_BAR + 8) for key in trees)]
    for depth in range(max(tree.depth for tree in trees.values()) + 1):
        cells = []
        for n in counts.values():
            there = depth < len(n)
            bar = lying(n[depth] / (n.max() or 1), _BAR - 1) if there else " " * (_BAR - 1)
            number = f"{_short(int(n[depth]))}" if there else ""
            cells.append(f"{bar} {number:<8}")
        lines.append(f"2^{depth}".ljust(7) + "".join(cells))
    return [line.rstrip() for line in lines]


def _short(n: int) -> str:
    return f"{n:,}" if n < 1_000_000 else f"{n / 1e6:.1f} M"
