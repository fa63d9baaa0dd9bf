"""Generated BSDFs are those of genBSDF's method, within its noise, on the same device files.

How they are compared is in `alike.py`. Radiance's random numbers differ in each run.
"""

from __future__ import annotations

from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest
import radiance
from alike import OURS, SIGNIFICANCE, assert_alike, both_sides, fractions, patch_solid_angles, z_scores
from radiance import needs_radiance

import bsdftree
from bsdftree import Bsdf, Device

pytestmark = needs_radiance

BLINDS = "blinds:angle=30,height=0.4,width=0.4"
PANE = """
void {material} 0 0 3 {value} {value} {value}
it polygon pane 0 0 12  0 0 -0.001  1 0 -0.001  1 1 -0.001  0 1 -0.001
"""


@pytest.fixture
def device(tmp_path):
    """A function from a spec or a scene text to a scene file."""

    def write(scene: str) -> Path:
        path = tmp_path / "device.rad"
        path.write_text(scene if "polygon" in scene else Device.from_spec(scene).to_rad())
        return path

    return write


@pytest.mark.parametrize("spec", ["sawtooth", BLINDS])
def test_klems_matrices_are_alike(device, tmp_path, spec):
    samples = 200
    path = device(spec)
    theirs = bsdftree.load(radiance.generate(path, tmp_path / "theirs.xml", samples=samples), strict=False)
    ours = bsdftree.generate(path, klems="quarter", samples=OURS, seed=5)
    assert_alike(theirs, ours, samples)


@pytest.mark.parametrize("spec", ["sawtooth", BLINDS])
def test_rank_4_trees_are_alike(device, tmp_path, spec):
    samples = 200
    path = device(spec)
    file = radiance.generate(path, tmp_path / "theirs.xml", rank=4, log2_res=3, samples=samples)
    ours = bsdftree.generate(path, rank=4, log2_res=3, samples=OURS, prune=False, seed=6)
    assert_alike(bsdftree.load(file, strict=False), ours, samples, 3)


@pytest.mark.parametrize(("rank", "log2_res"), [(3, 4), (4, 3)])
@pytest.mark.parametrize(("material", "value"), [("mirror it", 0.9), ("glass it", 0.8)])
def test_panes_are_alike(device, tmp_path, material, value, rank, log2_res):
    samples = 400
    path = device(PANE.format(material=material, value=value))
    file = radiance.generate(path, tmp_path / "theirs.xml", rank=rank, log2_res=log2_res, samples=samples)
    theirs = bsdftree.load(file, strict=False)
    ours = bsdftree.generate(path, rank=rank, log2_res=log2_res, samples=OURS, prune=False, seed=7)
    if rank == 3:
        # Peaks lie on the border of two exitant cells, which share them as it happens: rounding in ours, the parity of
        # the incident cell in Radiance's.
        theirs, ours = (Bsdf.from_trees({k: both_sides(t) for k, t in b.components.items()}) for b in (theirs, ours))
    assert_alike(theirs, ours, samples, log2_res)


@pytest.fixture(scope="module")
def glazed_blinds(data) -> Bsdf:
    return bsdftree.generate(data / "pyradiance/blinds.rad", klems="full", samples=4000, seed=8)


def test_published_klems_matrix_of_real_blinds_is_ours(data, glazed_blinds):
    """`genBSDF -c 10000 -ad 20000` ran for hours on this device: totals of all 145 incident patches."""
    published = bsdftree.load(data / "pyradiance/blinds.xml")
    for key, component in glazed_blinds.components.items():
        theirs, ours = (fractions(c, 0).sum(axis=1) for c in (published.components[key], component))
        weights = patch_solid_angles(component.incident_rings) / np.pi
        assert abs(weights @ (theirs - ours)) < 0.002
        z = z_scores(theirs, 10_000, ours, 4000)
        print(f"{key}: total {weights @ theirs:.4f} {weights @ (theirs - ours):+.4f}, |z| at most {abs(z).max():.2f}")
        assert abs(z).max() < NormalDist().inv_cdf(1 - SIGNIFICANCE / 2 / z.size)
        assert (z**2).mean() < 1 + 5 * np.sqrt(2 / z.size)


def test_published_rank_3_tree_of_real_blinds_is_ours_where_it_was_sampled(data, glazed_blinds):
    """genBSDF takes rank 3 in the plane of X and Z only, and culls by 90 %: totals there, away from grazing."""
    published = bsdftree.load(data / "pyradiance/blindsT3.xml")
    theta = np.radians([5.0, 15.0, 25.0, 35.0, 45.0, 55.0])
    incident = np.stack([-np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    for side in (1, -1):
        for part in ("reflection", "transmission"):
            theirs, ours = (b.hemispherical(incident * [1, 1, side], part) for b in (published, glazed_blinds))
            np.testing.assert_allclose(theirs, ours, atol=0.03)
            assert abs(theirs - ours).mean() < 0.01


def test_differences_are_no_larger_than_radiances_own_noise(device, tmp_path):
    """Squared differences to the mean of two of its runs are, over all cells, those of the runs to each other.

    This sees faults far under the bound of a count, of which diffuse light has a small part.
    """
    path = device(BLINDS)
    files = [radiance.generate(path, tmp_path / f"{n}.xml", samples=n) for n in (150, 170)]
    a, b = (bsdftree.load(file, strict=False) for file in files)
    ours = bsdftree.generate(path, klems="quarter", samples=10 * OURS, seed=9)
    for key, component in ours.components.items():
        x, y, o = (fractions(c, 0) for c in (a.components[key], b.components[key], component))
        # Over the expected count, so that all cells weigh alike.
        lit = o > 1e-3
        noise, difference = ((x - y) ** 2 / 4 / o)[lit], (((x + y) / 2 - o) ** 2 / o)[lit]
        n_effective = noise.sum() ** 2 / (noise**2).sum()
        # The logarithm of the ratio of two means of n squares has variance 4/n.
        ratio, limit = difference.sum() / noise.sum(), np.exp(5 * np.sqrt(4 / n_effective))
        print(f"{key}: {ratio:.2f} (limit {limit:.2f}, {n_effective:.0f} of {lit.sum()} cells)")
        assert 1 / limit < ratio < limit


def test_our_own_noise_is_within_the_bound(device):
    """Two independent halves of ours differ as the bound of a count allows, and not much less where it is one."""
    path = device(BLINDS)
    a, b = (bsdftree.generate(path, klems="quarter", samples=1000, seed=seed) for seed in (1, 2))
    for key in a.components:
        z = z_scores(fractions(a.components[key], 0), 1000, fractions(b.components[key], 0), 1000)
        print(f"{key}: mean z² of {z.size} cells {(z**2).mean():.2f}")
        assert 0.05 < (z**2).mean() < 1 + 5 * np.sqrt(2 / z.size)
