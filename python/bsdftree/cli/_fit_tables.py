"""What a fit says of itself, as tables."""

from __future__ import annotations

from itertools import groupby

from bsdftree import DirectionTotal, FitSummary, PartSummary
from bsdftree.cli._common import printable, stdout, table

# Recipes worth a line: those that could have been.
_N_RECIPES = 5


def show(summary: FitSummary) -> None:
    """Print a summary for people."""
    channels = "X, Y, Z" if summary.n_channels == 3 else "one channel"
    what = f"{summary.n_scans} scans, {summary.n_points:,} points, {channels}"
    _say(f"{summary.name or 'a sample'}: {what}", "bold")
    for note in summary.notes:
        _say(f"note: {note}", "dim")
    _say(f"symmetry: {summary.symmetry}, {summary.symmetry_reason}")
    if summary.symmetry_errors:
        tried = ", ".join(f"{name} {_percent(error)}" for name, error in summary.symmetry_errors.items())
        _say(f"left-out scans are predicted to: {tried}", "dim")
    for part in summary.parts:
        _show_part(part)


def _show_part(part: PartSummary) -> None:
    side = "the room" if part.component.endswith("back") else "outside"
    _say(f"\n{part.component} (light from {side})", "bold")
    swapped = any(recipe.reciprocal for recipe in part.recipes)
    columns = ("", "frame", "weights", "base", *(("swapped pairs",) if swapped else ()))
    recipes = table(*columns, ">error of left-out scans", ">worst")
    for k, recipe in enumerate(part.recipes[:_N_RECIPES]):
        recipes.add_row(
            "in use" if k == 0 else "",
            recipe.frame,
            recipe.blend,
            "stays" if recipe.split else "moves",
            *(("averaged" if recipe.reciprocal else "–",) if swapped else ()),
            _percent(recipe.l1),
            _percent(recipe.worst),
        )
    stdout.print(recipes)
    more = len(part.recipes) - _N_RECIPES
    if more > 0:
        _say(f"and {more} recipes with larger errors", "dim")
    _say(_reciprocity(part))
    totals = table(">light from θ", ">scans", ">points", ">total measured", ">of the tree", ">± standard error", "")
    for theta_deg, rows in groupby(part.totals, key=lambda row: (row.n_points > 0, round(row.theta_deg, 1))):
        _add_total(totals, theta_deg[1], list(rows))
    stdout.print(totals)
    tree = "" if part.n_leaves is None else f"rank {part.rank}, {part.n_leaves:,} leaves; "
    _say(
        f"{tree}mean standard error {_percent(part.standard_error)}; {_percent(part.uncertain)} of the light has more "
        "than 25 %"
    )
    _say(
        f"extrapolated: {_percent(part.extrapolated)} of incident directions lie outside those measured; exitant "
        f"directions are up to {part.hole_deg:.0f}° from all points"
    )


def _reciprocity(part: PartSummary) -> str:
    """What swapped pairs of scans say, and what was made of it."""
    found = part.reciprocity
    if found is None:
        return "reciprocity: not known, too few scans were measured towards each other's light"
    said = (
        f"{found.n_pairs:,} swapped pairs differ by {_percent(found.difference)}, expected {_percent(found.expected)}"
    )
    if not found.holds:
        return f"reciprocity: does not hold, and is {'' if part.recipes[0].reciprocal else 'not '}used; {said}"
    if part.recipes[0].reciprocal:
        return f"reciprocity: holds, and is used; {said}"
    tried = any(recipe.reciprocal for recipe in part.recipes)
    return f"reciprocity: holds, and is not used{', since it does not help' if tried else ''}; {said}"


def _add_total(totals: object, theta_deg: float, rows: list[DirectionTotal]) -> None:
    n = len(rows)
    measured = [row.measured for row in rows if row.measured is not None]
    is_measured = rows[0].n_points > 0
    totals.add_row(  # type: ignore[attr-defined]
        f"{theta_deg:g}°",
        f"{n}" if is_measured else "–",
        f"{sum(row.n_points for row in rows):,}" if is_measured else "–",
        _percent(sum(measured) / len(measured)) if measured else "–",
        _percent(sum(row.fitted for row in rows) / n),
        _percent(sum(row.standard_error for row in rows) / n),
        "" if is_measured else "extrapolated",
    )


def _percent(value: float) -> str:
    return "–" if value != value else f"{100 * value:.1f} %"


def _say(text: str, style: str | None = None) -> None:
    stdout.print(printable(text), style=style, highlight=False, markup=False)
