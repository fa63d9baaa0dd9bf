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
    with pytest.raises(ValueError, match="leaves are the least"):
        b.reduce(n_leaves=1, total=0.001)


@pytest.mark.parametrize(("file", "n_bytes"), [("xml", 60_000), ("bsdft", 60_000), ("packed", 1800)])
def test_files_are_as_large_as_is_wanted(data, tmp_path, file, n_bytes):
    b = bsdftree.load(data / "pyradiance/t3.xml")
    small, path = b.reduce(n_bytes=n_bytes, file=file), tmp_path / ("b.xml" if file == "xml" else "b.bsdft")
    small.save(path, packed=file == "packed")
    assert 0.9 * n_bytes < path.stat().st_size <= n_bytes
    with pytest.raises(ValueError, match="bytes are the least"):
        b.reduce(n_bytes=10, file=file)
    with pytest.raises(ValueError, match='expected "xml", "bsdft" or "packed"'):
        b.reduce(n_bytes=n_bytes, file="zip")


def test_what_is_small_enough_stays_as_it_is(data):
    b = bsdftree.load(data / "pyradiance/t3.xml")
    whole = b.reduce(n_bytes=10**9)
    assert all(loss.l1 <= 1e-9 for *_, loss in b.losses_of(whole))


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


@needs_radiance
def test_culled_trees_are_what_radiances_reducer_makes(data, rng):
    values = (rng.random((8, 8, 8, 8)) ** 4).astype(np.float32)
    whole, culled = Tree.from_grid(values), Tree.from_grid(values, cull_percent=80)
    theirs = Tree(radiance_reduced(values.reshape(-1), 4, 3, 80, average=False))
    assert culled.n_leaves == theirs.n_leaves < whole.n_leaves
    for a, b in zip(culled.leaves(), whole.reduce(cull_percent=80).leaves(), strict=True):
        np.testing.assert_array_equal(a, b)
    b = bsdftree.load(data / "pyradiance/blindsT3.xml")
    losses = b.losses_of(b.reduce(cull_percent=99))
    assert sum(loss.after for loss in losses) < sum(loss.before for loss in losses) / 2
    assert [loss.component for loss in losses] == list(b.components)


@needs_radiance
def test_colour_is_culled_too():
    b = bsdftree.generate("sawtooth", log2_res=3, samples=500, color=True)
    culled = b.reduce(cull_percent=95)
    for name, before in b._core.components("Visible").items():
        after = culled._core.components("Visible")[name]
        assert len(before) == len(after) == 3
        assert all(a.n_leaves <= c.n_leaves for a, c in zip(after, before, strict=True))


def test_a_cull_percentage_is_by_itself_and_in_its_range(monkeypatch):
    tree = Tree.from_grid(np.arange(8.0).reshape(2, 2, 2))
    for reduce in (tree.reduce, Bsdf.from_trees({"reflection_back": tree}).reduce):
        with pytest.raises(ValueError, match="expected one of them"):
            reduce(cull_percent=90, l1=0.1)
        with pytest.raises(ValueError, match="0 <= cull_percent < 100"):
            reduce(cull_percent=100)
    with pytest.raises(ValueError, match="expected one of them"):
        Tree.from_grid(np.ones((2, 2, 2)), cull_percent=90, tolerance=0.1)
    monkeypatch.setattr("bsdftree._radiance.programs.find_folder", lambda: None)
    with pytest.raises(ValueError, match=r"pip install 'bsdftree\[radiance\]'"):
        tree.reduce(cull_percent=90)


@needs_radiance
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1.0, 1e30, 1e39])
def test_bad_values_never_reach_radiances_reducer(bad):
    values = np.random.default_rng(1).random((8, 8, 8, 8))
    values[1, 2, 3, 4] = bad
    with pytest.raises(ValueError, match=r"1 of 4096 values .* at index \[1, 2, 3, 4\]"):
        Tree.from_grid(values, cull_percent=90)
    assert Tree.from_grid(values, cull_percent=90, strict=False).repairs


def test_bad_values_are_refused_or_replaced_and_told():
    values = np.random.default_rng(2).random((8, 8, 8)).astype(np.float32)
    good = values.copy()
    values[0, 1, 2], values[2, 7, 7], values[3, 4, 4] = np.nan, -0.5, np.inf
    with pytest.raises(ValueError, match=r"3 of 512 values .*1 not a number, 1 infinite.*, 1 negative.*first is NaN"):
        Tree.from_grid(values)
    for how in ({}, {"tolerance": 0.0}):
        tree = Tree.from_grid(values, strict=False, **how)
        (repair,) = tree.repairs
        assert "3 of 512" in repair and "taken as 0" in repair
        mended = tree.to_grid(3)
        # The half of the incident directions that is read.
        changed = np.argwhere((mended != good)[:4]).tolist()
        assert changed == [[0, 1, 2], [2, 7, 7], [3, 4, 4]]
        assert mended[2, 7, 7] == 0
        block = good[:2, :2, 2:4].astype(float)
        assert mended[0, 1, 2] == pytest.approx((block.sum() - good[0, 1, 2]) / 7)
    assert Tree.from_grid(good, strict=False).repairs == []
    with pytest.raises(ValueError, match="512 of 512 values"):
        Tree.from_grid(np.full((8, 8, 8), np.nan), strict=False)
    assert Tree.from_raw(values.tobytes(), 3, strict=False).repairs


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


