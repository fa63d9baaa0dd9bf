"""`bsdftree genbsdf` at the prompt: what genBSDF's scripts ask for comes out, with its exit codes and warnings."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
import radiance
from click.testing import CliRunner
from radiance import needs_radiance

import bsdftree
from bsdftree.cli import main

PANE = "void glass it 0 0 3 .8 .8 .8\nit polygon pane 0 0 12  0 0 -0.1  2 0 -0.1  2 1 -0.1  0 1 -0.1\n"
SLATS = """void plastic white 0 0 5 .7 .7 .7 0 0
white polygon one 0 0 12  0 0 -.03  1 0 -.03  1 .02 -.01  0 .02 -.01
white polygon two 0 0 12  0 .04 -.03  1 .04 -.03  1 .06 -.01  0 .06 -.01
"""
SUN_FROM_OUTSIDE, LIGHT_FROM_ROOM = [0, 0, -1], [0, 0, 1]


@pytest.fixture
def prompt(tmp_path, monkeypatch):
    """A function that runs genbsdf beside pane.rad and slats.rad: exit code, BSDF or None, messages."""
    (tmp_path / "pane.rad").write_text(PANE)
    (tmp_path / "slats.rad").write_text(SLATS)
    (tmp_path / "temporary").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))

    def run(*words, stdin=""):
        result = CliRunner().invoke(main, ["genbsdf", *map(str, words)], input=stdin)
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exc_info
        bsdf = None
        if result.exit_code == 0:
            Path("out.xml").write_text(result.stdout)
            bsdf = bsdftree.load("out.xml")
        else:
            assert result.stdout == ""
        assert list((tmp_path / "temporary").iterdir()) == [], "the temporary folder is left"
        return result.exit_code, bsdf, result.stderr

    return run


def test_defaults_are_klems_from_the_room_with_geometry(prompt):
    code, bsdf, messages = prompt("-c", 16, "pane.rad")
    assert code == 0
    assert set(bsdf.components) == {"reflection_back", "transmission_back"}
    assert bsdf.components["reflection_back"].values.shape == (145, 145)
    assert bsdf.geometry.startswith("xf -t -1.0 -0.5 0\n") and "f v0 v1 v2 v3" in bsdf.geometry
    assert (bsdf.width, bsdf.height, bsdf.thickness, bsdf.unit) == (2.0, 1.0, 0.1, "meter")
    assert (bsdf.name, bsdf.manufacturer) == ("Name", "Manufacturer")
    assert bsdf.provenance[-1] == "Command: bsdftree genbsdf -c 16 pane.rad"
    assert messages.startswith("Recover using: bsdftree genbsdf -recover ")


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("+f", "-b"), {"reflection_front", "transmission_front"}),
        (("-f", "+b"), {"reflection_back", "transmission_back"}),
        (("+forward", "+backward"), {"reflection_front", "transmission_front", "reflection_back", "transmission_back"}),
    ],
)
@pytest.mark.parametrize("kind", [(), ("-t4", 3), ("-t3", 3)])
def test_sides_are_genbsdfs(prompt, words, parts, kind):
    code, bsdf, messages = prompt("-c", 16, "-geom", "meter", *kind, *words, "pane.rad")
    assert code == 0 and set(bsdf.components) == parts
    assert bsdf.geometry is None
    assert ("recommend both" in messages) == (kind == ("-t3", 3) and len(parts) == 2)
    if kind:
        assert all(c.rank == int(kind[0][-1]) and c.depth <= 3 for c in bsdf.components.values())


def test_units_dim_and_fields_are_in_the_header(prompt):
    code, bsdf, _ = prompt(
        *("-c", 16, "-geom", "inch", "-dim", -1, 3, 0, 2, -0.5, 0, "-s", "m=ACME;Name=Pane;eo=.5;Foo=bar", "pane.rad")
    )
    assert code == 0
    np.testing.assert_allclose([bsdf.width, bsdf.height, bsdf.thickness], np.array([4, 2, 0.5]) * 0.0254)
    assert (bsdf.unit, bsdf.manufacturer, bsdf.name) == ("inch", "ACME", "Pane")
    assert bsdf.properties == {"EffectiveOpennessFraction": ".5", "Foo": "bar"}
    code, bsdf, messages = prompt("-c", 16, "-geom", "millimeter", "-W", "-s", "m=ACME;t=7;ef=.8", "pane.rad")
    assert code == 0 and bsdf.thickness == pytest.approx(0.007)
    assert "missing 'n' assignment for WINDOW <Name>" in messages and "'m'" not in messages
    assert bsdf.properties["EmissivityFront"] == ".8" and bsdf.properties["ThermalConductivity"] == "1"
    code, _, messages = prompt("-c", 16, "-geom", "inch", "-s", "t=thick", "pane.rad")
    assert code == 1 and "expected a length in inch" in messages


def test_half_the_aperture_is_open_beside_the_device(prompt):
    """Light that misses the device goes on: the meaning of -dim."""
    _, whole, _ = prompt("-c", 200, "-geom", "meter", "pane.rad")
    _, wide, _ = prompt("-c", 200, "-geom", "meter", "-dim", 0, 4, 0, 1, -0.1, 0, "pane.rad")
    a, b = (float(x.hemispherical(LIGHT_FROM_ROOM, "reflection")) for x in (whole, wide))
    assert b == pytest.approx(a / 2, rel=0.05)


def test_the_scene_may_come_by_standard_input(prompt):
    code, a, _ = prompt("-c", 16, "-geom", "meter", stdin=PANE)
    assert code == 0
    _, b, _ = prompt("-c", 16, "-geom", "meter", "pane.rad")
    np.testing.assert_array_equal(a.components["reflection_back"].values, b.components["reflection_back"].values)


def test_mgf_is_read_where_it_is_said_to_be(prompt, data):
    code, a, messages = prompt("-c", 64, "-geom", "meter", "+mgf", data / "radiance/sawtooth.mgf")
    assert code == 0, messages
    _, b, _ = prompt("-c", 64, "-geom", "meter", "+mgf", stdin=(data / "radiance/sawtooth.mgf").read_text())
    np.testing.assert_array_equal(a.components["reflection_back"].values, b.components["reflection_back"].values)
    code, _, messages = prompt("-c", 64, "+mgf", "pane.rad")
    assert code == 1 and "the input has no surfaces" in messages and "pane.rad:1" in messages


def test_colour_and_culling(prompt):
    (Path("red.rad")).write_text(PANE.replace(".8 .8 .8", ".9 .6 .3"))
    code, bsdf, _ = prompt("-c", 64, "+C", "-t4", 3, "-t", -1, "red.rad")
    assert code == 0
    u, _ = bsdf.chroma_of()["transmission_back"]
    # Radiance's white has u′ 4/19; red has more.
    assert float(u.to_grid(3).max()) > 0.25
    leaves = {}
    for cull in (-1, 50, 90, 99):
        code, bsdf, _ = prompt("-c", 64, "-geom", "meter", "-t4", 4, "-t", cull, "slats.rad")
        leaves[cull] = sum(c.n_leaves for c in bsdf.components.values())
    assert leaves[-1] > leaves[50] > leaves[90] > leaves[99]


def test_equal_seeds_give_equal_bits_for_any_n(prompt):
    files = []
    for n in (1, 2):
        prompt("-c", 16, "-n", n, "--seed", 3, "slats.rad")
        files.append(Path("out.xml").read_text().split("<WindowElement", 1)[1])
    assert files[0] == files[1]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-q", "pane.rad"), "Usage: bsdftree genbsdf"),
        (("-f", "-b", "pane.rad"), "Must have at least one of +forward or +backward"),
        (("-geom", "furlong", "pane.rad"), "Illegal geometry unit 'furlong'"),
        (("-t", "100", "pane.rad"), "must be < 100"),
        (("nothing.rad",), "nothing.rad"),
        (("-t4", "40", "pane.rad"), "2^40"),
        (("-recover", "nowhere"), "nowhere: invalid path"),
        (("-dim", "1", "0", "0", "1", "-1", "0", "pane.rad"), "expected min < max"),
    ],
)
def test_whatever_is_wrong_ends_with_1(prompt, words, message):
    code, _, messages = prompt(*words)
    assert code == 1 and message in messages
    assert "Traceback" not in messages and "Recover" not in messages.split(message)[-1]


def test_where_the_device_lies_is_told_as_genbsdf_does(prompt):
    inside = PANE.replace("-0.1", "0.1")
    code, _, messages = prompt("-c", 8, stdin=inside)
    assert code == 1 and "Device entirely inside room!" in messages
    code, _, messages = prompt("-c", 8, stdin=PANE + inside.replace("pane", "other").split("\n", 1)[1])
    assert code == 0 and "Warning: Device extends into room" in messages
    code, _, messages = prompt("-c", 8, stdin=PANE.replace("-0.1", "-1"))
    assert code == 0 and "Warning: Device far behind Z==0 plane" in messages
    # genBSDF refuses a flat device at z = 0, for which nothing speaks.
    code, _, messages = prompt("-c", 8, "-geom", "meter", stdin=PANE.replace("-0.1", "0"))
    assert code == 0 and "Warning" not in messages


def test_options_for_rcontrib_are_noted_and_do_nothing(prompt):
    code, a, messages = prompt("-c", 16, "-r", "-ab 5 -ad 700", "pane.rad")
    assert code == 0 and "-r '-ab 5 -ad 700' is for rcontrib" in messages
    _, b, messages = prompt("-c", 16, "pane.rad")
    assert "for rcontrib" not in messages
    np.testing.assert_array_equal(a.components["reflection_back"].values, b.components["reflection_back"].values)


def test_a_killed_run_is_recovered(tmp_path):
    """As genBSDF says it: by the line on standard error, from another directory."""
    (tmp_path / "slats.rad").write_text(SLATS)
    (tmp_path / "temporary").mkdir()
    environment = os.environ | {"TMPDIR": str(tmp_path / "temporary")}
    words = [sys.executable, "-m", "bsdftree", "genbsdf", "-t4", "4", "-c", "512", "-geom", "meter"]
    process = subprocess.Popen(
        words, cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment
    )
    process.stdin.write(SLATS.encode())
    process.stdin.close()
    line = process.stderr.readline().decode()
    assert line.startswith("Recover using: bsdftree genbsdf -recover ")
    folder = Path(line.split()[-1])
    while not list((folder / "checkpoint").glob("*")):
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert json.loads((folder / "genbsdf.json").read_text())["words"][:2] == ["-t4", "4"]
    run = {"capture_output": True, "check": True, "env": environment}
    recovered = subprocess.run([*words[:4], "-recover", str(folder)], cwd="/", **run).stdout
    whole = subprocess.run(words, cwd=tmp_path, input=SLATS.encode(), **run).stdout
    assert recovered.split(b"-->")[-1] == whole.split(b"-->")[-1]
    assert not folder.exists()


@needs_radiance
def test_radiance_reads_geometry_and_data(prompt, tmp_path):
    """pkgBSDF takes the file apart: the geometry is where it was, centred, for a renderer to show."""
    code, _, _ = prompt("-c", 16, "-geom", "meter", "pane.rad")
    assert code == 0
    code, _, _ = prompt("-c", 16, "slats.rad")
    packed = radiance.run("pkgBSDF", "-s", "./out.xml", cwd=tmp_path).decode()
    (tmp_path / "packed.rad").write_text(packed)
    boxes = radiance.run("getbbox", "-h", "packed.rad", cwd=tmp_path).split()
    box = [float(x) for x in boxes]
    np.testing.assert_allclose(box[:4], [-0.5, 0.5, -0.03, 0.03], atol=2e-3)


@needs_radiance
def test_engine_radiance_does_the_same(prompt):
    options = ("-geom", "meter", "-t4", 3, "-c", 64, "-t", 50, "-n", 2)
    code, theirs, messages = prompt("--engine", "radiance", "-r", "-ad 60", *options, "slats.rad")
    assert code == 0, messages
    assert "note" not in messages and "Recover" not in messages
    _, ours, _ = prompt(*options, "slats.rad")
    assert set(theirs.components) == set(ours.components)
    i = bsdftree.direction_from_polar([10, 30, 50, 70], [0, 90, 180, 270])
    for part in ("reflection", "transmission"):
        np.testing.assert_allclose(theirs.hemispherical(i, part), ours.hemispherical(i, part), atol=0.15)
    code, theirs, messages = prompt("--engine", "radiance", "-c", 16, "+geom", "inch", stdin=PANE)
    assert code == 0 and "ts 0.7" in theirs.geometry
    np.testing.assert_allclose([theirs.width, theirs.height, theirs.thickness], np.array([2, 1, 0.1]) * 0.0254)
    code, _, messages = prompt("--engine", "radiance", stdin="!rm -rf /\n")
    assert code == 1 and "standard input:1: the command 'rm' is not run" in messages


def test_the_one_word_is_the_same_verb(tmp_path):
    (tmp_path / "pane.rad").write_text(PANE)
    code = "import sys; from bsdftree.cli.genbsdf import main; sys.argv[0] = 'genBSDF'; main()"
    words = [sys.executable, "-c", code, "-c", "8", "-geom", "meter", "+f", "pane.rad"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("<?xml") and "Reflection Front" in done.stdout


SHEET = "paint polygon sheet 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0\n"
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl paint\nf 1 2 3 4\n"


@pytest.mark.parametrize("engine", ["bsdftree", pytest.param("radiance", marks=needs_radiance)])
def test_materials_are_those_of_scenes_and_meshes_for_either_engine(prompt, engine):
    Path("paint.mat").write_text("void plastic paint 0 0 5 .6 .6 .6 0 0\n")
    Path("sheet.rad").write_text(SHEET)
    Path("sheet.obj").write_text(OBJ)
    words = ("--engine", engine, "--materials", "paint.mat", "-c", 16, "-dim", 0, 1, 0, 1, -0.1, 0, "-geom", "meter")
    for files, stdin in [(("sheet.rad",), ""), ((), SHEET), (("sheet.obj",), "")]:
        code, bsdf, messages = prompt(*words, *files, stdin=stdin)
        assert code == 0, messages
        total = bsdf.hemispherical(LIGHT_FROM_ROOM, part="reflection")
        assert float(total) == pytest.approx(0.6, abs=0.05), files


def test_what_would_stop_a_ray_is_told_before_rays_are_sent(prompt):
    Path("never.rad").write_text(
        f"void brightfunc p 2 'if(Px+9,.5,nothing)' . 0 0\np plastic paint 0 0 5 .6 .6 .6 0 0\n{SHEET}"
    )
    code, _, messages = prompt("-c", 4, "-dim", 0, 1, 0, 1, -0.1, 0, "-geom", "meter", "never.rad")
    assert code == 0
    assert messages.count('never.rad:1: brightfunc "p": generation will fail if a ray needs this') == 1
    assert messages.index("will fail if a ray") < messages.index("Recover using")
