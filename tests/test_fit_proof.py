"""Fits of synthetic goniophotometer runs over known BRDFs and BTDFs, and that their judge is to be trusted."""

from __future__ import annotations

import numpy as np
import pytest
from benches.fit import contender, gonio, judge, report, truths
from benches.fit.contender import Contender
from radiance import needs_radiance

import bsdftree

CLOSED = [m for m in truths.materials() if m.family in ("microfacet", "mixed", "anisotropic", "sharp")]


@pytest.fixture(autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BSDFTREE_BENCH_CACHE", str(tmp_path_factory.getbasetemp() / "fit"))


def directions(rng: np.random.Generator, n: int, side: float) -> np.ndarray:
    """Uniform in projected solid angle."""
    radius, phi = np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), side * np.sqrt(1 - radius**2)], axis=1)


@pytest.mark.parametrize("material", CLOSED, ids=lambda m: m.name)
def test_known_bsdfs_keep_energy(material, rng):
    for theta in (0, 40, 75, 85):
        incident = np.tile(bsdftree.direction_from_polar(theta, 30), (20_000, 1))
        exitant = directions(rng, 20_000, -1.0 if material.transmission else 1.0)
        values = material(incident, exitant)
        assert np.all(values >= 0)
        assert np.pi * values.mean() < 1.02


@pytest.mark.parametrize("material", [m for m in CLOSED if not m.transmission], ids=lambda m: m.name)
def test_known_reflection_is_reciprocal(material, rng):
    incident, exitant = directions(rng, 2000, 1.0), directions(rng, 2000, 1.0)
    np.testing.assert_allclose(material(incident, exitant), material(exitant, incident), rtol=1e-9)


@pytest.mark.parametrize("family", ["bagher_sgd", "low_cooktorrance_E2", "low_lowmicrofacet_E2", "ngan_ward"])
def test_published_fits_are_reciprocal(family, data, rng):
    name = next(name for name, fits in truths.MERL if fits == family)
    material = truths.find([name])[0]
    incident, exitant = directions(rng, 2000, 1.0), directions(rng, 2000, 1.0)
    np.testing.assert_allclose(material(incident, exitant), material(exitant, incident), rtol=1e-9)


def test_runs_are_the_same_every_time_and_as_noisy_as_they_say():
    material = truths.find(["mixed-iso"])[0]
    scans = gonio.measure(material)
    again = gonio.measure(material)
    assert all(np.array_equal(a.values, b.values) for a, b in zip(scans, again, strict=True))
    assert [len(scan.values) for scan in scans] == [gonio.POINTS] * len(gonio.IN_PLANE)
    for scan in scans:
        true = material(np.tile(scan.incident, (len(scan.values), 1)), scan.exitant)
        assert 0.9 * gonio.NOISE < np.std(scan.values / true - 1) < 1.1 * gonio.NOISE
        assert scan.exitant_deg[:, 0].max() <= gonio.HIGHEST + 1e-3


@pytest.mark.parametrize("name", ["mixed-iso", "sharp-iso"])
def test_files_of_a_run_are_read_as_what_was_written(name, tmp_path):
    scans = gonio.measure(truths.find([name])[0], points=300)
    read = bsdftree.Measurement.load(gonio.write(scans, tmp_path, name))
    assert read.name == name
    assert len(read.scans) == len(scans)
    for ours, theirs in zip(scans, read.scans, strict=True):
        np.testing.assert_allclose(theirs.incident, ours.incident, atol=1e-6)
        np.testing.assert_allclose(theirs.exitant, ours.exitant, atol=1e-6)
        np.testing.assert_array_equal(theirs.values, ours.values)


def test_judge_finds_what_was_done_to_the_truth():
    material = truths.find(["ggx-iso"])[0]
    court = judge.court(material, 4)
    true = judge.in_cells(court, Contender("truth", material))
    assert true.l1[court.inside].max() < 0.02
    worse = Contender("worse", lambda i, o: 1.1 * material(i, o), lambda i, o: 0.06 * material(i, o))
    for verdict in (judge.in_cells(court, worse), judge.point_by_point(court, worse)):
        np.testing.assert_allclose(verdict.l1, 0.1, atol=0.02)
        np.testing.assert_allclose(verdict.total, 0.1, atol=0.02)
    assert judge.point_by_point(court, worse).covered.min() == 1.0
    braver = Contender("braver", worse.evaluate, lambda i, o: 0.04 * material(i, o))
    assert judge.point_by_point(court, braver).covered.max() == 0.0


def test_judge_does_not_charge_a_tree_for_its_cells():
    material = truths.find(["ggx-iso"])[0]
    made = bsdftree.Bsdf.from_function(material, rank=3, log2_res=5, tolerance=0.0, components=("reflection_back",))
    court = judge.court(material, 5)
    verdict = judge.in_cells(court, contender.of_tree("tree", made, 5, 0.0))
    assert verdict.l1[court.inside].max() < 0.01


def test_left_out_directions_were_not_measured():
    for name in ("ggx", "ggx-iso"):
        court = judge.court(truths.find([name])[0], 5)
        measured = np.array([bsdftree.direction_from_polar(*a) for a in gonio.incident_angles(court.cells.rank)])
        if court.cells.rank == 3:
            measured[:, 0] *= -1
        assert np.degrees(np.arccos(np.max(court.middle[court.inside] @ measured.T))) >= 2
        assert court.inside.any()
        assert not court.inside.all()


def fit_of(name: str, points: int, **options: str) -> tuple[judge.Court, contender.Contender]:
    material = truths.find([name])[0]
    model = contender.model(gonio.measure(material, points=points), **options)[0]
    return judge.court(material, 5 if material.rank == 4 else 6), model


@pytest.mark.parametrize("name", ["ggx-iso", "mixed-iso", "ward-iso", "sharp-iso", "sharp"])
def test_left_out_directions_are_predicted(name):
    court, model = fit_of(name, 1500)
    verdict = judge.point_by_point(court, model)
    target, counts = court.material.target, court.counts
    assert verdict.l1[counts].mean() <= target.error
    assert verdict.total[counts].mean() <= target.hemispherical
    assert verdict.covered[counts].mean() >= report.COVERED


@pytest.mark.parametrize("name", [name for name, _ in truths.MERL])
def test_published_fits_are_predicted(name, data):
    court, model = fit_of(name, 1500)
    verdict = judge.point_by_point(court, model)
    assert verdict.l1[court.counts].mean() <= court.material.target.error
    assert verdict.total[court.counts].mean() <= court.material.target.hemispherical
    assert verdict.covered[court.counts].mean() >= report.COVERED


def test_trees_are_means_over_cells_at_a_sharp_edge():
    material = truths.find(["sharp-iso"])[0]
    court = judge.court(material, 5)
    verdict = judge.in_cells(court, contender.tree(gonio.measure(material, points=1500), 3, 5))
    assert verdict.l1[court.counts].mean() <= material.target.error
    assert verdict.total[court.counts].mean() <= material.target.hemispherical


@needs_radiance
def test_error_is_a_quarter_of_pabopto2bsdfs(tmp_path):
    material = truths.find(["mixed-iso"])[0]
    scans = gonio.measure(material)
    court = judge.court(material, 6)
    theirs = contender.radiance(gonio.write(scans, tmp_path / "scans", material.name), 6, tmp_path)
    case = report.Case(court, judge.in_cells(court, contender.tree(scans, 3, 6)), judge.in_cells(court, theirs))
    assert case.misses() == []
