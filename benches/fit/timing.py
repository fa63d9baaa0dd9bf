"""What the two cases of the issue cost, from readings to tree: wall time, CPU time and peak memory."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

from benches.generate.process import Cost, run

from . import contender, gonio, incumbent, truths

CASES = (
    ("33 x 3000 points, rank 4", "ward", 6, 60.0),
    ("33 x 3000 points, isotropic, rank 4", "ggx", 6, 60.0),
    ("9 x 3000 points, rank 3", "ggx-iso", 6, 5.0),
)
"""What, the material, our resolution, and the wall time [s] that is allowed on two cores."""
THEIRS = {"ward": 5, "ggx": 5, "ggx-iso": 6}
"""The incumbent's resolution: 2^6 at rank 4 takes it sixteen times as long as 2^5."""


def table() -> str:
    """Each of ours in a process of its own, start of Python and all; the incumbent's as they were kept."""
    rows = [
        "| case | ours | wall s | CPU s | MB | allowed s | incumbent | wall s | CPU s | MB |",
        "|------|------|-------:|------:|---:|----------:|-----------|-------:|------:|---:|",
    ]
    for what, name, log2_res, allowed in CASES:
        folder = truths.cache_folder()
        material = truths.find([name])[0]
        files = gonio.write(gonio.measure(material), folder / "scans" / name, name)
        ours = run([sys.executable, "-m", "benches.fit.timing", log2_res, material.rank, *files])
        kept = incumbent.tree(files, THEIRS[name], folder)
        theirs = kept.interpolant + kept.resampling
        rows.append(f"| {what} | 2^{log2_res} | {_shown(ours)} | {allowed:g} | 2^{THEIRS[name]} | {_shown(theirs)} |")
    return "\n".join(rows) + f"\n\nload {os.getloadavg()[0]:.1f} on {os.cpu_count()} threads"


def _shown(cost: Cost) -> str:
    return f"{cost.wall:.1f} | {cost.cpu:.1f} | {cost.memory / 1e6:.0f}"


def _one(log2_res: int, rank: int, files: list[Path]) -> None:
    import bsdftree

    start = time.perf_counter()
    fitted = bsdftree.fit(bsdftree.Measurement.load(files))
    between = time.perf_counter()
    made = fitted.trees(rank=rank, log2_res=log2_res, tolerance=contender.TOLERANCE).bsdf
    end = time.perf_counter()
    leaves = sum(tree.n_leaves for tree in made.components.values())
    print(f"fit {between - start:.1f} s, tree {end - between:.1f} s, {leaves} leaves", file=sys.stderr)


if __name__ == "__main__":
    _one(int(sys.argv[1]), int(sys.argv[2]), [Path(path) for path in sys.argv[3:]])
