"""The whole BSDF: all incident and exitant directions in one image, as G. Ward's talks on tensor trees show it."""

from __future__ import annotations

import textwrap
from itertools import accumulate
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from bsdftree import Bsdf, Matrix
from bsdftree.plot._image import Tiles, matrix_image, tiles_of
from bsdftree.plot._parts import SIDES, band_of, diffuse_total, heading_of, parts_of
from bsdftree.plot._style import FAINT, INK, Scale, bare, figure

Layout = Literal["mosaic", "matrix"]
# Edge of a panel: a power of two, so that pixels of the image are pixels of the picture.
_EDGE = 1024


LEGEND_RANK4 = (
    "A tile is one incident direction, placed by where the light heads (top: up, right: to the right); "
    "inside it, all directions in which light leaves.\n"
    "Light that goes straight on or is mirrored keeps its tile's place. Seen from the room. "
    "Dashed squares: polar angles 30° and 60°."
)
LEGEND_RANK3 = (
    "A tile is one range of incident polar angles; inside it, all directions in which light leaves. "
    "The light heads to the right: light that goes straight on or is mirrored lies right of the centre."
)
LEGEND_MATRIX = (
    "Klems patches ring by ring from the normal; numbers are the polar angles between rings. "
    "Within a ring azimuth grows counter-clockwise from the right.\nIncident patches are placed by where "
    "the light heads: light that goes straight on or is mirrored lies on the diagonal."
)


class Panel(NamedTuple):
    """What one panel shows, before it has colours."""

    title: str
    content: Tiles | Matrix
    pixels: NDArray[np.float64]

    @property
    def aspect(self) -> float:
        """Height by width."""
        return float(self.pixels.shape[0] / self.pixels.shape[1])

    @property
    def legend(self) -> str:
        """How to read it."""
        if isinstance(self.content, Matrix):
            return LEGEND_MATRIX
        return LEGEND_RANK4 if self.content.theta_deg is None else LEGEND_RANK3


def panel_of(
    bsdf: Bsdf, part: str, band: str, *, layout: Layout | None = None, log2_res: int | None = None, max_px: int
) -> Panel:
    """Collect the pixels of one component; a matrix is drawn as such unless told otherwise."""
    component = bsdf.components_of(band)[part]
    name = part.replace("_", " ").capitalize()
    title = f"{name}: {SIDES[part]}, {100.0 * diffuse_total(bsdf, part, band):.2f} %"
    if isinstance(component, Matrix) and layout != "mosaic":
        return Panel(title, component, matrix_image(component, max_px))
    tiles = tiles_of(bsdf, part, band, log2_res, max_px)
    return Panel(title, tiles, tiles.pixels)


def mosaic(
    bsdf: Bsdf,
    *,
    part: str | None = None,
    band: str | None = None,
    log2_res: int | None = None,
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    title: str | None = None,
) -> Figure:
    """Draw the whole BSDF: in one image a tile for each incident direction, in it all exitant directions.

    Parameters
    ----------
    bsdf
        Trees of rank 3 or 4, or Klems matrices.
    part
        One component, e.g. ``"reflection_back"``; all that there are by default.
    band
        Spectral band; ``Visible`` or the only one by default.
    log2_res
        Up to 2^log2_res incident cells per axis, by default up to 2^5. Coarser cells are means.
    limits
        Smallest and largest value [1/sr] of the colour scale, e.g. to compare pictures; by default round
        numbers around the values.
    colors
        Name of a matplotlib colour map. Zero is dark grey in all of them.
    title
        Heading; the name of the product by default.

    Returns
    -------
    Figure
        One panel for each component; its title has the fraction of evenly diffuse light that it scatters.

    Raises
    ------
    ValueError
        If there is no such part or band, or an argument is out of range.

    Notes
    -----
    Where the tree is finer than the picture, pixels are means. :func:`bsdftree.plot.mosaic_image` has the numbers.
    """
    band = band_of(bsdf, band)
    parts = parts_of(bsdf, part, band)
    panels = [panel_of(bsdf, p, band, layout="mosaic", log2_res=log2_res, max_px=_EDGE) for p in parts]
    return draw_panels(panels, heading_of(bsdf, band, title), limits, colors)


