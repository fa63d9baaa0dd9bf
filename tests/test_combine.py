"""Turned, mirrored, merged and stacked BSDFs; stacks beside WINDOW's own engine and beside tracing all layers."""

from __future__ import annotations

import pickle
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree import Bsdf, Device
from bsdftree.cli import main

# pywincalc ends the process on some files.
WINDOW = """
import pickle, sys, warnings
warnings.simplefilter("ignore")
import numpy as np, pywincalc
layers = [pywincalc.parse_bsdf_xml_file(path) for path in sys.argv[1:]]
gaps = [pywincalc.Gap(pywincalc.PredefinedGasType.AIR, 0.0127) for _ in layers[1:]]
full = pywincalc.BSDFHemisphere.create(pywincalc.BSDFBasisType.FULL)
system = pywincalc.GlazingSystem(solid_layers=layers, gap_layers=gaps, bsdf_hemisphere=full)
found = system.optical_method_results("PHOTOPIC", 0, 0).system_results
matrices = {f"{what}_{side}": np.array(getattr(getattr(found, side), long).matrix)
    for side in ("front", "back") for what, long in (("transmission", "transmittance"), ("reflection", "reflectance"))}
sys.stdout.buffer.write(b"RESULT" + pickle.dumps(matrices))
"""


def window(*paths) -> dict[str, np.ndarray]:
    """Matrices of WINDOW's engine for layers from the outside to the room."""
    pytest.importorskip("pywincalc", reason="SKIPPED: no pywincalc; pip install pywincalc brings WINDOW's engine")
    done = subprocess.run([sys.executable, "-c", WINDOW, *map(str, paths)], capture_output=True, timeout=200)
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    return pickle.loads(done.stdout.partition(b"RESULT")[2])


@pytest.mark.parametrize("names", [("bsdfxmlparser/2011-SA1.XML", "mermet/E_Screen_3pct_White.xml")])
@pytest.mark.parametrize("order", [1, -1])
def test_stack_is_that_of_window(data, names, order):
    paths = [data / name for name in names][::order]
    theirs = window(*paths)
    ours = bsdftree.stack([bsdftree.load(path, strict=False) for path in paths])
    for key, matrix in ours.components.items():
        light = matrix.values.sum()
        errors = [abs(matrix.values - m).sum() / light for m in (theirs[key].T, theirs[key])]
        print(f"{key}: relative L1 {errors[0]:.2e} (transposed {errors[1]:.2e})")
        assert errors[0] < 2e-3


def test_stack_is_what_tracing_both_layers_finds():
    """A diffuser close to another."""
    white = "void trans white 0 0 7 .8 .8 .8 0 0 .5 0\n"
    pane = "white polygon {0} 0 0 12 0 0 {1} 1 0 {1} 1 1 {1} 0 1 {1}\n"
    options = dict(klems="quarter", samples=3000, seed=5)
    layers = [
        bsdftree.generate(Device.parse(text), **options)
        for text in (white + pane.format("a", -0.1), white + pane.format("b", -0.2))
    ]
    both = bsdftree.generate(Device.parse(white + pane.format("a", -0.1) + pane.format("b", -0.10001)), **options)
    stacked = bsdftree.stack(layers[::-1])
    incident = bsdftree.direction_from_polar([[15], [45], [70], [110], [150]], np.arange(10, 360, 45))
    for part in ("reflection", "transmission"):
        np.testing.assert_allclose(
            stacked.hemispherical(incident, part), both.hemispherical(incident, part), atol=0.012
        )


def test_stack_of_trees_is_that_of_matrices():
    options = dict(seed=3, samples=256)
    blinds, sheet = (Device.from_spec(s) for s in ("blinds:angle=45", "perforated"))
    trees = bsdftree.stack([bsdftree.generate(d, rank=4, log2_res=4, **options) for d in (blinds, sheet)])
    klems = bsdftree.stack([bsdftree.generate(d, klems="full", **options) for d in (blinds, sheet)])
    theta = np.degrees(np.arcsin(np.sqrt((np.arange(40) + 0.5) / 40)))
    incident = bsdftree.direction_from_polar(theta[:, None], np.arange(4, 360, 9.0))
    for side in (1, -1):
        for part in ("reflection", "transmission"):
            totals = [b.hemispherical(incident * [1, 1, side], part).mean() for b in (trees, klems)]
            assert totals[0] == pytest.approx(totals[1], abs=0.01), (side, part)


