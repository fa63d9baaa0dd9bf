"""``bsdftree generate``: device geometry to BSDF."""

from __future__ import annotations

import os
import shlex
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

import bsdftree
from bsdftree import Device, GenerationReport, Resumed, device_families
from bsdftree._device import format_of
from bsdftree.cli._common import BASES, PERCENT, json_option, print_json, stderr, stdout, table, tell, with_input_errors
from bsdftree.cli._progress import paths_bar
from bsdftree.cli.info import summarize

_UNITS = ["meter", "foot", "inch", "centimeter", "millimeter"]


def _list_devices(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if not value or context.resilient_parsing:
        return
    for family in device_families():
        stdout.print(f"[bold]{family.name}[/bold]: {family.summary}", highlight=False)
        stdout.print(family.drawing, highlight=False, markup=False)
        parameters = table("  parameter", "unit", ">default", "range", "meaning")
        for p in family.parameters:
            parameters.add_row(f"  {p.name}", p.unit, p.default, p.range, p.meaning)
        stdout.print(parameters)
        stdout.print()
    context.exit()


@click.command()
@click.argument("files", nargs=-1, type=click.Path(), metavar="[FILE]...")
@click.option(
    "--device", "spec", metavar="SPEC", help="A parametric device, e.g. blinds:depth=0.05,spacing=0.04,angle=30."
)
@click.option(
    "--list-devices",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_list_devices,
    help="Describe the parametric devices with drawings, and exit.",
)
@click.option("-o", "--output", metavar="OUT.xml", help="Where to write the BSDF; standard output by default.")
@click.option(
    "--rank", type=click.Choice(["3", "4"]), default="4", show_default=True, help="Tensor tree: 3 is isotropic."
)
@click.option(
    "--log2-res", type=int, default=5, show_default=True, metavar="N", help="Up to 2^N cells per axis of the tree."
)
@click.option("--klems", type=BASES, help="A Klems matrix instead of a tree.")
@click.option(
    "--subdivide",
    type=click.Choice(["1", "2", "4"]),
    default="1",
    show_default=True,
    help="Split each Klems patch N × N.",
)
@click.option(
    "--samples",
    type=int,
    metavar="N",
    help="Paths per incident cell and side, at most. [default: 2000; 2^20 with --tolerance or --time-budget]",
)
@click.option(
    "--tolerance",
    type=float,
    metavar="E",
    help="Stop when the estimated relative error of the whole is this small, e.g. 0.05.",
)
@click.option(
    "--direction-tolerance",
    type=float,
    default=0.05,
    show_default=True,
    metavar="E",
    help="Tolerated error of the hemispherical total of any one incident direction, relative to it or to 0.1.",
)
@click.option(
    "--detail",
    type=float,
    metavar="D",
    help="How small differences are kept, relative to the mean BSDF; less gives more values. "
    "[default: 0.1, or twice the tolerance if that is less]",
)
@click.option("--time-budget", type=float, metavar="SECONDS", help="Stop when this time is over.")
@click.option(
    "--sampling",
    type=click.Choice(["sobol", "random"]),
    default="sobol",
    show_default=True,
    help="Whether paths start from evenly spread or from independent points.",
)
@click.option(
    "--sides",
    type=click.Choice(["front", "back", "both"]),
    default="both",
    show_default=True,
    help="Where light comes from: front is the room (+Z).",
)
@click.option("--color", is_flag=True, help="Keep colour: Y, u′, v′ trees or X, Y, Z matrices.")
@click.option(
    "--bands",
    default="Visible",
    show_default=True,
    metavar="NAME,...",
    help="Bands of the file: Visible, Solar, NIR, UV, a wavelength in nm such as 550, or a mean over wavelengths such "
    "as PAR:400-700. Materials with spectra are traced by wavelengths.",
)
@click.option(
    "--band",
    "own_bands",
    multiple=True,
    metavar="NAME=FILE",
    help="A band with materials of its own: a Radiance file that defines them under the same names; may be repeated.",
)
@click.option(
    "--reciprocity/--no-reciprocity",
    default=None,
    help="Average pairs of directions with the same pairs swapped. "
    "[default: where all materials are reciprocal; not rank 3]",
)
@click.option(
    "--no-reuse", is_flag=True, help="Follow each path alone, also where diffuse surfaces let paths be shared."
)
@click.option("--no-prune", is_flag=True, help="Keep cells of a tree that differ only by noise.")
@click.option(
    "--dim",
    nargs=6,
    type=float,
    metavar="X0 X1 Y0 Y1 Z0 Z1",
    help="Box that stands for the device, in its unit, instead of its bounding box.",
)
@click.option(
    "--tile",
    is_flag=True,
    help="Repeat the device for ever, without edges; --dim, or a parametric device's own period, is what repeats.",
)
@click.option(
    "--unit", type=click.Choice(_UNITS), default="meter", show_default=True, help="Unit of length in the files."
)
@click.option(
    "--up",
    type=click.Choice(["x", "-x", "y", "-y", "z", "-z"]),
    default="y",
    show_default=True,
    help="Axis that points up in the drawing. With z, the room is towards -Y of the drawing.",
)
@click.option("--geometry", is_flag=True, help="Put the device into the file too, as MGF.")
@click.option("--name", help="Name of the product in the file.")
@click.option("--manufacturer", help="Its maker.")
@click.option(
    "--seed", type=click.IntRange(0, 2**64 - 1), default=0, show_default=True, help="Equal seeds give equal bits."
)
@click.option("--threads", type=click.IntRange(1), help="Number of threads; all processors by default.")
@click.option(
    "--checkpoint",
    type=click.Path(file_okay=False),
    metavar="DIR",
    help="Keep what was counted in this directory, new or empty at first. The same command goes on where it was "
    "interrupted, with the same result; a larger --samples goes on from what is there.",
)
@click.option(
    "--materials",
    multiple=True,
    type=click.Path(),
    metavar="FILE",
    help="A Radiance file of materials for meshes; may be repeated.",
)
@click.option(
    "--material",
    "material_names",
    multiple=True,
    metavar="NAME=MODIFIER",
    help="The modifier for a material's name in meshes, or =MODIFIER for what has none; may be repeated.",
)
@click.option(
    "--engine",
    type=click.Choice(["bsdftree", "radiance"]),
    default="bsdftree",
    show_default=True,
    help="What traces: our tracer, or Radiance's rcontrib (pip install 'bsdftree[radiance]').",
)
@click.option(
    "--rcontrib",
    metavar="OPTIONS",
    help="With --engine radiance: more options of rcontrib, e.g. '-ab 8 -ad 2000'; @FILE for those in a file.",
)
@click.option(
    "--cull-percent",
    type=PERCENT,
    default=90.0,
    show_default=True,
    metavar="P",
    help="With --engine radiance: how much of a tree is culled.",
)
@click.option(
    "--allow-command",
    "allow_commands",
    multiple=True,
    metavar="NAME",
    help="A program that commands (!NAME …) of scene files may run; may be repeated.",
)
@json_option
@with_input_errors
def generate(
    files: tuple[str, ...],
    spec: str | None,
    output: str | None,
    rank: str,
    log2_res: int,
    klems: str | None,
    subdivide: str,
    samples: int | None,
    tolerance: float | None,
    direction_tolerance: float,
    detail: float | None,
    time_budget: float | None,
    sampling: str,
    sides: str,
    color: bool,
    bands: str,
    own_bands: tuple[str, ...],
    reciprocity: bool | None,
    no_reuse: bool,
    no_prune: bool,
    dim: tuple[float, ...] | None,
    tile: bool,
    unit: str,
    up: str,
    geometry: bool,
    name: str | None,
    manufacturer: str | None,
    seed: int,
    threads: int | None,
    checkpoint: str | None,
    materials: tuple[str, ...],
    material_names: tuple[str, ...],
    engine: str,
    rcontrib: str | None,
    cull_percent: float,
    allow_commands: tuple[str, ...],
    as_json: bool,
) -> None:
    """Ray-trace a device into a BSDF and write it as WINDOW 6 XML.

    The device is one or more FILEs, told apart by their endings (Radiance scenes, .mgf, .obj, .ply, .stl, .rtm,
    .oct, and the geometry in a BSDF .xml), or a parametric device (--device; see --list-devices). It lies in z ≤ 0
    with the room at +Z and up at +Y, as for Radiance's genBSDF.

    \b
    Examples:
      bsdftree generate blinds.rad -o blinds.xml
      bsdftree generate --rank 3 --log2-res 4 mirror.rad -o mirror.xml
      bsdftree generate --device blinds:depth=0.05,spacing=0.04,angle=30 --log2-res 6 -o blinds.xml
      bsdftree generate --log2-res 7 --samples 16384 --checkpoint blinds.state blinds.rad -o blinds.xml
      bsdftree generate --klems full --unit inch --dim 0 40 0 40 -2 0 shade.rad -o shade.xml
      bsdftree generate --engine radiance --klems full --samples 200 blinds.rad -o oracle.xml
    """
    if bool(files) == bool(spec):
        raise click.UsageError("give either scene files or --device (bsdftree generate --list-devices describes them)")
    if output is None and as_json:
        raise click.UsageError("--json describes what was written; say where to with -o")
    if klems is None and subdivide != "1":
        raise click.UsageError("--subdivide splits Klems patches; give --klems too")
    if rcontrib is not None and engine != "radiance":
        raise click.UsageError("--rcontrib is for --engine radiance")
    device: Device | tuple[str, ...]
    if spec:
        device = Device.from_spec(spec)
    elif engine == "bsdftree" or not all(format_of(file) in ("rad", "mgf") for file in files):
        names = _names(material_names)
        device = Device.read(
            *files,
            unit=unit,
            materials=materials,
            default_material=names.pop("", None),
            material_names=names,
            allow_commands=allow_commands,
        )
        tell(device.warnings)
    elif material_names:
        raise click.UsageError("--material is for meshes; in scenes, surfaces name their materials themselves")
    else:
        # Radiance reads the scenes itself, after the materials.
        device = (*materials, *files)
    reports: list[GenerationReport] = []
    limit = samples if samples is not None else 2000 if tolerance is None and time_budget is None else None
    begin = time.perf_counter()
    with _kept(checkpoint), paths_bar() as bar:
        bsdf = bsdftree.generate(
            device,
            rank=int(rank),
            log2_res=log2_res,
            klems=klems,  # type: ignore[arg-type]
            subdivide=int(subdivide),
            samples=samples,
            tolerance=tolerance,
            direction_tolerance=direction_tolerance,
            detail=detail,
            time_budget=time_budget,
            sampling=sampling,  # type: ignore[arg-type]
            sides=sides,  # type: ignore[arg-type]
            color=color,
            bands=_bands(bands, own_bands),
            reciprocity=reciprocity,
            reuse=not no_reuse,
            prune=not no_prune,
            dim=dim,
            tile=tile,
            unit=unit,
            up=up,
            geometry=geometry,
            seed=seed,
            threads=threads,
            checkpoint=checkpoint,
            engine=engine,  # type: ignore[arg-type]
            rcontrib=shlex.split(rcontrib or ""),
            cull_percent=cull_percent,
            allow_commands=allow_commands,
            progress=bar.update,
            resumed=lambda where: _show_resumed(where, limit),
            report=reports.append,
        )
    seconds = time.perf_counter() - begin
    (report,) = reports
    told = device.warnings if isinstance(device, Device) else []
    tell(warning for warning in report.warnings if warning not in told)
    command = shlex.join(["bsdftree", "generate", *sys.argv[2:]])
    bsdf = bsdf.with_header(
        name=name or (spec.partition(":")[0] if spec else os.path.splitext(os.path.basename(files[-1]))[0]),
        manufacturer=manufacturer,
        provenance=[*bsdf.provenance, f"Command: {command}"],
    )
    if output is None:
        click.echo(bsdf.to_xml(), nl=False)
        return
    bsdf.save(output)
    if as_json:
        print_json(_summary(bsdf, output, report, seconds))
    else:
        _show(bsdf, output, report, seconds, tolerance)
        if checkpoint is not None:
            stderr.print(f"{checkpoint} keeps what was counted: more --samples go on from there", highlight=False)


def _names(pairs: tuple[str, ...]) -> dict[str, str]:
    """Modifiers by their names in meshes; that of what has none by an empty name."""
    names = {}
    for pair in pairs:
        name, is_pair, modifier = pair.partition("=")
        if not is_pair or not modifier:
            raise click.UsageError(f"--material {pair}: expected NAME=MODIFIER or =MODIFIER")
        names[name] = modifier
    return names


@contextmanager
def _kept(checkpoint: str | None) -> Iterator[None]:
    """Say on Ctrl-C that nothing is lost."""
    try:
        yield
    except KeyboardInterrupt:
        if checkpoint is not None:
            click.echo(f"bsdftree: stopped; {checkpoint} keeps what was counted, the same command goes on", err=True)
        raise


def _bands(names: str, own: tuple[str, ...]) -> dict[str, list[str] | None] | list[str]:
    """Bands with the files of those that have materials of their own."""
    bands: dict[str, list[str] | None] = {name.strip(): None for name in names.split(",")}
    for pair in own:
        name, is_pair, path = pair.partition("=")
        if not is_pair or not name.strip() or not path:
            raise click.UsageError(f"--band {pair}: expected NAME=FILE, e.g. Solar=solar.rad")
        bands[name.strip()] = [*(bands.get(name.strip()) or []), path]
    return bands if own else list(bands)


def _show_resumed(where: Resumed, limit: int | None) -> None:
    if where.samples == where.round_end:
        line = f"nothing left to count: the checkpoint has {where.samples} samples per incident cell"
    else:
        line = f"resuming at sample {where.samples}{'' if limit is None else f' of {limit}'}"
        line += f", {where.share:.0%} of the round to {where.round_end}"
    if where.dropped:
        line += f"; {where.dropped} bytes were not whole and are counted again"
    stderr.print(f"bsdftree: {line}", highlight=False)


def _summary(bsdf: bsdftree.Bsdf, output: str, report: GenerationReport, seconds: float) -> dict[str, Any]:
    summary = summarize(bsdf, output)
    errors = {band.name: {"error": band.error, "direction_error": band.direction_error} for band in report.bands}
    bands = [band | errors.get(band["band"], {}) for band in summary["bands"]]
    return summary | {
        "bands": bands,
        "paths": report.paths,
        "samples": report.samples,
        "stop": report.stop,
        "error": report.error,
        "direction_error": report.direction_error,
        "lost": report.lost,
        "tracing_seconds": report.tracing_seconds,
        "reducing_seconds": report.reducing_seconds,
        "seconds": seconds,
        "warnings": list(report.warnings),
    }


def _show(bsdf: bsdftree.Bsdf, output: str, report: GenerationReport, seconds: float, tolerance: float | None) -> None:
    values = sum(c.n_leaves if isinstance(c, bsdftree.Tree) else c.values.size for c in bsdf.components.values())
    rate = report.paths / max(report.tracing_seconds, 1e-9)
    stderr.print(
        f"{output}: {os.path.getsize(output):,} bytes, {values:,} values, {report.paths:,} paths "
        f"at {rate / 1e6:.2f} M/s, {seconds:.2f} s",
        highlight=False,
    )
    missed = "tolerance not reached: " if tolerance is not None and report.stop == "samples" else ""
    reached = {"tolerance": "tolerance reached: ", "time": "time is over: ", "memory": "memory is used up: "}
    stderr.print(
        f"{reached.get(report.stop, missed)}{report.samples:,} samples per incident cell; estimated error "
        f"{report.error:.1%} of the whole, {report.direction_error:.1%} of the worst direction's total",
        highlight=False,
    )
    for band in report.bands if len(report.bands) > 1 else ():
        stderr.print(
            f"  {band.name}: estimated error {band.error:.1%} of the whole, {band.direction_error:.1%} of the worst "
            "direction's total",
            highlight=False,
        )
