"""RGL's tensor files, made of random tables, beside Mitsuba's `measured` (`pip install mitsuba`, else skipped)."""

import struct

import numpy as np
import pytest

from bsdftree import Measurement

N_TABLE, N_VALUES = 24, 16
PI = np.pi


def tensor_file(fields):
    """The container: names, axes, types (1: bytes, 10: floats), places and shapes, then numbers; little-endian."""
    place = 18 + sum(2 + len(name) + 11 + 8 * array.ndim for name, array in fields.items())
    head, body = b"tensor_file\0\x01\0" + struct.pack("<I", len(fields)), b""
    for name, array in fields.items():
        body += bytes(-(place + len(body)) % 8)
        kind = 1 if array.dtype == np.uint8 else 10
        head += struct.pack("<H", len(name)) + name.encode()
        head += struct.pack(f"<HBQ{array.ndim}Q", array.ndim, kind, place + len(body), *array.shape)
        body += array.tobytes()
    return head + body


def smooth(rng, *shape):
    """Random positive tables, blurred."""
    table = rng.random(shape) + 0.3
    for axis in (-1, -2) * 3:
        table = (table + np.roll(table, 1, axis) + np.roll(table, -1, axis)) / 3
    return table.astype(np.float32)


def made(rng, phis, jacobian):
    """A file of flat spectra; the last azimuth of a whole turn has the tables of the first."""
    thetas, phis = np.array([0.05, 0.5, 1.1], np.float32), np.array(phis, np.float32)
    incident = len(phis), len(thetas)
    vndf, values = smooth(rng, *incident, N_TABLE, N_TABLE), smooth(rng, *incident, N_VALUES, N_VALUES)
    if len(phis) > 1 and phis[-1] - phis[0] > 6:
        vndf[-1], values[-1] = vndf[0], values[0]
    ndf, sigma = smooth(rng, N_TABLE, N_TABLE), smooth(rng, N_TABLE, N_TABLE)
    if len(phis) <= 2:
        # Isotropic microfacets have no azimuth. Mitsuba turns such light by half a turn, by the sign of its y.
        ndf[:], sigma[:] = ndf[0], sigma[0]
    return {
        "description": np.frombuffer(b"made", np.uint8),
        "theta_i": thetas,
        "phi_i": phis,
        "ndf": ndf,
        "sigma": sigma,
        "vndf": vndf,
        "spectra": np.repeat(values[:, :, None], 4, axis=2),
        "luminance": values,
        "wavelengths": np.array([400, 500, 600, 700], np.float32),
        "jacobian": np.array([jacobian], np.uint8),
    }


@pytest.mark.parametrize(
    ("phis", "jacobian", "symmetry"),
    [
        ([0.0], 1, "isotropic"),
        ([0.0], 0, "isotropic"),
        ([-PI, PI], 1, "isotropic"),
        (np.linspace(-PI, PI, 5), 1, None),
        (np.linspace(-PI, 0, 4), 1, "half_turn"),
        (np.linspace(-PI, -PI / 2, 4), 0, "quadrilateral"),
    ],
)
def test_values_are_those_of_mitsuba(tmp_path, rng, phis, jacobian, symmetry):
    mitsuba = pytest.importorskip("mitsuba", reason="SKIPPED: no mitsuba; pip install mitsuba brings it")
    mitsuba.set_variant("scalar_spectral")
    path = tmp_path / "made.bsdf"
    path.write_bytes(tensor_file(made(rng, phis, jacobian)))
    read, theirs = Measurement.load(path), mitsuba.load_dict({"type": "measured", "filename": str(path)})
    assert read.symmetry == symmetry
    point, n_compared = mitsuba.SurfaceInteraction3f(), 0
    point.wavelengths = [500.0] * 4
    for scan in read.scans:
        phi = np.arctan2(scan.incident[1], scan.incident[0])
        if symmetry in ("half_turn", "quadrilateral") and min(abs(phi - phis[0]), abs(phi + phis[0])) < 1e-3:
            continue  # Mitsuba looks at either end of the range, which of random tables differ.
        if symmetry == "half_turn" and abs(phi) < 1e-3:
            continue
        for k in rng.choice(len(scan.exitant), 25, replace=False):
            exitant = scan.exitant[k]
            point.wi = scan.incident.tolist()
            expected = theirs.eval(mitsuba.BSDFContext(), point, exitant.tolist())[0] / exitant[2]
            assert scan.values[k, 1] == pytest.approx(expected, rel=2e-5)
            n_compared += 1
    assert n_compared >= 75
