"""Directions as arrays of unit vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Directions = NDArray[np.float64]


def direction_from_polar(theta_deg: ArrayLike, phi_deg: ArrayLike) -> Directions:
    """Unit vectors from polar angles and azimuths.

    Parameters
    ----------
    theta_deg
        Angle from +Z [degree], over 90 on the back. Any shape.
    phi_deg
        Azimuth [degree], counter-clockwise from +X seen from the front. Broadcast against ``theta_deg``.

    Returns
    -------
    ndarray
        Shape (..., 3).

    Examples
    --------
    >>> direction_from_polar(90, 90).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    theta, phi = np.broadcast_arrays(np.radians(theta_deg), np.radians(phi_deg))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def polar_from_direction(direction: ArrayLike) -> NDArray[np.float64]:
    """Polar angle from +Z and azimuth in [0, 360) [degree] of vectors.

    Parameters
    ----------
    direction
        Shape (..., 3); need not be of unit length.

    Returns
    -------
    ndarray
        Shape (..., 2).

    Examples
    --------
    >>> polar_from_direction([0, -2, 0]).tolist()
    [90.0, 270.0]
    """
    x, y, z = np.moveaxis(np.asarray(direction, float), -1, 0)
    theta = np.degrees(np.arctan2(np.hypot(x, y), z))
    return np.stack([theta, np.degrees(np.arctan2(y, x)) % 360.0], axis=-1)


def as_rows(name: str, value: ArrayLike) -> tuple[Directions, tuple[int, ...]]:
    """Vectors as a C-contiguous (n, 3) array, and the shape that results have; the core makes them unit vectors.

    Raises
    ------
    ValueError
        If the last axis is not 3 long.
    """
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} has shape {array.shape}; expected (..., 3), unit vectors away from the surface")
    return np.ascontiguousarray(array.reshape(-1, 3)), array.shape[:-1]


def as_pairs(incident: ArrayLike, exitant: ArrayLike) -> tuple[Directions, Directions, tuple[int, ...]]:
    """Both directions of each pair, broadcast against each other."""
    i, shape_i = as_rows("incident", incident)
    o, shape_o = as_rows("exitant", exitant)
    if shape_i == shape_o:
        return i, o, shape_i
    try:
        shape = np.broadcast_shapes(shape_i, shape_o)
    except ValueError:
        raise ValueError(
            f"incident has shape {(*shape_i, 3)} and exitant {(*shape_o, 3)}; they do not broadcast"
        ) from None
    rows = [
        np.ascontiguousarray(np.broadcast_to(a.reshape(*s, 3), (*shape, 3)).reshape(-1, 3))
        for a, s in ((i, shape_i), (o, shape_o))
    ]
    return rows[0], rows[1], shape


def direction_from_square(x: ArrayLike, y: ArrayLike, side: float = 1.0) -> Directions:
    """Unit vectors on one side of the surface from points of the Shirley-Chiu square [0, 1]², (..., 3)."""
    a, b = np.broadcast_arrays(2.0 * np.asarray(x, float) - 1.0, 2.0 * np.asarray(y, float) - 1.0)
    along_x = np.abs(a) > np.abs(b)
    radius = np.where(along_x, a, b)
    ratio = np.divide(np.where(along_x, b, a), radius, out=np.zeros_like(radius), where=radius != 0.0)
    phi = np.where(along_x, 0.25 * np.pi * ratio, 0.25 * np.pi * (2.0 - ratio))
    # A negative radius is the opposite sector.
    disk_x, disk_y = radius * np.cos(phi), radius * np.sin(phi)
    return np.stack([disk_x, disk_y, side * np.sqrt(np.maximum(1.0 - radius**2, 0.0))], axis=-1)
