"""What trees of standard errors say of the trees that they belong to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bsdftree._bsdf import Bsdf
from bsdftree._component import Array, Tree

UNCERTAIN = 0.25
"""Leaves whose relative standard error is over this count as uncertain."""


class ErrorByFlux(NamedTuple):
    """How well a component is known, weighted by the light that is scattered if it comes evenly from everywhere."""

    mean: float
    """Mean relative standard error: Σ error / Σ value."""
    uncertain: float
    """Share of the light in leaves whose relative standard error is over 25 %."""


def errors_by_flux(bsdf: Bsdf, errors: Bsdf, band: str = "Visible") -> dict[str, ErrorByFlux]:
    """How well each component is known.

    Parameters
    ----------
    bsdf
        Trees.
    errors
        The same trees with a standard error in place of each leaf's value, as ``bsdftree fit --errors`` writes them.
    band
        Spectral band.

    Raises
    ------
    ValueError
        If the errors are not of these trees.
    """
    return {key: _error(key, tree, errors.components_of(band).get(key)) for key, tree in _trees(bsdf, band).items()}


def _trees(bsdf: Bsdf, band: str) -> dict[str, Tree]:
    components = bsdf.components_of(band)
    trees = {key: component for key, component in components.items() if isinstance(component, Tree)}
    if len(trees) < len(components):
        raise ValueError("standard errors are of trees; this BSDF has matrices")
    return trees


def _error(key: str, tree: Tree, errors: object) -> ErrorByFlux:
    if not isinstance(errors, Tree):
        raise ValueError(f"the errors have no tree of {key}; expected those of this BSDF, of the same run")
    cells, levels, values = tree.leaves()
    other_cells, other_levels, sigma = errors.leaves()
    if not (np.array_equal(cells, other_cells) and np.array_equal(levels, other_levels)):
        raise ValueError(
            f"the errors of {key} have {len(sigma)} leaves in other cells than the {len(values)} of the tree; "
            "expected the errors of this BSDF, of the same run"
        )
    weights = _weights(tree.rank, cells, levels)
    flux, error = weights * values, weights * sigma
    total = float(flux.sum())
    if total <= 0:
        return ErrorByFlux(0.0, 0.0)
    return ErrorByFlux(float(error.sum()) / total, float(flux[sigma > UNCERTAIN * values].sum()) / total)


def _weights(rank: int, cells: NDArray[np.uint32], levels: NDArray[np.uint32]) -> Array:
    """Projected solid angle of each leaf's incident times that of its exitant cell, as shares of the hemispheres'."""
    edge: Array = np.ldexp(1.0, -levels.astype(np.int32))
    if rank == 4:
        return np.asarray(edge**4)
    # The incident axis is 1 - sin θ, twice as wide; its upper half stands for nothing.
    sine = [np.maximum(1 - 2 * (cells[:, 0] + end) * edge, 0) for end in (0, 1)]
    return np.asarray((sine[0] ** 2 - sine[1] ** 2) * edge**2)
