"""Values, totals and resolution of real files are those of Radiance's library.

Radiance scales values by up to ±0.03 % by their place (FORMAT: library behaviour), so 0.05 % is agreement.
"""

from __future__ import annotations

import numpy as np
import pytest
from directions import SIDES, hemisphere
from parity import (
    answering,
    as_radiance_has_it,
    assert_evaluates_alike,
    is_dropped,
    pairs,
    sampled_in_reverse_by_us_only,
)
from radiance import REAL_FILES, TRUNCATED_FILES, Library, needs_radiance, refuses

import bsdftree
from bsdftree import Bsdf, Tree

pytestmark = needs_radiance


@pytest.mark.parametrize("name", REAL_FILES)
def test_values_agree(data, rng, name):
    assert_evaluates_alike(bsdftree.load(data / name), data / name, rng)


@pytest.mark.parametrize("name", REAL_FILES)
def test_totals_agree(data, rng, name):
    b = bsdftree.load(data / name)
    incident = np.concatenate([hemisphere(rng, 40, 1), hemisphere(rng, 40, -1)])
    # Normal and grazing incidence are totals of ordinary cells too, off their borders.
    x = np.array([1e-4, 0.99999])
    edge = np.stack([x, x / 7, np.sqrt(1 - x**2)], axis=1) / np.sqrt(1 + (x / 7) ** 2)[:, None]
    incident = np.concatenate([incident, edge, edge * [1, 1, -1]])
    theirs = Library(data / name).answers(incident=incident)
    for part in ("reflection", "transmission", "all"):
        ours = b.hemispherical(incident, part)
        assert not np.signbit(ours).any()
        compared = np.ones(len(incident), bool)
        if part != "reflection":
            # Radiance does not sample rank-3 trees in reverse: see test_rank_3_in_reverse.
            compared = ~sampled_in_reverse_by_us_only(b, incident)
        error = abs(ours - theirs[part])[compared]
        print(f"{name}: largest error of {part} {error.max(initial=0.0):.1e}")
        np.testing.assert_allclose(theirs[part][compared], ours[compared], rtol=1e-3, atol=1e-7)


def test_rank_3_in_reverse_scatters_what_radiance_evaluates(data, rng):
    """Our totals of a reversed rank-3 tree are the integrals of Radiance's values, which it cannot sum itself."""
    b = bsdftree.load(data / "pyradiance/t3.xml")
    library = Library(data / "pyradiance/t3.xml")
    n, finer = 192, 12
    incident = hemisphere(rng, 4, -1)
    assert (library.answers(incident=incident)["transmission"] == 0.0).all(), (
        "Radiance sums reversed rank-3 trees now: compare with it in test_totals_agree"
    )
    for direction in incident:
        cells = np.stack(np.mgrid[:n, :n], axis=-1).reshape(-1, 2)
        values = values_in_disk(library, direction, (cells + 0.5) / n).reshape(n, n)
        # Cells that neighbours differ from are divided: a peak is smaller than they are.
        padded = np.pad(values, 1, mode="edge")
        around = np.stack([padded[i : i + n, j : j + n] for i in range(3) for j in range(3)])
        divided = (around.max(0) - around.min(0) > 0.05 * values.mean()).ravel()
        inside = np.repeat(cells[divided], finer**2, axis=0)
        places = (inside + rng.random(inside.shape)) / n
        values.reshape(-1)[divided] = values_in_disk(library, direction, places).reshape(-1, finer**2).mean(axis=1)
        print(f"relative error {np.pi * values.mean() / b.hemispherical(direction) - 1:.1e}")
        assert np.pi * values.mean() == pytest.approx(b.hemispherical(direction), rel=0.01)


def values_in_disk(library: Library, incident: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Radiance's values at exitant directions of the upper side: square of radius and turn, each in 0 to 1."""
    radius, azimuth = np.sqrt(places[:, 0]), 2 * np.pi * places[:, 1]
    exitant = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1 - radius**2)], axis=1)
    return library.answers(pairs=(np.broadcast_to(incident, exitant.shape), exitant))["xyz"][:, 1]


@pytest.mark.parametrize("name", REAL_FILES)
def test_projected_solid_angles_agree(data, rng, name):
    """Radiance gives the smaller and the larger of the incident and the exitant cell; for trees they are one."""
    b = bsdftree.load(data / name)
    keys = [(sides, key) for sides in SIDES if (key := answering(b, sides)) is not None and not is_dropped(b, key)]
    if not keys:
        pytest.skip("no component that is more than Lambertian")
    drawn = [pairs(b, rng, sides) for sides, _ in keys]
    question = tuple(np.concatenate(part) for part in zip(*drawn, strict=True))
    theirs = Library(data / name).answers(resolution=question)["solid_angle"]
    ours = b.projected_solid_angle(*question)
    assert np.isclose(theirs, ours[:, None], rtol=1e-4).any(axis=1).all()
    is_tree = np.repeat([isinstance(b.components[key], Tree) for _, key in keys], [len(d[0]) for d in drawn])
    np.testing.assert_allclose(theirs[is_tree, 0], ours[is_tree], rtol=1e-6)


@pytest.mark.parametrize("rank", [3, 4])
@pytest.mark.parametrize(
    ("base", "extra", "what_stays"),
    [
        (0.1, 0.0009, "lambertian"),
        (0.1, 0.0011, "all"),
        (0.0, 0.0009, "nothing"),
        (0.0, 0.0011, "all"),
    ],
)
def test_radiance_drops_what_scatters_under_a_thousandth(tmp_path, rng, rank, base, extra, what_stays):
    """A component whose largest total beside its Lambertian part is at most 0.001 is only its Lambertian part there."""
    grid = np.full((4,) * rank, base)
    # One incident cell, all exitant cells of one half: a total of `extra` beside the base.
    grid[(1,) * (rank - 2)][:2] += 2 * extra / np.pi
    path = tmp_path / "small.xml"
    Bsdf.from_trees({"reflection_back": Tree.from_grid(grid)}).save(path)
    b = bsdftree.load(path)
    incident, exitant = pairs(b, rng, (1, 1))
    theirs = Library(path).answers(pairs=(incident, exitant))["xyz"][:, 1]
    expected = {"lambertian": np.full(len(theirs), base), "nothing": np.zeros(len(theirs))}
    np.testing.assert_allclose(theirs, expected.get(what_stays, b.eval(incident, exitant)), rtol=5e-4, atol=1e-9)
    np.testing.assert_allclose(as_radiance_has_it(b, incident, exitant, (1, 1)), theirs, rtol=5e-4, atol=1e-9)


@pytest.mark.parametrize("name", TRUNCATED_FILES)
def test_truncated_files_are_refused_by_both(data, name):
    assert refuses(data / name)
    with pytest.raises(ValueError, match="found 4 values"):
        bsdftree.load(data / name)


def test_all_real_files_are_compared(data):
    found = {str(p.relative_to(data)) for p in data.glob("*/*") if p.suffix.lower() == ".xml"}
    assert found == {*REAL_FILES, *TRUNCATED_FILES}
