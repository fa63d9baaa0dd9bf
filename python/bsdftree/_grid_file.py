"""Files of grids: all values one after the other, the last axis fastest, as NumPy and rttree_reduce have them.

In: paths. Out: arrays of 3 or 4 axes that lie in the file where that can be, so that large ones need no memory.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bsdftree._reduce import as_grid

ENDINGS = {".npy": None, ".f32": "float", ".flt": "float", ".f64": "double", ".dbl": "double"}
"""Endings of files that are grids, and the numbers in them; those of .npy are said in it."""

_BYTES = {"float": 4, "double": 8}


def is_grid(path: str) -> bool:
    """Whether the name of a file is one of a grid."""
    return Path(path).suffix.lower() in ENDINGS


def read_grid(path: str, rank: int, numbers: str | None = None) -> NDArray[Any]:
    """Return the values in a file.

    Parameters
    ----------
    path
        Of a file of NumPy's (.npy), of bare numbers with the lowest byte first, or of text; what precedes an empty
        line is skipped if it begins as Radiance's files do.
    rank
        3 or 4.
    numbers
        ``"float"``, ``"double"`` or ``"ascii"``; by default what the ending says.

    Raises
    ------
    ValueError
        If the file is not that, or has not (2^N)^rank values.
    """
    numbers = numbers or ENDINGS[Path(path).suffix.lower()]
    try:
        if numbers is None:
            return _numpy_grid(path, rank)
        start = _start(path)
        return as_grid(_text(path, start) if numbers == "ascii" else _mapped(path, start, numbers), rank)
    except ValueError as error:
        kind = f"as {numbers}, for" if numbers else "for"
        raise ValueError(f"{path}: {error}; {kind} a tree of rank {rank}") from None


def _numpy_grid(path: str, rank: int) -> NDArray[Any]:
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
        raise ValueError(f"{getattr(array, 'dtype', 'not an array')}; expected an array of real numbers")
    if array.ndim in (3, 4) and array.ndim != rank:
        raise ValueError(f"an array of {array.ndim} axes; give --rank {array.ndim}")
    return array if array.ndim == rank else as_grid(array, rank)


def _start(path: str) -> int:
    """Where values begin: after Radiance's header, if there is one."""
    with open(path, "rb") as file:
        head = file.read(1 << 16)
    if not head.startswith(b"#?"):
        return 0
    end = head.find(b"\n\n")
    if end < 0:
        raise ValueError("a header without an empty line and values after it")
    return end + 2


def _mapped(path: str, start: int, numbers: str) -> NDArray[Any]:
    size, n_bytes = _BYTES[numbers], Path(path).stat().st_size - start
    if n_bytes == 0 or n_bytes % size:
        raise ValueError(f"{n_bytes} bytes of values; expected a multiple of {size}")
    mapped: NDArray[Any] = np.memmap(path, np.dtype(f"<f{size}"), "r", offset=start)
    return mapped if sys.byteorder == "little" else mapped.astype(f"=f{size}")


def _text(path: str, start: int) -> NDArray[np.float64]:
    data = Path(path).read_bytes()[start:].replace(b",", b" ")
    try:
        with warnings.catch_warnings():
            # Older NumPy warns where newer fails.
            warnings.simplefilter("error")
            return np.fromstring(data, np.float64, sep=" ")
    except (ValueError, DeprecationWarning):
        raise ValueError(_first_wrong(data)) from None


def _first_wrong(text: bytes) -> str:
    for index, word in enumerate(text.split()):
        try:
            float(word)
        except ValueError:
            return f"value {index} is {word[:40].decode(errors='replace')!r}; expected a number"
    return "text that is no row of numbers"
