"""Polar maps: all exitant directions of an incident direction, as two disks."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from bsdftree import Bsdf, direction_from_polar, polar_from_direction
from bsdftree._queries import Part
from bsdftree.plot._image import hemisphere_image
from bsdftree.plot._parts import OUTSIDE, ROOM, band_of, heading_of, scatters
from bsdftree.plot._style import INK, Scale, bare, figure

Array = NDArray[np.float64]
_THETA_DEG = np.array([0.0, 30.0, 60.0])
# Pixels of a small disk.
_SMALL = 250


def polar(
    bsdf: Bsdf,
    incident: ArrayLike | None = None,
    *,
    band: str | None = None,
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    color: bool = False,
    title: str | None = None,
) -> Figure:
    """Draw polar maps of where light from some directions goes: a disk of exitant directions for each side.

    The disks are orthographic (a direction's x and y, so equal areas are equal projected solid angles) and both as
    seen from the room, X to the right and Y up. A circle marks where the light comes from, on its side; a cross marks
    straight on and mirrored.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    incident
        Unit vector away from the surface, (3,), for two large disks; (n, 3) for a column of two disks each. By default
        0, 30 and 60 degrees from above, from each side from which light is scattered.
    band
        Spectral band; ``Visible`` or the only one by default.
    limits
        Smallest and largest value [1/sr] of the colour scale; by default round numbers around the values.
    colors
        Name of a matplotlib colour map. Zero is dark grey in all of them.
    color
        Draw the hues of the light instead of a colour map, and its luminance as lightness. Without colour all is grey.
    title
        Heading; the name of the product by default.

    Raises
    ------
    ValueError
        If ``incident`` is not of vectors with a direction, or there is no such band.
    """
    band = band_of(bsdf, band)
    vectors = unit_vectors(default_incident(bsdf, band) if incident is None else incident)
    heading = heading_of(bsdf, band, title)
    if vectors.ndim == 1:
        images = _images(bsdf, vectors, band, 700, color)
        return _large(bsdf, vectors, band, images, _scale(images, limits, colors), heading)
    maps = [_images(bsdf, v, band, 2 * _SMALL, color) for v in vectors]
    return _many(bsdf, vectors, band, maps, _scale([m for both in maps for m in both], limits, colors), heading)


def _images(bsdf: Bsdf, vector: Array, band: str, n_px: int, color: bool) -> list[Array]:
    """Maps of both sides."""
    return [hemisphere_image(bsdf, vector, side, band, n_px, color=color) for side in (ROOM, OUTSIDE)]


def _scale(images: list[Array], limits: tuple[float, float] | None, colors: str) -> Scale:
    """One scale for all maps: of the luminance, if they have colours."""
    if images[0].ndim == 2:
        return Scale.of(images, limits, colors)
    return Scale.of([image[..., 1] for image in images], limits, colors).in_color()


def default_incident(bsdf: Bsdf, band: str) -> Array:
    """From above, from each side that matters."""
    sides = [side for side in (ROOM, OUTSIDE) if scatters(bsdf, side, band)] or [ROOM]
    return np.concatenate([direction_from_polar(_THETA_DEG, 90.0) * [1.0, 1.0, side] for side in sides])


def unit_vectors(incident: ArrayLike) -> Array:
    """One direction (3,) or several (n, 3), as unit vectors."""
    vectors = np.asarray(incident, float)
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if vectors.shape[-1:] != (3,) or vectors.ndim > 2 or not (np.isfinite(lengths).all() and lengths.all()):
        raise ValueError(f"incident is {np.asarray(incident).tolist()}; expected unit vectors away from the surface")
    return np.asarray(vectors / lengths, float)


def _large(bsdf: Bsdf, vector: Array, band: str, images: list[Array], scale: Scale, heading: str) -> Figure:
    """Two large disks."""
    picture = figure(1640, 880)
    for k, (image, side, name) in enumerate(zip(images, (ROOM, OUTSIDE), ("room", "outside"), strict=True)):
        kind = "reflection" if side * vector[2] > 0.0 else "transmission"
        axes = picture.add_axes(((40 + 750 * k) / 1640, 50 / 880, 720 / 1640, 720 / 880))
        _draw_disk(axes, image, scale, vector, side)
        total = float(bsdf.hemispherical(vector, kind, band=band))  # type: ignore[arg-type]
        axes.text(-1.1, 1.12, f"To the {name}: {kind} {100.0 * total:.2f} %", fontsize=13, color=INK, va="bottom")
    legend = "Seen from the room.  ○ where the light comes from   × straight on, or mirrored"
    picture.text(30 / 1640, 22 / 880, legend, fontsize=10, va="center", color=INK)
    text = f"{heading}   light from {angles(vector)}".strip()
    picture.text(30 / 1640, 1.0 - 34 / 880, text, fontsize=15, va="center", color=INK)
    scale.bar(picture, (1545 / 1640, 110 / 880, 22 / 1640, 600 / 880))
    return picture


def angles(vector: Array) -> str:
    """θ, φ and side of a direction, in words."""
    theta, phi = polar_from_direction(vector)
    # At a normal azimuth means nothing.
    azimuth = "" if np.hypot(vector[0], vector[1]) < 1e-6 else f", φ {phi:.4g}°"
    return f"θ {theta:.4g}°{azimuth} ({'room' if vector[2] > 0.0 else 'outside'})"


def _many(bsdf: Bsdf, vectors: Array, band: str, images: list[list[Array]], scale: Scale, heading: str) -> Figure:
    """A column of two small disks for each direction, at most six columns beside each other."""
    columns = min(len(vectors), 6)
    rows = -(-len(vectors) // columns)
    block = 2 * _SMALL + 106
    width, height = max(70 + columns * (_SMALL + 14) + 120, 760), 66 + rows * block + 24
    picture = figure(width, height)
    picture.text(30 / width, 1.0 - 30 / height, heading, fontsize=15, va="center", color=INK)
    for k, (vector, both) in enumerate(zip(vectors, images, strict=True)):
        x, top = 62 + (k % columns) * (_SMALL + 14), 66 + (k // columns) * block
        at = (x + 0.5 * _SMALL) / width
        picture.text(at, 1 - (top + 8) / height, f"from {angles(vector)}", fontsize=11, ha="center", color=INK)
        for row, (image, side, name) in enumerate(zip(both, (ROOM, OUTSIDE), ("room", "outside"), strict=True)):
            y = top + 20 + row * (_SMALL + 34)
            axes = picture.add_axes((x / width, 1 - (y + _SMALL) / height, _SMALL / width, _SMALL / height))
            draw_map(axes, image, scale, vector, side)
            kind: Part = "reflection" if side * vector[2] > 0.0 else "transmission"
            total = float(bsdf.hemispherical(vector, kind, band=band))
            text = f"{kind} {100.0 * total:.2f} %"
            picture.text(at, 1 - (y + _SMALL + 12) / height, text, fontsize=9.5, ha="center", va="center", color=INK)
            if k % columns == 0:
                y_middle = 1 - (y + 0.5 * _SMALL) / height
                picture.text(
                    34 / width, y_middle, f"to the {name}", fontsize=11, rotation=90, ha="center", va="center",
                    color=INK,
                )  # fmt: skip
    legend = (
        "Seen from the room, X to the right, Y up; dashed: θ 30° and 60°.  ○ where the light comes from   "
        "× straight on, or mirrored"
    )
    text = textwrap.fill(legend, int((width - 60) / 7.0))
    picture.text(30 / width, 24 / height, text, fontsize=9.5, va="center", color=INK)
    scale.bar(picture, ((width - 92) / width, 1 - (66 + 2 * _SMALL + 20) / height, 20 / width, (2 * _SMALL) / height))
    return picture


def draw_map(axes: Axes, image: Array, scale: Scale, incident: Array, side: float) -> None:
    """A disk without words, for small pictures."""
    scale.draw(axes, image, (-1, 1, -1, 1))
    mark_map(axes, incident, side, "white", "black")


def mark_map(axes: Axes, incident: Array, side: float, color: str, halo_color: str) -> None:
    """Rim, polar angles, and where the light comes from and would go, over a disk."""
    bare(axes)
    axes.set_xlim(-1.03, 1.03)
    axes.set_ylim(-1.03, 1.03)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=INK, linewidth=0.8))
    for theta_deg in (30, 60):
        r = float(np.sin(np.radians(theta_deg)))
        axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=color, linewidth=0.6, linestyle=(0, (5, 4))))
    halo = [withStroke(linewidth=2.0, foreground=halo_color)]
    x, y, z = incident
    axes.plot(-x, -y, "x", color=color, markersize=6, markeredgewidth=1.3, path_effects=halo)
    if side * z > 0.0:
        axes.plot(
            x, y, "o", markerfacecolor="none", markeredgecolor=color, markersize=8, markeredgewidth=1.3,
            path_effects=halo,
        )  # fmt: skip


def _draw_disk(axes: Axes, image: Array, scale: Scale, incident: Array, side: float) -> None:
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
