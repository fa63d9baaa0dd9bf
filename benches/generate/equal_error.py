"""Errors against references: of genBSDF, of its reducer on our paths, and of ours.

Ours is measured over a series of sample counts, for each variant that `generate()` has options for, and with tolerances
that it is to find by itself.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bsdftree

from . import incumbent, ours
from .devices import ENDLESS, EQUAL_ERROR, SAWTOOTH, Scene
from .errors import Errors, grids, n_leaves, total
from .references import Reference, reference

CULL_PERCENTS = (50, 70, 80, 90, 95, 99)
METRICS = ("l1", "rms")
REFERENCE = {4: 60_000, 5: 131_072, 6: 65_536}
"""Paths of a reference, by resolution."""
TOLERANCES = (0.2, 0.1)
PATIENCE = 20.0
"""Most wall time [s] for a tolerance."""


@dataclass(frozen=True)
class Plan:
    """One device at one resolution, and how much is spent on it; on genBSDF nothing, if the device has no end."""

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
    """A generation: paths per incident cell, CPU time [s], errors, leaves, XML [byte], errors that it reported."""

    samples: int
    cpu: float
    errors: Errors
    leaves: int
    bytes: int
    estimated: float | None = None
    estimated_direction: float | None = None


def plans(quick: bool) -> list[Plan]:
    """Four times the samples at a quarter of the incident cells is the same work for genBSDF."""
    if quick:
        series = (4, 16, 64, 256, 1024)
        return [Plan(scene, 4, REFERENCE[4], 20, series, (500,)) for scene in EQUAL_ERROR]
    fine = Plan(SAWTOOTH, 6, REFERENCE[6], 20, _powers(4, 2048), (1000,))
    at_5 = [
        Plan(scene, 5, REFERENCE[5], 0 if scene.period else 80, _powers(4, 8192), (1000, 10_000))
        for scene in (*EQUAL_ERROR, *ENDLESS)
    ]
    return [fine, *at_5]


def _powers(least: int, most: int) -> tuple[int, ...]:
    return tuple(2**k for k in range(least.bit_length() - 1, most.bit_length()))


def series(device: Path, plan: Plan, truth: Reference, work: Path, options: dict[str, Any]) -> list[Point]:
    """Errors over sample counts."""
    return [point(device, plan, truth, work, samples=samples, **options) for samples in plan.series]


def point(device: Path, plan: Plan, truth: Reference, work: Path, **options: Any) -> Point:
    """One generation and its errors."""
    options |= plan.scene.options
    made = ours.make(device, work / "ours.xml", log2_res=plan.log2_res, seed=1, **options)
    seen = truth.errors(grids(made.bsdf, plan.log2_res))
    leaves = n_leaves(made.bsdf)
    return Point(made.samples, made.cpu, seen, leaves, made.bytes, made.estimated, made.estimated_direction)


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
    incumbent: Point | None
    culled: list[Culled]
    ours: dict[str, list[Point]]
    tolerated: dict[float, Point]


def measure(plan: Plan, cache: Path, work: Path) -> Measured:
    """Everything about one device."""
    print(f"{time.strftime('%H:%M:%S')} {plan.name}", file=sys.stderr, flush=True)
    truth = reference(plan.scene, plan.log2_res, plan.reference, cache)
    device = plan.scene.write(work)
    variants = {name: series(device, plan, truth, work, options) for name, options in ours.available().items()}
    theirs = _genbsdf(device, plan, truth, work) if plan.genbsdf else None
    culled = _culled(device, plan, truth, work)
    return Measured(plan, truth, theirs, culled, variants, _tolerated(device, plan, truth, work))


def _tolerated(device: Path, plan: Plan, truth: Reference, work: Path) -> dict[float, Point]:
    """Ours by default, asked for an error instead of a number of paths."""
    if not ours.accepts("tolerance"):
        return {}
    patience = ours.known({"time_budget": PATIENCE})
    return {e: point(device, plan, truth, work, tolerance=e, **patience) for e in TOLERANCES}


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
        options = baseline() | plan.scene.options
        raw = bsdftree.generate(
            device, rank=4, log2_res=plan.log2_res, sides="front", samples=samples, seed=2, prune=False, **options
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


def measurements(quick: bool, cache: Path, work: Path, names: Sequence[str] = ()) -> list[Measured]:
    """Of every device, or of those that are named."""
    all_plans = plans(quick)
    if unknown := set(names) - {plan.scene.name for plan in all_plans}:
        raise SystemExit(f"no device {sorted(unknown)}; there are {sorted({p.scene.name for p in all_plans})}")
    return [measure(plan, cache, work) for plan in all_plans if not names or plan.scene.name in names]
