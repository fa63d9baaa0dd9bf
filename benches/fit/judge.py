"""How far a contender is from the truth, on incident directions that were not measured.

**In cells** (trees, the verdict). For each left-out incident cell and all exitant cells of a grid of 2^log2_res per
axis, both the truth and the contender are averaged over the incident cell *and* the exitant cell, by the tree's own
measure (uniform in its coordinates: projected solid angle; at rank 3 uniform in sin θ of the incident direction). The
truth by 512 points (POINTS) of a low-discrepancy sequence in both cells together; a tree of the same resolution by its
value, a finer tree by all its cells within, anything else by points too. So no contender is charged for what a tree of
that resolution cannot show. bsdf2ttree samples the middle of incident cells only; so it is also compared with the truth
at the middle (averaged over exitant cells alone), and whichever is better for it counts. With `--klems` the cells are
the patches of a Klems matrix.

**Point by point** (fitted models, `--quick`). The middle of each left-out incident cell, one jittered exitant direction
in each of 64 × 64 cells.

Either way, per incident direction: `l1` = Σ |f − truth| Ω / Σ truth Ω; `total`, the relative error of the hemispherical
sum; `covered`, the share of true flux in directions where |f − truth| ≤ 2 standard errors.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .cells import Cells
from .contender import Contender
from .film import low_discrepancy
from .formulas import Array, Function
from .patches import Patches
from .truths import Material, cache_folder

POINTS = {"prism": 128}
"""For true means of a family; 512 for what is not traced."""
MODEL_POINTS = 32


@dataclass(frozen=True)
class Verdict:
    """Per left-out incident direction."""

    name: str
    l1: Array
    total: Array
    covered: Array | None
    seconds: float
    values: Array
    """What was found, and what is true: (incident, exitant)."""
    true: Array


@dataclass(frozen=True)
class Court:
    """Where a material is judged: left-out incident cells, whether inside the range, near total reflection."""

    material: Material
    cells: Cells
    incident: Array
    inside: Array
    near: Array

    @property
    def middle(self) -> Array:
        return self.cells.incident(self.incident, np.full(self.incident.shape, 0.5))

    @property
    def n_exitant(self) -> int:
        return len(self.cells.exitant(np.zeros(2)))

    @property
    def solid_angles(self) -> Array:
        """Of exitant cells, up to a factor."""
        return self.cells.solid_angles if isinstance(self.cells, Patches) else np.ones(self.n_exitant)

    @property
    def counts(self) -> Array:
        """Inside the measured range and away from total internal reflection: what targets are about."""
        return self.inside & ~self.near


def court(material: Material, log2_res: int, *, klems: bool = False) -> Court:
    """The cells of a tree, or the patches of a Klems matrix."""
    rank, transmission = material.rank, material.transmission
    cells = Patches(rank, 0, transmission) if klems else Cells(rank, log2_res, transmission)
    incident, inside = cells.left_out()
    middle = cells.incident(incident, np.full(incident.shape, 0.5))
    return Court(material, cells, incident, inside, material.near_reflection(middle))


def in_cells(court: Court, contender: Contender) -> Verdict:
    """Averaged over cells."""
    found = _contender_means(court, contender)
    verdict = _verdict(court, contender, found, truth(court), _errors(court, contender))
    if contender.name != "incumbent":
        return verdict
    other = _verdict(court, contender, found, truth(court, at_middle=True), None)
    return min(verdict, other, key=lambda v: float(v.l1[court.counts].mean()))


def point_by_point(court: Court, contender: Contender) -> Verdict:
    """At the middle of each left-out incident cell."""
    cells = Cells(court.material.rank, 6, court.material.transmission)
    exitant = cells.exitant(np.random.default_rng(3).random((cells.n**2, 2)))
    found, true, error = [], [], []
    for middle in court.middle:
        incident = np.repeat(middle[None], len(exitant), axis=0)
        found.append(contender.evaluate(incident, exitant))
        true.append(court.material(incident, exitant))
        error.append(contender.error(incident, exitant) if contender.error else np.zeros(len(exitant)))
    return _verdict(court, contender, np.array(found), np.array(true), np.array(error) if contender.error else None)


def _verdict(court: Court, contender: Contender, found: Array, true: Array, error: Array | None) -> Verdict:
    # Point by point there is a point in each of other cells, all of the same size.
    shares = court.solid_angles if found.shape[1] == court.n_exitant else np.ones(found.shape[1])
    found, true, error = found * shares, true * shares, None if error is None else error * shares
    flux = np.maximum(true.sum(axis=1), 1e-12)
    covered = None
    if error is not None:
        covered = np.sum(true * (np.abs(found - true) <= 2 * error), axis=1) / flux
    l1 = np.abs(found - true).sum(axis=1) / flux
    total = np.abs(found.sum(axis=1) - true.sum(axis=1)) / flux
    return Verdict(contender.name, l1, total, covered, contender.seconds, found / shares, true / shares)


def _means(court: Court, function: Function, points: Array) -> Array:
    """Means over cells by points (n, 4) in incident and exitant cell: (incident cells, exitant cells)."""
    means = np.zeros((len(court.incident), court.n_exitant))
    depth = court.incident.shape[1]
    for point in points:
        exitant = court.cells.exitant(point[2:])
        incident = court.cells.incident(court.incident, np.broadcast_to(point[:depth], court.incident.shape))
        for row, direction in zip(means, incident, strict=True):
            row += function(np.repeat(direction[None], len(exitant), axis=0), exitant)
    return means / len(points)


def truth(court: Court, *, at_middle: bool = False) -> Array:
    """True means over cells, or over exitant cells at the middle of incident cells; kept in the cache."""
    points = POINTS.get(court.material.family, 512)
    names = (*SOURCES, type(court.cells).__module__.rpartition(".")[2])
    source = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")) if path.stem in names)
    asked = (court.material.name, court.cells, court.incident.tolist(), at_middle, points)
    key = hashlib.sha256(repr(asked).encode() + source).hexdigest()[:16]
    path = cache_folder() / f"truth-{court.material.name}-{key}.npy"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        places = low_discrepancy(points, 4)
        if at_middle:
            places[:, :2] = 0.5
        np.save(path, _means(court, court.material, places))
    return np.asarray(np.load(path))


SOURCES = ("truths", "formulas", "merl", "diffuser", "film", "cells")


def _contender_means(court: Court, contender: Contender) -> Array:
    if contender.log2_res is None:
        return _means(court, contender.evaluate, low_discrepancy(MODEL_POINTS, 4))
    finer = 2 ** max(contender.log2_res - court.cells.log2_res, 0)
    place = (np.arange(finer) + 0.5) / finer
    axes = [place] * court.incident.shape[1] + [[0.5]] * (2 - court.incident.shape[1]) + [place, place]
    return _means(court, contender.evaluate, np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 4))


def _errors(court: Court, contender: Contender) -> Array | None:
    """Standard errors in the middle of cells: those of means are taken to be as large."""
    if contender.error is None:
        return None
    return _means(court, contender.error, np.full((1, 4), 0.5))
