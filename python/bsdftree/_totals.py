"""Light scattered from rings of directions and from all of them: what tables and pictures print."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bsdftree._component import Array
from bsdftree._directions import direction_from_polar
from bsdftree._queries import Part, Queries

# Azimuths that avoid the symmetry planes of most devices.
_PHI_DEG = (np.arange(16) + 0.5) * 22.5
# Polar angles that are even in projected solid angle.
_THETA_DEG = np.degrees(np.arcsin(np.sqrt((np.arange(32) + 0.5) / 32)))


def totals_by_azimuth(bsdf: Queries, side: float, part: Part, theta_deg: ArrayLike, band: str) -> Array:
    """Directional-hemispherical totals for light from a side (1 the front, -1 the back), (angles, 16 azimuths)."""
    incident = direction_from_polar(np.asarray(theta_deg, float)[:, None], _PHI_DEG)
    incident[..., 2] *= side
    return bsdf.hemispherical(incident, part, band=band)


def mean_total(bsdf: Queries, side: float, part: Part, band: str = "Visible") -> float:
    """Fraction of evenly diffuse light from a side (1 the front, -1 the back) that is scattered."""
    return float(totals_by_azimuth(bsdf, side, part, _THETA_DEG, band).mean())
