"""A transmitting diffuser with a sharp edge: constant within a cone about the straight or a bent direction."""

from __future__ import annotations

import numpy as np

from .formulas import Array, Function

CONE = np.radians(10.0)
EDGE = np.radians(0.2)
"""From 12 to 88 % of the height in ±0.4°."""
BASE = 0.02
"""Hemispherical transmittance of the weak base."""
CONSTANT = 0.75 / (np.pi * np.sin(CONE) ** 2)
"""[1/sr]: three quarters of normal light within the cone."""


def sharp_diffuser(bend: float = 0.0) -> Function:
    """Light from the front that leaves to the back; its polar angle is reduced by this fraction."""

    def f(incident: Array, exitant: Array) -> Array:
        theta = np.arctan2(np.hypot(incident[:, 0], incident[:, 1]), incident[:, 2]) * (1 - bend)
        phi = np.arctan2(-incident[:, 1], -incident[:, 0])
        axis = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)], axis=1)
        off = 2 * np.arcsin(np.clip(np.linalg.norm(exitant - axis, axis=1) / 2, 0, 1))
        edge = 1 / (1 + np.exp(np.clip((off - CONE) / EDGE, -50, 50)))
        return np.where((incident[:, 2] > 0) & (exitant[:, 2] < 0), CONSTANT * edge + BASE / np.pi, 0.0)

    return f
