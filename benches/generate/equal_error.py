"""Errors against references: what genBSDF and its reducer need, and what we need for the same error.

Ours is measured over a series of sample counts. Where it meets an error is interpolated between two counts, both
logarithms linear. Nothing is extrapolated: "<" and ">" stand before what the series does not reach.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import bsdftree

from . import incumbent, ours
from .devices import EQUAL_ERROR, SAWTOOTH, Scene
from .errors import Errors, grids, n_leaves, total
from .references import Reference, reference
from .tables import head, listed, megabytes, row, shown

CULL_PERCENTS = (50, 70, 80, 90, 95, 99)
METRICS = ("l1", "rms")
BUDGET = 5.0
"""CPU time [s] of "the best within"."""


@dataclass(frozen=True)
class Plan:
    """One device at one resolution, and how much is spent on it."""

    scene: Scene
    log2_res: int
    reference: int
    genbsdf: int
    series: tuple[int, ...]
    reduced: tuple[int, ...]

    @property
    def name(self) -> str:
        return f"{self.scene.name}, 2^{self.log2_res}"


@dataclass(frozen=True)
class Point:
    """A generation: paths per incident cell, CPU time [s], errors, leaves, XML [byte]."""

    samples: int
    cpu: float
    errors: Errors
    leaves: int
    bytes: int


@dataclass(frozen=True)
class Reached:
    """Where a series meets an error; `bound` is "<" or ">" if it lies outside."""

    samples: float
    cpu: float
    bound: str = ""

    def times_less(self, than: float, what: str) -> str:
        flipped = {"<": ">", ">": "<", "": ""}[self.bound]
        return f"{flipped}{shown(than / getattr(self, what))}"


def plans(quick: bool) -> list[Plan]:
    """Four times the samples at a quarter of the incident cells is the same work for genBSDF."""
    if quick:
        series = (4, 16, 64, 256, 1024)
        return [Plan(scene, 4, 60_000, 20, series, (500,)) for scene in EQUAL_ERROR]
    fine = Plan(SAWTOOTH, 6, 200_000, 20, _powers(4, 2048), (1000,))
    return [fine, *(Plan(scene, 5, 400_000, 80, _powers(4, 8192), (1000, 10_000)) for scene in EQUAL_ERROR)]


def _powers(least: int, most: int) -> tuple[int, ...]:
    return tuple(2**k for k in range(least.bit_length() - 1, most.bit_length()))


def series(device: Path, plan: Plan, truth: Reference, work: Path, options: dict[str, Any]) -> list[Point]:
    """Errors over sample counts."""
    points = []
    for samples in plan.series:
        made = ours.make(device, work / "ours.xml", log2_res=plan.log2_res, samples=samples, seed=1, **options)
        seen = truth.errors(grids(made.bsdf, plan.log2_res))
        points.append(Point(samples, made.cpu, seen, n_leaves(made.bsdf), made.bytes))
    return points


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


@dataclass(frozen=True)
class Culled:
    """The reducer's best result for a metric, and the error of what it was given."""

    samples: int
    metric: str
    error: float
    percent: int
    leaves: int
    raw: float


@dataclass(frozen=True)
class Measured:
    plan: Plan
    truth: Reference
    incumbent: Point
    culled: list[Culled]
    ours: dict[str, list[Point]]


def measure(plan: Plan, cache: Path, work: Path) -> Measured:
    """Everything about one device."""
    truth = reference(plan.scene, plan.log2_res, plan.reference, cache)
    device = plan.scene.write(work)
    variants = {name: series(device, plan, truth, work, options) for name, options in ours.available().items()}
    return Measured(plan, truth, _genbsdf(device, plan, truth, work), _culled(device, plan, truth, work), variants)


