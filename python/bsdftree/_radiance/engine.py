"""A device to a BSDF by Radiance's ``rcontrib``: the fallback for what our tracer lacks, and its oracle.

In: a scene as text, the cells, how many rays. Out: the BSDF with standard errors, and a report, as from our tracer.

Method: genBSDF's. Rays start on the face of the device's box, for each incident cell as many, at the stratified points
of our own tracer (genBSDF has a jittered grid); glow sources of half the sky catch what leaves, by cell. Each cell's
rays are dealt to 8 replicates, whose scatter is the error. Trees are reduced by Radiance's rttree_reduce, or kept.

Deviations from genBSDF: both transmissions are kept at rank 4; rank 3 is the mean over 8 azimuths, where genBSDF takes
the plane of X and Z; colour is 1931 XYZ from Radiance's primaries to full precision, and is not bleached by dark cells.
Radiance's random numbers differ in each run, and so do results. Lengths are Radiance's as they stand: a unit only names
them.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bsdftree import _core
from bsdftree._radiance.bins import klems_bins, square_bins
from bsdftree._radiance.programs import RadianceError
from bsdftree._radiance.programs import run as run_program
from bsdftree._radiance.rcontrib import REPLICATES, Rays, Run, bounds, compiled, contributions
from bsdftree._radiance.reduce import reduced
from bsdftree._radiance.scene import SceneText

Array = NDArray[np.float32]

STUDENT_95 = 2.36
"""Half the width of an interval of 95 % in standard errors, with 7 degrees of freedom."""
MOST_BYTES = 8 << 30
BESIDE = 1e-7
"""By how much cells of rank 3 are turned aside [radian], one way and the other in turn: light in the plane of
incidence, which is a border of cells, is shared by both, as our own tracer shares it."""
TURNS = {
    "x": ["-rz", "90"],
    "-x": ["-rz", "-90"],
    "y": [],
    "-y": ["-rz", "180"],
    "z": ["-rx", "-90"],
    "-z": ["-rx", "90"],
}
# Which component light belongs to that comes from one side (rows) and leaves to the front or the back.
_PARTS = {
    False: ("reflection_back", "transmission_back"),
    True: ("transmission_front", "reflection_front"),
}


@dataclass(frozen=True)
class Job:
    """What is to be done. Lengths in the scene's own unit.

    Attributes
    ----------
    layout, rank, log2_res
        The cells; rank 0 for patches.
    samples
        Rays per incident cell and side; rounded up to a multiple of 8.
    from_back
        The sides that light comes from.
    color
        Whether to keep colour.
    cull_percent
        What rttree_reduce culls; None keeps all cells.
    average
        Whether the reducer averages pairs with swapped pairs: reflections, and all of rank 3.
    dim
        xmin, xmax, ymin, ymax, zmin, zmax of the box that stands for the device; None for its bounding box.
    up
        The axis that points up in the drawing.
    options
        More options of rcontrib.
    seed, processes
        Of the starting points; of rcontrib.
    """

    layout: _core.Layout
    rank: int
    log2_res: int
    samples: int
    from_back: tuple[bool, ...]
    color: bool = False
    cull_percent: float | None = 90.0
    average: bool = False
    dim: tuple[float, ...] | None = None
    up: str = "y"
    options: tuple[str, ...] = ()
    seed: int = 0
    processes: int = 1


@dataclass
class Traced:
    """What came of it: components as functions of luminance or of luminance and chroma, and their errors."""

    components: dict[str, list[_core.Tree | _core.Matrix]]
    errors: dict[str, list[_core.Tree | _core.Matrix]]
    totals: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]
    samples: int
    rays: int
    error: float
    direction_error: float
    dim: tuple[float, ...]
    tracing_seconds: float
    reducing_seconds: float
    scene: SceneText


@dataclass
class _Counts:
    """Fractions of light from each incident cell to each exitant cell: the mean, its error, errors of totals."""

    mean: list[Array]
    sigma: Array
    total_sigma: NDArray[np.float64]


def trace(scene: SceneText, job: Job, progress: Callable[[int, int], None] | None = None) -> Traced:
    """Trace a scene with Radiance.

    Raises
    ------
    RadianceError
        If Radiance is not installed, refuses the scene or an option, or the result would not fit into memory.
    """
    _check(job)
    turn = TURNS[job.up.lower().lstrip("+")]
    if turn:
        scene = SceneText(
            run_program("xform", *turn, stdin=scene.text, directories=scene.directories), scene.directories
        )
    dim = job.dim if job.dim is not None else bounds(scene)
    for k, axis in enumerate("XY"):
        if dim[2 * k + 1] <= dim[2 * k]:
            raise RadianceError(
                f"the device has no extent along {axis}; turn it to face +Z (--up, or xform in the scene), or give the "
                f"box that it stands for (--dim)"
            )
    samples = -(-job.samples // REPLICATES) * REPLICATES
    n_rays = samples * job.layout.n_incident * len(job.from_back)
    began = time.perf_counter()
    counts: dict[str, _Counts] = {}
    with tempfile.TemporaryDirectory(prefix="bsdftree-") as folder:
        octree = compiled(scene, Path(folder))
        done = 0
        for from_back in job.from_back:

            def told(n: int, before: int = done) -> None:
                if progress is not None:
                    progress(before + n, n_rays)

            rays = Rays(job.layout, dim, from_back, samples, job.seed)
            sides = _counted(octree, scene.directories, rays, job, told)
            counts |= dict(zip(_PARTS[from_back], sides, strict=True))
            done += samples * job.layout.n_incident
    traced = time.perf_counter()
    areas = job.layout.exitant_areas()
    components = {key: _functions(key, c, areas, job) for key, c in counts.items()}
    errors = {key: [job.layout.function((c.sigma / areas).astype(np.float32).ravel())] for key, c in counts.items()}
    totals = {key: (c.mean[0].sum(axis=1, dtype=np.float64), c.total_sigma) for key, c in counts.items()}
    error, direction_error = _errors(counts, totals, _incident_areas(job, areas))
    end = time.perf_counter()
    return Traced(
        components,
        errors,
        totals,
        samples,
        n_rays,
        error,
        direction_error,
        dim,
        traced - began,
        end - traced,
        scene,
    )


def _check(job: Job) -> None:
    if job.up.lower().lstrip("+") not in TURNS:
        raise RadianceError(f"up is {job.up!r}; expected x, -x, y, -y, z or -z")
    if job.samples < 1:
        raise RadianceError(f"{job.samples} samples per incident cell; expected at least 1")
    if job.cull_percent is not None and not 0 <= job.cull_percent < 100:
        raise RadianceError(f"a culling of {job.cull_percent} %; expected 0 or more and less than 100")
    # Of each part luminance, its error, and chroma, as 32-bit numbers; and as much again while trees are made.
    cells = job.layout.n_incident * job.layout.n_exitant
    size = cells * 4 * (4 if job.color else 2) * (2 * len(job.from_back) + 1)
    if size > MOST_BYTES:
        raise RadianceError(
            f"{cells:,} pairs of cells take {size / 2**30:.1f} GiB; at most {MOST_BYTES >> 30} are allowed: lower the "
            f"resolution"
        )


def _runs(job: Job) -> list[Run]:
    """Return the runs that count one side."""
    everyone = tuple(range(REPLICATES))
    if job.rank == 0:
        return [Run(klems_bins(job.layout.rings), everyone)]
    n = 1 << job.log2_res
    if job.rank == 4:
        return [Run(square_bins(n), everyone)]
    # The bins of a run are of one azimuth, so that each replicate is a run, with an azimuth of its own.
    turn = float(np.random.default_rng(job.seed).random())
    azimuths = [2 * np.pi * (k + turn) / REPLICATES for k in everyone]
    return [Run(square_bins(n, a + BESIDE * (-1) ** k), (k,), a) for k, a in enumerate(azimuths)]


def _counted(
    octree: Path, directories: Sequence[str], rays: Rays, job: Job, told: Callable[[int], None]
) -> list[_Counts]:
    """Count rays that come from one side: those that leave to the front and those that leave to the back."""
    n_incident, n_exitant = job.layout.n_incident, job.layout.n_exitant
    each = rays.samples // REPLICATES
    n_kept = 3 if job.color else 1
    means = np.zeros((2, n_kept, n_incident, n_exitant), np.float32)
    sigmas = np.zeros((2, n_incident, n_exitant), np.float32)
    total_sigmas = np.zeros((2, n_incident))
    to_xyz = np.array(_core.XYZ_FROM_RGB, np.float32)
    rows = [1, 0, 2] if job.color else [1]
    squares = np.zeros((2, n_incident, n_exitant), np.float32)
    total_squares = np.zeros((2, n_incident))
    for k, run in enumerate(_runs(job)):
        records = contributions(octree, directories, rays, run, job.options, job.processes, is_square=job.rank > 0)
        for cell, record in enumerate(records):
            # Replicate, side of exit, exitant cell, colour.
            xyz = record @ to_xyz.T
            kept = xyz[..., rows]
            means[:, :, cell] += kept.sum(axis=0).transpose(0, 2, 1) / REPLICATES
            y = xyz[..., 1]
            squares[:, cell] += (y * y).sum(axis=0)
            total_squares[:, cell] += (y.sum(axis=2, dtype=np.float64) ** 2).sum(axis=0)
            told((k * n_incident + (cell + 1) * len(run.replicates)) * each)
    for side in range(2):
        mean = means[side, 0]
        spread = np.maximum(squares[side] / REPLICATES - mean * mean, 0.0)
        sigmas[side] = np.sqrt(spread / (REPLICATES - 1))
        total = mean.sum(axis=1, dtype=np.float64)
        total_spread = np.maximum(total_squares[side] / REPLICATES - total * total, 0.0)
        total_sigmas[side] = np.sqrt(total_spread / (REPLICATES - 1))
    return [_Counts(list(means[side]), sigmas[side], total_sigmas[side]) for side in range(2)]


def _functions(key: str, counts: _Counts, areas: NDArray[np.float64], job: Job) -> list[_core.Tree | _core.Matrix]:
    """Make a component: its luminance, and its chroma if colour is kept."""
    values = [(mean / areas).astype(np.float32) for mean in counts.mean]
    if job.rank and job.color:
        n = 1 << job.log2_res
        values = [values[0], *_chroma(values, (n,) * 4 if job.rank == 4 else (n // 2, n, n))]
    if not job.rank or job.cull_percent is None:
        return [job.layout.function(v.ravel()) for v in values]
    average = job.average and (job.rank == 3 or key.startswith("reflection"))
    # Chroma is kept four times as finely, as in genBSDF.
    culls = [job.cull_percent, *[100 - (100 - job.cull_percent) / 4] * 2]
    return [reduced(v, job.rank, job.log2_res, p, average=average) for v, p in zip(values, culls, strict=False)]


def _chroma(values: list[Array], shape: tuple[int, ...]) -> tuple[Array, Array]:
    """CIE 1976 u′ and v′; where there is no light, of the smallest cell around it of a coarser tree that has light.

    genBSDF takes white there, and its reducer bleaches what it merges with it.
    """
    xyz = np.stack([values[k].reshape(shape) for k in (1, 0, 2)]).astype(np.float64)
    lit = xyz.copy()
    size = 1
    while size < max(shape) and not (lit[1] > 0).all():
        size *= 2
        blocks = [max(1, n // size) for n in shape]
        split = [w for n, m in zip(shape, blocks, strict=True) for w in (m, n // m)]
        sums = xyz.reshape(3, *split).sum(axis=tuple(range(2, 2 + 2 * len(shape), 2)), keepdims=True)
        around = np.broadcast_to(sums, (3, *split)).reshape(3, *shape)
        lit = np.where(lit[1] > 0, lit, around)
    sum_of = lit[0] + 15 * lit[1] + 3 * lit[2]
    safe = np.where(sum_of > 0, sum_of, 19.0)
    u, v = np.where(sum_of > 0, 4 * lit[0], 4) / safe, np.where(sum_of > 0, 9 * lit[1], 9) / safe
    return u.astype(np.float32), v.astype(np.float32)


def _incident_areas(job: Job, areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Projected solid angles of the incident cells [sr], up to a factor."""
    if job.rank == 3:
        sine = 1 - 2 * np.arange(job.layout.n_incident + 1) / (1 << job.log2_res)
        return np.asarray(sine[:-1] ** 2 - sine[1:] ** 2)
    return areas


def _errors(
    counts: dict[str, _Counts],
    totals: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]],
    weights: NDArray[np.float64],
) -> tuple[float, float]:
    """Relative error of the whole, before trees are reduced, and of the worst direction's total."""
    error = sum(float(weights @ c.sigma.sum(axis=1, dtype=np.float64)) for c in counts.values())
    light = sum(float(weights @ total) for total, _ in totals.values())
    worst = max(float((STUDENT_95 * sigma / np.maximum(total, 0.1)).max()) for total, sigma in totals.values())
    return float(np.sqrt(2 / np.pi)) * error / max(light, 1e-30), worst
