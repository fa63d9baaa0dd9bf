"""Patches of the Klems full basis, and rays that start in them.

In: numbers of patches. Out: rays of light towards the device. Invariant: patches are numbered as in CONVENTIONS.md, by
the direction in which light *travels*, projected to the device's plane; so light that goes straight through, or is
mirrored, leaves through the patch that it came through.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RINGS = (
    (0, 5, 1),
    (5, 15, 8),
    (15, 25, 16),
    (25, 35, 20),
    (35, 45, 24),
    (45, 55, 24),
    (55, 65, 24),
    (65, 75, 16),
    (75, 90, 12),
)
"""Polar angles [degree], and number of patches from the normal outwards."""
N_PATCHES = sum(n for _, _, n in RINGS)
INCIDENT = (0, 3, 12, 21, 30, 42, 55, 74, 80, 103, 121, 138)
"""Patches that light comes through: one or two of each ring, towards all four quarters."""


def bounds() -> Array:
    """sin² of the polar angles and the azimuths [radian] of all patches: (patch, (lower, upper, from, to))."""
    rows = []
    for lower, upper, n in RINGS:
        inner, outer = (np.sin(np.radians(theta)) ** 2 for theta in (lower, upper))
        step = 2 * np.pi / n
        rows += [(inner, outer, (k - 0.5) * step, (k + 0.5) * step) for k in range(n)]
    return np.array(rows)


def projected_solid_angles() -> Array:
    """Of all patches [sr]."""
    inner, outer, start, end = bounds().T
    areas: Array = (outer - inner) * (end - start) / 2
    return areas


def evenly(rng: np.random.Generator, n: int, dimensions: int) -> Array:
    """n points in the unit cube of which each coordinate is stratified: (n, dimensions)."""
    columns = [(rng.permutation(n) + rng.random(n)) / n for _ in range(dimensions)]
    return np.stack(columns, axis=1)


def direction(patch: int | NDArray[np.intp], points: Array) -> Array:
    """Upward unit vectors in patches, even in projected solid angle.

    Parameters
    ----------
    points
        Numbers in [0, 1), (2, n).

    Returns
    -------
    (n, 3)
    """
    inner, outer, start, end = bounds()[patch].T
    sine2 = inner + (outer - inner) * points[0]
    azimuth = start + (end - start) * points[1]
    sine = np.sqrt(sine2)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - sine2)], axis=1)


def rays(patch: int, side: int, box: Array, clearance: float, points: Array) -> Array:
    """Rays through a patch, spread over the aperture.

    Origins lie on the plane that touches the device's box on the side that light comes from (1 the front, +Z; -1 the
    back) at a clearance [unit of box]; directions are spread evenly in projected solid angle.

    Parameters
    ----------
    points
        Numbers in [0, 1), (n, 4).

    Returns
    -------
    (n, 6): origin, direction of travel.
    """
    (x0, y0, z0), (x1, y1, z1) = box
    z = z1 + clearance if side > 0 else z0 - clearance
    x, y = x0 + (x1 - x0) * points[:, 2], y0 + (y1 - y0) * points[:, 3]
    origin = np.stack([x, y, np.full(len(points), z)], axis=1)
    return np.hstack([origin, direction(patch, points[:, :2].T) * [1, 1, -side]])
