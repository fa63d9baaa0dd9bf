"""Components and bands by name: which of them a file has, how much light they scatter."""

from __future__ import annotations

import numpy as np

from bsdftree import Bsdf, Matrix, Tree
from bsdftree._sides import OUTSIDE as OUTSIDE
from bsdftree._sides import ROOM as ROOM
from bsdftree._sides import SIDES as SIDES
from bsdftree._totals import mean_total


def band_of(bsdf: Bsdf, band: str | None) -> str:
    """The band asked for, or ``Visible``, or the only one there is."""
    if band is None:
        return "Visible" if "Visible" in bsdf.bands or not bsdf.bands else bsdf.bands[0]
    if band not in bsdf.bands:
        raise ValueError(f"no band {band!r}; the BSDF has {', '.join(bsdf.bands)}")
    return band


def parts_of(bsdf: Bsdf, part: str | None, band: str) -> list[str]:
    """The part asked for, or all parts of a band, light from the room first."""
    there = [key for key in SIDES if key in bsdf.components_of(band)]
    if part is None:
        return there
    if part not in there:
        raise ValueError(f"no component {part!r} in band {band}; the BSDF has {', '.join(there)}")
    return [part]


def heading_of(bsdf: Bsdf, band: str, title: str | None) -> str:
    """The title given or the product's name, with the band where there are several."""
    text = bsdf.name if title is None else title
    return text if len(bsdf.bands) < 2 else f"{text}  ({band})".strip()


def is_black(component: Tree | Matrix) -> bool:
    """Whether a component scatters nothing at all."""
    if isinstance(component, Matrix):
        return not np.any(component.values > 0.0)
    cells, levels, values = component.leaves()
    # Rank 3 keeps half of its incident axis for nothing.
    used = cells[:, 0] < np.ldexp(0.5, levels.astype(np.int32)) if component.rank == 3 else True
    return not np.any((values > 0.0) & used)


def scatters(bsdf: Bsdf, side: float, band: str) -> bool:
    """Whether anything becomes of light from a side; an absent transmission is the other one reversed."""
    components = bsdf.components_of(band)
    keys = [key for key, sides in SIDES.items() if sides.incident == side or sides.kind == "transmission"]
    return any(key in components and not is_black(components[key]) for key in keys)


def diffuse_total(bsdf: Bsdf, part: str, band: str) -> float:
    """Fraction of evenly diffuse light that a component scatters, in [0, 1] if lawful."""
    sides = SIDES[part]
    return mean_total(bsdf, sides.incident, sides.kind, band)
