"""bsdftree as it is: a generation by name of variant, with those options that `generate()` has.

An option that `generate()` does not have may only ask for what it does anyway (`ALWAYS`); a variant that asks for
more is left out of the tables, which say so. CPU seconds are those of this process while it generates and writes XML,
all threads together; so Python's start-up is not among them.
"""

from __future__ import annotations

import inspect
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bsdftree
from bsdftree import Bsdf

ALWAYS: dict[str, Any] = {"sampling": "sobol", "reuse": False}
"""What `generate()` does where it has no such option."""

SOBOL = {"sampling": "sobol", "reciprocity": False, "reuse": False}
RANDOM = SOBOL | {"sampling": "random"}
NO_GUARD = {"direction_tolerance": 1e6}
"""Hemispherical totals of single directions may be wrong by any amount."""
VARIANTS: dict[str, dict[str, Any]] = {
    "random numbers": RANDOM,
    "Sobol": SOBOL,
    "Sobol, reciprocity": SOBOL | {"reciprocity": True},
    "Sobol, reciprocity, no guard": SOBOL | {"reciprocity": True} | NO_GUARD,
    "Sobol, reuse": SOBOL | {"reuse": True},
    "Sobol, reciprocity, reuse": SOBOL | {"reciprocity": True, "reuse": True},
    "Sobol, reciprocity, reuse, detail 0.01": SOBOL | {"reciprocity": True, "reuse": True, "detail": 0.01},
}


class Missing(Exception):
    """`generate()` has no such option yet."""


def accepts(option: str) -> bool:
    return option in inspect.signature(bsdftree.generate).parameters


def known(options: dict[str, Any]) -> dict[str, Any]:
    """Options to pass; `Missing` if `generate()` cannot do what they ask."""
    for name, value in options.items():
        if not accepts(name) and value != ALWAYS.get(name):
            raise Missing(f"generate() has no option {name!r}")
    return {name: value for name, value in options.items() if accepts(name)}


def available() -> dict[str, dict[str, Any]]:
    """Variants that can be measured."""
    found = {}
    for name, options in VARIANTS.items():
        try:
            found[name] = known(options)
        except Missing:
            continue
    return found


@dataclass(frozen=True)
class Made:
    """A BSDF, its CPU time [s], the size of its file, and what was reported: error of the whole and of a direction."""

    bsdf: Bsdf
    cpu: float
    bytes: int
    samples: int
    estimated: float | None
    estimated_direction: float | None


def make(device: Path, into: Path, **options: Any) -> Made:
    """Generate and write; light comes from the front, as in genBSDF unless told otherwise."""
    reports: list[bsdftree.GenerationReport] = []
    start = time.process_time()
    bsdf = bsdftree.generate(device, rank=4, sides="front", report=reports.append, **options)
    bsdf.save(into)
    cpu = time.process_time() - start
    (said,) = (vars(report) for report in reports)
    samples = int(said.get("samples") or options["samples"])
    return Made(bsdf, cpu, into.stat().st_size, samples, said.get("error"), said.get("direction_error"))
