"""What it means that Radiance's library has the same BSDF, and what of it Radiance leaves out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from directions import SIDES, away_from_borders, hemisphere
from radiance import Library

from bsdftree import Bsdf, Matrix, Tree

N_PAIRS = 1000
"""For each combination of sides; as many again with sampled exitant directions."""

COMPONENT = {
    (1, 1): "reflection_back",
    (-1, -1): "reflection_front",
    (-1, 1): "transmission_front",
    (1, -1): "transmission_back",
}


def answering(b: Bsdf, sides: tuple[int, int]) -> str | None:
    """The component that answers: its own, or the other transmission reversed."""
    for key in (COMPONENT[sides], COMPONENT[sides[::-1]] if sides[0] != sides[1] else None):
        if key in b.components:
            return key
    return None


def largest_hemispherical(component: Tree | Matrix) -> float:
    """Largest total over all incident directions."""
    if isinstance(component, Matrix):
        rings = np.array(component.exitant_rings)
        lower, upper, n = np.radians(rings[:, 0]), np.radians(rings[:, 1]), rings[:, 2].astype(int)
        solid_angles = np.repeat(np.pi * (np.cos(lower) ** 2 - np.cos(upper) ** 2) / n, n)
        return float((component.values @ solid_angles).max())
    grid = component.to_grid().astype(float)
    if component.rank == 3:
        grid = grid[: max(len(grid) // 2, 1)]
    return float(grid.sum(axis=(-2, -1)).max() * np.pi / 4**component.depth)


def is_dropped(b: Bsdf, key: str) -> bool:
    """Whether Radiance drops all but the Lambertian part of a component, because too little light is in the rest."""
    return largest_hemispherical(b.components[key]) - b.lambertian()[key] <= 0.001


def as_radiance_has_it(b: Bsdf, incident: np.ndarray, exitant: np.ndarray, sides: tuple[int, int]) -> np.ndarray:
    """Our values, except for components that Radiance drops: these are Lambertian.

    A transmission that it drops is, beside its Lambertian part, the other one reversed, as if it were absent.
    """
    own, other = COMPONENT[sides], COMPONENT[sides[::-1]]
    if own not in b.components or not is_dropped(b, own):
        if own != other and own not in b.components and other in b.components and is_dropped(b, other):
            return np.full(len(incident), b.lambertian()[other] / np.pi)
        return b.eval(incident, exitant)
    result = np.full(len(incident), b.lambertian()[own] / np.pi)
    if other != own and other in b.components and not is_dropped(b, other):
        result += b.eval(exitant, incident) - b.lambertian()[other] / np.pi
    return result


def pairs(b: Bsdf, rng: np.random.Generator, sides: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions, half of them where the BSDF is large, none at borders of cells."""
    incident = hemisphere(rng, 2 * N_PAIRS, sides[0])
    exitant = hemisphere(rng, 2 * N_PAIRS, sides[1])
    sampled = b.sample(incident[N_PAIRS:], rng.random(N_PAIRS))
    found = (sampled.pdf > 0) & (np.sign(sampled.exitant[:, 2]) == sides[1])
    exitant[N_PAIRS:][found] = sampled.exitant[found]
    steady = away_from_borders(b.eval, incident, exitant)
    assert steady.mean() > 0.98
    return incident[steady], exitant[steady]


def assert_evaluates_alike(b: Bsdf, path: Path, rng: np.random.Generator) -> None:
    """Assert that Radiance has the same values at random pairs, for all four combinations of sides."""
    drawn = [pairs(b, rng, sides) for sides in SIDES]
    incident, exitant = (np.concatenate(part) for part in zip(*drawn, strict=True))
    expected = np.concatenate([as_radiance_has_it(b, *d, s) for d, s in zip(drawn, SIDES, strict=True)])
    xyz = Library(path).answers(pairs=(incident, exitant))["xyz"]
    assert len(xyz) > 3000
    error = abs(xyz[:, 1] - expected)
    print(f"{path.name}: largest relative error {(error / np.maximum(expected, 1e-6)).max():.1e}")
    np.testing.assert_allclose(xyz[:, 1], expected, rtol=5e-4, atol=1e-9)


def sampled_in_reverse_by_us_only(b: Bsdf, incident: np.ndarray) -> np.ndarray:
    """Where transmission is a rank-3 tree reversed."""
    result = np.zeros(len(incident), bool)
    for side in (1, -1):
        key = answering(b, (side, -side))
        reversed_tree = key not in (None, COMPONENT[side, -side]) and isinstance(b.components[key], Tree)
        if reversed_tree and b.components[key].rank == 3:
            result |= np.sign(incident[:, 2]) == side
    return result
