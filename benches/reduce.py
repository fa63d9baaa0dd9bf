"""Reduced trees beside Radiance's rttree_reduce (pyradiance) at equal numbers of leaves: a Markdown table, pictures.

    python benches/reduce.py [FOLDER] [LOG2_RES…]    pictures to FOLDER, docs/img by default; 5 and 6

Grids of 2^LOG2_RES cells per axis are full: what the generator counts without pruning, a formula at the middles of
cells, and a measurement (of the University of Arizona's, from BSDFTREE_DATA or ../shared/data) fitted without
tolerance. CPU seconds: ours of the reduction from the grid, in the process; Radiance's of its program, which reads and
writes too. The table has rttree_reduce's default percentage, 90, and 99; the pictures all.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import bsdftree
from bsdftree import Tree
from bsdftree._directions import direction_from_square
from bsdftree._radiance.reduce import reduced as radiance_reduced
from bsdftree.plot._style import FAINT, INK, figure, save

CULLS = (50.0, 80.0, 90.0, 97.0, 99.0, 99.7)
SHOWN = (90.0, 99.0)
DATA = Path(os.environ.get("BSDFTREE_DATA", "../shared/data"))
MEASURED = DATA / "ua-loft/processed/zemax/IMX455.bsdf"

Curves = dict[str, list[tuple[int, float, float]]]


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


def measured(log2_res: int) -> NDArray[np.float32]:
    """Return a camera chip's reflection as it was measured, fitted."""
    b = bsdftree.fit(MEASURED).bsdf(rank=4, log2_res=log2_res, tolerance=0.0)
    return b.components["reflection_back"].to_grid(log2_res)


def main() -> None:
    """Print the table and write the pictures."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/img")
    print("| grid | by | leaves | XML bytes | .bsdft bytes | L1 % | RMS % | totals %, mean | worst | CPU s |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for log2_res in [int(word) for word in sys.argv[2:]] or [5, 6]:
        subjects: dict[str, Callable[[], NDArray[np.float32]]] = {
            "sawtooth": lambda n=log2_res: traced("sawtooth", "reflection_back", n),
            "blinds": lambda n=log2_res: traced("blinds", "transmission_front", n),
            "smooth and peaky": lambda n=log2_res: rough_metal(n),
            "measured": lambda n=log2_res: measured(n),
        }
        picture = figure(1900, 560)
        for column, (name, make) in enumerate(subjects.items(), 1):
            values = make().reshape((1 << log2_res,) * 4)
            draw(picture, column, name, compared(f"{name} 2^{log2_res}", values, log2_res))
        picture.tight_layout()
        save(picture, folder / f"reduce-{log2_res}.png")


def compared(name: str, values: NDArray[np.float32], log2_res: int) -> Curves:
    """Reduce a grid by all ways, print some, and return leaves, L1 and worst totals of all."""
    whole, curves = Tree.from_grid(values), Curves()
    for cull in CULLS:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        theirs = Tree(radiance_reduced(values.reshape(-1), 4, log2_res, cull, average=False))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        n, worst = theirs.n_leaves, whole.loss_of(theirs).worst_total
        ways: dict[str, Callable[[], Tree]] = {
            "least L1": lambda n=n: Tree.from_grid(values, n_leaves=n),
            "least RMS": lambda n=n: Tree.from_grid(values, n_leaves=n, norm="rms"),
            "least L1, balanced": lambda n=n, w=worst: Tree.from_grid(values, n_leaves=n, balance=w / 6),
            "same L1, totals 1 %": lambda t=theirs: Tree.from_grid(values, tolerance=whole.loss_of(t).l1, total=0.01),
        }
        row(name, f"rttree_reduce {cull:g} %", whole, theirs, seconds, curves.setdefault("rttree_reduce", []), cull)
        for way, reduced in ways.items():
            start = time.process_time()
            tree = reduced()
            row(name, way, whole, tree, time.process_time() - start, curves.setdefault(way, []), cull)
    return curves


def draw(picture: Figure, column: int, name: str, curves: Curves) -> None:
    """Draw errors against leaves."""
    for k, label in enumerate(("relative L1 error", "worst total's error")):
        axes = picture.add_subplot(2, 4, column + 4 * k)
        for way, points in curves.items():
            points.sort()
            axes.loglog([p[0] for p in points], [max(p[k + 1], 1e-6) for p in points], "o-", markersize=3, label=way)
        axes.set_title("" if k else name, color=INK)
        axes.set_xlabel("leaves" if k else "")
        axes.set_ylabel(label if column == 1 else "")
        axes.grid(color=FAINT, alpha=0.25)
        if column == 1 and k == 0:
            axes.legend(frameon=False, fontsize=8)


def row(
    name: str,
    way: str,
    whole: Tree,
    tree: Tree,
    seconds: float,
    curve: list[tuple[int, float, float]],
    cull: float,
) -> None:
    """Add to a curve, and print a row if it is one that is shown."""
    loss = whole.loss_of(tree)
    curve.append((tree.n_leaves, loss.l1, loss.worst_total))
    if cull not in SHOWN:
        return
    b = bsdftree.Bsdf.from_trees({"reflection_back": tree})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tree.bsdft"
        b.save(path)
        sizes = [len(b.to_xml().encode()), path.stat().st_size]
    numbers = " | ".join(f"{100 * e:.2f}" for e in (loss.l1, loss.rms, loss.mean_total, loss.worst_total))
    print(
        f"| {name} | {way} | {tree.n_leaves:,} | {sizes[0]:,} | {sizes[1]:,} | {numbers} | {seconds:.2f} |", flush=True
    )


if __name__ == "__main__":
    main()
