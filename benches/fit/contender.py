"""Who is judged: something that answers pairs of directions, perhaps with an error, and the CPU time that it took.

CPU time of all threads, and of all programs: wall time depends on who else uses the machine.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import bsdftree

from . import incumbent
from .formulas import Array, Function
from .gonio import Scan

TOLERANCE = 0.0
"""Of our trees, which are compared with trees that are not culled."""


@dataclass(frozen=True)
class Contender:
    """`evaluate(incident (n, 3), exitant (n, 3)) -> (n,)` [1/sr], `error` likewise its standard error.

    A tree says how many cells per axis it has at most; what has none is evaluated at many points within a cell.
    """

    name: str
    evaluate: Function
    error: Function | None = None
    log2_res: int | None = None
    seconds: float = 0.0
    note: str = ""
    bsdf: bsdftree.Bsdf | None = None


def measurement(scans: list[Scan]) -> Any:
    """The scans as arrays."""
    return bsdftree.Measurement([(scan.incident, scan.exitant, scan.values, None) for scan in scans])


def model(scans: list[Scan], **options: Any) -> tuple[Contender, Any]:
    """Our fit, point by point, and the fit itself."""
    if not hasattr(bsdftree, "fit"):
        raise SystemExit("this bsdftree has no fit yet")
    taken = measurement(scans)
    start = time.process_time()
    fitted = bsdftree.fit(taken, **options)
    seconds = time.process_time() - start
    return Contender("ours", fitted.eval, fitted.error, None, seconds, repr(fitted)), fitted


def of_tree(
    name: str, bsdf: bsdftree.Bsdf, log2_res: int, seconds: float, error: Function | None = None, note: str = ""
) -> Contender:
    return Contender(name, bsdf.eval, error, log2_res, seconds, note, bsdf)


def tree(scans: list[Scan], rank: int, log2_res: int, tolerance: float = TOLERANCE, **options: Any) -> Contender:
    """Our fit as a tree; time of fitting and resampling."""
    pointwise, fitted = model(scans, **options)
    start = time.process_time()
    made = fitted.trees(rank, log2_res, tolerance=tolerance)
    seconds = pointwise.seconds + time.process_time() - start
    return of_tree("ours", made.bsdf, log2_res, seconds, made.errors.eval, pointwise.note)


def klems(scans: list[Scan], rank: int, log2_res: int, **options: Any) -> Contender:
    """Our fit as a full Klems matrix, of the tree, as `bsdftree fit --klems full` writes it."""
    made = tree(scans, rank, log2_res, **options)
    start = time.process_time()
    assert made.bsdf is not None
    matrix = made.bsdf.to_klems("full")
    return of_tree("ours", matrix, 0, made.seconds + time.process_time() - start, note=made.note)


def radiance_klems(files: list[Path], cache: Path) -> Contender:
    """The incumbent's full Klems matrix."""
    outcome = incumbent.klems(files, cache)
    return of_tree("incumbent", outcome.bsdf(), 0, outcome.interpolant.cpu + outcome.resampling.cpu)


def radiance(files: list[Path], log2_res: int, cache: Path) -> Contender:
    """The incumbent's tree."""
    outcome = incumbent.tree(files, log2_res, cache)
    return of_tree("incumbent", outcome.bsdf(), log2_res, outcome.interpolant.cpu + outcome.resampling.cpu)


def nearest(scans: list[Scan]) -> Contender:
    """The nearest reading of the nearest scan: what a fit has to beat whatever it does."""

    def evaluate(incident: Array, exitant: Array) -> Array:
        which = np.argmax(incident @ np.stack([scan.incident for scan in scans]).T, axis=1)
        values = np.empty(len(incident))
        for k in np.unique(which):
            mine = np.flatnonzero(which == k)
            for part in np.array_split(mine, 1 + len(mine) // 4096):
                values[part] = scans[k].values[np.argmax(exitant[part] @ scans[k].exitant.T, axis=1)]
        return values

    return Contender("nearest", evaluate)
