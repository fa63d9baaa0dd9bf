"""A BSDF as a window construction for EnergyPlus: ``Construction:ComplexFenestrationState`` and what it names.

In goes a BSDF with the bands Visible and Solar, out come EnergyPlus objects as epJSON has them, or as text for an IDF.
Trees, and matrices of other bases, become Klems full first. Values are BSDF [1/sr], as in WINDOW's XML: EnergyPlus
multiplies them by projected solid angles itself. A row for each exitant patch, a column for each incident one. Front is
the outside, as in WINDOW, and an azimuth is that of the way the light goes, on either side, so WINDOW's matrices are
EnergyPlus's as they stand. The basis has a row for each ring: polar angle of its middle [degree], number of patches.
An absorptance matrix is one row: what light from that patch leaves in the layer.

The construction is **one** solid layer, since a BSDF does not say what is between its faces: it absorbs all that is
neither transmitted nor reflected. Infrared and conduction come from options, else from the file, else from defaults.

Sources: EnergyPlus Input Output Reference, Construction:ComplexFenestrationState and Matrix:TwoDimension; EnergyPlus's
code where that is silent: WindowComplexManager.cc for rows, columns and weights (what of a beam is transmitted is the
sum over the column of its patch, times projected solid angle) and for azimuths (WorldVectFromW6); GetMatrixInput, which
reads row by row. The field "visible … back transmittance" is read as back *reflectance* (VisBkRefl), and that is
written. For diffuse light EnergyPlus takes rows for columns: see COMPARE.md. Names of fields are those of
EnergyPlus 25.2; earlier ones spelled "absoptance". An IDF has no names of fields, and suits either.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bsdftree._bsdf import Bsdf, Matrix
from bsdftree._whole_file import write_whole

FULL = "LBNL/Klems Full"
# What else an epJSON or IDF field would end at, and EnergyPlus's longest name.
FORBIDDEN, LONGEST = ",;!\r\n\t", 100
# Of the layer: our word, the file's, the default of EnergyPlus's IDD for WindowMaterial:Glazing, the range.
THERMAL = {
    "conductivity": ("ThermalConductivity", 0.9, (0.0, np.inf)),
    "emissivity_front": ("EmissivityFront", 0.84, (0.0, 1.0)),
    "emissivity_back": ("EmissivityBack", 0.84, (0.0, 1.0)),
    "infrared_transmittance": ("TIR", 0.0, (0.0, 1.0)),
}
# EnergyPlus has none: common window glass.
DEFAULT_THICKNESS = 0.003

Objects = dict[str, dict[str, dict[str, Any]]]


def energyplus(
    bsdf: Bsdf,
    name: str | None = None,
    *,
    solar_from_visible: bool = False,
    thickness: float | None = None,
    conductivity: float | None = None,
    emissivity_front: float | None = None,
    emissivity_back: float | None = None,
    infrared_transmittance: float | None = None,
) -> Objects:
    """Make a window construction for EnergyPlus: Construction:ComplexFenestrationState, its matrices and its layer.

    The construction is one solid layer. An absent transmission is the other one reversed, an absent reflection is
    black, with a warning.

    Parameters
    ----------
    bsdf
        With bands Visible and Solar.
    name
        Of the construction; that of the BSDF unless told otherwise. All other names begin with it.
    solar_from_visible
        Use Visible where there is no Solar. Wrong for coated glass and most fabrics.
    thickness
        [m]; the file's, else 0.003.
    conductivity
        [W/(m K)]; the file's, else 0.9.
    emissivity_front, emissivity_back
        Hemispherical, in the infrared, of the outside and the room side; the file's, else 0.84.
    infrared_transmittance
        The file's, else 0.

    Returns
    -------
    dict
        epJSON: type of object, name, fields. To be merged with a model, whose windows name the construction.

    Raises
    ------
    ValueError
        If a band is missing, or a name or a value cannot be written.

    Examples
    --------
    >>> half = Bsdf.from_components({"transmission_front": Matrix.from_values(np.full((145, 145), 0.5 / np.pi)),
    ...                              "reflection_front": Matrix.from_values(np.zeros((145, 145))),
    ...                              "reflection_back": Matrix.from_values(np.zeros((145, 145)))})
    >>> made = energyplus(half, "half", solar_from_visible=True)
    >>> round(made["Matrix:TwoDimension"]["half_layer_1_fAbs"]["values"][0]["value"], 6)
    0.5
    """
    name = _checked_name(bsdf.name or "BSDF" if name is None else name)
    given = {
        "conductivity": conductivity,
        "emissivity_front": emissivity_front,
        "emissivity_back": emissivity_back,
        "infrared_transmittance": infrared_transmittance,
    }
    layer = _layer(bsdf, thickness, given)
    bands = _bands(bsdf, solar_from_visible)
    visible, solar = (_full(bsdf, band) for band in bands)
    for band, key in zip((*bands, bands[1]), ("reflection_back", "reflection_back", "reflection_front"), strict=True):
        if key not in bsdf.components_of(band):
            warnings.warn(f"{band} {key} is absent: taken as black", stacklevel=2)
    rings = [((low + high) / 2 if low else 0.0, n) for low, high, n in solar["transmission_front"].exitant_rings]
    absorbed = {side: _absorptance(solar, side, bands[1])[None] for side in ("front", "back")}
    matrices: dict[str, NDArray[np.float64]] = {
        "Basis": np.array(rings),
        "TfSol": _written(solar["transmission_front"]),
        "RbSol": _written(solar["reflection_back"]),
        "Tfvis": _written(visible["transmission_front"]),
        "Rbvis": _written(visible["reflection_back"]),
        "layer_1_fAbs": absorbed["front"],
        "layer_1_bAbs": absorbed["back"],
    }
    return {
        "Construction:ComplexFenestrationState": {
            name: {
                "basis_type": "LBNLWINDOW",
                "basis_symmetry_type": "None",
                "window_thermal_model": f"{name}_thermal",
                "basis_matrix_name": f"{name}_Basis",
                "solar_optical_complex_front_transmittance_matrix_name": f"{name}_TfSol",
                "solar_optical_complex_back_reflectance_matrix_name": f"{name}_RbSol",
                "visible_optical_complex_front_transmittance_matrix_name": f"{name}_Tfvis",
                "visible_optical_complex_back_transmittance_matrix_name": f"{name}_Rbvis",
                "outside_layer_name": f"{name}_layer_1",
                "outside_layer_directional_front_absorptance_matrix_name": f"{name}_layer_1_fAbs",
                "outside_layer_directional_back_absorptance_matrix_name": f"{name}_layer_1_bAbs",
            }
        },
        "Matrix:TwoDimension": {f"{name}_{key}": _matrix_object(values) for key, values in matrices.items()},
        "WindowMaterial:Glazing": {f"{name}_layer_1": layer},
        "WindowThermalModel:Params": {
            f"{name}_thermal": {
                "standard": "ISO15099",
                "thermal_model": "ISO15099",
                "sdscalar": 1.0,
                "deflection_model": "NoDeflection",
            }
        },
    }


def save_energyplus(path: str | os.PathLike[str], objects: Objects) -> None:
    """Write what :func:`energyplus` made: an IDF if the path ends in .idf, else epJSON.

    Parameters
    ----------
    path
        The file; it is replaced when it is complete.
    objects
        What :func:`energyplus` returned.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    target = Path(path)
    text = idf_text(objects) if target.suffix.lower() == ".idf" else json.dumps(objects, indent=1) + "\n"
    write_whole(target, text.encode())


