"""Every verb at the prompt, on real files and on faulty ones."""

import json
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

import bsdftree
from bsdftree.cli import main
from bsdftree.cli._common import printable

READABLE = 18

MIRROR_RAD = """# the talk's flat device at z = 0
void mirror silver 0 0 3 .9 .9 .9
silver polygon glass 0 0 12  -1 -1 0  1 -1 0  1 1 0  -1 1 0
"""


@pytest.fixture
def run():
    def run(*args, **kwargs):
        return CliRunner().invoke(main, [str(a) for a in args], **kwargs)

    return run


@pytest.fixture
def mirror(tmp_path):
    path = tmp_path / "mirror.rad"
    path.write_text(MIRROR_RAD)
    return path


def readable(data):
    files = sorted(p for p in data.glob("*/*") if p.suffix.lower() == ".xml" and "Small" not in p.name)
    assert len(files) == READABLE
    return files


def test_the_talks_own_command_makes_a_flat_mirror(run, mirror, tmp_path):
    out = tmp_path / "mirror.xml"
    result = run("generate", "--rank", 3, "--log2-res", 4, mirror, "-o", out)
    assert result.exit_code == 0, result.output
    b = bsdftree.load(out)
    totals = b.hemispherical(bsdftree.direction_from_polar([5, 45, 85], 30), "reflection")
    np.testing.assert_allclose(totals, 0.9, rtol=1e-3)
    assert b.name == "mirror"
    made, command = b.provenance
    assert "seed 0" in made and "2000 samples" in made and bsdftree.__version__ in made
    assert command.startswith("Command: bsdftree generate")


def test_generate_writes_the_same_xml_to_standard_output(run, mirror, tmp_path):
    out = tmp_path / "m.xml"
    options = ("generate", "--rank", 3, "--log2-res", 3, "--samples", 50, "--name", "m", mirror)
    assert run(*options, "-o", out).exit_code == 0
    printed = run(*options)
    assert printed.exit_code == 0
    assert bsdftree.load(out).to_xml() == printed.stdout


def test_generate_describes_what_it_made_as_json(run, tmp_path):
    out = tmp_path / "b.xml"
    result = run("generate", "--device", "blinds:angle=20", "--klems", "quarter", "--samples", 100, "--json", "-o", out)
    assert result.exit_code == 0, result.output
    made = json.loads(result.stdout)
    assert made["paths"] == 2 * 41 * 100
    assert {c["component"] for c in made["bands"][0]["components"]} == {
        "reflection_front", "reflection_back", "transmission_front", "transmission_back",
    }  # fmt: skip


def test_unit_and_dim_are_in_the_files_unit(run, tmp_path):
    scene = tmp_path / "inch.rad"
    scene.write_text("void plastic p 0 0 5 .5 .5 .5 0 0\np polygon a 0 0 12 0 0 -1 40 0 -1 40 20 -1 0 20 -1\n")
    out = tmp_path / "inch.xml"
    options = ("--unit", "inch", "--dim", 10, 30, 5, 15, -2, 0, "--klems", "quarter", "--samples", 50)
    result = run("generate", *options, scene, "-o", out)
    assert result.exit_code == 0, result.output
    b = bsdftree.load(out)
    assert b.unit == "inch"
    np.testing.assert_allclose([b.width, b.height, b.thickness], np.array([20, 10, 2]) * 0.0254)


def test_a_tiled_opaque_device_lets_nothing_through(run, tmp_path, mirror):
    out = tmp_path / "s.xml"
    result = run("generate", "--device", "sawtooth", "--tile", "--klems", "quarter", "--samples", 200, "-o", out)
    assert result.exit_code == 0, result.output
    b = bsdftree.load(out)
    assert "tiled" in b.provenance[0]
    assert (b.components["transmission_back"].values == 0).all()
    unknown = run("generate", "--tile", mirror)
    assert unknown.exit_code == 1 and "--dim" in unknown.output


