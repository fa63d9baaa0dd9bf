"""``bsdftree genbsdf``: the command line of Radiance's genBSDF."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import click

import bsdftree
from bsdftree import Bsdf, Device, GenerationReport, Resumed
from bsdftree._device import METERS
from bsdftree.cli._common import input_errors, printable
from bsdftree.cli._genbsdf_input import read_input
from bsdftree.cli._genbsdf_words import USAGE, Request, UsageError, request
from bsdftree.cli._progress import paths_bar

PATHS_PER_SAMPLE = {"klems": 64, "tree": 16}
"""A sample of genBSDF sends out up to 700 rays where it meets a diffuse surface, a path of ours one; in trees, diffuse
vertices are reused. As many paths make errors at most as large as genBSDF's, and cost less: see COMPARE.md."""
CULL_DETAIL = 1.0
"""`--detail` × what is left of 100 %: a culling of 90 %, as by default, is the default detail of 0.1."""
WINDOW_FIELDS = {
    "ThermalConductivity": "1",
    "EmissivityFront": "0.9",
    "EmissivityBack": "0.9",
    "TIR": "0.1",
    "EffectiveOpennessFraction": "0.05",
}
"""What wrapBSDF -W fills in."""

_HELP = f"""Generate a BSDF by the command line of Radiance's genBSDF; XML goes to standard output.

\b
{USAGE}

Scripts run unchanged with "bsdftree genbsdf", or the one word "bsdftree-genbsdf", for "genBSDF": same defaults, same
meaning of sides, same units, geometry and fields in the file. Options of our own come among the others, before files:
--engine radiance, --seed K, --checkpoint DIR, --materials FILE, --allow-command NAME. See COMPARE.md for what differs.

\b
Examples:
  bsdftree genbsdf -n 4 +f +b blinds.rad > blinds.xml
  bsdftree genbsdf -t4 5 -c 10240 -geom inch -dim 0 40 0 40 -2 0 shade.rad > shade.xml
  genblinds white b .05 1 1 25 30 | xform -rz -90 -rx 90 | cat white.mat - | bsdftree genbsdf -t3 4 > b.xml
"""


@click.command(
    help=_HELP,
    context_settings={
        "ignore_unknown_options": True,
        "allow_interspersed_args": False,
        "help_option_names": ["--help"],
    },
)
@click.argument("words", nargs=-1, type=click.UNPROCESSED, metavar="[OPTION | FILE]...")
def genbsdf(words: tuple[str, ...]) -> None:
    """Understand the words, do it, and end with genBSDF's exit codes: 0, or 1 for whatever is wrong."""
    try:
        asked = request(words)
    except UsageError as error:
        _die(str(error))
    with input_errors():
        _run(asked, words)


def main() -> None:
    """Run as the one word ``bsdftree-genbsdf``."""
    genbsdf(prog_name="bsdftree-genbsdf")


def _die(message: str) -> NoReturn:
    click.echo(message, err=True)
    sys.exit(1)


def _run(asked: Request, words: Sequence[str]) -> None:
    if asked.recover is not None:
        _recover(asked.recover)
        return
    if asked.rank == 3 and not (asked.forward and asked.backward):
        click.echo("Warning: recommend both +forward and +backward with -t3", err=True)
    scene = None if asked.files else sys.stdin.buffer.read()
    with _kept(asked, words, scene) as folder:
        xml = _generated(asked, words, scene, folder)
    click.echo(xml, nl=False)


def _recover(folder: str) -> None:
    """Go on with what a run was about that was interrupted."""
    folder = os.path.abspath(folder)
    saved = Path(folder) / "genbsdf.json"
    try:
        job = json.loads(saved.read_text())
        words, directory = [str(word) for word in job["words"]], str(job["directory"])
        scene = (Path(folder) / "scene").read_bytes() if job["stdin"] else None
        os.chdir(directory)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{folder}: invalid path ({error})") from None
    asked = request(words)
    click.echo(_generated(asked, words, scene, Path(folder)), nl=False)
    if asked.checkpoint is None:
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def _kept(asked: Request, words: Sequence[str], scene: bytes | None) -> Iterator[Path | None]:
    """Keep what -recover needs, for as long as it may be needed."""
    if asked.engine == "radiance" or asked.checkpoint is not None:
        yield None if asked.checkpoint is None else Path(asked.checkpoint)
        return
    folder = Path(tempfile.mkdtemp(prefix="genBSDF."))
    job = {"words": list(words), "directory": os.getcwd(), "stdin": scene is not None}
    (folder / "genbsdf.json").write_text(json.dumps(job))
    if scene is not None:
        (folder / "scene").write_bytes(scene)
    try:
        yield folder
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    shutil.rmtree(folder, ignore_errors=True)


