"""Verdicts as an aligned table, one row per material; "theirs" is the incumbent's.

Columns: how many left-out incident directions count (inside the measured range, away from total internal reflection);
mean relative L1 of both, the ratio of means, the least ratio and our worst L1 of any one direction; mean relative error
of hemispherical totals; share of flux within 2 standard errors; mean L1 outside the measured range, and near total
internal reflection; CPU time from readings to tree [s]; targets that ours misses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .formulas import Array
from .judge import Court, Verdict

COVERED = 0.9
"""Share of the flux that 2 sigma bars have to cover."""


@dataclass(frozen=True)
class Case:
    court: Court
    ours: Verdict | None
    incumbent: Verdict | None

    @property
    def ratios(self) -> Array:
        """How much closer ours is, direction by direction, where targets hold."""
        if self.ours is None or self.incumbent is None:
            return np.array([])
        counts = self.court.counts
        return np.asarray(self.incumbent.l1[counts] / np.maximum(self.ours.l1[counts], 1e-12))

    @property
    def ratio(self) -> float | None:
        """Of mean errors."""
        if self.ours is None or self.incumbent is None:
            return None
        counts = self.court.counts
        return float(self.incumbent.l1[counts].mean() / self.ours.l1[counts].mean())

    def misses(self) -> list[str]:
        """Targets that ours misses."""
        if self.ours is None:
            return []
        target, counts = self.court.material.target, self.court.counts
        found = []
        if self.ours.l1[counts].mean() > target.error:
            found.append(f"L1 > {target.error:g}")
        if self.ours.total[counts].mean() > target.hemispherical:
            found.append(f"total > {100 * target.hemispherical:g} %")
        if self.ours.covered is not None and self.ours.covered[counts].mean() < COVERED:
            found.append(f"covered < {100 * COVERED:g} %")
        if self.ratio is not None and self.ratio < target.ratio:
            found.append(f"ratio < {target.ratio:g}")
        if self.ratio is not None and self.ratios.min() < target.worst_ratio:
            found.append(f"worst < {target.worst_ratio:g}")
        return found


COLUMNS = (
    "material",
    "n",
    "L1 ours",
    "L1 theirs",
    "ratio",
    "least ratio",
    "worst L1 ours",
    "total ours",
    "total theirs",
    "2σ covers",
    "outside ours",
    "outside theirs",
    "TIR ours",
    "TIR theirs",
    "CPU s ours",
    "CPU s theirs",
    "misses",
)


def row(case: Case) -> list[str]:
    ours, theirs, court = case.ours, case.incumbent, case.court
    counts, outside, near = court.counts, ~court.inside & ~court.near, court.inside & court.near
    return [
        court.material.name,
        str(counts.sum()),
        _mean(ours, "l1", counts),
        _mean(theirs, "l1", counts),
        "" if case.ratio is None else f"{case.ratio:.1f}",
        "" if case.ratio is None else f"{case.ratios.min():.1f}",
        "" if ours is None else f"{ours.l1[counts].max():.3f}",
        _mean(ours, "total", counts),
        _mean(theirs, "total", counts),
        _mean(ours, "covered", counts),
        _mean(ours, "l1", outside),
        _mean(theirs, "l1", outside),
        _mean(ours, "l1", near),
        _mean(theirs, "l1", near),
        "" if ours is None else f"{ours.seconds:.1f}",
        "" if theirs is None else f"{theirs.seconds:.1f}",
        ", ".join(case.misses()) if case.ours else "",
    ]


def _mean(verdict: Verdict | None, field: str, where: Array) -> str:
    values = None if verdict is None else getattr(verdict, field)
    return "" if values is None or not where.any() else f"{values[where].mean():.3f}"


def table(cases: Sequence[Case]) -> str:
    """Markdown that is aligned as text too; columns without a value are left out."""
    rows = [row(case) for case in cases]
    kept = [k for k in range(len(COLUMNS)) if any(cells[k] for cells in rows)]
    rows = [[COLUMNS[k] for k in kept], *([cells[k] for k in kept] for cells in rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "| " + " | ".join(_padded(c, w, k) for k, (c, w) in enumerate(zip(cells, widths, strict=True))) + " |"
        for cells in rows
    ]
    rule = "|" + "|".join("-" * (w + 1) + ("-" if k == 0 else ":") for k, w in enumerate(widths)) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])


def _padded(cell: str, width: int, column: int) -> str:
    return cell.ljust(width) if column == 0 else cell.rjust(width)


def directions(case: Case) -> str:
    """The worst directions of a case, with their angles: where to look."""
    shown = case.ours or case.incumbent
    if shown is None:
        return ""
    middle = case.court.middle
    theta = np.degrees(np.arccos(middle[:, 2]))
    phi = np.degrees(np.arctan2(middle[:, 1], middle[:, 0])) % 360
    lines = []
    for k in np.argsort(-shown.l1)[:8]:
        place = "inside" if case.court.inside[k] else "outside"
        place += ", near total reflection" if case.court.near[k] else ""
        both = "" if case.ours is None or case.incumbent is None else f", incumbent {case.incumbent.l1[k]:.3f}"
        lines.append(f"  theta {theta[k]:4.1f} phi {phi[k]:5.1f}: {shown.l1[k]:.3f}{both} ({place})")
    return "\n".join(lines)
