"""``bsdftree fit``: measurements to trees, with their errors."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import asdict, replace
from typing import Any, Literal, get_args

import click

import bsdftree
from bsdftree import Bsdf, FitSummary, FittedTrees, Measurement
from bsdftree._fit import Frame
from bsdftree._measurement import Symmetry
from bsdftree.cli._common import (
    BASES,
    PERCENT,
    columns_option,
    format_option,
    grazing_option,
    json_option,
    print_json,
    side_option,
    stderr,
    tell,
    with_input_errors,
)
from bsdftree.cli._fit_tables import show
from bsdftree.cli._progress import cells_bar, fits_bar

# More incident directions than this share outside of those measured are worth a warning.
_MOST = 0.5


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("-o", "--output", metavar="OUT", required=True, help="File to write: .xml or .bsdft.")
@click.option(
    "--symmetry",
    type=click.Choice(get_args(Symmetry)),
    help="Of the sample; bilateral_x is a mirror at the plane y = 0, bilateral_y at x = 0, half_turn half a turn "
    'without a mirror (pabopto2bsdf\'s "up"). [default: what the files state, or the scans show]',
)
@click.option(
    "--frame",
    type=click.Choice(get_args(Frame)),
    help="How lobes move with the incident direction. [default: what predicts left-out scans best]",
)
@click.option(
    "--reciprocal/--no-reciprocal",
    default=None,
    help="Whether values of swapped directions count too. [default: where scans agree, and it helps to predict them]",
)
@click.option("--rank", type=click.Choice(["3", "4"]), help="Of the tree. [default: 3 if isotropic, else 4]")
@click.option(
    "--log2-res",
    type=int,
    metavar="N",
    help="Up to 2^N cells per axis: to 9 at rank 3, to 7 at rank 4. [default: what shows the points]",
)
@click.option(
    "--tolerance",
    type=PERCENT,
    metavar="PERCENT",
    help="Relative L1 error that reducing the tree may add; 0 keeps everything. [default: a fifth of the fit's]",
)
@click.option("--klems", type=BASES, help="A Klems matrix of the tree instead of the tree.")
@click.option(
    "--errors",
    "errors_output",
    metavar="FILE",
    help="Write the same tree with a standard error in place of each value; bsdftree info --errors reads it.",
)
@click.option("--plot", type=click.Path(), metavar="FILE", help="Draw points beside fitted values and errors.")
@columns_option
@format_option
@side_option
@grazing_option
@click.option("--name", help="Name of the product in the file. [default: the sample's]")
@click.option("--manufacturer", help="Its maker.")
@json_option
@with_input_errors
def fit(
    files: tuple[str, ...],
    output: str,
    symmetry: str | None,
    frame: str | None,
    reciprocal: bool | None,
    rank: str | None,
    log2_res: int | None,
    tolerance: float | None,
    klems: str | None,
    errors_output: str | None,
    plot: str | None,
    columns: str | None,
    format_: str | None,
    side: Literal["front", "back"],
    grazing: float | Literal["auto"] | None,
    name: str | None,
    manufacturer: str | None,
    as_json: bool,
) -> None:
    """Fit a tree to measurements of one sample and write it as WINDOW 6 XML.

    Between measured incident directions lobes move. How they move, and which symmetry the sample has, is what predicts
    left-out scans best from the others; the summary shows the scores. `bsdftree measured` says what is in the files.

    \b
    Examples:
      bsdftree fit coating.bsdf -o coating.xml
      bsdftree fit film_*.txt -o film.xml --errors film_errors.xml --plot film.png
      bsdftree fit film_*.txt -o film.xml --symmetry quadrilateral --log2-res 6 --tolerance 1
      bsdftree fit scan.csv --columns theta_i=1,theta_o=2,phi_o=3,value=4 -o scan.xml
    """
    if klems and errors_output:
        raise click.UsageError("--errors are those of a tree; leave out --klems")
    if plot:
        _check_picture(plot)
    measurement = Measurement.load(files, columns=columns, side=side, format=format_, grazing=grazing)
    with fits_bar() as bar:
        fitted = bsdftree.fit(
            measurement,
            symmetry=symmetry,  # type: ignore[arg-type]
            frame=frame,  # type: ignore[arg-type]
            reciprocal=reciprocal,
            progress=bar.update,
        )
    with cells_bar() as bar:
        trees = fitted.trees(
            rank=int(rank) if rank else None,
            log2_res=log2_res,
            tolerance=None if tolerance is None else tolerance / 100,
            progress=bar.update,
        )
    command = shlex.join(["bsdftree", "fit", *sys.argv[2:]])
    told = trees.bsdf.name or os.path.splitext(os.path.basename(files[0]))[0]
    bsdf, errors = (
        b.with_header(
            name=name or told,
            manufacturer=manufacturer or b.manufacturer,
            provenance=[*b.provenance, f"Command: {command}"],
        )
        for b in trees
    )
    written: Bsdf = bsdf.to_klems(klems) if klems else bsdf
    written.save(output)
    if errors_output:
        errors.save(errors_output)
    if plot:
        from bsdftree.plot import save

        save(fitted.plot(title=name or told), plot)
    summary = replace(fitted.summary(FittedTrees(bsdf, errors)), name=bsdf.name)
    for part in summary.parts:
        if part.extrapolated > _MOST:
            tell(
                [
                    f"{part.component}: most of the tree is extrapolated, {100 * part.extrapolated:.0f} % of incident "
                    "directions lie outside those measured; if turns or mirrors leave the sample as it is, say so with "
                    "--symmetry"
                ]
            )
    if as_json:
        print_json(_as_json(summary, output))
        return
    show(summary)
    for path in (output, errors_output, plot):
        if path:
            stderr.print(f"wrote {path}, {os.path.getsize(path):,} bytes", highlight=False)


def _check_picture(path: str) -> None:
    """Refuse before the work what cannot be drawn after it."""
    try:
        from bsdftree.plot._style import FORMATS
    except ModuleNotFoundError as error:
        raise click.ClickException(str(error)) from None
    ending = os.path.splitext(path)[1].lower()
    if ending.lstrip(".") not in FORMATS:
        raise click.UsageError(f"--plot {path}: ending {ending!r}; expected .png, .svg or .pdf")


def _as_json(summary: FitSummary, output: str) -> dict[str, Any]:
    """NaN is no JSON: what could not be scored is null."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(v) for key, v in value.items()}
        if isinstance(value, (list, tuple)):
            return [plain(v) for v in value]
        return None if isinstance(value, float) and value != value else value

    described: dict[str, Any] = plain({"file": output} | asdict(summary))
    return described
