"""One picture for a first look: the whole BSDF, slices and totals."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter

from bsdftree import Bsdf, Matrix, Tree, direction_from_polar
from bsdftree.plot._mosaic import draw_panel, legend_of, panel_of
from bsdftree.plot._parts import OUTSIDE, ROOM, band_of, is_black, parts_of, scatters
from bsdftree.plot._slice import FROM_OUTSIDE, FROM_ROOM, draw_slice
from bsdftree.plot._style import INK, OUTSIDE_COLOR, ROOM_COLOR, Picture, Scale, figure, line_axes

# All in pixels.
_WIDTH = 1600
_MARGIN = 44
# Room for the colour bar at the right.
_BAR = 110
_GAP = 56
_HEADER, _LEGEND, _BELOW = 116, 86, 460
# Least height of what stands beside a single mosaic.
_BESIDE = 640


def overview(bsdf: Bsdf, *, title: str | None = None, band: str | None = None) -> Figure:
    """Draw the whole BSDF of every component, slices in the vertical plane and hemispherical totals.

    Made for 1600 pixels of width. Components that are black are named, not drawn.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    title
        Heading; the name of the product by default.
    band
        Spectral band; ``Visible`` or the only one by default.

    Raises
    ------
    ValueError
        If there is no such band.

    See Also
    --------
    bsdftree.plot.mosaic, bsdftree.plot.slice, bsdftree.plot.polar
    """
    band = band_of(bsdf, band)
    components = bsdf.components_of(band)
    parts = parts_of(bsdf, None, band)
    black = [p for p in parts if is_black(components[p])]
    shown = [p for p in parts if p not in black] or parts[:1]
    sides = [side for side in (ROOM, OUTSIDE) if scatters(bsdf, side, band)] or [ROOM]

    n = len(shown)
    # A single mosaic would fill the picture: it is given the width of one of two, and the rest stands beside it.
    edge = (_WIDTH - 2 * _MARGIN - _BAR - (max(n, 2) - 1) * _GAP) / max(n, 2)
    beside = n == 1
    panels = [
        panel_of(bsdf, p, band, log2_res=_log2_res(components[p], edge), max_px=1 << (int(edge).bit_length() - 1))
        for p in shown
    ]
    scale = Scale.of([p.pixels for p in panels])
    edge_y = edge * max(p.aspect for p in panels)
    height = _HEADER + (max(edge_y, _BESIDE) if beside else edge_y) + _LEGEND + (20 if beside else _BELOW)
    picture = figure(_WIDTH, height)
    _heading(picture, bsdf, band, title, black, height)
    bottom = height - _HEADER - edge_y
    for k, panel in enumerate(panels):
        box = (_MARGIN + k * (edge + _GAP), bottom, edge, edge_y)
        draw_panel(picture.add_axes(_fractions(box, height)), panel, scale, 11.5 if n < 4 else 10)
    bar_x = _MARGIN + n * (edge + _GAP) - _GAP + 44
    scale.bar(picture, _fractions((bar_x, bottom, 18, edge_y - 34), height))
    text = legend_of(panels, edge if beside else _WIDTH - 2 * _MARGIN)
    picture.text(_MARGIN / _WIDTH, (bottom - 34) / height, text, fontsize=9.5, va="top", color=INK)

    if beside:
        x = bar_x + _BAR
        width = _WIDTH - _MARGIN - x
        polar_edge = min(width / len(sides) - 104, 340)
        spare = width / len(sides) - polar_edge
        corners = [
            (x + k * width / len(sides) + 0.75 * spare, height - _HEADER - polar_edge + 10) for k in range(len(sides))
        ]
        totals_box = (x + 20, _LEGEND + 20, width - 20, height - _HEADER - _LEGEND - 20 - polar_edge - 150)
    else:
        third = (_WIDTH - 2 * _MARGIN - 30) / (len(sides) + 1)
        polar_edge = _BELOW - 120
        corners = [(_MARGIN + k * third + 120, 46) for k in range(len(sides))]
        left = _MARGIN + len(sides) * third + 70
        totals_box = (left, 60, _WIDTH - _MARGIN - left, _BELOW - 140)
    for side, (x, y) in zip(sides, corners, strict=True):
        box = (x, y, polar_edge, polar_edge)
        axes = picture.add_axes(_fractions(box, height), projection="polar")
        assert isinstance(axes, PolarAxes)
        draw_slice(axes, bsdf, FROM_ROOM if side == ROOM else FROM_OUTSIDE, [90.0] * 3, band)
    _draw_totals(picture.add_axes(_fractions(totals_box, height)), bsdf, sides, band)
    return picture


def _log2_res(component: Tree | Matrix, edge: float) -> int:
    """No more tiles than can be told apart; rank 3 has few."""
    return 5 if edge >= 600 or (isinstance(component, Tree) and component.rank == 3) else 4


def _fractions(box: tuple[float, float, float, float], height: float) -> tuple[float, float, float, float]:
    """A box in pixels from the lower left as parts of the figure."""
    x, y, w, h = box
    return x / _WIDTH, y / height, w / _WIDTH, h / height


def _heading(picture: Picture, bsdf: Bsdf, band: str, title: str | None, black: list[str], height: float) -> None:
    text = (bsdf.name or "BSDF") if title is None else title
    picture.text(_MARGIN / _WIDTH, 1 - 28 / height, text, fontsize=16, va="center", color=INK)
    components = bsdf.components_of(band)
    components = {key: c for key, c in components.items() if key not in black} or components
    kinds = dict.fromkeys(_kind(c) for c in components.values())
    notes = [band, "; ".join(kinds), "percentages are of evenly diffuse light"]
    if black:
        notes.append("black: " + ", ".join(p.replace("_", " ") for p in black))
    picture.text(_MARGIN / _WIDTH, 1 - 56 / height, "  ·  ".join(notes), fontsize=10, va="center", color=INK)


def _kind(component: Tree | Matrix) -> str:
    if isinstance(component, Tree):
        return f"rank-{component.rank} tree of $2^{component.depth}$ cells per axis"
    return f"Klems matrix of {component.values.shape[0]} × {component.values.shape[1]} patches"


def _draw_totals(axes: Axes, bsdf: Bsdf, sides: list[float], band: str) -> None:
    """Hemispherical totals in the vertical plane: light from below at negative angles, from above at positive ones."""
    angle = np.arange(-89.75, 90.0, 0.5)
    highest = 0.0
    for side in sides:
        incident = direction_from_polar(angle, 90.0) * [1.0, 1.0, side]
        name, color, width = ("room", ROOM_COLOR, 2.6) if side == ROOM else ("outside", OUTSIDE_COLOR, 1.3)
        for kind, line in (("reflection", "-"), ("transmission", "--")):
            totals = 100.0 * bsdf.hemispherical(incident, kind, band=band)  # type: ignore[arg-type]
            highest = max(highest, float(totals.max()))
            axes.plot(angle, totals, line, color=color, linewidth=width, label=f"{kind}, light from {name}")
    axes.set_xlim(-90, 90)
    axes.set_xticks(range(-90, 91, 30))
    axes.set_ylim(0, 102 if 50.0 < highest <= 101.0 else 1.08 * highest or 102)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{abs(value):.0f}°"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g} %"))
    axes.set_xlabel("from below        incident angle in the vertical plane        from above", fontsize=9.5, color=INK)
    axes.set_title(
        "Reflectance and transmittance by incident angle", fontsize=11, color=INK, loc="left", pad=10 + 17 * len(sides)
    )
    line_axes(axes)
    axes.legend(
        fontsize=9, frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(-0.01, 0.985), handlelength=1.8,
        columnspacing=1.0, borderpad=0.2,
    )  # fmt: skip
