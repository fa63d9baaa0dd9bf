"""How evenly samples lie, and what ramps in leaves gain: tables and the pictures of docs/sampling.md.

    python benches/sampling.py [FOLDER]          pictures go to FOLDER, docs/img by default

Evenness: of n samples of one incident direction, the share that falls into a cap of directions is compared with the
light that leaves through it, for 300 random caps. Ramps: relative L1 distances from formulas at random pairs of
directions.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bsdftree
from bsdftree import Bsdf, direction_from_polar
from bsdftree.plot._curve import step_curve
from bsdftree.plot._image import hemisphere_image
from bsdftree.plot._style import FAINT, INK, figure, save

Array = NDArray[np.float64]
N_CAPS, N_RUNS = 300, 12
LOG2_N = (4, 6, 8, 10, 12, 14, 16)


def strata(n: int, rng: np.random.Generator) -> Array:
    """One number in each of n equal parts of [0, 1)."""
    return np.minimum((np.arange(n) + rng.random(n)) / n, 1.0 - 2.0**-53)


def squares(n: int, rng: np.random.Generator) -> Array:
    """Two numbers in each of n equal squares."""
    k = round(n**0.5)
    x, y = np.meshgrid(np.arange(k), np.arange(k))
    return np.minimum((np.stack([x.ravel(), y.ravel()], -1) + rng.random((n, 2))) / k, 1.0 - 2.0**-53)


WAYS: dict[str, tuple[str, Callable[[int, np.random.Generator], Array]]] = {
    "one number, random": ("#d95f02", lambda n, rng: rng.random(n)),
    "two numbers, k × k squares": ("#7570b3", squares),
    "one number, n strata": ("#1b9e77", strata),
}


def caps(rng: np.random.Generator) -> tuple[Array, Array]:
    """Centres, uniform over the sphere, and cosines of radii from 5° to 60°."""
    z, phi = rng.uniform(-1, 1, N_CAPS), rng.uniform(0, 2 * np.pi, N_CAPS)
    r = np.sqrt(1 - z * z)
    centres = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)
    return centres, np.cos(np.radians(rng.uniform(5, 60, N_CAPS)))


def evenness(b: Bsdf, incident: Array) -> dict[str, Array]:
    """RMS error over caps and runs for each way and number of samples."""
    rng = np.random.default_rng(1)
    centres, cosines = caps(rng)

    def shares(u: Array) -> Array:
        exitant = b.sample(incident, u).exitant
        inside = np.zeros(N_CAPS)
        for part in np.array_split(exitant, max(1, len(exitant) // 16384)):
            inside += (part @ centres.T > cosines).sum(0)
        return inside / len(exitant)

    exact = shares((np.arange(1 << 22) + 0.5) / (1 << 22))
    errors = {}
    for name, (_, numbers) in WAYS.items():
        runs = [[shares(numbers(1 << k, rng)) - exact for _ in range(N_RUNS)] for k in LOG2_N]
        errors[name] = np.sqrt(np.mean(np.square(runs), axis=(1, 2)))
    return errors


def draw_evenness(subjects: dict[str, tuple[Bsdf, Array]], path: Path) -> None:
    """Print the table and draw the curves."""
    picture = figure(1200, 480)
    print("| samples | " + " | ".join(f"{name}: {way}" for name in subjects for way in WAYS) + " |")
    print("|---|" + "---|" * (len(subjects) * len(WAYS)))
    columns = []
    for k, (name, (b, incident)) in enumerate(subjects.items(), 1):
        axes = picture.add_subplot(1, len(subjects), k)
        for way, error in evenness(b, incident).items():
            axes.loglog(2.0 ** np.array(LOG2_N), error, "o-", base=2, color=WAYS[way][0], label=way, markersize=4)
            columns.append(error)
        axes.set_yscale("log", base=10)
        axes.set_title(name, color=INK)
        axes.set_xlabel("samples")
        axes.set_ylabel("error of the light in a cap of directions, RMS")
        axes.grid(color=FAINT, alpha=0.25)
        axes.legend(frameon=False)
    for row, k in zip(np.array(columns).T, LOG2_N, strict=True):
        print(f"| {1 << k:,} | " + " | ".join(f"{e:.2g}" for e in row) + " |")
    picture.tight_layout()
    save(picture, path)


def rough_metal(roughness: float) -> Callable[[Array, Array], Array]:
    """Diffuse, and a rough mirror by GGX microfacets (B. Walter et al., EGSR 2007)."""

    def value(incident: Array, exitant: Array) -> Array:
        h = incident + exitant
        cos2 = h[:, 2] ** 2 / (h**2).sum(1)
        a2 = roughness**2
        d = a2 / (np.pi * (cos2 * (a2 - 1) + 1) ** 2)
        ci, co = (np.maximum(abs(v[:, 2]), 1e-4) for v in (incident, exitant))
        smith = [(np.sqrt(1 + a2 * (1 / c**2 - 1)) - 1) / 2 for c in (ci, co)]
        return 0.1 + 0.5 * d / (4 * ci * co * (1 + smith[0] + smith[1]))

    return value


def hemisphere(n: int, rng: np.random.Generator) -> Array:
    """Front directions, uniform in projected solid angle."""
    r, phi = np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - r * r)], -1)


def tree(formula: Callable[[Array, Array], Array], rank: int, log2_res: int, tolerance: float) -> Bsdf:
    """One side of a formula as a tree."""
    parts = ["reflection_back"]
    return Bsdf.from_function(formula, rank=rank, log2_res=log2_res, tolerance=tolerance, components=parts)


def gain_row(name: str, formula: Callable[[Array, Array], Array], b: Bsdf) -> None:
    """Print one row of distances."""
    rng = np.random.default_rng(2)
    incident, exitant = hemisphere(400_000, rng), hemisphere(400_000, rng)
    truth = formula(incident, exitant)
    steps, ramps = (abs(x.eval(incident, exitant) - truth).sum() / truth.sum() for x in (b, b.smooth()))
    leaves = b.components["reflection_back"].n_leaves
    print(f"| {name} | {leaves:,} | {steps:.3f} | {ramps:.3f} | {steps / ramps:.1f} |", flush=True)


def best(f: Callable[[], object]) -> float:
    """Shortest CPU time of five calls [s]."""
    times = []
    for _ in range(5):
        start = time.process_time()
        f()
        times.append(time.process_time() - start)
    return min(times)


def cost(b: Bsdf) -> None:
    """Print what ramps cost: making them, and a million look-ups and samples from NumPy."""
    rng = np.random.default_rng(3)
    n, leaves = 1_000_000, b.components["reflection_back"].n_leaves
    incident, exitant, u = hemisphere(n, rng), hemisphere(n, rng), rng.random(n)
    print(f"| {leaves:,} leaves | steps | ramps |\n|---|---|---|")
    smooth = b.smooth()
    print(f"| to make [µs a leaf] | | {best(b.smooth) / leaves * 1e6:.2f} |")
    for name, call in {
        "eval [M/s]": lambda f: f.eval(incident, exitant),
        "sample [M/s]": lambda f: f.sample(incident, u),
        "hemispherical [M/s]": lambda f: f.hemispherical(incident),
    }.items():
        rates = [n / 1e6 / best(lambda f=f, call=call: call(f)) for f in (b, smooth)]
        print(f"| {name} | {rates[0]:.1f} | {rates[1]:.1f} |")


def draw_smooth(path: Path) -> None:
    """Formula, steps and ramps: a lobe that the tree resolves, and one that it does not."""
    incident = direction_from_polar(40, 165)
    picture = figure(1600, 720)
    for row, roughness in enumerate((0.15, 0.02)):
        formula = rough_metal(roughness)
        b = tree(formula, 4, 5, 0.12)
        step = (np.arange(300) + 0.5) / 150 - 1
        x, y = np.meshgrid(step, -step)
        inside = x**2 + y**2 < 1
        exitant = np.stack([x[inside], y[inside], np.sqrt(1 - x[inside] ** 2 - y[inside] ** 2)], -1)
        truth = np.full(x.shape, np.nan)
        truth[inside] = formula(np.broadcast_to(incident, exitant.shape), exitant)
        images = [truth, *(hemisphere_image(f, incident, 1.0, "Visible", 300) for f in (b, b.smooth()))]
        top = np.log10(np.nanmax(images[1])) + 0.3
        for column, (name, image) in enumerate(zip(("formula", "steps", "ramps"), images, strict=True)):
            axes = picture.add_subplot(2, 4, 4 * row + column + 1)
            shown = axes.imshow(np.log10(image), vmin=-1, vmax=top, cmap="viridis")
            axes.set_title(f"{name}, roughness {roughness}" if not column else name, color=INK)
            axes.axis("off")
        ticks = range(-1, int(top) + 1)
        bar = picture.colorbar(shown, ax=axes, shrink=0.8, ticks=list(ticks), format=lambda x, _: f"{10.0**x:g}")
        bar.set_label("BSDF [1/sr]")
        axes = picture.add_subplot(2, 4, 4 * row + 4)
        angles = np.linspace(-89, 89, 3000)
        line = formula(np.broadcast_to(incident, (3000, 3)), direction_from_polar(angles, -15.0))
        axes.semilogy(angles, line, color=INK, lw=0.8, label="formula")
        for f, color, name in ((b, "#d95f02", "steps"), (b.smooth(), "#1b9e77", "ramps")):
            angle, value = step_curve(f, 40, 165, "Visible")
            front = abs(angle) < 89
            axes.semilogy(angle[front], value[front], color=color, lw=1, label=name)
        axes.set_xlim(0, 85)
        axes.set_xlabel("exitant polar angle [degree]")
        axes.set_ylabel("BSDF [1/sr]")
        axes.legend(frameon=False)
    picture.tight_layout()
    save(picture, path)


def main() -> None:
    """Print both tables and write both pictures."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/img")
    sun = direction_from_polar(130, 90)
    subjects = {
        "blinds, 2⁵, sun at 50°": (bsdftree.generate("blinds", log2_res=5, samples=2000), sun),
        "rough metal, 2⁶, 40°": (tree(rough_metal(0.1), 3, 6, 0.02), direction_from_polar(40, 180)),
    }
    draw_evenness(subjects, folder / "sampling.png")
    print("\n| function | leaves | steps | ramps | gain |\n|---|---|---|---|---|")
    for roughness, rank, log2_res, tolerance in (
        (0.3, 4, 5, 0.14),
        (0.15, 4, 5, 0.14),
        (0.3, 3, 7, 0.03),
        (0.15, 3, 6, 0.1),
        (0.05, 4, 5, 0.1),
        (0.02, 4, 5, 0.1),
    ):
        formula = rough_metal(roughness)
        b = tree(formula, rank, log2_res, tolerance)
        gain_row(f"rough metal {roughness} + diffuse, rank {rank}, 2^{log2_res}", formula, b)
    print()
    cost(tree(rough_metal(0.15), 4, 5, 0.14))
    draw_smooth(folder / "smooth.png")


if __name__ == "__main__":
    main()
