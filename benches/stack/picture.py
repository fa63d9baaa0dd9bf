"""Stacked beside traced by incident direction, and how far they are apart by gap and by the number of cells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

if TYPE_CHECKING:
    from .__main__ import Row

NAMES = {
    "transmission_front": ("transmitted", "C0"),
    "reflection_front": ("reflected outside", "C1"),
    "reflection_back": ("reflected to the room", "C3"),
}
RINGS = np.array([0, 10, 20, 30, 40, 50, 60, 70, 82.5])
FLOOR = 0.02
"""What is less is not told from noise."""
COUNTS = [1, 8, 16, 20, 24, 24, 24, 16, 12]


def draw(rows: Sequence[Row], path: Path) -> None:
    """Draw three panels into a PNG."""
    figure, (totals, gaps, cells) = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained")
    far = max(row.gap for row in rows)
    for key, (name, colour) in NAMES.items():
        mine = [row for row in rows if row.key == key]
        (full,) = (row for row in mine if row.domain.name == "Klems full" and row.gap == far)
        stacked, traced = (np.array([ring.mean() for ring in _rings(each.value)]) for each in full.incident)
        totals.plot(RINGS, traced, color=colour, label=f"{name}, traced")
        totals.plot(RINGS, stacked, "o", color=colour, mfc="none", label=f"{name}, stacked")
        fine = [row for row in mine if row.domain.name == "Klems full, split 3 × 3"]
        values, errors = (100 * np.array([row.light[k] for row in fine]) for k in (0, 1))
        gaps.errorbar([row.gap for row in fine], values, 2 * errors, color=colour, marker="o", capsize=3, label=name)
        for kind, style in (("Klems quarter", "o-"), ("rank 4", "s--")):
            by_size = sorted(
                (row for row in mine if row.domain.name.startswith(kind) and row.gap == far),
                key=lambda row: row.domain.n_cells,
            )
            x, y = ([f(row) for row in by_size] for f in (lambda r: r.domain.n_cells, lambda r: 100 * r.directions))
            y = np.maximum(y, FLOOR)
            cells.plot(x, y, style, color=colour, label=f"{name}, {kind}")
    totals.set(xlabel="polar angle of incident light [°]", ylabel="of the light", title="Klems full, averaged by ring")
    gaps.set(xscale="log", xlabel="gap [spacings of the slats]", ylabel="stacked − traced [% of the light]")
    gaps.set_title("Near layers know of each other's places (± 2 s.e.)")
    gaps.axhline(0, color="grey", lw=0.8)
    cells.set(
        xscale="log",
        yscale="log",
        xlabel="cells of a side",
        ylabel=f"RMS over incident cells [points; at least {FLOOR}]",
    )
    cells.set_title("Far layers: what the size of cells does")
    for axes in (totals, gaps, cells):
        axes.legend(fontsize=8, loc="lower left" if axes is cells else "best")
        axes.grid(alpha=0.3)
    figure.suptitle("Slats behind a pane: stack of two BSDFs beside the traced whole")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=90)


def _rings(values: np.ndarray) -> list[np.ndarray]:
    return np.split(values, np.cumsum(COUNTS)[:-1])
