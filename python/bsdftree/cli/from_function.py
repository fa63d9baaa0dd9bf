"""``bsdftree from-function``: a tensor tree of a function in Radiance's language."""

from __future__ import annotations

import click

from bsdftree import Bsdf
from bsdftree._component import COMPONENTS
from bsdftree.cli._common import PERCENT, with_input_errors


@click.command("from-function")
@click.argument("names", nargs=-1, required=True, metavar="NAME [GREEN BLUE]")
@click.option("-o", "--output", required=True, type=click.Path(), help="File to write.")
@click.option("-f", "files", multiple=True, type=click.Path(), help="Function file (.cal).")
@click.option("-e", "definitions", multiple=True, metavar="EXPR", help="Definitions, such as 's = 0.1;'.")
@click.option("--rank", type=click.IntRange(3, 4), default=4, show_default=True, help="3 is isotropic.")
@click.option(
    "--log2-res", type=click.IntRange(1, 10), default=6, show_default=True, help="At most 2^N cells per axis."
)
@click.option(
    "--tolerance",
    type=PERCENT,
    default=2.0,
    show_default=True,
    metavar="PERCENT",
    help="Relative error to aim at.",
)
@click.option(
    "-c",
    "--component",
    "components",
    multiple=True,
    type=click.Choice(COMPONENTS),
    help="What to make; all by default, black ones are left out. Front is the outside, as in WINDOW.",
)
@with_input_errors
def from_function(
    names: tuple[str, ...],
    output: str,
    files: tuple[str, ...],
    definitions: tuple[str, ...],
    rank: int,
    log2_res: int,
    tolerance: float,
    components: tuple[str, ...],
) -> None:
    """Make a tensor tree of the function NAME, refined where it changes.

    NAME takes six arguments, as in bsdf2ttree: the incident and the exitant unit vector, both away from the surface,
    +Z in the room. Its value is the BSDF [1/sr] without cosine. Three names are red, green and blue.

    \b
    Examples:
      bsdftree from-function white -e 'white(ix,iy,iz,ox,oy,oz) = if(iz*oz, .8/PI, 0);' -o white.xml
      bsdftree from-function -f lobe.cal lobe --rank 3 --log2-res 7 -o lobe.xml
    """
    if len(names) not in (1, 3):
        raise click.UsageError(f"{len(names)} names; expected one function, or three: red, green and blue")
    made = Bsdf.from_cal(
        names,
        files=files,
        definitions=definitions,
        rank=rank,
        log2_res=log2_res,
        tolerance=tolerance / 100,
        components=components or COMPONENTS,
    )
    if not made.components:
        raise ValueError(f"{names[0]} is 0 everywhere: there is nothing to write")
    made.save(output)
