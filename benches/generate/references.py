"""What is taken for the truth: dense grids from many paths, kept in a folder between runs.

Two independent halves, of which nothing is merged and no pairs are swapped; each averaged with its mirror image in the
plane x = 0, which every device here is symmetric about (that the images agree within noise is asserted). The mean is
the reference, and the difference of the halves tells its own error, printed as "floor". RMS errors are freed of it; L1
errors are not, and hold for what lies well above the floor.

Diffused light is reused where `generate()` can do that. Such a reference is checked against plain paths: means over
blocks of cells have to agree within the noise of both.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import bsdftree

from . import ours
from .devices import Scene
from .errors import Errors, Grids, errors, grids, total

LOG2_BLOCKS = 3
"""Means over 2^3 cells per axis are compared with plain paths."""
PLAIN = 4
"""One plain path for so many of those that share diffused light."""


@dataclass(frozen=True)
class Reference:
    values: Grids
    samples: int
    floor: Errors
    total: float
    to_plain: float
    """RMS difference to plain paths, over blocks of cells, over what noise explains; NaN if it is from plain paths."""

    def errors(self, values: Grids) -> Errors:
        """Errors of values; RMS without the reference's own noise, which is independent of them."""
        seen = errors(values, self.values)
        return replace(seen, rms=float(np.sqrt(max(seen.rms**2 - self.floor.rms**2, 0.0))))


def mirrored(values: Grids) -> Grids:
    return {key: v[::-1, :, ::-1, :] for key, v in values.items()}


def mean(a: Grids, b: Grids) -> Grids:
    return {key: 0.5 * (a[key] + b[key]) if a.keys() >= {key} <= b.keys() else 0.5 * (a | b)[key] for key in a | b}


def reference(scene: Scene, log2_res: int, samples: int, folder: Path) -> Reference:
    """Reference of a device; from the folder, if it has been made before."""
    options = {"reuse": True} if ours.accepts("reuse") else {}
    # What `generate()` is asked, not how it does it: the truth does not change with versions.
    asked = (scene.text, log2_res, samples, sorted(options.items()), *scene.period)
    name = hashlib.sha256(repr(asked).encode()).hexdigest()[:16]
    path = folder / f"{scene.name.replace(' ', '-')}-{log2_res}-{name}.npz"
    if not path.exists():
        _make(scene, log2_res, samples, path, ours.known(ours.SOBOL | options) | scene.options)
    with np.load(path) as stored:
        floor = Errors(*map(float, stored["floor"]))
        values = {key: stored[key] for key in stored.files if key not in ("floor", "to_plain")}
        return Reference(values, samples, floor, total(values), float(stored["to_plain"]))


def _make(scene: Scene, log2_res: int, samples: int, path: Path, options: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    device = scene.write(path.parent)
    blocks = min(log2_res, LOG2_BLOCKS)
    (a, b), reused = _halves(device, log2_res, samples, blocks, options)
    to_plain = float("nan")
    if options.get("reuse"):
        _, plain = _halves(device, log2_res, samples // PLAIN, blocks, options | {"reuse": False})
        noise = sum(errors(x, y).rms ** 2 / 4 for x, y in (reused, plain))
        to_plain = errors(mean(*reused), mean(*plain)).rms / np.sqrt(noise)
        if to_plain > 2:
            raise RuntimeError(f"{scene.name}: reuse differs from plain paths by {to_plain:.1f} times the noise")
    device.unlink()
    by_symmetry, by_chance = errors(a, mirrored(a)).l1, errors(a, b).l1
    if by_symmetry > 1.25 * by_chance:
        raise RuntimeError(
            f"{scene.name}: differs from its mirror image by {by_symmetry}, from a second by {by_chance}"
        )
    a, b = (mean(half, mirrored(half)) for half in (a, b))
    gap = errors(a, b)
    # Of the mean of two: its error is in the mean half of their difference.
    floor = np.array([gap.l1 / 2, gap.rms / 2, gap.worst / 2])
    temporary = path.with_suffix(".part.npz")
    np.savez(temporary, floor=floor, to_plain=np.array(to_plain), **mean(a, b))  # type: ignore[arg-type]
    temporary.rename(path)


def _halves(
    device: Path, log2_res: int, samples: int, blocks: int, options: dict[str, Any]
) -> tuple[tuple[Grids, Grids], tuple[Grids, Grids]]:
    """Two halves, and their means over 2^blocks cells per axis."""
    fine, coarse = [], []
    for seed in (1001, 1002):
        made = bsdftree.generate(
            device, rank=4, log2_res=log2_res, sides="front", samples=samples // 2, prune=False, seed=seed, **options
        )
        fine.append(grids(made, log2_res))
        coarse.append(grids(made, blocks))
        del made
    return (fine[0], fine[1]), (coarse[0], coarse[1])
