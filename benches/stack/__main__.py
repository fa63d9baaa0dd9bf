"""How far stacks are from tracing, by resolution and gap: `python -m benches.stack` draws docs/img/stack.png."""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import bsdftree

from . import picture
from .layers import PATCHES, SPACING, Array, Mean, Stack, functions, generate, mean, split

GAPS = (0.01, 0.1, 0.5, 2.5)
"""Between slats and pane, in spacings of the slats."""
TIMES = 8


@dataclass(frozen=True)
class Domain:
    """Over what cells layers are stacked, and over which coarser ones that is compared."""

    name: str
    generate: dict[str, Any]
    stack: dict[str, Any]
    compare: dict[str, Any]
    n_cells: int
    per_coarse: int

    def coarse(self, bsdf: bsdftree.Bsdf) -> dict[str, Array]:
        """Values over the cells that are compared."""
        if "klems" in self.compare:
            return functions(bsdf.to_klems(self.compare["klems"]))
        return functions(bsdf, self.compare["log2_res"])


def domains() -> list[Domain]:
    """All that are measured, from coarse to fine."""
    made = []
    for basis, parts in (("quarter", (1, 3, 5)), ("full", (1, 3))):
        for m in parts:
            rings = {"klems": basis if m == 1 else split(basis, m)}
            n = PATCHES[basis] if m == 1 else sum(n for _, _, n in rings["klems"])
            name = f"Klems {basis}" + f", split {m} × {m}" * (m > 1)
            made.append(Domain(name, rings, rings, {"klems": basis}, n, m * m))
    for n in (3, 4, 5):
        tree = {"rank": 4, "log2_res": n}
        coarse = {"rank": 4, "log2_res": 3}
        made.append(Domain(f"rank 4, 2^{n}", tree, {"log2_res": n}, coarse, 4**n, 4 ** (n - 3)))
    return made


@dataclass(frozen=True)
class Row:
    """How far one component of a stack is from tracing."""

    domain: Domain
    gap: float
    key: str
    light: tuple[float, float]
    """Of all light that is scattered: difference and its standard error, relative."""
    directions: float
    """Root mean square of the difference of totals of incident cells, beyond noise."""
    incident: tuple[Mean, Mean]
    """Totals of incident cells: stacked, traced."""


def compare(domain: Domain, gap: float, stacked: list[dict[str, Array]], traced: list[dict[str, Array]]) -> list[Row]:
    """Compare all components; areas of incident cells are those of exitant ones."""
    n = len(traced[0]["transmission_front"])
    areas = np.full(n, np.pi / n)
    if "klems" in domain.compare:
        basis = domain.compare["klems"]
        areas = bsdftree.Matrix.from_values(np.zeros((n, n)), basis).projected_solid_angles()[0]
    rows = []
    for key in traced[0]:
        a, b = (mean([each[key] @ areas for each in side]) for side in (stacked, traced))
        lights = [mean([areas @ each[key] @ areas for each in side]) for side in (stacked, traced)]
        light = lights[0].value / lights[1].value - 1
        error = np.hypot(lights[0].error, lights[1].error) / lights[1].value
        beyond = areas @ ((a.value - b.value) ** 2 - a.error**2 - b.error**2) / np.pi
        rows.append(Row(domain, gap, key, (float(light), float(error)), float(np.sqrt(max(beyond, 0))), (a, b)))
    return rows


def main() -> None:
    """Print a table and draw the picture."""
    parser = argparse.ArgumentParser(prog="python -m benches.stack", description="Stacks beside tracing.")
    parser.add_argument("--samples", type=int, default=12800, help="paths for each coarse incident cell and seed")
    parser.add_argument("--shade", default="diffuse", help="diffuse or glossy")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/img/stack.png"))
    arguments = parser.parse_args()
    began = time.perf_counter()
    rows: list[Row] = []
    known: dict[tuple[str, float], list[dict[str, Array]]] = {}
    print("| layers over | cells | gap | R front | T front | R back | ± | directions: R front | T front | R back |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    for domain in domains():
        layers = Stack(arguments.shade, "glass", True, SPACING).alone()
        # All parts of a coarse cell together have as many paths as it has.
        samples = max(arguments.samples // domain.per_coarse, 64)
        stacked = [
            domain.coarse(
                bsdftree.stack([generate(d, 1 + k, samples, **domain.generate) for d in layers], **domain.stack)
            )
            for k in range(TIMES)
        ]
        for gap in GAPS:
            where = (str(domain.compare), gap)
            if where not in known:
                together = Stack(arguments.shade, "glass", True, gap * SPACING).together()
                known[where] = [
                    functions(generate(together, 100 + k, arguments.samples, **domain.compare)) for k in range(TIMES)
                ]
            of_gap = compare(domain, gap, stacked, known[where])
            rows += of_gap
            print(_line(domain, gap, {row.key: row for row in of_gap}), flush=True)
    picture.draw(rows, arguments.output)
    print(f"{arguments.output}: {(time.perf_counter() - began) / 60:.1f} minutes")


def _line(domain: Domain, gap: float, row: dict[str, Row]) -> str:
    keys = ("reflection_front", "transmission_front", "reflection_back")
    light = " | ".join(f"{100 * row[key].light[0]:+.2f}" for key in keys)
    noise = 100 * max(row[key].light[1] for key in keys)
    directions = " | ".join(f"{100 * row[key].directions:.2f}" for key in keys)
    return f"| {domain.name} | {domain.n_cells} | {gap:g} | {light} | {noise:.2f} | {directions} |"


if __name__ == "__main__":
    main()
