"""What a generation says of itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bsdftree._bsdf import Bsdf


@dataclass(frozen=True)
class Resumed:
    """Where a generation went on that had been interrupted, or was done and is to have more samples.

    Attributes
    ----------
    samples
        Paths per incident cell and side that had been counted in whole rounds.
    round_end
        Paths per incident cell and side at the end of the round that was interrupted; ``samples`` if none was.
    share
        The share of that round that had been counted, in 0..1.
    dropped
        What had been written but is not whole, and is counted again [byte].
    """

    samples: int
    round_end: int
    share: float
    dropped: int


@dataclass(frozen=True)
class BandReport:
    """What is known of a band.

    Attributes
    ----------
    name
        As in the file, such as ``"Visible"``.
    error
        Estimated relative error of the whole: Σ abs(error) / Σ BSDF over all finest cells.
    direction_error
        Largest error of the hemispherical total of an incident cell: half its 95 % interval, or what the tree departs
        from what was counted; relative to the total, or to 0.1 if the total is less.
    totals
        For each component, the hemispherical totals of all incident cells as counted, before anything was merged, and
        their standard errors, each (n_cells,). Cells count in Morton order, x first.
    """

    name: str
    error: float
    direction_error: float
    totals: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]


@dataclass(frozen=True)
class GenerationReport:
    """What a generation did.

    Attributes
    ----------
    paths
        Paths followed.
    samples
        Paths per incident cell and side.
    stop
        Why there were no more: ``"samples"``, ``"tolerance"``, ``"time"`` or ``"memory"``.
    error
        Estimated relative error of the whole: Σ abs(error) / Σ BSDF over all finest cells.
    direction_error
        Largest error of the hemispherical total of an incident cell: half its 95 % interval, or what the tree departs
        from what was counted; relative to the total, or to 0.1 if the total is less.
    errors
        The standard error of each value, as a BSDF of the same form. A 95 % interval is ±2.36 standard errors.
    totals
        For each component, the hemispherical totals of all incident cells as counted, before anything was merged, and
        their standard errors, each (n_cells,). Cells count in Morton order, x first.
    lost
        Paths trapped in the device; they are missing from the result.
    tracing_seconds, reducing_seconds
        Wall time of the two stages.
    aperture
        Smallest and largest x, y, z of the box that stood for the device [m].
    warnings
        What you should know.
    bands
        What is known of each band; ``error`` and ``direction_error`` are the largest of them, ``totals`` those of the
        first. Empty with Radiance as the engine.
    """

    paths: int
    samples: int
    stop: Literal["samples", "tolerance", "time", "memory"]
    error: float
    direction_error: float
    errors: Bsdf
    totals: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]
    lost: int
    tracing_seconds: float
    reducing_seconds: float
    aperture: tuple[tuple[float, float, float], tuple[float, float, float]]
    warnings: tuple[str, ...]
    bands: tuple[BandReport, ...] = ()
