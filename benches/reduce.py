"""Reduced trees beside Radiance's rttree_reduce (pyradiance) at equal numbers of leaves: a Markdown table, a picture.

    python benches/reduce.py [FOLDER] [LOG2_RES]    picture to FOLDER, docs/img by default; grids of 2^5 per axis

Grids are full: what the generator counts without pruning, and a formula at the middles of cells. CPU seconds: ours of
the reduction in the process, Radiance's of its program, which reads and writes too.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bsdftree
from bsdftree import Tree
from bsdftree._directions import direction_from_square
from bsdftree._radiance.reduce import reduced as radiance_reduced
from bsdftree.plot._style import FAINT, INK, figure, save

CULLS = (50.0, 80.0, 90.0, 97.0, 99.0, 99.7)


def rough_metal(log2_res: int) -> NDArray[np.float32]:
    """Diffuse, a broad lobe and a narrow one."""
    n = 1 << log2_res
    x, y = np.meshgrid(*2 * [(np.arange(n) + 0.5) / n], indexing="ij")
    exitant = direction_from_square(x, y).reshape(-1, 3)
    incident = exitant * [-1.0, -1.0, 1.0]
    values = np.empty((n * n, n * n), np.float32)
    for row, i in zip(values, incident, strict=True):
        h = i + exitant
        tan2 = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
        row[:] = 0.05
        for roughness, share in ((0.3, 0.2), (0.08, 0.4)):
            lobe = np.exp(-tan2 / roughness**2) / (np.pi * roughness**2)
            row += share * lobe * (h**2).sum(1) / h[:, 2] ** 4
    return values


def traced(device: str, component: str, log2_res: int) -> NDArray[np.float32]:
    """Return counts of a device, not pruned."""
    b = bsdftree.generate(device, log2_res=log2_res, samples=20_000, prune=False)
    return b.components[component].to_grid(log2_res)


def main() -> None:
    """Print the table and write the picture."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/img")
    log2_res = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    subjects = {
        "sawtooth": traced("sawtooth", "reflection_back", log2_res),
        "blinds": traced("blinds", "transmission_front", log2_res),
        "rough metal": rough_metal(log2_res),
    }
    picture = figure(1500, 440)
    print("| grid | by | leaves | XML MB | .bsdft MB | L1 % | RMS % | totals %, mean | worst | CPU s |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for column, (name, values) in enumerate(subjects.items(), 1):
        whole = Tree.from_grid(values.reshape((1 << log2_res,) * 4))
        curves: dict[str, list[tuple[int, float, float]]] = {}
        for cull in CULLS:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            theirs = Tree(radiance_reduced(values.reshape(-1), 4, log2_res, cull, average=False))
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            row(name, f"rttree_reduce {cull:g} %", whole, theirs, seconds, curves.setdefault("rttree_reduce", []))
            for norm in ("l1", "rms"):
                start = time.process_time()
                ours = whole.reduce(n_leaves=theirs.n_leaves, norm=norm)
                row(name, norm, whole, ours, time.process_time() - start, curves.setdefault(f"least {norm}", []))
            start = time.process_time()
            kept = whole.reduce(l1=whole.loss_of(theirs).l1, total=0.01)
            row(
                name,
                "same L1, totals 1 %",
                whole,
                kept,
                time.process_time() - start,
                curves.setdefault("totals kept", []),
            )
        for k, (label, key) in enumerate((("relative L1 error", 1), ("worst total's error", 2))):
            axes = picture.add_subplot(2, 3, column + 3 * k)
            for way, points in curves.items():
                points.sort()
                axes.loglog([p[0] for p in points], [max(p[key], 1e-6) for p in points], "o-", markersize=3, label=way)
            axes.set_title(name if k == 0 else "", color=INK)
            axes.set_xlabel("leaves" if k else "")
            axes.set_ylabel(label)
            axes.grid(color=FAINT, alpha=0.25)
        axes.legend(frameon=False, fontsize=8)
    picture.tight_layout()
    save(picture, folder / "reduce.png")


def row(name: str, way: str, whole: Tree, tree: Tree, seconds: float, curve: list[tuple[int, float, float]]) -> None:
    """Print one row."""
    loss = whole.loss_of(tree)
    curve.append((tree.n_leaves, loss.l1, loss.worst_total))
    b = bsdftree.Bsdf.from_trees({"reflection_back": tree})
    megabytes = [len(b.to_xml().encode()) / 1e6, tree.nbytes / 1e6]
    numbers = " | ".join(f"{100 * e:.2f}" for e in (loss.l1, loss.rms, loss.mean_total, loss.worst_total))
    sizes = " | ".join(f"{m:.2f}" for m in megabytes)
    print(f"| {name} | {way} | {tree.n_leaves:,} | {sizes} | {numbers} | {seconds:.2f} |", flush=True)


if __name__ == "__main__":
    main()
