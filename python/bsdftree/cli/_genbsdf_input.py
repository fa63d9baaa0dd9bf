"""What genBSDF is given, for either engine: something to trace, and how large it is.

Our tracer takes what our reader makes of the input; Radiance takes the scene itself, which may have what our reader
does not know.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

from bsdftree import Device
from bsdftree._device import METERS, format_of
from bsdftree._radiance.generation import scene_of
from bsdftree._radiance.programs import run
from bsdftree._radiance.rcontrib import bounds
from bsdftree._radiance.scene import SceneText, scene_of_text
from bsdftree.cli._genbsdf_words import Request


@dataclass
class Input:
    """Something to trace.

    Attributes
    ----------
    device
        For ``generate``.
    bounds
        xmin, xmax, ymin, ymax, zmin, zmax in the unit of the input.
    """

    device: Device | SceneText
    bounds: tuple[float, ...]


def read_input(asked: Request, scene: bytes | None) -> Input:
    """Read files, or what came by standard input.

    Raises
    ------
    ValueError
        If the input is not understood, or has no surfaces.
    """
    return _for_radiance(asked, scene) if asked.engine == "radiance" else _for_us(asked, scene)


def _for_us(asked: Request, scene: bytes | None) -> Input:
    if scene is not None:
        device = Device.parse(
            scene.decode(errors="replace"),
            unit=asked.unit,
            format="mgf" if asked.mgf else "rad",
            materials=asked.materials or (),
            allow_commands=asked.allow_commands,
        )
    else:
        device = Device.read(
            *asked.files,
            unit=asked.unit,
            format="mgf" if asked.mgf else None,
            materials=asked.materials or (),
            allow_commands=asked.allow_commands,
        )
    if device.bounds is None:
        raise ValueError("; ".join(["the input has no surfaces", *device.warnings[:3]]))
    corners = zip(*device.bounds, strict=True)
    return Input(device, tuple(length / METERS[asked.unit] for corner in corners for length in corner))


def _for_radiance(asked: Request, scene: bytes | None) -> Input:
    materials = [asked.materials] if asked.materials is not None else []
    if asked.mgf and materials:
        raise ValueError("--materials are of Radiance; MGF names none of them: leave it out")
    if scene is None and not asked.mgf and not all(format_of(file) in ("rad", "mgf") for file in asked.files):
        # What our reader makes of meshes, its lengths those of the input.
        read = Device.read(*asked.files, materials=materials, allow_commands=asked.allow_commands)
        text = scene_of_text(read.to_rad(), name=" ".join(asked.files))
    elif scene is None and not asked.mgf:
        text, _ = scene_of([*materials, *asked.files], asked.unit, asked.allow_commands)
    elif asked.mgf:
        files = asked.files
        with tempfile.TemporaryDirectory(prefix="bsdftree-") as folder:
            if scene is not None:
                files = [os.path.join(folder, "input.mgf")]
                Path(files[0]).write_bytes(scene)
            text = scene_of_text(run("mgf2rad", *files), name="what mgf2rad writes")
    else:
        text = scene_of_text(scene or b"", asked.allow_commands, name="standard input")
        if materials:
            first, _ = scene_of(materials, asked.unit, asked.allow_commands)
            text = SceneText(first.text + b"\n" + text.text, [*first.directories, *text.directories])
    return Input(text, bounds(text))
