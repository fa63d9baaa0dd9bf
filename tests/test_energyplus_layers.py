"""Windows of several layers for EnergyPlus: absorptances beside WINDOW's engine, and in EnergyPlus on a clear day."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner
from energyplus_room import WINDOW_AREA, needs_energyplus, simulate, write_model
from test_energyplus import areas_of, values_of

import bsdftree
from bsdftree import Bsdf
from bsdftree.cli import main

GLASS, SCREEN, WOVEN = "pyradiance/clear.xml", "mermet/E_Screen_3pct_White.xml", "bsdfxmlparser/2011-SA1.XML"

# pywincalc ends the process on some files.
WINDOW = """
import pickle, sys, warnings
warnings.simplefilter("ignore")
import numpy as np, pywincalc
layers = [pywincalc.parse_bsdf_xml_file(path) for path in sys.argv[1:]]
gaps = [pywincalc.Gap(pywincalc.PredefinedGasType.AIR, 0.0127) for _ in layers[1:]]
full = pywincalc.BSDFHemisphere.create(pywincalc.BSDFBasisType.FULL)
system = pywincalc.GlazingSystem(solid_layers=layers, gap_layers=gaps, bsdf_hemisphere=full)
found = system.optical_method_results("PHOTOPIC", 0, 0).layer_results
absorbed = [[getattr(layer, side).absorptance.angular_total for side in ("front", "back")] for layer in found]
sys.stdout.buffer.write(b"RESULT" + pickle.dumps(np.array(absorbed)))
"""


@pytest.mark.parametrize("names", [(WOVEN, SCREEN), (SCREEN, WOVEN), (SCREEN, WOVEN, SCREEN)])
def test_absorptances_are_those_of_window(data, names):
    pytest.importorskip("pywincalc", reason="SKIPPED: no pywincalc; pip install pywincalc brings WINDOW's engine")
    paths = [data / name for name in names]
    done = subprocess.run([sys.executable, "-c", WINDOW, *map(str, paths)], capture_output=True, timeout=300)
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    theirs = pickle.loads(done.stdout.partition(b"RESULT")[2])
    ours = bsdftree.layer_absorptances([bsdftree.load(path, strict=False) for path in paths], klems="full")
    assert ours.shape == theirs.shape == (len(names), 2, 145)
    print(f"{len(names)} layers: largest difference {abs(ours - theirs).max():.1e}, largest {theirs.max():.3f}")
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    assert theirs.max() > 0.05


def test_all_light_is_transmitted_reflected_or_absorbed(data):
    layers = [bsdftree.load(data / name, strict=False) for name in (GLASS, WOVEN, SCREEN)]
    made = bsdftree.energyplus(layers, "w")
    areas = areas_of(values_of(made, "w_Basis"))
    whole = bsdftree.stack([layer.to_klems("full") for layer in layers], klems="full").components_of("Solar")
    for side in ("front", "back"):
        left = sum(values_of(made, f"w_layer_{k}_{side[0]}Abs")[0] for k in (1, 2, 3))
        scattered = sum(whole[f"{part}_{side}"].values @ areas for part in ("transmission", "reflection"))
        np.testing.assert_allclose(left + scattered, 1, atol=2e-5)
    np.testing.assert_allclose(
        areas @ values_of(made, "w_TfSol"), whole["transmission_front"].values @ areas, rtol=1e-5
    )


def test_trees_are_stacked_over_cells():
    white = bsdftree.Tree.from_grid(np.full((4,) * 4, 0.25 / np.pi))
    parts = ("transmission_front", "transmission_back", "reflection_front", "reflection_back")
    b = Bsdf.from_trees(dict.fromkeys(parts, white))
    found = bsdftree.layer_absorptances([b, b])
    assert found.shape == (2, 2, 4)
    gap = 1 / (1 - 0.25**2)
    np.testing.assert_allclose(found[0, 0], 0.5 + 0.25 * gap * 0.25 * 0.5, rtol=1e-6)
    np.testing.assert_allclose(found[1, 0], 0.25 * gap * 0.5, rtol=1e-6)
    np.testing.assert_allclose(found[0], found[1, ::-1])


@needs_energyplus
@pytest.mark.parametrize("ending", ["idf", "epJSON"])
@pytest.mark.parametrize("names", [(GLASS, SCREEN), (WOVEN, GLASS, SCREEN)])
def test_energyplus_absorbs_the_sun_in_each_layer_as_we_do(data, tmp_path, names, ending):
    """Of the beam, in the patch where the sun is; of the sky, always the same fraction."""
    made = tmp_path / f"window.{ending}"
    words = ["stack", *(str(data / name) for name in names), "-o", str(made), "--name", "cfs", "--repair"]
    gaps = [word for gap in ("0.0127,Argon", "0.05")[: len(names) - 1] for word in ("--gap", gap)]
    done = CliRunner().invoke(main, [*words, *gaps])
    assert done.exit_code == 0, done.output
    n = len(names)
    errors, steps = simulate(
        write_model(tmp_path / f"model.{ending}", "cfs", made),
        tmp_path,
        "Surface Outside Face Incident Beam Solar Radiation Rate per Area",
        "Surface Outside Face Incident Sky Diffuse Solar Radiation Rate per Area",
        "Surface Outside Face Incident Ground Diffuse Solar Radiation Rate per Area",
        "Site Solar Azimuth Angle",
        "Site Solar Altitude Angle",
        *(f"Surface Window Total Absorbed Shortwave Radiation Rate Layer {k}" for k in range(1, n + 1)),
    )
    assert " ** Severe" not in errors and " 0 Severe Errors" in errors
    found = np.array(steps)
    beam, sky, ground, azimuth, altitude, *absorbed = found[found[:, 0] > 20].T
    layers = [bsdftree.load(data / name, strict=False) for name in names]
    ours = bsdftree.layer_absorptances(layers, "Solar", klems="full")[:, 0]
    patch = patches(layers[0], azimuth, altitude)
    assert len(set(patch)) > 5
    for k in range(n):
        light = np.stack([beam * ours[k, patch], sky, ground], 1) * WINDOW_AREA
        fitted = np.linalg.lstsq(light, absorbed[k], rcond=None)[0]
        left = abs(light @ fitted - absorbed[k])
        print(f"{ending} layer {k + 1}: beam × {fitted[0]:.6f}, sky {fitted[1]:.4f}, left {left.max():.1e} W")
        # A sun next to the border of a patch may be counted to either: the two bases end at rounded angles.
        assert fitted[0] == pytest.approx(1, abs=2e-3)
        assert (left < 1e-4 * absorbed[k].max()).mean() > 0.9


def patches(layer: Bsdf, azimuth: np.ndarray, altitude: np.ndarray) -> np.ndarray:
    """The Klems patches of the sun's light; north is into the room, so that our X is west."""
    azimuth, altitude = np.radians(azimuth), np.radians(altitude)
    east, north, up = np.sin(azimuth) * np.cos(altitude), np.cos(azimuth) * np.cos(altitude), np.sin(altitude)
    rings = layer.to_klems("full").components_of("Solar")["transmission_front"].exitant_rings
    theta, phi = np.degrees(np.arccos(-north)), np.degrees(np.arctan2(-up, east))
    first = np.cumsum([0, *(n for _, _, n in rings)])
    ring = np.searchsorted([high for _, high, _ in rings], theta, side="right").clip(max=len(rings) - 1)
    counts = np.array([n for _, _, n in rings])[ring]
    return first[ring] + np.round(phi / 360 * counts).astype(int) % counts


