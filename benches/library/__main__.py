"""Measure the library: `python -m benches.library [FOLDER OF REAL FILES]`, a Markdown table.

Trees: Radiance's sample t3.xml (rank 3), a sawtooth that is traced here at 2^6, and smooth functions with a peak that
the Rust benchmark makes at 2^5 and 2^6. Rust is measured by `cargo bench -p bsdftree --bench library`, NumPy with
arrays of as many pairs, Radiance's library (pyradiance) as Python programs can ask it: a call for each pair, less what
such a call costs by itself. All in CPU time on one thread, the best of several runs. A figure with a ✗ misses its
target.
"""

from __future__ import annotations

import json
import os

os.environ["RAYON_NUM_THREADS"] = "1"

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyradiance.bsdf as library
from benches.beside_radiance import cpu_name, degrees, directions, held
from benches.library.targets import TARGETS

import bsdftree
from bsdftree import Bsdf, Matrix, Tree
from bsdftree._radiance.reduce import write_reduced

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("BSDFTREE_DATA", ROOT.parent / "shared/data"))
CARGO = ("cargo", "bench", "--quiet", "-p", "bsdftree", "--bench", "library", "--")
# As many as the Rust benchmark has: with more, what arrays take of the caches differs.
N = 1 << 18
N_RADIANCE = 20_000
LARGE = 500_000
Figures = dict[str, float]


def best(work: Callable[[], object], repeats: int = 7) -> float:
    """Shortest CPU time of this thread [s]."""
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return min(times)


def largest(b: Bsdf) -> Tree | Matrix:
    return max(b.components.values(), key=lambda c: c.n_leaves if isinstance(c, Tree) else c.values.size)


def by_rust(files: list[Path], *options: str) -> dict[str, Figures]:
    """Figures of the Rust benchmark by file."""
    command = [*CARGO, "--json", *options, *map(str, files)]
    printed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    figures: dict[str, Figures] = {str(path): {} for path in files}
    for line in printed.stdout.splitlines():
        found = json.loads(line)
        figures[found["on"]] |= {found["what"]: found["value"], "values": found["values"], "bytes": found["bytes"]}
    return figures


def by_numpy(path: Path) -> Figures:
    """Per cent of the Rust rate just before and after, of the component with most values, reflecting to the room."""
    rng = np.random.default_rng(1)
    tree = largest(bsdftree.load(path, strict=False))
    assert isinstance(tree, Tree)
    b = Bsdf.from_trees({"reflection_back": tree})
    incident, exitant, u = directions(N, 1, rng), directions(N, 1, rng), rng.random(N)
    works = {
        "eval": lambda: b.eval(incident, exitant),
        "sample, pdf, weight": lambda: b.sample(incident, u),
        "pdf": lambda: b.pdf(incident, exitant),
        "hemispherical": lambda: b.hemispherical(incident),
        "projected solid angle": lambda: b.projected_solid_angle(incident, exitant),
    }

    def share(what: str, work: Callable[[], object]) -> float:
        def rate() -> float:
            return by_rust([path], f"--only={what}")[str(path)][what]

        before, numpy, after = rate(), N / best(work) / 1e6, rate()
        return 100 * numpy / max(before, after)

    return {f"NumPy: {what}": share(what, work) for what, work in works.items()}


def by_radiance(path: Path, call: float) -> Figures:
    """Its library on the same XML; values are compared first."""
    rng = np.random.default_rng(1)
    start = time.process_time()
    theirs = held(path)
    figures = {"XML read": path.stat().st_size / (time.process_time() - start) / 1e6}
    b = bsdftree.load(path, strict=False)
    side = 1 if any(key.startswith("reflection_back") for key in b.components) else -1
    incident, exitant = directions(N_RADIANCE, side, rng), directions(N_RADIANCE, side, rng)
    angles = np.hstack([degrees(incident), degrees(exitant)]).tolist()
    values = np.array([library.query(theirs, *a)[1] for a in angles])
    agree = np.isclose(values, b.eval(incident, exitant), rtol=5e-4, atol=1e-9).mean()
    assert agree > 0.995, f"{path.name}: only {agree:.1%} of values agree"
    seconds = best(lambda: [library.query(theirs, *a) for a in angles], 3) / N_RADIANCE
    figures["eval, single calls"] = 1e-6 / max(seconds - call, 1e-9)
    some = angles[:2000]
    seconds = best(lambda: [library.sample(theirs, *a[:2], 1, library.SAMPLE_ALL) for a in some], 3) / len(some)
    figures["sample, single calls"] = 1e-6 / max(seconds - call, 1e-9)
    return figures


