"""Devices of many kinds scatter light as Radiance has it: the small sister of `make devices-report`.

Significance and tolerance are those of `benches.devices.comparison`, for each device. Our seeds are fixed; Radiance's
random numbers are its own.
"""

from __future__ import annotations

import numpy as np
import pytest
from benches.devices import real, scenes
from benches.devices.comparison import compare
from benches.devices.run import measure
from radiance import needs_radiance

pytestmark = needs_radiance

SAMPLES = 4096
DEVICES = (
    "brightfunc.rad",
    "colorfunc.rad",
    "cones-cups.rad",
    "dielectric-spheres.rad",
    "double-glazing.rad",
    "fabric-weave.rad",
    "materials.mgf",
    "metal-spheres.rad",
    "mirror-slats.rad",
    "mirror-tubes.rad",
    "mixtext.rad",
    "rough-plastic.rad",
    "specpict.rad",
    "trans-rings.rad",
)
OWN = {scene.name: scene for scene in scenes.own()}


@pytest.mark.parametrize("name", DEVICES)
def test_device_scatters_as_in_radiance(name):
    measured = measure(OWN[name], SAMPLES)
    v = measured.verdict
    print(f"{name}: {v.n_tests} tests, p {v.p:.2g} ({v.worst}); totals {v.radiance.ravel()} {v.ours.ravel()}")
    assert v.agrees


def test_every_feature_is_in_some_device():
    features = {feature for scene in [*OWN.values(), *real.real()] for feature in scene.features}
    assert len(OWN) >= 40
    assert PRIMITIVES | MATERIALS | MODIFIERS <= features, (PRIMITIVES | MATERIALS | MODIFIERS) - features


PRIMITIVES = set("polygon sphere bubble cylinder tube cone cup ring mesh instance".split())
MATERIALS = set(
    "plastic metal trans plastic2 metal2 trans2 glass dielectric interface mirror ashik2 prism1 prism2 antimatter BSDF "
    "aBSDF plasfunc metfunc transfunc BRTDfunc plasdata metdata transdata WGMDfunc".split()
)
MODIFIERS = set(
    "brightfunc brightdata brighttext colorfunc colordata colorpict colortext texfunc texdata mixfunc mixdata mixpict "
    "mixtext spectrum specfile specfunc specdata specpict".split()
)


def test_comparison_finds_small_faults_and_passes_equals(rng):
    """Counts of equal probabilities agree; a hundredth more light in one direction of reflection does not."""
    n = 32768
    probabilities = rng.dirichlet(np.full(290, 0.5), (2, 12))

    def counts(p: np.ndarray, batches: int) -> np.ndarray:
        drawn = rng.multinomial(n // batches, p, (batches, 2, 12)) / (n // batches)
        return np.moveaxis(drawn, 0, 2).reshape(2, 12, batches, 2, 145, 1)

    theirs, equal = counts(probabilities, 32), counts(probabilities, 8)
    assert compare(theirs, equal, n).agrees
    faulty = probabilities.copy()
    moved = 0.01 * faulty[..., :145].sum(axis=-1)
    faulty[..., :145] *= 0.99
    faulty[..., 200] += moved
    verdict = compare(theirs, counts(faulty, 8), n)
    assert not verdict.agrees and verdict.p < 1e-9
