"""``bsdftree measured``: what is in files of measurements."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, Literal

import click
from rich.console import Console

from bsdftree import Measurement
from bsdftree.cli._common import (
    columns_option,
    format_option,
    grazing_option,
    json_option,
    print_json,
    printable,
    side_option,
    table,
    with_input_errors,
)

# Two names of angles and four ranges take more than the width of other tables.
_wide = Console(soft_wrap=True, width=170)
# Of more rows than this, the first are shown.
_MOST_ROWS = 60


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@columns_option
@format_option
@side_option
@grazing_option
@click.option("--plot", type=click.Path(), metavar="FILE", help="Draw the coverage as PNG, SVG or PDF.")
@click.option(
    "-o", "--output", type=click.Path(file_okay=False), metavar="DIR", help="Write files that pabopto2bsdf takes."
)
@json_option
@with_input_errors
def measured(
    files: tuple[str, ...],
    columns: str | None,
    format_: str | None,
    side: Literal["front", "back"],
    grazing: float | Literal["auto"] | None,
    plot: str | None,
    output: str | None,
    as_json: bool,
) -> None:
    """Say what is in files of measurements of one sample: directions, coverage, values, noise.

    \b
    Examples:
      bsdftree measured coating_*.txt
      bsdftree measured coating.bsdf --plot coating.png
      bsdftree measured scan.csv --columns theta_i=1,theta_o=2,phi_o=3,value=4 -o scan
    """
    measurement = Measurement.load(files, columns=columns, side=side, format=format_, grazing=grazing)
    if as_json:
        print_json(summarize(measurement))
    else:
        show(measurement)
    if plot:
        from bsdftree.plot import save

        save(measurement.plot(), plot)
        click.echo(f"wrote {plot}", err=True)
    if output:
        click.echo(f"wrote {len(measurement.save(output))} files to {output}", err=True)


def summarize(measurement: Measurement) -> dict[str, Any]:
    """Collect what is printed."""
    return {
        "name": measurement.name,
        "manufacturer": measurement.manufacturer,
        "symmetry": measurement.symmetry,
        "wavelength_nm": measurement.wavelength_nm,
        "n_channels": measurement.n_channels,
        "parts": measurement.parts,
        "notes": measurement.notes,
        "scans": [asdict(row) | {"source": measurement.scans[row.scan].source} for row in measurement.summary()],
    }


def show(measurement: Measurement) -> None:
    """Print a summary for people."""
    facts = [measurement.name or "a sample", "X, Y, Z" if measurement.n_channels == 3 else "one channel"]
    facts += [measurement.symmetry] if measurement.symmetry else []
    facts += [f"{measurement.wavelength_nm:g} nm"] if measurement.wavelength_nm else []
    _wide.print(printable(", ".join(facts)), highlight=False, markup=False)
    for note in measurement.notes:
        _wide.print(printable(f"note: {note}"), style="dim", highlight=False, markup=False)
    angles = (">θ in", ">φ in", ">points", ">θ out", ">azimuths", ">spacing", ">hole")
    rows = table("part", *angles, ">values [1/sr]", ">below 0", ">error", ">asymmetry", ">total")
    summary = measurement.summary()
    for row in summary[:_MOST_ROWS]:
        rows.add_row(
            row.part,
            f"{row.incident_theta_deg:.1f}°",
            f"{row.incident_phi_deg:.1f}°",
            f"{row.n_points:,}",
            "{:.0f}–{:.0f}°".format(*row.theta_range_deg),
            f"{row.azimuth_coverage_deg:.0f}°",
            "–" if row.spacing_deg is None else f"{row.spacing_deg:.1f}°",
            f"{row.hole_deg:.0f}°",
            "{:.3g}..{:.3g}".format(*row.value_range),
            f"{row.n_negative:,}",
            "–" if row.relative_error is None else f"{100 * row.relative_error:.1f} %",
            "–" if row.asymmetry is None else f"{100 * row.asymmetry:.0f} %",
            "–" if row.total is None else f"{100 * row.total:.1f} %",
        )
    _wide.print(rows)
    if len(summary) > _MOST_ROWS:
        _wide.print(f"and {len(summary) - _MOST_ROWS} more; --json has all")
