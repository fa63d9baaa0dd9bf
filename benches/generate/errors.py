"""How far a BSDF is from another.

In: BSDFs of rank 4 as dense grids of values f, one for each component (a component that is absent is black), all of
cells of equal projected solid angle Ω. Out, over the cells of all components:

* relative L1, Σ|f − r| / Σ r: the share of light that goes astray;
* relative RMS, √(Σ(f − r)² / Σ r²): dominated by peaks;
* the worst incident cell's hemispherical error, max |Σ_exitant (f − r) Ω|.

Grids are compared a slab at a time, so that temporaries stay at a megabyte or so. Where dense grids would not fit,
`sampled_difference` estimates L1 from directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bsdftree import Bsdf, Tree

Grids = dict[str, NDArray[np.float32]]
"""From component to values (n, n, n, n): incident x, y, exitant x, y of the Shirley-Chiu square."""


@dataclass(frozen=True)
class Errors:
    l1: float
    rms: float
    worst: float


def trees(bsdf: Bsdf) -> dict[str, Tree]:
    return {key: c for key, c in bsdf.components.items() if isinstance(c, Tree)}


def n_leaves(bsdf: Bsdf) -> int:
    return sum(tree.n_leaves for tree in trees(bsdf).values())


def grids(bsdf: Bsdf, log2_res: int) -> Grids:
    return {key: tree.to_grid(log2_res) for key, tree in trees(bsdf).items()}


def errors(values: Grids, reference: Grids) -> Errors:
    """Errors of values against a reference."""
    n = len(next(iter(reference.values())))
    solid_angle = np.pi / n**2
    black = np.zeros((n, n, n), np.float32)
    absolute = squared = total = total_squared = 0.0
    missing = np.zeros((n, n))
    for key in sorted(values.keys() | reference.keys()):
        for x in range(n):
            f = values[key][x] if key in values else black
            r = reference[key][x] if key in reference else black
            difference = (f - r).reshape(n, -1)
            absolute += float(np.abs(difference).sum(dtype=np.float64))
            squared += float(np.square(difference).sum(dtype=np.float64))
            total += float(r.sum(dtype=np.float64))
            total_squared += float(np.square(r).sum(dtype=np.float64))
            missing[x] += difference.sum(axis=1, dtype=np.float64)
    worst = float(np.abs(missing).max()) * solid_angle
    return Errors(absolute / total, float(np.sqrt(squared / total_squared)), worst)


def total(values: Grids) -> float:
    """Mean fraction of light that is scattered."""
    n = len(next(iter(values.values())))
    return sum(float(grid.mean(dtype=np.float64)) for grid in values.values()) * n**2 * np.pi / n**2


def sampled_difference(a: Bsdf, b: Bsdf, n: int, rng: np.random.Generator) -> float:
    """Relative L1 difference of two BSDFs, ∫|a − b| / ∫(a + b)/2, from n incident directions of the front.

    Exitant directions are chosen from each by its own sampling, half and half; |a − b| over the density of that,
    (a + b)/2, is at most 2, so that peaks do no harm: the standard error is under 2/√n.
    """
    radius, azimuth = np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    incident = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1 - radius**2)], axis=1)
    difference = both = 0.0
    for source in (a, b):
        sample = source.sample(incident, rng.random((n, 2)))
        seen = sample.pdf > 0
        i, o = incident[seen], sample.exitant[seen]
        f, g = a.eval(i, o), b.eval(i, o)
        # Sampled with density f over its total; what is integrated counts with weight total / f.
        difference += float((2 * np.abs(f - g) / (f + g) * sample.weight[seen]).sum())
        both += float(sample.weight[seen].sum())
    return difference / both
