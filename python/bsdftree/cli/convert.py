"""``bsdftree convert``: from one file to another, in another format or of another kind of data."""

from __future__ import annotations

import click

from bsdftree import Bsdf
from bsdftree.cli._common import read, repair_option, with_input_errors


@click.command()
@click.argument("source", metavar="IN", type=click.Path())
@click.argument("target", metavar="OUT", type=click.Path())
@repair_option
@with_input_errors
def convert(source: str, target: str, repair: bool) -> None:
    """Write the BSDF in IN to OUT, in the format that the ending of OUT says.

    \b
    Examples:
      bsdftree convert --repair faulty.xml mended.xml
    """
    _converted(read(source, repair)).save(target)


def _converted(bsdf: Bsdf) -> Bsdf:
    """Change what the BSDF is made of, as the options ask; as it is without any."""
    return bsdf