def _genbsdf(device: Path, plan: Plan, truth: Reference, work: Path) -> Point:
    xml, cost = incumbent.genbsdf(device, plan.log2_res, plan.genbsdf, work)
    bsdf = incumbent.read(xml)
    values = grids(bsdf, plan.log2_res)
    if abs(total(values) - truth.total) > 0.02:
        raise RuntimeError(f"{plan.name}: genBSDF scatters {total(values):.4f} of the light, we {truth.total:.4f}")
    return Point(plan.genbsdf, cost.cpu, truth.errors(values), n_leaves(bsdf), xml.stat().st_size)


def baseline() -> dict[str, Any]:
    """Uniform random sampling, if we can still do it."""
    variants = ours.available()
    return variants.get("random numbers", variants["Sobol"])


def _culled(device: Path, plan: Plan, truth: Reference, work: Path) -> list[Culled]:
    """Our paths, reduced by rttree_reduce at its best percentage for each metric."""
    found = []
    for samples in plan.reduced:
        raw = bsdftree.generate(
            device, rank=4, log2_res=plan.log2_res, sides="front", samples=samples, seed=2, prune=False, **baseline()
        )
        values = grids(raw, plan.log2_res)
        unreduced, inputs = truth.errors(values), incumbent.write_values(values, work)
        seen = []
        for percent in CULL_PERCENTS:
            xml, _ = incumbent.reduced(inputs, plan.log2_res, percent, work)
            bsdf = incumbent.read(xml)
            seen.append((truth.errors(grids(bsdf, plan.log2_res)), percent, n_leaves(bsdf)))
        for metric in METRICS:
            error, percent, leaves = min((getattr(e, metric), p, n) for e, p, n in seen)
            found.append(Culled(samples, metric, error, percent, leaves, getattr(unreduced, metric)))
    return found


def print_tables(all_measured: Sequence[Measured]) -> None:
    """Every comparison, device by device."""
    left_out = [name for name in ours.VARIANTS if name not in ours.available()]
    if left_out:
        print(f"\nLeft out, as `generate()` has no such option: {listed(left_out)}.")
    _references(all_measured)
    _against_genbsdf(all_measured)
    _against_reducer(all_measured)
    _worst_directions(all_measured)
    _reuse(all_measured)
    _all_points(all_measured)


def _references(all_measured: Sequence[Measured]) -> None:
    head("References", "device", ">paths per incident cell", ">total", ">floor: L1", ">RMS", ">worst direction")
    for m in all_measured:
        floor = m.truth.floor
        row(m.plan.name, m.truth.samples, m.truth.total, floor.l1, floor.rms, floor.worst)


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
        theirs = m.incumbent
        row(
            m.plan.name,
            "genBSDF",
            theirs.samples,
            theirs.errors.worst,
            theirs.errors.l1,
            theirs.leaves,
            megabytes(theirs.bytes),
        )
        for name, points in m.ours.items():
            for p in (points[len(points) // 2], points[-1]):
                row(m.plan.name, name, p.samples, p.errors.worst, p.errors.l1, p.leaves, megabytes(p.bytes))


def _reuse(all_measured: Sequence[Measured]) -> None:
    pairs = [(name, name.removesuffix(", reuse")) for name in ours.available() if name.endswith(", reuse")]
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
            row(m.plan.name, without_name, *cells, *within)


def _all_points(all_measured: Sequence[Measured]) -> None:
    columns = (">paths", ">CPU s", ">L1", ">RMS", ">worst direction", ">leaves", ">XML MB")
    head("All points", "device", "ours", *columns)
    for m in all_measured:
        for name, points in m.ours.items():
            for p in points:
                e = p.errors
                row(m.plan.name, name, p.samples, p.cpu, e.l1, e.rms, e.worst, p.leaves, megabytes(p.bytes))


def run(quick: bool, cache: Path, work: Path) -> None:
    """Measure and print."""
    measured = []
    for plan in plans(quick):
        measured.append(measure(plan, cache, work))
    print("\n## Equal error")
    print_tables(measured)
