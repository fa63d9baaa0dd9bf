"""Meshes as devices and in scenes, beside what Radiance makes of the same files."""

import numpy as np
import pytest
import radiance
from radiance import needs_radiance

import bsdftree
from bsdftree import Device

MATERIALS = "void plastic red 0 0 5 .5 .25 .125 0 0\nvoid metal shiny 0 0 5 .8 .8 .8 1 0\n"
# A trough, concave to +z, of 40 strips.
TROUGH = ["2*s-1", "2*t-1", "(2*s-1)*(2*s-1)/2-.6"]


@pytest.fixture
def trough(tmp_path):
    made = radiance.run("gensurf", "shiny", "trough", *TROUGH, 40, 1, "-s", "-o")
    (tmp_path / "trough.obj").write_bytes(made)
    (tmp_path / "m.mat").write_text(MATERIALS)
    radiance.run("obj2mesh", "-a", "m.mat", "trough.obj", "trough.rtm", cwd=tmp_path)
    return tmp_path


@needs_radiance
def test_an_obj_file_is_what_obj2rad_makes_of_it(tmp_path):
    (tmp_path / "b.obj").write_bytes(radiance.run("genbox", "red", "b", 1, 2, 3, "-r", 0.2, "-n", 4, "-o"))
    (tmp_path / "m.mat").write_text(MATERIALS)
    ours = Device.read(tmp_path / "b.obj", materials=tmp_path / "m.mat")
    theirs = Device.parse(MATERIALS + radiance.run("obj2rad", "b.obj", cwd=tmp_path).decode())
    np.testing.assert_allclose(ours.bounds, theirs.bounds, atol=1e-12)
    assert ours.n_surfaces == 1 and theirs.n_surfaces > 100
    a, b = (bsdftree.generate(d, klems="quarter", samples=2000, seed=4, sides="front") for d in (ours, theirs))
    i = bsdftree.direction_from_polar([170, 130, 110], [10, 100, 200])
    np.testing.assert_allclose(a.hemispherical(i), b.hemispherical(i), atol=0.03)


@needs_radiance
def test_a_compiled_mesh_is_its_obj_file(trough):
    compiled = Device.read(trough / "trough.rtm")
    from_obj = Device.read(trough / "trough.obj", materials=trough / "m.mat")
    np.testing.assert_allclose(compiled.bounds, from_obj.bounds, atol=1e-8)
    assert compiled.n_surfaces == from_obj.n_surfaces == 1
    in_scene = Device.parse("void mesh m 5 trough.rtm -t 0 0 1\n0\n0\n", directory=trough)
    np.testing.assert_allclose(in_scene.bounds, np.add(compiled.bounds, [0, 0, 1]), atol=1e-12)


@needs_radiance
def test_an_octree_is_its_scene(trough):
    (trough / "s.rad").write_text(MATERIALS + "red sphere a 0 0 4 0 0 0 1\nshiny ring b 0 0 8 3 0 0 0 0 1 .5 1\n")
    (trough / "s.oct").write_bytes(radiance.run("oconv", "-f", "s.rad", cwd=trough))
    device = Device.parse("void instance i 3 s.oct -s 2\n0\n0\n", directory=trough)
    np.testing.assert_allclose(device.bounds, 2 * np.array(Device.read(trough / "s.rad").bounds), atol=1e-7)
    assert Device.read(trough / "s.oct").n_surfaces == 2


@needs_radiance
def test_smooth_normals_spread_light_as_in_radiance(trough):
    """Reflected peaks of 40 facets are apart; those of a smooth mirror are not, in neither program."""
    (trough / "s.rad").write_text(MATERIALS + "void mesh m 1 trough.rtm 0 0\n")
    rays = np.column_stack([np.linspace(-0.9, 0.9, 361), np.full(361, 0.1), np.full(361, 2.0)])
    (trough / "s.oct").write_bytes(radiance.run("oconv", "s.rad", cwd=trough))
    text = "".join(f"{x:.9f} {y} {z} 0 0 -1\n" for x, y, z in rays)
    out = radiance.run("rtrace", "-h", "-w", "-on", "s.oct", stdin=text, cwd=trough).decode()
    normals = np.array([line.split() for line in out.splitlines()], float)
    # The surface it stands for: z = x²/2 − 0.6.
    expected = np.column_stack([-rays[:, 0], np.zeros(361), np.ones(361)])
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(normals, expected, atol=2e-3)
    device = Device.read(trough / "trough.rtm")
    flat = Device.parse(MATERIALS + radiance.run("gensurf", "shiny", "trough", *TROUGH, 40, 1).decode())
    options = {"rank": 4, "log2_res": 5, "samples": 4096, "sides": "front", "seed": 1, "prune": False}
    smooth, faceted = (bsdftree.generate(d, **options) for d in (device, flat))
    i = np.array([[0.0, 0.0, 1.0]])
    # What leaves in the plane of curvature, once reflected: normals from −24° to 24°.
    polar = np.radians(np.linspace(-40, 40, 321))
    o = np.column_stack([np.sin(polar), np.zeros(321), np.cos(polar)])
    values = [np.array([b.eval(i, v[None])[0] for v in o]) for b in (smooth, faceted)]
    totals = [b.hemispherical(i)[0] for b in (smooth, faceted)]
    print(f"totals {totals}, means {[v.mean() for v in values]}")
    assert abs(totals[0] - totals[1]) < 0.03 and (values[0] > 0).all()
    assert abs(values[0].mean() / values[1].mean() - 1) < 0.1


def test_meshes_without_materials_say_what_to_do(tmp_path):
    (tmp_path / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paint\nf 1 2 3\n")
    with pytest.raises(ValueError, match=r"t\.obj:5: .*found 'paint': define it in a file of materials"):
        Device.read(tmp_path / "t.obj")
    with pytest.raises(ValueError, match=r"t\.obj:5: expected an index of one of the 3 vertices before, found '4'"):
        (tmp_path / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n")
        Device.read(tmp_path / "t.obj")
