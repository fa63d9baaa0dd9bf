"""What is taken for the truth: dense grids from many paths, kept in a folder between runs.

Two independent halves, of which nothing is merged and no pairs are swapped; each averaged with its mirror image in
the plane x = 0, which every device here is symmetric about (that the images agree within noise is asserted). The mean
is the reference, and the difference of the halves tells its own error, printed as "floor". RMS errors are freed of
it; L1 errors are not, and hold for what lies well above the floor.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import bsdftree

from .devices import Scene
from .errors import Errors, Grids, errors, grids, total
from .ours import SOBOL, known


@dataclass(frozen=True)
class Reference:
    values: Grids
    samples: int
    floor: Errors
    total: float

    def errors(self, values: Grids) -> Errors:
        """Errors of values; RMS without the reference's own noise, which is independent of them."""
        seen = errors(values, self.values)
        return replace(seen, rms=float(np.sqrt(max(seen.rms**2 - self.floor.rms**2, 0.0))))


def mirrored(values: Grids) -> Grids:
    return {key: v[::-1, :, ::-1, :] for key, v in values.items()}


def mean(a: Grids, b: Grids) -> Grids:
    return {key: 0.5 * (a[key] + b[key]) if a.keys() >= {key} <= b.keys() else 0.5 * (a | b)[key] for key in a | b}


def reference(scene: Scene, log2_res: int, samples: int, folder: Path, **options: Any) -> Reference:
    """Reference of a device; from the folder, if it has been made before."""
    # What `generate()` is asked, not how it does it: the truth does not change with versions.
    name = hashlib.sha256(repr((scene.text, log2_res, samples, sorted(options.items()))).encode()).hexdigest()[:16]
    path = folder / f"{scene.name.replace(' ', '-')}-{log2_res}-{name}.npz"
    if not path.exists():
        _make(scene, log2_res, samples, path, known(SOBOL | options))
    with np.load(path) as stored:
        floor = Errors(*map(float, stored["floor"]))
        values = {key: stored[key] for key in stored.files if key != "floor"}
    return Reference(values, samples, floor, total(values))


def _make(scene: Scene, log2_res: int, samples: int, path: Path, options: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    device = scene.write(path.parent)
    halves = []
    for seed in (1001, 1002):
        made = bsdftree.generate(
            device,
            rank=4,
            log2_res=log2_res,
            sides="front",
            samples=samples // 2,
            prune=False,
            seed=seed,
            **options,
        )
        halves.append(grids(made, log2_res))
        del made
    device.unlink()
    a, b = halves
    by_symmetry, by_chance = errors(a, mirrored(a)).l1, errors(a, b).l1
    if not 0.8 < by_symmetry / by_chance < 1.25:
        raise RuntimeError(
            f"{scene.name}: differs from its mirror image by {by_symmetry}, from a second by {by_chance}"
        )
    a, b = (mean(half, mirrored(half)) for half in halves)
    gap = errors(a, b)
    # Of the mean of two: its error is in the mean half of their difference.
    floor = [gap.l1 / 2, gap.rms / 2, gap.worst / 2]
    temporary = path.with_suffix(".part.npz")
    np.savez(temporary, floor=np.array(floor), **mean(a, b))  # type: ignore[arg-type]
    temporary.rename(path)
