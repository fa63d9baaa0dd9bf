"""BSDFs as arrays of pixels; nothing here draws.

Enters a :class:`bsdftree.Bsdf`, leaves an array [1/sr] whose row 0 is the top of the picture; NaN is no direction.
In every mosaic a pixel's place follows the Shirley-Chiu map (JGT 2(3), 1997) of the direction in which the light
**heads**: a tile's place that of the incident light (so the negative of the incident vector), the place inside a tile
that of the light that leaves. Light that goes straight on, or is mirrored, therefore keeps its place.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree import Bsdf, Matrix, Tree
from bsdftree._directions import direction_from_square
from bsdftree.plot._parts import SIDES, band_of, parts_of

Array = NDArray[np.float64]
# A uniform grid of 2^24 values, 64 MB, is the finest that is worth making for a picture.
_LOG2_GRID = 24
# Finest squares over which a Klems matrix, whose patches have no grid, is evaluated.
_LOG2_KLEMS = 5


class Tiles(NamedTuple):
    """Tiles, one for each incident cell.

    ``theta_deg`` are the bounds of the incident polar angle of each tile in reading order, for rank 3 only.
    """

    pixels: Array
    columns: int
    rows: int
    theta_deg: list[tuple[float, float]] | None


def mosaic_image(
    bsdf: Bsdf, part: str, *, band: str | None = None, log2_res: int | None = None, max_px: int = 2048
) -> Array:
    """All values of a component as one mosaic: a tile for each incident cell, in it all exitant cells.

    Rank 4: tile column and row are the Shirley-Chiu square of the direction in which the incident light heads, x to
    the right and y up; inside a tile the same for the light that leaves. Rank 3: one tile for each incident polar
    angle, from normal to grazing in reading order, with the incident light heading to the right. Klems matrices: as
    rank 4, with the values at the centres of the cells.

    Parameters
    ----------
    bsdf, part, band
        The component, e.g. ``"reflection_back"``, and its spectral band; by default ``Visible``.
    log2_res
        Up to 2^log2_res incident cells per axis, by default up to 2^5. Coarser cells are means.
    max_px
        Largest number of pixels along an edge; the exitant cells become means to fit in.

    Returns
    -------
    ndarray
        [1/sr], row 0 at the top.

    Raises
    ------
    ValueError
        If there is no such part or band, or ``log2_res`` leaves no pixel for a tile.
    """
    band = band_of(bsdf, band)
    (part,) = parts_of(bsdf, part, band)
    return tiles_of(bsdf, part, band, log2_res, max_px).pixels


def tiles_of(bsdf: Bsdf, part: str, band: str, log2_res: int | None, max_px: int) -> Tiles:
    """:func:`mosaic_image` with what is needed to label it."""
    component = bsdf.components_of(band)[part]
    depth = component.depth if isinstance(component, Tree) else _LOG2_KLEMS
    rank = component.rank if isinstance(component, Tree) else 4
    log2_incident = min(depth, 5 if log2_res is None else log2_res, _LOG2_GRID // rank)
    if rank == 3:
        log2_incident = max(log2_incident, 1)  # only the half at and below ½ is used
    # Columns of tiles: all of the incident square, or what makes a row of 2^(N-1) polar angles about square.
    log2_columns = log2_incident if rank == 4 else log2_incident // 2
    log2_exitant = min(depth, _LOG2_GRID // rank, max_px.bit_length() - 1 - log2_columns)
    if log2_incident < 0 or log2_exitant < 0:
        raise ValueError(f"no room for 2^{log2_columns} tiles along {max_px} pixels; give a smaller log2_res")
    if isinstance(component, Matrix):
        return _mosaic_of_matrix(bsdf, part, band, log2_incident, log2_exitant)
    return _mosaic_of_tree(component, log2_incident, log2_exitant)


def _mosaic_of_tree(tree: Tree, log2_incident: int, log2_exitant: int) -> Tiles:
    grid = tree.to_grid(max(log2_incident, log2_exitant)).astype(np.float64)
    n, m = 1 << log2_incident, 1 << log2_exitant
    if tree.rank == 4:
        return Tiles(_rank4_pixels(_means(grid, (n, n, m, m))), n, n, None)
    tiles = _means(grid, (n, m, m))[: n // 2][::-1]  # from normal to grazing
    columns = 1 << (log2_incident // 2)
    rows = n // 2 // columns
    # (tile row, tile column, exitant x, exitant y) to rows from the top and columns.
    pixels = tiles.reshape(rows, columns, m, m)[..., ::-1].transpose(0, 3, 1, 2).reshape(rows * m, columns * m)
    edges = np.degrees(np.arcsin(np.linspace(0.0, 1.0, n // 2 + 1)))
    return Tiles(pixels, columns, rows, [(float(a), float(b)) for a, b in pairwise(edges)])


def _mosaic_of_matrix(bsdf: Bsdf, part: str, band: str, log2_incident: int, log2_exitant: int) -> Tiles:
    n, m = 1 << log2_incident, 1 << log2_exitant
    sides = SIDES[part]
    heading_in, heading_out = ((np.arange(k) + 0.5) / k for k in (n, m))
    incident = -direction_from_square(heading_in[:, None], heading_in, -sides.incident)
    exitant = direction_from_square(heading_out[:, None], heading_out, sides.exitant)
    values = bsdf.eval(incident[:, :, None, None], exitant, band=band)
    return Tiles(_rank4_pixels(values), n, n, None)


def _rank4_pixels(grid: Array) -> Array:
    """Incident x, y, exitant x, y to rows from the top and columns."""
    n, m = grid.shape[0], grid.shape[2]
    return grid.transpose(1, 3, 0, 2)[::-1, ::-1].reshape(n * m, n * m)


def _means(grid: Array, shape: tuple[int, ...]) -> Array:
    """Block means down to a shape that divides the grid's."""
    for axis, n in enumerate(shape):
        blocks = (*grid.shape[:axis], n, grid.shape[axis] // n, *grid.shape[axis + 1 :])
        grid = grid.reshape(blocks).mean(axis=axis + 1)
    return grid


def matrix_image(matrix: Matrix, max_px: int) -> Array:
    """A Klems matrix, incident patch to the right, exitant patch downwards; means of k × k if over ``max_px``."""
    values = matrix.values.T.astype(np.float64)
    k = -(-max(values.shape) // max_px)
    if k == 1:
        return values
    padded = np.pad(values, [(0, -size % k) for size in values.shape], constant_values=np.nan)
    rows, columns = (size // k for size in padded.shape)
    means: Array = np.nanmean(padded.reshape(rows, k, columns, k), axis=(1, 3))
    return means


def hemisphere_image(
    bsdf: Bsdf, incident: ArrayLike, side: float, band: str, n_px: int, *, color: bool = False
) -> Array:
    """Values for all directions of one side as an orthographic disk, X to the right and Y up; NaN outside of it.

    (n_px, n_px), or with ``color`` CIE X, Y, Z, (n_px, n_px, 3).
    """
    step = (np.arange(n_px) + 0.5) / n_px * 2.0 - 1.0
    x, y = np.meshgrid(step, -step)
    inside = x**2 + y**2 < 1.0
    z = side * np.sqrt(1.0 - x[inside] ** 2 - y[inside] ** 2)
    pixels = np.full((n_px, n_px, 3) if color else (n_px, n_px), np.nan)
    pixels[inside] = bsdf.eval(incident, np.stack([x[inside], y[inside], z], axis=-1), color=color, band=band)
    return pixels
