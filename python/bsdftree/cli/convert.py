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
@repair_option
@with_input_errors
def convert(source: str, target: str, packed: bool, level: int, repair: bool) -> None:
    """Write the BSDF in IN to OUT, in the format that the ending of OUT says.

    .bsdft is the binary twin of the XML: the same to the last bit, smaller, and open at once whatever its size.
    Packed, it is smaller still, and read as a whole. Any other ending is WINDOW 6 XML.

    \b
    Examples:
      bsdftree convert blinds.xml blinds.bsdft
      bsdftree convert --packed blinds.xml archive.bsdft
      bsdftree convert archive.bsdft blinds.xml
      bsdftree convert --repair faulty.xml mended.xml
    """
    bsdf = read(source, repair)
    _converted(bsdf).save(target, packed=packed, level=level)


def _converted(bsdf: Bsdf) -> Bsdf:
    """Change what the BSDF is made of, as the options ask; as it is without any."""
    return bsdf