def grid_file(folder, kind, values):
    path = folder / f"grid.{kind}"
    if kind == "npy":
        np.save(path, values)
    elif kind == "fortran.npy":
        np.save(path, np.asfortranarray(values))
    elif kind == "f32":
        values.astype("<f4").tofile(path)
    elif kind == "f64":
        values.astype("<f8").tofile(path)
    else:
        path.write_text(" ".join(map(str, values.reshape(-1))))
    return path


@pytest.mark.parametrize("kind", ["npy", "fortran.npy", "f32", "f64", "txt"])
@pytest.mark.parametrize("rank", [3, 4])
def test_command_line_reduces_grids(tmp_path, kind, rank, rng):
    values = (rng.random((8,) * rank) ** 6).astype(np.float32)
    source, target = grid_file(tmp_path, kind, values), tmp_path / "small.bsdft"
    raw = ["--raw", "ascii"] if kind == "txt" else []
    options = [*raw, "--rank", rank, "--component", "reflection_back", source, "-o", target]
    report = json.loads(run("reduce", "--json", "--l1", "10", "--total", "2", *options).stdout)
    small = bsdftree.load(target).components["reflection_back"]
    loss = Tree.from_grid(values).loss_of(small)
    (part,) = report["components"]
    assert part["l1"] == pytest.approx(loss.l1, rel=1e-9) and part["leaves"] == [8**rank, small.n_leaves]
    assert loss.l1 <= 0.1 and loss.worst_total <= 0.02 and small.n_leaves < 8**rank
    assert run("reduce", "--size", "2k", *options).exit_code == 0
    assert target.stat().st_size <= 2000
    assert run("convert", *raw, "--rank", rank, source, tmp_path / "whole.xml").exit_code == 0


def test_command_line_says_what_is_wrong_with_grids(tmp_path):
    values = np.ones((4, 4, 4, 4), np.float32)
    values[0, 0, 1, 0] = np.nan
    source, target = grid_file(tmp_path, "npy", values), tmp_path / "small.xml"
    result = run("reduce", source, "-o", target)
    assert result.exit_code == 1 and "NaN at index [0, 0, 1, 0]" in result.output and "--repair takes" in result.output
    result = run("reduce", "--repair", source, "-o", target)
    assert result.exit_code == 0 and "1 of 256 values" in result.stderr
    assert bsdftree.load(target).components["transmission_front"].n_leaves == 1
    assert "give --rank 4" in run("reduce", "--rank", "3", source, "-o", target).output
    np.save(source, np.array(["a"]))
    assert "expected an array of real numbers" in run("reduce", source, "-o", target).output
    np.save(source, np.array([{}]), allow_pickle=True)
    assert run("reduce", source, "-o", target).exit_code == 1
    source.write_bytes(b"\x93NUMPY\x01")
    assert run("reduce", source, "-o", target).exit_code == 1
    (tmp_path / "g.f32").write_bytes(b"1234567")
    assert "expected a multiple of 4" in run("reduce", tmp_path / "g.f32", "-o", target).output


@needs_radiance
def test_command_line_culls(data, tmp_path):
    source, target = data / "pyradiance/blindsT3.xml", tmp_path / "culled.xml"
    assert run("reduce", "--cull-percent", "90", source, "-o", target).exit_code == 0
    assert "culled by 90 % by rttree_reduce" in bsdftree.load(target).provenance[-1]
    assert run("reduce", "--cull-percent", "90", "--total", "1", source, "-o", target).exit_code == 2


def constants(kind, rng, shape=(8, 8, 8, 8)):
    """Nothing but noise around a constant, and what is known of it."""
    if kind == "normal":
        return np.maximum(1 + 0.2 * rng.standard_normal(shape), 0), {"variance": 0.04}
    if kind == "uneven":
        deviation = np.minimum(0.1 * np.exp(0.8 * rng.standard_normal(shape)), 0.25)
        return np.maximum(1 + deviation * rng.standard_normal(shape), 0), {"variance": deviation**2}
    counts = rng.poisson(float(kind), shape)
    return 0.1 * counts, {"counts": counts}


@pytest.mark.parametrize("kind", ["normal", "uneven", "0.01", "0.1", "1", "10"])
@pytest.mark.parametrize("rank", [3, 4])
def test_a_constant_with_noise_is_one_leaf(kind, rank):
    # In 1 % of cases at most it is more. That 6 of 100 are has a probability of 5e-4 then.
    rng = np.random.default_rng(7)
    grids = (constants(kind, rng, (16, 16, 16) if rank == 3 else (8, 8, 8, 8)) for _ in range(100))
    assert sum(Tree.from_grid(values, **known).n_leaves > 1 for values, known in grids) < 6


