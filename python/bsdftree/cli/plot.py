"""``bsdftree plot``: see the whole BSDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bsdftree import direction_from_polar
from bsdftree.cli._common import read, repair_option, with_input_errors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PARTS = ["reflection_back", "transmission_back", "reflection_front", "transmission_front"]
# Which kinds of picture an option is for.
_ONLY_FOR = {
    "part": ("whole",),
    "layout": ("whole",),
    "limits": ("whole", "hemisphere"),
    "incident": ("polar", "hemisphere"),
    "linear": ("polar",),
}


@click.command()
@click.argument("file", type=click.Path())
@click.option(
    "-o", "--output", metavar="OUT", help="Picture to write: .png, .svg or .pdf. [default: FILE's name with .png, here]"
)
@click.option(
    "--kind",
    type=click.Choice(["overview", "whole", "polar", "hemisphere"]),
    default="overview",
    show_default=True,
    help="Which picture; see above.",
)
@click.option("--part", type=click.Choice(_PARTS), help="One component for whole; all by default.")
@click.option(
    "--incident",
    type=(float, float),
    multiple=True,
    metavar="THETA PHI",
    help="Where light comes from [degree], for hemisphere (one) and polar (any number): θ from +Z, over 90 is "
    "from outside; φ counter-clockwise from +X, 90 is from above.",
)
@click.option("--band", help="Spectral band. [default: Visible, or the only one]")
@click.option("--layout", type=click.Choice(["matrix", "mosaic"]), help="Klems matrices in whole. [default: matrix]")
@click.option(
    "--range", "limits", type=(float, float), metavar="MIN MAX", help="Colour scale [1/sr] of whole and hemisphere."
)
@click.option("--linear", is_flag=True, help="Linear instead of logarithmic radius of polar.")
@click.option("--smooth", is_flag=True, help="Ramps in the leaves of trees instead of steps.")
@click.option("--title", help="Heading. [default: the product's name, or FILE's]")
@click.option("--dpi", type=click.IntRange(20, 1200), default=100, show_default=True, help="Pixels per inch.")
@click.option("--show", is_flag=True, help="Open the picture in the system's viewer.")
@repair_option
@with_input_errors
def plot(
    file: str,
    output: str | None,
    kind: str,
    part: str | None,
    incident: tuple[tuple[float, float], ...],
    band: str | None,
    layout: str | None,
    limits: tuple[float, float] | None,
    linear: bool,
    smooth: bool,
    title: str | None,
    dpi: int,
    show: bool,
    repair: bool,
) -> None:
    """Draw the BSDF of FILE. Needs matplotlib: pip install 'bsdftree[plot]'.

    \b
    Kinds of picture:
      overview    all of the following but hemisphere, 1600 pixels wide
      whole       every incident and exitant direction in one image: a tile for
                  each incident direction, in it all exitant directions
      polar       slices through the plane of incidence, room above, outside below
      hemisphere  where light from one direction goes: one disk for each side

    Colours and radii are BSDF values [1/sr] without cosine, on a logarithmic scale.
    All is seen from the room, right is +X, up is +Y.

    \b
    Examples:
      bsdftree plot blinds.xml                                  writes blinds.png
      bsdftree plot blinds.xml --kind whole --part transmission_front -o sun.png
      bsdftree plot blinds.xml --kind hemisphere --incident 135 90     sun at 45°
      bsdftree plot blinds.xml --kind polar --incident 150 90 --incident 120 90 -o slices.svg
    """
    given = {"part": part, "layout": layout, "limits": limits, "incident": incident, "linear": linear}
    for name, value in given.items():
        if value and kind not in _ONLY_FOR[name]:
            option = "range" if name == "limits" else name
            raise click.UsageError(f"--{option} is for --kind {' and '.join(_ONLY_FOR[name])}, not {kind}")
    if kind == "hemisphere" and len(incident) != 1:
        raise click.UsageError("--kind hemisphere needs one --incident THETA PHI, e.g. 135 90 for sun at 45°")
    try:
        from bsdftree import plot as pictures
    except ModuleNotFoundError as error:
        raise click.ClickException(str(error)) from None

    target = Path(output) if output else Path(Path(file).name).with_suffix(".png")
    if target.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise click.UsageError(f"-o {target}: ending {target.suffix!r}; expected .png, .svg or .pdf")
    bsdf = read(file, repair)
    bsdf = bsdf.smooth() if smooth else bsdf
    common: dict[str, Any] = {"band": band, "title": title or bsdf.name or Path(file).stem}
    figure: Figure
    if kind == "whole":
        figure = pictures.whole(bsdf, part=part, layout=layout, limits=limits, **common)  # type: ignore[arg-type]
    elif kind == "polar":
        figure = pictures.polar(bsdf, **_angles(incident), radius="linear" if linear else "log", **common)
    elif kind == "hemisphere":
        figure = pictures.hemisphere(bsdf, direction_from_polar(*incident[0]), limits=limits, **common)
    else:
        figure = pictures.overview(bsdf, **common)
    pictures.save(figure, target, dpi=dpi)
    click.echo(f"wrote {target}", err=True)
    if show and click.launch(str(target)) != 0:
        raise click.ClickException(f"no viewer opened {target}; open it by hand")


def _angles(incident: tuple[tuple[float, float], ...]) -> dict[str, Any]:
    if not incident:
        return {}
    return {"theta_deg": [theta for theta, _ in incident], "phi_deg": [phi for _, phi in incident]}
