"""Whether two engines say the same of a device: z-tests patch by patch, of groups of patches, and of totals.

In: fractions of light in independent batches (Radiance) and runs (ours). Out: a `Verdict`.

Each number is a mean over batches with a standard error of its own, by their scatter. A difference over its standard
error is Student's t with Welch's degrees of freedom; `z` is the normal deviate of the same probability. Single patches
are tested, or neighbours of a ring together until they hold `LEAST_RAYS` rays, since with fewer a mean and its scatter
are not independent. Beside them the light of each incident patch and of each exitant patch is tested, and the mean z²
of all patches, which sees faults too small to show in one. All tests of a device together have the significance
`SIGNIFICANCE` (Bonferroni): `p` is the least of their probabilities times their number.

Totals are means over the incident patches, for both sides of incidence and exitance; they may differ by `TOTAL` at
most, absolute, however well the tests are passed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from .patches import Array

SIGNIFICANCE = 1e-4
TOTAL = 0.005
LEAST_RAYS = 100
ROUNDING = 2e-5
"""Radiance carries coefficients and results as 32-bit floats, and takes what is rougher than 1e-4 for equal."""
XYZ_FROM_RGB = np.array(
    [[0.5141446, 0.3238845, 0.1619709], [0.2651058, 0.6701058, 0.0647884], [0.0241005, 0.1228527, 0.8530467]]
)
"""Of Radiance's primaries and its white."""


@dataclass(frozen=True)
class Verdict:
    """What came out.

    `z` of all patches (or groups of them) that are not the same in all batches; `p` of the device; `worst` says which
    test gave it. Totals are (side of incidence, side of exitance), Radiance's and ours, of luminance.
    """

    z: Array
    n_tests: int
    p: float
    worst: str
    radiance: Array
    ours: Array
    efficiency: float
    """Variance of patches, Radiance's over ours (median), at the numbers of rays that there were."""

    @property
    def largest_difference(self) -> float:
        """Of totals, absolute."""
        return float(np.abs(self.radiance - self.ours).max())

    @property
    def agrees(self) -> bool:
        return self.p > SIGNIFICANCE and self.largest_difference <= TOTAL


def luminance_or_xyz(rgb: Array, colour: bool) -> Array:
    """Of Radiance's colours (…, 3): X, Y, Z, or Y alone (…, 1)."""
    values: Array = rgb @ (XYZ_FROM_RGB if colour else XYZ_FROM_RGB[1:2]).T
    return values


def variances(*x: Array) -> list[Array]:
    """Of means over batches, on the first axis."""
    return [y.var(axis=0, ddof=1) / len(y) for y in x]


def z_scores(a: Array, b: Array) -> Array:
    """Normal deviates of differences of means over batches, on the first axis."""
    n_a, n_b = len(a), len(b)
    var_a, var_b = variances(a, b)
    variance = var_a + var_b
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = variance**2 / (var_a**2 / (n_a - 1) + var_b**2 / (n_b - 1))
        freedom = np.where(np.isfinite(freedom), freedom, n_a + n_b - 2)
    t = (a.mean(axis=0) - b.mean(axis=0)) / np.sqrt(variance + ROUNDING**2)
    return normal_deviate(t, freedom)


def normal_deviate(t: Array, freedom: Array) -> Array:
    """Of Student's t, the normal deviate of the same probability (D. L. Wallace, Ann. Math. Stat. 30, 1959)."""
    scale = (8 * freedom + 1) / (8 * freedom + 3)
    deviate: Array = np.sign(t) * scale * np.sqrt(freedom * np.log1p(t**2 / freedom))
    return deviate


def compare(radiance: Array, ours: Array, rays_per_patch: int) -> Verdict:
    """Compare; both (side of incidence, incident patch, batch, side of exitance, exitant patch, channel)."""
    # Batches first.
    a, b = (np.moveaxis(x, 2, 0) for x in (radiance, ours))
    y = 1 if radiance.shape[-1] == 3 else 0
    starts = group_starts((a.mean(axis=0) + b.mean(axis=0))[..., y] / 2 * rays_per_patch)
    grouped = [together(x, starts) for x in (a, b)]
    var_a, var_b = variances(*grouped)
    z, noisy = z_scores(*grouped), var_a + var_b > ROUNDING**2
    tests = {
        "patches": z.ravel(),
        "incident patches": z_scores(a.sum(axis=4), b.sum(axis=4)).ravel(),
        "exitant patches": z_scores(a.mean(axis=2), b.mean(axis=2)).ravel(),
        "totals": z_scores(a.sum(axis=4).mean(axis=2), b.sum(axis=4).mean(axis=2)).ravel(),
    }
    n_tests = sum(group.size for group in tests.values()) + 1
    least = {name: two_sided(float(np.abs(group).max())) for name, group in tests.items() if group.size}
    if noisy.any():
        excess = (z[noisy] ** 2).mean() - 1
        least["mean z²"] = NormalDist().cdf(-excess * math.sqrt(noisy.sum() / 2))
    worst = min(least, key=lambda name: least[name])
    totals = [x[..., y].sum(axis=4).mean(axis=(0, 2)) for x in (a, b)]
    both = (var_a > ROUNDING**2) & (var_b > ROUNDING**2)
    efficiency = float(np.median((var_a / np.where(both, var_b, 1))[both])) if both.any() else math.nan
    return Verdict(z[noisy], n_tests, min(1.0, least[worst] * n_tests), worst, totals[0], totals[1], efficiency)


def group_starts(rays: Array) -> list[NDArray[np.intp]]:
    """Where groups of neighbouring patches begin, for each row of expected rays (…, patch); all have enough."""
    starts = []
    for row in rays.reshape(-1, rays.shape[-1]):
        groups, held = [0], 0.0
        for k, n in enumerate(row):
            if held >= LEAST_RAYS:
                groups.append(k)
                held = 0.0
            held += float(n)
        if held < LEAST_RAYS and len(groups) > 1:
            groups.pop()
        starts.append(np.array(groups, np.intp))
    return starts


def together(x: Array, starts: list[NDArray[np.intp]]) -> Array:
    """Sums over groups of patches; (batch, …, patch, channel) to (batch, group, channel)."""
    rows = x.reshape(len(x), -1, *x.shape[-2:])
    return np.concatenate([np.add.reduceat(rows[:, k], groups, axis=1) for k, groups in enumerate(starts)], axis=1)


def two_sided(z: float) -> float:
    """Probability of a normal deviate this far from 0."""
    return math.erfc(z / math.sqrt(2))
