"""What resolution costs: trees of 2^4 to 2^8 cells per axis, paths per incident cell alike.

`its estimate` is what was reported. `noise` is the relative L1 difference of two trees of different seeds over √2, as
if each were off by as much; `to 2^8` is the difference of a tree to the finest one: noise of both and what the cells
blur. Both are estimated from directions that the trees choose themselves (`errors.sampled_difference`), since a dense
grid of 2^8 would have 4 · 10^9 cells.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import bsdftree

from .devices import RESOLUTION, Scene
from .errors import n_leaves, sampled_difference
from .process import Cost
from .process import run as run_program
from .tables import head, megabytes, row

SAMPLES = 500
DIRECTIONS = 1_000_000


@dataclass(frozen=True)
class Step:
    log2_res: int
    cost: Cost
    reducing: float
    leaves: int
    bytes: int
    estimated: float | None
    noise: float
    to_finest: float | None


def generate(device: Path, log2_res: int, samples: int, seed: int, work: Path) -> tuple[Path, Cost, dict[str, Any]]:
    """A tree as the command line makes it by default; the file, its cost, and what was said."""
    xml, summary = work / f"{device.stem}-{log2_res}-{seed}.xml", work / "resolution.json"
    command = [sys.executable, "-m", "bsdftree", "generate", device, "--sides", "front", "--log2-res", log2_res]
    cost = run_program([*command, "--samples", samples, "--seed", seed, "--json", "-o", xml], stdout=summary)
    return xml, cost, json.loads(summary.read_text())


def sweep(scene: Scene, resolutions: range, samples: int, work: Path) -> list[Step]:
    """From the finest, which the others are compared to."""
    device, rng = scene.write(work), np.random.default_rng(1)
    steps: list[Step] = []
    finest: bsdftree.Bsdf | None = None
    for log2_res in reversed(resolutions):
        made = [generate(device, log2_res, samples, seed, work) for seed in (1, 2)]
        a, b = (bsdftree.load(xml) for xml, _, _ in made)
        xml, cost, said = made[0]
        noise = sampled_difference(a, b, DIRECTIONS, rng) / np.sqrt(2)
        # Of another seed than the finest.
        blur: float | None = None if finest is None else sampled_difference(b, finest, DIRECTIONS, rng)
        finest = a if finest is None else finest
        reducing, estimated = said["reducing_seconds"], said.get("error")
        size = xml.stat().st_size
        steps.append(Step(log2_res, cost, reducing, n_leaves(a), size, estimated, noise, blur))
        for path, _, _ in made:
            path.unlink()
    return steps[::-1]


def run(quick: bool, work: Path, picture: Path) -> None:
    """Measure, print, draw."""
    resolutions, samples = (range(4, 7), SAMPLES // 4) if quick else (range(4, 9), SAMPLES)
    sweeps = {scene.name: sweep(scene, resolutions, samples, work) for scene in RESOLUTION}
    print("\n## Resolution")
    columns = (
        ">wall s",
        ">CPU s",
        ">of it reduction, wall s",
        ">peak MB",
        ">leaves",
        ">XML MB",
        ">its estimate",
        ">noise",
        f">to 2^{resolutions[-1]}",
    )
    note = f"{samples} paths per incident cell, light from the front, options by default."
    head("Cells per axis", "device", ">N", *columns, note=note)
    for name, steps in sweeps.items():
        for s in steps:
            memory, size, seen = megabytes(s.cost.memory), megabytes(s.bytes), (s.estimated, s.noise, s.to_finest)
            row(name, s.log2_res, s.cost.wall, s.cost.cpu, s.reducing, memory, s.leaves, size, *seen)
    draw(sweeps, picture)
    print(f"\n![What resolution costs]({picture})")


def draw(sweeps: dict[str, list[Step]], picture: Path) -> None:
    """Four costs over N, logarithmic, one line for each device."""
    plt.switch_backend("Agg")
    panels: dict[str, Callable[[Step], float]] = {
        "wall time [s]": lambda s: s.cost.wall,
        "leaves": lambda s: s.leaves,
        "peak memory [MB]": lambda s: megabytes(s.cost.memory),
        "noise (relative L1)": lambda s: s.noise,
    }
    figure, axes = plt.subplots(1, len(panels), figsize=(12, 3.4), layout="constrained")
    for axis, (label, value) in zip(axes, panels.items(), strict=True):
        for (name, steps), marker in zip(sweeps.items(), "os", strict=True):
            axis.plot([s.log2_res for s in steps], [value(s) for s in steps], marker=marker, label=name)
        axis.set_yscale("log")
        # Whole decades, so that little change looks like little.
        low, high = np.log10(axis.get_ylim())
        axis.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))
        axis.set_xticks([s.log2_res for s in steps], [f"$2^{{{s.log2_res}}}$" for s in steps])
        axis.set_xlabel("cells per axis")
        axis.set_title(label, fontsize="medium")
        axis.grid(alpha=0.3, which="both")
    axes[0].legend()
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=110)
    plt.close(figure)