def _generated(asked: Request, words: Sequence[str], scene: bytes | None, folder: Path | None) -> str:
    """Return the XML of what was asked for."""
    if asked.rcontrib and asked.engine != "radiance":
        click.echo(
            f"bsdftree: note: -r '{' '.join(asked.rcontrib)}' is for rcontrib and has no meaning here: paths are "
            f"followed to their ends",
            err=True,
        )
    given = read_input(asked, scene)
    told = given.device.warnings if isinstance(given.device, Device) else []
    for warning in told:
        click.echo(printable(f"Warning: {warning}"), err=True)
    _warn(asked.dim or given.bounds)
    if folder is not None and asked.checkpoint is None:
        click.echo(f"Recover using: bsdftree genbsdf -recover {folder}", err=True)
    reports: list[GenerationReport] = []
    with paths_bar() as bar:
        bsdf = bsdftree.generate(
            given.device,  # type: ignore[arg-type]
            rank=asked.rank or 4,
            log2_res=asked.log2_res,
            klems=None if asked.rank else "full",
            samples=asked.samples * _paths_per_sample(asked),
            detail=_detail(asked),
            sides="both" if asked.forward and asked.backward else "back" if asked.forward else "front",
            color=asked.color,
            reciprocity=None if asked.average and asked.engine == "bsdftree" else asked.average,
            prune=asked.cull_percent >= 0,
            dim=asked.dim,
            unit=asked.unit,
            geometry=asked.geometry,
            seed=asked.seed,
            threads=asked.processes,
            checkpoint=None if folder is None else _checkpoint(asked, folder),
            engine=asked.engine,  # type: ignore[arg-type]
            rcontrib=asked.rcontrib if asked.engine == "radiance" else (),
            cull_percent=max(0.0, asked.cull_percent),
            progress=bar.update,
            resumed=_tell_resumed,
            report=reports.append,
        )
    for warning in reports[0].warnings:
        if "into the room" not in warning and warning not in told:
            click.echo(printable(f"Warning: {warning}"), err=True)
    return _headed(bsdf, asked, words).to_xml()


def _checkpoint(asked: Request, folder: Path) -> Path:
    return folder if asked.checkpoint is not None else folder / "checkpoint"


def _tell_resumed(where: Resumed) -> None:
    click.echo(f"bsdftree: goes on at sample {where.samples}", err=True)


def _paths_per_sample(asked: Request) -> int:
    return 1 if asked.engine == "radiance" else PATHS_PER_SAMPLE["tree" if asked.rank else "klems"]


def _detail(asked: Request) -> float | None:
    """Return the detail that stands for a culling: half the detail for twice what is left."""
    if not asked.rank or asked.cull_percent < 0 or asked.engine == "radiance":
        return None
    return CULL_DETAIL / (100.0 - asked.cull_percent)


def _warn(dim: Sequence[float]) -> None:
    """Say what genBSDF says of where the device lies, in its unit."""
    if dim[4] > 0 or (dim[4] == 0 and dim[5] > 1e-5):
        raise ValueError("Device entirely inside room!")
    if dim[5] > 1e-5:
        click.echo("Warning: Device extends into room", err=True)
    elif dim[5] ** 2 > 0.01 * (dim[1] - dim[0]) * (dim[3] - dim[2]):
        click.echo("Warning: Device far behind Z==0 plane", err=True)


def _headed(bsdf: Bsdf, asked: Request, words: Sequence[str]) -> Bsdf:
    """Put into the header what was asked for."""
    fields = dict(asked.fields)
    if asked.window:
        for letter, name in (("m", "Manufacturer"), ("n", "Name")):
            if name not in fields:
                click.echo(f"Warning: missing '{letter}' assignment for WINDOW <{name}>", err=True)
    size = {"Width": bsdf.width, "Height": bsdf.height, "Thickness": bsdf.thickness}
    for length in size.keys() & fields.keys():
        try:
            size[length] = float(fields.pop(length)) * METERS[asked.unit]
        except ValueError as error:
            raise ValueError(f"-s {length}: {error}; expected a length in {asked.unit}") from None
    # What wrapBSDF's templates have.
    name = fields.pop("Name", "" if asked.window else "Name")
    manufacturer = fields.pop("Manufacturer", "" if asked.window else "Manufacturer")
    return bsdf.with_header(
        name=name,
        manufacturer=manufacturer,
        provenance=[*bsdf.provenance, f"Command: {shlex.join(['bsdftree', 'genbsdf', *words])}"],
        size=(size["Width"], size["Height"], size["Thickness"]),
        properties=(WINDOW_FIELDS if asked.window else {}) | fields,
    )
