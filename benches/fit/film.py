"""Prismatic films as our own generator traces them, blurred: what a real, slightly imperfect film would show.

In: a device. `generate()` makes a tree of 2^7 cells per axis, kept in the cache. Out: a function of pairs of
directions (light from the front, leaving to the back): the tree with both of its directions jittered by a normal
distribution in direction cosines (so both the peaks and how they move with the incident direction are smooth),
INCIDENT_BLUR and EXITANT_BLUR. What would be blurred beyond the horizon is folded back. A weak haze is added, as every
film has it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bsdftree

from .formulas import Array

LOG2_RES = 7
PATHS = 256
"""Per incident cell; surfaces are smooth and few."""
INCIDENT_BLUR, EXITANT_BLUR = 0.02, 0.044
"""Standard deviation of direction cosines: 1.1° and 2.5° at the normal."""
HAZE = 0.02
"""Hemispherical transmittance of light that is diffused."""
SAMPLES = 2**14
GRID = 256
NEAR = np.radians(8.0)
"""About half of what lies between two incident directions of a measurement."""
CHANGE = 1.5
"""Of transmittance within that: more is total internal reflection setting in."""


def low_discrepancy(n: int, dimensions: int) -> Array:
    """Roberts's R sequence, (n, dimensions) in [0, 1)."""
    root = 2.0
    for _ in range(60):
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1, dimensions + 1)
    return (0.5 + steps * np.arange(1, n + 1)[:, None]) % 1.0


def _normal(u: Array) -> Array:
    """Pairs of normally distributed numbers from pairs in [0, 1)."""
    radius = np.sqrt(-2 * np.log(1 - u[:, :1]))
    turn = 2 * np.pi * u[:, 1:2]
    return radius * np.concatenate([np.cos(turn), np.sin(turn)], axis=1)


def _folded(xy: Array) -> Array:
    radius = np.linalg.norm(xy, axis=1, keepdims=True)
    return np.where(radius > 1, xy * (np.maximum(2 - radius, 0) / np.maximum(radius, 1)), xy)


@dataclass
class Film:
    tree: bsdftree.Bsdf
    _last: dict[bytes, Array] = field(default_factory=dict)

    def __call__(self, incident: Array, exitant: Array) -> Array:
        values = np.zeros(len(incident))
        directions, which = np.unique(incident.round(9), axis=0, return_inverse=True)
        for k, direction in enumerate(directions):
            mine = (which.ravel() == k) & (exitant[:, 2] < 0)
            if direction[2] > 0:
                values[mine] = _interpolated(self._slice(direction), exitant[mine, :2]) + HAZE / np.pi
        return values

    def _slice(self, incident: Array) -> Array:
        """BSDF on a grid of GRID² places (x, y) in [−1, 1]² of exitant directions, (GRID, GRID)."""
        key = incident.tobytes()
        if key not in self._last:
            if len(self._last) > 64:
                self._last.clear()
            self._last[key] = self._traced(incident)
        return self._last[key]

    def _traced(self, incident: Array) -> Array:
        u = low_discrepancy(SAMPLES, 6)
        xy = _folded(incident[:2] + INCIDENT_BLUR * _normal(u[:, :2]))
        z = np.sqrt(np.maximum(1 - np.sum(xy * xy, axis=1), 1e-6))
        leaves = self.tree.sample(np.column_stack([xy, z]), u[:, 2:4], part="transmission")
        to = _folded(leaves.exitant[:, :2] + EXITANT_BLUR * 0.5 * _normal(u[:, 4:6]))
        return _blurred(_deposited(to, np.where(leaves.pdf > 0, leaves.weight, 0.0) / SAMPLES))

    def near_reflection(self, incident: Array) -> NDArray[np.bool_]:
        """Whether transmittance changes fast enough within NEAR for a lobe to be switching off, (n,)."""
        theta, phi = np.meshgrid(np.linspace(0, NEAR, 5), np.arange(8) * np.pi / 4)
        steps = np.stack([theta * np.cos(phi), theta * np.sin(phi)], axis=-1).reshape(-1, 2)
        polar = np.arccos(np.clip(incident[:, 2], -1, 1))[:, None]
        turn = np.arctan2(incident[:, 1], incident[:, 0])[:, None]
        x, y = polar * np.cos(turn) + steps[:, 0], polar * np.sin(turn) + steps[:, 1]
        polar, turn = np.minimum(np.hypot(x, y), np.radians(88)), np.arctan2(y, x)
        around = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
        totals = self.tree.hemispherical(around, part="transmission")
        return np.asarray(totals.max(axis=1) > CHANGE * totals.min(axis=1))


def _deposited(xy: Array, weight: Array) -> Array:
    """Weights shared among the four places around, per projected solid angle."""
    place = (xy + 1) * GRID / 2 - 0.5
    low = np.floor(place).astype(int)
    part = place - low
    grid = np.zeros((GRID, GRID))
    for dx in (0, 1):
        for dy in (0, 1):
            share = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
            cell = np.clip(low + np.array([dx, dy]), 0, GRID - 1)
            np.add.at(grid, (cell[:, 0], cell[:, 1]), share * weight)
    return grid / (2 / GRID) ** 2


def _blurred(grid: Array) -> Array:
    """By what the jitter of half the width has left of EXITANT_BLUR."""
    sigma = EXITANT_BLUR * np.sqrt(0.75)
    frequency = np.fft.fftfreq(2 * GRID, 2 / GRID)
    low_pass = np.exp(-2 * (np.pi * sigma * frequency) ** 2)
    spectrum = np.fft.fft2(grid, (2 * GRID, 2 * GRID)) * low_pass[:, None] * low_pass
    return np.maximum(np.fft.ifft2(spectrum).real[:GRID, :GRID], 0.0)


def _interpolated(grid: Array, xy: Array) -> Array:
    place = np.clip((xy + 1) * GRID / 2 - 0.5, 0, GRID - 1.001)
    low = place.astype(int)
    a, b = (place - low).T
    i, j = low.T
    rows = (1 - a) * grid[i, j] + a * grid[i + 1, j], (1 - a) * grid[i, j + 1] + a * grid[i + 1, j + 1]
    return np.asarray((1 - b) * rows[0] + b * rows[1])


def film(name: str, device: bsdftree.Device | str, cache: Path, *, tile: bool) -> Film:
    """The film of a device, or of a spec such as "prism:angle_up=30"."""
    text = device if isinstance(device, str) else device.to_rad()
    asked = hashlib.sha256(repr((text, LOG2_RES, PATHS, tile)).encode()).hexdigest()[:16]
    path = cache / f"{name}-{asked}.bsdft"
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        made = bsdftree.generate(
            device, rank=4, log2_res=LOG2_RES, samples=PATHS, sides="front", tile=tile, reuse=False, seed=5
        )
        made.save(path)
    return Film(bsdftree.load(path))


def two_lobe_prism(radiance: Path) -> bsdftree.Device:
    """Radiance's prismatic glazing of two slopes (index 1.52), as its prism.cal computes it; flat side to the room."""
    return bsdftree.Device.parse(TWO_LOBES, directory=radiance)


TWO_LOBES = """
void prism2 film
11 coef1 dx1 dy1 dz1 coef2 dx2 dy2 dz2 prism.cal -rx 90
0
4 1.52 .2 .1 .2
film polygon sheet
0
0
12 0 0 0  1 0 0  1 1 0  0 1 0
"""
