"""Radiance's matrix files as arrays."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree import _core


def read_radiance_matrix(path: str | os.PathLike[str]) -> NDArray[np.float64]:
    """Read a matrix that rmtxop, rcomb or dctimestep has written.

    Parameters
    ----------
    path
        A file whose header has NROWS, NCOLS, NCOMP and FORMAT (ascii, float or double).

    Returns
    -------
    ndarray
        Shape (rows, columns, components).

    Raises
    ------
    ValueError
        If it is no such file, or values are missing; the message says where.
    OSError
        If it cannot be read.
    """
    try:
        return _core.read_radiance_matrix(Path(path).read_bytes())
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)}: {error}") from None


def write_radiance_matrix(
    path: str | os.PathLike[str], values: ArrayLike, format: Literal["ascii", "float", "double"] = "float"
) -> None:
    """Write a matrix for rmtxop, rcomb or dctimestep.

    Parameters
    ----------
    path
        The file; it is replaced when it is complete.
    values
        Shape (rows, columns) or (rows, columns, components).
    format
        How values are written.

    Raises
    ------
    ValueError
        If the array has another number of axes.
    OSError
        If it cannot be written.
    """
    array = np.asarray(values, np.float64)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or not array.size:
        raise ValueError(f"an array of shape {array.shape}; expected (rows, columns) or (rows, columns, components)")
    _core.write_radiance_matrix(os.fspath(path), np.ascontiguousarray(array), format)
