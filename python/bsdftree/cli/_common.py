"""What the verbs share: reading a file, tables, errors."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import click
from rich.console import Console
from rich.table import Table

from bsdftree import Bsdf, Measurement, Tree, load
from bsdftree._grid_file import read_grid

P = ParamSpec("P")
R = TypeVar("R")

# Tables keep their columns on a narrow terminal and in a pipe: lines may wrap, but nothing is cut off.
stdout = Console(soft_wrap=True, width=max(Console().width, 120))
stderr = Console(stderr=True, soft_wrap=True)


@contextmanager
def input_errors() -> Iterator[None]:
    """Turn what is wrong with the input into a message and exit code 1."""
    try:
        yield
    except (ValueError, OSError) as error:
        click.echo(printable(f"bsdftree: {error}"), err=True)
        sys.exit(1)


def printable(text: str) -> str:
    """Return a text that cannot command a terminal, whatever is in the files that it quotes."""
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)


def with_input_errors(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a verb with :func:`input_errors`."""

    @wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> R:
        with input_errors():
            return function(*args, **kwargs)

    return wrapped


def read(path: str, repair: bool) -> Bsdf:
    """Read a BSDF and verify it; say on standard error what was repaired."""
    bsdf = load(path, strict=not repair)
    try:
        bsdf.verify()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    say_repairs(path, bsdf.repairs)
    return bsdf


def read_grid_tree(path: str, numbers: str | None, rank: int, component: str, repair: bool) -> Bsdf:
    """Read a grid as a BSDF of one component; say on standard error what was repaired."""
    try:
        tree = Tree.from_grid(read_grid(path, rank, numbers), strict=not repair)
    except ValueError as error:
        raise ValueError(grid_message(path, error)) from None
    say_repairs(path, tree.repairs)
    return Bsdf.from_trees({component: tree})


def grid_message(path: str, error: ValueError) -> str:
    """Return what is wrong with a grid, in the words of the command line."""
    text = str(error).replace("strict=False takes", "--repair takes")
    return text if text.startswith(path) else f"{path}: {text}"


def say_repairs(path: str, repairs: Iterable[str]) -> None:
    """Say on standard error what was repaired."""
    for repaired in repairs:
        click.echo(printable(f"{path}: {repaired}"), err=True)


def tell(warnings: Iterable[str]) -> None:
    """Say on standard error what is doubtful."""
    for warning in warnings:
        click.echo(printable(f"bsdftree: warning: {warning}"), err=True)


def print_json(data: Any) -> None:
    """Data for programs."""
    click.echo(json.dumps(data, indent=2))


def table(*columns: str, title: str | None = None) -> Table:
    """Make a table; columns whose name begins with > are right-aligned."""
    result = Table(title=title, title_justify="left", title_style="bold", header_style="bold", box=None, pad_edge=False)
    for column in columns:
        result.add_column(column.lstrip(">"), justify="right" if column.startswith(">") else "left", no_wrap=True)
    return result


BASES = click.Choice(["full", "half", "half73", "quarter"])
PERCENT = click.FloatRange(0, 100, max_open=True)
repair_option = click.option(
    "--repair", is_flag=True, help="Mend what can be mended in a faulty file, and say what was mended."
)
columns_option = click.option(
    "--columns",
    metavar="LIST",
    help="Of tables (CSV): theta_i=NAME,phi_i=2,theta_o=…,phi_o=…,value=…[,error=…], columns by name or number from 1.",
)
format_option = click.option(
    "--format", "format_", type=click.Choice(Measurement.FORMATS), help="If the content of the files does not tell."
)
side_option = click.option(
    "--side",
    type=click.Choice(["front", "back"]),
    default="front",
    show_default=True,
    help="Side of the device that was the sample's front; front is the room.",
)


def _grazing(ctx: click.Context, param: click.Parameter, value: str | None) -> float | str | None:
    if value is None or value == "auto":
        return value
    try:
        angle = float(value)
    except ValueError:
        angle = -1.0
    if not 0 <= angle < 90:
        raise click.BadParameter(f"{value!r}; expected 0 to less than 90 [degree], or auto")
    return angle


grazing_option = click.option(
    "--grazing",
    callback=_grazing,
    metavar="DEGREES|auto",
    help="Leave out points nearer to the surface than this; auto: than the lowest incident direction.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for programs instead of tables.")
