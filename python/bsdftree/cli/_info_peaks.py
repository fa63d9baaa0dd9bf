"""Specular peaks as ``info --peaks`` prints them: in go families of peaks, out come their JSON and a table."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from bsdftree import PeakFamily, polar_from_direction
from bsdftree.cli._common import stdout, table

_PEAK_THETAS_DEG = (0, 30, 60)
_SUN_DEG = 0.533
# What deviates a peak takes more than the width of other tables.
_wide = Console(soft_wrap=True, width=200)


def summarize_peaks(family: PeakFamily) -> dict[str, Any]:
    """Collect what ``info --peaks`` prints of a family, and its peaks one by one."""
    rows = []
    for peak in family.peaks:
        row: dict[str, Any] = {}
        for name, direction in (("incident", peak.incident), ("exitant", peak.exitant)):
            theta, phi = polar_from_direction(direction)
            row |= {f"{name}_theta_deg": float(theta), f"{name}_phi_deg": float(phi)}
        row |= {key: getattr(peak, key) for key in ("strength", "surround", "width_deg", "resolution_limited")}
        rows.append(row)
    least, most = family.strength_range
    return {
        "component": family.component,
        "kind": family.kind,
        "normal": family.normal,
        "axis": family.axis,
        "index": family.index,
        "flat_first": family.flat_first,
        "shift": family.shift,
        "residual_deg": family.residual_deg,
        "n_directions": family.n_directions,
        "n_found": family.n_found,
        "theta_deg": [min(family.theta_deg), max(family.theta_deg)],
        "strength": {"mean": family.mean_strength, "min": least, "max": most},
        "strength_by_theta_deg": {str(t): family.strength_at(t) for t in _PEAK_THETAS_DEG},
        "width_deg": family.width_deg,
        "resolution_limited": family.resolution_limited,
        "peaks": rows,
    }


_PEAK_KINDS = {"straight": "straight through", "mirror": "mirrored", "retro": "retroreflected"}


def _deviation(family: dict[str, Any]) -> str:
    """What deviates the peaks of a family, in words."""

    def along(vector: tuple[float, float, float]) -> str:
        tilt, azimuth = polar_from_direction(vector)
        return f"{tilt:.1f}° to φ {round(float(azimuth)) % 360}°"

    match family["kind"]:
        case "facet":
            return f"mirror facets {along(family['normal'])}"
        case "groove":
            tilt, azimuth = polar_from_direction(family["axis"])
            # An axis in the plane of the device has no tilt worth telling, and points both ways.
            direction = f"φ {round(float(azimuth)) % 180}°" if tilt > 89 else along(family["axis"])
            return f"right-angled grooves along {direction}"
        case "prism":
            first = "flat side" if family["flat_first"] else "ridges"
            return f"prism facets {along(family['normal'])}, index {family['index']:.2f}, {first} first"
        case "inner_facet":
            return f"inner facets {along(family['normal'])}, index {family['index']:.2f}"
        case "shift":
            return "shift {:+.3f}, {:+.3f} in direction cosines".format(*family["shift"])
        case "table":
            return "no one map: see --json"
        case _:
            return ""


def show_peaks(families: list[dict[str, Any]]) -> None:
    """Print a table of the peaks of a band."""
    if not families:
        stdout.print("\nNo specular peaks", style="bold")
        return
    angles = (f">{t}°" for t in _PEAK_THETAS_DEG)
    ranges = (">θ", ">found", ">width", ">sun ×", ">misfit", "deviated by")
    rows = table("component", "peak", ">strength", ">min..max", *angles, *ranges, title="\nSpecular peaks")
    for f in families:
        strength, (low, high) = f["strength"], f["theta_deg"]
        rows.add_row(
            f["component"],
            _PEAK_KINDS.get(f["kind"], "deviated"),
            f"{100 * strength['mean']:.1f} %",
            f"{100 * strength['min']:.1f}..{100 * strength['max']:.1f} %",
            *("–" if s is None else f"{100 * s:.1f} %" for s in f["strength_by_theta_deg"].values()),
            f"{low:.0f}–{high:.0f}°",
            f"{100 * f['n_found'] / f['n_directions']:.0f} %",
            f"{'≤ ' if f['resolution_limited'] else ''}{f['width_deg']:.1f}°",
            f"{max((f['width_deg'] / _SUN_DEG) ** 2, 1):,.0f}",
            "–" if f["residual_deg"] is None else f"{f['residual_deg']:.1f}°",
            _deviation(f),
        )
    _wide.print(rows)


PEAK_NOTE = """\
strength: part of the light in the peak, mean where it is found; 0°, 30°, 60°: of light from there.
θ, found: incident directions. misfit: angle (root mean square) from the map of directions that the peak follows.
width ≤: as narrow as the data can say, in truth perhaps narrower.
sun ×: the data keeps a peak's light but smears it over its width, so the sun in it is this much too large and dim.
What to do: straight peaks come out sharp with Radiance's aBSDF in place of BSDF. Others do not: generate finer data
(--log2-res), or put the mirror or prism itself into the scene where glare and sun patches matter."""
