"""Specular peaks: of generated devices, whose optics are known, and of real files."""

import dataclasses
import json

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree.cli import main

# Components of each real file that have peaks, by kind; every other readable file has none.
REAL = {
    "clear.xml": {"reflection_front": "mirror", "reflection_back": "mirror"}
    | {"transmission_front": "straight", "transmission_back": "straight"},
    "ven45.xml": {"reflection_front": "mirror", "transmission_front": "straight", "transmission_back": "straight"},
    "blinds.xml": {"reflection_front": "mirror", "reflection_back": "mirror"}
    | {"transmission_front": "straight", "transmission_back": "straight"},
    "blindsT3.xml": {"reflection_front": "mirror", "reflection_back": "mirror"}
    | {"transmission_front": "straight", "transmission_back": "straight"},
    "t3.xml": {"transmission_back": "straight"},
    "blinds30.xml": {"reflection_back": "mirror", "transmission_back": "straight"},
    "ec60.xml": {"transmission_front": "straight", "transmission_back": "straight"},
    "E_Screen_3pct_White.xml": {"transmission_front": "straight", "transmission_back": "straight"},
    "2011-SA1.XML": {"transmission_front": "straight", "transmission_back": "straight"},
    "simple_klems_through_trans.xml": {"transmission_front": "straight", "transmission_back": "straight"},
    "sawtooth.xml": {"reflection_back": "facet"},
}


def real_files(data):
    paths = (p for p in data.glob("*/*") if p.suffix.lower() == ".xml" and "Small" not in p.name)
    return {p.name: p for p in paths}


def run(*args):
    return CliRunner().invoke(main, [str(a) for a in args])


def angle_deg(a, b):
    return np.degrees(np.arccos(np.clip(np.dot(a, b), -1, 1)))


def strongest(families):
    """The kind with the most light in each component."""
    kinds = {}
    for family in families:
        kinds.setdefault(family.component, family.kind)
    return kinds


def test_real_files_have_the_peaks_that_their_products_have(data):
    files = real_files(data)
    assert len(files) == 18
    for name, path in files.items():
        assert strongest(bsdftree.load(path, strict=False).peaks()) == REAL.get(name, {}), name


def test_fabrics_transmit_their_openness_straight_through(data):
    # Both are screens of 3 %: light at the normal that meets no yarn.
    for name in ("mermet/E_Screen_3pct_White.xml", "bsdfxmlparser/2011-SA1.XML"):
        families = bsdftree.load(data / name).peaks()
        assert {f.kind for f in families} == {"straight"}
        for family in families:
            assert 0.03 < family.strength_at(0) < 0.05
            assert family.strength_at(60) < family.strength_at(0)
            assert family.n_found > 0.9 * family.n_directions == 0.9 * 145


def test_glazing_lets_through_in_its_peak_all_that_it_lets_through(data):
    b = bsdftree.load(data / "pyradiance" / "clear.xml")
    for family in b.peaks():
        incident = [peak.incident for peak in family.peaks]
        part = "reflection" if family.kind == "mirror" else "transmission"
        totals = b.hemispherical(incident, part)
        np.testing.assert_allclose([peak.strength for peak in family.peaks], totals, rtol=1e-3)


def test_radiances_sawtooth_has_the_facets_of_its_profile(data):
    # sawtooth.pts: (0, 1) to (2, 2), a slope of one half.
    family = bsdftree.load(data / "radiance" / "sawtooth.xml").peaks()[0]
    tilt = np.arctan(0.5)
    assert angle_deg(family.normal, [-np.sin(tilt), 0, np.cos(tilt)]) < 1.0


def test_a_mirror_has_one_peak_of_its_reflectance_at_every_resolution():
    device = bsdftree.Device.from_spec("mirror:reflectance=0.85")
    for options in ({"rank": 3, "log2_res": 4}, {"rank": 4, "log2_res": 3}, {"klems": "full"}):
        (family,) = bsdftree.generate(device, samples=64, **options).peaks()
        assert (family.component, family.kind) == ("reflection_back", "mirror")
        assert family.n_found == family.n_directions
        assert family.resolution_limited
        np.testing.assert_allclose(family.strength_range, 0.85, rtol=1e-4)


def test_a_sheet_of_glass_reflects_and_transmits_as_fresnel_says(tmp_path):
    scene = tmp_path / "pane.rad"
    scene.write_text("void glass g 0 0 3 1 1 1\ng polygon p 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n")
    families = bsdftree.generate(scene, log2_res=4, samples=500).peaks()
    assert {(f.component, f.kind) for f in families} == {
        ("reflection_front", "mirror"), ("reflection_back", "mirror"),
        ("transmission_front", "straight"), ("transmission_back", "straight"),
    }  # fmt: skip
    # At the normal: r = ((n - 1) / (n + 1))^2 at each face, all reflections inside summed; Radiance's index is 1.52.
    r = (0.52 / 2.52) ** 2
    for family in families:
        expected = 2 * r / (1 + r) if family.kind == "mirror" else (1 - r) / (1 + r)
        # 64 cells within 30°, of 500 paths each: 4 standard errors.
        assert abs(family.strength_at(0) - expected) < 4 * np.sqrt(0.25 / 500 / 4)
        assert family.residual_deg < 0.2


