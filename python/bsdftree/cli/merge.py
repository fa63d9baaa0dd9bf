"""``bsdftree merge``: one file of the components and bands of several."""

from __future__ import annotations

import warnings

import click

import bsdftree
from bsdftree import Bsdf
from bsdftree._component import COMPONENTS
from bsdftree.cli._common import read, repair_option, with_input_errors

_GROUPS = {
    "reflection": [key for key in COMPONENTS if key.startswith("reflection")],
    "transmission": [key for key in COMPONENTS if key.startswith("transmission")],
    "front": [key for key in COMPONENTS if key.endswith("front")],
    "back": [key for key in COMPONENTS if key.endswith("back")],
} | {key: [key] for key in COMPONENTS}


@click.command()
@click.argument("files", nargs=-1, required=True)
@click.option("-o", "--output", required=True, type=click.Path(), help="File to write.")
@repair_option
@with_input_errors
def merge(files: tuple[str, ...], output: str, repair: bool) -> None:
    """Join the components and bands of several FILES of one device.

    FILE[:WHAT,...][@BAND] takes some of a file: reflection, transmission, front, back or one component, such as
    transmission_front (front is the outside, as in WINDOW); @BAND calls its band Visible, or its only one, BAND.

    \b
    Examples:
      bsdftree merge front.xml back.xml -o both.xml
      bsdftree merge measured.xml:reflection traced.xml:transmission -o out.xml
      bsdftree merge visible.xml solar.xml@Solar -o out.xml
    """
    parts = [_part(word, repair) for word in files]
    with warnings.catch_warnings(record=True) as remarks:
        warnings.simplefilter("always")
        made = bsdftree.merge(parts)
    for remark in remarks:
        click.echo(f"warning: {remark.message}", err=True)
    made.save(output)


def _part(word: str, repair: bool) -> Bsdf:
    """Read one word of the command line."""
    path, band = word, None
    if "@" in word.rpartition("/")[2]:
        path, _, band = word.rpartition("@")
    components: list[str] | None = None
    start, _, what = path.rpartition(":")
    if start and "/" not in what:
        unknown = [name for name in what.split(",") if name not in _GROUPS]
        if unknown:
            raise ValueError(f"{word}: {unknown[0]!r}; expected one of {', '.join(_GROUPS)}")
        path, components = start, [key for name in what.split(",") for key in _GROUPS[name]]
    bsdf = read(path, repair)
    if band is None:
        return bsdf.select(components)
    old = "Visible" if "Visible" in bsdf.bands or len(bsdf.bands) != 1 else bsdf.bands[0]
    return bsdf.select(components, bands=[old], rename=(old, band))
