"""Paths and rays per second, before anything is reduced.

Of paths: whole ones, with one thread and two, beside the bare closest hits that they ask for (example `paths` of the
crate). Of rays: closest hits beside Embree's single-ray queries in robust mode, the same rays through the same scenes
on one thread (example `rays`; Embree 3, Debian: libembree-dev). Both run by turns, and the best of each counts. Embree
decides in f32, so rays at edges may differ: by how many hits is printed. It has no quadrics: they are user geometry
(crates/bsdftree-generate/benches/embree/).
"""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

from .tables import head, row

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "crates/bsdftree-generate/benches/embree/embree.cpp"
SCENES = ["blind", "mesh", "quadrics"]
KINDS = "incoming,chords,bounces"
ROUNDS = 3

Rates = dict[tuple[str, str], tuple[float, int]]


def run(quick: bool, work: Path) -> None:
    """Build, measure, print."""
    if not shutil.which("cargo"):
        print("\nSKIPPED: raw speed needs cargo")
        return
    print("\n## Raw speed")
    paths()
    rays(1 if quick else ROUNDS, work)


def paths() -> None:
    """Whole paths beside the closest hits that they ask for."""
    columns = (
        ">M paths/s, 1 thread",
        ">2 threads",
        ">ratio",
        ">rays of a path",
        ">M closest hits/s",
        ">path ÷ its closest hits",
    )
    head("Whole paths", "device", *columns, note="Counted in the cells of a 2^3 tree, nothing reduced.")
    for line in printed([built("paths")]).splitlines():
        device, one, two, bare, n_rays, ratio = line.split()
        each, both = float(one) / 1e6, float(two) / 1e6
        row(device, each, both, both / each, float(n_rays), float(bare) / 1e6, float(ratio))


def rays(rounds: int, work: Path) -> None:
    """Closest hits beside Embree's."""
    ours, theirs = built("rays"), str(work / "embree")
    compile_theirs = ["g++", "-O3", "-march=native", str(SOURCE), "-o", theirs, "-lembree3"]
    if not shutil.which("g++") or subprocess.run(compile_theirs, check=False).returncode != 0:
        print("\nSKIPPED: Embree's rays need g++ and its headers (Debian: apt-get install g++ libembree-dev)")
        return
    printed([ours, str(work)])
    command = [theirs, str(work), *(f"{scene}:{KINDS}" for scene in SCENES)]
    pairs = [(rates(printed([ours])), rates(printed(command))) for _ in range(rounds)]
    mine, embree = (best([pair[k] for pair in pairs]) for k in range(2))
    columns = (">bsdftree M/s", ">Embree M/s", ">ratio", ">hits", ">Embree's more")
    head("Closest hits", "scene", "rays", *columns, note="One thread; Embree robust.")
    for key, (rate, hits) in mine.items():
        other, other_hits = embree[key]
        row(*key, rate / 1e6, other / 1e6, rate / other, hits, other_hits - hits)


def printed(command: list[str]) -> str:
    """What a command prints."""
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, cwd=ROOT).stdout


def built(example: str) -> str:
    """Builds an example; where it is."""
    build = ["cargo", "build", "--release", "--quiet", "-p", "bsdftree-generate", "--example", example]
    messages = printed([*build, "--message-format=json-render-diagnostics"])
    binaries = (json.loads(line).get("executable") for line in messages.splitlines())
    return str(next(binary for binary in binaries if binary))


def rates(lines: str) -> Rates:
    """(scene, kind) to (rays per second, hits)."""
    rows = (line.split() for line in lines.splitlines())
    return {(scene, kind): (float(rate), int(hits)) for scene, kind, rate, hits in rows}


def best(rounds: list[Rates]) -> Rates:
    """The fastest of several rounds."""
    return {key: max(r[key] for r in rounds) for key in rounds[0]}
