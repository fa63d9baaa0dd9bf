"""Directions to test with, and the statistics of comparing them."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

SIDES = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
"""Signs of z of incident and exitant direction: all four components."""


def hemisphere(rng: np.random.Generator, n: int, side: int) -> np.ndarray:
    """Directions uniform in projected solid angle, (n, 3)."""
    radius, azimuth = np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    xy = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth)])
    return np.stack([*xy, side * np.sqrt(1 - radius**2)], axis=1)


def turned(directions: np.ndarray, polar: float, azimuth: float) -> np.ndarray:
    """The same directions with changed polar angle and azimuth [radian]."""
    x, y, z = directions.T
    theta, phi = np.arctan2(np.hypot(x, y), z) + polar, np.arctan2(y, x) + azimuth
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def away_from_borders(evaluate, incident: np.ndarray, exitant: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Which pairs keep their value when either direction moves by `step` [radian] in polar angle and azimuth.

    Not those within `step` of the normal or of the plane of the surface either.
    """
    value = evaluate(incident, exitant)
    steady = np.ones(value.shape, bool)
    for polar, azimuth in [(step, step), (step, -step), (-step, step), (-step, -step)]:
        steady &= evaluate(turned(incident, polar, azimuth), exitant) == value
        steady &= evaluate(incident, turned(exitant, polar, azimuth)) == value
    for direction in (incident, exitant):
        sine = np.hypot(direction[:, 0], direction[:, 1])
        steady &= (sine > step) & (abs(direction[:, 2]) > step)
    return steady


def histogram(directions: np.ndarray, n_radii: int = 8, n_azimuths: int = 16) -> np.ndarray:
    """Counts in cells of equal projected solid angle on both sides: (2 · n_radii · n_azimuths,)."""
    x, y, z = directions.T
    radius = np.minimum(((x**2 + y**2) * n_radii).astype(int), n_radii - 1)
    azimuth = np.minimum(((np.arctan2(y, x) / (2 * np.pi) % 1.0) * n_azimuths).astype(int), n_azimuths - 1)
    return np.bincount(((z < 0) * n_radii + radius) * n_azimuths + azimuth, minlength=2 * n_radii * n_azimuths)


def p_of_chi_squared(chi_squared: float, degrees_of_freedom: int) -> float:
    """Probability of a larger value (Wilson and Hilferty 1931; better than 1 % of itself near 1e-4 over 10 degrees)."""
    width = 2.0 / (9.0 * degrees_of_freedom)
    return 1.0 - NormalDist().cdf(((chi_squared / degrees_of_freedom) ** (1 / 3) - (1 - width)) / np.sqrt(width))


def two_sample_chi_squared(a: np.ndarray, b: np.ndarray, least: int = 20) -> tuple[float, int, float]:
    """χ², its degrees of freedom and its p for two histograms of one distribution; rare cells are pooled."""
    rare = a + b < least
    a, b = (np.append(h[~rare], h[rare].sum()) for h in (a, b))
    there = a + b > 0
    a, b = a[there], b[there]
    scale = np.sqrt(b.sum() / a.sum())
    chi_squared = float((((a * scale - b / scale) ** 2) / (a + b)).sum())
    freedom = len(a) - 1
    return chi_squared, freedom, 1.0 if freedom == 0 else p_of_chi_squared(chi_squared, freedom)
