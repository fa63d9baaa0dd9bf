"""`engine="radiance"` makes the BSDFs of our own tracer, within its noise, and cleans up after itself."""

import tempfile
import time
from itertools import pairwise

import numpy as np
import pytest
import radiance
from alike import OURS, STUDENT, assert_alike, both_sides
from radiance import needs_radiance

import bsdftree
from bsdftree import Bsdf, Device, GenerationReport
from bsdftree._radiance.programs import RadianceError

pytestmark = needs_radiance

BLINDS = "blinds:angle=30,height=0.4,width=0.4"
GLASS = "void glass it 0 0 3 .8 .8 .8\nit polygon pane 0 0 12  0 0 -0.001  1 0 -0.001  1 1 -0.001  0 1 -0.001\n"
TINTED = GLASS.replace(".8 .8 .8", ".9 .6 .3")
SAMPLES = 160
FEWER = ("-ad", "60")
"""Fewer rays where light is diffused; in the mean nothing changes."""


@pytest.fixture
def scene(tmp_path):
    """A function from a spec or a scene text to a scene file."""

    def write(text: str):
        path = tmp_path / "device.rad"
        path.write_text(text if "polygon" in text else Device.from_spec(text).to_rad())
        return path

    return write


def theirs(device, **options) -> tuple[Bsdf, GenerationReport]:
    reports: list[GenerationReport] = []
    options = {"rcontrib": FEWER} | options
    bsdf = bsdftree.generate(device, engine="radiance", report=reports.append, **options)
    return bsdf, reports[0]


def assert_totals_alike(report, ours: Bsdf, atol: float = 0.005) -> None:
    """Assert that the light in each component is the same to half a percent of what comes in, and of each direction."""
    for key, (totals, errors) in report.totals.items():
        grid = ours.components[key]
        values = grid.values if hasattr(grid, "values") else None
        assert values is not None
        expected = values @ report_areas(grid)
        weights = report_areas(grid) / np.pi
        assert abs(weights @ (totals - expected)) < atol, key
        z = (totals - expected) / np.hypot(errors, np.sqrt(expected * (1 - expected).clip(0) / OURS) + 1e-4)
        print(f"{key}: {weights @ totals:.4f} {weights @ (totals - expected):+.4f}, |z| at most {abs(z).max():.2f}")
        assert abs(z).max() < STUDENT, key


def report_areas(matrix) -> np.ndarray:
    lower, upper, n = np.array(matrix.exitant_rings).T
    ring = np.pi * (np.cos(np.radians(lower)) ** 2 - np.cos(np.radians(upper)) ** 2) / n
    return np.repeat(ring, n.astype(int))


@pytest.mark.parametrize("spec", ["sawtooth", BLINDS, GLASS], ids=["sawtooth", "blinds", "glass"])
@pytest.mark.parametrize("klems", ["quarter", "half"])
def test_matrices_of_both_engines_are_alike(scene, spec, klems):
    path = scene(spec)
    bsdf, report = theirs(path, klems=klems, samples=SAMPLES, seed=2)
    ours = bsdftree.generate(path, klems=klems, samples=OURS, seed=5)
    assert_alike(bsdf, ours, SAMPLES, total=0.005)
    assert_totals_alike(report, ours)


@pytest.mark.parametrize("spec", ["sawtooth", BLINDS, GLASS], ids=["sawtooth", "blinds", "glass"])
def test_rank_4_trees_of_both_engines_are_alike(scene, spec):
    path = scene(spec)
    bsdf, _ = theirs(path, rank=4, log2_res=3, samples=SAMPLES, prune=False, seed=2)
    ours = bsdftree.generate(path, rank=4, log2_res=3, samples=OURS, prune=False, seed=6)
    assert_alike(bsdf, ours, SAMPLES, 3, total=0.005)


@pytest.mark.parametrize("spec", [BLINDS, GLASS], ids=["blinds", "glass"])
def test_rank_3_trees_of_both_engines_are_alike(scene, spec):
    path = scene(spec)
    made = theirs(path, rank=3, log2_res=4, samples=4 * SAMPLES, prune=False, seed=2)[0]
    ours = bsdftree.generate(path, rank=3, log2_res=4, samples=OURS, prune=False, seed=6)
    # Peaks lie on the border of two cells, which share them.
    a, b = (Bsdf.from_trees({k: both_sides(t) for k, t in x.components.items()}) for x in (made, ours))
    assert_alike(a, b, 4 * SAMPLES, 4, total=0.01 if spec == BLINDS else 0.005)


