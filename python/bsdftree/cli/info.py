"""``bsdftree info``: what is in a file."""

from __future__ import annotations

import os
from typing import Any

import click

from bsdftree import Bsdf, Tree, errors_by_flux
from bsdftree._queries import Part
from bsdftree._totals import mean_total, totals_by_azimuth
from bsdftree.cli._common import json_option, print_json, read, repair_option, stdout, table, with_input_errors
from bsdftree.cli._info_charts import can_chart, leaves_chart, totals_chart
from bsdftree.cli._info_peaks import PEAK_NOTE, show_peaks, summarize_peaks

_PARTS: tuple[Part, ...] = ("reflection", "transmission")
_THETAS_DEG = (0, 15, 30, 45, 60, 75)


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("--peaks", is_flag=True, help="Find specular peaks: straight through, mirrored and deviated.")
@click.option(
    "--min-strength",
    type=click.FloatRange(0, 100, min_open=True, max_open=True),
    default=0.2,
    show_default=True,
    metavar="PERCENT",
    help="With --peaks: least part of the light in a peak.",
)
@click.option(
    "--errors",
    "errors_file",
    type=click.Path(),
    metavar="FILE",
    help="Standard errors that bsdftree fit --errors wrote of one BSDF: say how well it is known.",
)
@repair_option
@json_option
@with_input_errors
def info(
    files: tuple[str, ...],
    peaks: bool,
    min_strength: float,
    errors_file: str | None,
    repair: bool,
    as_json: bool,
) -> None:
    """Say what is in BSDF files: size, components, resolution, reflectance and transmittance.

    On a terminal with small charts; in a pipe, with NO_COLOR or TERM=dumb, plain.

    \b
    Examples:
      bsdftree info blinds.xml
      bsdftree info --peaks glazing.xml
      bsdftree info --errors film_errors.xml film.xml
      bsdftree info --json *.xml
    """
    if errors_file and len(files) > 1:
        raise click.UsageError("--errors are of one BSDF; give one file")
    summaries = []
    for path in files:
        bsdf = read(path, repair)
        summary = summarize(bsdf, path)
        if peaks:
            for band in summary["bands"]:
                families = bsdf.peaks(min_strength=min_strength / 100, band=band["band"])
                band["peaks"] = [summarize_peaks(family) for family in families]
        if errors_file:
            _add_errors(summary, bsdf, errors_file, repair)
        summaries.append(summary)
        if not as_json:
            show(summary, bsdf)
    if as_json:
        print_json(summaries if len(summaries) > 1 else summaries[0])


def _add_errors(summary: dict[str, Any], bsdf: Bsdf, path: str, repair: bool) -> None:
    """Put into each component how well it is known."""
    errors = read(path, repair)
    for band in summary["bands"]:
        try:
            known = errors_by_flux(bsdf, errors, band["band"])
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        for component in band["components"]:
            of_component = known[component["component"]]
            component |= {"standard_error": of_component.mean, "uncertain": of_component.uncertain}


def _totals(bsdf: Bsdf, band: str) -> list[dict[str, Any]]:
    """Reflectance and transmittance from both sides: by polar angle (mean over azimuth), and over the hemisphere."""
    rows = []
    for side, sign in (("front", 1.0), ("back", -1.0)):
        for part in _PARTS:
            by_angle = totals_by_azimuth(bsdf, sign, part, _THETAS_DEG, band).mean(axis=1)
            rows.append(
                {
                    "incident_side": side,
                    "part": part,
                    "hemispherical": mean_total(bsdf, sign, part, band),
                    "by_theta_deg": {str(t): float(v) for t, v in zip(_THETAS_DEG, by_angle, strict=True)},
                }
            )
    return rows