def idf_text(objects: Objects) -> str:
    """Return the objects as text for an IDF."""
    # An IDF knows fields by their order; that of ours is EnergyPlus's, but for the optical fields a layer leaves empty.
    return "".join(_idf_object(kind, name, fields) for kind, all_ in objects.items() for name, fields in all_.items())


def _idf_object(kind: str, name: str, fields: Mapping[str, Any]) -> str:
    return ",\n  ".join([kind, name, *_idf_fields(kind, fields)]) + ";\n\n"


def _idf_fields(kind: str, fields: Mapping[str, Any]) -> Iterator[str]:
    for key, value in fields.items():
        if key == "values":
            # Short lines: earlier versions read 500 characters.
            numbers = [repr(each["value"]) for each in value]
            yield from (", ".join(numbers[i : i + 10]) for i in range(0, len(numbers), 10))
        elif kind == "WindowMaterial:Glazing" and key == "thickness":
            # Transmittances and reflectances of a layer that has none but its construction's.
            yield from ["", repr(value), *[""] * 6]
        else:
            yield value if isinstance(value, str) else repr(value)


def _checked_name(name: str) -> str:
    longest = LONGEST - len("_layer_1_fAbs")
    if not name.strip() or len(name) > longest or any(c in FORBIDDEN or not c.isprintable() for c in name):
        raise ValueError(
            f"name {name[:120]!r} of the construction; expected 1 to {longest} printable characters without , ; and !:"
            " give another name"
        )
    return name


