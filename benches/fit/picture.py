"""Truth, ours and the incumbent side by side, for some left-out incident directions: disks of exitant directions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bsdftree._directions import direction_from_square

from .formulas import Array
from .report import Case

DECADES = 3
"""Of the logarithmic colour scale, down from the brightest true cell."""


def draw(cases: Sequence[Case], path: Path, per_case: int = 2) -> None:
    """A row for the worst and the median counted direction of every case."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import LogNorm

    rows = [(case, k) for case in cases for k in _chosen(case, per_case)]
    figure, axes = pyplot.subplots(len(rows), 3, figsize=(7.2, 2.45 * len(rows)), squeeze=False, layout="constrained")
    for line, (case, k) in zip(axes, rows, strict=True):
        shown = [v for v in (case.ours, case.incumbent) if v is not None]
        true = shown[0].true[k]
        norm = LogNorm(true.max() * 10.0**-DECADES, true.max())
        for axis in line:
            axis.set_axis_off()
        panels = [("truth", true, None)] + [(v.name, v.values[k], v.l1[k]) for v in shown]
        for axis, (name, values, l1) in zip(line, panels, strict=False):
            mesh = _disk(axis, values, norm)
            axis.set_title(name if l1 is None else f"{name}: L1 {l1:.3f}", fontsize=8)
        line[0].text(-1.25, 0, _label(case, k), rotation=90, va="center", ha="center", fontsize=8)
        bar = figure.colorbar(mesh, ax=line[2], shrink=0.8)
        bar.ax.tick_params(labelsize=6)
        bar.set_label("1/sr", fontsize=6)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _chosen(case: Case, n: int) -> list[int]:
    verdict = case.ours or case.incumbent
    if verdict is None:
        return []
    counts = np.flatnonzero(case.court.counts)
    ranked = counts[np.argsort(-verdict.l1[counts])]
    return [int(k) for k in ranked[np.linspace(0, len(ranked) // 2, n).astype(int)]]


def _label(case: Case, k: int) -> str:
    x, y, z = case.court.middle[k]
    return f"{case.court.material.name}\nθ {np.degrees(np.arccos(z)):.0f}°, φ {np.degrees(np.arctan2(y, x)) % 360:.0f}°"


def _disk(axis: object, values: Array, norm: object) -> object:
    n = round(len(values) ** 0.5)
    edges = np.arange(n + 1) / n
    x, y = np.meshgrid(edges, edges, indexing="ij")
    places = direction_from_square(x.ravel(), y.ravel())[:, :2].reshape(n + 1, n + 1, 2)
    shown = np.maximum(values.reshape(n, n), norm.vmin)  # type: ignore[attr-defined]
    axis.set_aspect("equal")  # type: ignore[attr-defined]
    return axis.pcolormesh(places[..., 0], places[..., 1], shown, norm=norm, rasterized=True)  # type: ignore[attr-defined]
