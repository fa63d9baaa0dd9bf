"""Pictures: pixels against eval, orientation, colours of zero, files."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import DATA, NO_DATA
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import bsdftree
from bsdftree import Bsdf, Tree, direction_from_polar, plot
from bsdftree.cli import main
from bsdftree.plot._curve import step_curve
from bsdftree.plot._image import hemisphere_image, matrix_image
from bsdftree.plot._parts import SIDES, diffuse_total, is_black
from bsdftree.plot._style import ZERO, Scale, round_limits

REAL_FILES = sorted(str(p.relative_to(DATA)) for p in DATA.glob("*/*.xml")) or ["none"]


def square_direction(x: float, y: float, side: float) -> list[float]:
    """Shirley and Chiu's map by the table of their paper, one point at a time."""
    a, b = 2 * x - 1, 2 * y - 1
    quarter = np.pi / 4
    if a > -b:
        r, phi = (a, quarter * b / a) if a > b else (b, quarter * (2 - a / b))
    elif a < b:
        r, phi = -a, quarter * (4 + b / a)
    else:
        r, phi = -b, quarter * (6 - a / b) if b else 0.0
    return [r * np.cos(phi), r * np.sin(phi), side * np.sqrt(1 - r * r)]


def expected_mosaic(bsdf: Bsdf, part: str, n: int, m: int) -> np.ndarray:
    """Evaluate at the centre of each pixel: tile column x, tile row y from below, and so inside the tile."""
    sides = SIDES[part]
    pixels = np.empty((n * m, n * m))
    exitant = np.array(
        [[square_direction((c + 0.5) / m, (r + 0.5) / m, sides.exitant) for c in range(m)] for r in range(m)]
    )
    for row in range(n):
        for column in range(n):
            heads = square_direction((column + 0.5) / n, (row + 0.5) / n, -sides.incident)
            tile = bsdf.eval(-np.array(heads), exitant)
            top = (n - 1 - row) * m
            pixels[top : top + m, column * m : (column + 1) * m] = tile[::-1]
    return pixels


def png(figure: Figure) -> io.BytesIO:
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    stream.seek(0)
    return stream


@pytest.fixture(scope="module")
def mirror() -> Bsdf:
    return bsdftree.generate("mirror:reflectance=0.9", log2_res=3, samples=64)


@pytest.fixture(scope="module")
def blinds() -> Bsdf:
    return bsdftree.generate("blinds:angle=45", log2_res=3, samples=500)


@pytest.mark.parametrize("part", list(SIDES))
def test_pixels_of_rank_4_are_values_at_cell_centres(part: str, rng: np.random.Generator) -> None:
    bsdf = Bsdf.from_trees({part: Tree.from_grid(rng.random((4, 4, 4, 4)))})
    assert np.array_equal(plot.mosaic_image(bsdf, part), expected_mosaic(bsdf, part, 4, 4))


