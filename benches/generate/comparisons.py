"""Tables of the equal-error measurements.

Where a series of ours meets an error is interpolated between two sample counts, both logarithms linear. Nothing is
extrapolated: "<" and ">" stand before what the series does not reach.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from . import ours
from .equal_error import CULL_PERCENTS, METRICS, PATIENCE, Measured, Point
from .tables import head, listed, megabytes, row, shown

BUDGET = 5.0
"""CPU time [s] of "the best within"."""


@dataclass(frozen=True)
class Reached:
    """Where a series meets an error; `bound` is "<" or ">" if it lies outside."""

    samples: float
    cpu: float
    bound: str = ""

    def times_less(self, than: float, what: str) -> str:
        flipped = {"<": ">", ">": "<", "": ""}[self.bound]
        return f"{flipped}{shown(than / getattr(self, what))}"


def reached(points: Sequence[Point], metric: str, target: float) -> Reached:
    """Where the series first has an error this small."""
    first = points[0]
    if getattr(first.errors, metric) <= target:
        return Reached(first.samples, first.cpu, "<")
    for a, b in pairwise(points):
        from_error, to_error = (getattr(p.errors, metric) for p in (a, b))
        if to_error <= target:
            share = math.log(from_error / target) / math.log(from_error / to_error)
            return Reached(_between(a.samples, b.samples, share), _between(a.cpu, b.cpu, share))
    return Reached(points[-1].samples, points[-1].cpu, ">")


def _between(a: float, b: float, share: float) -> float:
    """From a (0) to b (1), linear in logarithms."""
    return math.exp((1 - share) * math.log(a) + share * math.log(b))


def print_tables(all_measured: Sequence[Measured]) -> None:
    """Every comparison, device by device."""
    left_out = [name for name in ours.VARIANTS if name not in ours.available()]
    if left_out:
        print(f"\nLeft out, as `generate()` has no such option: {listed(left_out)}.")
    _references(all_measured)
    _against_genbsdf(all_measured)
    _against_reducer(all_measured)
    _worst_directions(all_measured)
    _tolerances(all_measured)
    _reuse(all_measured)
    _all_points(all_measured)


def _references(all_measured: Sequence[Measured]) -> None:
    note = "Floor is a reference's own error; to plain: its RMS difference to plain paths, over the noise of both."
    columns = (">paths", ">total", ">floor: L1", ">RMS", ">worst direction", ">to plain")
    head("References", "device", *columns, note=note)
    for m in all_measured:
        floor = m.truth.floor
        row(m.plan.name, m.truth.samples, m.truth.total, floor.l1, floor.rms, floor.worst, m.truth.to_plain)


def _against_genbsdf(all_measured: Sequence[Measured]) -> None:
    note = "CPU seconds for the error that genBSDF reaches, tree and XML included."
    columns = (">CPU s", ">paths", ">times less")
    head(
        "Equal error against genBSDF",
        *("device", "genBSDF", ">its CPU s", ">L1", ">RMS", "ours"),
        *(f"{c} for its {metric}" if k == 0 else c for metric in ("L1", "RMS") for k, c in enumerate(columns)),
        note=note,
    )
    for m in all_measured:
        theirs = m.incumbent
        if theirs is None:
            continue
        for name, points in m.ours.items():
            cells: list[object] = []
            for metric in METRICS:
                at = reached(points, metric, getattr(theirs.errors, metric))
                samples = f"{at.bound}{shown(round(at.samples))}"
                cells += [f"{at.bound}{shown(at.cpu)}", samples, at.times_less(theirs.cpu, "cpu")]
            settings = f"-t4 {m.plan.log2_res} -c {theirs.samples}"
            row(m.plan.name, settings, theirs.cpu, theirs.errors.l1, theirs.errors.rms, name, *cells)


def _against_reducer(all_measured: Sequence[Measured]) -> None:
    numbers = (
        "random numbers" if "random numbers" in ours.available() else "Sobol (there is no option for random numbers)"
    )
    note = (
        f"Our paths, {numbers}, reduced by rttree_reduce at the best of {listed([f'{p} %' for p in CULL_PERCENTS])} "
        "for that error, and how many times fewer paths our variants need for it."
    )
    names = list(all_measured[0].ours)
    columns = [f">{name}" for name in names]
    head(
        "Equal error against the incumbent's reducer",
        *("device", "error", ">paths", ">not reduced", ">best %", ">its error", ">leaves", *columns),
        note=note,
    )
    for m in all_measured:
        for c in m.culled:
            ratios = [reached(m.ours[name], c.metric, c.error).times_less(c.samples, "samples") for name in names]
            metric = "L1" if c.metric == "l1" else "RMS"
            row(m.plan.name, metric, c.samples, c.raw, c.percent, c.error, c.leaves, *ratios)


def _worst_directions(all_measured: Sequence[Measured]) -> None:
    head(
        "Worst incident direction and leaves",
        *("device", "what", ">paths", ">worst direction", ">L1", ">leaves", ">XML MB"),
    )
    for m in all_measured:
        if (theirs := m.incumbent) is not None:
            seen = (theirs.samples, theirs.errors.worst, theirs.errors.l1, theirs.leaves, megabytes(theirs.bytes))
            row(m.plan.name, "genBSDF", *seen)
        for name, points in m.ours.items():
            for p in (points[len(points) // 2], points[-1]):
                row(m.plan.name, name, p.samples, p.errors.worst, p.errors.l1, p.leaves, megabytes(p.bytes))


def _tolerances(all_measured: Sequence[Measured]) -> None:
    if not any(m.tolerated for m in all_measured):
        return
    note = f"Options by default, but for the tolerance; at most {PATIENCE:g} s of wall time. L1 has the floor in it."
    columns = (">tolerance", ">paths", ">CPU s", ">its estimate", ">L1", ">floor", ">direction's estimate", ">leaves")
    head("Asked for an error", "device", *columns, note=note)
    for m in all_measured:
        for tolerance, p in m.tolerated.items():
            seen = (p.estimated, p.errors.l1, m.truth.floor.l1, p.estimated_direction)
            row(m.plan.name, tolerance, p.samples, p.cpu, *seen, p.leaves)


def _reuse(all_measured: Sequence[Measured]) -> None:
    pairs = [(name, name.partition(", reuse")[0]) for name in ours.available() if ", reuse" in name]
    if not pairs:
        return
    note = f"CPU seconds for the smallest L1 of the series without; best L1 within {BUDGET:g} CPU seconds."
    columns = (">L1", ">CPU s without", ">with", ">times less", f">L1 within {BUDGET:g} s without", ">with")
    head("Reuse of diffuse vertices", "device", "ours", *columns, note=note)
    for m in all_measured:
        for with_name, without_name in pairs:
            a, b = m.ours[without_name], m.ours[with_name]
            best = min(a, key=lambda p: p.errors.l1)
            at = reached(b, "l1", best.errors.l1)
            within = [min((p.errors.l1 for p in points if p.cpu <= BUDGET), default=None) for points in (a, b)]
            cells = (best.errors.l1, best.cpu, f"{at.bound}{shown(at.cpu)}", at.times_less(best.cpu, "cpu"))
            row(m.plan.name, with_name, *cells, *within)


def _all_points(all_measured: Sequence[Measured]) -> None:
    columns = (">paths", ">CPU s", ">L1", ">its estimate", ">RMS", ">worst direction", ">leaves", ">XML MB")
    head("All points", "device", "ours", *columns)
    for m in all_measured:
        for name, points in m.ours.items():
            for p in points:
                seen = (p.errors.l1, p.estimated, p.errors.rms, p.errors.worst)
                row(m.plan.name, name, p.samples, p.cpu, *seen, p.leaves, megabytes(p.bytes))
