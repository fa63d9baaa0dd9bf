"""`bsdftree check` at the prompt: mistakes in files are found, named and repaired; clean files are copied bit by bit.

What is planted in BSDFs as such, of both kinds, is in crates/bsdftree/tests/check.rs.
"""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree._placement import Position, placed
from bsdftree.cli import main

FINDING = {"kind", "severity", "part", "incident", "exitant", "amount", "message", "advice", "repair"}
BAND = {"band", "energy", "reciprocity", "symmetry", "noise", "gamut", "findings"}


@pytest.fixture
def run():
    def run(*args):
        return CliRunner().invoke(main, ["check", *map(str, args)])

    return run


@pytest.fixture
def blinds(data):
    """Real, four components, good to 1 %."""
    return data / "pyradiance" / "blinds.xml"


def findings(result, kind):
    checked = json.loads(result.stdout)
    found = [*checked["findings"], *(f for band in checked["bands"] for f in band["findings"])]
    return [f for f in found if f["kind"] == kind]


def assert_repaired(run, path, kind, tmp_path):
    """Found with a repair, repaired with numbers, and not found in the copy."""
    before = findings(run("--json", path), kind)
    assert any(f["repair"] for f in before), before
    out = tmp_path / f"mended-{kind}.xml"
    result = run("--json", path, "--fix", out, "--only", kind)
    repaired = json.loads(result.stdout)["repaired"]
    assert repaired["file"] == str(out)
    assert repaired["mended"] and all(m["before"] != m["after"] for m in repaired["mended"]), repaired
    assert {m["kind"] for m in repaired["mended"]} == {kind}
    assert result.exit_code == (0 if repaired["ok"] else 1)
    assert not [f for f in findings(run("--json", out), kind) if f["repair"]]
    mended = bsdftree.load(out)
    assert sum("Repaired by: bsdftree" in line for line in mended.provenance) == len(repaired["mended"])
    return mended


def test_the_schema_is_what_docs_say(run, blinds):
    checked = json.loads(run("--json", blinds).stdout)
    assert set(checked) == {"file", "ok", "findings", "bands"} and checked["ok"]
    assert set(checked["bands"][0]) == BAND
    assert len(checked["bands"][0]["noise"]) == 4
    bright = bsdftree.Bsdf.from_trees({"reflection_back": bsdftree.Tree.from_grid(np.full((2, 2, 2, 2), 0.4))})
    finding = next(f for _, f in bright.check().all())
    assert set(vars(finding)) == FINDING and finding.incident is not None


def test_a_clean_file_is_copied_bit_by_bit(run, blinds, tmp_path):
    for source in (blinds, tmp_path / "twin.bsdft"):
        if source != blinds:
            bsdftree.load(blinds).save(source)
        before = source.read_bytes()
        out = tmp_path / f"copy{source.suffix}"
        result = run(source, "--fix", out)
        assert result.exit_code == 0, result.output
        assert "copied as it is" in result.output
        assert out.read_bytes() == before == source.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["copy.bsdft", "copy.xml", "twin.bsdft"]


def test_every_real_file_is_repaired_or_copied(run, data, tmp_path):
    for path in sorted(p for p in data.glob("*/*") if p.suffix.lower() == ".xml" and "Small" not in p.name):
        out = tmp_path / path.name
        result = run("--json", path, "--fix", out)
        assert result.exit_code == 0, result.output
        repaired = json.loads(result.stdout)["repaired"]
        assert repaired["ok"]
        if not repaired["mended"]:
            assert out.read_bytes() == path.read_bytes()
        left = bsdftree.load(out).check()
        assert left.ok and not any(f.repair for _, f in left.all()), path


def test_negative_values_are_a_violation_and_become_zero(run, blinds, tmp_path):
    text = blinds.read_text()
    place = text.index("<ScatteringData>") + len("<ScatteringData>")
    path = tmp_path / "negative.xml"
    path.write_text(text[:place] + re.sub(r"\d", "-1", text[place : place + 40], count=1) + text[place + 40 :])
    with pytest.raises(ValueError, match=": 1 negative value; "):
        bsdftree.load(path)
    result = run("--json", path)
    assert result.exit_code == 1 and findings(result, "values")[0]["severity"] == "violation"
    assert_repaired(run, path, "values", tmp_path)
    refused = run(path, "--fix", tmp_path / "no.xml", "--only", "energy")
    assert refused.exit_code == 1 and "add values to --only" in refused.output
    assert not (tmp_path / "no.xml").exists()


