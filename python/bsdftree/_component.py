"""What a BSDF is made of: trees and matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree import _core
from bsdftree._reduce import Loss, Norm, as_grid, culled, loss_between, refuse_beside_cull, tree_of_grid

COMPONENTS = ("reflection_front", "reflection_back", "transmission_front", "transmission_back")
"""All components; front is the outside here, as in WINDOW."""

Array = NDArray[np.float64]


class Tree:
    """A tensor tree: one BSDF component, subdivided where it changes.

    Attributes
    ----------
    rank : int
        3 (isotropic: incident polar angle, exitant direction) or 4.
    depth : int
        Deepest subdivision: 2^depth cells per axis.
    n_leaves : int
        Number of values.
    nbytes : int
        Memory of the tree [byte].
    repairs : list of str
        What :meth:`from_grid` replaced.
    """

    def __init__(self, core: _core.Tree, repairs: list[str] | None = None) -> None:
        self._core = core
        self.repairs: list[str] = repairs or []
        self.rank = core.rank
        self.depth = core.depth
        self.n_leaves = core.n_leaves
        self.nbytes = core.nbytes

    @classmethod
    def from_grid(
        cls,
        values: ArrayLike,
        *,
        tolerance: float | None = None,
        rms: float | None = None,
        total: float | None = None,
        n_leaves: int | None = None,
        norm: Norm = "l1",
        cull_percent: float | None = None,
        variance: ArrayLike | None = None,
        counts: ArrayLike | None = None,
        balance: float | None = None,
        strict: bool = True,
    ) -> Tree:
        """Build a tree from a uniform grid; equal neighbours become one leaf.

        A grid of 32-bit numbers may be a file: ``np.load(path, mmap_mode="r")`` or ``np.memmap(path, np.float32)``,
        reshaped. Reducing it takes an eighth of its memory beside it, and what remains.

        Parameters
        ----------
        values
            BSDF [1/sr], shape (2^N,) * rank with rank 3 or 4. Axes as in the file format: rank 4 is incident x, y and
            exitant x, y of the Shirley-Chiu square; rank 3 is incident polar angle and exitant x, y.
        tolerance
            Relative L1 error that joining neighbours may make, as ``l1`` of :meth:`reduce`.
        rms, total, n_leaves, norm, cull_percent, balance
            As of :meth:`reduce`.
        variance
            Square of the standard error of each value [1/sr²], or of all. A branch is then kept only where its children
            differ by more than noise explains, and only where the bounds ask for it, which are then on what reduction
            adds to that. A constant with noise becomes one leaf in 99 % of cases at least. Leaves are plain means.
        counts
            Number of samples of about equal weight (paths, photons) that made each value, instead of its variance.
        strict
            Whether to refuse values that are negative, not finite or over 1e12. Otherwise negative ones become 0,
            others the mean of the good ones in the smallest block of cells of a tree that has such, and ``repairs``
            says so.

        Raises
        ------
        ValueError
            If the shape is not that, a value is bad, or the tree cannot be so small.

        Examples
        --------
        >>> Tree.from_grid(np.full((4, 4, 4, 4), 0.2)).n_leaves
        1
        >>> counts = np.random.default_rng(0).poisson(3.0, (8, 8, 8, 8))
        >>> Tree.from_grid(0.1 * counts).n_leaves, Tree.from_grid(0.1 * counts, counts=counts).n_leaves
        (4096, 1)
        """
        goal = (tolerance, rms, total, n_leaves, norm, cull_percent)
        tree, _, repairs = tree_of_grid(values, strict, *goal, variance, counts, balance)
        return cls(tree, repairs)

    def reduce(
        self,
        *,
        l1: float | None = None,
        rms: float | None = None,
        total: float | None = None,
        n_leaves: int | None = None,
        norm: Norm = "l1",
        cull_percent: float | None = None,
        balance: float | None = None,
    ) -> Tree:
        """Return a smaller tree, branches of which became leaves of their mean.

        Bounds hold together. Of all trees made that way with as few leaves, none has a smaller error in the norm that
        is bounded, or is ``norm``; a bound on totals takes back what it must.

        Parameters
        ----------
        l1
            Most of ∫|f - g| / ∫f.
        rms
            Most of √∫(f - g)² / √∫f².
        total
            Most of |H_f - H_g| / max(H_f, 0.1) for any incident direction, H being directional-hemispherical totals.
        n_leaves
            Most leaves.
        norm
            What is made least where only ``n_leaves`` or ``total`` is given: ``"l1"`` or ``"rms"``.
        cull_percent
            Radiance's percentage, by itself, for comparison: what its ``rttree_reduce`` makes of the values, with
            pyradiance (the extra ``radiance``). No bound is kept by it.
        balance
            To what leaves of one node bring the errors of totals (those of ``total``) by giving light to each other, as
            far as they can. The light over every node then stays what it was, but a leaf is not the mean of what it
            was; bounds are kept. With ``n_leaves``, branches are chosen for it too, at some cost in the chosen norm:
            totals come several times nearer.

        Raises
        ------
        ValueError
            If nothing is given, or the bounds need more than ``n_leaves``; if pyradiance is needed and not there.

        Examples
        --------
        >>> x = (np.arange(16) + 0.5) / 16
        >>> tree = Tree.from_grid(np.exp(-8 * (x[:, None, None] - x[:, None]) ** 2 - x))
        >>> small = tree.reduce(l1=0.05, total=0.01)
        >>> tree.n_leaves > 2 * small.n_leaves, tree.loss_of(small).l1 <= 0.05, tree.loss_of(small).worst_total <= 0.01
        (True, True, True)
        """
        if cull_percent is not None:
            refuse_beside_cull(l1, rms, total, n_leaves, balance)
            return Tree(culled(self._core, cull_percent))
        goal = _core.Goal(l1=l1, rms=rms, total=total, n_leaves=n_leaves, norm=norm, balance=balance)
        return Tree(_core.reduced(self._core, goal))

    def loss_of(self, reduced: Tree) -> Loss:
        """How far a tree is from this one, of which it has nowhere smaller leaves."""
        return loss_between(self._core, reduced._core)

    @classmethod
    def from_raw(cls, values: bytes | ArrayLike, rank: int = 4, *, strict: bool = True) -> Tree:
        """Build a tree from what rttree_reduce reads: all values of a uniform grid, one after the other.

        Parameters
        ----------
        values
            Bytes of 32-bit floats (``-ff``), or numbers, such as ``np.loadtxt(path)`` of a text file (``-fa``). The
            last axis varies fastest.
        rank
            3 or 4.
        strict
            As of :meth:`from_grid`.

        Raises
        ------
        ValueError
            If there are not (2^N)^rank of them, or one is bad.

        Examples
        --------
        >>> Tree.from_raw(np.full(256, 0.2, np.float32).tobytes()).n_leaves
        1
        """
        array = np.frombuffer(values, np.float32) if isinstance(values, bytes) else np.asarray(values)
        return cls.from_grid(as_grid(array, rank), strict=strict)

    def to_grid(self, log2_res: int | None = None) -> NDArray[np.float32]:
        """Values on a uniform grid.

        Parameters
        ----------
        log2_res
            2^log2_res cells per axis; the tree's own depth by default. Coarser cells are means.

        Returns
        -------
        ndarray
            Shape (2^log2_res,) * rank [1/sr].

        Raises
        ------
        ValueError
            If the grid would have over 2^31 values.
        """
        log2_res = self.depth if log2_res is None else log2_res
        if not 0 <= log2_res * self.rank <= 31:
            raise ValueError(f"a grid of 2^{log2_res} cells along {self.rank} axes; expected at most 2^31 in all")
        return self._core._to_grid(log2_res).reshape((1 << log2_res,) * self.rank)

    def leaves(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32], NDArray[np.float32]]:
        """All leaves.

        Returns
        -------
        cells : ndarray
            Lower corners in units of each leaf's own edge, (n_leaves, rank).
        levels : ndarray
            Edge is 2^-level, (n_leaves,).
        values : ndarray
            [1/sr], (n_leaves,).
        """
        return self._core.leaves()

    def __repr__(self) -> str:
        return repr(self._core)


class Matrix:
    """A Klems matrix: one BSDF component over fixed patches.

    Attributes
    ----------
    values : ndarray
        [1/sr], (incident patches, exitant patches). WINDOW's text has the transpose.
    incident_basis, exitant_basis : str
        Names of the angle bases.
    incident_rings, exitant_rings : list of (lower, upper, n)
        Polar angles [degree] and number of patches of each ring, from the normal outwards.
    nbytes : int
        Memory of the values [byte].
    """

    def __init__(self, core: _core.Matrix) -> None:
        self._core = core
        self.values = core.values
        self.incident_basis = core.incident_basis
        self.exitant_basis = core.exitant_basis
        self.incident_rings = core.incident_rings
        self.exitant_rings = core.exitant_rings
        self.nbytes = core.nbytes

    @classmethod
    def from_values(
        cls, values: ArrayLike, basis: str | list[tuple[float, float, int]] = "full", *, subdivide: int = 1
    ) -> Matrix:
        """Make a matrix of an array.

        Parameters
        ----------
        values
            [1/sr], (incident patches, exitant patches).
        basis, subdivide
            As in :meth:`Bsdf.to_klems`.

        Raises
        ------
        ValueError
            If the shape is not that of the basis, or a value is negative or not finite.
        """
        return cls(_core.matrix(np.asarray(values, np.float32), basis, subdivide))

    def projected_solid_angles(self) -> tuple[Array, Array]:
        """Projected solid angles [sr] of the incident and the exitant patches."""
        incident, exitant = _core.patch_areas(self._core)
        return incident, exitant

    def weighted(self) -> Array:
        """What dctimestep multiplies by: value times projected solid angle of the incident patch.

        Returns
        -------
        ndarray
            (exitant patches, incident patches): radiance out for radiance in. ``write_radiance_matrix`` writes it.
        """
        return np.asarray(self.values.T * self.projected_solid_angles()[0], np.float64)

    def __repr__(self) -> str:
        return repr(self._core)


def wrapped(core: _core.Tree | _core.Matrix) -> Tree | Matrix:
    return Tree(core) if isinstance(core, _core.Tree) else Matrix(core)
