"""What a fit says of itself: one place for what the verb, notebooks and programs show.

In: a fit, and trees that it made, if any. Out: numbers. Totals of scans come from the measured points
(:meth:`Measurement.summary`), not from the fit, so that they can be held against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bsdftree._component import Tree
from bsdftree._directions import direction_from_polar, direction_from_square, polar_from_direction
from bsdftree._measurement import Array, Measurement, Scan, ScanSummary
from bsdftree._queries import Part
from bsdftree._standard_errors import UNCERTAIN, errors_by_flux

if TYPE_CHECKING:
    from bsdftree._fit import Fit, FittedTrees, Recipe, SwappedPairs

# Light from polar angles up to this [degree] is no extrapolation worth a row of its own.
_GRAZING_DEG = 85.0
# Cells of an edge of the square over which a fit without trees is summed.
_N_CELLS = 96
# Images of incident directions by symmetry; of isotropic samples polar angles alone count.
_MIRRORS = {
    "half_turn": [(-1, -1, 1)],
    "bilateral_x": [(1, -1, 1)],
    "bilateral_y": [(-1, 1, 1)],
    "quadrilateral": [(1, -1, 1), (-1, 1, 1), (-1, -1, 1)],
}


@dataclass(frozen=True)
class DirectionTotal:
    """Light from one direction that a component scatters.

    Attributes
    ----------
    theta_deg, phi_deg
        Where it comes from [degree], θ from the normal of its side.
    n_points
        Measured on the side to which it leaves; 0 if nothing was measured for this direction.
    measured
        Directional-hemispherical total, summed from the points as :meth:`Measurement.summary` does. None if there are
        none, or they have large holes.
    fitted
        The same of the trees (mean of an incident cell), or of the fit itself if there are none.
    standard_error
        Mean standard error by flux, relative.
    """

    theta_deg: float
    phi_deg: float
    n_points: int
    measured: float | None
    fitted: float
    standard_error: float


@dataclass(frozen=True)
class PartSummary:
    """What is known of the fit of one component.

    Attributes
    ----------
    component
        Such as ``reflection_back``, light from the room: front is the outside, as in WINDOW.
    recipes
        All that were tried, best first; the first is in use.
    reciprocity
        What swapped pairs of scans say; None if there are too few.
    totals
        For each scan, by polar angle and azimuth; and for one direction nearer to grazing than all, if there is room.
    extrapolated
        Share of incident directions (projected solid angle) outside those measured and their images.
    hole_deg
        Farthest that an exitant direction is from all points, median of all scans [degree].
    rank, n_leaves
        Of the tree, if there is one.
    standard_error
        Mean relative standard error by flux: of the tree, or of the fit at the scans' incident directions.
    uncertain
        Share of that flux whose relative standard error is over 25 %.
    """

    component: str
    recipes: list[Recipe]
    reciprocity: SwappedPairs | None
    totals: list[DirectionTotal]
    extrapolated: float
    hole_deg: float
    rank: int | None
    n_leaves: int | None
    standard_error: float
    uncertain: float


@dataclass(frozen=True)
class FitSummary:
    """What a fit says of itself.

    Attributes
    ----------
    name
        Of the sample.
    n_scans, n_points, n_channels
        That were measured; 3 channels are X, Y and Z.
    notes
        What was assumed, repaired or left out in reading and in fitting.
    symmetry, symmetry_reason, symmetry_errors
        As of the fit.
    parts
        By component.
    """

    name: str | None
    n_scans: int
    n_points: int
    n_channels: int
    notes: list[str]
    symmetry: str
    symmetry_reason: str
    symmetry_errors: dict[str, float]
    parts: list[PartSummary]


def summarize_fit(fit: Fit, trees: FittedTrees | None = None) -> FitSummary:
    """Collect what is known; see :meth:`Fit.summary`."""
    measurement = fit.measurement
    # Points of a sample whose symmetry was found have images too.
    told = Measurement(measurement.scans, symmetry=fit.symmetry).summary()  # type: ignore[arg-type]
    return FitSummary(
        name=measurement.name,
        n_scans=len(measurement.scans),
        n_points=sum(len(scan.exitant) for scan in measurement.scans),
        n_channels=measurement.n_channels,
        notes=[*measurement.notes, *fit.notes],
        symmetry=fit.symmetry,
        symmetry_reason=fit.symmetry_reason,
        symmetry_errors=fit.symmetry_errors,
        parts=[_part(fit, part, [row for row in told if row.part == part], trees) for part in fit.recipes],
    )


def extrapolation(fit: Fit) -> list[str]:
    """Sentences for files that are made of a fit: what was not measured."""
    parts: dict[str, list[str]] = {}
    for component in fit.recipes:
        incident = [scan.incident for scan in scans_of(fit.measurement, component)]
        share = f"{100 * _outside(incident, fit.symmetry):.1f} % of incident directions"
        parts.setdefault(f"{share}; measured to {polar_of(incident[-1])[0]:.1f} degrees", []).append(component)
    return [f"Extrapolated: {what} ({', '.join(components)})" for what, components in parts.items()]


def scans_of(measurement: Measurement, component: str) -> list[Scan]:
    """The scans of a component by polar angle and azimuth, with its points alone and Y alone of colour."""
    incident, exitant = sides_of(component)
    chosen = []
    for scan in measurement.scans:
        here = scan.exitant[:, 2] * exitant > 0
        if scan.incident[2] * incident > 0 and here.any():
            values = scan.values if scan.values.ndim == 1 else scan.values[:, 1]
            chosen.append(Scan(scan.incident, scan.exitant[here], values[here], None, scan.source))
    return sorted(chosen, key=lambda scan: polar_of(scan.incident))


def sides_of(component: str) -> tuple[float, float]:
    """Sign of z of a component's incident and exitant directions."""
    incident = 1.0 if component.endswith("back") else -1.0
    return incident, incident if component.startswith("reflection") else -incident


