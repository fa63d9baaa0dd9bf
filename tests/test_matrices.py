"""Matrices and raw grids, in and out, with Radiance's own tools."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from radiance import needs_radiance, run

import bsdftree
from bsdftree import Bsdf, Matrix, Tree, read_radiance_matrix, write_radiance_matrix
from bsdftree.cli import main


@needs_radiance
@pytest.mark.parametrize("format", ["ascii", "float", "double"])
@pytest.mark.parametrize("shape", [(3, 4), (3, 4, 3)])
def test_rmtxop_reads_and_writes_them(tmp_path, rng, format, shape):
    a, b = rng.random(shape), rng.random((4, 5, *shape[2:]))
    for name, array in (("a.mtx", a), ("b.mtx", b)):
        write_radiance_matrix(tmp_path / name, array, format)
    (tmp_path / "c.mtx").write_bytes(run("rmtxop", f"-f{format[0]}", "a.mtx", ".", "b.mtx", cwd=tmp_path))
    c = read_radiance_matrix(tmp_path / "c.mtx")
    expected = np.einsum("ijc,jkc->ikc", a.reshape(3, 4, -1), b.reshape(4, 5, -1))
    np.testing.assert_allclose(c, expected, rtol=1e-5)


@needs_radiance
def test_dctimestep_multiplies_by_ours_as_by_the_file(data, tmp_path, rng):
    """V T D s with T from XML by Radiance, and as the matrix that we write."""
    xml = data / "pyradiance/ven45.xml"
    done = CliRunner().invoke(main, ["convert", str(xml), str(tmp_path / "T.mtx")])
    assert done.exit_code == 0, done.output
    assert read_radiance_matrix(tmp_path / "T.mtx").shape == (145, 145, 1)
    three = np.repeat(read_radiance_matrix(tmp_path / "T.mtx"), 3, axis=2)
    write_radiance_matrix(tmp_path / "T3.mtx", three)
    write_radiance_matrix(tmp_path / "V.mtx", np.repeat(rng.random((4, 145, 1)), 3, axis=2))
    write_radiance_matrix(tmp_path / "D.mtx", np.repeat(rng.random((145, 146, 1)), 3, axis=2))
    sky = "\n".join("1 1 1" for _ in range(146))
    header = "#?RADIANCE\nNROWS=146\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n"
    (tmp_path / "s.mtx").write_text(header + sky)
    outputs = []
    for t in (xml, "T3.mtx"):
        (tmp_path / "out.mtx").write_bytes(run("dctimestep", "-of", "V.mtx", t, "D.mtx", "s.mtx", cwd=tmp_path))
        outputs.append(read_radiance_matrix(tmp_path / "out.mtx"))
    assert outputs[0].min() > 0
    np.testing.assert_allclose(outputs[1], outputs[0], rtol=2e-3)


@needs_radiance
def test_rmtxop_has_the_matrix_of_the_file_as_we_write_it(data, tmp_path):
    """Radiance's rmtxop of the XML, and of what `convert` makes of it."""
    xml = data / "pyradiance/ven45.xml"
    assert CliRunner().invoke(main, ["convert", str(xml), str(tmp_path / "T.mtx")]).exit_code == 0
    for name, source in (("ours", "T.mtx"), ("theirs", xml)):
        (tmp_path / f"{name}.mtx").write_bytes(run("rmtxop", "-ff", source, cwd=tmp_path))
    ours, theirs = (read_radiance_matrix(tmp_path / f"{name}.mtx") for name in ("ours", "theirs"))
    assert ours.max() > 0.1
    # Radiance keeps colours of XML in few bits.
    np.testing.assert_allclose(ours[:, :, 0], theirs.mean(2), rtol=0.01, atol=1e-6)


