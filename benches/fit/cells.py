"""The cells of trees, in which fits are compared: incident cells that were not measured, and all exitant cells.

Coordinates are those of CONVENTIONS.md. Rank 4: an incident cell is a cell of the square of −incident.xy. Rank 3: an
interval of sin θ in the plane of incidence, incident direction in x < 0. Exitant cells are those of the square of
exitant.xy, all of equal projected solid angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bsdftree._directions import direction_from_square

from .formulas import Array
from .gonio import IN_PLANE, RINGS, incident_angles

APART = {3: np.cos(np.radians(2.0)), 4: np.cos(np.radians(3.0))}
"""Of the rank: a cell whose middle is closer to a measured direction counts as measured."""
INSIDE, OUTSIDE = 48, 12
"""How many left-out incident cells are judged, at most."""


@dataclass(frozen=True)
class Cells:
    rank: int
    log2_res: int
    transmission: bool

    @property
    def n(self) -> int:
        return 1 << self.log2_res

    def incident(self, cells: Array, u: Array) -> Array:
        """Directions in incident cells (n, 2) or, rank 3, (n, 1), at places u in [0, 1) within them."""
        place = (cells + u) / self.n
        if self.rank == 3:
            sine = 1 - 2 * place[:, 0]
            return np.column_stack([-sine, 0 * sine, np.sqrt(1 - sine**2)])
        toward = direction_from_square(place[:, 0], place[:, 1])
        return toward * (-1, -1, 1)

    def exitant(self, v: Array) -> Array:
        """One direction in each exitant cell, at the place v (2,) within all, or (n², 2) within each: (n², 3)."""
        cell = np.stack(np.divmod(np.arange(self.n**2), self.n), axis=1)
        place = (cell + v) / self.n
        return direction_from_square(place[:, 0], place[:, 1], -1.0 if self.transmission else 1.0)

    def left_out(self, seed: int = 11) -> tuple[Array, Array]:
        """Incident cells that were not measured, and whether all of each lies inside the measured range."""
        cells, inside = self._all()
        middle = self.incident(cells, np.full(cells.shape, 0.5))
        measured = self._measured()
        far = np.max(middle @ measured.T, axis=1) < APART[self.rank]
        shuffled = np.random.default_rng(seed).permutation(len(cells))
        within, without = shuffled[(inside & far)[shuffled]], shuffled[~inside[shuffled]]
        chosen = np.concatenate([within[:INSIDE], without[:OUTSIDE]])
        return cells[chosen], inside[chosen]

    def _measured(self) -> Array:
        angles = np.radians(incident_angles(self.rank))
        theta, phi = angles[:, 0], angles[:, 1] + (np.pi if self.rank == 3 else 0)
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)

    def _all(self) -> tuple[Array, Array]:
        if self.rank == 3:
            cells = np.arange(self.n // 2)[:, None]
            return cells, 1 - 2 * cells[:, 0] / self.n <= np.sin(np.radians(IN_PLANE[-1])) + 1e-9
        cells = np.stack(np.meshgrid(np.arange(self.n), np.arange(self.n), indexing="ij"), axis=-1).reshape(-1, 2)
        corners = [self.incident(cells, np.full(cells.shape, corner)) for corner in np.ndindex(2, 2)]
        return cells, np.all([within_range(corner) for corner in corners], axis=0)


def within_range(incident: Array) -> Array:
    """Whether directions lie in the spherical hull of the outermost ring of an anisotropic run, (n,)."""
    theta, n, first = RINGS[-1]
    phi = np.degrees(np.arctan2(incident[:, 1], incident[:, 0]))
    off = (phi - first) % (360 / n) - 180 / n
    edge = np.tan(np.radians(theta)) * np.cos(np.pi / n)
    slope = np.hypot(incident[:, 0], incident[:, 1]) / np.maximum(incident[:, 2], 1e-12)
    return np.asarray(slope * np.cos(np.radians(off)) <= edge)
