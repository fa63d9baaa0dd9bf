"""What a check found, as tables."""

from __future__ import annotations

from bsdftree import BandCheck, Check, Finding, polar_from_direction
from bsdftree.cli._common import printable, stdout, table

COLORS = {"violation": "red", "warning": "yellow", "note": "cyan"}


def show(path: str, found: Check) -> None:
    """Print everything."""
    if found.findings:
        stdout.print(f"[bold]{printable(path)}[/bold]", highlight=False)
    for finding in found.findings:
        _show_finding(finding)
    for band in found.bands:
        stdout.print(f"[bold]{printable(path)}[/bold]  {printable(band.band)}", highlight=False)
        _show_energy(band)
        if band.reciprocity:
            _show_reciprocity(band)
        _show_components(band)
        for finding in band.findings:
            _show_finding(finding)
        if band.ok:
            stdout.print("[green]ok[/green]")
        stdout.print()


def _percent(value: float | None, digits: int = 1) -> str:
    return "" if value is None else f"{100 * value:.{digits}f} %"


def _polar(direction: tuple[float, float, float]) -> str:
    theta, phi = polar_from_direction([*direction[:2], abs(direction[2])])
    return f"{theta:.1f}°, {phi:.1f}°"


def _show_energy(band: BandCheck) -> None:
    energy = table("light from", ">reflected", ">transmitted", ">most", "at θ, φ", ">over 100 %")
    for e in band.energy:
        side = "front (room)" if e.side == "front" else "back (outside)"
        shares = (_percent(e.reflected, 2), _percent(e.transmitted, 2), _percent(e.max, 2))
        energy.add_row(side, *shares, _polar(e.at), f"{_percent(e.over)} of directions" if e.over else "none")
    stdout.print(energy)


def _show_reciprocity(band: BandCheck) -> None:
    pairs = table("reciprocity error", ">mean by flux", ">largest", "from θ, φ", "to θ, φ")
    for r in band.reciprocity:
        pairs.add_row(r.part, _percent(r.mean, 2), _percent(r.max), *(map(_polar, r.at) if r.max else ("", "")))
    stdout.print(pairs)


def _show_components(band: BandCheck) -> None:
    """Noise, symmetry and colour of each component."""
    symmetry = {s.part: s for s in band.symmetry}
    gamut = {g.part: g for g in band.gamut}
    columns = ["component", ">noise", ">mirrored left-right", ">top-bottom", ">turned 90°"]
    rows = table(*columns, *([">impossible colour", ">beyond RGB"] if gamut else []))
    for n in band.noise:
        s, g = symmetry.get(n.part), gamut.get(n.part)
        changes = (s.left_right, s.top_bottom, s.quarter_turn) if s else (None, None, None)
        colors = (g.impossible, g.beyond_rgb) if g else (None, None)
        shown = map(_percent, changes + colors if gamut else changes)
        rows.add_row(n.part, _percent(n.level) or "not told", *shown)
    if band.noise:
        stdout.print(rows)


def _show_finding(finding: Finding) -> None:
    color = COLORS[finding.severity]
    stdout.print(f"[{color}]{finding.severity}[/{color}] {finding.kind}: ", end="", highlight=False)
    # Not as markup: a file's own words may be in it.
    stdout.print(printable(finding.message), highlight=False, markup=False)
    if not finding.advice:
        return
    repair = f"; --fix OUT --only {finding.kind} repairs it" if finding.repair else ""
    stdout.print(f"  → {finding.advice}{repair}", highlight=False, markup=False)
