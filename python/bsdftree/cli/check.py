"""``bsdftree check``: does a file obey physics and say what was meant; a repaired copy of it."""

from __future__ import annotations

import os
import re
import shutil
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click

from bsdftree import Bsdf, Check, Finding, Mended, __version__, _core, load
from bsdftree._check import KINDS
from bsdftree._placement import Position, placed, placement_finding
from bsdftree._whole_file import whole_file
from bsdftree.cli._check_tables import show
from bsdftree.cli._common import json_option, print_json, printable, stdout, with_input_errors

MENDABLE = KINDS[:-1]


def _kinds(_context: click.Context, _option: click.Parameter, value: str | None) -> tuple[str, ...]:
    if value is None:
        return MENDABLE
    kinds = tuple(word.strip() for word in value.split(","))
    unknown = [kind for kind in kinds if kind not in MENDABLE]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r}; expected some of {', '.join(MENDABLE)}")
    return kinds


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option(
    "--energy",
    default=1.0,
    show_default=True,
    metavar="PERCENT",
    help="Tolerated excess of scattered light over 100 %.",
)
@click.option(
    "--reciprocity",
    default=25.0,
    show_default=True,
    metavar="PERCENT",
    help="Tolerated mean difference |a-b|/(a+b) between pairs of directions and the same pairs swapped, by flux.",
)
@click.option(
    "--noise",
    default=25.0,
    show_default=True,
    metavar="PERCENT",
    help="Tolerated relative standard deviation of a value.",
)
@click.option(
    "--device",
    metavar="FILE",
    type=click.Path(),
    help="Tell which way up and round the data is by this geometry, traced coarsely; a BSDF file may hold its own.",
)
@click.option("--fix", metavar="OUT", type=click.Path(), help="Write a repaired copy of the one file to OUT.")
@click.option(
    "--only",
    "kinds",
    metavar="KIND,...",
    callback=_kinds,
    help=f"With --fix: repair findings of these kinds only: {', '.join(MENDABLE)}.",
)
@json_option
@with_input_errors
def check(
    files: tuple[str, ...],
    energy: float,
    reciprocity: float,
    noise: float,
    device: str | None,
    fix: str | None,
    kinds: tuple[str, ...],
    as_json: bool,
) -> None:
    """Check BSDF files: energy, reciprocity, missing and swapped sides, orientation, units, noise and colour.

    A violation breaks a law of physics or of the format, a warning is what may not be meant, a note is a guess. What
    each finding is told by is in docs/check.md. Exits with 1 if a file has a violation, or cannot be read.

    With --fix, what can be repaired is repaired in a copy, each repair is listed with a number before and after, and in
    the copy's provenance; a file without such findings is copied as it is. Exits with 1 if the copy has a violation.

    \b
    Examples:
      bsdftree check blinds.xml
      bsdftree check --reciprocity 10 --json *.xml
      bsdftree check blinds30.xml --device blinds30.xml
      bsdftree check window.xml --fix mended.xml
      bsdftree check window.xml --fix mended.xml --only energy,units
    """
    limits = {"energy": energy / 100, "reciprocity": reciprocity / 100, "noise": noise / 100}
    if fix and len(files) != 1:
        raise click.UsageError(f"--fix writes a copy of one file; found {len(files)}")
    if not fix and kinds != MENDABLE:
        raise click.UsageError("--only chooses what --fix repairs; add --fix OUT")
    results = []
    for path in files:
        bsdf, faults = _read(path)
        found = _with_faults(bsdf.check(**limits), bsdf, faults)
        position = Position()
        if device:
            positions = placed(bsdf, device)
            finding = placement_finding(positions, device)
            found = replace(found, findings=(*found.findings, finding))
            if finding.repair and "orientation" in kinds:
                position = positions[0][1]
        result = {"file": path, "ok": found.ok, **_as_json(found)}
        if not as_json:
            show(path, found)
        if fix:
            result["repaired"] = _repaired(path, bsdf, faults, position, fix, kinds, limits, as_json)
        results.append(result)
    if as_json:
        print_json(results if len(results) > 1 else results[0])
    if not all(result.get("repaired", result)["ok"] for result in results):
        sys.exit(1)


def _read(path: str) -> tuple[Bsdf, list[str]]:
    """Read a BSDF, strictly if possible, and tell what had to be mended otherwise."""
    try:
        bsdf, faults = load(path), []
    except ValueError:
        # What can be mended no more than strictly says so again.
        bsdf, faults = load(path, strict=False), _core.faults(os.fspath(path))
    try:
        bsdf.verify()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return bsdf, faults


def _with_faults(found: Check, bsdf: Bsdf, faults: list[str]) -> Check:
    """Findings of the reader before those of the header, and what the file's maker says of its error after them."""
    advice = "write it as the format has it"
    read = (Finding("values", "violation", None, None, None, 1.0, fault, advice, True) for fault in faults)
    stated = re.search(r"estimated error ([\d.]+) % of the whole", " ".join(bsdf.provenance))
    said = []
    if stated:
        error = float(stated[1]) / 100
        message = f"its maker estimates an error of {stated[1]} % of the whole (relative L1)"
        said = [Finding("noise", "note", None, None, None, error, message, "", False)]
    return replace(found, findings=(*read, *found.findings, *said))


def _as_json(found: Check) -> dict[str, Any]:
    return {"findings": [asdict(f) for f in found.findings], "bands": [asdict(band) for band in found.bands]}


def _repaired(
    path: str,
    bsdf: Bsdf,
    faults: list[str],
    position: Position,
    out: str,
    kinds: tuple[str, ...],
    limits: dict[str, float],
    as_json: bool,
) -> dict[str, Any]:
    """Write the repaired copy, and say what was done."""
    if faults and "values" not in kinds:
        raise ValueError(f"{path}: {faults[0]}; it cannot be written as it is: add values to --only")
    done = [Mended("values", None, None, fault, "faults of the format", 1.0, 0.0) for fault in faults]
    if position != Position():
        bsdf = position.undone(bsdf)
        done.append(
            Mended("orientation", None, None, f"the device was {position}: put back", "positions off", 1.0, 0.0)
        )
    lines = [f"Repaired by: bsdftree {__version__} ({m.what})" for m in done]
    copy, mended = bsdf.with_header(provenance=[*bsdf.provenance, *lines]).repaired(kinds, **limits)
    mended = [*done, *mended]
    if mended or Path(path).suffix.lower() != Path(out).suffix.lower():
        copy.save(out)
    else:
        _copy(path, out)
    ok = copy.check(**limits).ok
    if not as_json:
        for m in mended:
            band = f"{m.band}: " if m.band else ""
            numbers = f"{m.measure} {m.before:.4g} → {m.after:.4g}"
            stdout.print(f"[green]repaired[/green] {m.kind}: {printable(band + m.what)}: {numbers}", highlight=False)
        what = (
            f"{len(mended)} repair{'s' if len(mended) > 1 else ''}" if mended else "nothing to repair: copied as it is"
        )
        stdout.print(f"{printable(out)}: {what}; {'ok' if ok else 'still in violation'}", highlight=False)
    return {"file": out, "ok": ok, "mended": [asdict(m) for m in mended]}


def _copy(path: str, out: str) -> None:
    """Copy bit by bit, whole or not at all."""
    with whole_file(out) as temporary:
        shutil.copy(path, temporary)