def test_an_angle_basis_in_radians_is_found_and_read_in_degrees(run, blinds, tmp_path):
    def radians(match):
        return f"{match[1]}{np.radians(float(match[2])):.5f}<"

    text, n = re.subn(r"(<(?:LowerTheta|UpperTheta)>)([\d.]+)<", radians, blinds.read_text())
    assert n == 18
    path = tmp_path / "radians.xml"
    path.write_text(text)
    assert "radians" in findings(run("--json", path), "values")[0]["message"]
    mended = assert_repaired(run, path, "values", tmp_path)
    for key, component in bsdftree.load(blinds).components.items():
        np.testing.assert_array_equal(mended.components[key].values, component.values)
        # Totals are sums over the patches of the basis.
        same = [
            b.hemispherical(bsdftree.direction_from_polar([0, 30, 80], 45)) for b in (mended, bsdftree.load(blinds))
        ]
        np.testing.assert_allclose(*same, rtol=1e-4)


def test_lengths_in_millimetres_declared_as_metres_are_found_and_mended(run, blinds, tmp_path):
    path = tmp_path / "long.xml"
    text, n = re.subn(r"(<Thickness unit=.)\w+(.>)[^<]*", r"\1Meter\g<2>76.2", blinds.read_text())
    assert n == 1
    path.write_text(text)
    mended = assert_repaired(run, path, "units", tmp_path)
    assert mended.thickness == pytest.approx(0.0762)


def test_micrometres_taken_for_nanometres_are_found_and_mended(run, blinds, tmp_path):
    path = tmp_path / "micro.xml"
    bsdftree.load(blinds).select(rename=("Visible", "0.65")).save(path)
    assert "650 nm" in findings(run("--json", path), "units")[0]["message"]
    assert assert_repaired(run, path, "units", tmp_path).bands == ["650"]


def test_percentages_in_a_real_file_are_found_and_divided(run, blinds, tmp_path):
    b = bsdftree.load(blinds)
    percent = {key: bsdftree.Matrix.from_values(100 * m.values, "full") for key, m in b.components.items()}
    path = tmp_path / "percent.xml"
    bsdftree.Bsdf.from_components(percent).save(path)
    mended = assert_repaired(run, path, "units", tmp_path)
    for key, component in b.components.items():
        np.testing.assert_allclose(mended.components[key].values, component.values, rtol=1e-5)


def test_noise_is_what_the_standard_errors_of_a_generation_are(run, tmp_path):
    """With independent samples and nothing averaged, the level told from values alone is within 25 % of theirs."""
    reports = []
    device = bsdftree.Device.from_spec("blinds:angle=45")
    options = {"sampling": "random", "reuse": False, "reciprocity": False, "report": reports.append}
    b = bsdftree.generate(device, klems="full", samples=3000, **options)
    for noise in b.check().bands[0].noise:
        values, errors = (x.components[noise.part].values.ravel() for x in (b, reports[0].errors))
        order = np.argsort(relative := errors / np.maximum(values, 1e-30))
        flux = np.cumsum(values[order], dtype=float)
        median = relative[order][np.searchsorted(flux, flux[-1] / 2)]
        assert noise.level == pytest.approx(median, rel=0.25), noise
    path = tmp_path / "b.xml"
    b.save(path)
    stated = findings(run("--json", path), "noise")[0]
    assert stated["severity"] == "note" and stated["amount"] == pytest.approx(reports[0].error, abs=6e-4)


@pytest.mark.parametrize("position", [Position(turn_deg=180), Position(turn_deg=90), Position(flip=True)], ids=str)
def test_geometry_tells_which_way_up_and_round_a_real_device_is(run, data, tmp_path, position):
    source = data / "frads" / "blinds30.xml"
    b = bsdftree.load(source)
    path, out = tmp_path / "turned.xml", tmp_path / "back.xml"
    position.of(b).with_header(provenance=b.provenance).save(path)
    told = findings(run("--json", path, "--device", source), "orientation")
    assert str(position) in told[0]["message"] and told[0]["severity"] == "warning", told
    assert run(path, "--device", source, "--fix", out, "--only", "orientation").exit_code == 0
    assert all(error < 1e-6 for error in b.distance(bsdftree.load(out)).values())
    assert placed(b, source)[0][1] == Position()
    assert findings(run("--json", source, "--device", source), "orientation")[0]["severity"] == "note"


def test_the_command_line_says_what_it_cannot_do(run, blinds, tmp_path):
    for args, message in [
        ((blinds, blinds, "--fix", tmp_path / "x.xml"), "one file; found 2"),
        ((blinds, "--only", "energy"), "add --fix OUT"),
        ((blinds, "--fix", tmp_path / "x.xml", "--only", "noise"), "expected some of values, units"),
    ]:
        result = run(*args)
        assert result.exit_code == 2 and message in result.output, result.output
    missing = run(blinds, "--fix", tmp_path / "nowhere" / "x.xml")
    assert missing.exit_code == 1 and "nowhere" in missing.output
    with pytest.raises(ValueError, match=r"no kind of finding .sharpness.; expected some of values"):
        bsdftree.load(blinds).repaired(["sharpness"])