def test_sawtooth_has_the_normal_of_its_mirror_facets():
    for valley in (0.5, 0.7):
        # The facet that faces up goes from the lower peak to the valley: depth 0.01 over valley · period.
        device = bsdftree.Device.from_spec(f"sawtooth:valley={valley}")
        b = bsdftree.generate(device, log2_res=5, samples=200, tile=True)
        family = b.peaks()[0]
        tilt = np.arctan(0.01 / (valley * 0.02))
        assert family.kind == "facet"
        assert angle_deg(family.normal, [0, np.sin(tilt), np.cos(tilt)]) < 0.5, valley
        totals = b.hemispherical([peak.incident for peak in family.peaks], "reflection")
        assert (np.array([peak.strength for peak in family.peaks]) <= totals * (1 + 1e-6)).all()


def test_prism_has_its_facets_its_index_and_several_peaks_at_once():
    families = bsdftree.generate(bsdftree.Device.from_spec("prism"), log2_res=5, samples=500, tile=True).peaks()
    prisms = [f for f in families if f.kind == "prism" and f.mean_strength > 0.3]
    assert [f.component for f in prisms] == ["transmission_front"] * 2 + ["transmission_back"] * 2
    assert [f.flat_first for f in prisms] == [True, True, False, False]
    for family in prisms:
        assert angle_deg(family.normal, [0, np.sign(family.normal[1]) * np.sqrt(0.5), np.sqrt(0.5)]) < 2.0
        assert abs(family.index - 1.49) < 0.05
        assert family.residual_deg < 2.0
    assert {np.sign(f.normal[1]) for f in prisms[:2]} == {-1, 1}
    # Retroreflected across the grooves by total reflection at both facets.
    front = next(f for f in families if f.component == "reflection_front")
    assert front.kind == "groove" and abs(front.axis[0]) > 0.999


def test_diffuse_and_glossy_surfaces_have_no_peaks(tmp_path):
    square = "p polygon q 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"
    for material in ("void plastic p 0 0 5 .6 .6 .6 0 0\n", "void metal p 0 0 5 .8 .8 .8 .9 .25\n"):
        scene = tmp_path / "flat.rad"
        scene.write_text(material + square)
        for options in ({"rank": 3, "log2_res": 5}, {"log2_res": 4}, {"klems": "full"}):
            assert bsdftree.generate(scene, samples=200, **options).peaks() == [], (material, options)


def test_peaks_can_be_evaluated_where_they_are(data):
    b = bsdftree.load(data / "pyradiance" / "blindsT3.xml")
    for family in b.peaks():
        for peak in family.peaks:
            assert b.eval(peak.incident, peak.exitant) > 10 * peak.surround


def test_families_are_frozen_and_arguments_are_checked():
    b = bsdftree.Bsdf.from_trees({"reflection_back": bsdftree.Tree.from_grid(np.full((2, 2, 2, 2), 0.1))})
    assert b.peaks() == []
    for wrong in ({"contrast": 1.0}, {"contrast": float("nan")}, {"min_strength": 0.0}, {"min_strength": 1.5}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            b.peaks(**wrong)
    with pytest.raises(ValueError, match="Solar"):
        b.peaks(band="Solar")
    peak = bsdftree.Peak((0, 0, 1), (0, 0, 1), 0.5, 0.0, 0.1, 1.0, True)
    with pytest.raises(dataclasses.FrozenInstanceError):
        peak.strength = 1.0


def test_info_prints_peaks_and_what_to_do(data):
    result = run("info", "--peaks", data / "mermet" / "E_Screen_3pct_White.xml")
    assert result.exit_code == 0, result.output
    assert result.output.count("straight through") == 4  # two components, Visible and Solar
    assert result.output.count("aBSDF") == 1
    assert "…" not in result.output
    without = run("info", data / "mermet" / "E_Screen_3pct_White.xml")
    assert "peak" not in without.output.lower()
    nothing = run("info", "--peaks", data / "radiance" / "testBSDF.xml")
    assert nothing.exit_code == 0 and "No specular peaks" in nothing.output and "aBSDF" not in nothing.output


def test_info_json_carries_every_peak(data):
    path = data / "pyradiance" / "blinds.xml"
    summary = json.loads(run("info", "--peaks", "--json", path).stdout)
    families = summary["bands"][0]["peaks"]
    assert "peaks" not in json.loads(run("info", "--json", path).stdout)["bands"][0]
    for family in families:
        assert set(family) == {
            "component", "kind", "normal", "axis", "index", "flat_first", "shift", "residual_deg", "n_directions",
            "n_found", "theta_deg", "strength", "strength_by_theta_deg", "width_deg", "resolution_limited", "peaks",
        }  # fmt: skip
        assert family["strength"]["min"] <= family["strength"]["mean"] <= family["strength"]["max"]
        assert set(family["strength_by_theta_deg"]) == {"0", "30", "60"}
        assert all(0.002 <= peak["strength"] <= 1 for peak in family["peaks"])
        # The angles are those that eval takes.
        peak = family["peaks"][0]
        angles = [peak[f"{d}_{a}_deg"] for d in ("incident", "exitant") for a in ("theta", "phi")]
        assert float(run("eval", path, *angles).stdout) > 10 * peak["surround"]


def test_info_lists_weaker_peaks_when_asked(data):
    path = data / "mermet" / "E_Screen_3pct_White.xml"
    assert "straight through" not in run("info", "--peaks", "--min-strength", "10", path).output
    assert run("info", "--peaks", "--min-strength", "0", path).exit_code == 2
    assert run("info", "--peaks", "missing.xml").exit_code == 1
