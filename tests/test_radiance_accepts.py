"""Radiance reads, checks, converts and renders the files that we write, and finds in them what we have.

Files: all real ones converted, and generated ones of every kind. Programs: checkBSDF, bsdf2klems, rtrace, rpict.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from directions import SIDES, hemisphere, turned
from parity import (
    COMPONENT,
    assert_evaluates_alike,
    is_dropped,
    largest_hemispherical,
    pairs,
    sampled_in_reverse_by_us_only,
)
from radiance import REAL_FILES, Library, needs_radiance, run

import bsdftree
from bsdftree import Bsdf, Device, Tree

pytestmark = needs_radiance

COLOURED = """
void plastic red 0 0 5 0.8 0.3 0.1 0 0
void glass tinted 0 0 3 0.3 0.6 0.9
red polygon lower 0 0 12  0 0 -0.01  0.5 0 -0.01  0.5 1 -0.01  0 1 -0.01
tinted polygon pane 0 0 12  0.5 0 -0.01  1 0 -0.01  1 1 -0.01  0.5 1 -0.01
red polygon step 0 0 12  0.5 0 -0.01  0.5 0 0  0.5 1 0  0.5 1 -0.01
"""
BLINDS = "blinds:angle=30,glazing=0.8"
GENERATED = {
    "rank 3": ("sawtooth", dict(rank=3, log2_res=5)),
    "rank 4": (BLINDS, dict(rank=4, log2_res=3)),
    "Klems full": (BLINDS, dict(klems="full")),
    "Klems half": (BLINDS, dict(klems="half")),
    "Klems quarter": (BLINDS, dict(klems="quarter")),
    "Klems quarter 2x2": (BLINDS, dict(klems="quarter", subdivide=2)),
    "Klems full 2x2": (BLINDS, dict(klems="full", subdivide=2, samples=50)),
    "colour rank 3": (COLOURED, dict(rank=3, log2_res=4, color=True)),
    "colour rank 4": (COLOURED, dict(rank=4, log2_res=3, color=True)),
    "colour Klems": (COLOURED, dict(klems="quarter", color=True)),
    "from the room only": (BLINDS, dict(rank=4, log2_res=3, sides="front")),
    "from outside only": (BLINDS, dict(rank=4, log2_res=3, sides="back")),
    "Klems from the room only": (BLINDS, dict(klems="quarter", sides="front")),
}
COARSE = ["frads/blinds30.xml", *(name for name in GENERATED if "Klems" in name and "2x2" not in name)]
COLOURS = [name for name in GENERATED if name.startswith("colour")]


@pytest.fixture(scope="session")
def write(tmp_path_factory, request):
    """A function from the name of a real or generated BSDF to the path of a file that we wrote of it."""
    folder, written = tmp_path_factory.mktemp("written"), {}

    def write_once(name: str) -> Path:
        if name not in written:
            path = folder / (re.sub(r"\W+", "_", name) + ".xml")
            if name in GENERATED:
                device, options = GENERATED[name]
                device = Device.parse(device) if device is COLOURED else Device.from_spec(device)
                b = bsdftree.generate(device, **{"samples": 300, "seed": 11} | options)
            else:
                b = bsdftree.load(request.getfixturevalue("data") / name)
            b.save(path)
            written[name] = path
        return written[name]

    return write_once


every_file = pytest.mark.parametrize("name", [*REAL_FILES, *GENERATED])


@every_file
def test_library_has_the_same_values(write, rng, name):
    path = write(name)
    assert_evaluates_alike(bsdftree.load(path), path, rng)


@pytest.mark.parametrize("name", COLOURS)
def test_library_has_the_same_colours(write, rng, name):
    path = write(name)
    b = bsdftree.load(path)
    assert b.chroma_of().keys() == b.components.keys()
    incident, exitant = (np.concatenate(part) for part in zip(*[pairs(b, rng, s) for s in SIDES], strict=True))
    ours = b.eval(incident, exitant, color=True)
    theirs = Library(path).answers(pairs=(incident, exitant))["xyz"]
    assert (np.ptp(ours, axis=1) > 0.05 * ours[:, 1]).mean() > 0.2, "hardly any colour to compare"
    np.testing.assert_allclose(theirs[:, 1], ours[:, 1], rtol=5e-4, atol=1e-9)
    lit = ours[:, 1] > 0
    ours, theirs = (xyz[lit, :2] / xyz[lit].sum(axis=1, keepdims=True) for xyz in (ours, theirs))
    error = abs(theirs - ours).max()
    print(f"{name}: largest error of chromaticity {error:.1e}")
    # Of a matrix, Radiance keeps chromaticities u' and v' in 8 bits each, dithered; of a tree, it joins cells of nearly
    # one colour.
    assert error < (0.01 if "Klems" in name else 2e-3)


ROWS = {
    "Interior Refl": "reflection_back",
    "Exterior Refl": "reflection_front",
    "Int->Ext Trans": "transmission_back",
    "Ext->Int Trans": "transmission_front",
}


@every_file
def test_checkbsdf_finds_our_totals(write, name):
    """Lambertian part and largest total [%, one decimal], smallest angle [degree] of each component."""
    path = write(name)
    b = bsdftree.load(path)
    lambertian, seen = b.lambertian(), 0
    for line in run("checkBSDF", path).decode().splitlines():
        row = re.match(r"(.*?)\s+([\d.]+) +([\d.]+) +([\d.]+)\s+([\d.]+)%\s+([\d.]+) deg", line)
        if row is None:
            continue
        key, y, total, angle = ROWS[row[1]], float(row[3]), float(row[5]), float(row[6])
        component = b.components.get(key)
        diffuse = largest = 0.0
        if component is not None and not is_dropped(b, key):
            diffuse, largest = lambertian[key], largest_hemispherical(component)
            if isinstance(component, Tree):
                assert angle == pytest.approx(np.degrees(2.0 * 0.5**component.depth), abs=0.006)
                if component.rank == 3 and total < 100 * largest - 0.1:
                    # It may take two incident cells together.
                    rows = component.to_grid().astype(float).sum(axis=(1, 2)) * np.pi / 4**component.depth
                    largest = rows.reshape(-1, 2).mean(axis=1).max()
        elif component is not None:
            # What is only Lambertian it prints as a fraction in the column of percentages.
            diffuse, largest = lambertian[key], 0.01 * lambertian[key]
        elif key.startswith("transmission"):
            # The other transmission's Lambertian part is copied.
            diffuse = next((v for k, v in lambertian.items() if k.startswith("transmission")), 0.0)
            largest = 0.01 * diffuse
        assert y == pytest.approx(100 * diffuse, abs=0.051)
        assert total == pytest.approx(100 * largest, abs=0.051 + 0.001 * 100 * largest)
        seen += 1
    assert seen == 4


@pytest.mark.parametrize("name", ["frads/blinds30.xml", *GENERATED])
def test_bsdf2klems_keeps_our_totals(write, tmp_path, rng, name):
    """Totals of the Klems matrix that it makes, averaged over incident directions, are ours.

    It takes the mean of random places in each pair of patches, and finds too little of fine peaks.
    """
    path, klems = write(name), tmp_path / "klems.xml"
    same_basis = name in ("frads/blinds30.xml", "Klems full")
    made = run("bsdf2klems", *(["-n", 10] if same_basis else ["-q", "-n", 300]), path)
    # It writes colours of black pairs as -nan.
    klems.write_bytes(re.sub(rb"-?nan", b"0", made) if name in COLOURS else made)
    ours, theirs = bsdftree.load(path), bsdftree.load(klems, strict=False)
    tolerance = 2e-3 if name in COARSE else 0.12
    for side in (1, -1):
        incident = hemisphere(rng, 4000, side)
        for part in ("reflection", "transmission"):
            expected = ours.hemispherical(incident, part).mean()
            if expected > 0.002:
                assert theirs.hemispherical(incident, part).mean() == pytest.approx(expected, rel=tolerance)


def octree(folder: Path, bsdf: Path, sky_side: int) -> Path:
    """A sample of a BSDF in the plane z = 0, and a sky of radiance 1 on one side of it."""
    scene = f"""
    void glow sky 0 0 4 1 1 1 0
    sky source hemisphere 0 0 4 0 0 {sky_side} 180
    void BSDF material 6 0 {bsdf} 0 1 0 . 0 0
    material polygon sample 0 0 12  -5 -5 0  5 -5 0  5 5 0  -5 5 0
    """
    path = folder / "sample.oct"
    path.write_bytes(run("oconv", "-", stdin=scene))
    return path


def rendered(scene: Path, towards: np.ndarray) -> np.ndarray:
    """Radiance, weighted to luminance, that leaves the sample in directions: (n,).

    Hardly jittered (-ss): the material would otherwise answer for directions in neighbouring cells.
    """
    rays = "\n".join(" ".join(f"{x:.17g}" for x in ray) for ray in np.hstack([towards, -towards]))
    options = "-h -ab 1 -ad 256 -aa 0 -ss 1e-4 -st 0 -lw 1e-9 -lr 2".split()
    red, green, blue = np.loadtxt(run("rtrace", *options, scene, stdin=rays).decode().splitlines()).T
    return 0.265 * red + 0.670 * green + 0.065 * blue


def steady(b: Bsdf, directions: np.ndarray, step: float = 3e-4) -> np.ndarray:
    """Which directions are over `step` [radian] away from those with other totals."""
    moves = [(0.0, 0.0), (step, step), (step, -step), (-step, step), (-step, -step)]
    totals = [b.hemispherical(turned(directions, *move), p) for move in moves for p in ("reflection", "transmission")]
    return np.ptp(totals[0::2], axis=0) + np.ptp(totals[1::2], axis=0) == 0.0


@pytest.mark.parametrize("sky_side", [1, -1])
@every_file
def test_rtrace_renders_our_totals(write, tmp_path, rng, name, sky_side):
    """Under a uniform sky a sample is as bright as the fraction that it scatters of light from the viewer."""
    path = write(name)
    b = bsdftree.load(path)
    towards = np.concatenate([hemisphere(rng, 60, 1), hemisphere(rng, 60, -1)])
    towards = towards[steady(b, towards)]
    assert len(towards) > 50
    seen = rendered(octree(tmp_path, path, sky_side), towards)
    reflected = np.sign(towards[:, 2]) == sky_side
    expected = np.where(reflected, b.hemispherical(towards, "reflection"), b.hemispherical(towards, "transmission"))
    # Radiance does not sample rank-3 trees in reverse.
    compared = reflected | ~sampled_in_reverse_by_us_only(b, towards)
    expected = np.where(expected <= 0.001, np.clip(expected, 0, seen), expected)
    np.testing.assert_allclose(seen[compared], expected[compared], rtol=1e-3, atol=2e-4)


@pytest.mark.parametrize("sky_side", [1, -1])
@pytest.mark.parametrize("rank", [3, 4])
def test_rtrace_renders_a_diffuser_exactly(tmp_path, rng, rank, sky_side):
    parts = {"reflection_back": 0.5, "reflection_front": 0.2, "transmission_back": 0.3, "transmission_front": 0.3}
    path = tmp_path / "diffuser.xml"
    Bsdf.from_trees({k: Tree.from_grid(np.full((1,) * rank, v / np.pi)) for k, v in parts.items()}).save(path)
    for side in (1, -1):
        expected = parts[COMPONENT[(side, side)] if side == sky_side else COMPONENT[(side, -side)]]
        seen = rendered(octree(tmp_path, path, sky_side), hemisphere(rng, 20, side))
        np.testing.assert_allclose(seen, expected, rtol=1e-5)


@pytest.mark.parametrize("name", ["pyradiance/t3.xml", "frads/blinds30.xml", *GENERATED])
def test_rpict_pictures_a_sample(write, tmp_path, name):
    """The middle of the picture shows the sample, lit by the sky, as bright as it reflects on average."""
    path = write(name)
    b = bsdftree.load(path)
    side = -1 if name == "from outside only" else 1
    view = ["-vp", 0.0, 0.0, 3.0 * side, "-vd", 0, 0, -side, "-vu", 0, 1, 0, "-vh", 90, "-vv", 90]
    size = ["-x", 24, "-y", 24, "-ps", 1, "-ab", 1, "-ad", 256, "-aa", 0, "-ss", 0.001, "-st", 0]
    picture = run("rpict", *view, *size, octree(tmp_path, path, side))
    values = np.array(run("pvalue", "-h", "-H", "-b", "-d", stdin=picture).decode().split(), float).reshape(24, 24)
    x, y = np.meshgrid((np.arange(24) + 0.5) / 12 - 1, (np.arange(24) + 0.5) / 12 - 1)
    towards = np.stack([-x, -y, np.full_like(x, side)], axis=-1)
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    assert values.mean() == pytest.approx(b.hemispherical(towards, "reflection").mean(), rel=0.03)
