"""Devices are read by the endings of their files, with materials for meshes, from any drawing."""

import numpy as np
import pytest
import radiance
from radiance import needs_radiance

import bsdftree
from bsdftree import Device

RED = "void plastic red 0 0 5 .6 .1 .1 0 0\nvoid plastic grey 0 0 5 .5 .5 .5 0 0\n"
SQUARE = "red polygon s 0 0 12  0 0 -1  2 0 -1  2 1 -1  0 1 -1\n"
MGF = "m red =\n\trd .5\nv a =\n\tp 0 0 -1\nv b =\n\tp 2 0 -1\nv c =\n\tp 2 1 -1\nv d =\n\tp 0 1 -1\nf a b c d\n"
OBJ = "v 0 0 -1\nv 2 0 -1\nv 2 1 -1\nv 0 1 -1\nusemtl paint\nf 1 2 3\nf 1 3 4\n"
PLY = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
PLY += "property list uchar int vertex_indices\nend_header\n0 0 -1\n2 0 -1\n2 1 -1\n3 0 1 2\n"
STL = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 -1\nvertex 2 0 -1\nvertex 2 1 -1\nendloop\nendfacet\n"
STL += "endsolid a\n"
BOUNDS = [[0, 0, -1], [2, 1, -1]]


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in [
        ("d.rad", RED + SQUARE), ("d", RED + SQUARE), ("d.mat", RED), ("d.mgf", MGF), ("d.obj", OBJ), ("D.PLY", PLY),
        ("d.stl", STL), ("rest.rad", SQUARE),
    ]:  # fmt: skip
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize("name", ["d.rad", "d", "d.mgf", "d.obj", "D.PLY", "d.stl"])
def test_endings_say_what_a_file_is(files, name):
    materials = {"materials": "d.mat", "material_names": {"paint": "red"}, "default_material": "grey"}
    device = Device.read(name, unit="inch", **({} if name in ("d.rad", "d", "d.mgf") else materials))
    np.testing.assert_allclose(device.bounds, np.array(BOUNDS) * 0.0254)


def test_several_files_are_one_scene(files):
    assert Device.read("d.mat", "rest.rad").n_surfaces == 1
    both = Device.read("d.mat", "rest.rad", "d.obj", material_names={"paint": "red"})
    assert both.bounds == BOUNDS and both.n_surfaces >= 2
    with pytest.raises(ValueError, match="stand alone"):
        Device.read("d.rad", "d.mgf")
    with pytest.raises(ValueError, match="paint"):
        Device.read("d.obj")


def test_a_format_may_be_told(files):
    (files / "mgf.txt").write_text(MGF)
    assert Device.read("mgf.txt", format="mgf").bounds == BOUNDS
    assert Device.parse(MGF, format="mgf").bounds == BOUNDS


def test_up_turns_what_is_read(files):
    assert Device.read("d.rad", up="-y").bounds == [[-2, -1, -1], [0, 0, -1]]
    assert Device.read("d.rad", up="Y").bounds == BOUNDS
    with pytest.raises(ValueError, match="up is 'w'"):
        Device.read("d.rad", up="w")


def test_a_file_holds_the_device_that_it_is_of(files):
    bsdf = bsdftree.generate("d.rad", klems="quarter", samples=8, unit="inch", geometry=True)
    bsdf.save("out.xml")
    again = Device.read("out.xml")
    np.testing.assert_allclose(again.bounds, (np.array(BOUNDS) - [1, 0.5, 0]) * 0.0254, atol=1e-12)
    bsdftree.generate("d.rad", klems="quarter", samples=8).save("bare.xml")
    with pytest.raises(ValueError, match=r"bare.xml: the file holds no geometry"):
        Device.read("bare.xml")


def test_mgf_says_what_it_leaves_out(files):
    text, losses = Device.read("d.rad").to_mgf("inch")
    assert losses == [] and Device.parse(text, format="mgf", unit="inch").bounds == BOUNDS


@needs_radiance
def test_radiances_library_is_searched_for_functions(files, monkeypatch):
    monkeypatch.delenv("RAYPATH", raising=False)
    text = "void brightfunc striped 2 'if(sin(20*Px),1,.5)' . 0 0\nstriped plastic white 0 0 5 .8 .8 .8 0 0\n"
    assert Device.parse(text + SQUARE.replace("red", "white")).bounds == BOUNDS
    text = "void brightfunc noisy 4 dirt noise.cal -s .1 0 1 .5\nnoisy plastic white 0 0 5 .8 .8 .8 0 0\n"
    assert (radiance.FOLDER / "lib/noise.cal").is_file()
    try:
        Device.parse(text + SQUARE.replace("red", "white"))
    except ValueError as error:
        assert "no such file" not in str(error)


def test_only_allowed_commands_are_run(files):
    (files / "c.rad").write_text("!cp d.rad stolen.rad\n")
    with pytest.raises(ValueError, match=r"c.rad:1.*cp"):
        Device.read("c.rad")
    assert not (files / "stolen.rad").exists()
    (files / "c.rad").write_text("!head -n 9 d.rad\n")
    assert Device.read("c.rad", allow_commands=["head"]).bounds == BOUNDS