def test_subdivided_and_own_bases_are_alike(scene):
    path = scene(BLINDS)
    rings = [(0.0, 20.0, 1), (20.0, 50.0, 6), (50.0, 90.0, 10)]
    for options in ({"klems": "quarter", "subdivide": 2}, {"klems": rings}):
        bsdf, report = theirs(path, samples=1280 if "subdivide" not in options else 160, sides="front", **options)
        ours = bsdftree.generate(path, samples=OURS, sides="front", seed=6, **options)
        assert set(bsdf.components) == {"reflection_back", "transmission_back"}
        assert_totals_alike(report, ours)


def test_colour_is_ours(scene):
    path = scene(TINTED)
    i = bsdftree.direction_from_polar([10, 40, 60, 120, 150], [0, 50, 100, 200, 300])
    for options in ({"klems": "quarter"}, {"rank": 4, "log2_res": 3}):
        bsdf, _ = theirs(path, samples=400, color=True, prune=False, **options)
        ours = bsdftree.generate(path, samples=OURS, color=True, prune=False, **options)
        a, b = (x.eval(i, -i, color=True) for x in (bsdf, ours))
        assert (b.max(axis=1) > 1).all() and len(set(np.round(b[0] / b[0, 1], 3))) == 3
        np.testing.assert_allclose(a / a[:, 1:2], b / b[:, 1:2], rtol=0.02)


def test_culling_does_not_bleach(scene):
    """genBSDF takes white for the colour of dark cells, and merges that with the peaks beside them."""
    path = scene(TINTED)
    i = bsdftree.direction_from_polar([10, 40, 60], [0, 50, 100])
    for rank in (3, 4):
        bsdf, _ = theirs(path, rank=rank, log2_res=3, samples=64, color=True, sides="front")
        u, _ = bsdf.chroma_of()["transmission_back"]
        x, y, z = bsdf.eval(i, -i, color=True).T
        transmitted = np.array(bsdftree._core.XYZ_FROM_RGB) @ np.array([0.9, 0.6, 0.3])
        # Bleached, z / y would be nearly 1.
        np.testing.assert_allclose(x / y, transmitted[0] / transmitted[1], rtol=0.03)
        np.testing.assert_allclose(z / y, transmitted[2] / transmitted[1], rtol=0.2)
        assert u.n_leaves < 8**rank / 4


def test_errors_are_those_that_runs_have(scene):
    """Standard errors of totals describe the scatter of runs with other seeds."""
    path = scene(BLINDS)
    runs = [theirs(path, klems="quarter", samples=64, sides="front", seed=seed)[1] for seed in range(12)]
    for key in runs[0].totals:
        totals = np.array([r.totals[key][0] for r in runs])
        errors = np.array([r.totals[key][1] for r in runs])
        ratio = totals.var(axis=0, ddof=1).mean() / (errors**2).mean()
        print(f"{key}: variance of runs over what they said {ratio:.2f}")
        # 41 directions × 11 degrees of freedom, neighbours correlated; 5 deviations of a tenth of them.
        assert 0.5 < ratio < 2


def test_culled_trees_keep_the_light(scene):
    path = scene("sawtooth")
    whole, _ = theirs(path, rank=4, log2_res=3, samples=160, prune=False, sides="front")
    culled, report = theirs(path, rank=4, log2_res=3, samples=160, cull_percent=80, sides="front")
    key = "reflection_back"
    assert culled.components[key].n_leaves < 0.5 * whole.components[key].n_leaves
    a, b = (x.components[key].to_grid(3).mean() for x in (whole, culled))
    assert abs(a - b) < 0.01 * a
    assert report.reducing_seconds > 0 and report.stop == "samples" and report.paths == 64 * 160
    averaged, _ = theirs(path, rank=4, log2_res=3, samples=160, cull_percent=0, sides="front", reciprocity=True)
    grid = averaged.components[key].to_grid(3)
    np.testing.assert_allclose(grid, grid.transpose(2, 3, 0, 1)[::-1, ::-1, ::-1, ::-1], rtol=1e-3, atol=1e-6)


def test_units_and_up_are_ours(tmp_path):
    standing = tmp_path / "standing.rad"
    standing.write_text("void plastic p 0 0 5 .2 .2 .2 0 0\np polygon a 0 0 12  0 0 0  40 0 0  40 10 20  0 10 20\n")
    options = {"klems": "quarter", "samples": 160, "unit": "inch", "up": "z", "sides": "front"}
    made, report = theirs(standing, **options)
    ours = bsdftree.generate(standing, **options | {"samples": OURS})
    for name in ("width", "height", "thickness", "unit"):
        assert getattr(made, name) == pytest.approx(getattr(ours, name)), name
    assert_alike(made, ours, 160)
    np.testing.assert_allclose(report.aperture, [[0, 0, -10 * 0.0254], [40 * 0.0254, 20 * 0.0254, 0]], atol=1e-6)
    dim = (10, 30, 5, 15, -12, 0)
    made, report = theirs(standing, **options | {"dim": dim})
    np.testing.assert_allclose(np.transpose(report.aperture).ravel() / 0.0254, dim)
    # A device that was read is in metres.
    made, _ = theirs(Device.read(standing, unit="inch").turned_up("z"), **options | {"dim": dim, "up": "y"})
    assert (made.width, made.height, made.thickness) == pytest.approx((20 * 0.0254, 10 * 0.0254, 12 * 0.0254))


