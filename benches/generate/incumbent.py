"""Radiance's way: genBSDF's steps for rank 4 with its programs and settings, and its reducer alone on other values.

pyradiance brings the programs but not the script. The steps are those of `genBSDF +backward -forward -geom meter -t4
N -c SAMPLES -n PROCESSES`: octree, senders at z = zmax of the bounding box, rfluxmtx with `-ab 5 -ad 700 -lw 3e-6`,
colour to luminance over solid angle by rcalc, rttree_reduce at 90 % with `-a` for reflection, wrapBSDF. Files stand
between the steps instead of pipes, so that each one's CPU time is counted.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np

import bsdftree
from bsdftree import Bsdf
from bsdftree._radiance.programs import environment, words_of
from bsdftree._radiance.rcontrib import OPTIONS, bounds
from bsdftree._radiance.reduce import reducer_words
from bsdftree._radiance.scene import scene_of_files

from .errors import Grids
from .process import Cost, run

CULL_PERCENT = 90
FLAGS = {"transmission_back": "-tb", "reflection_back": "-rb"}
LUMINANCE = (0.2651, 0.6701, 0.0648)
"""Of Radiance's red, green and blue."""
CLEARANCE = 1e-5
"""Of the senders from the device [m]."""


def program(name: str, *arguments: object, stdin: Path | None = None, stdout: Path | None = None) -> Cost:
    return run(words_of(name, *arguments), stdin=stdin, stdout=stdout, environment=environment())


def rays(samples: int, box: tuple[float, ...]) -> int:
    """Rays per incident cell: genBSDF rounds up to a grid over the aperture."""
    width, height = box[1] - box[0], box[3] - box[2]
    across = int(math.sqrt(samples * width / height) + 1)
    return across * int(samples / across + 1)


def genbsdf(scene: Path, log2_res: int, samples: int, work: Path) -> tuple[Path, Cost]:
    """Generate as genBSDF does; the XML file and what all programs cost together."""
    n, box = 2**log2_res, bounds(scene_of_files([scene]))
    octree, sender, receivers = work / "device.oct", work / "sender.rad", work / "receivers.rad"
    face, behind = work / "face.dat", work / "behind.dat"
    x0, x1, y0, y1, _, z1 = box
    corners = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    vertices = "\n".join(f"{x:e} {y:e} {z1 + CLEARANCE:e}" for x, y in corners)
    sender.write_text(f"#@rfluxmtx u=-Y h=+sc{n}\n\nvoid polygon sender\n0\n0\n12\n{vertices}\n")
    receivers.write_text(
        f"#@rfluxmtx h=-sc{n}\n#@rfluxmtx u=-Y o={face}\n\n{_sky('face', 1)}\n"
        f"#@rfluxmtx h=+sc{n}\n#@rfluxmtx u=-Y o={behind}\n\n{_sky('behind', -1)}"
    )
    cost = program("oconv", "-w", scene, stdout=octree)
    settings = [*OPTIONS, "-w-", "-n", os.cpu_count() or 1, "-c", rays(samples, box)]
    cost += program("rfluxmtx", *settings, "-h", "-ff", sender, receivers, "-i", octree)
    files = {"transmission_back": behind, "reflection_back": face}
    for key, colors in files.items():
        values = work / f"{key}.values"
        weights = "+".join(f"{w}*${k}" for k, w in enumerate(LUMINANCE, 1))
        expression = f"Omega:PI/({n}*{n});$1=({weights})/Omega"
        cost += program("rcalc", "-if3", "-e", expression, "-of", colors, stdout=values)
        colors.unlink()
        files[key] = values
    path, reducing = reduced(files, log2_res, CULL_PERCENT, work)
    for values in files.values():
        values.unlink()
    return path, cost + reducing


def _sky(name: str, z: int) -> str:
    return (
        f"void glow receiver_{name}\n0\n0\n4 1 1 1 0\n\nreceiver_{name} source {name}_receiver\n0\n0\n4 0 0 {z} 180\n"
    )


def write_values(values: Grids, work: Path) -> dict[str, Path]:
    """Dense values as the reducer reads them."""
    paths = {}
    for key, grid in values.items():
        paths[key] = work / f"{key}.values"
        np.ascontiguousarray(grid, np.float32).tofile(paths[key])
    return paths


def reduced(values: dict[str, Path], log2_res: int, cull_percent: float, work: Path) -> tuple[Path, Cost]:
    """Values reduced by rttree_reduce and wrapped to XML; pairs of reflection are averaged with swapped pairs."""
    cost, inputs = Cost(), []
    for key, path in values.items():
        tree = work / f"{key}.tree"
        settings = reducer_words(4, log2_res, cull_percent, key.startswith("reflection"))
        cost += program("rttree_reduce", *settings, path, stdout=tree)
        inputs += [FLAGS[key], tree]
    xml = work / "incumbent.xml"
    cost += program("wrapBSDF", "-a", "t4", "-u", "meter", *inputs, stdout=xml)
    return xml, cost


def read(xml: Path) -> Bsdf:
    """Radiance's files have what strict reading refuses."""
    return bsdftree.load(xml, strict=False)
