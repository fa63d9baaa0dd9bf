"""``bsdftree convert``: from one file to another, in another format or of another kind of data."""

from __future__ import annotations

import click

from bsdftree import Bsdf
from bsdftree.cli._common import read, repair_option, with_input_errors


@click.command()
@click.argument("source", metavar="IN", type=click.Path())
@click.argument("target", metavar="OUT", type=click.Path())
@click.option("--packed", is_flag=True, help="Compress a .bsdft file.")
@click.option(
    "--level",
    type=click.IntRange(1, 22),
    default=19,
    show_default=True,
    help="With --packed: from 1, fast, to 22, small.",
)
@click.option(
    "--klems", type=click.Choice(["full", "half", "half73", "quarter"]), help="To matrices over this angle basis."
)
@click.option(
    "--subdivide",
    type=click.IntRange(1, 16),
    default=1,
    show_default=True,
    help="With --klems: split each patch into N by N.",
)
@click.option("--tree", is_flag=True, help="To tensor trees.")
@click.option("--rank", type=click.IntRange(3, 4), default=4, show_default=True, help="With --tree: 3 is isotropic.")
@click.option(
    "--log2-res",
    type=click.IntRange(1, 10),
    default=6,
    show_default=True,
    help="With --tree: at most 2^N cells per axis.",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(0, 100, max_open=True),
    default=0.0,
    show_default=True,
    metavar="PERCENT",
    help="With --tree: relative error that joining cells may add.",
)
@repair_option
@with_input_errors
def convert(
    source: str,
    target: str,
    packed: bool,
    level: int,
    klems: str | None,
    subdivide: int,
    tree: bool,
    rank: int,
    log2_res: int,
    tolerance: float,
    repair: bool,
) -> None:
    """Write the BSDF in IN to OUT, in the format that the ending of OUT says.

    .bsdft is the binary twin of the XML: the same to the last bit, smaller, and open at once whatever its size.
    Packed, it is smaller still, and read as a whole. Any other ending is WINDOW 6 XML.

    With --klems or --tree it becomes one of the other kind: means by projected solid angle, from the areas that
    cells and patches share, so totals are kept. What that changes is said on standard error, as relative error (L1).

    \b
    Examples:
      bsdftree convert blinds.xml blinds.bsdft
      bsdftree convert --packed blinds.xml archive.bsdft
      bsdftree convert archive.bsdft blinds.xml
      bsdftree convert --repair faulty.xml mended.xml
      bsdftree convert blinds.xml klems.xml --klems full
      bsdftree convert blinds.xml fine.xml --klems full --subdivide 2
      bsdftree convert klems.xml tree.xml --tree --rank 4 --log2-res 6 --tolerance 1
    """
    bsdf = read(source, repair)
    if klems and tree:
        raise click.UsageError("--klems and --tree; expected one of them")
    made = bsdf
    if klems:
        made = bsdf.to_klems(klems, subdivide=subdivide)
    elif tree:
        made = bsdf.to_tree(rank, log2_res, tolerance=tolerance / 100)
    if made is not bsdf:
        _say_errors(bsdf, made)
    made.save(target, packed=packed, level=level)


def _say_errors(bsdf: Bsdf, made: Bsdf) -> None:
    for band in bsdf.bands:
        for key, error in bsdf.distance(made, band).items():
            click.echo(f"{band} {key}: relative L1 error {100 * error:.2g} %", err=True)
