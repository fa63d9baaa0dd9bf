"""``bsdftree lobes``: the lobes of incident directions as a mesh."""

from __future__ import annotations

from typing import Literal

import click

import bsdftree
from bsdftree.cli._common import read, repair_option, with_input_errors


@click.command()
@click.argument("file", type=click.Path())
@click.option("-o", "--output", required=True, metavar="OUT.obj", type=click.Path(), help="Wavefront OBJ to write.")
@click.option(
    "--incident",
    type=(float, float),
    multiple=True,
    required=True,
    metavar="THETA PHI",
    help="Where light comes from [degree], once or more: θ from +Z, over 90 is from outside; φ counter-clockwise from "
    "+X, 90 is from above.",
)
@click.option(
    "--radius", type=click.Choice(["log", "linear"]), default="log", show_default=True, help="Log is over 4 decades."
)
@click.option(
    "--log2-res", type=click.IntRange(1, 10), default=6, show_default=True, help="2^N cells per axis of a hemisphere."
)
@click.option("--band", help="Spectral band. [default: Visible, or the only one]")
@repair_option
@with_input_errors
def lobes(
    file: str,
    output: str,
    incident: tuple[tuple[float, float], ...],
    radius: Literal["log", "linear"],
    log2_res: int,
    band: str | None,
    repair: bool,
) -> None:
    """Write the lobes of FILE as a mesh: a solid as far from its middle as the BSDF is large in that direction.

    One solid for the reflected and one for the transmitted light of each incident direction, side by side along X, with
    materials `reflection`, `transmission`, and `light` for the sign of where the light comes from. +Z is the room. For
    any viewer of meshes, and for Radiance: `obj2mesh -a materials.rad lobe.obj lobe.rtm`.

    \b
    Examples:
      bsdftree lobes blinds.xml --incident 150 90 -o lobe.obj
      bsdftree lobes blinds.xml --incident 180 0 --incident 150 90 --incident 120 90 --radius linear -o lobes.obj
    """
    if not output.lower().endswith(".obj"):
        raise click.UsageError(f"-o {output}: expected a name that ends in .obj")
    directions = [bsdftree.direction_from_polar(theta, phi) for theta, phi in incident]
    top = bsdftree.save_lobes(output, read(file, repair), directions, band=band, log2_res=log2_res, radius=radius)
    click.echo(f"wrote {output}; {top:.4g}/sr is 1 from the middle", err=True)
