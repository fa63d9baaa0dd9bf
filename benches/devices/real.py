"""Real files of other authors: read from the folder of real files, with what their authors made of them."""

from __future__ import annotations

import os
from pathlib import Path

from .scenes import Published, Scene

DATA = Path(os.environ.get("BSDFTREE_DATA", Path(__file__).parents[2] / ".." / "shared" / "data")).resolve()
"""As in the tests."""
TURNED = "!xform -t 8.1 0 0 -ry -90 -t 0 -2.5 0 {}\n"
"""The prisms of Radiance's tests face +X."""


def real() -> list[Scene]:
    """The devices; none if the folder is not there."""
    if not DATA.is_dir():
        return []
    radiance, pyradiance, frads = (DATA / name for name in ("radiance", "pyradiance", "frads"))
    # Box and rays are those that the authors' files name.
    sawtooth_box = (-120.0, 120.0, -120.0, 120.0, -2.0, 0.0)
    blinds30_box = (-1.355, 1.355, -0.855, 0.855, -0.03165063509461097, 0.0)
    return [
        Scene(
            "sawtooth.rad",
            "Ward's sawtooth, by genprism in a pipe (Radiance, test/)",
            ("polygon", "metal", "genprism", "xform"),
            radiance,
            dim=sawtooth_box,
            published=Published(radiance / "sawtooth.xml", 2000),
        ),
        Scene(
            "sawtooth.mgf",
            "The same sawtooth as MGF (Radiance, test/)",
            ("MGF",),
            radiance,
            dim=sawtooth_box,
            published=Published(radiance / "sawtooth.xml", 2000),
        ),
        Scene(
            "testspecmat.mgf",
            "Spectral MGF material, which mgf2rad makes a WGMDfunc (Radiance, test/)",
            ("MGF", "cspec", "WGMDfunc"),
            radiance,
            oracle="rays, reflection by sources",
            colour=True,
        ),
        Scene(
            "prism1.rad",
            "Prismatic pane, one direction (Radiance, test/)",
            ("polygon", "prism1"),
            radiance,
            text=TURNED.format("prism1.rad"),
        ),
        Scene(
            "prism2.rad",
            "Prismatic pane, two directions (Radiance, test/)",
            ("polygon", "prism2"),
            radiance,
            text=TURNED.format("prism2.rad"),
        ),
        Scene(
            "blinds.rad",
            "Glazed venetian blind (pyradiance)",
            ("polygon", "glass", "plastic"),
            pyradiance,
            published=Published(pyradiance / "blinds.xml", 10000),
        ),
        Scene(
            "blinds30.xml",
            "Geometry block of a blind's BSDF (frads)",
            ("XML", "MGF"),
            frads,
            dim=blinds30_box,
            known="mgf2rad takes ts + rs of glass, 0.710, for its transmissivity; that is a transmittance of 0.652, "
            "where the file says 0.640, as ours has and as the authors' own matrix has",
            published=Published(frads / "blinds30.xml", 500),
        ),
    ]
