"""``bsdftree stack``: layers one behind the other."""

from __future__ import annotations

from typing import Any

import click

import bsdftree
from bsdftree import Bsdf
from bsdftree.cli._common import BASES, PERCENT, read, repair_option, with_input_errors
from bsdftree.cli._energyplus_output import is_energyplus, write_energyplus


def _gaps(_context: click.Context, _parameter: click.Parameter, values: tuple[str, ...]) -> list[Any]:
    """Distances and gases of gaps."""
    made: list[Any] = []
    for value in values:
        distance, comma, gas = value.partition(",")
        try:
            made.append((float(distance), gas.strip()) if comma else float(distance))
        except ValueError:
            raise click.BadParameter(f"{value!r}; expected a distance [m], or distance,gas") from None
    return made


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
@click.option("--name", help="For .idf and .epJSON: name of the construction; those of the layers.")
@click.option(
    "--gap",
    "gaps",
    multiple=True,
    callback=_gaps,
    metavar="METERS[,GAS]",
    help="For .idf and .epJSON: a gap, one option each from the outside; Air, Argon, Krypton or Xenon. "
    "[default: 0.0127,Air]",
)
@click.option(
    "--shade",
    "shades",
    type=click.IntRange(1, 5),
    multiple=True,
    metavar="LAYER",
    help="For .idf and .epJSON: which layer is a shade, 1 is outside; once or more. [default: what the files say]",
)
@click.option("--solar-from-visible", is_flag=True, help="For .idf and .epJSON: take Visible where there is no Solar.")
@repair_option
@with_input_errors
def stack(
    files: tuple[str, ...],
    output: str,
    klems: str | None,
    log2_res: int | None,
    tolerance: float,
    name: str | None,
    gaps: list[Any],
    shades: tuple[int, ...],
    solar_from_visible: bool,
    repair: bool,
) -> None:
    """Stack the layers in FILES, the first one outside, the last one towards the room.

    All light that goes to and fro between layers is followed. A shade that is measured the wrong way round is turned by
    `bsdftree convert --flip`. Light leaves a cell evenly over all of it, so that peaks get wider by up to a cell at
    each layer.

    If OUTPUT ends in .idf or .epJSON, it is a window construction for EnergyPlus, with a material and absorptances for
    each layer, and gaps between them.

    \b
    Examples:
      bsdftree stack glass.xml shade.xml -o window.xml
      bsdftree stack glass.xml blinds.xml -o window.xml --klems full
      bsdftree stack glass.xml blinds.xml -o window.xml --log2-res 5 --tolerance 1
      bsdftree stack glass.xml glass.xml screen.xml -o window.idf --name window --gap 0.0127,Argon --gap 0.05
    """
    construction: dict[str, Any] = {
        "name": name,
        "gap": gaps,
        "shade": shades,
        "solar_from_visible": solar_from_visible,
    }
    for_energyplus = is_energyplus(output, construction)
    layers = [read(path, repair) for path in files]
    if for_energyplus:
        if klems not in (None, "full") or log2_res:
            raise click.UsageError(f"-o {output}: EnergyPlus has Klems full; leave --klems and --log2-res out")
        if shades and max(shades) > len(layers):
            raise click.UsageError(f"--shade {max(shades)}; there are {len(layers)} layers")
        options = {"gaps": gaps or None, "name": name, "solar_from_visible": solar_from_visible}
        chosen = [k in shades for k in range(1, len(layers) + 1)] if shades else None
        write_energyplus(layers, output, {**options, "shades": chosen})
        return
    made = bsdftree.stack(layers, klems=klems, log2_res=log2_res, tolerance=tolerance / 100)
    _say_left_out(layers, made)
    made.save(output)


def _say_left_out(layers: list[Bsdf], made: Bsdf) -> None:
    missing = sorted({band for layer in layers for band in layer.bands} - set(made.bands))
    if missing:
        click.echo(f"left out, since not all layers have it: {', '.join(missing)}", err=True)
