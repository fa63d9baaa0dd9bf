"""What was measured: where light came from, and the points of each scan."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from bsdftree._measurement import Array, Measurement
from bsdftree.plot._style import FAINT, INK, ZERO, Scale, bare, figure

_WIDTH = 1640
_TOP = 70
_PLACES_PX = 300
_COLUMNS = 6
# Of more scans than this, some are drawn, evenly spread.
_MOST = 36
_NAMES = {
    (1, 1): "reflection, room",
    (1, -1): "transmission to the outside",
    (-1, -1): "reflection, outside",
    (-1, 1): "transmission to the room",
}


def measurement(
    measured: Measurement,
    *,
    title: str | None = None,
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
) -> Figure:
    """Draw the coverage of a measurement.

    Above, where light came from. Below, a disk for each part of each scan with its points, coloured by value; a circle
    marks where the light comes from (on the same side), a cross the mirrored direction or straight on. Disks are
    orthographic (a direction's x and y) and as seen from the room, X to the right and Y up.

    Parameters
    ----------
    measured
        What was measured.
    title
        Heading; the name of the sample by default.
    limits
        Smallest and largest value [1/sr] of the colour scale; by default round numbers around the values.
    colors
        Name of a matplotlib colour map. Zero and negative values are dark grey in all of them.

    Raises
    ------
    ValueError
        If the limits are not 0 < lower < upper.
    """
    panels = _panels(measured)
    n_all = len(panels)
    if n_all > _MOST:
        panels = [panels[k] for k in np.linspace(0, n_all - 1, _MOST).round().astype(int)]
    scale = Scale.of([values for *_, values in panels], limits, colors)
    size = (_WIDTH - 130) // _COLUMNS
    rows = -(-len(panels) // _COLUMNS)
    height = _TOP + _PLACES_PX + rows * size + 50
    picture = figure(_WIDTH, height)

    def box(x: float, y: float, width: float, tall: float) -> tuple[float, float, float, float]:
        """A box by its top left corner, in pixels from the top."""
        return x / _WIDTH, 1 - (y + tall) / height, width / _WIDTH, tall / height

    incident = np.array([scan.incident for scan in measured.scans])
    for k, (side, name) in enumerate(((1, "Light from the room"), (-1, "Light from outside"))):
        shown = incident[np.sign(incident[:, 2]) == side]
        axes = picture.add_axes(box(40 + k * (_PLACES_PX + 40), _TOP, _PLACES_PX, _PLACES_PX))
        _disk(axes)
        axes.plot(shown[:, 0], shown[:, 1], "o", markersize=4.5, color="#b5452c", markeredgewidth=0)
        axes.text(0, 1.08, f"{name}: {len(shown)}", fontsize=11, color=INK, ha="center", va="bottom")
    for k, (scan_incident, exitant, values) in enumerate(panels):
        axes = picture.add_axes(
            box(20 + (k % _COLUMNS) * size, _TOP + _PLACES_PX + 20 + (k // _COLUMNS) * size, size, size)
        )
        _points(axes, scan_incident, exitant, values, scale)
    n_points = sum(len(scan.exitant) for scan in measured.scans)
    facts = [f"{len(measured.scans)} incident directions, {n_points:,} points"]
    facts += [f"symmetry: {measured.symmetry}"] if measured.symmetry else []
    facts += [f"{measured.wavelength_nm:g} nm"] if measured.wavelength_nm else []
    facts += [f"{len(panels)} of {n_all} disks are drawn"] if n_all > len(panels) else []
    facts += ["", "○ where the light comes from   × straight on, or mirrored", "Seen from the room, values of Y"]
    if measured.n_channels == 1:
        facts[-1] = "Seen from the room"
    x, y = 60 + 2 * (_PLACES_PX + 40), _TOP + 40
    picture.text(x / _WIDTH, 1 - y / height, "\n".join(facts), fontsize=12, va="top", color=INK, linespacing=1.7)
    heading = (measured.name or "measurement") if title is None else title
    picture.text(30 / _WIDTH, 1 - 34 / height, heading, fontsize=15, va="center", color=INK)
    scale.bar(picture, box(_WIDTH - 90, _TOP + _PLACES_PX + 60, 22, max(size * rows - 90, 150)))
    return picture


def _panels(measured: Measurement) -> list[tuple[Array, Array, Array]]:
    """Incident direction, exitant directions of one side and their values, for each part of each scan."""
    panels = []
    for scan in measured.scans:
        values = scan.values if measured.n_channels == 1 else scan.values[:, 1]
        for side in (1.0, -1.0):
            there = np.sign(scan.exitant[:, 2]) == side
            if there.any():
                panels.append((scan.incident, scan.exitant[there], values[there]))
    return panels


def _disk(axes: Axes) -> None:
    bare(axes)
    axes.set_xlim(-1.22, 1.22)
    axes.set_ylim(-1.22, 1.22)
    axes.set_aspect("equal")
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=INK, linewidth=1.0))
    for theta_deg in (30, 60):
        r = float(np.sin(np.radians(theta_deg)))
        axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=FAINT, linewidth=0.7, linestyle=(0, (5, 4))))


def _points(axes: Axes, incident: Array, exitant: Array, values: Array, scale: Scale) -> None:
    _disk(axes)
    # Bright points last, so that peaks are seen.
    order = np.argsort(values)
    seen = np.maximum(values[order], scale.low)
    size = float(np.clip(9000.0 / len(values), 1.5, 26.0))
    colors = scale.colors(LogNorm(scale.low, scale.high)(seen))
    colors[values[order] <= 0.0] = _zero()
    axes.scatter(exitant[order, 0], exitant[order, 1], s=size, c=colors, linewidths=0)
    x, y, z = incident
    axes.plot(-x, -y, "x", color="#b5452c", markersize=7, markeredgewidth=1.3)
    if z * exitant[0, 2] > 0.0:
        axes.plot(x, y, "o", markerfacecolor="none", markeredgecolor="#b5452c", markersize=8, markeredgewidth=1.3)
    theta, phi = np.degrees(np.arctan2(np.hypot(x, y), z)), np.degrees(np.arctan2(y, x)) % 360
    name = _NAMES[1 if z > 0 else -1, 1 if exitant[0, 2] > 0 else -1]
    axes.text(0, 1.06, f"θ {theta:.4g}° φ {phi:.4g}°  {name}", fontsize=9, color=INK, ha="center", va="bottom")


def _zero() -> tuple[float, float, float, float]:
    red, green, blue = (int(ZERO[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return red, green, blue, 1.0
