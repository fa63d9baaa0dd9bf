"""What a BSDF becomes: smooth, repaired, matrices, trees, those of the device in another position, a part of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from bsdftree import _core
from bsdftree._check import KINDS, Mended
from bsdftree._component import COMPONENTS
from bsdftree._header import Described
from bsdftree._reduce import FileKind, Norm, Reduction, losses, reduced

if TYPE_CHECKING:
    from typing_extensions import Self


class Conversions(Described):
    """Copies that are another BSDF; this one stays what it is."""

    def reduce(
        self,
        *,
        l1: float | None = None,
        rms: float | None = None,
        total: float | None = None,
        n_leaves: int | None = None,
        n_bytes: int | None = None,
        norm: Norm = "l1",
        file: FileKind = "xml",
        cull_percent: float | None = None,
        balance: float | None = None,
    ) -> Self:
        """Return a copy with smaller trees, as :meth:`Tree.reduce`.

        Bounds hold for each component of each band. Colour (u′, v′) is kept within 1 % on average. Matrices stay.

        Parameters
        ----------
        l1, rms, total, norm, balance
            As of :meth:`Tree.reduce`.
        n_leaves
            Most leaves of the luminance of all components together: the bound on L1 is about as small as that allows.
        n_bytes
            Largest size as a file [byte], likewise.
        file
            Which one: ``"xml"``, ``"bsdft"``, or ``"packed"``, a packed .bsdft.
        cull_percent
            As of :meth:`Tree.reduce`, of all trees, those of colour too, as genBSDF does it.

        Raises
        ------
        ValueError
            If there is no tree, nothing is given, or it cannot be so small.
        """
        return type(self)(reduced(self._core, l1, rms, total, n_leaves, n_bytes, norm, file, cull_percent, balance))

    def losses_of(self, reduced: Conversions) -> list[Reduction]:
        """What the trees of a reduced copy lost, one entry for each component of each band."""
        return losses(self._core, reduced._core)

    def smooth(self) -> Self:
        """Return the BSDF with ramps instead of steps in the leaves of its trees.

        Inside a leaf the values then go up and down as those around it suggest; the mean over every leaf stays what it
        is, so that no light is gained or lost, and nothing is negative. ``eval``, ``sample``, ``pdf`` and
        ``hemispherical`` fit together as before. A function that the tree resolves is met several times better; a peak
        narrower than a leaf stays a block. Totals of directions stay within 1 % of those of the cells around. Matrices
        and colour (u′, v′) stay constant over their cells. What is saved, converted or turned are the leaves, without
        ramps.

        Raises
        ------
        ValueError
            If there is no tree.

        Examples
        --------
        >>> import numpy as np
        >>> from bsdftree import Bsdf, Tree
        >>> x = (np.arange(8) + 0.5) / 8
        >>> b = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.broadcast_to(x, (8, 8, 8, 8)))})
        >>> from bsdftree import direction_from_polar
        >>> o = direction_from_polar([20, 25, 30], 90)
        >>> b.eval([0, 0, 1], o).round(3), b.smooth().eval([0, 0, 1], o).round(3)
        (array([0.688, 0.688, 0.812]), array([0.671, 0.711, 0.75 ]))
        """
        return type(self)(self._core.smooth())

    def repaired(
        self,
        kinds: Sequence[str] = KINDS,
        *,
        energy: float = 0.01,
        reciprocity: float = 0.25,
        noise: float = 0.25,
    ) -> tuple[Self, list[Mended]]:
        """Return a copy with findings mended, where they can be, and what was done.

        Parameters
        ----------
        kinds
            Which kinds of findings to mend; all by default.
        energy, reciprocity, noise
            What is tolerated, as in :meth:`check`.

        Returns
        -------
        Bsdf, list of Mended
            The copy, whose provenance says what was done, and that, with a number before and after. Without anything to
            mend, the copy is the same.

        Raises
        ------
        ValueError
            If there is no such kind.

        Examples
        --------
        >>> import numpy as np
        >>> from bsdftree import Bsdf, Tree
        >>> bright = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.4))})
        >>> mended, done = bright.repaired(["energy"])
        >>> [(m.what, m.measure, round(m.before, 3), round(m.after, 3)) for m in done]
        [('pairs of directions scaled down', 'largest total', 1.257, 1.0)]
        """
        core, done = _core.repaired(self._core, list(kinds), energy, reciprocity, noise)
        return type(self)(core), [Mended(**mended) for mended in done]

    def to_klems(self, basis: str | list[tuple[float, float, int]] = "full", *, subdivide: int = 1) -> Self:
        """Return the BSDF as matrices over an angle basis.

        Each value is the mean over incident and exitant patch by projected solid angle, from the areas that cells and
        patches share, cut out exactly. So totals are kept: the total of a patch is the mean of the totals over it.

        Parameters
        ----------
        basis
            ``"full"`` (145 patches), ``"half"`` (77; ``"half73"`` as it was before 2022), ``"quarter"`` (41), or rings
            as (lower, upper, n): polar angles [degree] and number of patches.
        subdivide
            Split each patch into this many by this many.

        Raises
        ------
        ValueError
            If there is no such basis, or it would have over 65536 patches.

        Examples
        --------
        >>> import numpy as np
        >>> from bsdftree import Bsdf, Tree
        >>> white = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.8 / np.pi))})
        >>> white.to_klems("quarter").components
        {'reflection_back': <Matrix LBNL/Klems Quarter (41) x LBNL/Klems Quarter (41)>}
        """
        return type(self)(_core.to_klems(self._core, basis, subdivide))

    def to_tree(self, rank: int = 4, log2_res: int = 5, *, tolerance: float = 0.0) -> Self:
        """Return the BSDF as tensor trees.

        Each value is the mean over its cell by projected solid angle, so totals are kept. Patches have borders where
        cells have none: :meth:`distance` says what that costs. Each level of resolution is up to sixteen times as many
        values, along all borders; a tolerance keeps them few.

        Parameters
        ----------
        rank
            3 averages over all turns about the normal; 4 keeps everything. Trees keep their rank, but may be coarsened.
        log2_res
            At most 2^log2_res cells per axis, 1 to 10.
        tolerance
            Relative L1 error that joining cells may add, in [0, 1). 0 joins equal ones only.

        Raises
        ------
        ValueError
            If an argument is out of its range, or a tree is of the other rank.
        """
        return type(self)(_core.to_tree(self._core, rank, log2_res, tolerance))

    def rotated(self, angle_deg: float) -> Self:
        """Return the BSDF of the device turned about its normal.

        Quarter turns, and of a matrix turns by whole patches of all rings, are exact. Others are resampled by the area
        that turned cells share with others, cut out exactly: light is kept, peaks get wider by up to a cell, and
        :meth:`distance` from the turn there and back says how much. Trees are turned at 2^7 cells per axis at most.
        Isotropic trees (rank 3) do not change. Geometry in the file is left out.

        Parameters
        ----------
        angle_deg
            Counter-clockwise as seen from the room [degree].
        """
        return type(self)(_core.turned(self._core, angle_deg))

    def mirrored(self, axis: Literal["x", "y"] = "x") -> Self:
        """Return the BSDF of the device mirrored: ``"x"`` swaps left and right, ``"y"`` up and down. Exact."""
        return type(self)(_core.mirrored(self._core, axis))

    def flipped(self) -> Self:
        """Return the BSDF of the device turned round about the vertical, its front to the back. Exact.

        What the properties say of the front is then said of the back: ``EmissivityFront``, ``EmissivityBack``.
        """
        turned = type(self)(_core.flipped(self._core))
        other = {"EmissivityFront": "EmissivityBack", "EmissivityBack": "EmissivityFront"}
        swapped = {other.get(key, key): value for key, value in self.properties.items()}
        if swapped == self.properties:
            return turned
        # Where both are, in the order they had: the schema prescribes one.
        kept = {key: swapped[key] for key in self.properties if key in swapped}
        return turned.with_header(properties=swapped if len(kept) < len(swapped) else kept)

    def select(
        self,
        components: Sequence[str] | None = None,
        *,
        bands: Sequence[str] | None = None,
        rename: tuple[str, str] | None = None,
    ) -> Self:
        """Return some of the BSDF.

        Parameters
        ----------
        components
            Which to take; all by default.
        bands
            Which to take; all by default.
        rename
            A band, and what it is to be called: a file of solar data may call it ``Visible``.

        Raises
        ------
        ValueError
            If there is no such component or band.
        """
        unknown = sorted(set(components or ()) - set(COMPONENTS))
        if unknown:
            raise ValueError(f"no component {unknown[0]!r}; expected one of {', '.join(COMPONENTS)}")
        chosen = None if components is None else list(components)
        return type(self)(_core.chosen(self._core, chosen, None if bands is None else list(bands), rename))
