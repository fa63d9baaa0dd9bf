"""All exitant directions of one incident direction, as two disks."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from bsdftree import Bsdf, polar_from_direction
from bsdftree.plot._image import hemisphere_image
from bsdftree.plot._parts import OUTSIDE, ROOM, band_of
from bsdftree.plot._style import INK, Scale, bare, figure


def hemisphere(
    bsdf: Bsdf,
    incident: ArrayLike,
    *,
    band: str | None = None,
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    title: str | None = None,
) -> Figure:
    """Draw where light from one direction goes: a disk of exitant directions for each side.

    The disks are orthographic (a direction's x and y, so equal areas are equal projected solid angles) and both as
    seen from the room, X to the right and Y up. A circle marks where the light comes from, on its side; a cross marks
    straight on and mirrored.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    incident
        Unit vector away from the surface, (3,).
    band
        Spectral band; ``Visible`` or the only one by default.
    limits
        Smallest and largest value [1/sr] of the colour scale; by default round numbers around the values.
    colors
        Name of a matplotlib colour map. Zero is dark grey in all of them.
    title
        Heading; the name of the product by default.

    Raises
    ------
    ValueError
        If ``incident`` is not one vector with a direction, or there is no such band.
    """
    band = band_of(bsdf, band)
    vector = np.asarray(incident, float)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
        raise ValueError(f"incident is {np.asarray(incident).tolist()}; expected one unit vector away from the surface")
    vector = vector / np.linalg.norm(vector)
    images = [hemisphere_image(bsdf, vector, side, band, 700) for side in (ROOM, OUTSIDE)]
    scale = Scale.of(images, limits, colors)
    picture = figure(1640, 880)
    for k, (image, side, name) in enumerate(zip(images, (ROOM, OUTSIDE), ("room", "outside"), strict=True)):
        kind = "reflection" if side * vector[2] > 0.0 else "transmission"
        axes = picture.add_axes(((40 + 750 * k) / 1640, 50 / 880, 720 / 1640, 720 / 880))
        _draw_disk(axes, image, scale, vector, side)
        total = float(bsdf.hemispherical(vector, kind, band=band))  # type: ignore[arg-type]
        axes.text(-1.1, 1.12, f"To the {name}: {kind} {100.0 * total:.2f} %", fontsize=13, color=INK, va="bottom")
    legend = "Seen from the room.  ○ where the light comes from   × straight on, or mirrored"
    picture.text(30 / 1640, 22 / 880, legend, fontsize=10, va="center", color=INK)
    theta, phi = polar_from_direction(vector)
    heading = bsdf.name if title is None else title
    of_band = f"  ({band})" if len(bsdf.bands) > 1 else ""
    side_name = "room" if vector[2] > 0.0 else "outside"
    text = f"{heading}{of_band}   light from θ {theta:g}°, φ {phi:g}° ({side_name})".strip()
    picture.text(30 / 1640, 1.0 - 34 / 880, text, fontsize=15, va="center", color=INK)
    scale.bar(picture, (1545 / 1640, 110 / 880, 22 / 1640, 600 / 880))
    return picture


def _draw_disk(
    axes: Axes, image: NDArray[np.float64], scale: Scale, incident: NDArray[np.float64], side: float
) -> None:
    scale.draw(axes, image, (-1, 1, -1, 1))
    bare(axes)
    axes.set_xlim(-1.16, 1.16)
    axes.set_ylim(-1.16, 1.16)
    halo = [withStroke(linewidth=2.2, foreground="black")]
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=INK, linewidth=1.0))
    for theta_deg in (30, 60):
        r = float(np.sin(np.radians(theta_deg)))
        axes.add_patch(Circle((0, 0), r, fill=False, edgecolor="white", linewidth=0.9, linestyle=(0, (5, 4))))
        s = r * np.sqrt(0.5)
        axes.text(s, s, f"{theta_deg}°", color="white", fontsize=10, ha="center", va="center", path_effects=halo)
    for x, y, text, rotation in (
        (1.07, 0, "φ 0°  right", 270),
        (0, 1.07, "φ 90°  up ↑", 0),
        (-1.07, 0, "φ 180°  left", 90),
        (0, -1.07, "φ 270°  down", 0),
    ):
        axes.text(x, y, text, fontsize=10, color=INK, ha="center", va="center", rotation=rotation)
    x, y, z = incident
    axes.plot(-x, -y, "x", color="white", markersize=9, markeredgewidth=1.6, path_effects=halo)
    if side * z > 0.0:
        axes.plot(
            x, y, "o", markerfacecolor="none", markeredgecolor="white", markersize=11, markeredgewidth=1.6,
            path_effects=halo,
        )  # fmt: skip