def test_materials_are_what_the_files_say(data):
    layers = [bsdftree.load(data / name) for name in (GLASS, SCREEN)]
    made = bsdftree.energyplus(layers, "w", gaps=[(0.02, "argon")])
    (glass,) = made["WindowMaterial:Glazing"].values()
    (shade,) = made["WindowMaterial:ComplexShade"].items()
    assert glass["thickness"] == 0.003048 and glass["conductivity"] == 0.9
    assert shade[0] == "w_layer_2"
    assert (shade[1]["thickness"], shade[1]["ir_transmittance"]) == (0.00043, 0.103)
    assert shade[1]["front_opening_multiplier"] == 0.04331
    assert made["WindowMaterial:Gas"]["w_gap_1_gas"] == {"gas_type": "Argon", "thickness": 0.02}
    assert made["Construction:ComplexFenestrationState"]["w"]["gap_1_name"] == "w_gap_1"
    both_glass = bsdftree.energyplus(layers, "w", shades=[False, False])
    assert list(both_glass["WindowMaterial:Glazing"]) == ["w_layer_1", "w_layer_2"]
    assert "WindowMaterial:ComplexShade" not in both_glass
    assert made["Construction:ComplexFenestrationState"]["w"].keys() > {"layer_2_name", "outside_layer_name"}


def test_a_layer_without_solar_has_its_visible_if_told(data):
    screen = bsdftree.load(data / SCREEN)
    layers = [screen.select(bands=["Visible"]), screen]
    with pytest.raises(ValueError, match="no band Solar"):
        bsdftree.energyplus(layers, "w")
    made = bsdftree.energyplus(layers, "w", solar_from_visible=True)
    visible = layers[0].select(rename=("Visible", "Solar"))
    expected = bsdftree.layer_absorptances([visible, screen], "Solar", klems="full")
    np.testing.assert_allclose(values_of(made, "w_layer_1_fAbs")[0], expected[0, 0], atol=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gaps": [0.01, 0.01]}, "2 layers with 2 gaps and 2 shades; expected 1 and 2"),
        ({"shades": [True]}, "2 layers with 1 gaps and 1 shades"),
        ({"gaps": [(0.01, "Steam")]}, "gas 'Steam' of a gap; expected one of Air, Argon"),
        ({"gaps": [0.0]}, "thickness of a gap 0.0; expected a number above 0"),
        ({"thickness": 0.1}, "thickness for 2 layers; expected it in the files"),
    ],
)
def test_what_does_not_go_together_is_refused(data, options, message):
    screen = bsdftree.load(data / SCREEN)
    with pytest.raises(ValueError, match=re.escape(message)):
        bsdftree.energyplus([screen, screen], "w", **options)


@pytest.mark.parametrize(
    ("words", "message", "code"),
    [
        (["{s}"] * 6 + ["-o", "{t}/x.idf", "--name", "w"], "6 layers; expected 1 to 5", 1),
        (["{s}", "{s}", "-o", "{t}/x.xml", "--gap", "0.1"], "--gap is for .idf and .epJSON", 2),
        (["{s}", "{s}", "-o", "{t}/x.idf", "--gap", "wide"], "expected a distance [m]", 2),
        (["{s}", "{s}", "-o", "{t}/x.idf", "--shade", "3"], "--shade 3; there are 2 layers", 2),
        (["{s}", "{s}", "-o", "{t}/x.idf", "--klems", "half"], "EnergyPlus has Klems full", 2),
    ],
)
def test_commands_that_do_not_fit_are_refused(data, tmp_path, words, message, code):
    words = [word.format(s=data / SCREEN, t=tmp_path) for word in words]
    done = CliRunner().invoke(main, ["stack", *words])
    assert done.exit_code == code and message in done.output, done.output
    assert not list(tmp_path.iterdir())
