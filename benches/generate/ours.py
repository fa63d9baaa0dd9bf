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

RANDOM = {"sampling": "random", "reciprocity": False, "reuse": False}
SOBOL = {"sampling": "sobol", "reciprocity": False, "reuse": False}
VARIANTS: dict[str, dict[str, Any]] = {
    "random numbers": RANDOM,
    "Sobol": SOBOL,
    "Sobol, reciprocity": SOBOL | {"reciprocity": True},
    "Sobol, reuse": SOBOL | {"reuse": True},
    "Sobol, reciprocity, reuse": SOBOL | {"reciprocity": True, "reuse": True},
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
    bsdf: Bsdf
    cpu: float
    bytes: int


def make(device: Path, into: Path, **options: Any) -> Made:
    """Generate and write; light comes from the front, as in genBSDF unless told otherwise."""
    start = time.process_time()
    bsdf = bsdftree.generate(device, rank=4, sides="front", **options)
    bsdf.save(into)
    return Made(bsdf, time.process_time() - start, into.stat().st_size)
