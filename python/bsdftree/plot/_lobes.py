"""Lobes: solids as far from their middle as the BSDF is large, seen in perspective."""

from __future__ import annotations

import textwrap
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]
from numpy.typing import ArrayLike, NDArray

from bsdftree import Bsdf
from bsdftree._lobes import lobe_radii, lobe_solid, lobe_values
from bsdftree.plot._parts import band_of, heading_of
from bsdftree.plot._polar import angles, default_incident, unit_vectors
from bsdftree.plot._slice import Radius
from bsdftree.plot._style import FAINT, INK, VERMILION, Scale, figure

Array = NDArray[np.float64]
_LOG2_RES = 5
_EDGE = 380
# From where the shading light shines; of no physical meaning.
_SHADE = np.array([0.35, -0.6, 0.72])


def lobes(
    bsdf: Bsdf,
    incident: ArrayLike | None = None,
    *,
    band: str | None = None,
    radius: Radius = "log",
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    title: str | None = None,
) -> Figure:
    """Draw lobes: for each incident direction a solid of the light that leaves, the room above, outside below.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    incident
        Unit vectors away from the surface, (3,) or (n, 3). By default 0, 30 and 60 degrees from above, from each side
        from which light is scattered.
    band
        Spectral band; ``Visible`` or the only one by default.
    radius
        The distance from the middle: ``"log"`` over as many decades, up to six, as most values need, or ``"linear"``.
    limits, colors
        Of the colour scale [1/sr], as of :func:`bsdftree.plot.mosaic`.
    title
        Heading; the name of the product by default.

    Raises
    ------
    ValueError
        If a direction is none, or there is no such band or radius.

    See Also
    --------
    bsdftree.save_lobes : the same solids as a mesh
    """
    band = band_of(bsdf, band)
    if radius not in ("log", "linear"):
        raise ValueError(f"radius {radius!r}; expected 'log' or 'linear'")
    vectors = np.atleast_2d(unit_vectors(default_incident(bsdf, band) if incident is None else incident))
    sides = (1.0, -1.0)
    values = [[lobe_values(bsdf, v, side, log2_res=_LOG2_RES, band=band) for side in sides] for v in vectors]
    top = float(np.max(values))
    decades = _decades(np.array(values), top)
    scale = Scale.of([f for both in values for f in both], limits, colors)
    columns = min(len(vectors), 3)
    rows = -(-len(vectors) // columns)
    width, height = max(columns * _EDGE + 140, 720), 60 + rows * _EDGE + 40
    picture = figure(width, height)
    picture.text(30 / width, 1.0 - 30 / height, heading_of(bsdf, band, title), fontsize=15, va="center", color=INK)
    for k, (vector, both) in enumerate(zip(vectors, values, strict=True)):
        x, y = 20 + (k % columns) * _EDGE, 40 + (rows - 1 - k // columns) * _EDGE
        box = (x / width, y / height, _EDGE / width, (_EDGE - 24) / height)
        axes = picture.add_axes(box, projection="3d")
        assert isinstance(axes, Axes3D)
        _draw(axes, vector, both, scale, lambda f: lobe_radii(f, top, radius, decades))
        at = (x + 0.5 * _EDGE) / width
        text = f"light from {angles(vector)}"
        picture.text(at, (y + _EDGE - 12) / height, text, fontsize=11, ha="center", va="center", color=INK)
    bar = min(rows * _EDGE - 90, 560)
    scale.bar(picture, ((width - 92) / width, (height - 110 - bar) / height, 20 / width, bar / height))
    how = f"logarithm of the BSDF over {decades} decades" if radius == "log" else "BSDF"
    text = (
        f"Distance from the middle: {how}, the rim is {top:.3g} /sr. Room above, outside below; X right, Y to the back."
    )
    text = textwrap.fill(text, int((width - 40) / 7.4))
    picture.text(30 / width, 20 / height, text, fontsize=9.5, va="center", color=INK)
    return picture


def _decades(values: Array, top: float) -> int:
    """So many that 95 of 100 positive values are not in the middle, one to six."""
    positive = values[values > 0.0]
    return 1 if positive.size == 0 else int(np.clip(np.ceil(np.log10(top / np.quantile(positive, 0.05))), 1, 6))


def _draw(
    axes: Axes3D, incident: Array, values: list[Array], scale: Scale, radius_of: Callable[[Array], Array]
) -> None:
    polygons, colors = [], []
    for side, f in zip((1.0, -1.0), values, strict=True):
        radii = radius_of(f)
        solid = lobe_solid(radii, side)
        if not len(solid.faces):
            continue
        corners = solid.vertices[solid.faces]
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        triangle = solid.faces[:, 2] == solid.faces[:, 3]
        normal[triangle] = np.cross(
            corners[triangle, 1] - corners[triangle, 0], corners[triangle, 2] - corners[triangle, 0]
        )
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        # A face has the colour of the value at its outermost corner.
        farthest = np.linalg.norm(corners, axis=2).max(axis=1)
        order = np.argsort(radii, axis=None)
        value = np.interp(farthest, radii.ravel()[order], f.ravel()[order])
        shade = 0.72 + 0.28 * (normal @ _SHADE)
        rgba = scale.rgba(value)
        rgba[:, :3] *= shade[:, None]
        polygons.append(corners)
        colors.append(rgba)
    around = np.radians(np.arange(0, 361, 4))
    rim = np.stack([np.cos(around), np.sin(around), 0.0 * around])
    axes.add_collection3d(
        Poly3DCollection([rim.T], facecolors=[(0.6, 0.6, 0.6, 0.12)], edgecolors=FAINT, linewidths=0.8)
    )
    if polygons:
        solids = Poly3DCollection(np.concatenate(polygons), facecolors=np.concatenate(colors), linewidths=0)
        # Thousands of faces would make drawings of lines huge.
        solids.set_rasterized(True)
        axes.add_collection3d(solids)
    x, y, z = 0.98 * incident
    axes.plot([0, x], [0, y], [0, z], color=VERMILION, linewidth=1.8, zorder=10)
    for at, text in (((1.15, 0, 0), "X"), ((0, 1.15, 0), "Y"), ((0, 0, 0.98 if incident[2] < 0.6 else -0.98), "Z")):
        axes.text(*at, text if at[2] >= 0 else "−Z", fontsize=9, color=INK, ha="center", va="center")
    axes.set_xlim(-0.8, 0.8)
    axes.set_ylim(-0.8, 0.8)
    axes.set_zlim(-0.8, 0.8)
    axes.set_box_aspect((1, 1, 1), zoom=1.3)
    axes.view_init(elev=16, azim=-50)
    axes.set_axis_off()
