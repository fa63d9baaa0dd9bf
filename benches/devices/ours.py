"""Our side: fractions of light from the same incident patches to all exitant patches, in independent runs."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bsdftree
from bsdftree import GenerationReport, Matrix

from .patches import INCIDENT, N_PATCHES, Array, projected_solid_angles

RUNS = 8
COMPONENTS = {
    ("reflection_back", 0, 0),
    ("transmission_back", 0, 1),
    ("transmission_front", 1, 0),
    ("reflection_front", 1, 1),
}
"""As files name them, with the sides of incidence and exitance: 0 the front (+Z), 1 the back."""


@dataclass(frozen=True)
class Generated:
    """What we counted: as `oracle.Counted`, runs instead of batches, colours CIE X, Y, Z or Y alone."""

    runs: Array
    n_paths: int
    cpu: float
    box: Array
    """Smallest and largest x, y, z of the aperture that light came through [m]."""


def generate(device: Path, samples: int, colour: bool, dim: tuple[float, ...] | None = None) -> Generated:
    """Generate Klems matrices of a device; `samples` paths for each side and incident patch, all runs together."""
    shape = (2, len(INCIDENT), RUNS, 2, N_PATCHES, 3 if colour else 1)
    runs, reports, start = np.zeros(shape), list[GenerationReport](), time.process_time()
    for seed in range(RUNS):
        made = bsdftree.generate(
            device,
            klems="full",
            samples=samples // RUNS,
            color=colour,
            dim=dim,
            seed=seed,
            threads=1,
            report=reports.append,
        )
        for name, side_in, side_out in COMPONENTS:
            y = made.components.get(name)
            if not isinstance(y, Matrix):
                continue
            channels = [y]
            if colour:
                x, z = made.chroma_of()[name]
                channels = [x, y, z]  # type: ignore[list-item]
            for channel, matrix in enumerate(channels):
                values = matrix.values[list(INCIDENT)] * projected_solid_angles()
                runs[side_in, :, seed, side_out, :, channel] = values
    cpu = time.process_time() - start
    return Generated(runs, sum(report.paths for report in reports), cpu, np.array(reports[0].aperture))
