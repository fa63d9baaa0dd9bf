"""Values of a BSDF along the plane of incidence, as the steps that they are, or the ramps if it is smooth.

Angles in the plane are measured at the surface from the front normal (+Z), positive to where the light heads: ±90° lie
in the surface, ±180° is the back normal. Mirrored light from polar angle θ lies at θ.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bsdftree import Bsdf, direction_from_polar

Array = NDArray[np.float64]
# Cells narrower than this [degree] may be missed: a cell of a 2^8 tree is 0.45° wide at the normal.
_SCAN_DEG = 0.05
# Arcs are drawn with chords of at most this [degree].
_CHORD_DEG = 0.5


def step_curve(bsdf: Bsdf, theta_deg: float, phi_deg: float, band: str) -> tuple[Array, Array]:
    """Angle in the plane [degree] and BSDF [1/sr] along it.

    Steps have two points at each edge between cells; edges are found to 1e-6 degree by bisection.
    """
    incident = direction_from_polar(theta_deg, phi_deg)

    def value(angle_deg: Array) -> Array:
        return bsdf.eval(incident, direction_from_polar(angle_deg, phi_deg + 180.0), band=band)

    n = round(360.0 / _SCAN_DEG)
    scan = np.arange(n, dtype=np.float64) * _SCAN_DEG - (
        180.0 - 0.5 * _SCAN_DEG
    )  # never exactly in the surface or along a normal
    values = value(scan)
    if bsdf.is_smooth:
        return scan, values
    before = np.flatnonzero(values[1:] != values[:-1])
    lower, upper, left = scan[before], scan[before + 1], values[before]
    while lower.size and upper[0] - lower[0] > 1e-6:
        middle = 0.5 * (lower + upper)
        same = value(middle) == left
        lower, upper = np.where(same, middle, lower), np.where(same, upper, middle)
    edges = np.concatenate([[-180.0], 0.5 * (lower + upper), [180.0]])
    cells = np.concatenate([values[before], values[-1:]])
    angles = [np.linspace(a, b, 2 + int((b - a) / _CHORD_DEG)) for a, b in pairwise(edges)]
    return np.concatenate(angles), np.repeat(cells, [len(a) for a in angles])
