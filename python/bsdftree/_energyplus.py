"""BSDFs as a window construction for EnergyPlus: ``Construction:ComplexFenestrationState`` and what it names.

In go the BSDFs of its layers, with the bands Visible and Solar; out come EnergyPlus objects as epJSON has them. Trees,
and matrices of other bases, become Klems full first. Values are BSDF [1/sr], as in WINDOW's XML: EnergyPlus multiplies
them by projected solid angles itself. A row for each exitant patch, a column for each incident one. Front is the
outside, as in WINDOW, and an azimuth is that of the way the light goes, on either side, so WINDOW's matrices are
EnergyPlus's as they stand. The basis has a row for each ring: polar angle of its middle [degree], number of patches. An
absorptance matrix is one row: what light from that patch leaves in the layer.

Several layers have gaps of gas between them, matrices of their stack, and absorptances with all light that goes to and
fro. One layer absorbs all that is neither transmitted nor reflected: a BSDF does not say what is between its faces.
Infrared and conduction come from options, else from the files, else from defaults (``_energyplus_layers``).

Sources: EnergyPlus Input Output Reference, Construction:ComplexFenestrationState and Matrix:TwoDimension; EnergyPlus's
code where that is silent: WindowComplexManager.cc for rows, columns and weights (what of a beam is transmitted is the
sum over the column of its patch, times projected solid angle) and for azimuths (WorldVectFromW6); GetMatrixInput, which
reads row by row. The field "visible … back transmittance" is read as back *reflectance* (VisBkRefl), and that is
written. For diffuse light EnergyPlus takes rows for columns: see COMPARE.md. Names of fields are those of
EnergyPlus 25.2; earlier ones spelled "absoptance". An IDF has no names of fields, and suits either.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bsdftree._bsdf import Bsdf
from bsdftree._combine import layer_absorptances, merge, stack
from bsdftree._component import Matrix
from bsdftree._energyplus_file import Objects
from bsdftree._energyplus_layers import DEFAULT_GAP, gap, glazing, is_shade, shade

FULL = "LBNL/Klems Full"
# What else an epJSON or IDF field would end at, and EnergyPlus's longest name.
FORBIDDEN, LONGEST = ",;!\r\n\t", 100
MOST_LAYERS = 5
"""That a construction of EnergyPlus has."""
Gap = float | tuple[float, str]


def energyplus(
    layers: Bsdf | Sequence[Bsdf],
    name: str | None = None,
    *,
    gaps: Sequence[Gap] | None = None,
    shades: Sequence[bool] | None = None,
    solar_from_visible: bool = False,
    thickness: float | None = None,
    conductivity: float | None = None,
    emissivity_front: float | None = None,
    emissivity_back: float | None = None,
    infrared_transmittance: float | None = None,
) -> Objects:
    """Make a window construction for EnergyPlus: Construction:ComplexFenestrationState, its matrices and its layers.

    An absent transmission is the other one reversed, an absent reflection is black, with a warning.

    Parameters
    ----------
    layers
        With bands Visible and Solar. One, which becomes one solid layer, or up to 5 from the outside to the room, which
        are stacked as by :func:`stack`.
    name
        Of the construction; that of the BSDF unless told otherwise. All other names begin with it.
    gaps
        Of several layers: the distances between them [m], or distance and gas (Air, Argon, Krypton, Xenon). By default
        0.0127 of air.
    shades
        Of several layers, whether each is a shade (WindowMaterial:ComplexShade) and not glass; by default, if its file
        says how permeable it is or that the infrared passes, or has geometry.
    solar_from_visible
        Use Visible where there is no Solar. Wrong for coated glass and most fabrics.
    thickness
        [m]; the file's, else 0.003. This and what follows is for one layer; of several, the files' (``with_header``).
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
        If a band is missing, layers, gaps and shades do not go together, or a name or a value cannot be written.

    Examples
    --------
    >>> half = Bsdf.from_components({"transmission_front": Matrix.from_values(np.full((145, 145), 0.5 / np.pi)),
    ...                              "reflection_front": Matrix.from_values(np.zeros((145, 145))),
    ...                              "reflection_back": Matrix.from_values(np.zeros((145, 145)))})
    >>> made = energyplus(half, "half", solar_from_visible=True)
    >>> round(made["Matrix:TwoDimension"]["half_layer_1_fAbs"]["values"][0]["value"], 6)
    0.5
    >>> made = energyplus([half, half], "both", gaps=[(0.01, "Argon")], solar_from_visible=True)
    >>> round(made["Matrix:TwoDimension"]["both_layer_2_fAbs"]["values"][0]["value"], 6)
    0.25
    """
    layers = [layers] if isinstance(layers, Bsdf) else list(layers)
    if not 1 <= len(layers) <= MOST_LAYERS:
        raise ValueError(f"{len(layers)} layers; expected 1 to {MOST_LAYERS}")
    name = _checked_name(" + ".join(layer.name or "BSDF" for layer in layers) if name is None else name)
    given = {
        "thickness": thickness,
        "conductivity": conductivity,
        "emissivity_front": emissivity_front,
        "emissivity_back": emissivity_back,
        "infrared_transmittance": infrared_transmittance,
    }
    materials = _materials(layers, name, gaps, shades, given)
    with_solar = [_with_solar(layer, solar_from_visible) for layer in layers]
    for layer in layers:
        _say_absent(layer)
    layers = with_solar
    whole = layers[0] if len(layers) == 1 else stack(layers, klems="full")
    visible, solar = (_full(whole, band) for band in ("Visible", "Solar"))
    rings = [((low + high) / 2 if low else 0.0, n) for low, high, n in solar["transmission_front"].exitant_rings]
    matrices: dict[str, NDArray[np.float64]] = {
        "Basis": np.array(rings),
        "TfSol": _written(solar["transmission_front"]),
        "RbSol": _written(solar["reflection_back"]),
        "Tfvis": _written(visible["transmission_front"]),
        "Rbvis": _written(visible["reflection_back"]),
    }
    for k, sides in enumerate(_absorptances(layers), 1):
        for side, absorbed in zip("fb", sides, strict=True):
            matrices[f"layer_{k}_{side}Abs"] = absorbed[None]
    return {
        "Construction:ComplexFenestrationState": {name: _construction(name, len(layers))},
        "Matrix:TwoDimension": {f"{name}_{key}": _matrix_object(values) for key, values in matrices.items()},
        **materials,
        "WindowThermalModel:Params": {
            f"{name}_thermal": {
                "standard": "ISO15099",
                "thermal_model": "ISO15099",
                "sdscalar": 1.0,
                "deflection_model": "NoDeflection",
            }
        },
    }


def _construction(name: str, n_layers: int) -> dict[str, str]:
    """Return the fields of Construction:ComplexFenestrationState, in EnergyPlus's order."""
    fields = {
        "basis_type": "LBNLWINDOW",
        "basis_symmetry_type": "None",
        "window_thermal_model": f"{name}_thermal",
        "basis_matrix_name": f"{name}_Basis",
        "solar_optical_complex_front_transmittance_matrix_name": f"{name}_TfSol",
        "solar_optical_complex_back_reflectance_matrix_name": f"{name}_RbSol",
        "visible_optical_complex_front_transmittance_matrix_name": f"{name}_Tfvis",
        "visible_optical_complex_back_transmittance_matrix_name": f"{name}_Rbvis",
    }
    for k in range(1, n_layers + 1):
        layer = "outside_layer" if k == 1 else f"layer_{k}"
        fields[f"{layer}_name"] = f"{name}_layer_{k}"
        fields[f"{layer}_directional_front_absorptance_matrix_name"] = f"{name}_layer_{k}_fAbs"
        fields[f"{layer}_directional_back_absorptance_matrix_name"] = f"{name}_layer_{k}_bAbs"
        if k < n_layers:
            fields[f"gap_{k}_name"] = f"{name}_gap_{k}"
    return fields


