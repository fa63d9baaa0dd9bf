"""``bsdftree eval``: values for pairs of directions."""

from __future__ import annotations

import sys

import click
import numpy as np

from bsdftree import direction_from_polar
from bsdftree.cli._common import json_option, print_json, read, repair_option, with_input_errors


@click.command("eval")
@click.argument("file", type=click.Path())
@click.argument("angles", nargs=-1, type=float)
@click.option("--color", is_flag=True, help="Print CIE X, Y, Z instead of Y.")
@click.option("--pdf", is_flag=True, help="Print the density [1/sr] of sampling the exitant direction as well.")
@click.option("--band", default="Visible", show_default=True, help="Spectral band.")
@repair_option
@json_option
@with_input_errors
def eval_(file: str, angles: tuple[float, ...], color: bool, pdf: bool, band: str, repair: bool, as_json: bool) -> None:
    """Print the BSDF [1/sr] of FILE for pairs of directions.

    ANGLES are θ_incident φ_incident θ_exitant φ_exitant in degrees, four to a pair; without them they are read
    from standard input, one pair a line. θ is measured from +Z (the room side), so that a θ over 90 lies on the
    back; φ counter-clockwise from +X. Both directions point away from the surface. The BSDF has no cosine.

    \b
    Examples:
      bsdftree eval blinds.xml 30 90 30 270
      bsdftree eval blinds.xml < pairs.txt
      bsdftree eval --json --pdf blinds.xml 30 90 150 270
    """
    numbers = list(angles) if angles else _numbers_from_stdin()
    if len(numbers) % 4 or not numbers:
        raise click.UsageError(
            f"{len(numbers)} angles; expected four to a pair: θ_incident φ_incident θ_exitant φ_exitant in degrees"
        )
    pairs = np.array(numbers).reshape(-1, 4)
    bsdf = read(file, repair)
    incident = direction_from_polar(pairs[:, 0], pairs[:, 1])
    exitant = direction_from_polar(pairs[:, 2], pairs[:, 3])
    values = bsdf.eval(incident, exitant, color=color, band=band)
    densities = bsdf.pdf(incident, exitant, band=band) if pdf else None
    if as_json:
        key = "xyz" if color else "value"
        rows = [
            {"incident_deg": p[:2].tolist(), "exitant_deg": p[2:].tolist(), key: v.tolist()}
            for p, v in zip(pairs, values, strict=True)
        ]
        if densities is not None:
            for row, density in zip(rows, densities, strict=True):
                row["pdf"] = float(density)
        print_json(rows)
        return
    columns = np.atleast_2d(values.T).T
    if densities is not None:
        columns = np.column_stack([columns, densities])
    for line in columns:
        click.echo("\t".join(f"{v:.7g}" for v in line))


def _numbers_from_stdin() -> list[float]:
    numbers: list[float] = []
    for number, line in enumerate(sys.stdin, 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        if len(words) != 4:
            raise ValueError(f"standard input, line {number}: {len(words)} numbers; expected four angles in degrees")
        try:
            numbers += [float(w) for w in words]
        except ValueError:
            raise ValueError(
                f"standard input, line {number}: {line.strip()!r}; expected four angles in degrees"
            ) from None
    return numbers