@needs_radiance
@pytest.mark.parametrize("rank", [3, 4])
@pytest.mark.parametrize("raw", ["ascii", "float", "double"])
def test_raw_grids_are_those_of_rttree_reduce(tmp_path, rng, rank, raw):
    n = 8
    grid = rng.random((n,) * rank).astype(np.float32)
    if rank == 3:
        grid[n // 2 :] = 0
    path = tmp_path / "grid"
    if raw == "ascii":
        np.savetxt(path, grid.reshape(-1, n), fmt="%.9g")
    else:
        path.write_bytes(grid.astype({"float": "f4", "double": "f8"}[raw]).tobytes())
    out = tmp_path / "out.xml"
    words = ["convert", "--raw", raw, "--rank", str(rank), "--component", "reflection_back", str(path), str(out)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    ours = bsdftree.load(out)
    np.testing.assert_array_equal(ours.components["reflection_back"].to_grid(), grid)
    reduced = run("rttree_reduce", "-h", f"-f{raw[0]}", "-r", rank, "-g", 3, "-t", 0, path).decode()
    start, end = (ours.to_xml().index(tag) for tag in ("<ScatteringData>", "</ScatteringData>"))
    text = ours.to_xml()
    (tmp_path / "theirs.xml").write_text(text[: start + 16] + reduced + text[end:])
    theirs = bsdftree.load(tmp_path / "theirs.xml").components["reflection_back"]
    # It prints seven digits after the point.
    np.testing.assert_allclose(theirs.to_grid(3), grid, rtol=1e-5, atol=6e-8)


def test_real_grid_is_read(data, tmp_path):
    """genBSDF's own output before reduction: the values of Radiance's data file, after a header."""
    path = tmp_path / "sawtooth.txt"
    path.write_text("#?RADIANCE\nFORMAT=ascii\n\n" + (data / "radiance/sawtooth.dat").read_text().partition("\n\n")[2])
    out = tmp_path / "s.xml"
    words = ["convert", "--raw", "ascii", "--component", "reflection_back", str(path), str(out)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    totals = bsdftree.load(out).hemispherical(bsdftree.direction_from_polar([5, 30, 60, 80], 45))
    assert ((totals > 0.61) & (totals < 0.70)).all()


@pytest.mark.parametrize(
    ("content", "raw", "said"),
    [
        (b"1 2 x", "ascii", "value 2 is 'x'; expected a number"),
        (b"1 2 3", "ascii", "3 values; expected (2^N)^4"),
        (b"12345", "float", "5 bytes of values; expected a multiple of 4"),
        (b"#?RADIANCE\n", "float", "without an empty line"),
    ],
)
def test_faulty_raw_grids_are_refused(tmp_path, content, raw, said):
    (tmp_path / "grid").write_bytes(content)
    done = CliRunner().invoke(main, ["convert", "--raw", raw, str(tmp_path / "grid"), str(tmp_path / "out.xml")])
    assert done.exit_code == 1 and said in done.output and "grid" in done.output
    assert not (tmp_path / "out.xml").exists()


def test_matrix_of_an_array_is_that_array(rng):
    values = rng.random((145, 145)).astype(np.float32)
    matrix = Matrix.from_values(values)
    np.testing.assert_array_equal(matrix.values, values)
    incident, exitant = matrix.projected_solid_angles()
    assert incident.sum() == pytest.approx(np.pi)
    b = Bsdf.from_components({"reflection_back": matrix})
    assert b.hemispherical([0, 0, 1]) == pytest.approx(values[0] @ exitant)
    np.testing.assert_allclose(matrix.weighted()[3, 7], values[7, 3] * incident[7])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Matrix.from_values(np.zeros((3, 3))), "expected (145, 145)"),
        (lambda: Tree.from_raw(np.zeros(17)), "expected (2^N)^4"),
        (lambda: write_radiance_matrix("x", np.zeros(3)), "expected (rows, columns)"),
        (lambda: write_radiance_matrix("/tmp", np.zeros((3, 3)), "half"), 'expected "ascii"'),
    ],
)
def test_what_does_not_fit_is_said(make, said):
    with pytest.raises(ValueError) as error:
        make()
    assert said in str(error.value)


def test_faulty_matrix_file_is_named(tmp_path):
    (tmp_path / "bad.mtx").write_text("#?RADIANCE\nNROWS=2\nNCOLS=2\nNCOMP=1\nFORMAT=ascii\n\n1 2 3\n")
    with pytest.raises(ValueError, match=r"bad\.mtx: 3 values after the header; expected 4"):
        read_radiance_matrix(tmp_path / "bad.mtx")