def test_colour_is_stacked_as_red_green_and_blue():
    def layer(r, g, b):
        text = f"void trans t 0 0 7 {r} {g} {b} 0 0 1 0\nt polygon p 0 0 12 0 0 -.1 1 0 -.1 1 1 -.1 0 1 -.1\n"
        return bsdftree.generate(Device.parse(text), klems="quarter", samples=500, color=True)

    stacked = bsdftree.stack([layer(0.8, 0.4, 0.2), layer(0.5, 0.9, 0.3)])
    xyz = stacked.eval([0, 0.6, 0.8], [0, 0.6, -0.8], color=True)
    expected = np.array(bsdftree._core.XYZ_FROM_RGB) @ [0.4, 0.36, 0.06] / np.pi
    np.testing.assert_allclose(xyz, expected, rtol=0.03)


def test_turns_of_a_device_are_turns_of_its_bsdf():
    """By a quarter, and by 30°, which no basis has."""
    plain = bsdftree.generate(Device.from_spec("blinds:angle=40"), klems="quarter", samples=2000, seed=2)
    quarter = plain.rotated(90)
    incident = bsdftree.direction_from_polar([[20], [50], [75]], np.arange(0, 360, 30.0))
    x, y, z = np.moveaxis(incident, -1, 0)
    np.testing.assert_allclose(
        quarter.hemispherical(incident), plain.hemispherical(np.stack([y, -x, z], -1)), rtol=1e-6
    )
    any_turn = plain.rotated(30)
    means = [b.hemispherical(bsdftree.direction_from_polar(50, np.arange(0.5, 360))).mean() for b in (plain, any_turn)]
    assert means[1] == pytest.approx(means[0], rel=1e-3)
    assert max(plain.distance(any_turn.rotated(-30)).values()) < max(plain.distance(any_turn).values())


def test_a_device_turned_round_is_its_other_side(data):
    b = bsdftree.load(data / "frads/blinds30.xml")
    flipped = b.flipped()
    assert flipped.geometry is None
    i, o = bsdftree.direction_from_polar([20, 50], [40, 100]), bsdftree.direction_from_polar([130, 60], [10, 200])
    turned = [-1, 1, -1]
    np.testing.assert_allclose(flipped.eval(i, o), b.eval(i * turned, o * turned))
    np.testing.assert_allclose(b.mirrored("x").eval(i, o), b.eval(i * [-1, 1, 1], o * [-1, 1, 1]))


def test_commands_move_merge_and_stack(data, tmp_path):
    blinds, screen = data / "frads/blinds30.xml", data / "mermet/E_Screen_3pct_White.xml"

    def invoke(*words):
        done = CliRunner().invoke(main, [str(word) for word in words])
        assert done.exit_code == 0, done.output
        return done.output

    invoke("convert", blinds, tmp_path / "flipped.xml", "--flip", "--mirror", "y")
    assert "turned there and back" in invoke("convert", blinds, tmp_path / "turned.xml", "--rotate", 20)
    invoke("merge", f"{blinds}:reflection", f"{tmp_path / 'turned.xml'}:transmission", "-o", tmp_path / "merged.xml")
    merged, original = (bsdftree.load(p) for p in (tmp_path / "merged.xml", blinds))
    assert merged.components.keys() == original.components.keys()
    said = invoke("merge", blinds, f"{screen}:front,back@Solar", "-o", tmp_path / "bands.xml")
    assert bsdftree.load(tmp_path / "bands.xml").bands == ["Visible", "Solar"], said
    said = invoke("stack", screen, blinds, "-o", tmp_path / "stack.xml")
    assert "left out, since not all layers have it: Solar" in said
    assert len(bsdftree.load(tmp_path / "stack.xml").components) == 4


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["merge", "{0}", "{0}", "-o", "{out}"], "choose which one to take"),
        (["merge", "{0}:reflections", "-o", "{out}"], "expected one of reflection"),
        (["merge", "{0}:reflection", "{1}:transmission", "-o", "{out}"], "convert one of them first"),
        (["stack", "{0}", "{1}", "-o", "{out}", "--log2-res", "4", "--klems", "full"], "expected one of them"),
        (["stack", "{1}", "{1}", "-o", "{out}", "--log2-res", "4"], "does not become one of rank 4"),
    ],
)
def test_what_does_not_fit_is_said(data, tmp_path, words, said):
    names = [data / "frads/blinds30.xml", data / "pyradiance/t3.xml"]
    done = CliRunner().invoke(main, [word.format(*names, out=tmp_path / "out.xml") for word in words])
    assert done.exit_code == 1 and said in done.output, done.output
    assert not list(tmp_path.iterdir())


def test_merging_warns_of_too_much_light():
    white = bsdftree.Tree.from_grid(np.full((1, 1, 1, 1), 0.7 / np.pi))
    parts = [Bsdf.from_trees({key: white}) for key in ("reflection_back", "transmission_back")]
    with pytest.warns(UserWarning, match=r"140.0 % of the light from the front leaves"):
        bsdftree.merge(parts)
