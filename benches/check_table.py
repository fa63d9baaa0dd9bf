"""The table of docs/check.md: `bsdftree check` on all BSDF files of a folder, in Markdown.

Run: python benches/check_table.py ../shared/data
"""

from __future__ import annotations

import sys
from pathlib import Path

import bsdftree
from bsdftree import BandCheck, Check


def rows(path: Path, folder: Path) -> list[str]:
    """A line for each band of a file, or one that says why it cannot be read."""
    name = f"`{path.relative_to(folder)}`"
    try:
        found = bsdftree.load(path).check()
    except ValueError as error:
        reason = str(error).removeprefix(f"{path}: ").split(";")[0]
        return [f"| {name} | | | | | | refused: {reason} |"]
    return [f"| {name} | {band.band} | {row(found, band)} |" for band in found.bands]


def row(found: Check, band: BandCheck) -> str:
    """What was measured in a band, and the kinds of what was found."""
    most = max((e.max for e in band.energy), default=0.0)
    reciprocity = [r.mean for r in band.reciprocity]
    noise = [n.level for n in band.noise if n.level is not None]
    symmetry = [max(getattr(s, axis) for s in band.symmetry) for axis in ("left_right", "top_bottom") if band.symmetry]
    told = [f"{f.severity}: {f.kind}, {about(f.message)}" for f in (*found.findings, *band.findings)]
    cells = [
        percent([most]),
        percent(reciprocity),
        percent(noise),
        " / ".join(percent([value]) for value in symmetry) or "isotropic",
        "<br>".join(told) or "nothing",
    ]
    return " | ".join(cells)


def percent(values: list[float]) -> str:
    """Smallest and largest, or one of equals."""
    if not values:
        return "–"
    ends = [f"{100 * value:.1f}" for value in (min(values), max(values))]
    return f"{'–'.join(dict.fromkeys(ends))} %"


def about(message: str) -> str:
    """The beginning of a message, as far as it says what it is about."""
    if message.startswith("a guess: "):
        return message
    return message.split(":")[0].split(";")[0].split(", by")[0].split(" (")[0]


def main() -> None:
    """Print the table."""
    folder = Path(sys.argv[1])
    print("| file | band | most light out | not reciprocal by | noise | mirrored left-right / top-bottom | told |")
    print("|---|---|---|---|---|---|---|")
    for path in sorted(p for p in folder.glob("*/*") if p.suffix.lower() == ".xml"):
        print("\n".join(rows(path, folder)))


if __name__ == "__main__":
    main()
