"""``bsdftree reduce``: smaller trees with an error that the user chooses."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from bsdftree import Bsdf
from bsdftree.cli._common import PERCENT, json_option, print_json, read, repair_option, stdout, table, with_input_errors

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
@click.option("--leaves", type=click.IntRange(1), metavar="N", help="Most leaves of all components together.")
@click.option("--size", callback=_bytes, metavar="SIZE", help="Largest size as XML, such as 5MB.")
@click.option("--packed", is_flag=True, help="Compress a .bsdft file.")
@repair_option
@json_option
@with_input_errors
def reduce(
    source: str,
    target: str,
    l1: float | None,
    rms: float | None,
    total: float | None,
    leaves: int | None,
    size: int | None,
    packed: bool,
    repair: bool,
    as_json: bool,
) -> None:
    """Make the trees of IN smaller, by as much as the error that you choose allows.

    Branches become leaves of their mean, so that no light is gained or lost over any of them. Bounds hold for each
    component of each band, together. Without any, L1 is kept to 2 % and each direction's total to 1 %.

    \b
    Examples:
      bsdftree reduce blinds.xml -o small.xml
      bsdftree reduce blinds.xml -o small.xml --l1 5 --total 0.5
      bsdftree reduce blinds.xml -o small.xml --size 1MB
      bsdftree reduce blinds.xml -o small.bsdft --leaves 20000 --packed
    """
    if sum(option is not None for option in (leaves, size, l1 if l1 is not None else rms)) > 1:
        raise click.UsageError("--leaves, --size, and --l1 or --rms exclude each other; give one of them")
    bsdf = read(source, repair)
    if all(option is None for option in (l1, rms, total, leaves, size)):
        l1, total = 2.0, 1.0
    bounds = {"l1": l1, "rms": rms, "total": total}
    shares: dict[str, Any] = {name: bound / 100 for name, bound in bounds.items() if bound is not None}
    done = ", ".join([f"{name} {bound:g} %" for name, bound in bounds.items() if bound is not None])
    reached = done or (f"{leaves} leaves" if leaves else f"{size} bytes")
    # First, since it is a part of the size.
    named = bsdf.with_header(provenance=[*bsdf.provenance, f"reduced to {reached} by bsdftree"])
    reduced = named.reduce(**shares, n_leaves=leaves, n_bytes=size)
    reduced.save(target, packed=packed)
    _report(bsdf, reduced, source, target, as_json)


def _report(bsdf: Bsdf, reduced: Bsdf, source: str, target: str, as_json: bool) -> None:
    """Say what was lost."""
    sizes = [Path(path).stat().st_size for path in (source, target)]
    rows = bsdf.losses_of(reduced)
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
