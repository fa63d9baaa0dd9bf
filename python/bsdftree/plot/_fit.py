"""A fit beside what was measured: points, fitted values, their errors, and a profile through the plane of incidence."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import FuncFormatter, NullFormatter

from bsdftree._directions import direction_from_polar
from bsdftree._fit import Fit
from bsdftree._fit_summary import polar_of, scans_of, sides_of
from bsdftree._measurement import Array, Scan
from bsdftree.plot._parts import SIDES
from bsdftree.plot._style import FAINT, INK, ZERO, Picture, Scale, bare, figure, round_limits

# All in pixels.
_WIDTH, _TOP, _PART, _ROW, _DISK, _LEFT = 1640, 108, 52, 330, 290, 24
_PROFILE_X, _PROFILE_WIDTH = 1066, 540
# Pixels of an edge of the images.
_N = 240
# Relative standard errors from none to this are drawn.
_MOST_ERROR = 0.5
# Points this near to the plane of incidence [degree] are in the profile, or the nearest fiftieth.
_NEAR_DEG = 1.5
_BAND, _LINE, _MARK = "#9fc3e8", "#2f6db5", "#b5452c"


class _Row(NamedTuple):
    """One incident direction: a scan, or none between two."""

    incident: Array
    scan: Scan | None
    title: str


def fit(
    fitted: Fit,
    part: str | None = None,
    *,
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    title: str | None = None,
) -> Figure:
    """Draw a fit beside what was measured, for some scans and for a direction between two.

    In a row: measured points and fitted values, on one colour scale; the relative standard error; and a profile in the
    plane of incidence with points and a band of two standard errors on either side. Disks are orthographic (a
    direction's x and y) and as seen from the room, X to the right and Y up; a circle marks where the light comes from
    (on the same side), a cross the mirrored direction or straight on.

    Parameters
    ----------
    fitted
        From :func:`bsdftree.fit`.
    part
        One component, e.g. ``"reflection_back"``; all that were measured by default.
    limits
        Smallest and largest value [1/sr] of the colour scale; by default round numbers around the values.
    colors
        Name of a matplotlib colour map. Zero is dark grey in all of them.
    title
        Heading; the name of the sample by default.

    Raises
    ------
    ValueError
        If the part was not measured, or the limits are not 0 < lower < upper.
    """
    if part is not None and part not in fitted.recipes:
        raise ValueError(f"no component {part!r}; measured are {', '.join(fitted.recipes)}")
    parts = list(fitted.recipes) if part is None else [part]
    rows = [(p, row) for p in parts for row in _rows(fitted, p, 3 if len(parts) < 3 else 2)]
    images = [_image(fitted, p, row.incident) for p, row in rows]
    points = [row.scan.values for _, row in rows if row.scan is not None]
    scale = Scale.of([*(values for values, _ in images), *points], limits, colors)
    height = _TOP + len(rows) * _ROW + len(parts) * _PART + 40
    picture = figure(_WIDTH, height)
    heading = (fitted.measurement.name or "fit") if title is None else title
    _say(picture, 30, f"{heading}   ({fitted.symmetry})", 15)
    names = ("measured", "fitted", "relative standard error", "in the plane of incidence [1/sr], with ± 2 errors")
    for k, name in enumerate(names):
        _say(picture, 70, name, 12, _LEFT + k * (_DISK + 12) if k < 3 else _PROFILE_X)
    top = float(_TOP)
    for k, ((p, row), image) in enumerate(zip(rows, images, strict=True)):
        if k == 0 or p != rows[k - 1][0]:
            _say(picture, top + 4, f"{p.replace('_', ' ')} ({SIDES[p]}): {_recipe(fitted, p)}", 11)
            top += _PART
        _draw_row(picture, fitted, p, row, image, scale, 1 - (top + _DISK) / height, height)
        top += _ROW
    _legend(picture, scale, height)
    return picture


def _say(picture: Picture, y: float, text: str, size: float, x: float = _LEFT) -> None:
    """Text at a place in pixels from the top left."""
    height = picture.bbox.height
    picture.text(x / _WIDTH, 1 - y / height, text, fontsize=size, va="center", color=INK)


def _recipe(fitted: Fit, part: str) -> str:
    used = fitted.recipes[part][0]
    score = "no scan could be left out" if np.isnan(used.l1) else f"left-out scans {100 * used.l1:.1f} % off"
    return f"{used.frame} frame, {used.blend} weights, {score}"


def _rows(fitted: Fit, part: str, n_scans: int) -> list[_Row]:
    """Some scans from low to high, and a direction between the middle one and its nearest neighbour."""
    scans = scans_of(fitted.measurement, part)
    chosen = sorted({round(k) for k in np.linspace(0, len(scans) - 1, min(n_scans, len(scans)))})
    rows = [_Row(scans[k].incident, scans[k], f"scan at {_angles(scans[k].incident)}") for k in chosen]
    middle = scans[chosen[len(chosen) // 2]]
    cosine = np.array([float(scan.incident @ middle.incident) for scan in scans])
    cosine[cosine > 1 - 1e-6] = -1
    if cosine.max() > -1:
        between = middle.incident + scans[int(cosine.argmax())].incident
        between /= np.linalg.norm(between)
        rows.append(_Row(between, None, f"between scans, {_angles(between)}"))
    return sorted(rows, key=lambda row: (-abs(row.incident[2]), row.scan is None))


def _angles(incident: Array) -> str:
    theta, phi = polar_of(incident)
    return f"θ {theta:.4g}°, φ {phi:.4g}°"


def _image(fitted: Fit, part: str, incident: Array) -> tuple[Array, Array]:
    """Values and relative errors over the disk; row 0 is the top."""
    at = (np.arange(_N) + 0.5) * 2 / _N - 1
    x, y = np.meshgrid(at, -at)
    inside = x * x + y * y < 1
    exitant = np.stack([x, y, sides_of(part)[1] * np.sqrt(np.maximum(1 - x * x - y * y, 0))], axis=-1)[inside]
    values, errors = np.full(inside.shape, np.nan), np.full(inside.shape, np.nan)
    values[inside] = _values(fitted, incident, exitant)
    errors[inside] = fitted.error(incident, exitant) / np.maximum(values[inside], 1e-300)
    return values, errors


def _values(fitted: Fit, incident: Array, exitant: Array) -> Array:
    values = fitted.eval(incident, exitant)
    return values[:, 1] if values.ndim == 2 else values


def _draw_row(
    picture: Picture, fitted: Fit, part: str, row: _Row, image: tuple[Array, Array], scale: Scale, y: float, tall: float
) -> None:
    for k in range(3):
        axes = picture.add_axes(((_LEFT + k * (_DISK + 12)) / _WIDTH, y, _DISK / _WIDTH, _DISK / tall))
        if k == 0 and row.scan is not None:
            _draw_points(axes, row.scan, scale)
        elif k == 1:
            scale.draw(axes, image[0], (-1, 1, -1, 1))
        elif k == 2:
            axes.imshow(
                image[1], cmap="magma", vmin=0, vmax=_MOST_ERROR, extent=(-1, 1, -1, 1), interpolation="nearest"
            )
        _disk(axes, row.incident, sides_of(part)[1], "white" if k else _MARK)
        if k == 0:
            axes.text(-1.1, 1.1, row.title, fontsize=10.5, color=INK, va="bottom")
        if k == 0 and row.scan is None:
            axes.text(0, 0.3, "nothing was\nmeasured here", fontsize=10.5, color=FAINT, ha="center")
    axes = picture.add_axes((_PROFILE_X / _WIDTH, y + 22 / tall, _PROFILE_WIDTH / _WIDTH, (_DISK - 22) / tall))
    _draw_profile(axes, fitted, part, row)


def _disk(axes: Axes, incident: Array, side: float, mark: str) -> None:
    bare(axes)
    axes.set_xlim(-1.1, 1.1)
    axes.set_ylim(-1.1, 1.1)
    axes.set_aspect("equal")
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=INK, linewidth=1.0))
    for theta_deg in (30, 60):
        r = float(np.sin(np.radians(theta_deg)))
        axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=mark, linewidth=0.6, alpha=0.5, linestyle=(0, (5, 4))))
    x, y, z = incident
    axes.plot(-x, -y, "x", color=mark, markersize=7, markeredgewidth=1.2)
    if z * side > 0:
        axes.plot(x, y, "o", markerfacecolor="none", markeredgecolor=mark, markersize=8, markeredgewidth=1.2)


def _draw_points(axes: Axes, scan: Scan, scale: Scale) -> None:
    # Bright points last, so that peaks are seen.
    order = np.argsort(scan.values)
    values = scan.values[order]
    shown = scale.colors(LogNorm(scale.low, scale.high)(np.maximum(values, scale.low)))
    size = float(np.clip(16000 / len(values), 1.5, 60))
    x, y = scan.exitant[order, :2].T
    axes.scatter(x[values > 0], y[values > 0], s=size, c=shown[values > 0], linewidths=0)
    axes.scatter(x[values <= 0], y[values <= 0], s=size, c=ZERO, linewidths=0)


def _draw_profile(axes: Axes, fitted: Fit, part: str, row: _Row) -> None:
    """Values against the polar angle in the plane of incidence, positive to where mirrored light goes."""
    theta, phi = polar_of(row.incident)
    side = sides_of(part)[1]
    angle = np.linspace(-89.5, 89.5, 359)
    exitant = direction_from_polar(angle, phi + 180) * [1, 1, side]
    values, errors = _values(fitted, row.incident, exitant), fitted.error(row.incident, exitant)
    low, high = round_limits(values, 5)
    axes.fill_between(
        angle, np.maximum(values - 2 * errors, low / 10), values + 2 * errors, color=_BAND, alpha=0.7, linewidth=0
    )
    axes.plot(angle, np.maximum(values, low / 10), color=_LINE, linewidth=1.6)
    if row.scan is not None:
        along, measured = _near_plane(row.scan, phi)
        axes.plot(along, measured, "o", color=_MARK, markersize=3, markeredgewidth=0)
        high = max(high, round_limits(measured, 5)[1]) if len(measured) else high
    axes.axvline(theta, color=FAINT, linewidth=0.8, linestyle=(0, (5, 4)))
    axes.set_yscale("log")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(low, high)
    axes.set_xlim(-90, 90)
    axes.set_xticks(range(-90, 91, 30))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0f}°"))
    axes.grid(color="#e4e4e4", linewidth=0.7)
    axes.tick_params(labelsize=9, colors=INK)
    for spine in axes.spines.values():
        spine.set_color("#bbbbbb")


def _near_plane(scan: Scan, phi_deg: float) -> tuple[Array, Array]:
    """Angles [degree] and values of points near the plane of incidence."""
    along = np.array([-np.cos(np.radians(phi_deg)), -np.sin(np.radians(phi_deg))])
    off = np.degrees(np.arcsin(np.clip(np.abs(scan.exitant[:, :2] @ [along[1], -along[0]]), 0, 1)))
    near = off < max(_NEAR_DEG, float(np.quantile(off, 0.02)))
    d = scan.exitant[near]
    return np.degrees(np.arctan2(d[:, :2] @ along, np.abs(d[:, 2]))), scan.values[near]


def _legend(picture: Picture, scale: Scale, height: float) -> None:
    """Both colour scales to the left of the profiles, and how to read the rest."""
    x, width = (_LEFT + 3 * (_DISK + 12) + 6) / _WIDTH, 14 / _WIDTH
    top, half = height - _TOP - _PART, 0.7 * _ROW
    scale.bar(picture, (x, (top - half + 14) / height, width, (half - 30) / height))
    axes = picture.add_axes((x, (top - 2 * half + 8) / height, width, (half - 40) / height))
    axes.imshow(
        np.linspace(1, 0, 256)[:, None],
        cmap="magma",
        extent=(0, 1, 0, 100 * _MOST_ERROR),
        aspect="auto",
        vmin=0,
        vmax=1,
    )
    axes.xaxis.set_ticks([])
    axes.yaxis.tick_right()
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{'≥ ' if v >= 100 * _MOST_ERROR else ''}{v:.0f} %"))
    axes.tick_params(labelsize=9, colors=INK)
    axes.set_title("error", fontsize=9, color=INK, pad=6)
    text = (
        "Seen from the room.  ○ where the light comes from   × straight on, or mirrored.  Profiles: right is the side "
        "of mirrored light, dashed its angle; points within 1.5° of the plane"
    )
    picture.text(_LEFT / _WIDTH, 22 / height, text, fontsize=10, va="center", color=INK)
