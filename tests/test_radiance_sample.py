"""Samples fall where those of Radiance's library fall: two-sample χ² over 256 cells of the sphere, significance 1e-4.

Radiance stratifies its samples, which makes its counts steadier than χ² supposes: the test errs to the safe side. It
has ten times as many, so that this hardly matters: they are nearly the expected counts.
"""

from __future__ import annotations

import numpy as np
import pytest
from directions import hemisphere, histogram, two_sample_chi_squared
from radiance import PARTS, Library, needs_radiance

import bsdftree

pytestmark = needs_radiance

N = 20_000
SIGNIFICANCE = 1e-4
# Away from the borders of Klems patches.
INCIDENT = bsdftree.direction_from_polar([18.0, 48.0, 77.0], [31.0, 205.0, 100.0])
FRONT_AND_BACK = np.concatenate([INCIDENT, INCIDENT * [1, 1, -1]])


@pytest.fixture(scope="module")
def rank_4(tmp_path_factory):
    """A rank-4 tree with one transmission only, so that light from outside asks it in reverse."""
    path = tmp_path_factory.mktemp("sample") / "blinds.xml"
    bsdftree.generate("blinds:angle=30", rank=4, log2_res=4, samples=400, sides="front", seed=3).save(path)
    return path


def drawn(path, incident, rng, part="all") -> tuple[np.ndarray, np.ndarray]:
    """Our samples and Radiance's, each (m, N, 3) for m incident directions."""
    theirs = Library(path).answers(sample=(incident, 10 * N, PARTS[part]))["samples"]
    u = rng.random((len(incident) * N, 2))
    ours = bsdftree.load(path).sample(np.repeat(incident, N, axis=0), u, part=part)
    assert (ours.pdf > 0).all()
    return ours.exitant.reshape(len(incident), N, 3), theirs


def compare(path, incident, rng, part="all"):
    for ours, theirs in zip(*drawn(path, incident, rng, part), strict=True):
        chi_squared, freedom, p = two_sample_chi_squared(histogram(ours), histogram(theirs))
        print(f"chi-squared {chi_squared:.0f} for {freedom} degrees of freedom, p {p:.2g}")
        assert p > SIGNIFICANCE


def test_the_comparison_tells_a_twentieth_of_the_light_apart(data, rng):
    ours, theirs = drawn(data / "pyradiance/blindsT3.xml", INCIDENT, rng)
    for a, b in zip(ours, theirs, strict=True):
        a[: N // 20] = hemisphere(rng, N // 20, 1)
        assert two_sample_chi_squared(histogram(a), histogram(b))[2] < SIGNIFICANCE


@pytest.mark.parametrize("name", ["pyradiance/blindsT3.xml", "pyradiance/blinds.xml", "frads/blinds30.xml"])
def test_samples_of_real_files_agree_from_both_sides(data, rng, name):
    """The last one has one transmission: a matrix, reversed."""
    compare(data / name, FRONT_AND_BACK, rng)


def test_samples_of_rank_3_agree(data, rng):
    compare(data / "pyradiance/t3.xml", INCIDENT, rng)


def test_samples_of_rank_4_agree_reversed_too(rank_4, rng):
    compare(rank_4, FRONT_AND_BACK, rng)


@pytest.mark.parametrize("part", ["reflection", "transmission"])
def test_samples_of_parts_agree(data, rng, part):
    compare(data / "pyradiance/blindsT3.xml", FRONT_AND_BACK, rng, part)


def test_reversed_rank_3_samples_follow_radiances_values(data, rng):
    """Radiance cannot sample these; our samples × its values is constant: value = weight × pdf / cos."""
    path = data / "pyradiance/t3.xml"
    b = bsdftree.load(path)
    incident = np.repeat(INCIDENT * [1, 1, -1], 2000, axis=0)
    assert (Library(path).answers(sample=(INCIDENT * [1, 1, -1], 10, PARTS["all"]))["samples"] == 0).all()
    ours = b.sample(incident, rng.random(len(incident)))
    assert (ours.pdf > 0).all()
    theirs = Library(path).answers(pairs=(incident, ours.exitant))["xyz"][:, 1]
    ratio = theirs * abs(ours.exitant[:, 2]) / (ours.pdf * ours.weight)
    # A sample at the border of a cell may lie in its neighbour for Radiance.
    assert (abs(ratio - 1) < 5e-4).mean() > 0.998
