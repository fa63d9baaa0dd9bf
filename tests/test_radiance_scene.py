"""Scenes reach Radiance's programs without a shell, and hostile ones do not get through."""

import numpy as np
import pytest
import radiance
from radiance import needs_radiance

import bsdftree
from bsdftree._radiance import scene as scene_module
from bsdftree._radiance.bins import klems_bins, square_bins
from bsdftree._radiance.programs import RadianceError, printed, run
from bsdftree._radiance.rcontrib import bounds
from bsdftree._radiance.scene import scene_of_files, scene_of_text

pytestmark = needs_radiance

WHITE = "void plastic white 0 0 5 .7 .7 .7 0 0\n"
SQUARE = "white polygon {} 0 0 12  0 0 -1  1 0 -1  1 1 -1  0 1 -1\n"


def primitives(text: bytes) -> list[str]:
    """Names of all primitives, as xform, which understands scenes by itself, gives them."""
    heads = [line.split() for line in radiance.run("xform", stdin=text).decode().splitlines()]
    return [head[2] for head in heads if len(head) == 3 and head[1].isalpha()]


@pytest.fixture
def files(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/square.rad").write_text(WHITE + SQUARE.format("square"))
    (tmp_path / "sub/two.rad").write_text("!xform -t 1 0 0 square.rad\n!cat square.rad | xform -s 2\n")
    (tmp_path / "all.rad").write_text(
        WHITE + "# a comment ! with a mark\n!genblinds white b .05 1 1 5 30 | xform -rz -90 -rx 90\n"
        "!xform -n a -a 3 -t 0 2 0 sub/two.rad\nvoid alias grey white\n"
        "!genbox white 'box' 1 1 1 \\\n -b .1\n"
    )
    return tmp_path


def test_commands_are_replaced_by_what_they_print(files):
    made = scene_of_files([files / "all.rad"])
    assert b"!" not in made.text
    names = primitives(made.text)
    assert names.count("b.3.0") == 1 and names.count("a.0.square") == 2 and names.count("a.2.square") == 2
    assert made.directories == [str(files)]
    # Slats below y = 0, a box up to z = 1, squares moved to x = 2, doubled, and 3 times along y.
    np.testing.assert_allclose(bounds(made), [0, 2, -0.925, 6, -2, 1], atol=1e-9)


def test_text_without_commands_stays_a_scene(files):
    text = WHITE + SQUARE.format("a") + 'void colorpict "p q" 7 red green blue "a b.hdr" . u v 0 0\n'
    assert scene_of_text(text).text.split() == text.encode().split()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("!touch /tmp/bsdftree-was-here\n", "the command 'touch' is not run"),
        ("!/bin/sh -c true\n", "the command '/bin/sh' is not run"),
        ("!../xform a.rad\n", "is not run"),
        ("!cat x; touch y\n", "';' in a command"),
        ("!cat `ls`\n", "'`' in a command"),
        ("!cat $HOME/x\n", "'$' in a command"),
        ("!xform < x\n", "'<' in a command"),
        ("!genbox white b 1 1 1 > /tmp/x\n", "'>' in a command"),
        ("!genbox white 'b 1 1 1\n", "a quote in the command is not closed"),
        ("!\n", "expected a word after"),
        ("!cat | | xform\n", "expected a word after"),
        ("!xform -rx 90\n", "xform names no file"),
        ("!xform --help x\n", "no option '--help'"),
        ("!xform nothing.rad\n", "no file 'nothing.rad'"),
        ("!gensurf white s '!ls' 1 1 1 1\n", "is given the command '!ls'"),
        (WHITE + "void colordata c 9 red green blue !ls !ls !ls . u v 0 0\n", "names the command '!ls'"),
        ("void colorpict c 7 red green blue '!ls' . u v 0 0", "names the command '!ls'"),
        (WHITE + SQUARE.format("a").replace("\n", " !ls\n"), "the command 'ls' is not run"),
        ("void plastic white 0 0", "the scene ends; expected the number of real"),
        ("void plastic white 0 0 many", "'many' for the number of real"),
        ("void plastic white 99999999999 0 0", "expected a small integer"),
        ("void instance i 1 no.oct 0 0", "no octree 'no.oct'"),
    ],
)
def test_nothing_else_is_run(text, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(scene_module, "printed", printed_only_radiance)
    with pytest.raises(RadianceError) as error:
        scene_of_text(text)
    assert message in str(error.value)
    assert str(error.value).startswith("text:")
    assert list(tmp_path.iterdir()) == []


def printed_only_radiance(words, **options):
    assert words[0].startswith(str(radiance.FOLDER))
    return printed(words, **options)


def test_an_allowed_command_runs_and_its_output_is_checked(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.rad").write_text(WHITE)
    assert b"plastic" in scene_of_text("!head -n 1 p.rad\n", allow_commands=["head"]).text
    (tmp_path / "p.rad").write_text("!ls\n")
    with pytest.raises(RadianceError, match="'ls' is not run"):
        scene_of_text("!head -n 1 p.rad\n", allow_commands=["head"])
    with pytest.raises(RadianceError, match="failed with code"):
        scene_of_text("!false\n", allow_commands=["false"])


def test_circles_and_floods_end(tmp_path, monkeypatch):
    (tmp_path / "a.rad").write_text("!xform b.rad\n")
    (tmp_path / "b.rad").write_text("!xform a.rad\n")
    with pytest.raises(RadianceError, match=r"does .* name itself"):
        scene_of_files([tmp_path / "a.rad"])
    monkeypatch.setattr(scene_module, "MOST_BYTES", 1 << 20)
    (tmp_path / "c.rad").write_text(WHITE + SQUARE.format("a"))
    (tmp_path / "d.rad").write_text("!xform -a 1000000000 -t 1 0 0 c.rad\n")
    with pytest.raises(RadianceError, match="printed more than 1 MiB"):
        scene_of_files([tmp_path / "d.rad"])
    with pytest.raises(RadianceError, match=r"took more than 0.2 s"):
        printed(["sleep", "20"], seconds=0.2)


def test_octrees_must_be_frozen(files, monkeypatch):
    monkeypatch.chdir(files)
    (files / "frozen.oct").write_bytes(radiance.run("oconv", "-f", "sub/square.rad", cwd=files))
    (files / "open.oct").write_bytes(radiance.run("oconv", "sub/square.rad", cwd=files))
    assert b"frozen" in scene_of_text("void instance i 1 frozen.oct 0 0\n").text
    with pytest.raises(RadianceError, match="is not frozen"):
        scene_of_text("void instance i 1 open.oct 0 0\n")


@pytest.mark.parametrize(("basis", "name"), [("full", "kbin"), ("half", "khbin"), ("quarter", "kqbin")])
def test_patches_are_radiances(basis, name, rng, tmp_path):
    layout = bsdftree._core.Layout(rank=4, log2_res=1, klems=basis, subdivide=1)
    directions = bsdftree.direction_from_polar(np.degrees(np.arcsin(np.sqrt(rng.random(5000)))), 360 * rng.random(5000))
    (tmp_path / "ours.cal").write_text(klems_bins(layout.rings))
    given = "\n".join(" ".join(f"{c:.17g}" for c in d) for d in directions).encode()
    rays = ["-e", "Dx=$1;Dy=$2;Dz=$3"]
    ours = run("rcalc", *rays, "-f", tmp_path / "ours.cal", "-e", "$1=bin", stdin=given)
    # What rfluxmtx gives for the front: the surface's normal is -Z, up is -Y, and it is left-handed.
    theirs = run(
        "rcalc", "-f", f"klems_{basis}.cal", "-e", "RHS=-1", *rays, "-e", f"$1={name}(0,0,-1,0,-1,0)", stdin=given
    )
    ours, theirs = (np.array(text.split(), int) for text in (ours, theirs))
    assert set(ours) == set(range(layout.n_exitant))
    np.testing.assert_array_equal(ours, theirs)


def test_square_cells_are_the_layouts(rng, tmp_path):
    layout = bsdftree._core.Layout(rank=4, log2_res=3, klems=None, subdivide=1)
    (tmp_path / "bins.cal").write_text(square_bins(8))
    cells = rng.integers(0, 64, 300)
    disks = np.array([layout.starts(False, cell, 3, 1)[2, :2] for cell in cells])
    given = "\n".join(f"{x:.17g} {y:.17g}" for x, y in disks)
    arguments = ["-f", "disk2square.cal", "-f", tmp_path / "bins.cal", "-e", "Dx=$1;Dy=$2;Dz=0", "-e", "$1=bin"]
    np.testing.assert_array_equal(np.array(run("rcalc", *arguments, stdin=given.encode()).split(), int), cells)
