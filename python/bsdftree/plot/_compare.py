"""Two BSDFs beside each other: polar maps, their difference and ratio, and a table of how far they are apart."""

from __future__ import annotations

from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LogNorm, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import ArrayLike, NDArray

from bsdftree import Bsdf, direction_from_polar
from bsdftree._totals import mean_total, totals_by_azimuth
from bsdftree.plot._hemispherical import parts_with_reversed
from bsdftree.plot._image import hemisphere_image
from bsdftree.plot._parts import OUTSIDE, ROOM, SIDES, band_of, scatters
from bsdftree.plot._polar import angles, draw_map, mark_map, unit_vectors
from bsdftree.plot._style import DIVERGING, INK, Picture, Scale, figure, round_limits

Array = NDArray[np.float64]
# All in pixels.
_DISK, _STEP, _LEFT, _TOP, _ROW, _BAR = 280, 296, 56, 84, 300, 96
# The ratio is drawn from a tenth to ten times.
_RATIO = 10.0
# Polar angles at which totals are compared [degree].
_THETA_DEG = np.arange(0.0, 90.0, 5.0)


class Difference(NamedTuple):
    """How far a component of one BSDF is from that of another.

    ``relative_l1`` is ∫|a - b| / ∫a over all pairs of directions, NaN if either is absent from its file; totals are of
    evenly diffuse light; ``worst_total`` is the largest difference b - a of totals by direction (every 5 by 22.5
    degrees) and ``theta_deg`` the polar angle where.
    """

    part: str
    relative_l1: float
    total_a: float
    total_b: float
    worst_total: float
    theta_deg: float


def differences(a: Bsdf, b: Bsdf, band: str) -> list[Difference]:
    """Compare all components that either BSDF has."""
    l1 = a.distance(b, band)
    found = []
    for part in SIDES:
        if part not in parts_with_reversed(a, band) and part not in parts_with_reversed(b, band):
            continue
        side, kind = SIDES[part].incident, SIDES[part].kind
        totals = [totals_by_azimuth(x, side, kind, _THETA_DEG, band) for x in (a, b)]
        apart = totals[1] - totals[0]
        row, column = np.unravel_index(np.abs(apart).argmax(), apart.shape)
        mean_a, mean_b = (mean_total(x, side, kind, band) for x in (a, b))
        found.append(
            Difference(
                part, l1.get(part, np.nan), mean_a, mean_b, float(apart[row, column]), float(_THETA_DEG[int(row)])
            )
        )
    return found


def compare(
    a: Bsdf,
    b: Bsdf,
    incident: ArrayLike | None = None,
    *,
    band: str | None = None,
    names: tuple[str, str] = ("A", "B"),
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    title: str | None = None,
) -> Figure:
    """Draw two BSDFs of any kind side by side, their difference b - a and ratio b / a, and a table of errors.

    Parameters
    ----------
    a, b
        Trees or Klems matrices, e.g. a reference and a smaller or coarser copy.
    incident
        Unit vectors away from the surface, (3,) or (n, 3); a row of maps for each and each side to which light goes. By
        default 30 degrees from above, from each side from which light is scattered.
    band
        Spectral band that both have; ``Visible`` or the only one of ``a`` by default.
    names
        What to call them.
    limits, colors
        Of the colour scale [1/sr], as of :func:`bsdftree.plot.mosaic`.
    title
        Heading; the names by default.

    Raises
    ------
    ValueError
        If a direction is none, or either has no such band.
    """
    band = band_of(a, band)
    band_of(b, band)
    if incident is None:
        sides = [s for s in (ROOM, OUTSIDE) if scatters(a, s, band) or scatters(b, s, band)] or [ROOM]
        incident = np.array([direction_from_polar(30.0, 90.0) * [1.0, 1.0, s] for s in sides])
    rows: list[tuple[Array, float, Array, Array]] = []
    for vector in np.atleast_2d(unit_vectors(incident)):
        of_sides = []
        for side in (ROOM, OUTSIDE):
            first, second = (hemisphere_image(x, vector, side, band, 2 * _DISK) for x in (a, b))
            of_sides.append((vector, side, first, second))
        rows += [r for r in of_sides if np.nanmax(r[2]) > 0.0 or np.nanmax(r[3]) > 0.0] or of_sides[:1]
    scale = Scale.of([image for row in rows for image in row[2:]], limits, colors)
    apart = [second - first for _, _, first, second in rows]
    table = differences(a, b, band)
    height = _TOP + len(rows) * _ROW + 44 + 22 * (len(table) + 1) + 20
    width = _LEFT + 4 * _STEP + 3 * _BAR
    picture = figure(width, height)
    heading = f"{names[0]}  and  {names[1]}" if title is None else title
    picture.text(24 / width, 1 - 28 / height, f"{heading}   ({band})", fontsize=15, va="center", color=INK)
    x_of = [_LEFT, _LEFT + _STEP, _LEFT + 2 * _STEP + _BAR, _LEFT + 3 * _STEP + 2 * _BAR]
    labels = (f"A: {names[0]}", f"B: {names[1]}", "difference B − A", "ratio B / A")
    for x, label in zip(x_of, labels, strict=True):
        text = label if len(label) < 36 else label[:34] + "…"
        picture.text((x + 0.5 * _DISK) / width, 1 - 68 / height, text, fontsize=11.5, ha="center", color=INK)
    difference, ratio = _difference_norm(apart, scale), LogNorm(1.0 / _RATIO, _RATIO)
    diverging = matplotlib.colormaps[DIVERGING]
    for k, ((vector, side, first, second), delta) in enumerate(zip(rows, apart, strict=True)):
        y = 1 - (_TOP + k * _ROW + _DISK) / height
        axes = [picture.add_axes((x / width, y, _DISK / width, _DISK / height)) for x in x_of]
        draw_map(axes[0], first, scale, vector, side)
        draw_map(axes[1], second, scale, vector, side)
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where((first > 0.0) | (second > 0.0), second / first, np.nan)
        _draw(axes[2], delta, difference, diverging, vector, side)
        _draw(axes[3], np.clip(relative, 1.0 / _RATIO, _RATIO), ratio, diverging, vector, side)
        goes = "room" if side == ROOM else "outside"
        at = y + 0.5 * _DISK / height
        text = f"from {angles(vector)}\nto the {goes}"
        picture.text(28 / width, at, text, fontsize=9.5, rotation=90, ha="center", va="center", color=INK)
    tall = min(_ROW - 60, 240)
    y = 1 - (_TOP + 20 + tall) / height
    scale.bar(picture, ((x_of[1] + _DISK + 22) / width, y, 14 / width, tall / height))
    for x, norm, unit in ((x_of[2], difference, "[1/sr]"), (x_of[3], ratio, "B / A [1]")):
        box = ((x + _DISK + 22) / width, y, 14 / width, tall / height)
        _bar(picture, box, norm, diverging, unit)
    _write_table(picture, table, width, height)
    return picture