def of_radiance(title: str, path: Path, data: Path, folder: Path) -> Figures:
    """How many times smaller .bsdft is than XML of Radiance: its own file, or what its reducer writes of all cells."""
    written = data / f"pyradiance/{title}"
    if not written.is_file():
        written = folder / "reduced.xml"
        tree = largest(bsdftree.load(path))
        assert isinstance(tree, Tree)
        write_reduced(written, tree.to_grid(tree.depth), tree.rank, tree.depth, 90, average=False)
    b = bsdftree.load(written, strict=False)
    twin = folder / "twin.bsdft"
    sizes = {}
    for name, level in (("", None), (" packed at 3", 3), (" packed at 19", 19)):
        b.save(twin, packed=level is not None, level=level or 19)
        sizes[f"Radiance's XML by bsdft{name}"] = written.stat().st_size / twin.stat().st_size
    return sizes


def call_cost(folder: Path) -> float:
    """Time of a call from Python that has next to nothing to do [s]."""
    path = folder / "white.xml"
    Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.2))}).save(path)
    theirs = held(path)
    return best(lambda: [library.query(theirs, 30.0, 40.0, 50.0, 60.0) for _ in range(N_RADIANCE)]) / N_RADIANCE


def cold(path: Path) -> Figures:
    """A process of its own that does what `bsdftree info` does."""
    build = ["cargo", "build", "--quiet", "--release", "-p", "bsdftree", "--example", "info"]
    subprocess.run(build, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    runs = []
    for _ in range(7):
        before = os.times()
        command = [target / "release/examples/info", "--memory", path]
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        after = os.times()
        kibibytes = int(printed.rpartition("memory at most:")[2].split()[0])
        runs.append((sum(after[2:4]) - sum(before[2:4]), 1024 * kibibytes))
    memory = sum(c.nbytes for c in bsdftree.load(path).components.values()) + path.stat().st_size
    seconds, _ = min(runs)
    peak = min(peak for _, peak in runs)
    return {
        "XML read, cold process": path.stat().st_size / seconds / 1e6,
        "memory of that by file and tree": peak / memory,
    }


def trees(data: Path, folder: Path) -> dict[str, Path]:
    """What is measured, as .bsdft files, by name; XML files beside them."""
    subprocess.run([*CARGO, f"--save={folder}"], cwd=ROOT, check=True)
    sawtooth = bsdftree.generate("sawtooth", rank=4, log2_res=6, samples=40, seed=1, prune=False)
    sawtooth.save(folder / "sawtooth.bsdft")
    bsdftree.load(data / "pyradiance/t3.xml", strict=False).save(folder / "t3.bsdft")
    names = {
        "t3.xml": "t3",
        "smooth 2^5": "smooth-5",
        "smooth 2^6": "smooth-6",
        "sawtooth 2^6": "sawtooth",
    }
    for name in names.values():
        bsdftree.load(folder / f"{name}.bsdft").save(folder / f"{name}.xml")
    return {title: folder / f"{name}.bsdft" for title, name in names.items()}


def show(files: dict[str, Path], ours: dict[str, Figures], theirs: dict[str, Figures]) -> None:
    large = {title: ours[title]["values"] > LARGE for title in files}
    print("| what | unit | target |", " | ".join(files), "| Radiance |")
    print("|---|---|---:|" + "---:|" * (len(files) + 1))
    sizes = [f"{ours[title]['values'] / 1e6:.3g} M, {ours[title]['bytes'] / 1e6:.3g} MB" for title in files]
    print("| *values, memory* | | |", " | ".join(sizes), "| |")
    for target in TARGETS:
        cells = []
        for title in files:
            value = ours[title].get(target.what)
            met = None if value is None else target.is_met(value, large[title])
            cells.append("" if value is None else f"{value:.3g}{' ✗' if met is False else ''}")
        wanted = [f"{w:g}" for w in dict.fromkeys((target.small, target.large)) if w is not None]
        sign = "≤ " if target.less_is_better else "≥ "
        radiance = [f"{theirs[title][target.what]:.2g}" for title in files if target.what in theirs[title]]
        row = (target.what, target.unit, sign + " / ".join(wanted) if wanted else "", *cells, " · ".join(radiance))
        print("|", " | ".join(row), "|")


def main() -> None:
    data = Path(sys.argv[1]) if len(sys.argv) > 1 else DATA
    if not data.is_dir():
        raise SystemExit(f"no data folder at {data}; name it or set BSDFTREE_DATA")
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"{cpu_name()}, {os.cpu_count()} cores{load}; bsdftree {bsdftree.__version__}\n")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        files = trees(data, folder)
        measured = by_rust(list(files.values()))
        ours = {title: measured[str(path)] for title, path in files.items()}
        call = call_cost(folder)
        theirs = {title: by_radiance(path.with_suffix(".xml"), call) for title, path in files.items()}
        for title, path in files.items():
            ours[title] |= by_numpy(path) | of_radiance(title, path, data, folder)
            if ours[title]["values"] > LARGE:
                ours[title] |= cold(path.with_suffix(".xml"))
        show(files, ours, theirs)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # Without freeing what Radiance's library holds.