@pytest.mark.parametrize("part", list(SIDES))
def test_tiles_of_rank_3_are_polar_angles_in_reading_order(part: str, rng: np.random.Generator) -> None:
    n, columns, rows = 16, 4, 2
    bsdf = Bsdf.from_trees({part: Tree.from_grid(rng.random((n, n, n)))})
    sides = SIDES[part]
    image = plot.mosaic_image(bsdf, part)
    assert image.shape == (rows * n, columns * n)
    exitant = np.array(
        [[square_direction((c + 0.5) / n, (r + 0.5) / n, sides.exitant) for c in range(n)] for r in range(n)]
    )
    for k in range(n // 2):
        sine = (k + 0.5) / (n // 2)  # from normal to grazing; the light comes from -X, so heads to +X
        tile = bsdf.eval([-sine, 0.0, sides.incident * np.sqrt(1 - sine**2)], exitant)[::-1]
        row, column = divmod(k, columns)
        assert np.array_equal(image[row * n : (row + 1) * n, column * n : (column + 1) * n], tile)


def test_mosaic_of_a_klems_matrix_is_eval_at_cell_centres() -> None:
    bsdf = bsdftree.generate("blinds:angle=30", klems="quarter", samples=100)
    # Edges between patches run along the diagonals of the square, where rounding decides.
    i, j = np.indices((8, 8))
    off = (i != j) & (i != 7 - j)
    off_both = np.kron(off, np.ones((8, 8), bool)) & np.tile(off, (8, 8))
    for part in SIDES:
        image = plot.mosaic_image(bsdf, part, log2_res=3, max_px=64)
        assert np.array_equal(image[off_both], expected_mosaic(bsdf, part, 8, 8)[off_both])
        assert np.ptp(image[off_both]) > 0.0


def test_mirrored_light_keeps_the_place_of_its_tile(mirror: Bsdf) -> None:
    n = 8
    tiles = plot.mosaic_image(mirror, "reflection_back").reshape(n, n, n, n).transpose(0, 2, 1, 3)
    for row in range(n):
        for column in range(n):
            peak = np.unravel_index(tiles[row, column].argmax(), (n, n))
            assert peak == (row, column)


def test_mirrored_light_of_rank_3_moves_right_from_the_centre() -> None:
    n, columns = 16, 4
    bsdf = bsdftree.generate("mirror:reflectance=0.9", rank=3, log2_res=4, samples=64)
    image = plot.mosaic_image(bsdf, "reflection_back")
    tiles = image.reshape(2, n, columns, n).transpose(0, 2, 1, 3).reshape(-1, n, n)
    assert [int(tile.max(axis=0).argmax()) for tile in tiles] == list(range(n // 2, n))


def test_light_from_above_is_at_the_bottom(blinds: Bsdf) -> None:
    # A positive angle raises the edge at the room: light from above passes outwards and is stopped inwards.
    outwards, inwards = (plot.mosaic_image(blinds, part) for part in ("transmission_back", "transmission_front"))
    half = len(outwards) // 2
    assert outwards[half:].mean() > 2.0 * outwards[:half].mean()
    assert inwards[:half].mean() > 2.0 * inwards[half:].mean()
    (axes, *_) = plot.mosaic(blinds, part="transmission_back").axes
    places = {text.get_text(): text.get_position() for text in axes.texts}
    assert places["light from above, heading down"][1] < 0.0 < 1.0 < places["light from below, heading up"][1]


def test_coarser_pixels_are_means(rng: np.random.Generator) -> None:
    grid = rng.random((8, 8, 8, 8)).astype(np.float32)
    bsdf = Bsdf.from_trees({"reflection_back": Tree.from_grid(grid)})
    image = plot.mosaic_image(bsdf, "reflection_back", log2_res=1, max_px=8)
    assert image.shape == (8, 8)
    # Bottom left: incident x and y in the lower half, exitant x and y in the lowest quarter.
    assert image[-1, 0] == pytest.approx(float(grid[:4, :4, :2, :2].mean(dtype=np.float64)), rel=1e-6)
    assert image.mean() == pytest.approx(float(grid.mean(dtype=np.float64)), rel=1e-6)


def test_too_many_tiles_are_refused() -> None:
    bsdf = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.arange(256.0).reshape(4, 4, 4, 4))})
    with pytest.raises(ValueError, match="smaller log2_res"):
        plot.mosaic_image(bsdf, "reflection_back", max_px=2)
    with pytest.raises(ValueError, match="the BSDF has reflection_back"):
        plot.mosaic_image(bsdf, "reflection_front")
    with pytest.raises(ValueError, match="no band 'Solar'"):
        plot.mosaic_image(bsdf, "reflection_back", band="Solar")


def test_matrix_runs_incident_right_and_exitant_down() -> None:
    bsdf = bsdftree.generate("blinds:angle=45", klems="quarter", samples=100)
    matrix = bsdf.components["transmission_back"]
    assert isinstance(matrix, bsdftree.Matrix)
    image = matrix_image(matrix, 1024)
    assert np.array_equal(image, matrix.values.T)
    coarse = matrix_image(matrix, 21)  # 41 patches by twos: the last pixel is one patch
    assert coarse.shape == (21, 21)
    assert coarse[0, 1] == pytest.approx(float(matrix.values[2:4, 0:2].mean(dtype=np.float64)), rel=1e-6)
    assert coarse[-1, -1] == pytest.approx(float(matrix.values[-1, -1]))


def test_disk_has_up_at_the_top_and_right_at_the_right(rng: np.random.Generator) -> None:
    bsdf = Bsdf.from_trees({p: Tree.from_grid(rng.random((1, 1, 8, 8)).repeat(8, 0).repeat(8, 1)) for p in SIDES})
    incident = direction_from_polar(40.0, 70.0)
    for side in (1.0, -1.0):
        image = hemisphere_image(bsdf, incident, side, "Visible", 101)
        assert np.isnan(image[0, 0]) and np.isnan(image[-1, -1])
        for row, column, x, y in ((10, 50, 0.0, 0.8), (50, 90, 0.8, 0.0), (70, 20, -0.6, -0.4)):
            x, y = (2 * column + 1) / 101 - 1, 1 - (2 * row + 1) / 101
            assert image[row, column] == bsdf.eval(incident, [x, y, side * np.sqrt(1 - x * x - y * y)])


def test_zero_has_its_own_colour_and_the_share_of_the_picture_that_is_black() -> None:
    grid = np.full((2, 2, 2, 2), 0.3)
    grid[:, 0] = 0.0  # nothing of light that heads down
    bsdf = Bsdf.from_trees({"reflection_back": Tree.from_grid(grid)})
    figure = plot.mosaic(bsdf)
    pixels = np.round(matplotlib.image.imread(png(figure))[..., :3] * 255)
    box = figure.axes[0].get_window_extent()
    height = pixels.shape[0]
    panel = pixels[round(height - box.y1) : round(height - box.y0), round(box.x0) : round(box.x1)]
    black = (panel == np.round(np.array(to_rgb(ZERO)) * 255)).all(axis=-1)
    half = len(panel) // 2
    # Lines between tiles and rings of polar angles cover a little.
    assert black[half:].mean() > 0.95 and black[:half].mean() == 0.0


def test_scale_keeps_zero_apart_from_faint_values() -> None:
    scale = Scale.of([np.array([0.0, 1e-9, 3.0])])
    assert (scale.low, scale.high, scale.clipped) == (pytest.approx(1e-5), 5.0, True)
    with pytest.raises(ValueError, match="0 < lower < upper"):
        Scale.of([np.array([1.0])], limits=(2.0, 1.0))


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ([0.0], (0.1, 1.0)),
        ([0.1], (0.01, 0.1)),
        ([np.float32(0.01), np.float32(0.16)], (0.01, 0.2)),
        ([0.03, 300.0], (0.01, 500.0)),
        ([7.0], (1.0, 10.0)),
        ([1e-20, 7.0], (1e-5, 10.0)),
    ],
)
def test_limits_are_round_and_hold_the_values(values: list[float], limits: tuple[float, float]) -> None:
    assert round_limits(np.array(values), 5) == pytest.approx(limits)


