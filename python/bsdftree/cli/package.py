"""``bsdftree package``: BSDF files as objects for Radiance's scenes."""

from __future__ import annotations

import warnings

import click

import bsdftree
from bsdftree.cli._common import repair_option, tell, with_input_errors


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option(
    "-o", "--output", metavar="DIR", default=".", show_default=True, type=click.Path(), help="Directory to write to."
)
@click.option("--size", type=(float, float), metavar="WIDTH HEIGHT", help="Of the rectangle [m]. [default: the file's]")
@click.option(
    "--through/--no-through",
    default=None,
    help="Whether light straight through stays sharp (aBSDF). [default: if there is a peak, and no geometry]",
)
@click.option("--instance", is_flag=True, help="Write geometry as a frozen octree. Needs 'bsdftree[radiance]'.")
@repair_option
@with_input_errors
def package(
    files: tuple[str, ...],
    output: str,
    size: tuple[float, float] | None,
    through: bool | None,
    instance: bool,
    repair: bool,
) -> None:
    """Write each of FILES as NAME.rad, with the XML that it names, as Radiance's pkgBSDF does.

    In metres, a rectangle of the width and height in the file, its middle on the Z axis; it faces +Z, the room, and up
    is +Y. If the file holds geometry (generate --geometry), that is there too: rays of view and shadow see it, others
    take the BSDF. Radiance finds the XML if it runs in DIR, or if DIR is in RAYPATH.

    \b
    Examples:
      bsdftree package blinds.xml
      bsdftree package blinds.xml screen.bsdft -o objects
      bsdftree package clear.xml --size 1.2 0.9 --no-through
    """
    for file in files:
        with warnings.catch_warnings(record=True) as doubts:
            warnings.simplefilter("always")
            made = bsdftree.package(file, output, size=size, through=through, instance=instance, strict=not repair)
        tell(dict.fromkeys(str(doubt.message) for doubt in doubts))
        click.echo(f"wrote {made}", err=True)
