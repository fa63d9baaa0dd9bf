"""The talk's job and its two tables, with ours beside them.

Source: "A Variable-resolution BSDF Implementation" (G. Ward, A. McNeil). Its device is a sawtooth of alternating
mirrors and diffusers; file sizes and calculation times are what its slides state. That its low-resolution tree is 2^4
and its high-resolution tree 2^6, both culled, is read from their sizes. Programs are run as users do, `bsdftree
generate` in a process of its own, Python's start-up included.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

from .process import Cost
from .process import run as run_program
from .tables import head, megabytes, row

SAMPLES = 400_000
QUICK_SAMPLES = 2_000
FULL_SAMPLES = 2_000
"""Paths for the file of all cells: its size depends little on them."""
DAY = 86400.0


@dataclass(frozen=True)
class Job:
    cost: Cost
    values: int
    bytes: int
    paths: int
    tracing: float
    reducing: float


def generate(work: Path, *arguments: object) -> Job:
    """A run of `bsdftree generate` on the sawtooth, light from the front."""
    xml, summary = work / "talk.xml", work / "talk.json"
    command = [sys.executable, "-m", "bsdftree", "generate", "--device", "sawtooth", "--sides", "front"]
    cost = run_program([*command, *arguments, "--json", "-o", xml], stdout=summary)
    said = json.loads(summary.read_text())
    values = sum(component["values"] for component in said["bands"][0]["components"])
    return Job(cost, values, xml.stat().st_size, said["paths"], said["tracing_seconds"], said["reducing_seconds"])


def run(quick: bool, work: Path) -> None:
    """Run the jobs and print the tables."""
    samples = QUICK_SAMPLES if quick else SAMPLES
    start_up = run_program([sys.executable, "-m", "bsdftree", "--version"])
    jobs = {
        "klems": generate(work, "--klems", "full", "--samples", samples),
        "low": generate(work, "--log2-res", 4, "--samples", samples),
        "high": generate(work, "--log2-res", 6, "--samples", samples),
        "full": generate(work, "--log2-res", 6, "--samples", min(samples, FULL_SAMPLES), "--no-prune"),
    }
    high = jobs["high"]
    print("\n## The talk's job")
    head(
        "From geometry to XML: sawtooth, rank 4, 2^6, light from the front",
        *("paths per incident cell", ">paths", ">wall s", ">CPU s", ">peak MB", ">values", ">XML MB"),
        note=f"In a process of its own; {start_up.cpu:.2f} CPU s of it are Python's start-up. Tracing took "
        f"{high.tracing:.1f} s and reduction {high.reducing:.1f} s of the wall time.",
    )
    cost = high.cost
    row(samples, high.paths, cost.wall, cost.cpu, megabytes(cost.memory), high.values, megabytes(high.bytes))
    head("Sizes", "file", ">talk MB", ">ours MB", ">values", ">times smaller")
    for what, name, theirs in (
        ("Klems full", "klems", 0.538),
        ("low-resolution tree, 2^4", "low", 0.110),
        ("high-resolution tree, 2^6", "high", 17.6),
        ("all cells, 2^6", "full", 205.0),
    ):
        mine = megabytes(jobs[name].bytes)
        row(what, theirs, mine, jobs[name].values, theirs / mine)
    head("Calculation times", "job", ">talk s", ">ours, wall s", ">times faster")
    row(
        "high-resolution tree, 2^6, 400 000 paths",
        30 * DAY,
        None if quick else cost.wall,
        None if quick else 30 * DAY / cost.wall,
    )
    for what, name in (("low-resolution tree, 2^4", "low"), ("Klems full", "klems")):
        row(f"{what}, {samples} paths", None, jobs[name].cost.wall, None)
