"""Trees from measurements."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bsdftree import _core
from bsdftree._bsdf import Bsdf
from bsdftree._fit_summary import FitSummary, extrapolation, summarize_fit
from bsdftree._measurement import Array, Measurement, Path_, Symmetry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Frame = Literal["fixed", "shift", "rotation", "half-vector", "lobes"]


@dataclass(frozen=True)
class Recipe:
    """One way to interpolate between incident directions, and how well it predicts scans that are left out."""

    frame: str
    """How lobes move with the incident direction: ``fixed``, ``shift``, ``rotation``, ``half-vector`` or ``lobes``."""
    blend: str
    """How weights go from scan to scan: ``spline`` or ``linear``."""
    split: bool
    """Whether what is below 1.5 medians of a scan stays, and only the rest moves."""
    reciprocal: bool
    """Whether pairs of directions are averaged with swapped pairs, by how well each is known."""
    l1: float
    """Relative L1 error of scans left out, weighted by projected solid angle; NaN if none can be left out."""
    worst: float
    """That of the worst scan that is not dark."""


@dataclass(frozen=True)
class SwappedPairs:
    """Whether light goes back as it came: what swapped pairs of scans say, each measured towards the other's light."""

    holds: bool
    """Whether they differ by no more than noise and the distance of points explain, or little more."""
    n_pairs: int
    """How many pairs were compared."""
    difference: float
    """Median of |ln(f(i,o)/f(o,i))|."""
    expected: float
    """The same as noise and the distance of points explain it."""


class FittedTrees(NamedTuple):
    """What a fit gives as trees."""

    bsdf: Bsdf
    """The BSDF."""
    errors: Bsdf
    """The same trees with a standard error in place of each leaf's value [1/sr]; of Y, if there is colour."""


