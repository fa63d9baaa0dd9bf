"""``bsdftree stack``: layers one behind the other."""

from __future__ import annotations

import click

import bsdftree
from bsdftree.cli._common import BASES, PERCENT, read, repair_option, with_input_errors


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("-o", "--output", required=True, type=click.Path(), help="File to write.")
@click.option(
    "--klems",
    type=BASES,
    help="Stack over the patches of this basis; by default that of the first matrix.",
)
@click.option(
    "--log2-res",
    type=click.IntRange(1, 6),
    help="Stack over trees of rank 4 with 2^N cells per axis; by default the finest of the files, up to 5.",
)
@click.option(
    "--tolerance",
    type=PERCENT,
    default=0.0,
    show_default=True,
    metavar="PERCENT",
    help="For trees: relative error that joining cells may add.",
)
@repair_option
@with_input_errors
def stack(
    files: tuple[str, ...], output: str, klems: str | None, log2_res: int | None, tolerance: float, repair: bool
) -> None:
    """Stack the layers in FILES, the first one outside, the last one towards the room.

    All light that goes to and fro between layers is followed. A shade that is measured the wrong way round is turned by
    `bsdftree convert --flip`. Light leaves a cell evenly over all of it, so that peaks get wider by up to a cell at
    each layer.

    \b
    Examples:
      bsdftree stack glass.xml shade.xml -o window.xml
      bsdftree stack glass.xml blinds.xml -o window.xml --klems full
      bsdftree stack glass.xml blinds.xml -o window.xml --log2-res 5 --tolerance 1
    """
    layers = [read(path, repair) for path in files]
    made = bsdftree.stack(layers, klems=klems, log2_res=log2_res, tolerance=tolerance / 100)
    missing = sorted({band for layer in layers for band in layer.bands} - set(made.bands))
    if missing:
        click.echo(f"left out, since not all layers have it: {', '.join(missing)}", err=True)
    made.save(output)
