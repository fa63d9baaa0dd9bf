"""Measurements: files read as Radiance reads them, arrays, files written."""

import json

import numpy as np
import pytest
import radiance
from click.testing import CliRunner

import bsdftree
from bsdftree import Measurement, direction_from_polar, polar_from_direction
from bsdftree.cli import main


def hemisphere(side, n=24):
    """Directions spread evenly on one side, (n², 3)."""
    u, v = ((np.arange(n * n) // n) + 0.5) / n, ((np.arange(n * n) % n) + 0.5) / n
    return direction_from_polar(np.degrees(np.arccos(side * u)), 360 * v)


def lobe(exitant, towards, sharpness=60.0):
    """A lobe about a direction, on a low floor [1/sr]."""
    return 0.01 + 2.0 * np.exp(sharpness * (exitant @ np.asarray(towards) - 1.0))


def write_pab_opto(folder, scans, header="", dsf=False):
    """Files by hand: angles of the file, values of a function of the file's own directions."""
    paths = []
    for k, (theta, phi, exitant, values) in enumerate(scans):
        angles = polar_from_direction(exitant)
        scale = np.abs(exitant[:, 2]) if dsf else 1.0
        rows = "\n".join(f"{t:.6f} {p:.6f} {v:.8g}" for (t, p), v in zip(angles, values * scale, strict=True))
        kind = "DSF" if dsf else "BSDF"
        path = folder / f"scan{k}.txt"
        path.write_text(
            f'#sample_name "lobes"\n{header}#format: theta phi {kind}\n#incident_angle {theta} {phi}\n{rows}\n'
        )
        paths.append(path)
    return paths


def off_axis_scans(incident_side, exitant_side):
    """One lobe that no turn and no mirror leaves where it is, brighter from some azimuths than from others."""
    exitant = hemisphere(exitant_side)
    towards = direction_from_polar(90 - 50 * exitant_side, 20)
    files = [(theta, phi) for theta in (15, 35, 55) for phi in range(15, 360, 45)]
    return [
        (theta if incident_side > 0 else 180 - theta, phi, exitant, 0.5 ** (phi // 90) * lobe(exitant, towards))
        for theta, phi in files
    ]


def middle(exitant, values):
    """Where most of it goes."""
    towards = (exitant * np.square(values)[:, None]).sum(0)
    return towards / np.linalg.norm(towards)


@radiance.needs_radiance
@pytest.mark.parametrize(
    ("incident_side", "exitant_side", "up", "back", "dsf"),
    [(1, 1, 25, False, True), (1, -1, 0, True, False), (-1, -1, 0, False, False)],
)
def test_lobes_lie_where_pabopto2bsdf_puts_them(tmp_path, incident_side, exitant_side, up, back, dsf):
    paths = write_pab_opto(tmp_path, off_axis_scans(incident_side, exitant_side), f"#upphi {up}\n" if up else "", dsf)
    options = ["-t"] if back else []
    (tmp_path / "lobes.sir").write_bytes(radiance.run("pabopto2bsdf", *options, *paths))
    (tmp_path / "lobes.xml").write_bytes(radiance.run("bsdf2klems", "-q", "-n", 16, tmp_path / "lobes.sir"))
    theirs = bsdftree.load(tmp_path / "lobes.xml")
    ours = Measurement.load(paths, side="back" if back else "front")
    assert ours.name == "lobes"
    part = "reflection" if incident_side == exitant_side else "transmission"
    # WINDOW's back is the room, where +Z and Radiance's front are.
    side = "back" if (incident_side > 0) != back else "front"
    assert ours.parts == [f"{part}_{side}"] == list(theirs.components)
    fine = hemisphere(np.sign(ours.scans[0].exitant[0, 2]), 80)
    # Radiance's mesh of incident directions is whole around those of the middle ring.
    ring = [scan for scan in ours.scans if 0.8 < abs(scan.incident[2]) < 0.85]
    ring.sort(key=lambda scan: polar_from_direction(scan.incident)[1])
    logs = []
    for scan in ring:
        values = theirs.eval(scan.incident, fine)
        logs.append(np.log([scan.values.mean(), values.mean()]))
        # Patches are some 20° wide; a lobe turned or mirrored would be 25° away and more.
        cosine = middle(scan.exitant, scan.values) @ middle(fine, values)
        assert np.degrees(np.arccos(cosine)) < 8.0, (scan.incident, scan.source)
    # Of all ways to turn or mirror the ring, no other than ours gives the brightness of the lobe.
    a, b = np.array(logs).T
    misfits = {(turn, mirror): np.std(np.roll(b[::mirror], turn) - a) for turn in range(8) for mirror in (1, -1)}
    assert min(misfits, key=misfits.__getitem__) == (0, 1), misfits


def without_header(interpolant):
    """The numbers of an interpolant; its header has the command and the time."""
    return interpolant[interpolant.index(b"\n\n") :]


@radiance.needs_radiance
@pytest.mark.parametrize(("angle", "grazing"), [("30", 30.0), ("A", "auto")])
def test_grazing_points_are_left_out_as_pabopto2bsdf_does(tmp_path, angle, grazing):
    exitant = hemisphere(1, 16)
    angles = (10, 30, 50, 65)
    scans = [(t, 90, exitant, lobe(exitant, direction_from_polar(t, 270))) for t in angles]
    paths = write_pab_opto(tmp_path, scans)
    theirs, all_ = (radiance.run("pabopto2bsdf", *options, *paths) for options in (["-g", angle], []))
    measured = Measurement.load(paths, grazing=grazing)
    assert all(len(scan.exitant) < len(exitant) for scan in measured.scans)
    assert "points nearer to the surface than" in measured.notes[-1]
    ours = radiance.run("pabopto2bsdf", *measured.save(tmp_path / "saved"))
    assert without_header(ours) == without_header(theirs) != without_header(all_)
    with pytest.raises(ValueError, match=r"no values farther than 89.9° from the surface in .*scan0"):
        Measurement.load(paths, grazing=89.9)
    with pytest.raises(ValueError, match=r"grazing angle of 90°.* expected 0 to less than 90"):
        Measurement.load(paths, grazing=90)


@radiance.needs_radiance
def test_half_turn_is_what_pabopto2bsdf_calls_up(tmp_path):
    exitant, fine = hemisphere(1, 16), hemisphere(1, 60)

    def towards(theta, phi):
        return direction_from_polar(theta, phi + 180 + 40)

    # Half of the azimuths of lobes that no mirror leaves where they are, brightest at azimuth 30° and 210°.
    files = [(theta, phi) for theta in (15, 35, 55) for phi in range(15, 180, 30)]
    bright = [1 + 0.6 * np.cos(2 * np.radians(phi - 30)) for _, phi in files]
    scans = [(t, p, exitant, b * lobe(exitant, towards(t, p), 20.0)) for (t, p), b in zip(files, bright, strict=True)]
    paths = write_pab_opto(tmp_path, scans, "#upphi 90\n")
    (tmp_path / "up.sir").write_bytes(radiance.run("pabopto2bsdf", "-s", "up", *paths))
    (tmp_path / "up.xml").write_bytes(radiance.run("bsdf2klems", "-q", "-n", 16, tmp_path / "up.sir"))
    theirs = bsdftree.load(tmp_path / "up.xml")
    turned, mirrored = (bsdftree.fit(paths, symmetry=name) for name in ("half_turn", "bilateral_x"))
    for phi in range(195, 360, 30):
        incident = direction_from_polar(35, phi)
        lobes = [middle(fine, b.eval(incident, fine)) for b in (turned, theirs, mirrored)]
        off = [np.degrees(np.arccos(np.clip(a @ towards(35, phi), -1, 1))) for a in lobes]
        # Patches of the quarter basis are some 25° wide.
        assert off[0] < 3 and off[1] < 15 and off[2] > 30, (phi, off)
    values = [turned.eval(direction_from_polar(35, phi), fine).mean() for phi in (225, 315)]
    assert values[0] > 2.5 * values[1]


def test_sides_of_the_plane_of_incidence_that_differ_are_told(data):
    raw = Measurement.load(sorted((data / "ua-loft/raw/rt-300s").glob("NiTE_on_invar*.xls")))
    published = Measurement.load(data / "ua-loft/processed/fred/AnoBlackNiTEonINVAR_fullAz.txt")
    grown = [row.asymmetry for row in raw.summary()]
    assert grown == sorted(grown) and 0.1 < grown[0] < 0.2 and grown[-1] > 0.8
    assert max(row.asymmetry for row in published.summary()) < 0.02
    assert any("two sides of the plane of incidence differ by up to 9" in note for note in raw.notes)
    assert not any("two sides" in note for note in published.notes)
    one_sided = Measurement.load(data / "ua-loft/processed/fred/AnoBlackNiTEonINVAR.txt")
    assert {row.asymmetry for row in one_sided.summary()} == {None}


def test_files_of_one_incident_direction_are_one_scan(tmp_path):
    towards = [0.0, 0.6, 0.8]
    scans = [(30, 90, side_directions, lobe(side_directions, towards)) for side_directions in map(hemisphere, (1, -1))]
    measured = Measurement.load(write_pab_opto(tmp_path, scans, "#upphi 90\n"))
    (scan,) = measured.scans
    assert scan.exitant.shape == (2 * 24**2, 3) and scan.values.shape == (2 * 24**2,)
    assert measured.parts == ["reflection_back", "transmission_back"]
    np.testing.assert_allclose(scan.incident, direction_from_polar(30, 90), atol=1e-12)


@pytest.mark.parametrize("n_channels", [1, 3])
def test_saved_measurement_is_read_again(tmp_path, rng, n_channels):
    scans = []
    for incident in direction_from_polar([10, 130, 50], [5, 355, 180]):
        exitant = np.concatenate([hemisphere(1, 6), hemisphere(-1, 6)])
        values = rng.normal(0.2, 0.2, (72, 3))[:, :n_channels].squeeze()
        scans.append((incident, exitant, values))
    made = Measurement(scans, name="a sample")
    paths = made.save(tmp_path / "out")
    assert len(paths) == 6
    read = Measurement.load(paths)
    assert (read.n_channels, read.name) == (n_channels, "a sample")
    for a, b in zip(read.scans, made.scans, strict=True):
        order = [np.argmax(a.exitant @ e) for e in b.exitant]
        np.testing.assert_allclose(a.exitant[order], b.exitant, atol=1e-14)
        np.testing.assert_array_equal(a.values[order], b.values)


def test_arrays_that_do_not_fit_are_refused():
    up, many = [0, 0, 1], hemisphere(1, 2)
    for scan, said in [
        ((up, many, np.ones(3)), r"values have shape \(3,\); expected \(4,\)"),
        ((up, many[:, :2], np.ones(4)), r"exitant has shape \(4, 2\)"),
        (([0, 0], many, np.ones(4)), r"incident has shape \(2,\)"),
        (([0, 0, 0], many, np.ones(4)), "no direction"),
        ((up, many, [1, 2, np.nan, 4]), r"exitant\[2\] is NaN"),
        ((up, many, np.ones(4), -np.ones(4)), r"error 0 of exitant\[0\] is -1"),
        ((up, many, np.ones(4), np.ones((4, 3))), "errors have shape"),
        ((up, many[:0], []), "no exitant"),
        ((up, many), "has 2 parts"),
    ]:
        with pytest.raises(ValueError, match=said):
            Measurement([scan])
    with pytest.raises(ValueError, match="some scans"):
        Measurement([(up, many, np.ones(4)), (up, many, np.ones((4, 3)))])


def test_files_that_are_none_are_refused(tmp_path):
    path = tmp_path / "x.txt"
    path.write_text("hello\n")
    with pytest.raises(ValueError, match=r"x\.txt: found no format"):
        Measurement.load(path)
    path.write_text("#format: theta phi BSDF\n#incident_angle 20 0\n10 0 0.1\n10 0\n")
    with pytest.raises(ValueError, match=r'x\.txt: line 4: found "10 0"; expected theta, phi and a value'):
        Measurement.load([path])
    with pytest.raises(FileNotFoundError):
        Measurement.load(tmp_path / "none.txt")
    with pytest.raises(ValueError, match='format "x"; expected one of "pab-opto"'):
        Measurement.load(path, format="x")
    with pytest.raises(ValueError, match="no files"):
        Measurement.load([])


COATINGS = ["AnoBlackEC1onAlum", "AnoBlackEC2onAlum", "AnoBlackNiTEonINVAR", "AnoBlackNiTEonSteel"]


def about(scan, exitant, width_deg=3.0):
    """Means of a scan and its mirror image around directions, NaN where there is none near."""
    known = np.concatenate([scan.exitant, scan.exitant * [1, -1, 1]])
    angle = np.degrees(np.arccos(np.clip(exitant @ known.T, -1, 1)))
    weight = np.exp(-0.5 * (angle / width_deg) ** 2)
    means = weight @ np.tile(scan.values, 2) / weight.sum(1)
    return np.where(angle.min(1) < width_deg, means, np.nan)


@pytest.mark.parametrize("name", COATINGS)
def test_twins_of_zemax_and_fred_agree(data, name):
    zemax = Measurement.load(data / f"ua-loft/processed/zemax/{name}.bsdf")
    assert (zemax.symmetry, zemax.wavelength_nm, zemax.parts) == ("isotropic", 650.0, ["reflection_back"])
    assert zemax.name.startswith("Anoplate AnoBlack")
    for path in (f"{name}.txt", f"{name}_fullAz.txt"):
        fred = Measurement.load(data / "ua-loft/processed/fred" / path)
        assert len(zemax.scans) == len(fred.scans) == 4
        for a, b in zip(zemax.scans, fred.scans, strict=True):
            np.testing.assert_allclose(a.incident, b.incident, atol=1e-12)
            # Their makers interpolated one and not the other, and shifted peaks by a degree or two.
            log_ratio = np.log(a.values / about(b, a.exitant))
            assert np.nanmedian(np.abs(log_ratio)) < 0.15
            if a.incident[2] < 0.7:
                turned = np.log(a.values / about(b, a.exitant * [-1, 1, 1]))
                assert np.nanmedian(np.abs(turned)) > 0.4


def test_reads_an_anisotropic_file_of_zemax(data):
    array = Measurement.load(data / "ua-loft/processed/zemax/IMX455.bsdf")
    assert (array.symmetry, len(array.scans)) == ("anisotropic", 144)
    assert array.notes[0].startswith("6732 zeros")
    theta, phi = polar_from_direction([scan.incident for scan in array.scans]).T
    assert set(theta.round(6)) == {10, 30, 50, 70} and len(set(phi.round(6))) == 36


def test_raw_sheets_become_the_published_brdf(data):
    raw = data / "ua-loft/raw/rt-300s"
    measured = Measurement.load(sorted(raw.glob("NiTE_on_invar*.xls")))
    fred = Measurement.load(data / "ua-loft/processed/fred/AnoBlackNiTEonINVAR_fullAz.txt")
    assert len(measured.scans) == len(fred.scans) == 4
    for a, b in zip(measured.scans, fred.scans, strict=True):
        np.testing.assert_allclose(a.incident, b.incident, atol=1e-12)
        cosine = b.exitant @ a.exitant.T
        at = cosine.argmax(1)
        assert np.all(cosine.max(1) > 1 - 1e-10)
        # What is published is the mean of the two sides of the plane of incidence, less the blank of the day: some
        # thousandths in RT.
        rt = np.pi * b.exitant[:, 2] * np.stack([a.values[at], b.values])
        mirrored = np.pi * b.exitant[:, 2] * a.values[(b.exitant * [1, -1, 1] @ a.exitant.T).argmax(1)]
        assert np.abs(0.5 * (rt[0] + mirrored) - rt[1]).max() < 0.0045
        assert a.errors.shape == a.values.shape and np.all(a.errors > 0)
    assert any("there is no blank" in note for note in measured.notes)
    # Three mounts of one coating differ by some percent.
    relative = np.concatenate([scan.errors / np.abs(scan.values) for scan in measured.scans])
    assert 0.01 < np.median(relative) < 0.15


def test_blanks_are_subtracted_where_they_fit(data):
    raw = data / "ua-loft/raw/rt-300s"
    black, blank = raw / "MagicBlack_v1o0_20250829.xls", raw / "blank_20250829.xls"
    without, fitting = Measurement.load(black), Measurement.load([black, blank])
    assert any("the blank is subtracted" in note for note in fitting.notes)
    assert not np.allclose(without.scans[0].values, fitting.scans[0].values)
    other = Measurement.load([*sorted(raw.glob("NiTE_on_invar*.xls")), blank])
    assert any("lacks angles" in note for note in other.notes)
    array = Measurement.load(sorted(raw.glob("IMX455*.xls")))
    phi = {round(polar_from_direction(scan.incident)[1], 6) for scan in array.scans}
    assert (len(array.scans), phi) == (16, {180, 150, 120, 90})
    with pytest.raises(ValueError, match="only blanks"):
        Measurement.load(blank)


def run(*args):
    return CliRunner().invoke(main, [str(a) for a in args])


def test_tables_are_read_by_their_columns(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("INC,A,B,F,S\n30,10,20,0.5,0.01\n30,20,20,0.25,0.02\n60,10,20,50,1\n")
    columns = {"theta_i": "INC", "theta_o": "A", "phi_o": 3, "value": "F", "error": "S", "percent": "yes"}
    table = Measurement.load(path, columns=columns)
    assert len(table.scans) == 2
    np.testing.assert_allclose(table.scans[0].values, [0.005, 0.0025])
    np.testing.assert_allclose(table.scans[0].errors, [0.0001, 0.0002])
    np.testing.assert_allclose(table.scans[0].exitant[0], direction_from_polar(10, 20))
    with pytest.raises(ValueError, match="line 1: found no column theta_i"):
        Measurement.load(path, format="table")
    with pytest.raises(ValueError, match="columns for a format that is no table"):
        Measurement.load(path, columns=columns, format="zemax")


def test_total_of_a_diffuser_is_its_reflectance():
    exitant = hemisphere(1, 20)
    row, other = Measurement(
        [([0, 0.6, 0.8], np.concatenate([exitant, -exitant]), np.repeat([0.2, 0.1], 400))]
    ).summary()
    assert (row.part, other.part, row.n_points) == ("reflection_back", "transmission_back", 400)
    assert row.total == pytest.approx(0.2 * np.pi, rel=1e-9) and other.total == pytest.approx(0.1 * np.pi, rel=1e-9)


@pytest.mark.parametrize("name", COATINGS)
def test_totals_of_twins_agree(data, name):
    zemax = Measurement.load(data / f"ua-loft/processed/zemax/{name}.bsdf").summary()[0]
    fred = Measurement.load(data / f"ua-loft/processed/fred/{name}_fullAz.txt").summary()[0]
    assert zemax.total == pytest.approx(fred.total, rel=0.05)


def test_measured_prints_draws_and_writes(data, tmp_path):
    files = sorted((data / "ua-loft/raw/rt-300s").glob("NiTE*.xls"))
    result = run("measured", *files, "--plot", tmp_path / "x.png", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "there is no blank" in result.output and result.output.count("reflection_back") == 4
    assert (tmp_path / "x.png").stat().st_size > 20_000
    written = sorted((tmp_path / "out").iterdir())
    assert [path.name for path in written] == [f"reflection_back_{t}.00_180.00.txt" for t in (10, 30, 50, 70)]
    summary = json.loads(run("measured", "--json", *written).output)
    assert [row["n_points"] for row in summary["scans"]] == [549, 542, 542, 542]
    assert run("measured", tmp_path / "x.png").exit_code == 1


def test_up_stays_up_on_the_back(tmp_path):
    scans = [(30, 90, direction_from_polar([40, 50], [90, 0]), np.array([1.0, 2.0]))]
    (scan,) = Measurement.load(write_pab_opto(tmp_path, scans, "#upphi 90\n"), side="back").scans
    np.testing.assert_allclose(scan.incident, direction_from_polar(150, 90), atol=1e-12)
    # Seen from the room, what was to the right of the sample's front is to its left.
    np.testing.assert_allclose(scan.exitant, direction_from_polar([140, 130], [90, 180]), atol=1e-9)


def test_merl_files_keep_colour_and_reflectance(tmp_path):
    scale = np.array([1 / 1500, 1.15 / 1500, 1.66 / 1500])
    path = tmp_path / "red.binary"
    with path.open("wb") as file:
        np.array([90, 90, 180], "<i4").tofile(file)
        for reflectance, s in zip((0.5, 0.2, 0.1), scale, strict=True):
            np.full(90 * 90 * 180, reflectance / np.pi / s, "<f8").tofile(file)
    merl = Measurement.load(path)
    assert (merl.n_channels, merl.symmetry, len(merl.scans)) == (3, "isotropic", 9)
    x, y, z = merl.scans[3].values[0] * np.pi
    assert x > y > z > 0.1
    assert all(row.total == pytest.approx(y, rel=1e-6) for row in merl.summary())


def test_astm_tables_are_read_in_radians(tmp_path):
    path = tmp_path / "x.astm"
    rows = "\n".join(f"0.5,1,{t:.3f},{p:.3f},0.25" for t in (0.1, 0.8) for p in (0, 2, 4))
    path.write_text(f"MANUFACTURER us\nNUM_POINTS 6\nVARS theta_i,phi_i,theta_r,phi_r,bsdf\n{rows}\n")
    astm = Measurement.load(path)
    assert (astm.manufacturer, astm.notes) == ("us", ["angles are taken as radians"])
    np.testing.assert_allclose(polar_from_direction(astm.scans[0].incident), np.degrees([0.5, 1]))


def test_doubtful_units_and_sides_are_noted(tmp_path):
    exitant = hemisphere(1, 20)
    scans = [(theta, 0, exitant, lobe(exitant, direction_from_polar(theta, 180), 20)) for theta in (20, 40, 60)]
    assert Measurement.load(write_pab_opto(tmp_path, scans)).notes == []
    percent = [(theta, phi, exitant, 100 * values) for theta, phi, exitant, values in scans]
    assert "percent" in Measurement.load(write_pab_opto(tmp_path, percent)).notes[0]
    turned = [(theta, 180, exitant, values) for theta, phi, exitant, values in scans]
    assert "goes back" in Measurement.load(write_pab_opto(tmp_path, turned)).notes[0]


def test_azimuths_of_zemax_files_have_the_sense_of_the_raw_sheets(data):
    made = Measurement.load(data / "ua-loft/processed/zemax/IMX455.bsdf")
    raw = Measurement.load(sorted((data / "ua-loft/raw/rt-300s").glob("IMX455*.xls")))
    assert len(raw.scans) == 16
    for scan in raw.scans:
        twin = made.scans[np.argmax([other.incident @ scan.incident for other in made.scans])]
        np.testing.assert_allclose(twin.incident, scan.incident, atol=1e-9)
        along = scan.incident * [1, 1, 0] / np.hypot(*scan.incident[:2])
        height = twin.exitant * [0, 0, 1]
        mirrored = 2 * np.outer(twin.exitant @ along, along) - twin.exitant * [1, 1, 0] + height
        correlations = []
        for exitant in (twin.exitant, mirrored):
            cosine = exitant @ scan.exitant.T
            near = cosine.max(1) > np.cos(np.radians(2))
            values = scan.values[cosine.argmax(1)[near]], twin.values[near]
            correlations.append(np.corrcoef(*np.log(np.maximum(values, 1e-4)))[0, 1])
        assert correlations[0] > correlations[1] + 0.05, scan.source
