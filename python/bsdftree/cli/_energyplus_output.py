"""What ``convert`` writes for EnergyPlus, and the options that say what a BSDF does not."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeVar

import click

from bsdftree import Bsdf, energyplus, save_energyplus
from bsdftree.cli._common import tell

F = TypeVar("F", bound=Callable[..., Any])
ENDINGS = (".idf", ".epjson")
OPTIONS = {
    "--name": (str, "name of the construction; that of the BSDF"),
    "--thickness": (float, "of the layer [m]; the file's, else 0.003"),
    "--conductivity": (float, "[W/(m K)]; the file's, else 0.9"),
    "--emissivity-front": (float, "of the outside, infrared; the file's, else 0.84"),
    "--emissivity-back": (float, "of the room side; the file's, else 0.84"),
    "--infrared-transmittance": (float, "the file's, else 0"),
}


def energyplus_options(function: F) -> F:
    """Decorate a verb with the options of :func:`bsdftree.energyplus`."""
    for option, (type_, what) in reversed(OPTIONS.items()):
        function = click.option(option, type=type_, help=f"For .idf and .epJSON: {what}.")(function)
    return click.option(
        "--solar-from-visible", is_flag=True, help="For .idf and .epJSON: take Visible where there is no Solar."
    )(function)


def is_energyplus(target: str, options: dict[str, Any]) -> bool:
    """Whether the ending is EnergyPlus's; if it is not, none of its options may be there."""
    if target.lower().endswith(ENDINGS):
        return True
    given = [key for key, value in options.items() if value]
    if given:
        raise click.UsageError(f"--{given[0].replace('_', '-')} is for .idf and .epJSON; OUT is {target}")
    return False


def write_energyplus(layers: Bsdf | list[Bsdf], target: str, options: dict[str, Any]) -> None:
    """Write the construction, and say on standard error what is doubtful in it."""
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always")
        try:
            objects = energyplus(layers, **options)
        except ValueError as error:
            raise ValueError(f"{target}: {error}") from None
    tell(dict.fromkeys(str(doubt.message) for doubt in doubts))
    save_energyplus(target, objects)