def test_steps_of_a_slice_lie_at_the_edges_of_cells() -> None:
    # Cells along y end at y = -1/2, 0, 1/2 of the square from -1 to 1, where y is sin θ: -30, 0 and 30 degrees.
    along_y = np.array([0.1, 0.2, 0.3, 0.4])
    grid = np.broadcast_to(along_y, (4, 4, 4, 4))
    bsdf = Bsdf.from_trees({"reflection_back": Tree.from_grid(grid)})
    angle, f = step_curve(bsdf, 20.0, 270.0, "Visible")  # from below, heading up
    jumps = np.flatnonzero(np.diff(f) != 0.0)
    assert angle[jumps] == pytest.approx([-90.0, -30.0, 0.0, 30.0, 90.0], abs=1e-5)
    assert f[jumps + 1] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.0])


def test_slices_are_eval(blinds: Bsdf) -> None:
    for theta, phi in ((30.0, 80.0), (120.0, 10.0)):
        angle, f = step_curve(blinds, theta, phi, "Visible")
        inside = np.flatnonzero((f[1:] == f[:-1]) & (np.diff(angle) > 1e-3))
        middle = 0.5 * (angle[inside] + angle[inside + 1])
        exitant = direction_from_polar(middle, phi + 180.0)
        assert np.array_equal(blinds.eval(direction_from_polar(theta, phi), exitant), f[inside])
        assert np.diff(angle)[inside].sum() > 359.9


