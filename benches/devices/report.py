"""The report: what was compared and how, a table of all devices, published files, and what was found out."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np

import bsdftree

from .comparison import SIGNIFICANCE, TOTAL
from .oracle import BATCHES
from .ours import RUNS
from .patches import INCIDENT, N_PATCHES
from .run import Compared, Measured

FINDINGS = Path(__file__).parent / "findings.md"


def aligned(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table of which the source is aligned too; columns that begin with ">" are numbers."""
    right = [c.startswith(">") for c in columns]
    cells = [[c.lstrip(">") for c in columns], *rows]
    widths = [max(3, *(len(row[k]) for row in cells)) for k in range(len(columns))]
    lines = [
        "| " + " | ".join(c.rjust(w) if r else c.ljust(w) for c, w, r in zip(row, widths, right, strict=True)) + " |"
        for row in cells
    ]
    rule = "|" + "|".join("-" * (w + 1) + (":" if r else "-") for w, r in zip(widths, right, strict=True)) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])


def verdict(m: Measured) -> str:
    """In a word or two."""
    if m.verdict.agrees:
        return "agrees" if not m.scene.known else "agrees, unlike what is known"
    return "differs, known" if m.scene.known else "DIFFERS"


def text(measured: Sequence[Measured], samples: int, minutes: float, picture: Path) -> str:
    """The whole report."""
    agreeing = sum(m.verdict.agrees for m in measured)
    known = sum(bool(m.scene.known) and not m.verdict.agrees for m in measured)
    tests = sum(m.verdict.n_tests for m in measured)
    features = sorted({f for m in measured for f in m.scene.features}, key=str.lower)
    ratios = [m.verdict.efficiency * m.radiance.cpu / m.ours.cpu * 145 / len(INCIDENT) for m in measured]
    parts = [
        "# Devices: our engine beside Radiance",
        f"Made by `make devices-report`: {len(measured)} devices, {tests:,} tests, {minutes:.0f} minutes on "
        f"{cpu_name()} ({os.cpu_count()} threads), bsdftree {bsdftree.__version__}, pyradiance "
        f"{version('pyradiance')}. "
        f"**{agreeing} agree, {known} differ for a reason that is known and stated, "
        f"{len(measured) - agreeing - known} differ otherwise.**",
        METHOD.format(
            samples=f"{samples:,}",
            batches=BATCHES,
            runs=RUNS,
            n_incident=len(INCIDENT),
            n_patches=N_PATCHES,
            significance=f"{SIGNIFICANCE:g}",
            total=f"{TOTAL:.1%}",
        ),
        f"Covered: {', '.join(features)}.",
        f"![Each device twice: ours left, Radiance's right]({picture.as_posix()})",
        "## What each device is",
        devices(measured),
        "## How they compare",
        COLUMNS,
        numbers(measured),
        f"Our engine needs {np.nanmedian(ratios):.2g} times less CPU time than Radiance's for the same error of a "
        "patch (median of the devices; its time here is for 12 of 145 incident patches, ours for all).",
        "## What their authors published",
        PUBLISHED,
        published([m for m in measured if m.published is not None]),
    ]
    notes = [f"* `{m.scene.name}`: {m.scene.known}." for m in measured if m.scene.known]
    if notes:
        parts += ["## Differences that are known", "\n".join(notes)]
    parts.append(FINDINGS.read_text().strip())
    return "\n\n".join(parts) + "\n"


METHOD = """\
Each device is a scene file that both engines read, traced by both into fractions of light from {n_incident} Klems
patches of each side to all {n_patches} patches of both sides. Radiance's rcontrib follows {samples} rays for each
incident patch, in {batches} independent batches, so that each number has a standard error; we generate a Klems
matrix with as many paths, in {runs} independent runs. A difference over its standard error is Student's t with
Welch's degrees of freedom, here as the normal deviate z of the same probability. Tested are single patches
(neighbours together until they hold 100 rays), each incident patch's and each exitant patch's light, totals, and
the mean z² of all patches. p is the least probability of these tests times their number (Bonferroni). A device
agrees if p > {significance} and no hemispherical total (mean over the incident patches) differs by more than
{total}, absolute. Rays end by Russian roulette alone in both engines; how else Radiance's settings differ from
genBSDF's, and why, and what "by sources" is, stands at the head of `benches/devices/oracle.py`."""

COLUMNS = """\
Totals are of light from the front (R, T) and from the back (R′, T′), Radiance's; Δ is the largest difference of
ours, in percent points. µs are CPU time of one ray or path, on one thread."""

PUBLISHED = """\
Totals of the same incident patches in the files that the devices' authors made with genBSDF, and ours; z of patches
has the noise of their count of rays."""


def devices(measured: Sequence[Measured]) -> str:
    rows = [
        [f"`{m.scene.name}`", m.scene.title, ", ".join(m.scene.features), m.scene.oracle, verdict(m)] for m in measured
    ]
    return aligned(["file", "device", "features", "Radiance by", "verdict"], rows)


def numbers(measured: Sequence[Measured]) -> str:
    rows = []
    for m in measured:
        v = m.verdict
        z = np.abs(v.z) if v.z.size else np.zeros(1)
        (r, t), (t_back, r_back) = v.radiance
        micro = [1e6 * m.radiance.cpu / m.radiance.n_rays, 1e6 * m.ours.cpu / m.ours.n_paths]
        rows.append(
            [
                f"`{m.scene.name}`",
                f"{v.z.size}",
                *(f"{q:.2f}" for q in np.quantile(z, [0.5, 0.99, 1])),
                f"{v.p:.1g}",
                v.worst,
                *(f"{100 * x:.1f}" for x in (r, t, r_back, t_back)),
                f"{100 * v.largest_difference:.2f}",
                *(f"{x:.2f}" for x in micro),
                f"{micro[0] / micro[1]:.1f}",
                verdict(m),
            ]
        )
    quantiles = [">median abs z", ">99 %", ">max"]
    totals = [">R %", ">T %", ">R′ %", ">T′ %", ">Δ"]
    times = [">Radiance µs", ">our µs", ">ratio"]
    return aligned(["file", ">patches", *quantiles, ">p", "by", *totals, *times, "verdict"], rows)


def published(measured: Sequence[Measured]) -> str:
    rows = [[f"`{m.scene.name}`", *_compared(m.published)] for m in measured if m.published is not None]
    totals = [">R %", ">ours", ">T %", ">ours", ">R′ %", ">ours", ">T′ %", ">ours"]
    return aligned(["file", ">rays", *totals, ">patches", ">mean z²", ">max abs z"], rows)


def _compared(c: Compared) -> list[str]:
    def percent(x: float) -> str:
        return "–" if np.isnan(x) else f"{100 * x:.1f}"

    order = [(0, 0), (0, 1), (1, 1), (1, 0)]
    totals = [percent(float(x[k])) for k in order for x in (c.theirs, c.ours)]
    return [f"{c.rays}", *totals, f"{c.z.size}", f"{(c.z**2).mean():.2f}", f"{np.abs(c.z).max():.2f}"]


def cpu_name() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
