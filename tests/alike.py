"""Whether two BSDFs of one device are alike within their noise.

Compared are fractions of light from each incident cell to each exitant cell, f · Ω. The mean of n paths has at most the
variance p(1 − p)/n of a count, because a path carries a weight of at most 1. Ours have many more paths, so that
noise is nearly all the other's. Significance 1e-6 for all cells of a component together (Bonferroni).
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from bsdftree import Bsdf, Matrix, Tree

OURS = 20_000
"""Paths of ours."""
SIGNIFICANCE = 1e-6
STUDENT = 14.0
"""Of Student's t with 7 degrees of freedom: beyond ±14 is one of 4·10⁵, a few of which are looked at."""


def patch_solid_angles(rings) -> np.ndarray:
    """Projected solid angles of the patches of a Klems basis [sr]."""
    lower, upper, n = np.array(rings).T
    ring = np.pi * (np.cos(np.radians(lower)) ** 2 - np.cos(np.radians(upper)) ** 2) / n
    return np.repeat(ring, n.astype(int))


def fractions(component: Tree | Matrix, log2_res: int) -> np.ndarray:
    """Fraction of the light from each incident cell that leaves into each exitant cell: (incident, exitant)."""
    if isinstance(component, Matrix):
        return component.values * patch_solid_angles(component.exitant_rings)
    grid = component.to_grid(log2_res).astype(float) * np.pi / 4**log2_res
    n_exitant = 4**log2_res
    if component.rank == 3:
        return grid[: 2 ** (log2_res - 1)].reshape(-1, n_exitant)
    return grid.reshape(-1, n_exitant)


def z_scores(a: np.ndarray, n_a: int, b: np.ndarray, n_b: int) -> np.ndarray:
    """Difference over its largest standard deviation, where enough is counted for a normal distribution."""
    p = (n_a * a + n_b * b) / (n_a + n_b)
    counted = n_a * np.minimum(p, 1 - p) >= 10
    p = p[counted]
    return (a - b)[counted] / np.sqrt(p * (1 - p) * (1 / n_a + 1 / n_b))


def assert_alike(
    theirs: Bsdf, ours: Bsdf, n_theirs: int, log2_res: int = 0, total: float = 0.01, n_ours: int = OURS
) -> None:
    """Assert equality of totals (absolute) and of all cells, singly and as groups."""
    for key, component in ours.components.items():
        a, b = fractions(theirs.components[key], log2_res), fractions(component, log2_res)
        assert a.shape == b.shape
        difference = a.sum(axis=1).mean() - b.sum(axis=1).mean()
        assert abs(difference) < total, (key, difference)
        n = len(a)
        groups = {
            "cells": z_scores(a, n_theirs, b, n_ours),
            "incident cells": z_scores(a.sum(axis=1), n_theirs, b.sum(axis=1), n_ours),
            "exitant cells": z_scores(a.mean(axis=0), n * n_theirs, b.mean(axis=0), n * n_ours),
        }
        for group, z in groups.items():
            if not z.size:
                continue
            limit = NormalDist().inv_cdf(1 - SIGNIFICANCE / 2 / z.size)
            print(
                f"{key}: total {a.sum(axis=1).mean():.4f} ({difference:+.4f}); {z.size} {group}: "
                f"|z| at most {abs(z).max():.2f} (limit {limit:.2f}), mean z² {(z**2).mean():.2f}"
            )
            assert abs(z).max() < limit, (key, group)
            # A mean over k cells of at most 1, with 5 standard deviations of χ²/k.
            assert (z**2).mean() < 1 + 5 * np.sqrt(2 / z.size), (key, group)


def both_sides(tree: Tree) -> Tree:
    """The tree averaged with its mirror image in the plane of incidence."""
    grid = tree.to_grid()
    return Tree.from_grid((grid + grid[:, :, ::-1]) / 2)
