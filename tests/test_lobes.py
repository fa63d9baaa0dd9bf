"""Lobes as meshes: closed, as large as the BSDF, and as Radiance's obj2mesh and rtrace find them."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from radiance import needs_radiance, run

import bsdftree
from bsdftree import Bsdf, Tree
from bsdftree._lobes import lobe_solid, lobe_values
from bsdftree.cli import main

FILES = ["pyradiance/ven45.xml", "pyradiance/t3.xml", "radiance/sawtooth.xml"]


def triangles(lobe):
    """Corners of all triangles, (n, 3, 3)."""
    quads = lobe.vertices[lobe.faces]
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_lobe_is_closed_and_faces_outwards(rng, side):
    """Areas of a closed surface, as vectors, are 0 in sum; its volume is that of pyramids under the cells."""
    radii = rng.random((8, 8)) ** 3
    radii[rng.random((8, 8)) < 0.3] = 0
    lobe = lobe_solid(radii, side)
    corners = triangles(lobe)
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    np.testing.assert_allclose(areas.sum(0), 0, atol=1e-12)
    volume = (corners.mean(1) * areas).sum() / 3
    sphere = lobe_solid(np.ones((8, 8)), side)
    tops = triangles(sphere._replace(faces=sphere.faces[:64]))
    each = (np.linalg.det(tops) / 6).reshape(2, 64).sum(0)
    assert volume == pytest.approx((each * radii.ravel() ** 3).sum(), rel=1e-9)
    assert (side * lobe.vertices[:, 2] >= -1e-12).all()


def test_a_diffuser_is_a_hemisphere():
    lobe = lobe_solid(np.ones((64, 64)), 1.0)
    distance = np.linalg.norm(lobe.vertices, axis=1)
    assert np.allclose(distance[distance > 0], 1)
    corners = triangles(lobe)
    assert np.linalg.det(corners).sum() / 6 == pytest.approx(2 * np.pi / 3, rel=6e-3)


@pytest.mark.parametrize("name", FILES)
def test_cells_have_the_light_of_the_file(data, name):
    b = bsdftree.load(data / name, strict=False)
    incident = bsdftree.direction_from_polar(35, 80)
    for side, part in ((1, "reflection"), (-1, "transmission")):
        for log2_res in (6, 3):
            light = np.pi * lobe_values(b, incident, side, log2_res=log2_res).mean()
            # Klems patches and cells of rank 3 are cut by those of the mesh, and looked at by points.
            assert light == pytest.approx(b.hemispherical(incident, part), rel=0.01, abs=1e-7)


@needs_radiance
@pytest.mark.parametrize("radius", ["linear", "log"])
def test_radiance_meets_the_mesh_where_the_value_is(tmp_path, radius):
    """Rays to the middle, from where light goes: what they have left is 1 at the largest value."""
    grid = np.zeros((8,) * 4)
    grid[...] = np.random.default_rng(3).random((8, 8)) ** 4 + 0.001
    b = Bsdf.from_trees({"reflection_back": Tree.from_grid(grid), "transmission_back": Tree.from_grid(grid / 3)})
    incident = bsdftree.direction_from_polar(30, 90)
    top = bsdftree.save_lobes(tmp_path / "lobe.obj", b, incident, radius=radius, log2_res=5)
    materials = "".join(f"void plastic {m} 0 0 5 1 1 1 0 0\n" for m in ("light", "reflection", "transmission"))
    (tmp_path / "m.rad").write_text(materials)
    run("obj2mesh", "-a", "m.rad", "lobe.obj", "lobe.rtm", cwd=tmp_path)
    scene = "void mesh lobe 1 lobe.rtm 0 0\n"
    (tmp_path / "scene.oct").write_bytes(run("oconv", "-", stdin=scene, cwd=tmp_path))
    at = (4 * np.arange(8) + 1.5) / 32
    for side in (1.0, -1.0):
        directions = bsdftree._directions.direction_from_square(at[:, None], at, side).reshape(-1, 3)
        rays = "\n".join(" ".join(f"{v:.9g}" for v in ray) for ray in np.hstack([2 * directions, -directions]))
        words = ["-h", "-faa", "-oL", "-ab", "0", "-w", "scene.oct"]
        left = 2 - np.array(run("rtrace", *words, stdin=rays, cwd=tmp_path).split(), float)
        values = b.eval(incident, directions) / top
        expected = values if radius == "linear" else 1 + np.log10(values) / 4
        # The sign of the light is in the way of some.
        free = np.degrees(np.arccos(directions @ incident)) > 12
        assert free.sum() > 58
        # A cell is flat: its middle is nearer than its corners, at 2^5 by up to 1 %.
        assert (left[free] < expected[free] + 1e-5).all()
        np.testing.assert_allclose(left[free], expected[free], rtol=0.01, atol=1e-4)


def test_several_lobes_stand_side_by_side(data, tmp_path):
    out = tmp_path / "lobes.obj"
    words = ["lobes", str(data / "pyradiance/ven45.xml"), "--incident", "150", "90", "--incident", "40", "0"]
    done = CliRunner().invoke(main, [*words, "-o", str(out)])
    assert done.exit_code == 0 and "/sr is 1 from the middle" in done.output
    names = [line[2:] for line in out.read_text().splitlines() if line.startswith("o ")]
    assert names == [f"{w}_{d}" for d in ("150_90", "40_0") for w in ("light", *_order(d))]
    x = np.array([float(line.split()[1]) for line in out.read_text().splitlines() if line.startswith("v ")])
    assert x.min() < -0.2 and x.max() > 2.7
    assert ((x < 1.25) | (x > 1.25)).all()


def _order(direction: str) -> list[str]:
    """Room first."""
    return ["transmission", "reflection"] if direction == "150_90" else ["reflection", "transmission"]


@pytest.mark.parametrize(
    ("words", "said", "code"),
    [
        (["--incident", "150", "90", "-o", "{0}/x.ply"], "ends in .obj", 2),
        (["-o", "{0}/x.obj"], "--incident", 2),
        (["--incident", "150", "90", "--band", "UV", "-o", "{0}/x.obj"], "UV", 1),
        (["--incident", "nan", "90", "-o", "{0}/x.obj"], "expected unit vectors", 1),
    ],
)
def test_what_is_no_lobe_is_said(data, tmp_path, words, said, code):
    words = [word.format(tmp_path) for word in words]
    done = CliRunner().invoke(main, ["lobes", str(data / "pyradiance/ven45.xml"), *words])
    assert done.exit_code == code and said in done.output, done.output
    assert not list(tmp_path.iterdir())