class Fit:
    """A measurement fitted: values between and beyond what was measured, with errors. Made by :func:`fit`.

    Attributes
    ----------
    symmetry : str
        That is used.
    symmetry_reason : str
        Why.
    symmetry_errors : dict
        Cross-validated error with each symmetry that was tried.
    notes : list of str
        What was assumed where nothing was measured, a sentence each.
    recipes : dict
        By component, all recipes that were tried; the first is in use.
    reciprocity : dict
        By component, a :class:`SwappedPairs`; None if there are too few of them. Whether it is used, the recipe says.
    rank, log2_res, tolerance
        Of the trees that :meth:`trees` makes if it is told nothing.
    """

    def __init__(self, core: _core.Fit, measurement: Measurement) -> None:
        self._core = core
        self.measurement = measurement
        self.symmetry, self.symmetry_reason, errors = core.symmetry()
        self.symmetry_errors = dict(errors)
        self.notes = core.notes()
        self.recipes = {part: [Recipe(*row) for row in rows] for part, rows in core.scores()}
        self.reciprocity = {part: found and SwappedPairs(*found) for part, found in core.reciprocity()}
        self.rank, self.log2_res, self.tolerance = core.chosen()

    def eval(self, incident: ArrayLike, exitant: ArrayLike) -> Array:
        """Fitted values.

        Parameters
        ----------
        incident, exitant
            Unit vectors away from the surface, (..., 3), broadcast against each other.

        Returns
        -------
        ndarray
            BSDF [1/sr] without cosine, (...); with colour CIE X, Y, Z, (..., 3). 0 on sides that were not measured.
        """
        pairs, shape = _pairs(incident, exitant)
        values = self._core.eval(*pairs)
        return values[:, 0].reshape(shape) if values.shape[1] == 1 else values.reshape((*shape, 3))

    def error(self, incident: ArrayLike, exitant: ArrayLike) -> Array:
        """Standard errors [1/sr] of :meth:`eval`, of Y if there is colour; arguments and shape as there.

        They contain how badly scans are predicted from the others, how badly points from their neighbours, and the
        errors that came with the measurement; outside what was measured they grow with the distance to it.
        """
        pairs, shape = _pairs(incident, exitant)
        return self._core.error(*pairs).reshape(shape)

    def trees(
        self,
        rank: int | None = None,
        log2_res: int | None = None,
        *,
        tolerance: float | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> FittedTrees:
        """Make trees, and trees of their errors.

        Parameters
        ----------
        rank
            3 (isotropic samples) or 4.
        log2_res
            At most 2^log2_res cells per axis: to 9 at rank 3, to 7 at rank 4.
        tolerance
            Relative L1 error that reducing the trees may add; 0 keeps everything.
        progress
            Called with (done, total) now and then.

        Returns
        -------
        FittedTrees
            Values are means over cells. Totals of incident directions are as measured, and together at most 1.

        Raises
        ------
        ValueError
            If rank or resolution do not suit.
        """
        bsdf = self.bsdf(rank, log2_res, tolerance=tolerance, progress=progress)
        errors = Bsdf(self._core.errors_of(bsdf._core)).with_header(
            name=bsdf.name,
            manufacturer=bsdf.manufacturer,
            provenance=[*bsdf.provenance, "Standard errors in place of values"],
        )
        return FittedTrees(bsdf, errors)

    def bsdf(
        self,
        rank: int | None = None,
        log2_res: int | None = None,
        *,
        tolerance: float | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> Bsdf:
        """The trees of :meth:`trees`, without their errors; arguments as there."""
        core = self._core.bsdf(rank=rank, log2_res=log2_res, tolerance=tolerance, progress=progress)
        recipes = ", ".join(f"{part} {rows[0].frame}" for part, rows in self.recipes.items())
        made = f"Fitted by: bsdftree {_core.__version__} fit ({self.symmetry}; {recipes})"
        return Bsdf(core).with_header(
            name=self.measurement.name,
            manufacturer=self.measurement.manufacturer,
            provenance=[made, *extrapolation(self)],
        )

    def summary(self, trees: FittedTrees | None = None) -> FitSummary:
        """Say what was measured, how it was fitted and how good that is: what ``bsdftree fit`` prints.

        Parameters
        ----------
        trees
            What :meth:`trees` made, to have their sizes, totals and errors; those of the fit itself without them.
        """
        return summarize_fit(self, trees)

    def plot(self, part: str | None = None, *, title: str | None = None) -> Figure:
        """Draw measured points beside fitted values and their errors: :func:`bsdftree.plot.fit`."""
        from bsdftree.plot import fit

        return fit(self, part, title=title)

    def __repr__(self) -> str:
        lines = [f"Fit of {self.measurement!r}", f"  {self.symmetry}: {self.symmetry_reason}"]
        for part, (used, *_) in self.recipes.items():
            scores = "no scan can be left out" if used.l1 != used.l1 else f"left-out scans {used.l1:.1%} off"
            lines.append(f"  {part}: {used.frame} frame, {used.blend}, {scores}")
        return "\n".join(lines)


def fit(
    measurement: Measurement | Path_ | Iterable[Path_],
    *,
    symmetry: Symmetry | None = None,
    frame: Frame | None = None,
    reciprocal: bool | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Fit:
    """Fit a measurement: interpolate scattered values between exitant and incident directions.

    Between incident directions lobes are moved, not cross-faded. How they move, and how scans are weighted, is what
    predicts left-out scans best from the others.

    Parameters
    ----------
    measurement
        A :class:`Measurement`, or files of one.
    symmetry
        Of the sample; what the file states or the scans show if not given.
    frame
        How lobes move with the incident direction; what predicts best if not given.
    reciprocal
        Whether f(o, i) counts for f(i, o) where it is known better; if not given, where swapped pairs of scans do not
        contradict it and left-out scans are predicted better with it.
    progress
        Called with (done, total) now and then: cross-validations, of a symmetry or a recipe for one part.

    Raises
    ------
    ValueError
        If there is nothing to fit, or a scan has too few points.

    Examples
    --------
    >>> from bsdftree import direction_from_polar
    >>> exitant = direction_from_polar(*np.mgrid[0:90:10, 0:360:20].reshape(2, -1))
    >>> scans = [(direction_from_polar(theta, 180), exitant, np.full(len(exitant), 0.25)) for theta in (0, 30, 60)]
    >>> f = fit(Measurement(scans))
    >>> f.symmetry
    'isotropic'
    >>> round(float(f.eval(direction_from_polar(45, 0), [0, 0, 1])), 3)
    0.25
    """
    if not isinstance(measurement, Measurement):
        measurement = Measurement.load(measurement)
    fitted = _core.fit(measurement._core, symmetry=symmetry, frame=frame, reciprocal=reciprocal, progress=progress)
    return Fit(fitted, measurement)


def _pairs(incident: ArrayLike, exitant: ArrayLike) -> tuple[tuple[Array, Array], tuple[int, ...]]:
    """Two (n, 3) arrays of unit vectors, and the shape of the answer."""
    i, o = np.broadcast_arrays(np.asarray(incident, float), np.asarray(exitant, float))
    if i.shape[-1:] != (3,):
        raise ValueError(f"directions have shape {i.shape}; expected (..., 3)")
    rows = [np.ascontiguousarray(a.reshape(-1, 3)) for a in (i, o)]
    lengths = [np.linalg.norm(a, axis=1, keepdims=True) for a in rows]
    if not all(np.isfinite(n).all() and (n > 0).all() for n in lengths):
        raise ValueError("a direction has no length; expected unit vectors")
    units = tuple(np.ascontiguousarray(a / n) for a, n in zip(rows, lengths, strict=True))
    return (units[0], units[1]), i.shape[:-1]
