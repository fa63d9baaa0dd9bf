"""``generate`` with the engine ``radiance``: what it is given, to a job, and its outcome, to a BSDF with its header."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from bsdftree import _core
from bsdftree._bsdf import Bsdf
from bsdftree._device import METERS, Device, family_of, format_of
from bsdftree._radiance.engine import Job, Traced, trace
from bsdftree._radiance.programs import RadianceError, run
from bsdftree._radiance.scene import SceneText, scene_of_files, scene_of_text
from bsdftree._report import GenerationReport

Devices = Device | SceneText | str | os.PathLike[str] | Sequence[str | os.PathLike[str]]
SIDES = {"front": (False,), "back": (True,), "both": (False, True)}
# Options of rcontrib that say how light is followed, and how many words come after each; switches end in a sign.
_OPTIONS = {f"-a{c}": 1 for c in "bdsarwIiEeF"} | {f"-d{c}": 1 for c in "tcjsrp"} | {f"-l{c}": 1 for c in "rw"}
_OPTIONS |= {"-av": 3, "-ss": 1, "-st": 1, "-mg": 1, "-ms": 1, "-me": 3, "-ma": 3, "-am": 1, "-t": 1, "-n": 1}
_SWITCHES = ("-u", "-bv", "-dv", "-w", "-i", "-ld")


def generate_by_radiance(
    device: Devices,
    *,
    rank: int,
    log2_res: int,
    klems: str | list[tuple[float, float, int]] | None,
    subdivide: int,
    samples: int,
    sides: str,
    color: bool,
    reciprocity: bool,
    cull_percent: float | None,
    dim: Sequence[float] | None,
    unit: str,
    up: str,
    geometry: bool,
    seed: int,
    processes: int,
    options: Sequence[str],
    allow_commands: Sequence[str],
    progress: Callable[[int, int], None] | None,
    report: Callable[[GenerationReport], None] | None,
) -> Bsdf:
    """Generate with Radiance; see :func:`bsdftree.generate`. Rank 0 is a Klems basis."""
    if sides not in SIDES:
        raise ValueError(f'sides {sides!r}; expected "front", "back" or "both"')
    layout = _core.Layout(rank=rank or 4, log2_res=log2_res, klems=klems, subdivide=subdivide)
    scene, meters = scene_of(device, unit, allow_commands)
    scale = METERS[unit] / meters
    job = Job(
        layout=layout,
        rank=rank,
        log2_res=log2_res,
        samples=samples,
        from_back=SIDES[sides],
        color=color,
        cull_percent=cull_percent,
        average=reciprocity,
        dim=None if dim is None else tuple(scale * float(length) for length in dim),
        up=up,
        options=tuple(checked_options(options)),
        seed=seed,
        processes=processes,
    )
    traced = trace(scene, job, progress)
    if report is not None:
        report(_report(traced, meters))
    x0, x1, y0, y1, z0, _ = (meters * length for length in traced.dim)
    cells = f"rank {rank} 2^{log2_res}" if rank else f"klems {klems if isinstance(klems, str) else 'of own rings'}"
    if rank and cull_percent is not None:
        cells += f" culled {cull_percent:g} %"
    made = (
        f"Created by: bsdftree {_core.__version__} generate by Radiance's rcontrib ({cells}"
        f"{f' {subdivide}x{subdivide}' * (subdivide > 1)}, {traced.samples} samples per incident cell, seed {seed}, "
        f"sides {sides}{', color' if color else ''}{', reciprocity' if reciprocity else ''})"
    )
    core = _core.Bsdf.of_components(traced.components)
    return Bsdf(core).with_header(
        name="Device",
        manufacturer="Manufacturer",
        unit=unit,
        provenance=[made],
        size=(x1 - x0, y1 - y0, max(0.0, -z0)),
        geometry=_geometry(traced, "meter" if meters == 1.0 else unit) if geometry else None,
    )


def _geometry(traced: Traced, unit: str) -> tuple[str, str]:
    """Return what was traced as MGF, its middle at x = y = 0, and its unit."""
    x0, x1, y0, y1, _, _ = traced.dim
    # rad2mgf reads files only.
    with tempfile.TemporaryDirectory(prefix="bsdftree-") as folder:
        path = Path(folder) / "device.rad"
        path.write_bytes(traced.scene.text)
        mgf = run("rad2mgf", path, directories=traced.scene.directories).decode(errors="replace")
    return f"xf -t {-(x0 + x1) / 2:.6f} {-(y0 + y1) / 2:.6f} 0\n{mgf}xf\n", unit


def scene_of(device: Devices, unit: str, allow_commands: Sequence[str]) -> tuple[SceneText, float]:
    """Return a scene for Radiance, and the length of its unit [m]."""
    if unit not in METERS:
        raise ValueError(f"no unit {unit!r}; expected one of {', '.join(METERS)}")
    if isinstance(device, SceneText):
        return device, METERS[unit]
    if isinstance(device, Device):
        return scene_of_text(device.to_rad()), 1.0
    if isinstance(device, (str, os.PathLike)):
        family = family_of(device)
        if family is not None:
            return scene_of_text(Device.from_spec(family).to_rad()), 1.0
        device = [device]
    scenes = [_scene_of_file(Path(path), allow_commands) for path in device]
    directories = dict.fromkeys(directory for scene in scenes for directory in scene.directories)
    return SceneText(b"\n".join(scene.text for scene in scenes), list(directories)), METERS[unit]


def _scene_of_file(path: Path, allow_commands: Sequence[str]) -> SceneText:
    kind = format_of(path)
    if kind == "rad":
        return scene_of_files([path], allow_commands)
    if kind == "mgf":
        if not path.is_file():
            raise RadianceError(f"{path}: no such file")
        return scene_of_text(run("mgf2rad", path), name=f"{path} as mgf2rad writes it")
    # Other kinds are what our reader makes of them, in their own unit.
    return scene_of_text(Device.read(path).to_rad(), name=str(path))


def checked_options(options: Sequence[str]) -> list[str]:
    """Check options of rcontrib; ``@file`` stands for the words of a file.

    Raises
    ------
    RadianceError
        If one is not understood, or is not about how light is followed.
    """
    words: list[str] = []
    for option in options:
        if option.startswith("@"):
            try:
                words += Path(option[1:]).read_text().split()
            except (OSError, UnicodeDecodeError) as error:
                raise RadianceError(f"options of rcontrib in {option[1:]}: {error}") from None
        else:
            words.append(option)
    k = 0
    while k < len(words):
        n = _OPTIONS.get(words[k])
        if n is None and not words[k].startswith(_SWITCHES):
            raise RadianceError(
                f"rcontrib is not given {words[k]!r}; expected options of how light is followed, such as -ab 5"
            )
        k += 1 + (n or 0)
    if k > len(words):
        raise RadianceError(f"options of rcontrib end after {words[-1]!r}; expected a number")
    return words


def _report(traced: Traced, meters: float) -> GenerationReport:
    x0, x1, y0, y1, z0, z1 = (meters * length for length in traced.dim)
    warnings = []
    if z1 > 1e-5:
        warnings.append(f"the device reaches {z1:.4f} m into the room (z > 0)")
    if min(traced.dim[1] - traced.dim[0], traced.dim[3] - traced.dim[2]) < 1e-2:
        warnings.append("the device is under 0.01 units wide; Radiance takes no hits nearer than 1e-6: scale it up")
    return GenerationReport(
        paths=traced.rays,
        samples=traced.samples,
        stop="samples",
        error=traced.error,
        direction_error=traced.direction_error,
        errors=Bsdf(_core.Bsdf.of_components(traced.errors)),
        totals=traced.totals,
        lost=0,
        tracing_seconds=traced.tracing_seconds,
        reducing_seconds=traced.reducing_seconds,
        aperture=((x0, y0, z0), (x1, y1, z1)),
        warnings=tuple(warnings),
    )
