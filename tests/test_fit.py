"""Fits of measurements: what they keep, what they refuse, what the verb says of them."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree import Measurement, Tree, direction_from_polar, errors_by_flux
from bsdftree.cli import main

LOFT = "ua-loft/processed"


def hemisphere(n=400, side=1.0, below=80):
    """Directions spread evenly over projected solid angle, down to a polar angle (Vogel's spiral), (n, 3)."""
    k = np.arange(n) + 0.5
    theta = np.degrees(np.arcsin(np.sqrt(k / n) * np.sin(np.radians(below))))
    return direction_from_polar(theta, np.degrees(k * np.pi * (3 - np.sqrt(5)))) * [1, 1, side]


def mirrored(incident):
    return incident * np.array([-1, -1, 1])


def gloss(incident, exitant, across=1.0):
    """A lobe about the mirror direction, `across` times as wide along X as along Y, on a diffuse base [1/sr]."""
    off = (exitant - mirrored(incident)) / [across, 1, 1]
    return 0.08 + 0.5 * np.exp(-6 * (off**2).sum(axis=-1))


def ring_scans(f, thetas=(0, 20, 40, 60), azimuths=range(0, 360, 45), n=400, rng=None):
    """Scans all around, with 2 % noise if there are random numbers."""
    scans = []
    for theta in thetas:
        for phi in azimuths if theta else [0]:
            incident, exitant = direction_from_polar(theta, phi), hemisphere(n)
            values = f(incident, exitant)
            noise = 1 if rng is None else 1 + 0.02 * rng.standard_normal(values.shape)
            scans.append((incident, exitant, values * noise))
    return scans


def line_scans(f, thetas=(0, 15, 30, 45, 60, 75), n=400):
    return ring_scans(f, thetas, [180], n)


@pytest.fixture(scope="module")
def glossy():
    return bsdftree.fit(Measurement(line_scans(gloss), name="gloss"))


@pytest.fixture
def run():
    def run(*args):
        return CliRunner().invoke(main, [str(a) for a in args], catch_exceptions=False)

    return run


@pytest.mark.parametrize("symmetry", ["isotropic", "quadrilateral", "anisotropic"])
def test_constants_stay_constant(symmetry, rng):
    fitted = bsdftree.fit(Measurement(ring_scans(lambda i, o: np.full(len(o), 0.2))), symmetry=symmetry)
    incident, exitant = rng.normal(size=(2, 500, 3))
    incident[:, 2], exitant[:, 2] = np.abs(incident[:, 2]), np.abs(exitant[:, 2])
    np.testing.assert_allclose(fitted.eval(incident, exitant), 0.2, rtol=2e-3)
    tree = fitted.bsdf(log2_res=3).components["reflection_back"]
    values = tree.leaves()[2]
    np.testing.assert_allclose(values[values > 0], 0.2, rtol=2e-3)


def test_directions_between_scans_are_near_the_truth(glossy):
    exitant = hemisphere(500)
    for theta in (7, 22, 37, 52, 67):
        incident = direction_from_polar(theta, 180)
        true = gloss(incident, exitant)
        assert np.abs(glossy.eval(incident, exitant) - true).sum() < 0.04 * true.sum()


def test_totals_are_those_that_were_measured(glossy):
    trees = glossy.trees(log2_res=7)
    everywhere = hemisphere(20_000, below=90)
    for row in glossy.summary(trees).parts[0].totals:
        if row.n_points:
            true = np.pi * gloss(direction_from_polar(row.theta_deg, 180), everywhere).mean()
            assert row.measured == pytest.approx(true, rel=0.01)
            assert row.fitted == pytest.approx(row.measured, rel=0.015)
    at_grazing = trees.bsdf.hemispherical(direction_from_polar([80, 85, 89], 180), "reflection")
    assert np.all(at_grazing <= 1 + 1e-6)


def test_reflection_and_transmission_are_at_most_all_light():
    """What was measured is 30 % too bright: 0.65 π/π on either side."""
    both = np.concatenate([hemisphere(), hemisphere(side=-1)])
    scans = [(direction_from_polar(t, 180), both, np.full(len(both), 0.65 / np.pi)) for t in (0, 30, 60)]
    fitted = bsdftree.fit(Measurement(scans), symmetry="isotropic")
    assert list(fitted.recipes) == ["reflection_back", "transmission_back"]
    bsdf = fitted.bsdf(log2_res=4)
    incident = direction_from_polar(np.arange(1, 90, 4), 180)
    total = bsdf.hemispherical(incident, "reflection") + bsdf.hemispherical(incident, "transmission")
    np.testing.assert_allclose(total, 1, rtol=1e-5)


def test_isotropic_samples_are_found_and_others_are_not(rng):
    turning = Measurement(ring_scans(gloss, n=200, rng=rng))
    assert bsdftree.fit(turning).symmetry == "isotropic"
    brushed = Measurement(ring_scans(lambda i, o: gloss(i, o, across=2.5), n=200, rng=rng))
    found = bsdftree.fit(brushed)
    assert found.symmetry == "quadrilateral", found.symmetry_errors
    assert found.symmetry_errors["isotropic"] > 1.5 * found.symmetry_errors["anisotropic"]


def error_at(fitted, f, thetas, phi=180.0, side=1.0):
    """Mean relative L1 error over incident directions of one azimuth; `f` sees all light as reflected."""
    exitant, errors = hemisphere(2000, below=88), []
    for theta in thetas:
        incident = direction_from_polar(theta, phi)
        true = f(incident, exitant)
        errors.append(np.abs(fitted.eval(incident, exitant * [1, 1, side]) - true).sum() / true.sum())
    return np.mean(errors)


@pytest.mark.parametrize("azimuths", [[180], range(0, 360, 45)])
def test_swapped_pairs_help_where_reciprocity_holds(azimuths, rng):
    """Between scans, and more so beyond the last."""
    scans = Measurement(ring_scans(sheen, azimuths=azimuths, n=1000, rng=rng))
    symmetry = "isotropic" if len(azimuths) == 1 else "anisotropic"
    with_, without = (bsdftree.fit(scans, symmetry=symmetry, reciprocal=r) for r in (None, False))
    found = with_.reciprocity["reflection_back"]
    assert found.holds and found.difference < 0.03 and with_.recipes["reflection_back"][0].reciprocal
    assert without.reciprocity["reflection_back"] == found
    assert not any(recipe.reciprocal for recipe in without.recipes["reflection_back"])
    between = [error_at(fitted, sheen, (10, 30, 50), 200) for fitted in (with_, without)]
    assert between[0] < 0.98 * between[1], between
    beyond = [error_at(fitted, sheen, (72, 80)) for fitted in (with_, without)]
    assert beyond[0] < 0.8 * beyond[1], beyond
    # At a scan its own points count, but for some beside which there are none.
    for incident, exitant, values in scans_of(scans):
        mine, alone = with_.eval(incident, exitant), without.eval(incident, exitant)
        assert np.mean(np.abs(mine - alone) > 0.02 * alone) < 0.02
        assert np.abs(mine - values).sum() < 0.03 * values.sum()


def sheen(incident, exitant):
    """Gloss that grows towards grazing, for swapped pairs alike."""
    grazing = 1 - np.sqrt(np.abs(incident[..., 2] * exitant[..., 2]))
    return gloss(incident, exitant) * (1 + 3 * grazing**2)


def scans_of(measurement):
    return [(scan.incident, scan.exitant, scan.values) for scan in measurement.scans]


def test_swapped_pairs_are_refused_where_reciprocity_does_not_hold(run, tmp_path):
    scans = Measurement(line_scans(lambda i, o: gloss(i, o) * (0.4 + o[..., 2])))
    fitted = bsdftree.fit(scans)
    found = fitted.reciprocity["reflection_back"]
    assert not found.holds and found.difference > 3 * found.expected
    assert not any(recipe.reciprocal for recipe in fitted.recipes["reflection_back"])
    assert bsdftree.fit(scans, reciprocal=True).recipes["reflection_back"][0].reciprocal
    done = run("fit", *scans.save(tmp_path), "-o", tmp_path / "out.xml", "--log2-res", "3")
    assert "reciprocity: does not hold, and is not used" in done.output


def test_transmission_is_swapped_with_that_of_the_other_side():
    """From above it depends on the incident direction as from below on the exitant one."""

    def above(i, o):
        return sheen(i, o) * (0.4 + np.abs(i[..., 2]))

    def below(i, o):
        return above(o, i)

    scans = []
    for f, side, thetas in ((above, 1, (0, 20, 40, 60)), (below, -1, (10, 30, 50, 70))):
        for incident, exitant, values in line_scans(f, thetas, n=1000):
            scans.append((incident * [1, 1, side], exitant * [1, 1, -side], values))
    with_, without = (bsdftree.fit(Measurement(scans), reciprocal=r) for r in (None, False))
    assert set(with_.reciprocity) == {"transmission_back", "transmission_front"}
    for part, found in with_.reciprocity.items():
        assert found.holds and with_.recipes[part][0].reciprocal
    errors = [error_at(fitted, above, (10, 30, 50, 65), side=-1) for fitted in (with_, without)]
    assert errors[0] < 0.8 * errors[1], errors
    one_side = Measurement([scan for scan in scans if scan[0][2] > 0])
    assert bsdftree.fit(one_side).reciprocity == {"transmission_back": None}
    with pytest.raises(ValueError, match="the light that goes back was not measured"):
        bsdftree.fit(one_side, reciprocal=True)


def test_stated_symmetry_is_taken_and_given_symmetry_wins():
    stated = Measurement(line_scans(gloss), symmetry="bilateral_x")
    assert bsdftree.fit(stated).symmetry == "bilateral_x"
    assert bsdftree.fit(stated, symmetry="isotropic").symmetry_reason == "given"


def test_what_is_assumed_is_said_to_be():
    quadrant = ring_scans(lambda i, o: gloss(i, o, across=2.5), thetas=(20, 50), azimuths=(180, 210, 240, 270), n=150)
    assumed = bsdftree.fit(Measurement(quadrant))
    assert assumed.symmetry == "quadrilateral" and not assumed.symmetry_errors
    assert assumed.symmetry_reason.startswith(
        "assumed, not tested: incident directions lie in one quadrant, and scans differ from such images as there are"
    )
    between = ring_scans(lambda i, o: gloss(i, o, across=2.5), thetas=(20, 50), azimuths=(200, 230, 260), n=150)
    assert "no scan has an image to be compared with" in bsdftree.fit(Measurement(between)).symmetry_reason
    line = bsdftree.fit(Measurement(line_scans(gloss, n=150)))
    assert line.symmetry_reason.startswith("assumed, not tested: incident directions lie on one azimuth, and scans")


def test_errors_lie_in_the_cells_of_the_values(glossy):
    bsdf, errors = glossy.trees(log2_res=5)
    tree, of_tree = (b.components["reflection_back"] for b in (bsdf, errors))
    for a, b in zip(tree.leaves()[:2], of_tree.leaves()[:2], strict=True):
        np.testing.assert_array_equal(a, b)
    values, sigma = tree.leaves()[2], of_tree.leaves()[2]
    assert np.all(sigma[values > 0] > 0) and np.all(np.isfinite(sigma))
    assert any("Standard errors" in line for line in errors.provenance)


def test_errors_grow_outside_of_what_was_measured(glossy):
    exitant = hemisphere(200)
    inside, outside = (direction_from_polar(theta, 180) for theta in (70, 88))
    relative = [np.mean(glossy.error(i, exitant) / glossy.eval(i, exitant)) for i in (inside, outside)]
    assert relative[1] > 2 * relative[0]


def test_two_errors_on_either_side_hold_the_truth(rng):
    fitted = bsdftree.fit(Measurement(ring_scans(gloss, azimuths=[180], rng=rng), symmetry="isotropic"))
    exitant, covered = hemisphere(2000), []
    for theta in (10, 30, 50):
        incident = direction_from_polar(theta, 180)
        true = gloss(incident, exitant)
        within = np.abs(fitted.eval(incident, exitant) - true) <= 2 * fitted.error(incident, exitant)
        covered.append(true[within].sum() / true.sum())
    assert np.mean(covered) > 0.9, covered


def test_error_by_flux_is_that_of_its_leaves():
    values, errors = np.full((2, 2, 2, 2), 0.1), np.full((2, 2, 2, 2), 0.01)
    values[0, 0], errors[0, 0] = 0.3, 0.15
    of_values, of_errors = (bsdftree.Bsdf.from_trees({"reflection_back": Tree.from_grid(a)}) for a in (values, errors))
    known = errors_by_flux(of_values, of_errors)["reflection_back"]
    assert known.mean == pytest.approx((0.75 * 0.01 + 0.25 * 0.15) / 0.15)
    assert known.uncertain == pytest.approx(0.5)
    with pytest.raises(ValueError, match="other cells"):
        errors_by_flux(of_values, bsdftree.Bsdf.from_trees({"reflection_back": Tree.from_grid([[[[0.1]]]])}))
    with pytest.raises(ValueError, match="have no tree of reflection_back"):
        errors_by_flux(of_values, bsdftree.Bsdf.from_trees({"reflection_front": Tree.from_grid(errors)}))


def test_rank_3_weighs_cells_by_projected_solid_angle():
    """A leaf from sin θ = 1 to ½ stands for three quarters of the light."""
    values, errors = np.full((4, 1, 1), 0.1), np.full((4, 1, 1), 0.01)
    values = np.tile(values, (1, 4, 4))
    errors = np.tile(errors, (1, 4, 4))
    values[1], errors[1] = 0.101, 0.101
    of_values, of_errors = (bsdftree.Bsdf.from_trees({"reflection_back": Tree.from_grid(a)}) for a in (values, errors))
    known = errors_by_flux(of_values, of_errors)["reflection_back"]
    assert known.uncertain == pytest.approx(0.25 * 0.101 / (0.75 * 0.1 + 0.25 * 0.101), rel=1e-5)


def test_colour_gives_colour():
    def colored(incident, exitant):
        return gloss(incident, exitant)[:, None] * [0.9, 1.0, 0.5]

    fitted = bsdftree.fit(Measurement(line_scans(colored)))
    incident, exitant = direction_from_polar(30, 180), hemisphere(50)
    values = fitted.eval(incident, exitant)
    assert values.shape == (50, 3)
    np.testing.assert_allclose(values / values[:, 1:2], np.tile([0.9, 1.0, 0.5], (50, 1)), rtol=0.02)
    assert fitted.error(incident, exitant).shape == (50,)
    bsdf = fitted.bsdf(log2_res=4)
    xyz = bsdf.eval(incident, exitant, color=True)
    np.testing.assert_allclose(xyz / xyz[:, 1:2], np.tile([0.9, 1.0, 0.5], (50, 1)), rtol=0.05)


def test_input_that_cannot_be_fitted_is_refused(glossy):
    up, exitant = [0, 0, 1], hemisphere(50)
    with pytest.raises(ValueError, match="no scans"):
        bsdftree.fit(Measurement([]))
    with pytest.raises(ValueError, match=r"2 points on the side of reflection_back; expected 3"):
        bsdftree.fit(Measurement([(up, exitant[:2], [0.1, 0.1])]))
    with pytest.raises(ValueError, match="reflection_back is black"):
        bsdftree.fit(Measurement([(up, exitant, np.zeros(50))]))
    with pytest.raises(ValueError, match="log2_res is 10; expected 1 to 9 at rank 3"):
        glossy.bsdf(log2_res=10)
    with pytest.raises(ValueError, match="log2_res is 8; expected 1 to 7 at rank 4"):
        glossy.bsdf(rank=4, log2_res=8)
    with pytest.raises(ValueError, match="rank"):
        glossy.bsdf(rank=5)
    askew = bsdftree.fit(Measurement(line_scans(gloss)), symmetry="bilateral_x")
    with pytest.raises(ValueError, match="a tree of rank 3 is isotropic, but the sample is bilateral_x; use rank 4"):
        askew.bsdf(rank=3)
    with pytest.raises(ValueError, match="direction has no length"):
        glossy.eval([0, 0, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="expected"):
        bsdftree.fit(Measurement(line_scans(gloss)), frame="sideways")


def test_what_progress_raises_stops_the_fit(glossy):
    class Enough(Exception):
        pass

    def stop(done, total):
        raise Enough

    with pytest.raises(Enough):
        glossy.trees(rank=4, log2_res=6, progress=stop)
    with pytest.raises(Enough):
        bsdftree.fit(glossy.measurement, progress=stop)


def test_a_fit_tells_how_far_it_is():
    told = []
    fitted = bsdftree.fit(Measurement(ring_scans(gloss)), progress=lambda *counts: told.append(counts))
    done, totals = zip(*told, strict=True)
    assert sorted(done) == list(done) and len(set(done)) > 2
    # Five frames with each symmetry, sixteen recipes, what is done with the best, and swapped pairs.
    assert set(totals) - {0} == {5 * len(fitted.symmetry_errors) + 16 + 2} and done[-1] <= totals[-1]


SCRIPT = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
from test_fit import gloss, ring_scans
import bsdftree
scans = ring_scans(lambda i, o: gloss(i, o, 2.0), (0, 40), n=120)
for reciprocal in (False, True):
    fitted = bsdftree.fit(bsdftree.Measurement(scans), symmetry="quadrilateral", reciprocal=reciprocal)
    bsdf, errors = fitted.trees(log2_res=4)
    print(hashlib.sha256((bsdf.to_xml() + errors.to_xml()).encode()).hexdigest())
"""


def test_any_number_of_threads_gives_the_same_bits():
    def digest(threads):
        environment = os.environ | {"RAYON_NUM_THREADS": str(threads)}
        return subprocess.check_output([sys.executable, "-c", SCRIPT, os.path.dirname(__file__)], env=environment)

    assert digest(1) == digest(2)


INTERRUPTED = """
import os, signal, sys
from bsdftree.cli import _progress, main
doing = sys.argv[1]
_progress.WorkBar.update = lambda bar, *_: doing in bar._doing and os.kill(os.getpid(), signal.SIGINT)
main(sys.argv[2:])
"""


@pytest.mark.skipif(os.name != "posix", reason="SIGINT to a process is of POSIX")
@pytest.mark.parametrize("doing", ["trying", "trees"])
def test_ctrl_c_leaves_no_file(tmp_path, doing):
    paths = Measurement(line_scans(gloss)).save(tmp_path / "scans")
    words = ["fit", *map(str, paths), "-o", str(tmp_path / "out.xml"), "--rank", "4", "--log2-res", "6"]
    process = subprocess.run([sys.executable, "-c", INTERRUPTED, doing, *words], capture_output=True, text=True)
    assert process.returncode == 1 and "Traceback" not in process.stderr and "Aborted" in process.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["scans"]


def test_fit_says_what_it_is(glossy):
    text = repr(glossy)
    assert "'gloss', 6 scans, 2400 points" in text
    assert "isotropic" in text and "reflection_back" in text and "left-out scans" in text
    summary = glossy.summary()
    (part,) = summary.parts
    assert (summary.n_scans, summary.n_points, summary.n_channels) == (6, 2400, 1)
    assert (part.rank, part.n_leaves) == (None, None)
    assert [row.theta_deg for row in part.totals] == [0, 15, 30, 45, 60, 75, 82.5]
    assert part.totals[-1].measured is None and part.totals[-1].n_points == 0
    assert part.extrapolated == pytest.approx(np.cos(np.radians(75)) ** 2)
    assert 0 < part.standard_error < 0.2 and 0 <= part.uncertain < 0.3


def test_extrapolated_share_is_that_of_the_hull_of_all_images():
    quarter = [s for s in ring_scans(gloss, n=60) if s[0][0] >= -1e-9 and s[0][1] >= -1e-9]
    (part,) = bsdftree.fit(Measurement(quarter), symmetry="quadrilateral", frame="fixed").summary().parts
    # An octagon with corners at 60°, on the disk of equal solid angles.
    assert 0.25 < part.extrapolated < 0.40
    (alone,) = bsdftree.fit(Measurement(quarter), symmetry="anisotropic", frame="fixed").summary().parts
    assert alone.extrapolated > 0.75


@pytest.mark.parametrize("name", ["zemax/AnoBlackEC1onAlum.bsdf", "fred/AnoBlackNiTEonINVAR_fullAz.txt"])
def test_real_files_become_lawful_trees(data, run, tmp_path, name):
    out, errors, picture = tmp_path / "out.xml", tmp_path / "errors.xml", tmp_path / "out.png"
    result = run("fit", data / LOFT / name, "-o", out, "--errors", errors, "--plot", picture, "--log2-res", 6)
    assert result.exit_code == 0, result.output
    assert "symmetry: isotropic" in result.stdout
    assert "in use" in result.stdout and "extrapolated" in result.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")
    bsdf = bsdftree.load(out)
    said = "Extrapolated: 11.7 % of incident directions; measured to 70.0 degrees (reflection_back)"
    assert bsdf.provenance[1] == said
    assert "isotropic" in bsdf.provenance[0] and "AnoBlack" in bsdf.name
    checked = run("check", out)
    assert checked.exit_code == 0, checked.output
    # Black coatings reflect some percent, more towards grazing.
    totals = bsdf.hemispherical(direction_from_polar([10, 70], 180), "reflection")
    assert 0.02 < totals[0] < totals[1] < 0.2
    told = json.loads(run("info", "--errors", errors, "--json", out).stdout)
    (component,) = told["bands"][0]["components"]
    assert 0.02 < component["standard_error"] < 0.6 and 0 <= component["uncertain"] <= 1
    assert "standard error" in run("info", "--errors", errors, out).stdout


def test_assumptions_of_scans_in_one_plane_are_told(run, tmp_path):
    angle = np.arange(-80, 81, 4.0)
    exitant = direction_from_polar(np.abs(angle), np.where(angle < 0, 180, 0))
    scans = [(i, exitant, gloss(i, exitant)) for i in direction_from_polar([0, 20, 40, 60], 180)]
    paths = Measurement(scans).save(tmp_path / "scans")
    options = ("-o", tmp_path / "out.xml", "--log2-res", 4)
    told = run("fit", *paths, *options, "--symmetry", "isotropic")
    assert told.exit_code == 0 and "4 of 4 scans were measured in the plane of incidence alone" in told.output
    refused = run("fit", *paths, *options, "--symmetry", "anisotropic")
    assert refused.exit_code == 1 and "if it is isotropic, say so" in refused.output


def test_verb_warns_of_what_was_hardly_measured(run, tmp_path):
    paths = Measurement(line_scans(gloss, (0, 30, 60))).save(tmp_path / "scans")
    options = ("-o", tmp_path / "out.xml", "--log2-res", 3, "--frame", "fixed")
    assert "most of the tree is extrapolated" in run("fit", *paths, *options, "--symmetry", "anisotropic").output
    assert "most of the tree is extrapolated" not in run("fit", *paths, *options, "--symmetry", "isotropic").output


def test_summary_as_json_is_json(run, tmp_path):
    paths = Measurement([line_scans(gloss)[0]], name="one scan").save(tmp_path / "scans")
    result = run("fit", *paths, "-o", tmp_path / "out.bsdft", "--symmetry", "isotropic", "--log2-res", 4, "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout, parse_constant=lambda name: pytest.fail(name))
    assert told["name"] == "one scan" and told["parts"][0]["recipes"][0]["l1"] is None
    assert told["parts"][0]["n_leaves"] == bsdftree.load(tmp_path / "out.bsdft").components["reflection_back"].n_leaves


def test_klems_matrix_has_the_totals_of_the_tree(run, tmp_path):
    paths = Measurement(line_scans(gloss)).save(tmp_path / "scans")
    out = tmp_path / "out.xml"
    result = run("fit", *paths, "-o", out, "--klems", "half", "--log2-res", 5, "--name", "N", "--manufacturer", "M")
    assert result.exit_code == 0, result.output
    bsdf = bsdftree.load(out)
    assert (bsdf.name, bsdf.manufacturer) == ("N", "M")
    assert bsdf.components["reflection_back"].incident_basis.endswith("Half")
    tree = bsdftree.fit(Measurement(line_scans(gloss))).bsdf(log2_res=5)
    at = direction_from_polar(0, 0)
    assert float(bsdf.hemispherical(at, "reflection")) == pytest.approx(
        float(tree.hemispherical(at, "reflection")), 0.02
    )


def test_words_that_are_wrong_are_refused_before_the_work(run, tmp_path):
    path = Measurement(line_scans(gloss)).save(tmp_path / "scans")[0]
    out = tmp_path / "out.xml"
    assert run("fit", path).exit_code == 2
    assert run("fit", path, "-o", out, "--symmetry", "round").exit_code == 2
    assert run("fit", path, "-o", out, "--klems", "full", "--errors", tmp_path / "e.xml").exit_code == 2
    refused = run("fit", path, "-o", out, "--plot", tmp_path / "picture.txt")
    assert refused.exit_code == 2 and ".txt" in refused.output
    for arguments, said in [
        ((tmp_path / "none.txt", "-o", out), "none.txt"),
        ((path, "-o", out, "--log2-res", "12"), "log2_res is 12"),
    ]:
        result = run("fit", *arguments)
        assert result.exit_code == 1 and said in result.output
    assert not out.exists()
    assert run("info", "--errors", out, path, path).exit_code == 2


def test_picture_shows_scans_and_a_direction_between(glossy):
    plot = pytest.importorskip("bsdftree.plot")
    picture = glossy.plot(title="gloss")
    texts = [t.get_text() for axes in picture.axes for t in axes.texts] + [t.get_text() for t in picture.texts]
    assert sum(t.startswith("scan at") for t in texts) == 3
    assert sum(t.startswith("between scans") for t in texts) == 1
    assert "gloss   (isotropic)" in texts
    with pytest.raises(ValueError, match="no component 'transmission_back'; measured are reflection_back"):
        plot.fit(glossy, "transmission_back")
