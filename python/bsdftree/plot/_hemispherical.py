"""Directional-hemispherical totals of each component against the incident angle."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from bsdftree import Bsdf, direction_from_polar
from bsdftree._totals import mean_total, totals_by_azimuth
from bsdftree.plot._parts import SIDES, band_of, heading_of
from bsdftree.plot._style import INK, OKABE_ITO, figure, line_axes

_THETA_DEG = np.arange(0.25, 90.0, 0.5)
_FROM = {0.0: "right", 90.0: "above", 180.0: "left", 270.0: "below"}
_WIDTH, _PANEL, _GAP, _TOP, _BOTTOM, _LEFT = 1200, 360, 84, 122, 60, 76


def hemispherical(bsdf: Bsdf, *, part: str | None = None, band: str | None = None, title: str | None = None) -> Figure:
    """Draw how much light each component scatters [%], by the polar angle and azimuth that it comes from.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    part
        One component; by default all that scatter, an absent transmission as the other one reversed.
    band
        Spectral band; ``Visible`` or the only one by default.
    title
        Heading; the name of the product by default.

    Raises
    ------
    ValueError
        If there is no such part or band.
    """
    band = band_of(bsdf, band)
    shown = [part] if part else parts_with_reversed(bsdf, band)
    if part is not None and part not in parts_with_reversed(bsdf, band):
        raise ValueError(f"no component {part!r} in band {band}; the BSDF has {', '.join(bsdf.components_of(band))}")
    columns = min(len(shown), 2)
    rows = -(-len(shown) // columns)
    edge = (_WIDTH - _LEFT - 30 - (columns - 1) * _GAP) / columns
    height = _TOP + rows * _PANEL + (rows - 1) * _GAP + _BOTTOM
    picture = figure(_WIDTH, height)
    picture.text(0.025, 1 - 30 / height, heading_of(bsdf, band, title), fontsize=15, va="center", color=INK)
    for k, name in enumerate(shown):
        x = _LEFT + (k % columns) * (edge + _GAP)
        y = _BOTTOM + (rows - 1 - k // columns) * (_PANEL + _GAP)
        axes = picture.add_axes((x / _WIDTH, y / height, edge / _WIDTH, _PANEL / height))
        _draw(axes, bsdf, name, band)
        if k == 0:
            picture.legend(
                *axes.get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(0.02, 1 - 48 / height), ncols=5,
                fontsize=9.5, frameon=False, handlelength=1.8,
            )  # fmt: skip
    return picture


def parts_with_reversed(bsdf: Bsdf, band: str) -> list[str]:
    """Components that there are, an absent transmission among them if it is the other one reversed."""
    there = bsdf.components_of(band)
    any_transmission = any(key in there and sides.kind == "transmission" for key, sides in SIDES.items())
    return [key for key, sides in SIDES.items() if key in there or (any_transmission and sides.kind == "transmission")]


def _draw(axes: Axes, bsdf: Bsdf, part: str, band: str) -> None:
    sides = SIDES[part]
    highest = 0.0
    for (phi, name), color, width in zip(_FROM.items(), OKABE_ITO, (3.4, 2.6, 1.8, 1.1), strict=False):
        # The plane itself runs along edges of cells: the mean of both sides.
        incident = direction_from_polar(_THETA_DEG[:, None], [phi - 0.01, phi + 0.01]) * [1.0, 1.0, sides.incident]
        totals = 100.0 * bsdf.hemispherical(incident, sides.kind, band=band).mean(axis=1)
        highest = max(highest, float(totals.max()))
        axes.plot(_THETA_DEG, totals, color=color, linewidth=width, label=f"light from {name} (φ {phi:g}°)")
    mean = 100.0 * totals_by_azimuth(bsdf, sides.incident, sides.kind, _THETA_DEG, band).mean(axis=1)
    axes.plot(_THETA_DEG, mean, color=INK, linewidth=1.6, linestyle=(0, (4, 2)), label="mean of all azimuths")
    line_axes(axes)
    axes.set_xlim(0, 90)
    axes.set_xticks(range(0, 91, 15))
    axes.set_ylim(0, 102 if 50.0 < highest <= 101.0 else 1.08 * highest or 102)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0f}°"))
    axes.set_xlabel("incident polar angle θ [degree]", fontsize=9.5, color=INK)
    axes.set_ylabel(f"{'reflectance' if sides.kind == 'reflection' else 'transmittance'} [%]", fontsize=9.5, color=INK)
    diffuse = 100.0 * mean_total(bsdf, sides.incident, sides.kind, band)
    backwards = "" if part in bsdf.components_of(band) else ", the other one reversed"
    name = part.replace("_", " ").capitalize()
    axes.set_title(f"{name}: {sides}, diffuse {diffuse:.2f} %{backwards}", fontsize=11, color=INK, loc="left")
