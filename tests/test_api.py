"""What Python users call: shapes, errors, grids, threads, generation."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import bsdftree
from bsdftree import Bsdf, Device, Tree, direction_from_polar, generate


@pytest.fixture(scope="module")
def blinds():
    return generate("blinds:angle=30", log2_res=4, samples=200)


@pytest.fixture
def grid(rng):
    """Cells of which some are black and some repeat."""
    return rng.choice([0.0, 0.1, 0.2, 5.0], size=(8, 8, 8, 8)).astype(np.float32)


def test_results_have_the_shape_of_what_was_asked(blinds):
    i = direction_from_polar([10, 20, 30], 40)
    o = direction_from_polar([[170], [150]], 60)
    assert blinds.eval(i, o).shape == (2, 3)
    assert blinds.eval(i[0], o[0, 0]).shape == ()
    assert blinds.eval(i, o, color=True).shape == (2, 3, 3)
    assert blinds.pdf(i, o).shape == (2, 3)
    assert blinds.hemispherical(i).shape == (3,)
    assert blinds.projected_solid_angle(i).shape == (3, 2)
    assert blinds.projected_solid_angle(i, o).shape == (2, 3)
    assert blinds.sample(i, np.zeros((5, 3))).exitant.shape == (5, 3, 3)
    assert blinds.sample(i, np.zeros((3, 2))).weight.shape == (3,)
    assert blinds.sample(i[0], np.zeros(7)).pdf.shape == (7,)
    assert blinds.sample(i[0], np.zeros((7, 2))).pdf.shape == (7,)
    assert blinds.eval(np.empty((0, 3)), np.empty((0, 3))).shape == (0,)


def test_smooth_answers_fit_together_and_keep_the_leaves(blinds, rng):
    smooth = blinds.smooth()
    assert smooth.is_smooth and not blinds.is_smooth
    i = direction_from_polar(rng.uniform(0, 180, 500), rng.uniform(0, 360, 500))
    s = smooth.sample(i, rng.random((500, 2)))
    np.testing.assert_allclose(smooth.pdf(i, s.exitant), s.pdf, rtol=1e-8)
    np.testing.assert_allclose(smooth.hemispherical(i), s.weight, rtol=1e-12)
    value = smooth.eval(i, s.exitant)
    np.testing.assert_allclose(value * abs(s.exitant[:, 2]) / s.pdf, s.weight, rtol=1e-8)
    assert (value != blinds.eval(i, s.exitant)).mean() > 0.5
    for name, tree in blinds.components.items():
        np.testing.assert_array_equal(smooth.components[name].to_grid(), tree.to_grid())


def test_ramps_make_no_light(rng):
    prism = generate("prism", log2_res=4, samples=1000)
    i = direction_from_polar(np.degrees(np.arcsin(np.sqrt(rng.random(20000)))), rng.uniform(0, 360, 20000))
    i[::2, 2] *= -1
    steps, ramps = prism.hemispherical(i), prism.smooth().hemispherical(i)
    assert ramps.max() < 1.025 * max(steps.max(), 1)
    assert ramps.mean() == pytest.approx(steps.mean(), abs=0.002)


def test_smooth_needs_a_tree(blinds):
    with pytest.raises(ValueError, match="tensor trees"):
        blinds.to_klems("quarter").smooth()


def test_samples_have_weights_of_the_colour_they_meet(rng):
    red = """void plastic red 0 0 5 .6 .2 .1 .02 .2
    red polygon sheet 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0"""
    shade = generate(Device.parse(red), log2_res=3, samples=64, color=True)
    i = direction_from_polar(rng.uniform(0, 80, 50), rng.uniform(0, 360, 50))
    u = rng.random(50)
    luminance, color = shade.sample(i, u), shade.sample(i, u, color=True)
    np.testing.assert_array_equal(luminance.exitant, color.exitant)
    np.testing.assert_allclose(color.weight[:, 1], luminance.weight, rtol=1e-6)
    expected = shade.eval(i, color.exitant, color=True) * abs(color.exitant[:, 2:]) / color.pdf[:, None]
    np.testing.assert_allclose(color.weight, expected, rtol=1e-12)
    assert (color.weight[:, 0] > color.weight[:, 2]).all()
    night = bsdftree.Bsdf.from_trees({"reflection_back": Tree.from_grid(np.zeros((2, 2, 2)))})
    assert (night.sample(i, u, color=True).weight == 0).all()


def test_vectors_of_any_length_are_directions(blinds):
    i, o = direction_from_polar(30, 50), direction_from_polar(160, 200)
    assert blinds.eval(2.5 * i, 1e-3 * o) == blinds.eval(i, o)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda b: b.eval([0, 0, 0], [0, 0, 1]), r"incident\[0\].*no direction"),
        (lambda b: b.eval([0, 0, 1], [[0, 0, 1], [0, float("nan"), 1]]), r"exitant\[1\].*no direction"),
        (lambda b: b.eval([0, 1], [0, 0, 1]), r"incident has shape \(2,\)"),
        (lambda b: b.eval(np.ones((2, 3)), np.ones((3, 3))), "do not broadcast"),
        (lambda b: b.sample([0, 0, 1], [1.0]), r"outside \[0, 1\)"),
        (lambda b: b.sample([0, 0, 1], [float("nan")]), r"outside \[0, 1\)"),
        (lambda b: b.hemispherical([0, 0, 1], "specular"), "specular"),
        (lambda b: b.eval([0, 0, 1], [0, 0, 1], band="NIR"), "no band.*Visible"),
        (lambda b: Tree.from_grid(np.ones((3, 3, 3))), r"2\^N"),
        (lambda b: Tree.from_grid(np.ones((4, 4))), r"2\^N"),
        (lambda b: Tree.from_grid(np.full((2, 2, 2), -1)), r"-1\.?0? at index \[0, 0, 0\]"),
        (lambda b: Tree.from_grid(np.full((2, 2, 2), np.inf)), r"inf at index \[0, 0, 0\]"),
        (lambda b: Bsdf.from_trees({"reflection": Tree.from_grid(np.ones((2, 2, 2)))}), "reflection_front"),
        (lambda b: generate("mirror", rank=5), "rank 5"),
        (lambda b: generate("mirror", klems="full", subdivide=100), "patches"),
        (lambda b: generate("mirror", dim=[0, 1, 0, 1]), "xmin xmax"),
        (lambda b: generate("mirror", unit="league"), "league"),
        (lambda b: generate("mirror", up="north"), "north"),
        (lambda b: bsdftree.Device.parse("void plastic p 0 0 5 1 2"), "text:1"),
    ],
)
def test_bad_arguments_say_what_was_expected(blinds, call, message):
    with pytest.raises(ValueError, match=message):
        call(blinds)


def test_grids_survive_the_tree(grid):
    tree = Tree.from_grid(grid)
    np.testing.assert_array_equal(tree.to_grid(), grid)
    np.testing.assert_allclose(tree.to_grid(2), grid.reshape(4, 2, 4, 2, 4, 2, 4, 2).mean(axis=(1, 3, 5, 7)), rtol=1e-6)
    assert tree.depth == 3 and tree.rank == 4


def test_leaves_tile_the_domain(grid):
    cells, levels, values = Tree.from_grid(grid).leaves()
    assert cells.shape == (len(values), 4)
    np.testing.assert_allclose((0.0625**levels).sum(), 1)
    np.testing.assert_allclose((values * 0.0625**levels).sum(), grid.mean(), rtol=1e-6)


def test_saved_files_read_back_the_same(blinds, grid, tmp_path):
    white = Bsdf.from_trees({"reflection_front": Tree.from_grid(grid)}).with_header(
        name="a <b> & c", manufacturer="-- me --", provenance=["made -- by hand"]
    )
    for b in (blinds.with_header(unit="inch"), white):
        b.save(tmp_path / "x.xml")
        again = bsdftree.load(tmp_path / "x.xml")
        assert again.repairs == []
        assert again.to_xml() == b.to_xml()
        assert (again.name, again.manufacturer, again.unit, again.provenance) == (
            b.name, b.manufacturer, b.unit, b.provenance,
        )  # fmt: skip
        for key, tree in b.components.items():
            np.testing.assert_array_equal(again.components[key].to_grid(), tree.to_grid())


def test_a_failed_save_leaves_the_old_file(blinds, tmp_path):
    target = tmp_path / "folder.xml"
    target.mkdir()
    with pytest.raises(OSError, match=r"folder\.xml"):
        blinds.save(target)
    assert list(tmp_path.iterdir()) == [target]


def test_load_mends_only_when_asked(tmp_path):
    b = Bsdf.from_trees({"transmission_back": Tree.from_grid(np.full((1, 1, 1, 1), 0.2))})
    path = tmp_path / "old.xml"
    path.write_text(b.to_xml().replace("Transmission Back", "Transmission"))
    with pytest.raises(ValueError, match=r"line .*Transmission"):
        bsdftree.load(path)
    mended = bsdftree.load(path, strict=False)
    assert "transmission_back" in mended.components and len(mended.repairs) == 1


def test_missing_files_are_os_errors(tmp_path):
    with pytest.raises(FileNotFoundError):
        bsdftree.load(tmp_path / "nothing.xml")


def test_threads_get_the_same_answers(blinds, rng):
    i = direction_from_polar(rng.uniform(0, 180, 4000), rng.uniform(0, 360, 4000))
    u = rng.random(4000)
    alone = blinds.sample(i, u)
    with ThreadPoolExecutor(8) as pool:
        for other in pool.map(lambda _: bsdftree._bsdf.Bsdf(blinds._core).sample(i, u), range(16)):
            np.testing.assert_array_equal(other.exitant, alone.exitant)


def test_samples_estimate_the_total(blinds, rng):
    """The mean of weight x [exitant on the front] is the reflectance: z-test at 1e-5."""
    incident = direction_from_polar(35, 70)
    n = 20_000
    sample = blinds.sample(incident, rng.random(n))
    inside = sample.weight * (sample.exitant[:, 2] > 0)
    error = inside.std() / np.sqrt(n)
    assert abs(inside.mean() - blinds.hemispherical(incident, "reflection")) < 4.4 * error


def test_generation_is_a_function_of_seed_alone():
    def leaves(**options):
        b = generate("blinds:angle=10", rank=3, log2_res=4, samples=100, **options)
        return [tree.leaves()[2].tobytes() for tree in b.components.values()]

    assert leaves(threads=1) == leaves(threads=2)
    assert leaves(seed=1) != leaves(seed=2)


def test_progress_and_report_tell_what_was_done():
    calls, reports = [], []
    generate("mirror", klems="quarter", samples=10, progress=lambda *n: calls.append(n), report=reports.append)
    assert calls[-1] == (820, 820)
    (report,) = reports
    assert report.paths == 820 and report.lost == 0 and report.aperture[1][2] == 0.0


@pytest.mark.parametrize(
    ("klems", "n"),
    [("full", 145), ("half", 77), ("half73", 73), ("quarter", 41), ([(0, 30, 1), (30, 60, 6), (60, 90, 8)], 15)],
)
def test_any_klems_basis_can_be_generated_saved_and_loaded(klems, n, tmp_path):
    b = generate("mirror:reflectance=0.5", klems=klems, samples=40, sides="front")
    b.save(tmp_path / "k.xml")
    matrix = bsdftree.load(tmp_path / "k.xml").components["reflection_back"]
    assert matrix.values.shape == (n, n)
    np.testing.assert_array_equal(matrix.values, b.components["reflection_back"].values)
    np.testing.assert_allclose(b.hemispherical(direction_from_polar([0, 40, 80], 33)), 0.5, rtol=1e-6)


def test_an_error_in_progress_ends_the_generation():
    def fail(done, total):
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        generate("blinds", log2_res=5, samples=1_000_000, progress=fail)


def test_devices_are_written_as_scenes_that_read_back():
    device = bsdftree.Device.from_spec("prism")
    again = bsdftree.Device.parse(device.to_rad())
    assert again.to_rad() == device.to_rad() and again.n_surfaces == device.n_surfaces


def test_every_family_is_drawn_explained_and_built():
    families = bsdftree.device_families()
    assert {f.name for f in families} >= {"blinds", "sawtooth", "prism", "perforated", "mirror"}
    for family in families:
        assert family.drawing.strip() and family.summary
        assert all(p.meaning for p in family.parameters)
        assert bsdftree.Device.from_spec(family.name).n_surfaces > 0


def test_a_generation_that_stops_by_itself_has_the_bits_of_one_of_as_many_samples() -> None:
    reports: list[bsdftree.GenerationReport] = []
    stopped = bsdftree.generate("sawtooth", log2_res=3, tile=True, tolerance=0.1, report=reports.append)
    (report,) = reports
    assert report.stop == "tolerance" and report.error <= 0.1 and report.direction_error <= 0.05
    # Detail follows from the tolerance, so it has to be said.
    again = bsdftree.generate("sawtooth", log2_res=3, tile=True, samples=report.samples, detail=0.1)
    for key, component in stopped.components.items():
        assert np.array_equal(component.to_grid(3), again.components[key].to_grid(3)), key


def test_values_and_totals_come_with_standard_errors() -> None:
    reports: list[bsdftree.GenerationReport] = []
    b = bsdftree.generate("blinds:angle=30", log2_res=3, samples=256, report=reports.append)
    (report,) = reports
    for key, component in b.components.items():
        errors = report.errors.components[key]
        assert errors.n_leaves <= component.n_leaves and (errors.to_grid(3) >= 0).all()
        values, sigmas = report.totals[key]
        assert values.shape == sigmas.shape == (64,)
        assert ((values >= 0) & (values <= 1 + 3 * sigmas)).all()
    assert 0 < report.error < 0.2


def test_time_budgets_are_kept_about() -> None:
    reports: list[bsdftree.GenerationReport] = []
    bsdftree.generate("sawtooth", log2_res=4, time_budget=0.5, report=reports.append)
    assert reports[0].stop == "time" and reports[0].samples >= 64


@pytest.mark.parametrize(
    ("option", "message"),
    [({"tolerance": 0.0}, "tolerance"), ({"detail": -1.0}, "detail"), ({"sampling": "sobolev"}, "expected 'sobol'")],
)
def test_senseless_ways_to_stop_are_refused(option, message) -> None:
    with pytest.raises(ValueError, match=message):
        bsdftree.generate("sawtooth", log2_res=2, samples=8, **option)