def draw_panels(panels: list[Panel], heading: str, limits: tuple[float, float] | None, colors: str) -> Figure:
    """One large panel, or rows of two, on one colour scale."""
    scale = Scale.of([p.pixels for p in panels], limits, colors)
    columns = 1 if len(panels) == 1 else 2
    rows = -(-len(panels) // columns)
    # All in pixels.
    edge, gap, left, top, bottom, right = _EDGE, 96, 70, 110, 110, 130
    edge_y = round(edge * max(p.aspect for p in panels))
    width = left + columns * edge + (columns - 1) * gap + right
    height = top + rows * edge_y + (rows - 1) * gap + bottom
    picture = figure(width, height)
    picture.text(left / width, 1.0 - 30 / height, heading, fontsize=16, va="center", color=INK)
    for k, panel in enumerate(panels):
        x = left + (k % columns) * (edge + gap)
        y = bottom + (rows - 1 - k // columns) * (edge_y + gap)
        axes = picture.add_axes((x / width, y / height, edge / width, edge_y / height))
        draw_panel(axes, panel, scale, 13)
    bar_height = min(edge_y, 700)
    scale.bar(picture, (1.0 - 100 / width, (height - top - bar_height) / height, 22 / width, bar_height / height))
    text = legend_of(panels, width - left - 20)
    picture.text(left / width, (bottom - 34) / height, text, fontsize=9.5, va="top", color=INK)
    return picture


def legend_of(panels: list[Panel], width_px: float) -> str:
    """How to read some panels, in lines that fit in a width at 9.5 points."""
    characters = int(width_px / 6.4)
    lines = dict.fromkeys(line for panel in panels for line in panel.legend.split("\n"))
    return "\n".join(textwrap.fill(line, characters) for line in lines)


def draw_panel(axes: Axes, panel: Panel, scale: Scale, font_size: float) -> None:
    """Draw one component with its title and what tells the directions."""
    axes.set_title(panel.title, fontsize=font_size, color=INK, pad=6 + font_size, loc="left")
    if isinstance(panel.content, Matrix):
        _draw_matrix(axes, panel.content, panel.pixels, scale, font_size)
        return
    tiles = panel.content
    scale.draw(axes, tiles.pixels, (0, tiles.columns, 0, tiles.rows))
    axes.set_anchor("NW")
    bare(axes)
    if max(tiles.columns, tiles.rows) > 1:
        for x in range(1, tiles.columns):
            axes.axvline(x, color="white", linewidth=0.6, alpha=0.45)
        for y in range(1, tiles.rows):
            axes.axhline(y, color="white", linewidth=0.6, alpha=0.45)
    if tiles.theta_deg is None:
        _annotate_square(axes, tiles.columns, font_size)
    else:
        _annotate_polar_angles(axes, tiles, font_size)


def _annotate_square(axes: Axes, n: int, font_size: float) -> None:
    small = 0.75 * font_size
    halo = [withStroke(linewidth=2.0, foreground="#000000aa")]
    for theta_deg in (30.0, 60.0):
        half = 0.5 * n * float(np.sin(np.radians(theta_deg)))
        corner = (0.5 * n - half, 0.5 * n - half)
        dashes = (0, (5, 4))
        axes.add_patch(Rectangle(corner, 2 * half, 2 * half, fill=False, edgecolor="white", linestyle=dashes))
        axes.text(
            0.5 * n, 0.5 * n + half, f"{theta_deg:.0f}°", color="white", fontsize=small, ha="center", va="center",
            path_effects=halo,
        )  # fmt: skip
    for x, y, text, ha, va, rotation in (
        (0.5, 1.005, "light from below, heading up", "center", "bottom", 0),
        (0.5, -0.006, "light from above, heading down", "center", "top", 0),
        (-0.006, 0.5, "light from the right", "right", "center", 90),
        (1.006, 0.5, "light from the left", "left", "center", 90),
    ):
        axes.text(x, y, text, transform=axes.transAxes, fontsize=small, ha=ha, va=va, rotation=rotation, color=INK)


def _annotate_polar_angles(axes: Axes, tiles: Tiles, font_size: float) -> None:
    assert tiles.theta_deg is not None
    halo = [withStroke(linewidth=2.0, foreground="black")]
    for k, (lower, upper) in enumerate(tiles.theta_deg):
        x, y = k % tiles.columns + 0.03, tiles.rows - k // tiles.columns - 0.03
        axes.text(
            x,
            y,
            f"{lower:.0f}–{upper:.0f}°",
            color="white",
            fontsize=font_size * min(0.75, 4.0 / tiles.columns),
            va="top",
            path_effects=halo,
        )
    axes.text(
        0.5, -0.006, "incident polar angle, in reading order; light heads to the right", transform=axes.transAxes,
        fontsize=0.75 * font_size, ha="center", va="top", color=INK,
    )  # fmt: skip


def _draw_matrix(axes: Axes, matrix: Matrix, pixels: NDArray[np.float64], scale: Scale, font_size: float) -> None:
    n_incident, n_exitant = matrix.values.shape
    k = -(-max(n_incident, n_exitant) // max(pixels.shape))  # patches to a pixel
    scale.draw(axes, pixels, (0, pixels.shape[1] * k, pixels.shape[0] * k, 0))
    axes.set_xlim(0, n_incident)
    axes.set_ylim(n_exitant, 0)
    bare(axes)
    for rings, axis, line in (
        (matrix.incident_rings, axes.xaxis, axes.axvline),
        (matrix.exitant_rings, axes.yaxis, axes.axhline),
    ):
        edges = list(accumulate(n for _, _, n in rings))
        for edge in edges[:-1]:
            line(edge, color="white", linewidth=0.6, alpha=0.45)
        axis.set_ticks(edges, [f"{upper:g}°" for _, upper, _ in rings])
    axes.tick_params(labelsize=0.7 * font_size, colors=INK, length=2, color=FAINT, pad=2)
    axes.set_xlabel("incident patch", fontsize=0.75 * font_size, color=INK, labelpad=1)
    axes.set_ylabel("exitant patch", fontsize=0.75 * font_size, color=INK, labelpad=1)
