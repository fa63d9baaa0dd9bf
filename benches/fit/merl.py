"""MERL's materials by the parameters that were fitted to them: luminance of the published fits of bsdfbenchmark/bbm.

In: files of lines `name = Aggregate(Lambertian(albedo = [r, g, b]), Model(parameter = …, …))` of the data folder
(`bbm-fits`, BSD-3-Clause). Out: functions of pairs of directions. Each band is evaluated with its own parameters.

| model in the file | form | from |
|---|---|---|
| NganWard | Ward 1992 | Ngan, Durand, Matusik, EGSR 2005 |
| NganWardDuer | Ward with Dür's normalisation | the same |
| NganBlinnPhong | half vector to a power | the same |
| NganCookTorrance | Beckmann / π, V grooves, Schlick, over π cos cos | the same |
| LowCookTorrance | Beckmann × π, V grooves, Fresnel of an index, over π cos cos | Low et al., TOG 31(1), 2012 |
| LowMicrofacetFit | A (1 + B (1 − cos half))^−C, V grooves, Fresnel of an index, over π cos cos | the same |
| Bagher | shifted gamma distribution with its fitted masking | Bagher, Soler, Holzschuch, CGF 31(4), 2012 |
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import formulas as F
from .formulas import Array, Function

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Of linear sRGB, which MERL's colours are taken for."""
Parameters = Mapping[str, Any]


def read(path: Path, name: str) -> Function:
    """The luminance of one material of a file of fits."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith(f"{name} = "):
            return _material(line, f"{path}:{number}")
    raise ValueError(f"{path}: no material {name!r}")


def _material(line: str, where: str) -> Function:
    albedo = re.search(r"Lambertian\(albedo = (\[[^]]*\])\)", line)
    model = re.search(r"\), (\w+)\((.*)\)\)\s*$", line)
    if albedo is None or model is None or model[1] not in MODELS:
        raise ValueError(f"{where}: expected Aggregate(Lambertian(…), one of {', '.join(MODELS)}(…))")
    parameters = ast.literal_eval(re.sub(r"(\w+) = ", r"'\1': ", "{" + model[2] + "}"))
    parts = []
    for band, (weight, base) in enumerate(zip(LUMINANCE, ast.literal_eval(albedo[1]), strict=True)):
        mine = {key: _of_band(value, band) for key, value in parameters.items()}
        parts.append((weight, F.total(F.diffuse(base), MODELS[model[1]](mine))))
    return lambda incident, exitant: sum((w * f(incident, exitant) for w, f in parts), np.zeros(len(incident)))


def _of_band(value: float | list[float] | list[list[float]], band: int) -> Any:
    if not isinstance(value, list):
        return value
    return [row[band] for row in value] if isinstance(value[0], list) else value[band]


def _low_microfacets(p: Parameters) -> Function:
    return F.microfacets(
        lambda cosine: p["A"] * (1 + p["B"] * (1 - cosine)) ** -p["C"],
        lambda cosine: F.fresnel_of_index(p["eta"], cosine),
        F.grooves,
    )


def _low_cook_torrance(p: Parameters) -> Function:
    return F.microfacets(
        lambda cosine: p["albedo"] * F.beckmann(p["roughness"], cosine),
        lambda cosine: F.fresnel_of_index(p["eta"], cosine),
        F.grooves,
    )


def _ngan_cook_torrance(p: Parameters) -> Function:
    return F.microfacets(
        lambda cosine: p["albedo"] * F.beckmann(p["roughness"], cosine) / np.pi,
        lambda cosine: F.schlick(p["eta"], cosine),
        F.grooves,
    )


def _shifted_gamma(p: Parameters) -> Function:
    """Bagher et al.: their distribution, fitted masking and adapted Schlick term."""
    alpha, power, scale = (p[key] for key in ("alpha", "p", "K"))
    at_normal, slope = p["eta"]

    def normals(cosine: Array) -> Array:
        shifted = alpha + (1 / cosine**2 - 1) / alpha
        return p["albedo"] * scale * np.exp(-shifted) / (shifted**power * np.pi * cosine**4)

    def one(direction: Array) -> Array:
        theta = np.arccos(np.clip(direction[:, 2], 0, 1))
        over = np.maximum(theta - p["theta0"], 0)
        return np.clip(1 + p["Lambda"] * (1 - np.exp(p["c"] * over ** p["k"])), 0, 1)

    return F.microfacets(
        normals,
        lambda cosine: np.maximum(F.schlick(at_normal, cosine) - slope * cosine, 0),
        lambda incident, exitant, _: one(incident) * one(exitant),
    )


MODELS: dict[str, Callable[..., Function]] = {
    "NganWard": lambda p: F.ward(p["albedo"], p["roughness"]),
    "NganWardDuer": lambda p: F.ward(p["albedo"], p["roughness"], power=1.0),
    "NganBlinnPhong": lambda p: F.blinn_phong(p["albedo"], p["sharpness"]),
    "NganCookTorrance": _ngan_cook_torrance,
    "LowCookTorrance": _low_cook_torrance,
    "LowMicrofacetFit": _low_microfacets,
    "Bagher": _shifted_gamma,
}
