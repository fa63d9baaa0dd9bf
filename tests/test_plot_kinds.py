"""Pictures of every kind on every file, and the numbers in them against closed forms."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from conftest import DATA, NO_DATA
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import bsdftree
from bsdftree import Bsdf, Tree, direction_from_polar, plot
from bsdftree._cells import cells_of
from bsdftree._sides import SIDES
from bsdftree._totals import mean_total
from bsdftree.plot._compare import differences

REAL_FILES = sorted(str(p.relative_to(DATA)) for p in DATA.glob("*/*.xml")) or ["none"]
QUICK = ("overview", "slice", "mosaic", "hemispherical", "thumbnail")
SLOW = ("polar", "lobes", "klems", "stats")
KINDS = QUICK + SLOW
# One of each structure: rank 4, rank 3, Klems in one band and in two, one side alone.
DIFFERENT = (
    "radiance/sawtooth.xml", "pyradiance/t3.xml", "frads/ec60.xml", "pyradiance/ven45.xml",
    "ignis/simple_tensor_trans.xml", "ignis/simple_tensor_d2_t3_trans.xml",
)  # fmt: skip


def pixels(figure: Figure) -> np.ndarray:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=30)
    stream.seek(0)
    return matplotlib.image.imread(stream)[..., :3]


def lambertian(value: float, parts: tuple[str, ...] = tuple(SIDES), log2_res: int = 0) -> Bsdf:
    grid = np.full((1 << log2_res,) * 4, value)
    return Bsdf.from_trees({part: Tree.from_grid(grid) for part in parts})


@pytest.fixture(scope="module")
def colored() -> Bsdf:
    def f(incident: np.ndarray, exitant: np.ndarray) -> np.ndarray:
        return (0.1 + 0.05 * exitant[:, :1] ** 2) * np.array([1.0, 0.8, 0.3])

    return Bsdf.from_function(f, 4, 3, color=True)


@pytest.mark.skipif(REAL_FILES == ["none"], reason=NO_DATA)
@pytest.mark.parametrize("name", REAL_FILES)
def test_real_files_are_drawn_in_every_band(name: str, data: Path) -> None:
    bsdf = bsdftree.load(data / name, strict=False)
    for band in bsdf.bands:
        for kind in QUICK:
            image = pixels(getattr(plot, kind)(bsdf, band=band))
            assert image.std() > 0.01, (kind, band)


@pytest.mark.skipif(REAL_FILES == ["none"], reason=NO_DATA)
@pytest.mark.parametrize("name", DIFFERENT)
def test_slow_kinds_draw_files_of_every_structure(name: str, data: Path) -> None:
    bsdf = bsdftree.load(data / name, strict=False)
    for kind in SLOW:
        # The last band, since the first is what they take by themselves.
        assert pixels(getattr(plot, kind)(bsdf, band=bsdf.bands[-1])).std() > 0.01, kind
    assert pixels(plot.compare(bsdf, bsdf.to_klems("quarter"))).std() > 0.01


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_draws_color_and_nothing(kind: str, colored: Bsdf) -> None:
    assert pixels(getattr(plot, kind)(colored)).std() > 0.01
    assert pixels(getattr(plot, kind)(lambertian(0.0))).std() > 0.001


def test_totals_of_a_lambertian_are_level_lines() -> None:
    figure = plot.hemispherical(lambertian(0.25 / np.pi, ("reflection_back", "transmission_front")))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert [title.split(":")[0] for title in titles] == ["Reflection back", "Transmission back", "Transmission front"]
    assert titles[1].endswith("the other one reversed") and not titles[2].endswith("reversed")
    for axes in figure.axes:
        assert len(axes.lines) == 5
        for line in axes.lines:
            assert np.allclose(line.get_ydata(), 25.0, rtol=1e-5)


def test_matrix_view_of_a_tree_is_its_klems_matrix(rng: np.random.Generator) -> None:
    bsdf = Bsdf.from_trees({"reflection_back": Tree.from_grid(rng.random((4, 4, 4, 4)) + 0.1)})
    (image,) = plot.klems(bsdf).axes[0].images
    matrix = bsdf.to_klems("full").components["reflection_back"]
    assert isinstance(matrix, bsdftree.Matrix)
    assert np.allclose(np.asarray(image.get_array()), matrix.values.T)
    (image,) = plot.klems(bsdf, basis="quarter").axes[0].images
    assert np.asarray(image.get_array()).shape == (41, 41)


@pytest.mark.parametrize("rank", [3, 4])
def test_cells_hold_all_directions_and_all_light(rank: int, rng: np.random.Generator) -> None:
    grid = rng.random((8,) * rank)
    grid[(slice(0, 4),) * rank] = 0.3
    tree = Tree.from_grid(grid)
    cells = cells_of(tree)
    assert cells.labels == ["2^0", "2^1", "2^2", "2^3"]
    assert cells.counts.sum() == tree.n_leaves and cells.counts[1] == 1
    assert cells.shares.sum() == pytest.approx(1.0) and cells.light.sum() == pytest.approx(1.0)
    # A tree scatters pi times the mean of its values, weighted by projected solid angle.
    bsdf = Bsdf.from_trees({"reflection_back": tree})
    mean = float((cells.share * cells.values).sum())
    assert np.pi * mean == pytest.approx(mean_total(bsdf, 1.0, "reflection"), rel=0.02)


def test_cells_of_a_matrix_are_its_patches() -> None:
    matrix = lambertian(0.3).to_klems("full").components["reflection_back"]
    cells = cells_of(matrix)
    assert cells.counts.sum() == 145 * 145 and cells.labels[0] == "0–5°" and cells.counts[0] == 145
    assert cells.shares[0] == pytest.approx(np.sin(np.radians(5)) ** 2, rel=1e-6)
    assert np.allclose(cells.light, cells.shares, rtol=1e-6)


def test_errors_are_those_of_a_scaled_copy() -> None:
    found = {d.part: d for d in differences(lambertian(0.1), lambertian(0.15), "Visible")}
    assert set(found) == set(SIDES)
    for d in found.values():
        assert d.relative_l1 == pytest.approx(0.5, rel=1e-5)
        assert (d.total_a, d.total_b) == pytest.approx((0.1 * np.pi, 0.15 * np.pi), rel=1e-5)
        assert d.worst_total == pytest.approx(0.05 * np.pi, rel=1e-5)
    same = differences(lambertian(0.1), lambertian(0.1), "Visible")
    assert all(d.relative_l1 == 0.0 and d.worst_total == 0.0 for d in same)


def test_comparison_draws_difference_and_ratio() -> None:
    figure = plot.compare(lambertian(0.1), lambertian(0.15), direction_from_polar(30, 90), names=("first", "second"))
    for row in range(2):
        a, b, difference, ratio = (
            np.asarray(axes.images[0].get_array()) for axes in figure.axes[4 * row : 4 * row + 4]
        )
        for image, value in ((a, 0.1), (b, 0.15), (difference, 0.05), (ratio, 1.5)):
            assert np.nanmin(image) == pytest.approx(value, rel=1e-5) == np.nanmax(image)
    texts = [text.get_text() for text in figure.texts]
    assert "A: first" in texts and "50.00 %" in texts


def test_comparison_of_bands_that_one_lacks_is_refused() -> None:
    with pytest.raises(ValueError, match="no band 'Solar'"):
        plot.compare(lambertian(0.1), lambertian(0.1), band="Solar")


def test_a_lobe_of_a_diffuser_is_half_a_ball(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[np.ndarray] = []

    class Recorded(Poly3DCollection):
        def __init__(self, corners: np.ndarray, **options: object) -> None:
            drawn.append(np.concatenate(list(corners)))
            super().__init__(corners, **options)

    monkeypatch.setattr("bsdftree.plot._lobes.Poly3DCollection", Recorded)
    plot.lobes(lambertian(0.2, ("reflection_back",), 2), [0, 0, 1], radius="linear")
    _rim, solid = drawn
    assert solid[:, 2].min() >= -1e-9 and solid[:, 2].max() == pytest.approx(1.0, abs=1e-3)
    far = np.linalg.norm(solid, axis=-1)
    # The floor reaches from the rim to the middle.
    assert np.all((np.abs(far - 1.0) < 1e-5) | ((far == 0.0) & (solid[:, 2] == 0.0)))


def test_maps_of_many_directions_are_eval(rng: np.random.Generator) -> None:
    bsdf = Bsdf.from_trees({part: Tree.from_grid(rng.random((4, 4, 4, 4)) + 0.1) for part in SIDES})
    incident = direction_from_polar([20.0, 130.0], [30.0, 200.0])
    axes = plot.polar(bsdf, incident).axes
    for k, vector in enumerate(incident):
        for row, side in enumerate((1.0, -1.0)):
            image = np.asarray(axes[2 * k + row].images[0].get_array())
            n = len(image)
            x, y = (2 * (n // 3) + 1) / n - 1, 1 - (2 * (n // 4) + 1) / n
            exitant = [x, y, side * np.sqrt(1 - x * x - y * y)]
            assert image[n // 4, n // 3] == pytest.approx(float(bsdf.eval(vector, exitant)))


def test_notebooks_show_a_table_and_a_picture(colored: Bsdf) -> None:
    png = colored._repr_png_()
    assert png is not None and png.startswith(b"\x89PNG") and len(png) < 150_000
    html = colored.with_header(name="<b>&")._repr_html_()
    assert html.count("<tr>") == 5 and 'src="data:image/png;base64,' in html
    assert "&lt;b&gt;&amp;" in html and "colour" in html and "room → outside" in html


def test_notebooks_show_the_table_without_matplotlib() -> None:
    program = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from bsdftree import Bsdf, Tree\n"
        "b = Bsdf.from_trees({'reflection_back': Tree.from_grid([[[[0.25 / 3.14159265]]]])})\n"
        "assert b._repr_png_() is None\n"
        "html = b._repr_html_()\n"
        "assert '<img' not in html and '25.00 %' in html and html.endswith('</table>'), html\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_maps_in_color_have_the_hue_of_the_light(colored: Bsdf) -> None:
    for bsdf, ordered in ((colored, True), (lambertian(0.1), False)):
        for incident in ([0, 0, 1], [[0, 0, 1]]):
            rgba = np.asarray(plot.polar(bsdf, incident, color=True).axes[0].images[0].get_array())
            n = len(rgba)
            assert rgba[0, 0, 3] == 0.0 and rgba[n // 2, n // 2, 3] == 1.0
            red, green, blue = (float(c) for c in rgba[n // 2, n // 3, :3])
            # X = 1, Z = 0.3 of equal-energy white is orange; without colour all is grey.
            assert red > green + 0.05 > blue + 0.1 if ordered else max(red, green, blue) - min(red, green, blue) < 0.01
