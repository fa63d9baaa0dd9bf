"""Smaller trees with an error that the caller chooses, and how far they are from what they were."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree import _core
from bsdftree._directions import direction_from_square, polar_from_direction

Norm = Literal["l1", "rms"]
FileKind = Literal["xml", "bsdft", "packed"]
# Most values that Radiance's reducer is given: those of 2^7 cells per axis, of which it takes 6 GB.
_MOST_CULLED = 1 << 28


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
    return _loss(whole.rank, *_core.loss(whole, reduced))


def _loss(rank: int, l1: float, rms: float, mean: float, worst: float, at: tuple[float, float]) -> Loss:
    x, y = at
    if rank == 3:
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


def as_grid(values: NDArray[Any], rank: int) -> NDArray[Any]:
    """Return values one after the other as an array of as many axes."""
    n = round(values.size ** (1 / rank)) if rank in (3, 4) else 0
    if not n or n**rank != values.size:
        raise ValueError(f"{values.size} values; expected (2^N)^{rank}, with rank 3 or 4")
    return values.reshape((n,) * rank)


def tree_of_grid(
    values: ArrayLike,
    strict: bool = True,
    l1: float | None = None,
    rms: float | None = None,
    total: float | None = None,
    n_leaves: int | None = None,
    norm: Norm = "l1",
    cull_percent: float | None = None,
    variance: ArrayLike | None = None,
    counts: ArrayLike | None = None,
    balance: float | None = None,
) -> tuple[_core.Tree, Loss, list[str]]:
    """Return the tree of a grid, reduced if anything says how far; what was lost; and what was repaired."""
    if variance is not None and counts is not None:
        raise ValueError("variance and counts; expected one of them")
    noise = variance if variance is not None else counts
    # What is beyond the range is said to be infinite.
    with np.errstate(over="ignore"):
        array = np.asarray(values, np.float32)
    rank = array.ndim
    if rank not in (3, 4) or len(set(array.shape)) != 1:
        raise ValueError(f"a grid of shape {array.shape}; expected (2^N,) * 3 or (2^N,) * 4")
    flat = np.ascontiguousarray(array).reshape(-1)
    goal = _core.Goal(l1=l1, rms=rms, total=total, n_leaves=n_leaves, norm=norm, balance=balance)
    if noise is not None:
        if cull_percent is not None:
            raise ValueError("cull_percent and variance or counts; expected one of them")
        flat_noise = _beside(noise, array, "variance" if variance is not None else "counts")
        tree, loss, repaired = _core.tree_of_noisy_grid(flat, flat_noise, counts is not None, rank, strict, goal)
    elif cull_percent is None:
        tree, loss, repaired = _core.tree_of_grid(flat, rank, strict, goal)
    else:
        refuse_beside_cull(l1, rms, total, n_leaves, balance)
        whole, _, repaired = _core.tree_of_grid(flat, rank, strict, _core.Goal())
        tree = culled(whole, cull_percent)
        loss = _core.loss(whole, tree)
    return tree, _loss(rank, *loss), [repaired] if repaired else []


def _beside(numbers: ArrayLike, values: NDArray[np.float32], name: str) -> NDArray[np.float32]:
    """Return a number for each value, or the same for all."""
    try:
        with np.errstate(over="ignore"):
            array = np.broadcast_to(np.asarray(numbers, np.float32), values.shape)
    except ValueError:
        raise ValueError(f"{name} of shape {np.shape(numbers)}; expected one number, or {values.shape}") from None
    return np.ascontiguousarray(array).reshape(-1)


def refuse_beside_cull(*others: object) -> None:
    """Refuse a cull percentage that is not alone."""
    if any(other is not None for other in others):
        raise ValueError("cull_percent and a bound or size; expected one of them")


def culled(tree: _core.Tree, cull_percent: float) -> _core.Tree:
    """Return a tree as Radiance's ``rttree_reduce`` reduces it, from values on a grid as fine as the tree.

    Raises
    ------
    ValueError
        If pyradiance is not installed, the percentage is none, or the grid is too large.
    """
    from bsdftree._radiance.reduce import reduced as radiance_reduced

    if not 0 <= cull_percent < 100:
        raise ValueError(f"cull_percent = {cull_percent}; expected 0 <= cull_percent < 100")
    if 1 << tree.depth * tree.rank > _MOST_CULLED:
        raise ValueError(
            f"a tree of 2^{tree.depth} cells per axis is too fine for Radiance's reducer; bound an error instead"
        )
    if tree.depth == 0:
        return tree
    return radiance_reduced(_fit_to_cull(tree._to_grid(tree.depth)), tree.rank, tree.depth, cull_percent, average=False)


def _fit_to_cull(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return values that Radiance's reducer does not fail of, or refuse them."""
    if not (values.max() <= 1e12 and values.min() >= 0):
        raise ValueError(f"the largest value is {values.max():g}; Radiance's reducer is given none over 1e12")
    return values


def reduced(
    bsdf: _core.Bsdf,
    l1: float | None,
    rms: float | None,
    total: float | None,
    n_leaves: int | None,
    n_bytes: int | None,
    norm: Norm,
    file: FileKind,
    cull_percent: float | None,
    balance: float | None,
) -> _core.Bsdf:
    """Return a BSDF with smaller trees: to bounds, to about the least bound for a size, or culled."""
    if sum([n_leaves is not None, n_bytes is not None, l1 is not None or rms is not None]) > 1:
        raise ValueError("n_leaves, n_bytes, and bounds on L1 or RMS exclude each other; give one of them")
    trees = _core.all_trees(bsdf)
    if not trees:
        raise ValueError("there is no tensor tree to reduce; convert matrices by to_tree() first")
    if cull_percent is not None:
        refuse_beside_cull(l1, rms, total, n_leaves, n_bytes, balance)
        return _core.with_trees(bsdf, [culled(tree, cull_percent) for tree in trees])
    goal = _core.Goal(l1=l1, rms=rms, total=total, norm=norm, balance=balance)
    if n_leaves is not None:
        return _core.reduced_bsdf_to(bsdf, n_leaves, "leaves", goal)
    if n_bytes is not None:
        return _core.reduced_bsdf_to(bsdf, n_bytes, file, goal)
    return _core.reduced_bsdf(bsdf, goal)
