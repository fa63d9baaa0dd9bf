"""How components are divided: leaves of trees by depth, patches by ring, values."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from bsdftree import Bsdf, Matrix, Tree
from bsdftree._cells import Cells, cells_of
from bsdftree.plot._parts import band_of, heading_of, parts_of
from bsdftree.plot._style import INK, OKABE_ITO, figure, line_axes, round_limits

_WIDTH, _ROW, _PANEL, _TOP = 1400, 320, 210, 70
_COLUMNS = ((84, 330), (500, 380), (966, 400))
_VALUE_DECADES = 8


def stats(bsdf: Bsdf, *, part: str | None = None, band: str | None = None, title: str | None = None) -> Figure:
    """Draw how each component is divided: number of cells, their share of directions and of light, their values.

    Cells are leaves of trees, by depth (edge 2^-depth of the square), or pairs of patches of matrices, by exitant ring.
    Shares are of projected solid angles of incident times exitant directions.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    part
        One component; all that there are by default.
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
    parts = parts_of(bsdf, part, band)
    height = _TOP + _ROW * len(parts)
    picture = figure(_WIDTH, height)
    picture.text(30 / _WIDTH, 1.0 - 30 / height, heading_of(bsdf, band, title), fontsize=15, va="center", color=INK)
    for k, name in enumerate(parts):
        component = bsdf.components_of(band)[name]
        cells = cells_of(component)
        y = height - _TOP - k * _ROW - 46 - _PANEL
        boxes = [picture.add_axes((x / _WIDTH, y / height, w / _WIDTH, _PANEL / height)) for x, w in _COLUMNS]
        for axes in boxes:
            line_axes(axes)
        _draw_counts(boxes[0], cells)
        _draw_shares(boxes[1], cells)
        _draw_values(boxes[2], cells)
        text = f"{name.replace('_', ' ').capitalize()}: {_facts(component, cells)}"
        picture.text(30 / _WIDTH, (y + _PANEL + 30) / height, text, fontsize=12, va="center", color=INK)
    return picture


def _facts(component: Tree | Matrix, cells: Cells) -> str:
    memory = f"{component.nbytes / 1024:,.1f} KiB"
    if isinstance(component, Matrix):
        n_incident, n_exitant = component.values.shape
        return f"{n_incident} × {n_exitant} patches, {memory}, {np.mean(cells.values == 0.0):.1%} of values are 0"
    uniform = 1 << (component.rank * component.depth)
    return (
        f"rank {component.rank}, {component.n_leaves:,} leaves, {memory}; "
        f"1 for {uniform / component.n_leaves:,.3g} cells of the uniform grid of $2^{component.depth}$ per axis"
    )


def _labels(axes: Axes, cells: Cells, y_label: str) -> None:
    labels = [f"${label}$" if "^" in label else label for label in cells.labels]
    axes.set_xticks(range(len(labels)), labels, fontsize=9)
    if cells.kind != "depth":
        axes.tick_params(axis="x", labelrotation=30, labelsize=8, pad=1)
    axes.set_xlim(-0.6, max(len(labels), 4) - 0.4)
    per_axis = "cells per axis (2^depth)" if cells.kind == "depth" else "exitant ring, polar angle [degree]"
    axes.set_xlabel(per_axis, fontsize=9.5, color=INK)
    axes.set_ylabel(y_label, fontsize=9.5, color=INK)
    axes.grid(visible=False, axis="x")


def _draw_counts(axes: Axes, cells: Cells) -> None:
    counts = cells.counts
    axes.bar(range(len(counts)), counts, color=OKABE_ITO[0], width=0.7)
    axes.set_yscale("log")
    axes.set_ylim(0.7, 3.0 * counts.max())
    for x, n in enumerate(counts):
        if n:
            axes.text(x, 1.12 * n, _short(n), fontsize=8, ha="center", va="bottom", color=INK)
    _labels(axes, cells, "leaves [1]" if cells.kind == "depth" else "pairs of patches [1]")


def _short(n: float) -> str:
    return f"{n:.0f}" if n < 1e4 else f"{n / 1e3:.0f}k" if n < 1e6 else f"{n / 1e6:.1f}M"


def _draw_shares(axes: Axes, cells: Cells) -> None:
    at = np.arange(len(cells.labels))
    axes.bar(at - 0.19, cells.shares, 0.36, color=OKABE_ITO[1], label="of pairs of directions")
    axes.bar(at + 0.19, cells.light, 0.36, color=OKABE_ITO[2], label="of scattered light")
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    _legend(axes)
    _labels(axes, cells, "share [%]")


def _draw_values(axes: Axes, cells: Cells) -> None:
    positive = cells.values > 0.0
    low, high = round_limits(cells.values, _VALUE_DECADES)
    edges = np.geomspace(low, high, 8 * max(round(np.log10(high / low)), 1) + 1).tolist()
    values = np.clip(cells.values[positive], low, high)
    flux = (cells.share * cells.values)[positive]
    n, of_light = max(len(cells.values), 1), flux / (flux.sum() or 1.0)
    what = "leaves" if cells.kind == "depth" else "pairs of patches"
    axes.hist(values, edges, weights=np.full(len(values), 1 / n), color=OKABE_ITO[0], alpha=0.55, label=f"of {what}")
    axes.hist(values, edges, weights=of_light, histtype="step", linewidth=1.6, color=OKABE_ITO[3], label="of light")
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    _legend(axes)
    axes.set_xlabel(f"BSDF [1/sr]; {1.0 - positive.mean():.1%} of {what} are 0", fontsize=9.5, color=INK)
    axes.set_ylabel("share [%]", fontsize=9.5, color=INK)


def _legend(axes: Axes) -> None:
    axes.legend(
        fontsize=9,
        frameon=False,
        ncols=2,
        loc="lower right",
        bbox_to_anchor=(1.01, 0.98),
        handlelength=1.4,
        borderpad=0.2,
    )
