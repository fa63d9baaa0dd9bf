"""How a component is divided: its cells by size, and what light is in them.

Enters a tree or a matrix, leave groups of cells: leaves by depth, patches by ring. Shares are of projected solid angle
of incident times that of exitant directions; the half of the incident axis of rank 3 that is never used has none.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bsdftree._component import Array, Matrix, Tree


class Cells(NamedTuple):
    """Cells of a component and how they are grouped.

    Attributes
    ----------
    kind
        ``"depth"`` or ``"exitant ring"``.
    labels
        Of the groups.
    group
        Number of the group of each cell, (n,).
    share
        Part of all pairs of directions that each cell holds, (n,); they sum to 1.
    values
        [1/sr], (n,).
    """

    kind: str
    labels: list[str]
    group: NDArray[np.int64]
    share: Array
    values: Array

    @property
    def counts(self) -> Array:
        """Number of cells of each group."""
        return np.bincount(self.group, minlength=len(self.labels)).astype(float)

    @property
    def shares(self) -> Array:
        """Part of all pairs of directions in each group."""
        return np.bincount(self.group, self.share, len(self.labels)).astype(float)

    @property
    def light(self) -> Array:
        """Part of the scattered light in each group; zeros if there is none."""
        flux = np.bincount(self.group, self.share * self.values, len(self.labels)).astype(float)
        return flux / (float(flux.sum()) or 1.0)


def cells_of(component: Tree | Matrix) -> Cells:
    """Collect the cells of a component."""
    return _leaves(component) if isinstance(component, Tree) else _patches(component)


def _leaves(tree: Tree) -> Cells:
    corners, levels, values = tree.leaves()
    edge = np.ldexp(1.0, -levels.astype(np.int32))
    if tree.rank == 4:
        share = edge**4
    else:
        # d0 is 1/2 at the normal and 0 at grazing: the sine is 1 - 2 d0, the projected solid angle goes as its square.
        sine = [np.clip(1.0 - 2.0 * (corners[:, 0] + k) * edge, 0.0, 1.0) for k in (0.0, 1.0)]
        share = (sine[0] ** 2 - sine[1] ** 2) * edge**2
    labels = [f"2^{depth}" for depth in range(tree.depth + 1)]
    return Cells("depth", labels, levels.astype(np.int64), share, values.astype(float))


def _patches(matrix: Matrix) -> Cells:
    incident, exitant = matrix.projected_solid_angles()
    share = np.outer(incident / incident.sum(), exitant / exitant.sum())
    rings = np.repeat(np.arange(len(matrix.exitant_rings)), [n for _, _, n in matrix.exitant_rings])
    labels = [f"{lower:g}–{upper:g}°" for lower, upper, _ in matrix.exitant_rings]
    group = np.broadcast_to(rings, share.shape).ravel()
    return Cells("exitant ring", labels, group, share.ravel(), matrix.values.astype(float).ravel())
