"""Measure bsdftree beside Radiance (pyradiance) on the same files and devices, one thread each: a Markdown table.

    python benches/beside_radiance.py [FOLDER OF REAL FILES]

Radiance's library is asked as Python programs can: one call for a pair (`query`), one for a direction (`sample`). What
such a call costs by itself is measured with a Lambertian file and stands in the remarks. Generation is genBSDF's
method, rfluxmtx with its settings, by `pyradiance.genbsdf`. One of its primaries sends out up to 700 rays where it
meets a diffuse surface and ours follows one path, so that the last rows compare what counts: CPU time for equal noise.
"""

from __future__ import annotations

import os

os.environ["RAYON_NUM_THREADS"] = "1"

import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyradiance
import pyradiance.bsdf as library
from pyradiance.genbsdf import generate_bsdf, generate_xml

import bsdftree
from bsdftree import Bsdf, Device, Tree

DATA = Path(os.environ.get("BSDFTREE_DATA", Path(__file__).resolve().parents[2] / "shared/data"))
SEED = 1
PRIMARIES = 60


def best(work: Callable[[], Any], repeats: int = 3) -> float:
    """Shortest wall time [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def cpu(work: Callable[[], Any]) -> tuple[float, Any]:
    """CPU time of this process and those it starts [s], and the result."""
    before = os.times()
    result = work()
    after = os.times()
    return sum(after[:4]) - sum(before[:4]), result


def directions(n: int, side: int, rng: np.random.Generator) -> np.ndarray:
    radius, azimuth = np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), side * np.sqrt(1 - radius**2)], axis=1)


def degrees(d: np.ndarray) -> np.ndarray:
    return np.degrees(np.stack([np.arccos(d[:, 2]), np.arctan2(d[:, 1], d[:, 0]) % (2 * np.pi)], axis=1))


def row(
    what: str, on: str, unit: str, ours: float, theirs: float, remark: str = "", less_is_better: bool = False
) -> None:
    ratio = theirs / ours if less_is_better else ours / theirs
    print(f"| {what} | {on} | {unit} | {ours:.3g} | {theirs:.3g} | {ratio:.3g} | {remark} |", flush=True)


def held(path: Path) -> library.SDData:
    """Radiance's reading of a file, kept to the end of the program: freeing may crash it."""
    _HELD.append(library.load_file(str(path)))
    return _HELD[-1]


_HELD: list[library.SDData] = []


def measure_queries(path: Path, call: float) -> None:
    """Evaluation and sampling; values are compared first, so that a wrong engine fails."""
    rng = np.random.default_rng(SEED)
    b, theirs, n = bsdftree.load(path, strict=False), held(path), 20_000
    incident, exitant = directions(n, 1, rng), directions(n, -1, rng)
    angles = np.hstack([degrees(incident), degrees(exitant)]).tolist()
    values = np.array([library.query(theirs, *a)[1] for a in angles])
    agree = np.isclose(values, b.eval(incident, exitant), rtol=5e-4, atol=1e-9).mean()
    assert agree > 0.995, f"{path.name}: only {agree:.1%} of values agree"

    many = [np.tile(d, (50, 1)) for d in (incident, exitant)]
    ours = len(many[0]) / best(lambda: b.eval(*many))
    seconds = best(lambda: [library.query(theirs, *a) for a in angles]) / n
    remark = f"scalar calls; without the call's {1e6 * call:.2f} µs: {1 / (seconds - call):.3g}"
    row("eval", path.name, "pairs/s", ours, 1 / seconds, remark)

    n_one = 500_000
    u, one = rng.random(n_one), np.broadcast_to(incident[0], (n_one, 3))
    drawn = library.sample(theirs, *angles[0][:2], n_one, library.SAMPLE_ALL)[:, :3]
    gap = abs(b.sample(one, u).exitant.mean(axis=0) - drawn.mean(axis=0)).max()
    assert gap < 0.005, f"{path.name}: mean sampled directions differ by {gap}"
    ours = n_one / best(lambda: b.sample(one, u))
    seconds = best(lambda: library.sample(theirs, *angles[0][:2], n_one, library.SAMPLE_ALL))
    row(
        "sample, one incident direction",
        path.name,
        "samples/s",
        ours,
        n_one / seconds,
        "its loop is in C; ours gives pdf too",
    )

    ours = n / best(lambda: b.sample(incident, u[:n]))
    seconds = best(lambda: [library.sample(theirs, *a[:2], 1, library.SAMPLE_ALL) for a in angles])
    row("sample, random incident directions", path.name, "samples/s", ours, n / seconds, "scalar calls, tables cached")


