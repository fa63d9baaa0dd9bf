"""Smaller trees with an error that the caller chooses, and how far they are from what they were."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from bsdftree import _core
from bsdftree._directions import direction_from_square, polar_from_direction

Norm = Literal["l1", "rms"]
# Bounds on errors between which that of a number of leaves or bytes is sought, and how exactly it is found.
_FINEST, _COARSEST, _PRECISION = 1e-9, 1.0, 1e-3


class Loss(NamedTuple):
    """How far a reduced tree is from what it was.

    Attributes
    ----------
    l1
        ∫|f - g| / ∫f.
    rms
        √∫(f - g)² / √∫f².
    mean_total
        Mean over incident directions of |H_f - H_g| / max(H_f, 0.1), H being directional-hemispherical totals.
    worst_total
        Largest of those.
    worst_theta_deg, worst_phi_deg
        Incident direction that has it, θ from the normal [degree]; φ is NaN for an isotropic tree.
    """

    l1: float
    rms: float
    mean_total: float
    worst_total: float
    worst_theta_deg: float
    worst_phi_deg: float


class Reduction(NamedTuple):
    """One component before and after.

    Attributes
    ----------
    band, component
        Which one.
    before, after
        Number of leaves of the luminance.
    loss
        What was lost.
    """

    band: str
    component: str
    before: int
    after: int
    loss: Loss


def loss_between(whole: _core.Tree, reduced: _core.Tree) -> Loss:
    """Return the loss of a tree with branches cut off."""
    l1, rms, mean, worst, (x, y) = _core.loss(whole, reduced)
    if whole.rank == 3:
        theta, phi = float(np.degrees(np.arcsin(max(1.0 - 2.0 * x, 0.0)))), np.nan
    else:
        # The incident square is that of the direction that light travels in.
        theta, phi = polar_from_direction(direction_from_square(x, y) * [-1.0, -1.0, 1.0])
    return Loss(l1, rms, mean, worst, float(theta), float(phi))


def losses(whole: _core.Bsdf, reduced: _core.Bsdf) -> list[Reduction]:
    """Return what all trees of a BSDF lost."""
    found = []
    for band in whole.bands:
        parts = reduced.components(band)
        for name, functions in whole.components(band).items():
            before, after = functions[0], parts[name][0]
            if isinstance(before, _core.Tree) and isinstance(after, _core.Tree):
                found.append(Reduction(band, name, before.n_leaves, after.n_leaves, loss_between(before, after)))
    return found


def trees_of(bsdf: _core.Bsdf) -> list[_core.Tree]:
    """Return the luminance trees of all components."""
    functions = [f[0] for band in bsdf.bands for f in bsdf.components(band).values()]
    return [f for f in functions if isinstance(f, _core.Tree)]


def reduced(
    bsdf: _core.Bsdf,
    l1: float | None,
    rms: float | None,
    total: float | None,
    n_leaves: int | None,
    n_bytes: int | None,
    norm: Norm,
) -> _core.Bsdf:
    """Return a BSDF with smaller trees: to bounds, or with the least bound at which it is as small as is wanted."""
    if sum([n_leaves is not None, n_bytes is not None, l1 is not None or rms is not None]) > 1:
        raise ValueError("n_leaves, n_bytes, and bounds on L1 or RMS exclude each other; give one of them")
    if not trees_of(bsdf):
        raise ValueError("there is no tensor tree to reduce; convert matrices by to_tree() first")

    def at(bound: float) -> _core.Bsdf:
        of_l1, of_rms = (bound, None) if norm == "l1" else (None, bound)
        return _core.reduced_bsdf(bsdf, of_l1, of_rms, total, norm)

    if n_leaves is not None:
        return _smallest_error(at, lambda b: sum(tree.n_leaves for tree in trees_of(b)), n_leaves, "leaves")
    if n_bytes is not None:
        return _smallest_error(at, lambda b: len(b.to_xml().encode()), n_bytes, "bytes")
    return _core.reduced_bsdf(bsdf, l1, rms, total, norm)


def _smallest_error(
    reduce: Callable[[float], _core.Bsdf], size: Callable[[_core.Bsdf], int], most: int, what: str
) -> _core.Bsdf:
    """Return the BSDF of the least bound at which a size is at most so much."""
    fine, coarse = _FINEST, _COARSEST
    best = reduce(coarse)
    if size(best) > most:
        raise ValueError(f"{size(best):,} {what} are the least there can be; {most:,} were asked for")
    if size(finest := reduce(fine)) <= most:
        return finest
    while coarse / fine > 1.0 + _PRECISION:
        middle = float(np.sqrt(fine * coarse))
        found = reduce(middle)
        if size(found) <= most:
            coarse, best = middle, found
        else:
            fine = middle
    return best
