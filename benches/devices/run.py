"""One device through both engines, and beside what its authors published."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bsdftree
from bsdftree import Matrix

from . import oracle, ours
from .comparison import LEAST_RAYS, Verdict, compare, luminance_or_xyz
from .oracle import Counted
from .ours import COMPONENTS, Generated
from .patches import INCIDENT, N_PATCHES, Array, projected_solid_angles
from .scenes import Published, Scene, as_radiance

SEED = 20140304
RAYS_FOR_SOURCES = 1 / 16
"""Rays that look at small sources, for one that is followed: each meets hundreds of them."""


@dataclass(frozen=True)
class Compared:
    """Totals (side of incidence, side of exitance) in a published file, NaN if it has none, and ours; z of patches."""

    rays: int
    theirs: Array
    ours: Array
    z: Array


@dataclass(frozen=True)
class Measured:
    """A device, what both engines counted, and whether it is the same."""

    scene: Scene
    radiance: Counted
    ours: Generated
    verdict: Verdict
    published: Compared | None


def measure(scene: Scene, samples: int) -> Measured:
    """Run a device through both engines, with so many rays for each side and incident patch."""
    with tempfile.TemporaryDirectory() as folder:
        file = scene.prepare(Path(folder))
        generated = ours.generate(file, samples, scene.colour, scene.dim)
        counted = ask(scene, as_radiance(file), generated, samples)
    colours = luminance_or_xyz(counted.batches, scene.colour)
    verdict = compare(colours, generated.runs, samples)
    published = None if scene.published is None else beside(scene.published, generated.runs)
    return Measured(scene, counted, generated, verdict, published)


def ask(scene: Scene, file: Path, generated: Generated, samples: int) -> Counted:
    """Ask Radiance in the way that the device needs."""

    def seen() -> Counted:
        return oracle.by_sources(file, generated.box, int(samples * RAYS_FOR_SOURCES), SEED, scene.jitter)

    def followed(bounces: int = 100) -> Counted:
        return oracle.by_rays(file, generated.box, samples, SEED, bounces, scene.jitter)

    match scene.oracle:
        case "rays":
            return followed()
        case "sources":
            return seen()
        case "rays and sources":
            # Rays alone follow what is mirrored and passed on; sources alone see lobes, and what is diffused.
            return followed(bounces=0) + seen()
        case "rays, reflection by sources":
            a, b = followed(), seen()
            for side in (0, 1):
                a.batches[side, :, :, side] = b.batches[side, :, :, side]
            return Counted(a.batches, a.n_rays + b.n_rays, a.cpu + b.cpu)


def beside(published: Published, runs: Array) -> Compared:
    """Compare with a published Klems matrix, of which each value has at most the variance of a count."""
    bsdf = bsdftree.load(published.path, strict=False)
    shape = (2, len(INCIDENT), 2, N_PATCHES)
    theirs = np.full(shape, np.nan)
    for name, side_in, side_out in COMPONENTS:
        matrix = bsdf.components.get(name)
        if isinstance(matrix, Matrix):
            theirs[side_in, :, side_out] = matrix.values[list(INCIDENT)] * projected_solid_angles()
    values = runs[..., 0].mean(axis=2)
    own_variance = runs[..., 0].var(axis=2, ddof=1) / runs.shape[2]
    counted = np.isfinite(theirs) & (values * published.rays >= LEAST_RAYS)
    variance = values * (1 - values) / published.rays + own_variance
    z = ((theirs - values) / np.sqrt(np.where(counted, variance, 1)))[counted]
    totals = [np.where(np.isfinite(theirs), x, np.nan).sum(axis=3).mean(axis=1) for x in (theirs, values)]
    return Compared(published.rays, totals[0], totals[1], z)
