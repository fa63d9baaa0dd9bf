"""The patches of the full Klems basis, in which fits are compared as matrices: the interface of `Cells`.

Rings of polar angle, cut into patches of which the first is about azimuth 0 (J. Klems 1994, as WINDOW 7 has them). A
patch is named by its ring and its place in it, and so are incident ones; half a turn about the normal takes patches to
patches, so it does not matter which way incident azimuths are counted. Exitant patches differ in projected solid angle,
which `solid_angles` has. Rings are 10° wide: rank 3 has scans in the middle of each, so nothing can be left out, and
all rings that were measured count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cells import APART, INSIDE, OUTSIDE, Cells, within_range
from .formulas import Array
from .gonio import IN_PLANE

THETAS = np.array([0, 5, 15, 25, 35, 45, 55, 65, 75, 90])
"""Where rings begin and end [degree]."""
COUNTS = np.array([1, 8, 16, 20, 24, 24, 24, 16, 12])
"""Patches of each ring."""
PATCHES = np.array([(ring, k) for ring, count in enumerate(COUNTS) for k in range(count)])


@dataclass(frozen=True)
class Patches(Cells):
    """All 145 of them; `log2_res` is 0, for what is constant in each."""

    def incident(self, cells: Array, u: Array) -> Array:
        return _directions(cells, u)

    def exitant(self, v: Array) -> Array:
        return _directions(PATCHES, np.broadcast_to(v, PATCHES.shape)) * (1, 1, -1 if self.transmission else 1)

    @property
    def solid_angles(self) -> Array:
        """Projected, of exitant patches [sr]."""
        ring = PATCHES[:, 0]
        bounds = np.sin(np.radians(THETAS)) ** 2
        return np.asarray(np.pi * (bounds[ring + 1] - bounds[ring]) / COUNTS[ring])

    def _all(self) -> tuple[Array, Array]:
        if self.rank == 3:
            # The sample is isotropic: one patch of each ring will do.
            rings = np.stack([np.arange(len(COUNTS)), 0 * COUNTS], axis=1)
            return rings, THETAS[1:] <= IN_PLANE[-1]
        corners = [_directions(PATCHES, np.full(PATCHES.shape, corner)) for corner in np.ndindex(2, 2)]
        return PATCHES, np.all([within_range(corner) for corner in corners], axis=0)

    def left_out(self, seed: int = 11) -> tuple[Array, Array]:
        """Incident patches whose middle was not measured, and whether all of each lies inside the measured range."""
        patches, inside = self._all()
        middle = self.incident(patches, np.full(patches.shape, 0.5))
        measured = self._measured()
        far = (np.max(middle @ measured.T, axis=1) < APART[self.rank]) | (self.rank == 3)
        shuffled = np.random.default_rng(seed).permutation(len(patches))
        within, without = shuffled[(inside & far)[shuffled]], shuffled[~inside[shuffled]]
        chosen = np.concatenate([within[:INSIDE], without[:OUTSIDE]])
        return patches[chosen], inside[chosen]


def _directions(patches: Array, u: Array) -> Array:
    """Directions in patches, uniform in projected solid angle for uniform u (n, 2): (n, 3)."""
    ring, place = patches[:, 0], patches[:, 1]
    bounds = np.sin(np.radians(THETAS)) ** 2
    sine = np.sqrt(bounds[ring] + u[:, 0] * (bounds[ring + 1] - bounds[ring]))
    phi = 2 * np.pi * (place + u[:, 1] - 0.5) / COUNTS[ring]
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine**2)], axis=1)
