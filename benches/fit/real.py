"""Measured samples end to end: every one of ua-loft's, read, fitted and drawn, trees beside the raw points.

`python -m benches.fit.real` prints the table and draws docs/img/fit-real.png. There is no truth here; what is compared
is each scan with the fit and with its tree at the scan's own points (relative L1 weighted by |cos θ|: noise and
smoothing; in the tree also the size of cells), and how well scans are predicted from the others.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import bsdftree

from .truths import DATA

LOFT = DATA / "ua-loft"
PICTURE = Path("docs/img/fit-real.png")
DRAWN = ("EC1onAlum (zemax)", "NiTEonSteel_fullAz", "IMX455 (zemax)", "(raw)")
"""Parts of the names of those that are drawn: one of each kind."""


@dataclass(frozen=True)
class Sample:
    name: str
    files: list[Path]


def samples() -> Iterator[Sample]:
    """One for each file of processed data, and for each set of raw files."""
    for kind in ("zemax", "fred"):
        for path in sorted((LOFT / "processed" / kind).iterdir()):
            yield Sample(f"{path.stem} ({kind})", [path])
    raw = LOFT / "raw" / "rt-300s"
    for stem in ("IMX455_stageRotation", "MagicBlack", "NiTE_on_invar"):
        yield Sample(f"{stem} (raw)", sorted(raw.glob(f"{stem}*.xls")))


@dataclass(frozen=True)
class Fitted:
    sample: Sample
    measurement: Any
    bsdf: bsdftree.Bsdf
    fit: Any
    residual: float
    """Of the fitted model at the measured points, and of its tree."""
    tree_residual: float
    seconds: float


def fitted(sample: Sample, log2_res: int) -> Fitted:
    start = time.perf_counter()
    measurement = bsdftree.Measurement.load(sample.files)
    fit = bsdftree.fit(measurement)
    bsdf = fit.bsdf(log2_res=log2_res)
    seconds = time.perf_counter() - start
    return Fitted(
        sample, measurement, bsdf, fit, residual(measurement, fit.eval), residual(measurement, bsdf.eval), seconds
    )


def residual(measurement: bsdftree.Measurement, evaluate: Callable[..., Any]) -> float:
    """Relative L1 at the measured points, weighted by |cos θ|."""
    off = over = 0.0
    for scan in measurement.scans:
        cosine = np.abs(scan.exitant[:, 2])
        off += float(np.sum(np.abs(evaluate(scan.incident, scan.exitant) - scan.values) * cosine))
        over += float(np.sum(np.maximum(scan.values, 0) * cosine))
    return off / over


def row(fit: Fitted) -> str:
    scans = fit.measurement.scans
    points = sum(len(scan.values) for scan in scans)
    components = fit.bsdf.components
    trees = ", ".join(
        f"rank {t.rank}, {t.n_leaves} leaves" for t in components.values() if isinstance(t, bsdftree.Tree)
    )
    chosen = ", ".join(f"{fit.fit.symmetry}, {rows[0].frame}, {rows[0].l1:.3f}" for rows in fit.fit.recipes.values())
    cells = (fit.sample.name, len(scans), points, chosen, trees)
    numbers = (f"{fit.residual:.3f}", f"{fit.tree_residual:.3f}", f"{fit.seconds:.1f}")
    return "| " + " | ".join(map(str, cells + numbers)) + " |"


def draw(fits: list[Fitted], path: Path) -> None:
    """A row for each sample: two scans, each as its raw points and as the tree."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import LogNorm

    figure, axes = pyplot.subplots(len(fits), 4, figsize=(9.5, 2.3 * len(fits)), squeeze=False, layout="constrained")
    for line, fit in zip(axes, fits, strict=True):
        scans = sorted(fit.measurement.scans, key=lambda scan: -scan.incident[2])
        for pair, scan in zip((line[:2], line[2:]), (scans[len(scans) // 4], scans[-1]), strict=True):
            values = scan.values
            top = float(np.quantile(values, 0.999))
            norm = LogNorm(max(top / 1000, float(np.quantile(values[values > 0], 0.02))), top)
            places = scan.exitant[:, :2]
            pair[0].scatter(*places.T, c=np.clip(values, norm.vmin, None), norm=norm, s=4)
            grid = np.linspace(-1, 1, 161)
            x, y = np.meshgrid(grid, grid, indexing="ij")
            side = np.sign(np.median(scan.exitant[:, 2]))
            z = side * np.sqrt(np.maximum(1 - x * x - y * y, 0))
            seen = fit.bsdf.eval(scan.incident, np.stack([x, y, z], axis=-1))
            seen[x * x + y * y > 1] = np.nan
            mesh = pair[1].pcolormesh(grid, grid, np.clip(seen.T, norm.vmin, None), norm=norm, rasterized=True)
            theta, phi = bsdftree.polar_from_direction(scan.incident)
            pair[0].set_title(f"points, θ {theta:.0f}°, φ {phi:.0f}°", fontsize=7)
            pair[1].set_title("tree", fontsize=7)
            bar = figure.colorbar(mesh, ax=pair[1], shrink=0.8)
            bar.ax.tick_params(which="both", labelsize=5)
            for axis in pair:
                axis.set_aspect("equal")
                axis.set_xlim(-1.02, 1.02)
                axis.set_ylim(-1.02, 1.02)
                axis.set_axis_off()
        line[0].text(-1.3, 0, fit.sample.name, rotation=90, va="center", ha="center", fontsize=6)
    figure.savefig(path, dpi=100)
    pyplot.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benches.fit.real", description="Fits of ua-loft's samples.")
    parser.add_argument("--sample", metavar="PART", help="only samples with this in their names")
    parser.add_argument("--log2-res", type=int, default=6)
    parser.add_argument("--picture", type=Path, default=PICTURE)
    arguments = parser.parse_args()
    print("| sample | scans | points | fit, left-out L1 | tree | residual | of the tree | s |")
    print("|---|---:|---:|---|---|---:|---:|---:|")
    fits = []
    for sample in samples():
        if arguments.sample is None or arguments.sample in sample.name:
            fits.append(fitted(sample, arguments.log2_res))
            print(row(fits[-1]), flush=True)
    draw([fit for fit in fits if any(part in fit.sample.name for part in DRAWN)] or fits, arguments.picture)


if __name__ == "__main__":
    main()