def summarize(bsdf: Bsdf, path: str | None = None) -> dict[str, Any]:
    """Collect what ``info`` prints."""
    bands = []
    for band in bsdf.bands:
        lambertian = bsdf.lambertian(band)
        chroma = bsdf.chroma_of(band)
        components = []
        for key, component in bsdf.components_of(band).items():
            entry: dict[str, Any] = {"component": key, "color": key in chroma, "lambertian": lambertian[key]}
            if isinstance(component, Tree):
                entry |= {
                    "kind": f"tree, rank {component.rank}",
                    "resolution": f"2^{component.depth} per axis",
                    "values": component.n_leaves,
                }
            else:
                entry |= {
                    "kind": "matrix",
                    "resolution": f"{component.incident_basis} " + " × ".join(map(str, component.values.shape)),
                    "values": component.values.size,
                }
            entry["bytes"] = component.nbytes
            components.append(entry)
        bands.append({"band": band, "components": components, "totals": _totals(bsdf, band)})
    return {
        "file": path,
        "file_bytes": os.path.getsize(path) if path else None,
        "name": bsdf.name,
        "manufacturer": bsdf.manufacturer,
        "width": bsdf.width,
        "height": bsdf.height,
        "thickness": bsdf.thickness,
        "unit": bsdf.unit,
        "has_geometry": bsdf.geometry is not None,
        "provenance": bsdf.provenance,
        "bands": bands,
    }


def _show_charts(bsdf: Bsdf, band: str) -> None:
    """Print what a terminal shows beside the tables."""
    charts = {
        "Reflectance and transmittance by incident angle, mean over azimuth": totals_chart(bsdf, band),
        "Leaves by depth (cells per axis)": leaves_chart(bsdf, band),
    }
    for title, lines in charts.items():
        if lines:
            stdout.print(f"\n{title}", style="bold", highlight=False, markup=False)
            for line in lines:
                stdout.print(line, highlight=False, markup=False)


def show(summary: dict[str, Any], bsdf: Bsdf) -> None:
    """Print a summary for people: with charts on a terminal."""
    if summary["file"]:
        stdout.print(f"[bold]{summary['file']}[/bold]  {summary['file_bytes']:,} bytes", highlight=False)
    size = " × ".join("?" if summary[k] is None else f"{summary[k]:.4g}" for k in ("width", "height", "thickness"))
    name, maker = (summary[k] or "–" for k in ("name", "manufacturer"))
    geometry = ", with geometry" if summary["has_geometry"] else ""
    stdout.print(f"{name} by {maker}, {size} m (W × H × T){geometry}", highlight=False, markup=False)
    for line in summary["provenance"]:
        stdout.print(line, style="dim", highlight=False, markup=False)
    for band in summary["bands"]:
        known = "standard_error" in band["components"][0]
        columns = ("component", "kind", "resolution", ">values", ">memory", ">Lambertian", "color")
        of_errors = (">standard error", ">of light > 25 %") if known else ()
        components = table(*columns, *of_errors, title=f"\n{band['band']}")
        for c in band["components"]:
            components.add_row(
                c["component"],
                c["kind"],
                c["resolution"],
                f"{c['values']:,}",
                f"{c['bytes'] / 1024:,.1f} KiB",
                f"{100 * c['lambertian']:.2f} %",
                "yes" if c["color"] else "no",
                *(f"{100 * c[key]:.1f} %" for key in ("standard_error", "uncertain") if known),
            )
        stdout.print(components)
        angles = (f">{t}°" for t in _THETAS_DEG)
        totals = table("light from", "scattered by", ">hemisphere", *angles, title="\nReflectance and transmittance")
        for t in band["totals"]:
            side = "front (room)" if t["incident_side"] == "front" else "back (outside)"
            values = [t["hemispherical"], *t["by_theta_deg"].values()]
            totals.add_row(side, t["part"], *(f"{100 * v:.2f} %" for v in values))
        stdout.print(totals)
        if can_chart(stdout):
            _show_charts(bsdf, band["band"])
        if "peaks" in band:
            show_peaks(band["peaks"])
    if any(band.get("peaks") for band in summary["bands"]):
        stdout.print(PEAK_NOTE, style="dim", highlight=False, markup=False)
    stdout.print()
