"""``bsdftree plot``: see a BSDF, or two."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bsdftree import Bsdf, direction_from_polar
from bsdftree.cli._common import BASES, read, repair_option, with_input_errors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PARTS = ["reflection_back", "transmission_back", "reflection_front", "transmission_front"]
_KINDS = ["overview", "polar", "lobes", "slice", "mosaic", "hemispherical", "compare", "klems", "stats"]
# Which kinds of picture an option is for.
_ONLY_FOR = {
    "part": ("mosaic", "hemispherical", "klems", "stats"),
    "incident": ("polar", "lobes", "slice", "compare"),
    "range": ("polar", "lobes", "mosaic", "compare", "klems"),
    "linear": ("lobes", "slice"),
    "basis": ("klems",),
    "color": ("polar",),
}


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE [FILE]", type=click.Path())
@click.option(
    "-o", "--output", metavar="OUT", help="Picture to write: .png, .svg or .pdf. [default: FILE's name with .png, here]"
)
@click.option(
    "--kind",
    type=click.Choice(_KINDS),
    help="Which picture; see above. [default: overview, of two files compare]",
)
@click.option("--part", type=click.Choice(_PARTS), help="One component; all by default.")
@click.option(
    "--incident",
    type=(float, float),
    multiple=True,
    metavar="THETA PHI",
    help="Where light comes from [degree], once or more: θ from +Z, over 90 is from outside; φ counter-clockwise from "
    "+X, 90 is from above.",
)
@click.option("--band", help="Spectral band. [default: Visible, or the only one]")
@click.option("--basis", type=BASES, help="Patches of klems. [default: those of the file, for trees full]")
@click.option("--range", "limits", type=(float, float), metavar="MIN MAX", help="Colour scale [1/sr].")
@click.option("--linear", is_flag=True, help="Linear instead of logarithmic radius of slice and lobes.")
@click.option("--color", is_flag=True, help="Hues of the light in polar, luminance as lightness.")
@click.option("--smooth", is_flag=True, help="Ramps in the leaves of trees instead of steps.")
@click.option("--title", help="Heading. [default: the product's name, or FILE's]")
@click.option("--dpi", type=click.IntRange(20, 1200), default=100, show_default=True, help="Pixels per inch.")
@click.option("--show", is_flag=True, help="Open the picture in the system's viewer.")
@repair_option
@with_input_errors
def plot(
    files: tuple[str, ...],
    output: str | None,
    kind: str | None,
    part: str | None,
    incident: tuple[tuple[float, float], ...],
    band: str | None,
    basis: str | None,
    limits: tuple[float, float] | None,
    linear: bool,
    color: bool,
    smooth: bool,
    title: str | None,
    dpi: int,
    show: bool,
    repair: bool,
) -> None:
    """Draw the BSDF of FILE, or compare two. Needs matplotlib: pip install 'bsdftree[plot]'.

    \b
    Kinds of picture:
      overview       mosaic, slice and hemispherical in one
      polar          polar maps: where light from some directions goes
      lobes          the same as solids, in perspective
      slice          curves in the plane of incidence, room above, outside below
      mosaic         every incident and exitant direction in one image: a tile for
                     each incident direction, in it all exitant directions
      hemispherical  reflectance and transmittance by incident angle
      compare        two files: polar maps, difference, ratio, a table of errors
      klems          the matrix of Klems patches; trees become one
      stats          leaves by depth (patches by ring), shares of light, values

    Colours and radii are BSDF values [1/sr] without cosine, on a logarithmic scale.
    All is seen from the room, right is +X, up is +Y.

    \b
    Examples:
      bsdftree plot blinds.xml                                  writes blinds.png
      bsdftree plot blinds.xml --kind mosaic --part transmission_front -o sun.png
      bsdftree plot blinds.xml --kind polar --incident 135 90          sun at 45°
      bsdftree plot blinds.xml --kind slice --incident 150 90 --incident 120 90 -o slices.svg
      bsdftree plot blinds.xml small.xml -o errors.pdf
    """
    kind = kind or ("compare" if len(files) == 2 else "overview")
    given = {"part": part, "basis": basis, "range": limits, "incident": incident, "linear": linear, "color": color}
    for name, value in given.items():
        if value and kind not in _ONLY_FOR[name]:
            raise click.UsageError(f"--{name} is for --kind {', '.join(_ONLY_FOR[name])}, not {kind}")
    if any(not 0.0 <= theta <= 180.0 for theta, _ in incident):
        raise click.UsageError("--incident THETA PHI: expected θ from 0 to 180 degrees")
    if len(files) != (2 if kind == "compare" else 1):
        n = {2: "two files"}.get(2 if kind == "compare" else 1, "one file")
        raise click.UsageError(f"--kind {kind} takes {n}, not {len(files)}")
    target = Path(output) if output else Path(Path(files[0]).name).with_suffix(".png")
    if target.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise click.UsageError(f"-o {target}: ending {target.suffix!r}; expected .png, .svg or .pdf")
    try:
        from bsdftree import plot as pictures
    except ModuleNotFoundError as error:
        raise click.ClickException(str(error)) from None

    bsdfs = [read(file, repair) for file in files]
    bsdfs = [bsdf.smooth() for bsdf in bsdfs] if smooth else bsdfs
    options: dict[str, Any] = {"band": band, "title": title}
    options |= {key: given[key] for key in ("part", "basis", "color") if kind in _ONLY_FOR[key]}
    if kind in _ONLY_FOR["range"]:
        options["limits"] = limits
    if linear:
        options["radius"] = "linear"
    if kind == "compare":
        options["names"] = tuple(Path(file).name for file in files)
    else:
        options["title"] = title or bsdfs[0].name or Path(files[0]).stem
    pictures.save(_drawn(kind, bsdfs, incident, options), target, dpi=dpi)
    click.echo(f"wrote {target}", err=True)
    if show and click.launch(str(target)) != 0:
        raise click.ClickException(f"no viewer opened {target}; open it by hand")


def _drawn(kind: str, bsdfs: list[Bsdf], incident: tuple[tuple[float, float], ...], options: dict[str, Any]) -> Figure:
    from bsdftree import plot as pictures

    if incident and kind == "slice":
        theta, phi = zip(*incident, strict=True)
        options |= {"theta_deg": theta, "phi_deg": phi}
    elif incident:
        vectors = [direction_from_polar(*angles) for angles in incident]
        options["incident"] = vectors[0] if len(vectors) == 1 else vectors
    figure: Figure = getattr(pictures, kind)(*bsdfs, **options)
    return figure