def test_up_turns_a_standing_drawing(run, tmp_path):
    # Z up; slats tilted so that light from above, seen from the south (-Y), is caught.
    scene = tmp_path / "standing.rad"
    scene.write_text("void plastic p 0 0 5 0 0 0 0 0\np polygon a 0 0 12 0 0 0 1 0 0 1 1 1 0 1 1\n")
    flat = bsdftree.Device.read(scene).turned_up("z")
    assert flat.bounds == [[0, 0, -1], [1, 1, 0]]


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("generate",), "either scene files or --device"),
        (("generate", "--device", "louvre"), "blinds"),
        (("generate", "--device", "blinds:tilt=3"), "angle"),
        (("generate", "nothing.rad"), "nothing.rad"),
        (("generate", "--device", "mirror", "--log2-res", "40"), "2^40"),
        (("generate", "--device", "mirror", "--rank", "3", "--reciprocity"), "reciprocity"),
        (("info", "nothing.xml"), "nothing.xml"),
        (("eval", "nothing.xml", "1", "2", "3", "4"), "nothing.xml"),
        (("eval", "nothing.xml", "1", "2", "3"), "four to a pair"),
        (("sharpen",), "No such command"),
    ],
)
def test_bad_command_lines_say_what_is_wrong(run, args, message):
    result = run(*args)
    assert result.exit_code in (1, 2)
    assert message in result.output
    assert "Traceback" not in result.output


def test_an_unsupported_scene_names_file_line_and_modifier(run, tmp_path):
    path = tmp_path / "fog.rad"
    path.write_text("# fog\n\nvoid mist fog 0 0 0\nfog sphere cloud 0 0 4 0 0 -1 1\n")
    result = run("generate", path)
    assert result.exit_code == 1
    assert "fog.rad:3" in result.output and "mist" in result.output


def test_info_and_check_work_on_every_real_file(run, data):
    for path in readable(data):
        shown = run("info", path)
        assert shown.exit_code == 0, shown.output
        assert path.name in shown.output
        summary = json.loads(run("info", "--json", path).stdout)
        assert summary["bands"], path
        result = run("check", "--json", path)
        assert result.exit_code in (0, 1)
        checked = json.loads(result.stdout)
        assert checked["ok"] == (result.exit_code == 0)
        for band in checked["bands"]:
            for energy in band["energy"]:
                assert 0 <= energy["reflected"] + energy["transmitted"] <= energy["max"] + 1e-12
        # Radiance's testBSDF.xml is a formula of no surface: it scatters to 80 times what comes in.
        if path.name == "testBSDF.xml":
            assert not checked["ok"]


def test_truncated_files_are_refused_with_their_place(run, data):
    for path in data.glob("bsdfxmlparser/*Small*"):
        result = run("info", path)
        assert result.exit_code == 1
        assert "byte" in result.output and "expected 21025" in result.output


def test_check_fails_a_file_that_makes_light(run, tmp_path):
    bright = bsdftree.Tree.from_grid(np.full((2, 2, 2, 2), 0.4))
    path = tmp_path / "bright.xml"
    bsdftree.Bsdf.from_trees({"reflection_back": bright}).save(path)
    result = run("check", path)
    assert result.exit_code == 1
    assert "125.7 %" in result.output
    assert run("check", "--energy", "30", path).exit_code == 0


def test_eval_prints_what_python_returns(run, data):
    path = data / "pyradiance" / "blindsT3.xml"
    b = bsdftree.load(path)
    value = float(b.eval(bsdftree.direction_from_polar(30, 90), bsdftree.direction_from_polar(150, 270)))
    assert float(run("eval", path, 30, 90, 150, 270).stdout) == pytest.approx(value, rel=1e-6)
    lines = run("eval", path, input="30 90 150 270 # straight on\n\n0, 0, 180, 0\n").stdout.splitlines()
    assert len(lines) == 2 and float(lines[0]) == pytest.approx(value, rel=1e-6)
    row = json.loads(run("eval", "--json", "--pdf", "--color", path, 30, 90, 150, 270).stdout)[0]
    assert row["xyz"] == [value] * 3 and row["pdf"] > 0
    smooth = float(run("eval", "--smooth", path, 30, 90, 150, 270).stdout)
    ramps = b.smooth()
    assert smooth == pytest.approx(
        float(ramps.eval(bsdftree.direction_from_polar(30, 90), bsdftree.direction_from_polar(150, 270))), rel=1e-6
    )
    bad = run("eval", path, input="1 2 3\n")
    assert bad.exit_code == 1 and "line 1" in bad.output


def test_interrupt_stops_a_generation():
    """Ctrl-C ends the threads and the process, soon, and leaves no file."""
    code = "import signal, threading, os, bsdftree\n"
    code += "threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
    code += "bsdftree.generate('blinds', log2_res=5, samples=10_000_000)\n"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode != 0 and "KeyboardInterrupt" in result.stderr


def test_module_runs_as_a_program():
    result = subprocess.run([sys.executable, "-m", "bsdftree", "--version"], capture_output=True, text=True, check=True)
    assert bsdftree.__version__ in result.stdout


def test_what_files_hold_commands_no_terminal():
    assert printable("found 'a\x1b[31m\x07ö'\nend") == r"found 'a\x1b[31m\x07ö'" + "\nend"
