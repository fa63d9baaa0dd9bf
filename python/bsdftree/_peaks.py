"""Specular peaks and the families they form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

Direction = tuple[float, float, float]

#: Farthest polar angle [degree] from one asked for whose peaks still count: the next ring of a Klems basis is 10° off.
_NEAR_DEG = 7.5


@dataclass(frozen=True)
class Peak:
    """A peak of the light from one direction.

    Attributes
    ----------
    incident
        Where the light comes from, the middle of an incident cell; in isotropic data from azimuth 180°.
    exitant
        Where it goes: the flux-weighted mean direction.
    strength
        Fraction of the light in the peak, above the level around it.
    surround
        That level [1/sr].
    projected_solid_angle
        What it fills [sr].
    width_deg
        Full angle [degree] of the cone of its solid angle.
    resolution_limited
        Whether it fills at most four cells, so that in truth it may be narrower.
    """

    incident: Direction
    exitant: Direction
    strength: float
    surround: float
    projected_solid_angle: float
    width_deg: float
    resolution_limited: bool


@dataclass(frozen=True)
class PeakFamily:
    """Peaks of many incident directions that one map of directions describes.

    Attributes
    ----------
    component
        ``reflection_front``, ``reflection_back``, ``transmission_front`` or ``transmission_back``.
    kind
        The map from incident direction i to exitant direction o:

        * ``straight``: o = -i
        * ``mirror``: o = (-x, -y, z)
        * ``retro``: o = i
        * ``facet``: mirrored by facets of ``normal``
        * ``groove``: back across right-angled grooves along ``axis``, onward along them
        * ``prism``: refracted by a flat face and by facets of ``normal``
        * ``inner_facet``: in through a flat face, mirrored inside by facets of ``normal``, and out again
        * ``shift``: x and y of o are those of -i plus ``shift``
        * ``table``: none of these, see ``peaks``
    residual_deg
        Root mean square angle [degree] between the peaks and the map; None for a table.
    n_directions
        Incident directions looked at.
    peaks
        One peak for each direction it was found from; in a table maybe more.
    normal
        Unit normal of the facets, z >= 0.
    axis
        Unit vector along the grooves, z >= 0.
    index
        Index of refraction. From coarse data it is only known together with the tilt of the facets.
    flat_first
        Of a prism: whether the light enters through its flat face.
    shift
        In direction cosines.
    """

    component: str
    kind: str
    residual_deg: float | None
    n_directions: int
    peaks: tuple[Peak, ...]
    normal: Direction | None = None
    axis: Direction | None = None
    index: float | None = None
    flat_first: bool | None = None
    shift: tuple[float, float] | None = None

    @cached_property
    def n_found(self) -> int:
        """Incident directions that it was found from."""
        return len({peak.incident for peak in self.peaks})

    @property
    def mean_strength(self) -> float:
        """Mean fraction of the light, over the directions it was found from."""
        return float(np.mean([peak.strength for peak in self.peaks]))

    @property
    def strength_range(self) -> tuple[float, float]:
        """Least and largest fraction of the light."""
        strengths = [peak.strength for peak in self.peaks]
        return min(strengths), max(strengths)

    @property
    def width_deg(self) -> float:
        """Median width [degree]."""
        return float(np.median([peak.width_deg for peak in self.peaks]))

    @property
    def resolution_limited(self) -> bool:
        """Whether most of its peaks are as narrow as the data can say."""
        return sum(peak.resolution_limited for peak in self.peaks) * 2 > len(self.peaks)

    @cached_property
    def theta_deg(self) -> tuple[float, ...]:
        """Polar angle of each peak's incident direction from the nearer normal [degree]."""
        return tuple(float(np.degrees(np.arccos(min(abs(peak.incident[2]), 1.0)))) for peak in self.peaks)

    def strength_at(self, theta_deg: float) -> float | None:
        """Mean strength of the peaks of light from about a polar angle [degree] off the normal, or None without any."""
        near = [
            peak.strength
            for peak, theta in zip(self.peaks, self.theta_deg, strict=True)
            if abs(theta - theta_deg) <= _NEAR_DEG
        ]
        return float(np.mean(near)) if near else None


def peak_families(families: list[dict[str, Any]]) -> list[PeakFamily]:
    """Objects from what the extension returns."""
    columns = list(Peak.__annotations__)
    result = []
    for family in families:
        arrays = [family.pop(column).tolist() for column in columns]
        family["peaks"] = tuple(Peak(tuple(i), tuple(o), *rest) for i, o, *rest in zip(*arrays, strict=True))
        for vector in family.keys() & {"normal", "axis", "shift"}:
            family[vector] = tuple(family[vector])
        result.append(PeakFamily(**family))
    return result