def _materials(
    layers: Sequence[Bsdf],
    name: str,
    gaps: Sequence[Gap] | None,
    shades: Sequence[bool] | None,
    given: Mapping[str, float | None],
) -> Objects:
    """What layers and gaps are made of."""
    n = len(layers)
    if n == 1:
        rest = {key: value for key, value in given.items() if key != "thickness"}
        return {"WindowMaterial:Glazing": {f"{name}_layer_1": glazing(layers[0], given["thickness"], rest)}}
    if any(value is not None for value in given.values()):
        key = next(key for key, value in given.items() if value is not None)
        raise ValueError(f"{key} for {n} layers; expected it in the files of the layers: with_header, properties")
    gaps = [DEFAULT_GAP] * (n - 1) if gaps is None else list(gaps)
    shades = [is_shade(layer) for layer in layers] if shades is None else list(shades)
    if len(gaps) != n - 1 or len(shades) != n:
        raise ValueError(f"{n} layers with {len(gaps)} gaps and {len(shades)} shades; expected {n - 1} and {n}")
    made: Objects = {}
    for k, (layer, is_one) in enumerate(zip(layers, shades, strict=True), 1):
        kind = "ComplexShade" if is_one else "Glazing"
        fields = shade(layer) if is_one else glazing(layer, None, {})
        made.setdefault(f"WindowMaterial:{kind}", {})[f"{name}_layer_{k}"] = fields
    for k, each in enumerate(gaps, 1):
        distance, gas = (each, "Air") if isinstance(each, (int, float)) else each
        for kind, objects in gap(f"{name}_gap_{k}", distance, gas).items():
            made.setdefault(kind, {}).update(objects)
    return made