def _difference_norm(apart: list[Array], scale: Scale) -> Normalize:
    """Logarithmic on both sides of nothing, four decades each."""
    most = max(float(np.nanmax(np.abs(delta))) for delta in apart)
    _, high = round_limits(np.array([most]), 1) if most > 0.0 else (0.0, scale.high)
    return SymLogNorm(1e-4 * high, linscale=0.5, vmin=-high, vmax=high)


def _draw(axes: Axes, image: Array, norm: Normalize, colors: Colormap, incident: Array, side: float) -> None:
    axes.add_patch(Circle((0, 0), 1.0, facecolor="#d9d9d9", edgecolor="none", zorder=0))
    axes.imshow(image, cmap=colors, norm=norm, extent=(-1, 1, -1, 1), interpolation="nearest")
    mark_map(axes, incident, side, INK, "white")


def _bar(
    picture: Picture, box: tuple[float, float, float, float], norm: Normalize, colors: Colormap, unit: str
) -> None:
    axes = picture.add_axes(box)
    bar = picture.colorbar(ScalarMappable(norm, colors), cax=axes)
    high = float(norm.vmax or 1.0)
    if isinstance(norm, LogNorm):
        bar.set_ticks([1 / high, 0.5, 1, 2, high], labels=[f"≤ {1 / high:g}", "0.5", "1", "2", f"≥ {high:g}"])
    else:
        steps = [high, 1e-1 * high, 1e-2 * high, 1e-3 * high]
        ticks = [*(-s for s in steps), 0.0, *reversed(steps)]
        bar.set_ticks(ticks, labels=[f"{t:.0e}".replace("e-0", "e-").replace("e+0", "e") if t else "0" for t in ticks])
    bar.ax.minorticks_off()
    bar.ax.tick_params(labelsize=8.5, colors=INK)
    bar.ax.set_title(unit, fontsize=9, color=INK, pad=10)


def _write_table(picture: Picture, table: list[Difference], width: float, height: float) -> None:
    columns = (24, 330, 470, 600, 730, 960)
    head = ("component", "relative L1", "diffuse A", "diffuse B", "B − A, diffuse", "largest B − A, every 5° × 22.5°")
    lines = [head]
    for d in table:
        l1 = "–" if np.isnan(d.relative_l1) else f"{100 * d.relative_l1:.2f} %"
        worst = f"{100 * d.worst_total:+.3f} %, at θ {d.theta_deg:g}°"
        diffuse = (f"{100 * d.total_a:.3f} %", f"{100 * d.total_b:.3f} %", f"{100 * (d.total_b - d.total_a):+.3f} %")
        lines.append((f"{d.part.replace('_', ' ')}: {SIDES[d.part]}", l1, *diffuse, worst))
    for row, texts in enumerate(lines):
        y = 1 - (height - 22 * (len(lines) - row)) / height
        for x, text in zip(columns, texts, strict=True):
            picture.text(x / width, y, text, fontsize=10.5, color=INK, weight="bold" if row == 0 else "normal")
