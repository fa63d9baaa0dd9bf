"""``bsdftree check``: does a file obey physics."""

from __future__ import annotations

import sys
from dataclasses import asdict

import click

from bsdftree import BandCheck, polar_from_direction
from bsdftree.cli._common import json_option, print_json, read, repair_option, stdout, table, with_input_errors


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option(
    "--energy",
    default=1.0,
    show_default=True,
    metavar="PERCENT",
    help="Tolerated excess of scattered light over 100 %.",
)
@click.option(
    "--reciprocity",
    default=25.0,
    show_default=True,
    metavar="PERCENT",
    help="Tolerated mean difference |a-b|/(a+b) between pairs of directions and the same pairs swapped, by flux.",
)
@repair_option
@json_option
@with_input_errors
def check(files: tuple[str, ...], energy: float, reciprocity: float, repair: bool, as_json: bool) -> None:
    """Check energy, reciprocity, missing sides and orientation of BSDF files.

    Exits with 1 if any file violates energy conservation or reciprocity beyond tolerance, or cannot be read. Noise in
    ray-traced data shows as a lack of reciprocity: raise the tolerance, or generate with more samples.

    \b
    Examples:
      bsdftree check blinds.xml
      bsdftree check --reciprocity 10 --json *.xml
    """
    results = []
    for path in files:
        bands = read(path, repair).check(energy=energy / 100, reciprocity=reciprocity / 100)
        results.append({"file": path, "ok": all(b.ok for b in bands), "bands": [asdict(b) for b in bands]})
        if not as_json:
            _show(path, bands)
    if as_json:
        print_json(results if len(results) > 1 else results[0])
    if not all(result["ok"] for result in results):
        sys.exit(1)


def _show(path: str, bands: list[BandCheck]) -> None:
    for band in bands:
        stdout.print(f"[bold]{path}[/bold]  {band.band}", highlight=False)
        energy = table("light from", ">reflected", ">transmitted", ">most", "at θ, φ")
        for e in band.energy:
            theta, phi = polar_from_direction([*e.at[:2], abs(e.at[2])])
            side = "front (room)" if e.side == "front" else "back (outside)"
            energy.add_row(
                side,
                f"{100 * e.reflected:.2f} %",
                f"{100 * e.transmitted:.2f} %",
                f"{100 * e.max:.2f} %",
                f"{theta:.1f}°, {phi:.1f}°",
            )
        stdout.print(energy)
        if band.reciprocity:
            pairs = table("reciprocity error", ">mean by flux", ">largest")
            for r in band.reciprocity:
                pairs.add_row(r.part, f"{100 * r.mean:.2f} %", f"{100 * r.max:.1f} %")
            stdout.print(pairs)
        for finding in band.findings:
            color = "red" if finding.severity == "violation" else "yellow"
            stdout.print(f"[{color}]{finding.severity}[/{color}]: {finding.message}", highlight=False)
        if band.ok:
            stdout.print("[green]ok[/green]")
        stdout.print()
