"""Closest hits per second, ours beside Embree's single-ray queries in robust mode: same scenes, same rays, one thread.

python benches/beside_embree.py            # needs cargo, g++ and Embree 3 (Debian: libembree-dev)

Prints a table. Both run by turns, and the best of each counts. Embree decides in f32, so rays at edges may differ:
by how many hits is printed. It has no quadrics: they are user geometry (crates/bsdftree-generate/benches/embree/).
"""

import json
import shutil
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "crates/bsdftree-generate/benches/embree/embree.cpp"
SCENES = ["blind", "mesh", "quadrics"]
KINDS = "incoming,chords,bounces"
ROUNDS = 3

Rates = dict[tuple[str, str], tuple[float, int]]


def run(command: list[str]) -> str:
    """What a command prints."""
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, cwd=ROOT).stdout


def ours_binary() -> str:
    """Builds the example `rays`; where it is."""
    build = ["cargo", "build", "--release", "--quiet", "-p", "bsdftree-generate", "--example", "rays"]
    messages = run([*build, "--message-format=json-render-diagnostics"])
    binaries = (json.loads(line).get("executable") for line in messages.splitlines())
    return str(next(binary for binary in binaries if binary))


def rates(printed: str) -> Rates:
    """(scene, kind) to (rays per second, hits)."""
    rows = (line.split() for line in printed.splitlines())
    return {(scene, kind): (float(rate), int(hits)) for scene, kind, rate, hits in rows}


def best(rounds: list[Rates]) -> Rates:
    """The fastest of several rounds."""
    return {key: max(r[key] for r in rounds) for key in rounds[0]}


def main() -> None:
    """Compiles, runs by turns, prints."""
    ours = ours_binary()
    with tempfile.TemporaryDirectory() as folder:
        theirs = f"{folder}/embree"
        compile_theirs = ["g++", "-O3", "-march=native", str(SOURCE), "-o", theirs, "-lembree3"]
        if not shutil.which("g++") or subprocess.run(compile_theirs, check=False).returncode != 0:
            print("SKIPPED: this needs g++ and the headers of Embree 3 (Debian: apt-get install g++ libembree-dev)")
            return
        run([ours, folder])
        pairs = [
            (rates(run([ours])), rates(run([theirs, folder, *(f"{scene}:{KINDS}" for scene in SCENES)])))
            for _ in range(ROUNDS)
        ]
    mine, embree = (best([pair[k] for pair in pairs]) for k in range(2))
    print(f"{'scene':10} {'rays':10} {'ours M/s':>10} {'Embree M/s':>10} {'ratio':>6} {'hits':>7} {'differ':>7}")
    for key, (rate, hits) in mine.items():
        other, other_hits = embree[key]
        speeds = f"{rate / 1e6:10.2f} {other / 1e6:10.2f} {rate / other:6.2f}"
        print(f"{key[0]:10} {key[1]:10} {speeds} {hits:7} {other_hits - hits:+7}")


if __name__ == "__main__":
    main()
