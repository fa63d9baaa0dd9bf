"""What layers and gaps of a window are made of, as EnergyPlus's materials: all that is not light.

In goes a BSDF whose file may say how thick it is, how it conducts heat and how it looks in the infrared; what it does
not say is EnergyPlus's default. A layer is ``WindowMaterial:Glazing``, or ``WindowMaterial:ComplexShade`` if air passes
through it. Source: EnergyPlus Input Output Reference.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bsdftree._bsdf import Bsdf

# Of the layer: our word, the file's, the default of EnergyPlus's IDD for WindowMaterial:Glazing, the range.
THERMAL = {
    "conductivity": ("ThermalConductivity", 0.9, (0.0, np.inf)),
    "emissivity_front": ("EmissivityFront", 0.84, (0.0, 1.0)),
    "emissivity_back": ("EmissivityBack", 0.84, (0.0, 1.0)),
    "infrared_transmittance": ("TIR", 0.0, (0.0, 1.0)),
}
# EnergyPlus has none: common window glass.
DEFAULT_THICKNESS = 0.003
# WINDOW's word for how much air passes through a fabric, and the default of EnergyPlus's IDD.
PERMEABILITY, DEFAULT_OPENNESS = "PermeabilityFactor", 0.05
GASES = ("Air", "Argon", "Krypton", "Xenon")
DEFAULT_GAP = 0.0127
"""Half an inch [m], of air."""
PRESSURE = 101325.0
"""Of the gas [Pa]."""


def glazing(bsdf: Bsdf, thickness: float | None, given: Mapping[str, float | None]) -> dict[str, Any]:
    """Return the fields of WindowMaterial:Glazing, in EnergyPlus's order."""
    value = _thermal(bsdf, thickness, given)
    return {
        "optical_data_type": "BSDF",
        "thickness": value["thickness"],
        "infrared_transmittance_at_normal_incidence": value["infrared_transmittance"],
        "front_side_infrared_hemispherical_emissivity": value["emissivity_front"],
        "back_side_infrared_hemispherical_emissivity": value["emissivity_back"],
        "conductivity": value["conductivity"],
    }


def shade(bsdf: Bsdf) -> dict[str, Any]:
    """Return the fields of WindowMaterial:ComplexShade, in EnergyPlus's order; closed at its edges."""
    value = _thermal(bsdf, None, {})
    openness = _number(bsdf, PERMEABILITY, DEFAULT_OPENNESS, "it")
    return {
        "layer_type": "BSDF",
        "thickness": value["thickness"],
        "conductivity": value["conductivity"],
        "ir_transmittance": value["infrared_transmittance"],
        "front_emissivity": value["emissivity_front"],
        "back_emissivity": value["emissivity_back"],
        **{f"{edge}_opening_multiplier": 0.0 for edge in ("top", "bottom", "left_side", "right_side")},
        "front_opening_multiplier": in_range("PermeabilityFactor", openness, (0.0, 1.0)),
    }


def is_shade(bsdf: Bsdf) -> bool:
    """Whether air or the infrared passes through a layer, or it has geometry: glass says nothing of these."""
    transmittance = _number(bsdf, "TIR", 0.0, "infrared_transmittance")
    return PERMEABILITY in bsdf.properties or transmittance > 0 or bsdf.geometry is not None


def gap(name: str, thickness: float, gas: str) -> dict[str, dict[str, dict[str, Any]]]:
    """Return a gap and its gas."""
    known = {g.lower(): g for g in GASES}
    if gas.lower() not in known:
        raise ValueError(f"gas {gas!r} of a gap; expected one of {', '.join(GASES)}")
    thickness = in_range("thickness of a gap", thickness, (0.0, np.inf))
    return {
        "WindowMaterial:Gas": {f"{name}_gas": {"gas_type": known[gas.lower()], "thickness": thickness}},
        "WindowMaterial:Gap": {
            name: {"thickness": thickness, "gas_or_gas_mixture_": f"{name}_gas", "pressure": PRESSURE}
        },
    }


def _thermal(bsdf: Bsdf, thickness: float | None, given: Mapping[str, float | None]) -> dict[str, float]:
    if thickness is None:
        thickness = bsdf.thickness or DEFAULT_THICKNESS
    value = {"thickness": in_range("thickness", thickness, (0.0, np.inf))}
    for key, (word, default, range_) in THERMAL.items():
        found = given.get(key)
        if found is None:
            found = _number(bsdf, word, default, key)
        value[key] = in_range(key, found, range_)
    return value


def _number(bsdf: Bsdf, word: str, default: float, key: str) -> float:
    """A property of the file, or a default."""
    text = bsdf.properties.get(word)
    try:
        return default if text is None else float(text)
    except ValueError:
        raise ValueError(f"{word} of the file is {text!r}; expected a number: give {key}") from None


def in_range(key: str, value: float, range_: tuple[float, float]) -> float:
    low, high = range_
    # Thickness and conductivity divide.
    if not (low <= value <= high and np.isfinite(value) and (value > 0 or high == 1)):
        raise ValueError(f"{key} {value}; expected {'0 to 1' if high == 1 else 'a number above 0'}: give {key}")
    return float(value)
