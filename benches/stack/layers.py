"""A shade and a pane, each alone or both in one scene; their BSDFs, many times with other seeds; how far two are apart.

In: which shade and pane, which comes first, how far apart they are. Out: BSDFs of layers, of the stack and of the whole
scene. Everything repeats for ever (`tile`), as a stack of BSDFs has no edges by which light could leave. Incident
directions fill whole cells, as the light does that the layer before spreads over a cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bsdftree
from bsdftree import Bsdf, Device, Matrix, Tree

SPACING = 0.04
"""Of the slats [m]."""
DEPTH = 0.0433012701892
"""Of a slat 0.05 wide, tilted by 30° [m]."""
SHADES = {
    "diffuse": "void plastic slat 0 0 5 .7 .7 .7 0 0\n",
    "glossy": "void plastic slat 0 0 5 .7 .7 .7 .2 .1\n",
}
PANES = {
    # Takes the same of all light and reflects nothing: nothing of it differs within a cell.
    "film": "void trans pane 0 0 7 .6 .6 .6 0 0 1 1\n",
    "glass": "void glass pane 0 0 4 .96 .96 .96 1.52\n",
    # A solid of two surfaces.
    "dielectric": "void dielectric pane 0 0 5 .05 .05 .05 1.52 0\n",
}
BASIS = "quarter"
"""Klems patches over which stacks are compared; layers are stacked over these, or over parts of them."""
PATCHES = {"full": 145, "half": 77, "quarter": 41}
Rings = list[tuple[float, float, int]]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stack:
    """Slats and a pane, `gap` [m] apart; the pane outside, or towards the room."""

    shade: str
    pane: str
    pane_outside: bool
    gap: float

    def texts(self) -> list[str]:
        """Return the scenes of the layers from the outside to the room, each alone."""
        layers = [PANES[self.pane] + self._pane(-0.01), SHADES[self.shade] + _slat(0.0)]
        return layers if self.pane_outside else layers[::-1]

    def alone(self) -> list[Device]:
        """Return the layers from the outside to the room."""
        return [Device.parse(text) for text in self.texts()]

    def together(self) -> Device:
        """Both in one scene."""
        pane, slat = (-DEPTH - self.gap, 0.0) if self.pane_outside else (0.0, -self.gap)
        return Device.parse(PANES[self.pane] + SHADES[self.shade] + self._pane(pane) + _slat(slat))

    def _pane(self, z: float) -> str:
        """The pane, its foremost surface at z."""
        if self.pane == "dielectric":
            return _square("a", z, 1) + _square("b", z - 0.004, -1)
        return _square("a", z, 1)


def _square(name: str, z: float, side: int) -> str:
    """All of a period at z, that faces +Z or -Z."""
    r = SPACING / 2
    corners = [(-r, -r), (r, -r), (r, r), (-r, r)][::side]
    return f"pane polygon {name} 0 0 12 " + " ".join(f"{x} {y} {z}" for x, y in corners) + "\n"


def _slat(z: float) -> str:
    """One slat, its foremost edge at z and raised."""
    x, y, back = SPACING / 2, 0.0125, z - DEPTH
    return f"slat polygon s 0 0 12 {-x} {-y} {back} {-x} {y} {z} {x} {y} {z} {x} {-y} {back}\n"


def generate(device: Device, seed: int, samples: int, **into: Any) -> Bsdf:
    """Generate the BSDF of a device that repeats: independent paths, nothing merged."""
    r, (least, _) = SPACING / 2, device.bounds or ([0, 0, 0], 0)
    box = (-r, r, -r, r, least[2] - 0.001, 0)
    return bsdftree.generate(
        device, seed=seed, samples=samples, dim=box, tile=True, sampling="random", prune=False, **into
    )


def split(basis: str, m: int) -> Rings:
    """Split each patch in m × m, m odd: of even parts, one would lie half in the next patch, since all are centred."""
    made: Rings = []
    for low, high, n in bsdftree.Matrix.from_values(np.zeros((PATCHES[basis],) * 2), basis).exitant_rings:
        edges = np.linspace(low, high, m + 1).tolist()
        made += [(edges[i], edges[i + 1], m * n if n > 1 else max(1, 4 * i)) for i in range(m)]
    return made


def functions(bsdf: Bsdf, log2_res: int | None = None) -> dict[str, Array]:
    """Return the values of components, incident cells by exitant cells; of trees, means over cells of 2^log2_res."""
    return {key: _values(component, log2_res) for key, component in bsdf.components.items()}


def _values(component: Tree | Matrix, log2_res: int | None) -> Array:
    if isinstance(component, Matrix):
        return np.asarray(component.values, np.float64)
    grid = np.asarray(component.to_grid(), np.float64)
    n = 2 ** (component.depth if log2_res is None else log2_res)
    k = grid.shape[0] // n
    return grid.reshape(n, k, n, k, n, k, n, k).mean((1, 3, 5, 7)).reshape(n * n, n * n)


@dataclass(frozen=True)
class Mean:
    """Mean of many values of the same, and its standard error."""

    value: Array
    error: Array


def mean(each: Sequence[Array]) -> Mean:
    """Return the mean of independent results, and its standard error from their scatter."""
    return Mean(np.mean(each, 0), np.std(each, 0, ddof=1) / np.sqrt(len(each)))


def standard_score(a: Mean, b: Mean, allowed: Array | float = 0.0) -> Array:
    """Return |a - b| beyond what is allowed, in standard errors; 0 where neither has an error nor a difference."""
    beyond = np.maximum(abs(a.value - b.value) - allowed, 0)
    error = np.hypot(a.error, b.error)
    # Sums of the same numbers in another order differ by a rounding.
    rounded = beyond <= 1e-6 * np.maximum(abs(a.value), abs(b.value))
    return np.where(rounded, 0.0, beyond / np.maximum(error, 1e-300))