def test_scenes_that_our_reader_does_not_know_are_traced(data, tmp_path):
    bsdf, _ = theirs(
        data / "radiance/prism1.rad", klems="quarter", samples=16, sides="front", dim=(-1, 1, -1, 1, -1, 0)
    )
    assert 0.0 < bsdf.hemispherical([0, 0, 1]) <= 1.0 + 1e-6
    mgf = data / "radiance/sawtooth.mgf"
    bsdf, _ = theirs(mgf, klems="quarter", samples=64, sides="front")
    ours = bsdftree.generate(data / "radiance/sawtooth.rad", klems="quarter", samples=OURS, sides="front")
    a, b = (x.hemispherical(bsdftree.direction_from_polar([10, 30, 50], 40)) for x in (bsdf, ours))
    np.testing.assert_allclose(a, b, atol=0.1)


def test_progress_counts_rays_and_nothing_stays_behind(scene, monkeypatch, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    seen = []
    theirs(scene(GLASS), klems="quarter", samples=16, progress=lambda *p: seen.append(p))
    assert seen[-1] == (2 * 41 * 16, 2 * 41 * 16) and all(a < b for a, b in pairwise(seen))
    assert list(temporary.iterdir()) == []

    def stop(done, total):
        raise KeyboardInterrupt

    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        theirs(scene(BLINDS), rank=4, log2_res=5, samples=4000, progress=stop)
    assert time.monotonic() - began < 60
    assert list(temporary.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tile": True}, "knows no tile"),
        ({"tolerance": 0.1}, "knows no tolerance"),
        ({"checkpoint": "x"}, "knows no checkpoint"),
        ({"sampling": "random"}, "knows no sampling"),
        ({"rcontrib": ["-o", "x"]}, "is not given '-o'"),
        ({"rcontrib": ["-ab"]}, "expected a number"),
        ({"rcontrib": ["-ab", "much"]}, "rcontrib failed"),
        ({"rcontrib": ["@nothing.opt"]}, "nothing.opt"),
        ({"cull_percent": 100.0}, "a culling of 100.0 %"),
        ({"samples": 0}, "0 samples"),
        ({"log2_res": 9}, "GiB"),
        ({"log2_res": 0}, "2^0"),
        ({"klems": "third"}, "third"),
        ({"up": "w"}, "up is 'w'"),
        ({"unit": "cubit"}, "no unit 'cubit'"),
        ({"sides": "left"}, "sides 'left'"),
    ],
)
def test_bad_options_say_what_is_wrong(options, message):
    with pytest.raises(ValueError) as error:
        bsdftree.generate("mirror", engine="radiance", **options)
    assert message in str(error.value)


def test_bad_scenes_say_what_is_wrong(tmp_path):
    path = tmp_path / "d.rad"
    for text, message in [
        ("", "the scene has no surfaces"),
        ("void plastic p 0 0 5 .5 .5 .5 0 0\np polygon a 0 0 9 0 0 0 0 1 0 0 1 -1\n", "no extent along X"),
        ("white polygon a 0 0 9 0 0 0 1 1 0 0 1 0\n", "undefined modifier"),
        ("void plastics p 0 0 0\n", "unknown type"),
        ("!rm -rf /\n", "d.rad:1: the command 'rm' is not run"),
    ]:
        path.write_text(text)
        with pytest.raises(RadianceError) as error:
            theirs(path, klems="quarter", samples=8)
        assert message in str(error.value)
    with pytest.raises(RadianceError, match="no such file"):
        theirs(tmp_path / "nothing.rad", klems="quarter")


def test_without_radiance_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("bsdftree._radiance.programs.find_spec", lambda name: None)
    with pytest.raises(RadianceError, match=r"pip install 'bsdftree\[radiance\]'"):
        theirs("mirror", klems="quarter")


def test_genbsdfs_own_method_agrees_too(scene, tmp_path):
    """rfluxmtx, with genBSDF's senders and settings, as pyradiance runs it: the same within both one's noise."""
    path = scene(BLINDS)
    other = bsdftree.load(radiance.generate(path, tmp_path / "o.xml", samples=200), strict=False)
    bsdf, _ = theirs(path, klems="quarter", samples=1000)
    assert_alike(other, bsdf, 200, n_ours=1000, total=0.02)