def test_mirrored_light_leaves_a_slice_at_the_incident_angle(mirror: Bsdf) -> None:
    angle, f = step_curve(mirror, 40.0, 20.0, "Visible")
    assert abs(angle[f == f.max()].mean() - 40.0) < 10.0


def test_slices_and_maps_refuse_what_they_cannot_draw(blinds: Bsdf) -> None:
    with pytest.raises(ValueError, match="from 0 to 180"):
        plot.slice(blinds, theta_deg=[-10.0])
    with pytest.raises(ValueError, match="'log' or 'linear'"):
        plot.slice(blinds, radius="cubic")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="expected unit vectors"):
        plot.polar(blinds, np.zeros(3))


def test_titles_have_the_diffuse_total() -> None:
    white = Bsdf.from_trees({"reflection_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.8 / np.pi))})
    assert diffuse_total(white, "reflection_back", "Visible") == pytest.approx(0.8, rel=1e-6)
    assert plot.mosaic(white).axes[0].get_title(loc="left") == "Reflection back: room → room, 80.00 %"


def test_unused_half_of_rank_3_does_not_make_it_bright() -> None:
    grid = np.zeros((4, 4, 4))
    grid[2:] = 1.0
    assert is_black(Tree.from_grid(grid))
    grid[1, 0, 0] = 1e-6
    assert not is_black(Tree.from_grid(grid))


def test_overview_names_black_components_and_draws_the_others(mirror: Bsdf) -> None:
    figure = plot.overview(mirror, title="a mirror")
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert sum(title.startswith("Reflection back: room → room, ") for title in titles) == 1
    assert not any("ransmission back" in title for title in titles)
    texts = [text.get_text() for text in figure.texts]
    assert "a mirror" in texts
    assert any("black: transmission back, reflection front, transmission front" in text for text in texts)


def test_all_black_bsdf_is_drawn() -> None:
    black = Bsdf.from_trees({part: Tree.from_grid(np.zeros((1,) * 4)) for part in SIDES})
    for figure in (plot.overview(black), plot.mosaic(black), plot.slice(black), plot.polar(black, [0, 0, 1])):
        assert matplotlib.image.imread(png(figure))[..., :3].std() > 0.02


def test_notebooks_show_figures(mirror: Bsdf) -> None:
    assert plot.mosaic(mirror)._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


def test_pyplot_stays_unloaded() -> None:
    program = (
        "import sys, numpy as np\n"
        "from bsdftree import Bsdf, Tree, plot\n"
        "plot.overview(Bsdf.from_trees({'reflection_back': Tree.from_grid(np.ones((1,) * 4))}))._repr_png_()\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_same_bytes_each_time(ending: str, mirror: Bsdf, tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.{ending}" for k in range(2)]
    for path in paths:
        plot.save(plot.overview(mirror), path)
    first, second = (path.read_bytes() for path in paths)
    assert first == second and len(first) > 1000


def test_failed_write_keeps_the_old_file(tmp_path: Path, mirror: Bsdf, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.png"
    target.write_bytes(b"old")
    figure = plot.slice(mirror)

    def fail(path: Path, **_: object) -> None:
        path.write_bytes(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(figure, "savefig", fail)
    with pytest.raises(OSError, match="disk full"):
        plot.save(figure, target)
    assert target.read_bytes() == b"old" and list(tmp_path.iterdir()) == [target]


def test_unknown_ending_is_refused(tmp_path: Path, mirror: Bsdf) -> None:
    with pytest.raises(ValueError, match=r"expected \.png, \.svg or \.pdf"):
        plot.save(plot.slice(mirror), tmp_path / "a.bmp")


@pytest.mark.skipif(REAL_FILES == ["none"], reason=NO_DATA)
@pytest.mark.parametrize("name", REAL_FILES)
def test_command_draws_real_files(name: str, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(main, ["plot", "--repair", str(data / name)])
    written = f"{Path(name).stem}.png"
    assert result.exit_code == 0, result.output
    assert f"wrote {written}" in result.stderr and result.stdout == ""
    assert [path.name for path in tmp_path.iterdir()] == [written]
    assert matplotlib.image.imread(written).shape[1] == 1600


@pytest.fixture
def mirror_file(mirror: Bsdf, tmp_path: Path) -> str:
    path = tmp_path / "mirror.xml"
    mirror.save(path)
    return str(path)


@pytest.mark.parametrize(
    "options",
    [
        ["--kind", "mosaic", "--part", "reflection_back", "--range", "0.01", "100"],
        ["--kind", "slice", "--linear", "--incident", "30", "90", "--incident", "60", "0"],
        ["--kind", "polar", "--incident", "45", "90"],
        ["--kind", "polar", "--incident", "45", "90", "--incident", "120", "0"],
        ["--kind", "polar", "--color"],
        ["--kind", "lobes", "--linear", "--incident", "45", "90"],
        ["--kind", "klems", "--basis", "quarter", "--part", "reflection_back"],
        ["--kind", "hemispherical", "--part", "reflection_back"],
        ["--kind", "stats"],
    ],
)
def test_command_draws_every_kind(options: list[str], mirror_file: str, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    result = CliRunner().invoke(main, ["plot", mirror_file, *options, "-o", str(out), "--dpi", "50"])
    assert result.exit_code == 0, result.output
    image = matplotlib.image.imread(out)
    assert 350 < image.shape[1] < 1000 and image[..., :3].std() > 0.02


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--kind", "lobes", "--incident", "190", "0"], 2, "expected θ from 0 to 180"),
        (["--kind", "compare"], 2, "--kind compare takes two files, not 1"),
        (["--part", "reflection_back"], 2, "--part is for --kind mosaic, hemispherical, klems, stats, not overview"),
        (["--kind", "stats", "--part", "reflection_front", "--band", "Visible"], 0, "wrote"),
        (["--kind", "hemispherical", "--part", "transmission_front"], 0, "wrote"),
        (["-o", "a.bmp"], 2, "expected .png, .svg or .pdf"),
        (["--band", "Solar"], 1, "no band 'Solar'; the BSDF has Visible"),
        (["--kind", "mosaic", "--range", "0", "1"], 1, "expected 0 < lower < upper"),
    ],
)
def test_command_says_what_is_wrong(
    options: list[str], code: int, message: str, mirror_file: str, tmp_path: Path
) -> None:
    output = [] if "-o" in options else ["-o", str(tmp_path / "a.png")]
    result = CliRunner().invoke(main, ["plot", mirror_file, *options, *output])
    assert (result.exit_code, message in result.stderr) == (code, True), result.output
    assert (tmp_path / "a.png").exists() == (code == 0)


def test_missing_matplotlib_says_how_to_install_it(mirror_file: str) -> None:
    program = "import sys; sys.modules['matplotlib'] = None; from bsdftree.cli import main; main(sys.argv[1:])"
    run = [sys.executable, "-c", program]
    result = subprocess.run([*run, "plot", mirror_file], capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "pip install 'bsdftree[plot]'" in result.stderr and "Traceback" not in result.stderr
    assert subprocess.run([*run, "info", mirror_file], capture_output=True, check=False).returncode == 0


def test_unwritable_output_is_named(mirror_file: str, tmp_path: Path) -> None:
    target = tmp_path / "nowhere" / "a.png"
    result = CliRunner().invoke(main, ["plot", mirror_file, "--kind", "slice", "-o", str(target)])
    assert result.exit_code == 1 and f"'{target}'" in result.stderr and ".part" not in result.stderr
