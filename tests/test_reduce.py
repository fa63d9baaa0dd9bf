"""Reduced trees: bounds on real files, light kept, and Radiance's reducer at equal numbers of leaves."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from radiance import needs_radiance

import bsdftree
from bsdftree import Bsdf, Tree, _core, direction_from_polar
from bsdftree._radiance.reduce import reduced as radiance_reduced
from bsdftree.cli import main

TREES = [
    "pyradiance/blindsT3.xml",
    "pyradiance/t3.xml",
    "ignis/simple_tensor_d3_t3_refl.xml",
    "ignis/simple_tensor_d2_refl.xml",
]


@pytest.mark.parametrize("name", TREES)
def test_bounds_hold_on_real_files(data, name):
    b = bsdftree.load(data / name)
    small = b.reduce(l1=0.03, total=0.01)
    losses = b.losses_of(small)
    assert [loss.component for loss in losses] == list(b.components)
    for _, component, before, after, loss in losses:
        assert loss.l1 <= 0.03 and loss.worst_total <= 0.01
        assert after == small.components[component].n_leaves <= before == b.components[component].n_leaves
    i = direction_from_polar(np.repeat(np.arange(2.5, 180, 5), 24), np.tile(np.arange(0, 360, 15), 36))
    for part in ("reflection", "transmission"):
        change = abs(small.hemispherical(i, part) - b.hemispherical(i, part))
        assert (change <= 0.01 * np.maximum(b.hemispherical(i, part), 0.1) * (1 + 1e-9)).all()


def test_the_worst_direction_is_where_the_total_changed_most(data):
    b = bsdftree.load(data / "pyradiance/blindsT3.xml")
    small = b.reduce(l1=0.2)
    for _, component, _, _, loss in b.losses_of(small):
        if loss.worst_total == 0:
            continue
        side = 1 if component.endswith("back") else -1
        theta = loss.worst_theta_deg if side > 0 else 180 - loss.worst_theta_deg
        i = direction_from_polar(theta, 0.0 if np.isnan(loss.worst_phi_deg) else loss.worst_phi_deg)
        part = component.split("_")[0]
        before, after = (float(f.hemispherical(i, part)) for f in (b, small))
        assert abs(after - before) / max(before, 0.1) == pytest.approx(loss.worst_total, rel=1e-6)


def test_sizes_are_kept(data):
    b = bsdftree.load(data / "pyradiance/t3.xml")
    small = b.reduce(n_leaves=3000)
    n = sum(c.n_leaves for c in small.components.values())
    assert 2000 < n <= 3000
    assert len(b.reduce(n_bytes=60_000).to_xml().encode()) <= 60_000
    with pytest.raises(ValueError, match="bytes are the least"):
        b.reduce(n_bytes=10)


@needs_radiance
@pytest.mark.parametrize("cull_percent", [60, 90, 99])
def test_no_norm_is_worse_than_by_radiances_reducer(cull_percent, rng):
    x = (np.arange(16) + 0.5) / 16
    ridge = np.exp(-300 * ((x[:, None, None, None] - x[:, None]) ** 2 + (x[:, None, None] - x) ** 2))
    values = (0.1 + 20 * ridge + 0.3 * x[:, None, None, None] * x[:, None]).astype(np.float32)
    whole = Tree.from_grid(values)
    theirs = Tree(radiance_reduced(values.reshape(-1), 4, 4, cull_percent, average=False))
    lost = whole.loss_of(theirs)
    by_l1, by_rms = (whole.reduce(n_leaves=theirs.n_leaves, norm=norm) for norm in ("l1", "rms"))
    assert max(by_l1.n_leaves, by_rms.n_leaves) <= theirs.n_leaves
    # Its reducer counts values that text rounds.
    assert whole.loss_of(by_l1).l1 <= lost.l1 + 1e-5
    assert whole.loss_of(by_rms).rms <= lost.rms + 1e-5


def test_bad_goals_are_errors():
    tree = Tree.from_grid(np.arange(8.0).reshape(2, 2, 2))
    with pytest.raises(ValueError, match="how far to reduce"):
        tree.reduce()
    with pytest.raises(ValueError, match=r"-0\.1; expected a number of at least 0"):
        tree.reduce(l1=-0.1)
    with pytest.raises(ValueError, match="leaves are needed"):
        tree.reduce(l1=0.001, n_leaves=2)
    with pytest.raises(ValueError, match='expected "l1" or "rms"'):
        tree.reduce(n_leaves=3, norm="l2")
    with pytest.raises(ValueError, match="exclude each other"):
        Bsdf.from_trees({"reflection_back": tree}).reduce(l1=0.1, n_leaves=4)
    with pytest.raises(ValueError, match="no tensor tree"):
        Bsdf.from_trees({"reflection_back": tree}).to_klems("quarter").reduce(l1=0.1)
    with pytest.raises(ValueError, match="finer than the first"):
        _core.loss(Tree.from_grid(np.ones((2, 2, 2)))._core, tree._core)


def test_from_grid_takes_a_tolerance():
    x = (np.arange(16) + 0.5) / 16
    values = np.exp(-8 * (x[:, None, None] - x[:, None]) ** 2 - x)
    whole, small = Tree.from_grid(values), Tree.from_grid(values, tolerance=0.05)
    assert whole.loss_of(small).l1 <= 0.05 and small.n_leaves < whole.n_leaves / 2
    assert Tree.from_grid(values, n_leaves=100).n_leaves <= 100


def run(*args):
    return CliRunner().invoke(main, [str(a) for a in args])


def test_command_line_reduces_and_says_what_was_lost(data, tmp_path):
    source, target = data / "pyradiance/blindsT3.xml", tmp_path / "small.xml"
    result = run("reduce", source, "-o", target)
    assert result.exit_code == 0 and "transmission_front" in result.stdout
    assert target.stat().st_size < source.stat().st_size / 2
    assert "l1 2 %, total 1 %" in bsdftree.load(target).provenance[-1]
    report = json.loads(run("reduce", "--json", "--rms", "5", source, "-o", tmp_path / "small.bsdft").stdout)
    assert all(part["rms"] <= 0.05 for part in report["components"])
    assert run("reduce", "--size", "100k", source, "-o", target).exit_code == 0
    assert target.stat().st_size <= 100_000
    assert run("reduce", "--size", "10k", "--leaves", "5", source, "-o", target).exit_code == 2
    assert "expected a size" in run("reduce", "--size", "big", source, "-o", target).output
    assert "no tensor tree" in run("reduce", data / "pyradiance/clear.xml", "-o", target).output
