"""``bsdftree reduce``: smaller trees with an error that the user chooses."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from bsdftree import Bsdf, Tree
from bsdftree._component import COMPONENTS
from bsdftree._grid_file import is_grid, read_grid
from bsdftree._reduce import FileKind, Reduction, tree_of_grid
from bsdftree.cli._common import (
    PERCENT,
    grid_message,
    json_option,
    print_json,
    read,
    read_grid_tree,
    repair_option,
    say_repairs,
    stdout,
    table,
    with_input_errors,
)

_UNITS = {"": 1, "k": 1e3, "m": 1e6, "g": 1e9}


def _bytes(_context: click.Context, _parameter: click.Parameter, value: str | None) -> int | None:
    if value is None:
        return None
    match = re.fullmatch(r"([0-9.]+) *([kmg]?)b?", value.strip().lower())
    try:
        if match is None:
            raise ValueError
        return int(float(match[1]) * _UNITS[match[2]])
    except ValueError:
        raise click.BadParameter(f"{value!r}; expected a size such as 500k, 5MB or 2000000") from None


@click.command()
@click.argument("source", metavar="IN", type=click.Path())
@click.option("-o", "--output", "target", metavar="OUT", required=True, help="File to write: .xml or .bsdft.")
@click.option("--l1", type=PERCENT, metavar="PERCENT", help="Most of ∫|f − g| / ∫f. [default: 2]")
@click.option("--rms", type=PERCENT, metavar="PERCENT", help="Most of √∫(f − g)² / √∫f².")
@click.option(
    "--total",
    type=PERCENT,
    metavar="PERCENT",
    help="Most that any incident direction's hemispherical total may change, in percent of it or of 0.1. [default: 1]",
)
@click.option(
    "--balance",
    type=PERCENT,
    metavar="PERCENT",
    help="To what leaves of one node bring those changes by giving light to each other, as far as they can. Of a grid "
    "and with --leaves, branches are chosen for it too.",
)
@click.option("--leaves", type=click.IntRange(1), metavar="N", help="Most leaves of all components together.")
@click.option("--size", callback=_bytes, metavar="SIZE", help="Largest size of OUT, such as 5MB.")
@click.option(
    "--cull-percent",
    type=PERCENT,
    metavar="PERCENT",
    help="Radiance's percentage, for comparison: what its rttree_reduce does (pyradiance).",
)
@click.option("--packed", is_flag=True, help="Compress a .bsdft file.")
@click.option(
    "--raw",
    type=click.Choice(["ascii", "float", "double"]),
    help="IN is what rttree_reduce reads: all values of a grid. So are .npy, .f32 and .f64, without this.",
)
@click.option("--rank", type=click.IntRange(3, 4), default=4, show_default=True, help="Of a grid: 3 is isotropic.")
@click.option(
    "--component",
    type=click.Choice(COMPONENTS),
    default="transmission_front",
    show_default=True,
    help="What the values of a grid are. Front is the outside, as in WINDOW.",
)
@click.option(
    "--variance",
    metavar="FILE",
    help="Squares of the standard errors of a grid's values, in a file like it: noise is not kept as detail.",
)
@click.option("--counts", metavar="FILE", help="Numbers of samples that made them, instead.")
@repair_option
@json_option
@with_input_errors
def reduce(
    source: str,
    target: str,
    l1: float | None,
    rms: float | None,
    total: float | None,
    balance: float | None,
    leaves: int | None,
    size: int | None,
    cull_percent: float | None,
    packed: bool,
    raw: str | None,
    rank: int,
    component: str,
    variance: str | None,
    counts: str | None,
    repair: bool,
    as_json: bool,
) -> None:
    """Make the trees of IN smaller, by as much as the error that you choose allows.

    Branches become leaves of their mean, so that no light is gained or lost over any of them. Bounds hold for each
    component of each band, together. Without any, L1 is kept to 2 % and each direction's total to 1 %.

    IN is a BSDF, or a grid of 2^N cells along each axis, the last one fastest: a file of NumPy's (.npy) or of bare
    numbers. It is not loaded: of a grid larger than memory only the result must fit, and an eighth of the grid.

    \b
    Examples:
      bsdftree reduce blinds.xml -o small.xml
      bsdftree reduce blinds.xml -o small.xml --l1 5 --total 0.5
      bsdftree reduce blinds.xml -o small.xml --size 1MB
      bsdftree reduce blinds.xml -o small.bsdft --leaves 20000 --packed
      bsdftree reduce grid.npy -o tree.xml --component reflection_back --l1 1
      bsdftree reduce measured.npy -o tree.xml --counts samples.npy
      bsdftree reduce blinds.xml -o culled.xml --cull-percent 90
    """
    noise = {"variance": variance, "counts": counts}
    if (variance or counts) and (size or cull_percent is not None or not (raw or is_grid(source))):
        raise click.UsageError("--variance and --counts are of a grid, without --size or --cull-percent")
    ways = (leaves, size, cull_percent, l1 if l1 is not None else rms)
    if sum(way is not None for way in ways) > 1 or (
        cull_percent is not None and (total is not None or balance is not None)
    ):
        raise click.UsageError(
            "--leaves, --size, --cull-percent, and --l1 or --rms exclude each other; give one of them"
        )
    if all(way is None for way in (*ways, total)) and not (variance or counts):
        l1, total = 2.0, 1.0
    bounds = {"l1": l1, "rms": rms, "total": total, "balance": balance}
    shares: dict[str, Any] = {name: bound / 100 for name, bound in bounds.items() if bound is not None}
    done = [f"{name} {bound:g} %" for name, bound in bounds.items() if bound is not None]
    sizes = {"leaves": leaves, "bytes": size}
    done += [f"{n} {what}" for what, n in sizes.items() if n is not None]
    done += ["what differs by more than noise"] if variance or counts else []
    said = (
        f"culled by {cull_percent:g} % by rttree_reduce"
        if cull_percent is not None
        else f"reduced to {', '.join(done)}"
    )
    file: FileKind = "xml" if not target.lower().endswith(".bsdft") else "packed" if packed else "bsdft"
    if (raw or is_grid(source)) and size is None:
        reduced, rows = _reduced_grid(source, raw, rank, component, repair, leaves, cull_percent, shares, noise)
        named = reduced.with_header(provenance=[f"{said} by bsdftree"])
    else:
        bsdf = read_grid_tree(source, raw, rank, component, repair) if raw or is_grid(source) else read(source, repair)
        # First, since it is a part of the size.
        named = bsdf.with_header(provenance=[*bsdf.provenance, f"{said} by bsdftree"])
        named = named.reduce(**shares, n_leaves=leaves, n_bytes=size, file=file, cull_percent=cull_percent)
        rows = bsdf.losses_of(named)
    named.save(target, packed=packed)
    _report(rows, source, target, as_json)


def _reduced_grid(
    source: str,
    raw: str | None,
    rank: int,
    component: str,
    repair: bool,
    leaves: int | None,
    cull_percent: float | None,
    bounds: dict[str, Any],
    noise: dict[str, str | None],
) -> tuple[Bsdf, list[Reduction]]:
    """Reduce a grid, without the whole tree in memory."""
    values = read_grid(source, rank, raw)
    numbers: dict[str, Any] = {name: read_grid(path, rank, raw) for name, path in noise.items() if path}
    try:
        tree, loss, repairs = tree_of_grid(
            values, strict=not repair, n_leaves=leaves, cull_percent=cull_percent, **bounds, **numbers
        )
    except ValueError as error:
        raise ValueError(grid_message(source, error)) from None
    say_repairs(source, repairs)
    bsdf = Bsdf.from_trees({component: Tree(tree)})
    (band,) = bsdf.bands
    return bsdf, [Reduction(band, component, values.size, tree.n_leaves, loss)]


def _report(rows: list[Reduction], source: str, target: str, as_json: bool) -> None:
    """Say what was lost."""
    sizes = [Path(path).stat().st_size for path in (source, target)]
    if as_json:
        parts = [
            {"band": r.band, "component": r.component, "leaves": [r.before, r.after], **r.loss._asdict()} for r in rows
        ]
        print_json({"bytes": sizes, "components": parts})
        return
    shown = table(
        "band", "component", ">leaves before", ">after", ">L1 %", ">RMS %", ">totals %, mean", ">worst", ">at θ", ">φ"
    )
    for r in rows:
        errors = [f"{100 * e:.2f}" for e in (r.loss.l1, r.loss.rms, r.loss.mean_total, r.loss.worst_total)]
        phi = "any" if r.loss.worst_phi_deg != r.loss.worst_phi_deg else f"{r.loss.worst_phi_deg:.0f}°"
        where = (f"{r.loss.worst_theta_deg:.0f}°", phi) if r.loss.worst_total else ("", "")
        shown.add_row(r.band, r.component, f"{r.before:,}", f"{r.after:,}", *errors, *where)
    stdout.print(shown)
    stdout.print(f"{source}: {sizes[0]:,} bytes; {target}: {sizes[1]:,} bytes")
