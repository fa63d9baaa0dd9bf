"""Trees and matrices from one another, beside Radiance's bsdf2klems and on real files."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from radiance import REAL_FILES, needs_radiance, run

import bsdftree
from bsdftree import Bsdf, Tree
from bsdftree.cli import main


def areas(rings) -> np.ndarray:
    """Projected solid angles of all patches [sr]."""
    each = [np.full(n, np.pi * (np.cos(np.radians(a)) ** 2 - np.cos(np.radians(b)) ** 2) / n) for a, b, n in rings]
    return np.concatenate(each)


@needs_radiance
@pytest.mark.parametrize("name", ["pyradiance/t3.xml", "radiance/testBSDF.xml", "ignis/simple_tensor_d2_refl.xml"])
def test_matrices_are_those_of_bsdf2klems(data, tmp_path, name):
    """Radiance samples each pair of patches: with four times as many samples it is about twice as near to ours."""
    b = bsdftree.load(data / name, strict=False)
    ours, errors = b.to_klems("quarter"), []
    for samples in (16, 256):
        path = tmp_path / f"{samples}.xml"
        path.write_bytes(run("bsdf2klems", "-q", "-n", samples, data / name))
        theirs = bsdftree.load(path, strict=False)
        # Radiance evaluates an absent transmission, and drops what is black.
        for key, mine in ours.components.items():
            matrix = theirs.components.get(key)
            if matrix is None:
                assert not mine.values.any()
                continue
            weights = areas(mine.exitant_rings)
            light = weights @ mine.values @ weights
            error = weights @ abs(matrix.values - mine.values) @ weights / light
            total = weights @ matrix.values @ weights / light - 1
            errors.append((key, samples, error, total))
            print(f"{name} {key} -n {samples}: relative L1 {error:.2e}, light {total:+.1e}")
    assert errors
    for few, many in zip(errors[: len(errors) // 2], errors[len(errors) // 2 :], strict=True):
        assert few[0] == many[0]
        assert many[2] < 5e-4 or many[2] < 0.6 * few[2], f"{few} {many}"


@pytest.mark.parametrize("name", REAL_FILES)
def test_totals_are_kept(data, name):
    """Evenly diffuse light, through the mean of a matrix over its patches."""
    b = bsdftree.load(data / name, strict=False)
    for band in b.bands:
        first = {k: m for k, m in b.to_klems("full").components_of(band).items()}
        for made in (b.to_klems("half"), b.to_klems("quarter", subdivide=2)):
            for key, matrix in made.components_of(band).items():
                full = first[key]
                light = [areas(m.incident_rings) @ m.values @ areas(m.exitant_rings) for m in (full, matrix)]
                assert light[1] == pytest.approx(light[0], rel=1e-5, abs=1e-9)


def test_colour_is_converted_as_light():
    """Of red and blue halves of a cell, the mean is that of X, Y and Z, not of u' and v'."""
    device = bsdftree.Device.parse(
        "void plastic red 0 0 5 .8 .1 .1 0 0\nred polygon p 0 0 12 0 0 -.01 1 0 -.01 1 1 -.01 0 1 -.01\n"
    )
    b = bsdftree.generate(device, rank=4, log2_res=3, samples=64, color=True)
    klems = b.to_klems("quarter")
    incident = bsdftree.direction_from_polar([10, 40, 60], [0, 30, 200])
    exitant = bsdftree.direction_from_polar([20, 50, 70], [100, 130, 20])
    for made in (klems, klems.to_tree(4, 3), klems.to_tree(3, 3)):
        assert made.chroma_of().keys() == b.components.keys()
        np.testing.assert_allclose(
            made.eval(incident, exitant, color=True), b.eval(incident, exitant, color=True), rtol=0.02
        )


def test_trees_of_matrices_come_nearer_with_resolution(data):
    b = bsdftree.load(data / "frads/blinds30.xml").to_klems("quarter")
    errors = [max(b.distance(b.to_tree(4, n)).values()) for n in (3, 4, 5)]
    assert errors[2] < 0.8 * errors[1] < 0.64 * errors[0]
    assert b.distance(b)["transmission_back"] == 0.0


@needs_radiance
@pytest.mark.parametrize("options", [["--klems", "half"], ["--tree", "--rank", "4", "--log2-res", "4"]])
def test_command_writes_what_radiance_reads(data, tmp_path, options):
    out = tmp_path / "out.xml"
    done = CliRunner().invoke(main, ["convert", str(data / "frads/blinds30.xml"), str(out), *options])
    assert done.exit_code == 0, done.output
    assert "Visible transmission_back: relative L1 error" in done.output
    assert b"Int->Ext Trans" in run("checkBSDF", out)
    before, after = (bsdftree.load(p) for p in (data / "frads/blinds30.xml", out))
    # Even in projected solid angle.
    theta = np.degrees(np.arcsin(np.sqrt((np.arange(400) + 0.5) / 400)))
    incident = bsdftree.direction_from_polar(theta[:, None], np.arange(0.7, 360, 3.0))
    for side in (1, -1):
        totals = [b.hemispherical(incident * [1, 1, side]).mean() for b in (before, after)]
        assert totals[1] == pytest.approx(totals[0], rel=2e-3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--klems", "full", "--tree"], "expected one of them"),
        (["--tree", "--log2-res", "11"], "1<=x<=10"),
        (["--tree", "--rank", "4"], "does not become one of rank 4"),
    ],
)
def test_what_cannot_be_converted_is_said(data, tmp_path, arguments, said):
    out = tmp_path / "out.xml"
    done = CliRunner().invoke(main, ["convert", str(data / "pyradiance/t3.xml"), str(out), *arguments])
    assert done.exit_code in (1, 2) and said in done.output
    assert not out.exists()


def test_isotropic_trees_hold_the_mean_over_turns():
    grid = np.zeros((4, 4, 4, 4), np.float32)
    grid[1, 1] = 1.0
    turned = Bsdf.from_trees({"reflection_back": Tree.from_grid(grid)}).to_klems("full").to_tree(3, 5)
    phi = np.arange(0, 360, 30.0)
    values = turned.hemispherical(bsdftree.direction_from_polar(30, phi))
    assert np.ptp(values) == 0.0 and 0 < values[0] < np.pi