def ridge_and_slope(n):
    x = (np.arange(n) + 0.5) / n
    ridge = np.exp(-200 * ((x[:, None, None, None] - x[:, None]) ** 2 + (x[:, None, None] - x) ** 2))
    return (0.1 + 2 * ridge + 0.2 * x[:, None, None, None] * x[:, None]).astype(np.float32)


@needs_radiance
@pytest.mark.parametrize("per_count", [0.003, 0.03, 0.3])
@pytest.mark.parametrize("has_counts", [False, True])
def test_noise_is_taken_off_and_the_function_stays(per_count, has_counts):
    truth = ridge_and_slope(16)
    counts = np.random.default_rng(3).poisson(truth / per_count)
    noisy = (per_count * counts).astype(np.float32)
    known = {"counts": counts} if has_counts else {"variance": truth * per_count}

    def errors(tree):
        wrong = tree.to_grid(4) - truth.astype(float)
        return np.array([abs(wrong).mean(), (wrong**2).mean() ** 0.5])

    ours = Tree.from_grid(noisy, **known)
    assert (errors(ours) < 0.8 * errors(Tree.from_grid(noisy))).all()
    # Of Radiance's percentages the largest that leaves as many leaves.
    low, high = 0.0, 100.0
    while high - low > 0.01:
        middle = (low + high) / 2
        theirs = Tree(radiance_reduced(noisy.reshape(-1), 4, 4, middle, average=False))
        low, high = (middle, high) if theirs.n_leaves >= ours.n_leaves else (low, middle)
    theirs = Tree(radiance_reduced(noisy.reshape(-1), 4, 4, low, average=False))
    assert theirs.n_leaves >= ours.n_leaves
    assert errors(ours)[0] < errors(theirs)[0]


def test_leaves_of_noisy_grids_are_means_and_bounds_come_after():
    truth = ridge_and_slope(8)
    rng = np.random.default_rng(4)
    noisy = np.maximum(truth + 0.05 * rng.standard_normal(truth.shape), 0).astype(np.float32)
    whole, smaller = Tree.from_grid(noisy, variance=0.05**2), Tree.from_grid(noisy, variance=0.05**2, tolerance=0.05)
    assert 1 < smaller.n_leaves < whole.n_leaves < 8**4
    assert whole.loss_of(smaller).l1 <= 0.05
    for tree in (whole, smaller):
        for cell, level, value in zip(*tree.leaves(), strict=True):
            n = 8 >> level
            block = noisy[tuple(slice(c * n, (c + 1) * n) for c in cell)]
            assert value == pytest.approx(block.mean(dtype=float), rel=1e-6)
    exact = Tree.from_grid(truth, variance=0.0)
    np.testing.assert_array_equal(exact.to_grid(3), truth)


def test_bad_noise_is_refused():
    values = np.ones((4, 4, 4), np.float32)
    for known, message in (
        ({"variance": -1.0}, "-1 among the variances at index 0"),
        ({"counts": np.full((4, 4, 4), np.nan)}, "NaN among the counts"),
        ({"counts": np.ones((4, 4))[:3]}, r"counts of shape \(3, 4\)"),
        ({"counts": 1, "variance": 1}, "expected one of them"),
        ({"counts": 1, "cull_percent": 90}, "expected one of them"),
    ):
        with pytest.raises(ValueError, match=message):
            Tree.from_grid(values, **known)


def test_command_line_takes_counts(tmp_path):
    counts = np.random.default_rng(6).poisson(2.0, (8, 8, 8, 8))
    source, target = grid_file(tmp_path, "npy", 0.1 * counts), tmp_path / "small.xml"
    np.save(tmp_path / "counts.npy", counts)
    assert run("reduce", "--counts", tmp_path / "counts.npy", source, "-o", target).exit_code == 0
    assert bsdftree.load(target).components["transmission_front"].n_leaves == 1
    assert run("reduce", "--counts", tmp_path / "counts.npy", target, "-o", target).exit_code == 2


@pytest.mark.parametrize("norm", ["l1", "rms"])
def test_balanced_totals_are_several_times_nearer_and_light_stays(norm):
    values = rough(4)
    whole = Tree.from_grid(values)
    plain = whole.reduce(n_leaves=8000, norm=norm)
    ours = Tree.from_grid(values, n_leaves=8000, norm=norm, balance=0.01)
    assert ours.n_leaves == plain.n_leaves
    # Other branches are kept for it: exchange between leaves of the cheapest tree brings it to 0.9 times what it was.
    assert whole.loss_of(ours).worst_total <= 0.25 * whole.loss_of(plain).worst_total
    # Leaves that gave light are no means, but all nodes have what they had.
    np.testing.assert_allclose(ours.to_grid(0), whole.to_grid(0), rtol=1e-6)


def rough(log2_res):
    """A lobe that is wider at grazing incidence, and a constant."""
    x = (np.arange(1 << log2_res) + 0.5) / (1 << log2_res)
    a, b, c, d = np.meshgrid(x, x, x, x, indexing="ij", sparse=True)
    width = 0.02 + 0.1 * ((a - 0.5) ** 2 + (b - 0.5) ** 2)
    return (0.05 + 0.02 / width * np.exp(-((a - c) ** 2 + (b - d) ** 2) / width)).astype(np.float32)