def _checked_name(name: str) -> str:
    longest = LONGEST - len("_layer_1_fAbs")
    if not name.strip() or len(name) > longest or any(c in FORBIDDEN or not c.isprintable() for c in name):
        raise ValueError(
            f"name {name[:120]!r} of the construction; expected 1 to {longest} printable characters without , ; and !:"
            " give another name"
        )
    return name


def _with_solar(layer: Bsdf, solar_from_visible: bool) -> Bsdf:
    """The bands Visible and Solar of a layer, the latter from the former if told so."""
    there = ", ".join(layer.bands) or "none"
    if "Visible" not in layer.bands:
        raise ValueError(f"no band Visible; there are: {there}. EnergyPlus needs Visible and Solar")
    if "Solar" in layer.bands:
        return layer
    if solar_from_visible:
        visible = layer.select(bands=["Visible"])
        return merge([visible, visible.select(rename=("Visible", "Solar"))])
    raise ValueError(
        f"no band Solar; there are: {there}. EnergyPlus needs it for heat: generate with --bands Visible,Solar, add it"
        " by `bsdftree merge visible.xml solar.xml@Solar`, or let Visible stand for it by --solar-from-visible"
        " (solar_from_visible=True)"
    )


def _say_absent(layer: Bsdf) -> None:
    solar = "Solar" if "Solar" in layer.bands else "Visible"
    for band, key in (("Visible", "reflection_back"), (solar, "reflection_back"), (solar, "reflection_front")):
        if key not in layer.components_of(band):
            warnings.warn(f"{band} {key} is absent: taken as black", stacklevel=3)


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


def _absorptances(layers: Sequence[Bsdf]) -> NDArray[np.float64]:
    """Of light from each patch of both sides, what each layer absorbs, (layers, 2, 145)."""
    absorbed = layer_absorptances(layers, "Solar", klems="full")
    for k, sides in enumerate(absorbed, 1):
        for side, each in zip(("front", "back"), sides, strict=True):
            if each.min() < -0.001:
                of = "" if len(layers) == 1 else f" by layer {k}"
                warnings.warn(
                    f"Solar: light from the {side} (WINDOW's) becomes up to {1 - each.min():.3f} of itself{of}:"
                    " absorptance 0 there; see bsdftree check",
                    stacklevel=3,
                )
    return np.clip(absorbed, 0, 1)


def _written(matrix: Matrix) -> NDArray[np.float64]:
    """Rows exitant, columns incident."""
    return np.asarray(matrix.values.T, np.float64)


def _matrix_object(values: NDArray[np.float64]) -> dict[str, Any]:
    # The shortest text that is this single-precision value: mostly that of the XML.
    numbers = [{"value": float(str(v))} for v in values.astype(np.float32).ravel()]
    return {"number_of_rows": values.shape[0], "number_of_columns": values.shape[1], "values": numbers}
