"""``bsdftree convert``: from one file to another, in another format or of another kind of data."""

from __future__ import annotations

from typing import Any, Literal

import click

from bsdftree import Bsdf, Matrix, write_radiance_matrix
from bsdftree._component import COMPONENTS
from bsdftree._grid_file import is_grid as grid_by_name
from bsdftree.cli._common import BASES, PERCENT, read, read_grid_tree, repair_option, with_input_errors
from bsdftree.cli._energyplus_output import energyplus_options, is_energyplus, write_energyplus


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
@click.option("--klems", type=BASES, help="To matrices over this angle basis.")
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
    default=5,
    show_default=True,
    help="With --tree: at most 2^N cells per axis.",
)
@click.option(
    "--tolerance",
    type=PERCENT,
    default=0.0,
    show_default=True,
    metavar="PERCENT",
    help="With --tree: relative error that joining cells may add.",
)
@click.option("--flip", is_flag=True, help="Turn the device round about the vertical: front to the back.")
@click.option("--mirror", type=click.Choice(["x", "y"]), help="Mirror it: x swaps left and right, y up and down.")
@click.option(
    "--rotate", type=float, default=0.0, metavar="DEGREES", help="Turn it counter-clockwise about its normal."
)
@click.option(
    "--raw",
    type=click.Choice(["ascii", "float", "double"]),
    help="IN is what rttree_reduce reads: a grid of this --rank. So are .npy, .f32 and .f64, without this.",
)
@click.option(
    "--component",
    type=click.Choice(COMPONENTS),
    default="transmission_front",
    show_default=True,
    help="With --raw: what the values are. For .mtx: what to write. Front is the outside, as in WINDOW.",
)
@energyplus_options
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
    flip: bool,
    mirror: Literal["x", "y"] | None,
    rotate: float,
    raw: str | None,
    component: str,
    repair: bool,
    **construction: Any,
) -> None:
    """Write the BSDF in IN to OUT, in the format that the ending of OUT says.

    .bsdft is the binary twin of the XML: the same to the last bit, smaller, and open at once whatever its size.
    Packed, it is smaller still, and read as a whole. .mtx is a matrix for dctimestep and rmtxop, a row for each exitant
    patch: value times projected solid angle of the incident one. .idf and .epJSON are a window construction for
    EnergyPlus, to be merged with a model. Any other ending is WINDOW 6 XML.

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
      bsdftree convert klems.xml tree.xml --tree --rank 4 --log2-res 5 --tolerance 5
      bsdftree convert blinds.xml turned.xml --rotate 90
      bsdftree convert blinds.xml T.mtx --klems full
      bsdftree convert window.xml window.idf --name window
      bsdftree convert --raw float --rank 4 --component reflection_back grid.flt tree.xml
    """
    if klems and tree:
        raise click.UsageError("--klems and --tree; expected one of them")
    for_energyplus = is_energyplus(target, construction)
    is_grid = raw is not None or grid_by_name(source)
    bsdf = read_grid_tree(source, raw, rank, component, repair) if is_grid else read(source, repair)
    if flip:
        bsdf = bsdf.flipped()
    if mirror:
        bsdf = bsdf.mirrored(mirror)
    if rotate:
        turned = bsdf.rotated(rotate)
        # Of a turn and the turn back, half is the turn's.
        _say_errors(bsdf, turned.rotated(-rotate), "turned there and back")
        bsdf = turned
    made = bsdf
    if klems:
        made = bsdf.to_klems(klems, subdivide=subdivide)
    elif tree:
        made = bsdf.to_tree(rank, log2_res, tolerance=tolerance / 100)
    elif for_energyplus:
        # What it writes anyway: here the errors of that are said.
        made = bsdf.to_klems("full")
    if made is not bsdf:
        _say_errors(bsdf, made)
    if target.lower().endswith(".mtx"):
        _write_matrix(made, component, target)
    elif for_energyplus:
        write_energyplus(made, target, construction)
    else:
        made.save(target, packed=packed, level=level)


def _write_matrix(bsdf: Bsdf, component: str, target: str) -> None:
    found = bsdf.components.get(component)
    if not isinstance(found, Matrix):
        what = "a tree: add --klems full" if found else f"absent; there are {', '.join(bsdf.components)}"
        raise ValueError(f"{target}: {component} is {what}")
    write_radiance_matrix(target, found.weighted())


def _say_errors(bsdf: Bsdf, made: Bsdf, how: str = "") -> None:
    """Print how far what was made is from what was there; nothing of what is as it was."""
    changed = ((band, key, error) for band in bsdf.bands for key, error in bsdf.distance(made, band).items() if error)
    for band, key, error in changed:
        click.echo(f"{band} {key}: relative L1 error {100 * error:.1f} %{', ' + how if how else ''}", err=True)
