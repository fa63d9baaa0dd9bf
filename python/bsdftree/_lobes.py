"""Lobes as a mesh: for an incident direction, a solid whose surface is as far from the middle as the BSDF is large.

In go a BSDF and incident directions, out comes Wavefront OBJ. Cells of the Shirley-Chiu square are flat at the distance
of their mean value, with walls between them, so that nothing is smoothed over; the solid is closed. The largest value
of all lobes has the distance 1. Front is +Z: reflected and transmitted light lie above and below the plane z = 0, or
the other way round. Beside bsdf2rad, whose scenes have all incident directions, and a gigabyte and more.
"""

from __future__ import annotations

import os
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree._bsdf import Bsdf
from bsdftree._component import Matrix, Tree
from bsdftree._directions import direction_from_square, polar_from_direction
from bsdftree._whole_file import write_whole

Array = NDArray[np.float64]
LOG2_RES = 6
"""Cells per axis of a lobe, unless told otherwise: 2^6."""
DECADES = 4
"""Of a logarithmic radius: values that much below the largest are in the middle."""
_LOG2_CUT = 9
APART = 2.5
"""Between the middles of lobes."""


class Lobe(NamedTuple):
    """The solid of one side of the surface, round the origin.

    ``vertices`` is (n, 3), ``faces`` (m, 4): numbers of vertices, counter-clockwise seen from without. A triangle has
    its last vertex twice.
    """

    vertices: Array
    faces: NDArray[np.int64]


def lobe_values(
    bsdf: Bsdf, incident: ArrayLike, side: float, *, log2_res: int = LOG2_RES, band: str = "Visible"
) -> Array:
    """Return the BSDF [1/sr] of the cells of a square of exitant directions, (2^log2_res, 2^log2_res), x first.

    Parameters
    ----------
    incident
        Unit vector away from the surface, (3,).
    side
        Where the light goes: 1 for the room, -1 for the outside.
    log2_res, band
        Cells per axis, 2^log2_res; each is the mean of what is finer.
    """
    n = 1 << log2_res
    finest = max((_log2_points(f) for f in bsdf.components_of(band).values()), default=0)
    finer = 1 << max(0, finest - log2_res)
    at = (np.arange(n * finer) + 0.5) / (n * finer)
    means = np.empty((n, n))
    # A row of cells at a time: finest trees have 2^20 directions and more.
    for k in range(n):
        x = at[k * finer : (k + 1) * finer]
        values = bsdf.eval(np.asarray(incident, float), direction_from_square(x[:, None], at, side), band=band)
        means[k] = values.reshape(finer, n, finer).mean((0, 2))
    return means


def _log2_points(function: Tree | Matrix) -> int:
    """How finely to look: cells of rank 4 lie in ours or hold them, patches and turned cells are cut by them."""
    if isinstance(function, Tree):
        return function.depth if function.rank == 4 else max(function.depth + 2, _LOG2_CUT)
    return _LOG2_CUT


def lobe_solid(radii: ArrayLike, side: float) -> Lobe:
    """Make a solid of radii of the cells of a square of directions (n, n), on one side of the surface."""
    radii = np.asarray(radii, float)
    n = len(radii)
    edges = np.arange(n + 1) / n
    corners = direction_from_square(edges[:, None], edges, side)
    # The four corners of each cell, counter-clockwise seen from without, and the cell beyond each edge.
    turns = [(0, 0), (1, 0), (1, 1), (0, 1)] if side > 0 else [(0, 0), (0, 1), (1, 1), (1, 0)]
    beyond = [(0, -1), (1, 0), (0, 1), (-1, 0)] if side > 0 else [(-1, 0), (0, 1), (1, 0), (0, -1)]
    around = np.stack([corners[i : i + n, j : j + n] for i, j in turns], axis=2)
    vertices = [np.zeros((1, 3)), (around * radii[:, :, None, None]).reshape(-1, 3)]
    first = 1 + 4 * np.arange(n * n).reshape(n, n)
    faces = [(first[:, :, None] + np.arange(4))[radii > 0]]
    padded = np.pad(radii, 1)
    n_vertices = 1 + 4 * n * n
    for k, (i, j) in enumerate(beyond):
        low = padded[1 + i : 1 + i + n, 1 + j : 1 + j + n]
        wall = radii > low
        a, b = first[wall] + k, first[wall] + (k + 1) % 4
        feet = around[wall][:, [k, (k + 1) % 4]] * low[wall][:, None, None]
        # A wall that reaches the middle is a triangle.
        number = n_vertices + 2 * np.arange(len(a))
        foot_a, foot_b = (np.where(low[wall] > 0, number + m, 0) for m in (0, 1))
        faces.append(np.stack([b, a, foot_a, foot_b], axis=1))
        vertices.append(feet.reshape(-1, 3))
        n_vertices += 2 * len(a)
    return _compact(Lobe(np.concatenate(vertices), np.concatenate(faces)))