def call_cost(folder: Path) -> float:
    """Time of a call from Python that has next to nothing to do [s]."""
    path = folder / "white.xml"
    Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.2))}).save(path)
    theirs, n = held(path), 20_000
    return best(lambda: [library.query(theirs, 30.0, 40.0, 50.0, 60.0) for _ in range(n)]) / n


def measure_load(path: Path, folder: Path) -> None:
    ours = best(lambda: bsdftree.load(path, strict=False))
    # It keeps what it has read by name.
    copies = iter([shutil.copy(path, folder / f"{k}-{path.name}") for k in range(3)])
    theirs = best(lambda: held(next(copies)))
    remark = f"{path.stat().st_size / 1e6:.1f} MB"
    row("load", path.name, "ms", 1e3 * ours, 1e3 * theirs, remark, less_is_better=True)


def variance(a: Bsdf, b: Bsdf) -> float:
    """Variance of f, summed over the cells of all components, from two independent runs."""
    pairs = [(x.values, b.components[key].values) for key, x in a.components.items()]
    return sum(float(((x - y) ** 2).sum()) / 2 for x, y in pairs)


def measure_generation(name: str, spec: str, folder: Path) -> None:
    """Klems quarter basis, both sides."""
    device = folder / f"{name}.rad"
    device.write_text(Device.from_spec(spec).to_rad())

    def theirs(samples: int) -> Bsdf:
        made = generate_bsdf(str(device), basis="kq", nsamp=samples, nproc=1)
        path = folder / "theirs.xml"
        path.write_bytes(generate_xml(vis_results=made, basis="kq"))
        return bsdftree.load(path, strict=False)

    def ours(samples: int, seed: int) -> Bsdf:
        return bsdftree.generate(device, klems="quarter", samples=samples, seed=seed, threads=1)

    # genBSDF rounds the number of its rays up to a grid over the aperture; the second run must draw others.
    counts, runs = (PRIMARIES, PRIMARIES + 12), 20_000
    (cpu_a, a), (cpu_b, b) = (cpu(lambda n=n: theirs(n)) for n in counts)
    (cpu_c, c), (cpu_d, d) = (cpu(lambda s=s: ours(runs, s)) for s in (1, 2))
    for key, component in a.components.items():
        gap = np.pi * abs(component.values.mean() - c.components[key].values.mean())
        assert gap < 0.02, f"{name}: {key} differs by {gap:.3f}"
    per_cell = 2 * 41
    theirs_rate, ours_rate = per_cell * sum(counts) / (cpu_a + cpu_b), per_cell * 2 * runs / (cpu_c + cpu_d)
    row("generate", name, "primaries/CPU s", ours_rate, theirs_rate, "theirs up to 700 rays a primary")
    costs = variance(c, d) * (cpu_c + cpu_d), variance(a, b) * (cpu_a + cpu_b)
    row("generate", name, "CPU s × variance", *costs, "time for equal noise", less_is_better=True)


def main() -> None:
    data = Path(sys.argv[1]) if len(sys.argv) > 1 else DATA
    if not data.is_dir():
        raise SystemExit(f"no data folder at {data}; name it or set BSDFTREE_DATA")
    print(f"{cpu_name()}; Python {platform.python_version()}, bsdftree {bsdftree.__version__}, ", end="")
    print(f"pyradiance {getattr(pyradiance, '__version__', '1.3')}; one thread\n")
    print("| what | on | unit | bsdftree | Radiance | ratio | remark |\n|---|---|---|---:|---:|---:|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        large = folder / "blinds-t4-6.xml"
        blinds = "blinds:angle=30,height=0.4,width=0.4"
        bsdftree.generate(blinds, rank=4, log2_res=6, samples=100, seed=1, prune=False).save(large)
        call = call_cost(folder)
        for path in (data / "pyradiance/t3.xml", data / "pyradiance/blinds.xml", large):
            measure_queries(path, call)
        for name in ("bsdfxmlparser/2011-SA1.XML", "pyradiance/ven45.xml", "pyradiance/t3.xml"):
            measure_load(data / name, folder)
        measure_load(large, folder)
        measure_generation("sawtooth", "sawtooth", folder)
        measure_generation("blinds", blinds, folder)


def cpu_name() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # Without freeing what Radiance's library holds.
