"""``bsdftree eval``: values for pairs of directions."""

from __future__ import annotations

from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from bsdftree import Bsdf
from bsdftree.cli._common import json_option, print_json, read, repair_option, with_input_errors
from bsdftree.cli._pairs import BINARY, blocks, directions, width_of


def _letters(_context: click.Context, _parameter: click.Parameter, value: str) -> tuple[str, str]:
    if len(value) not in (1, 2) or set(value) - set("afd"):
        raise click.BadParameter(f"{value!r}; expected one or two letters of a, f and d, as rtrace's -f")
    return value[0], value[-1]


@click.command("eval", context_settings={"ignore_unknown_options": True})
@click.argument("file", type=click.Path())
@click.argument("numbers", nargs=-1, type=float, metavar="[ANGLES]...")
@click.option("--vectors", is_flag=True, help="Two vectors to a pair, six numbers, instead of angles.")
@click.option(
    "-f",
    "--format",
    "letters",
    default="a",
    show_default=True,
    callback=_letters,
    metavar="IO",
    help="Numbers of input and output: a text, f float, d double, as rtrace's -f; one letter is for both.",
)
@click.option("--color", is_flag=True, help="Print CIE X, Y, Z instead of Y.")
@click.option("--pdf", is_flag=True, help="Print the density [1/sr] of sampling the exitant direction as well.")
@click.option("--smooth", is_flag=True, help="Ramps in the leaves of trees instead of steps.")
@click.option("--band", default="Visible", show_default=True, help="Spectral band.")
@repair_option
@json_option
@with_input_errors
def eval_(
    file: str,
    numbers: tuple[float, ...],
    vectors: bool,
    letters: tuple[str, str],
    color: bool,
    pdf: bool,
    smooth: bool,
    band: str,
    repair: bool,
    as_json: bool,
) -> None:
    """Print the BSDF [1/sr] of FILE for pairs of directions.

    ANGLES are θ_incident φ_incident θ_exitant φ_exitant in degrees, four to a pair; without them they are read
    from standard input, one pair a line. θ is measured from +Z (the room side), so that a θ over 90 lies on the
    back; φ counter-clockwise from +X. Both directions point away from the surface. The BSDF has no cosine.

    \b
    Examples:
      bsdftree eval blinds.xml 30 90 30 270
      bsdftree eval blinds.xml < pairs.txt
      bsdftree eval --vectors -fdf blinds.xml < vectors.dbl > values.flt
      bsdftree eval --json --pdf blinds.xml 30 90 150 270
    """
    width = width_of(vectors)
    if len(numbers) % width:
        expected = (
            "six to a pair: two vectors" if vectors else "four to a pair: θ_incident φ_incident θ_exitant φ_exitant [°]"
        )
        raise click.UsageError(f"{len(numbers)} numbers; expected {expected}")
    if as_json and letters[1] != "a":
        raise click.UsageError(f"--json is text; -f asks for {letters[1]}")
    given = iter([np.array(numbers).reshape(-1, width)]) if numbers else blocks(letters[0], vectors)
    bsdf = read(file, repair)
    bsdf = bsdf.smooth() if smooth else bsdf
    rows: list[dict[str, Any]] = []
    n_pairs = 0
    for pairs in given:
        n_pairs += len(pairs)
        values, densities = _values(bsdf, pairs, vectors, color, pdf, band)
        if as_json:
            rows += _rows(pairs, values, densities, vectors)
            continue
        columns = values.reshape(len(pairs), -1)
        _put(columns if densities is None else np.column_stack([columns, densities]), letters[1])
    if n_pairs == 0:
        raise click.UsageError(f"no pairs of directions; expected {width} numbers to a pair")
    if as_json:
        print_json(rows)


def _values(
    bsdf: Bsdf, pairs: NDArray[np.float64], vectors: bool, color: bool, pdf: bool, band: str
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    incident, exitant = directions(pairs, vectors)
    values = bsdf.eval(incident, exitant, color=color, band=band)
    return values, bsdf.pdf(incident, exitant, band=band) if pdf else None


def _put(columns: NDArray[np.float64], letter: str) -> None:
    if letter == "a":
        click.echo("\n".join("\t".join(f"{v:.7g}" for v in line) for line in columns))
    else:
        click.echo(columns.astype(BINARY[letter]).tobytes(), nl=False)


def _rows(
    pairs: NDArray[np.float64], values: NDArray[np.float64], densities: NDArray[np.float64] | None, vectors: bool
) -> list[dict[str, Any]]:
    half = pairs.shape[1] // 2
    unit = "" if vectors else "_deg"
    key = "xyz" if values.ndim == 2 else "value"
    rows = [
        {f"incident{unit}": p[:half].tolist(), f"exitant{unit}": p[half:].tolist(), key: v.tolist()}
        for p, v in zip(pairs, values, strict=True)
    ]
    if densities is not None:
        for row, density in zip(rows, densities, strict=True):
            row["pdf"] = float(density)
    return rows