def polar_of(direction: Array) -> tuple[float, float]:
    """Polar angle from the normal of its side, and azimuth [degree]."""
    theta, phi = polar_from_direction(np.append(direction[:2], abs(direction[2])))
    return round(float(theta), 6), round(float(phi), 6) % 360.0


def _part(fit: Fit, component: str, told: list[ScanSummary], trees: FittedTrees | None) -> PartSummary:
    scans = fit.measurement.scans
    told = sorted(told, key=lambda row: polar_of(scans[row.scan].incident))
    incident = [scans[row.scan].incident for row in told]
    n_points, measured = [row.n_points for row in told], [row.total for row in told]
    theta_deg, phi_deg = polar_of(incident[-1])
    if theta_deg < _GRAZING_DEG:
        beyond = direction_from_polar(0.5 * (theta_deg + 90.0), phi_deg) * [1, 1, np.sign(incident[-1][2])]
        incident, n_points, measured = [*incident, beyond], [*n_points, 0], [*measured, None]
    fluxes = np.array([_flux(fit, component, i, trees) for i in incident])
    total, error = fluxes[:, 0], fluxes[:, 1] / np.maximum(fluxes[:, 0], 1e-300)
    if trees is None:
        all_, errors, uncertain = fluxes[: len(told)].sum(axis=0)
        quality = (errors / max(all_, 1e-300), uncertain / max(all_, 1e-300))
    else:
        quality = errors_by_flux(trees.bsdf, trees.errors)[component]
    tree = None if trees is None else trees.bsdf.components[component]
    return PartSummary(
        component=component,
        recipes=fit.recipes[component],
        reciprocity=fit.reciprocity[component],
        totals=[
            DirectionTotal(*polar_of(i), n, m, float(t), float(e))
            for i, n, m, t, e in zip(incident, n_points, measured, total, error, strict=True)
        ],
        extrapolated=_outside([scans[row.scan].incident for row in told], fit.symmetry),
        hole_deg=float(np.median([row.hole_deg for row in told])),
        rank=tree.rank if isinstance(tree, Tree) else None,
        n_leaves=tree.n_leaves if isinstance(tree, Tree) else None,
        standard_error=float(quality[0]),
        uncertain=float(quality[1]),
    )


def _hemisphere() -> Array:
    """Directions of the upper hemisphere, evenly spread over projected solid angle."""
    at = (np.arange(_N_CELLS) + 0.5) / _N_CELLS
    x, y = (a.ravel() for a in np.meshgrid(at, at))
    return direction_from_square(x, y)


def _flux(fit: Fit, component: str, incident: Array, trees: FittedTrees | None) -> tuple[float, float, float]:
    """Scattered light from one direction, its standard error, and how much of it is uncertain (of fits)."""
    if trees is not None:
        part: Part = "reflection" if component.startswith("reflection") else "transmission"
        total, error = (float(b.hemispherical(incident, part)) for b in trees)
        return total, error, 0.0
    exitant = _hemisphere() * [1, 1, sides_of(component)[1]]
    values, errors = fit.eval(incident, exitant), fit.error(incident, exitant)
    values = values[:, 1] if values.ndim == 2 else values
    share = np.pi / len(exitant)
    uncertain = float(values[errors > UNCERTAIN * values].sum())
    return share * float(values.sum()), share * float(errors.sum()), share * uncertain


def _outside(incident: Sequence[Array], symmetry: str) -> float:
    """Share of projected solid angle outside of some incident directions and their images."""
    up = np.array(incident) * [1, 1, np.sign(incident[0][2])]
    if symmetry == "isotropic":
        return float(up[:, 2].min() ** 2)
    images = np.concatenate([up, *(up * mirror for mirror in _MIRRORS.get(symmetry, []))])
    # On the disk of equal solid angles, as the fit sees them.
    corners, asked = (d[:, :2] / np.sqrt(1 + d[:, 2:]) for d in (images, _hemisphere()))
    hull = _hull(corners)
    if len(hull) < 3:
        return 1.0
    inside = np.ones(len(asked), bool)
    for a, b in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        inside &= (b[0] - a[0]) * (asked[:, 1] - a[1]) - (b[1] - a[1]) * (asked[:, 0] - a[0]) >= 0
    return float(1 - inside.mean())


def _hull(points: Array) -> Array:
    """Convex hull, counter-clockwise (Andrew 1979)."""
    ordered = sorted(set(map(tuple, points.tolist())))
    hull: list[tuple[float, ...]] = []
    for chain in (ordered, ordered[::-1]):
        start = len(hull)
        for p in chain:
            while len(hull) >= start + 2:
                a, b = hull[-2], hull[-1]
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 1e-12:
                    break
                hull.pop()
            hull.append(p)
        hull.pop()
    return np.array(hull)