def _layer(bsdf: Bsdf, thickness: float | None, given: Mapping[str, float | None]) -> dict[str, Any]:
    """Return the fields of WindowMaterial:Glazing, in EnergyPlus's order."""
    if thickness is None:
        thickness = bsdf.thickness or DEFAULT_THICKNESS
    value = {"thickness": _in_range("thickness", thickness, (0.0, np.inf))}
    for key, (word, default, range_) in THERMAL.items():
        found = given[key]
        if found is None:
            text = bsdf.properties.get(word)
            try:
                found = default if text is None else float(text)
            except ValueError:
                raise ValueError(f"{word} of the file is {text!r}; expected a number: give {key}") from None
        value[key] = _in_range(key, found, range_)
    return {
        "optical_data_type": "BSDF",
        "thickness": value["thickness"],
        "infrared_transmittance_at_normal_incidence": value["infrared_transmittance"],
        "front_side_infrared_hemispherical_emissivity": value["emissivity_front"],
        "back_side_infrared_hemispherical_emissivity": value["emissivity_back"],
        "conductivity": value["conductivity"],
    }


def _in_range(key: str, value: float, range_: tuple[float, float]) -> float:
    low, high = range_
    # Thickness and conductivity divide.
    if not (low <= value <= high and np.isfinite(value) and (value > 0 or high == 1)):
        raise ValueError(f"{key} {value}; expected {'0 to 1' if high == 1 else 'a number above 0'}: give {key}")
    return float(value)


def _bands(bsdf: Bsdf, solar_from_visible: bool) -> tuple[str, str]:
    there = ", ".join(bsdf.bands) or "none"
    if "Visible" not in bsdf.bands:
        raise ValueError(f"no band Visible; there are: {there}. EnergyPlus needs Visible and Solar")
    if "Solar" in bsdf.bands:
        return "Visible", "Solar"
    if solar_from_visible:
        return "Visible", "Visible"
    raise ValueError(
        f"no band Solar; there are: {there}. EnergyPlus needs it for heat: generate with --bands Visible,Solar, add it"
        " by `bsdftree merge visible.xml solar.xml@Solar`, or let Visible stand for it by --solar-from-visible"
        " (solar_from_visible=True)"
    )


def _full(bsdf: Bsdf, band: str) -> dict[str, Matrix]:
    """All four components of a band as Klems full matrices."""
    found = bsdf.components_of(band)
    if not all(isinstance(f, Matrix) and f.incident_basis == f.exitant_basis == FULL for f in found.values()):
        found = bsdf.select(bands=[band]).to_klems("full").components_of(band)
    full = {key: f for key, f in found.items() if isinstance(f, Matrix)}
    black = Matrix.from_values(np.zeros((145, 145)), "full")
    for key, other in (("transmission_front", "transmission_back"), ("transmission_back", "transmission_front")):
        if key not in found:
            full[key] = _reversed(full[other]) if other in found else black
    for key in ("reflection_front", "reflection_back"):
        full.setdefault(key, black)
    return full


def _reversed(matrix: Matrix) -> Matrix:
    """Return the transmission of light that goes the other way: transposed, and each azimuth half a turn on."""
    counts = [n for _, _, n in matrix.incident_rings]
    first = np.cumsum([0, *counts[:-1]])
    half_turned = np.concatenate([i + (np.arange(n) + n // 2) % n for i, n in zip(first, counts, strict=True)])
    return Matrix.from_values(matrix.values.T[np.ix_(half_turned, half_turned)], "full")


def _absorptance(band: Mapping[str, Matrix], side: str, name: str) -> NDArray[np.float64]:
    """1 - T - R of light from each patch of a side."""
    scattered = np.zeros(145)
    for part in ("transmission", "reflection"):
        matrix = band[f"{part}_{side}"]
        scattered += np.asarray(matrix.values, np.float64) @ matrix.projected_solid_angles()[1]
    if scattered.max() > 1.001:
        warnings.warn(
            f"{name}: light from the {side} (WINDOW's) becomes up to {scattered.max():.3f} of itself: absorptance 0"
            " there; see bsdftree check",
            stacklevel=3,
        )
    return np.clip(1 - scattered, 0, 1)


def _written(matrix: Matrix) -> NDArray[np.float64]:
    """Rows exitant, columns incident."""
    return np.asarray(matrix.values.T, np.float64)


def _matrix_object(values: NDArray[np.float64]) -> dict[str, Any]:
    # The shortest text that is this single-precision value: mostly that of the XML.
    numbers = [{"value": float(str(v))} for v in values.astype(np.float32).ravel()]
    return {"number_of_rows": values.shape[0], "number_of_columns": values.shape[1], "values": numbers}
