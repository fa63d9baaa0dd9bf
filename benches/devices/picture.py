"""Small multiples: each device twice, what leaves of the light from one incident patch; ours left, Radiance's right."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm

from .comparison import luminance_or_xyz
from .patches import INCIDENT, Array, bounds, projected_solid_angles
from .run import Measured

PATCH = INCIDENT.index(55)
"""40 degrees from the normal."""
COLUMNS = 6
DECADES = 3.0


def draw(measured: Sequence[Measured], path: Path) -> None:
    """Draw all devices into a file."""
    plt.switch_backend("Agg")
    rows = math.ceil(len(measured) / COLUMNS)
    figure, axes = plt.subplots(rows, COLUMNS, figsize=(2.3 * COLUMNS, 1.42 * rows + 0.5), layout="constrained")
    for axis in axes.ravel():
        axis.set_axis_off()
    for axis, m in zip(axes.ravel(), measured, strict=False):
        panel(axis, m)
    figure.suptitle(
        "Light from the front, 40° from the normal: BSDF of what leaves to the brighter hemisphere, "
        f"ours (left) and Radiance's (right); colours span {DECADES:g} decades",
        fontsize=9,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def panel(axis: Axes, m: Measured) -> None:
    """Two disks side by side, on one logarithmic scale."""
    y = 1 if m.scene.colour else 0
    ours = m.ours.runs[0, PATCH].mean(axis=0)[..., y]
    theirs = luminance_or_xyz(m.radiance.batches[0, PATCH].mean(axis=0), m.scene.colour)[..., y]
    side = int(np.argmax(ours.sum(axis=1)))
    values = [x[side] / projected_solid_angles() for x in (ours, theirs)]
    top = max(float(values[0].max()), 1e-6)
    norm = LogNorm(top / 10**DECADES, top, clip=True)
    for k, f in enumerate(values):
        disk = PolyCollection(outlines(2.2 * k), array=np.maximum(f, norm.vmin or 0), norm=norm, cmap="viridis")
        disk.set_edgecolor("face")
        disk.set_linewidth(0.2)
        axis.add_collection(disk)
    axis.set_xlim(-1.05, 3.25)
    axis.set_ylim(-1.05, 1.05)
    axis.set_aspect("equal")
    mark = "" if m.verdict.agrees else ("  ≠ known" if m.scene.known else "  ≠")
    where = "reflected" if side == 0 else "transmitted"
    axis.set_title(f"{m.scene.name}{mark}\n{where}, to {top:.2g}/sr", fontsize=6.5, pad=2)


def outlines(shift: float) -> list[Array]:
    """Of all patches, in the plane of projected directions."""
    shapes = []
    for inner, outer, start, end in bounds():
        azimuths = np.linspace(start, end, 9)
        ring = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
        shape = np.concatenate([math.sqrt(outer) * ring, math.sqrt(inner) * ring[::-1]])
        shapes.append(shape + np.array([shift, 0]))
    return shapes