def _compact(lobe: Lobe) -> Lobe:
    """Leave out vertices that no face has."""
    used, faces = np.unique(lobe.faces, return_inverse=True)
    return Lobe(lobe.vertices[used], faces.reshape(lobe.faces.shape))


def save_lobes(
    path: str | os.PathLike[str],
    bsdf: Bsdf,
    incident: ArrayLike,
    *,
    band: str | None = None,
    log2_res: int = LOG2_RES,
    radius: Literal["log", "linear"] = "log",
) -> float:
    """Write the lobes of incident directions as Wavefront OBJ, one beside the other along X.

    Parameters
    ----------
    path
        The file; it is replaced when it is complete.
    bsdf
        Trees or matrices.
    incident
        Unit vectors away from the surface, (3,) or (n, 3). A slender pyramid, ``light``, points from there.
    band
        ``Visible`` or the only one by default.
    log2_res
        2^log2_res cells per axis of each hemisphere; finer data is averaged.
    radius
        The distance from the middle: the value, or its logarithm over four decades.

    Returns
    -------
    float
        The value [1/sr] that is 1 from the middle; 0 if nothing is scattered.

    Raises
    ------
    ValueError
        If there is no such band, or a direction is none.

    Notes
    -----
    Objects are named by θ and φ of the light; materials are ``reflection``, ``transmission`` and ``light``.
    """
    if radius not in ("log", "linear"):
        raise ValueError(f"radius {radius!r}; expected 'log' or 'linear'")
    if not 1 <= log2_res <= 10:
        raise ValueError(f"log2_res {log2_res}; expected 1 to 10")
    if band is None:
        band = "Visible" if "Visible" in bsdf.bands or not bsdf.bands else bsdf.bands[0]
    vectors = np.atleast_2d(np.asarray(incident, float))
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if vectors.ndim != 2 or vectors.shape[1] != 3 or not (np.isfinite(lengths).all() and lengths.all()):
        raise ValueError(f"incident is {np.asarray(incident).tolist()}; expected unit vectors away from the surface")
    vectors = vectors / lengths
    sides = (1.0, -1.0)
    values = [[lobe_values(bsdf, v, side, log2_res=log2_res, band=band) for side in sides] for v in vectors]
    top = float(np.max(values))
    lines = [f"# {' '.join(bsdf.name.split())}: {radius} radius, 1 is {top:g}/sr; front, the room, is +Z"]
    n_vertices = 0
    for k, (vector, of_sides) in enumerate(zip(vectors, values, strict=True)):
        theta, phi = polar_from_direction(vector)
        middle = np.array([APART * k, 0.0, 0.0])
        solids = [("light", _pyramid(vector))]
        for side, f in zip(sides, of_sides, strict=True):
            what = "reflection" if side * vector[2] > 0 else "transmission"
            solids.append((what, lobe_solid(lobe_radii(f, top, radius), side)))
        for what, solid in solids:
            if len(solid.faces):
                lines.append(f"o {what}_{theta:g}_{phi:g}\nusemtl {what}")
                lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in (solid.vertices + middle).tolist()]
                lines += [_face(face) for face in (solid.faces + 1 + n_vertices).tolist()]
                n_vertices += len(solid.vertices)
    write_whole(path, ("\n".join(lines) + "\n").encode())
    return top


def lobe_radii(values: Array, top: float, radius: str, decades: float = DECADES) -> Array:
    """Distances from the middle of values, 1 for the largest of all, ``top``; ``radius`` is log or linear."""
    if top == 0.0:
        return values
    if radius == "linear":
        return values / top
    # Values below all decades are in the middle.
    radii: Array = 1 + np.log10(np.maximum(values / top, 10.0**-decades)) / decades
    return radii


def _face(numbers: list[int]) -> str:
    a, b, c, d = numbers
    return f"f {a} {b} {c}" if c == d else f"f {a} {b} {c} {d}"


def _pyramid(direction: Array) -> Lobe:
    """A sign of where the light comes from: its tip is at 1.05."""
    other = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    u = np.cross(direction, other)
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    base = [1.3 * direction + 0.03 * (a * u + b * v) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    sides = [[(k + 1) % 4, k, 4, 4] for k in range(4)]
    return Lobe(np.array([*base, 1.05 * direction]), np.array([[0, 1, 2, 3], *sides]))
