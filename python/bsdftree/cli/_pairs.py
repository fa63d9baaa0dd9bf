"""Pairs of directions from standard input, as text or as Radiance's binary numbers, block by block."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bsdftree import direction_from_polar

Array = NDArray[np.float64]
BINARY = {"f": np.float32, "d": np.float64}
BLOCK = 1 << 16
"""Pairs that are held at once."""


def width_of(vectors: bool) -> int:
    """Numbers of a pair: angles of two directions, or two vectors."""
    return 6 if vectors else 4


def blocks(letter: str, vectors: bool) -> Iterator[Array]:
    """Pairs of standard input, (n, 4) or (n, 6) each.

    Raises
    ------
    ValueError
        If a line, or the last pair, has too few or too many numbers.
    """
    width = width_of(vectors)
    what = "six components of two vectors" if vectors else "four angles in degrees"
    return _text(width, what) if letter == "a" else _binary(np.dtype(BINARY[letter]), width, what)


def directions(pairs: Array, vectors: bool) -> tuple[Array, Array]:
    """Incident and exitant unit vectors of pairs.

    Raises
    ------
    ValueError
        If a vector has no direction.
    """
    if not vectors:
        return direction_from_polar(pairs[:, 0], pairs[:, 1]), direction_from_polar(pairs[:, 2], pairs[:, 3])
    both = pairs.reshape(-1, 2, 3)
    length = np.linalg.norm(both, axis=2, keepdims=True)
    bad = ~(np.isfinite(length) & (length > 0)).all((1, 2))
    if bad.any():
        raise ValueError(f"vectors {pairs[bad][0].tolist()}; expected finite ones that are not 0")
    both = both / length
    return both[:, 0], both[:, 1]


def _text(width: int, what: str) -> Iterator[Array]:
    numbers: list[float] = []
    for number, line in enumerate(sys.stdin, 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        if len(words) != width:
            raise ValueError(f"standard input, line {number}: {len(words)} numbers; expected {what}")
        try:
            numbers += [float(w) for w in words]
        except ValueError:
            raise ValueError(f"standard input, line {number}: {line.strip()!r}; expected {what}") from None
        if len(numbers) == BLOCK * width:
            yield np.reshape(numbers, (-1, width))
            numbers = []
    if numbers:
        yield np.reshape(numbers, (-1, width))


def _binary(dtype: np.dtype[Any], width: int, what: str) -> Iterator[Array]:
    size = dtype.itemsize * width
    done = 0
    while data := sys.stdin.buffer.read(BLOCK * size):
        if len(data) % size:
            raise ValueError(
                f"standard input ends {len(data) % size} bytes after pair {done + len(data) // size}; expected {what},"
                f" {size} bytes"
            )
        done += len(data) // size
        yield np.frombuffer(data, dtype).reshape(-1, width).astype(np.float64)
