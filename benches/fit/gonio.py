"""A goniophotometer's run over a known BSDF: where it looks, its noise, and the text files that it writes.

Per incident direction a coarse scan of the hemisphere finds the peaks, and the rest of the points are spent around
them, denser towards the middle. Every reading has multiplicative noise and that of a dark detector. Numbers have six
digits, in files as in arrays. Seeds are fixed: a material's run is the same in every run.

Files are "theta phi BSDF" as pab-opto's Mountain writes them; angles in degrees in the sample's frame (0 to 180 from
the front's normal; "upphi 90": phi counts from X). Radiance's pabopto2bsdf reads those, and so does bsdftree.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bsdftree

from .formulas import Array
from .truths import Material

POINTS, COARSE = 3000, 1000
"""Readings per incident direction, and how many of them are the coarse scan."""
HIGHEST = 85.0
"""Polar angle of readings, at most [degree]."""
NOISE = 0.02
"""Standard deviation of a reading, relative."""
DARK = 1e-3
"""Standard deviation of a dark reading, relative to the mean BSDF of the coarse scans."""
PEAK_RADIUS = 25.0
"""How far about a peak it looks closer [degree]."""
RINGS = ((0, 1, 0.0), (15, 4, 45.0), (30, 4, 0.0), (45, 8, 22.5), (60, 8, 0.0), (75, 8, 22.5))
"""Polar angle, number of azimuths, first azimuth: 33 incident directions."""
IN_PLANE = tuple(range(0, 81, 10))
"""Polar angles of an isotropic run: 9."""


@dataclass(frozen=True)
class Scan:
    """Readings of one incident direction [degree]: (n, 2) exitant polar angle and azimuth, (n,) BSDF [1/sr]."""

    theta: float
    phi: float
    exitant_deg: Array
    values: Array

    @property
    def incident(self) -> Array:
        return bsdftree.direction_from_polar(self.theta, self.phi)

    @property
    def exitant(self) -> Array:
        return bsdftree.direction_from_polar(self.exitant_deg[:, 0], self.exitant_deg[:, 1])


def incident_angles(rank: int) -> list[tuple[float, float]]:
    if rank == 3:
        return [(float(theta), 0.0) for theta in IN_PLANE]
    return [(float(theta), first + 360.0 * k / n) for theta, n, first in RINGS for k in range(n)]


def measure(material: Material, points: int = POINTS, noise: float = NOISE) -> list[Scan]:
    """All scans of a material; points per incident direction."""
    rng = np.random.default_rng(zlib.crc32(material.name.encode()))
    side = -1.0 if material.transmission else 1.0
    coarse = max(points * COARSE // POINTS, 100)
    shots = []
    for theta, phi in incident_angles(material.rank):
        incident = bsdftree.direction_from_polar(theta, phi)
        seen = _jittered(_spread(coarse), rng)
        seen[:, 2] *= side
        found = _peaks(seen, material(_rows(incident, len(seen)), seen))
        closer = _around(found, points - coarse, rng)
        shots.append((theta, phi, np.concatenate([seen, closer])))
    scans = []
    dark = DARK * np.mean([material(_rows(*_of(s), coarse), s[2][:coarse]).mean() for s in shots])
    for theta, phi, exitant in shots:
        angles = bsdftree.polar_from_direction(exitant).round(4)
        rounded = bsdftree.direction_from_polar(angles[:, 0], angles[:, 1])
        true = material(_rows(bsdftree.direction_from_polar(theta, phi), len(rounded)), rounded)
        read = true * (1 + noise * rng.standard_normal(len(true))) + dark * rng.standard_normal(len(true))
        scans.append(Scan(theta, phi, angles, _six_digits(np.maximum(read, 0.0))))
    return scans


def _of(shot: tuple[float, float, Array]) -> tuple[Array]:
    return (bsdftree.direction_from_polar(shot[0], shot[1]),)


def _rows(direction: Array, n: int) -> Array:
    return np.broadcast_to(direction, (n, 3))


def _spread(n: int) -> Array:
    """n directions evenly over the front up to HIGHEST: a Fibonacci spiral."""
    k = np.arange(n) + 0.5
    z = 1 - k / n * (1 - np.cos(np.radians(HIGHEST)))
    phi = k * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def _jittered(directions: Array, rng: np.random.Generator) -> Array:
    """What the arm makes of it: half a degree off, and not above HIGHEST."""
    return _lowered(directions + np.radians(0.5) * rng.standard_normal(directions.shape))


def _lowered(directions: Array) -> Array:
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    z = np.sign(unit[:, 2]) * np.maximum(np.abs(unit[:, 2]), np.cos(np.radians(HIGHEST)))
    flat = unit[:, :2] / np.linalg.norm(unit[:, :2], axis=1, keepdims=True)
    return np.column_stack([flat * np.sqrt(1 - z * z)[:, None], z])


def _peaks(directions: Array, values: Array) -> Array:
    """The brightest reading, and up to two others, brighter than all within 12 degrees and than a fifth of it."""
    order = np.argsort(-values)
    found: list[int] = []
    for k in order[values[order] > 0.2 * values[order[0]]]:
        near = directions @ directions[k] > np.cos(np.radians(12))
        if len(found) < 3 and values[k] >= values[near].max():
            found.append(int(k))
    return directions[found]


def _around(peaks: Array, n: int, rng: np.random.Generator) -> Array:
    """n directions on spirals about the peaks, as many per degree of radius."""
    made = []
    side = np.sign(peaks[0, 2])
    for k, axis in enumerate(peaks):
        mine = n // len(peaks) + (k < n % len(peaks))
        radius = np.radians(PEAK_RADIUS) * (np.arange(mine) + rng.random(mine)) / mine
        turn = np.arange(mine) * np.pi * (3 - np.sqrt(5)) + 2 * np.pi * rng.random()
        x = np.cross(axis, [0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [1.0, 0.0, 0.0])
        x /= np.linalg.norm(x)
        off = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * np.cross(axis, x)
        made.append(np.cos(radius)[:, None] * axis + np.sin(radius)[:, None] * off)
    directions = np.concatenate(made)
    directions[:, 2] = side * np.abs(directions[:, 2])
    return _lowered(directions)


def _six_digits(values: Array) -> Array:
    return np.array([float(f"{v:.6g}") for v in values])


def write(scans: list[Scan], folder: Path, name: str) -> list[Path]:
    """One text file per incident direction."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for k, scan in enumerate(scans):
        lines = [
            f'#sample_name "{name}"',
            "#format: theta phi BSDF",
            "#colorimetry: CIE-Y",
            f"#incident_angle {scan.theta:g} {scan.phi:g}",
            f"#intheta {scan.theta:g}",
            f"#inphi {scan.phi:g}",
            "#upphi 90",
        ]
        rows = zip(scan.exitant_deg, scan.values, strict=True)
        lines += [f"{theta:.4f} {phi:.4f} {value:.6g}" for (theta, phi), value in rows]
        paths.append(folder / f"{k:02d}.txt")
        paths[-1].write_text("\n".join(lines) + "\n")
    return paths
