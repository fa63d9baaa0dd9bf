"""Generation of a BSDF from a device."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

from bsdftree import _core
from bsdftree._bsdf import Bsdf
from bsdftree._device import Device, as_device
from bsdftree._radiance.generation import generate_by_radiance
from bsdftree._report import BandReport, GenerationReport, Resumed

Bands = Sequence[str] | Mapping[str, "Device | str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | None"]
KlemsName = Literal["full", "half", "half73", "quarter"]


def generate(
    device: Device | str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    rank: int = 4,
    log2_res: int = 5,
    klems: KlemsName | Sequence[tuple[float, float, int]] | None = None,
    subdivide: int = 1,
    samples: int | None = None,
    tolerance: float | None = None,
    direction_tolerance: float = 0.05,
    detail: float | None = None,
    time_budget: float | None = None,
    sampling: Literal["sobol", "random"] = "sobol",
    sides: Literal["front", "back", "both"] = "both",
    color: bool = False,
    bands: Bands = ("Visible",),
    reciprocity: bool | None = None,
    reuse: bool = True,
    prune: bool = True,
    dim: Sequence[float] | None = None,
    tile: bool = False,
    unit: str = "meter",
    up: str = "y",
    geometry: bool = False,
    seed: int = 0,
    threads: int | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    engine: Literal["bsdftree", "radiance"] = "bsdftree",
    rcontrib: Sequence[str] = (),
    cull_percent: float = 90.0,
    allow_commands: Sequence[str] = (),
    progress: Callable[[int, int], None] | None = None,
    resumed: Callable[[Resumed], None] | None = None,
    report: Callable[[GenerationReport], None] | None = None,
) -> Bsdf:
    """Ray-trace a device into a BSDF.

    Parameters
    ----------
    device
        A :class:`Device`, paths of Radiance scene files, or a spec such as ``"blinds:angle=30"``.
    rank, log2_res
        A tensor tree of this rank (3 isotropic, 4) with up to 2^log2_res cells per axis. A rank-3 tree of a device that
        is not isotropic is its mean over azimuth.
    klems, subdivide
        A Klems matrix instead: its basis, and into how many by how many parts each patch is split (1, 2, 4). The
        basis is ``"full"`` (145 patches), ``"half"`` (77), ``"half73"`` (as before 2022), ``"quarter"`` (41), or a
        list of rings from the normal outwards: lower and upper polar angle [degree] and number of patches.
    samples
        Paths per incident cell and side, at most. By default 2000, or 2^20 if ``tolerance`` or ``time_budget`` is
        given.
    tolerance
        Stop when the estimated relative error of the whole, Σ abs(error) / Σ BSDF over all finest cells, is this small,
        and ``direction_tolerance`` is kept too.
    direction_tolerance
        Tolerated error of the hemispherical total of any one incident direction, relative to it, or to 0.1 if it is
        less. Cells are kept small enough for it.
    detail
        How small differences are kept, relative to the mean BSDF, where they are as large as a cell of a 2^5 tree
        (smaller ones have to be stronger): less gives more values. By default 0.1, or twice the tolerance if that is
        less.
    time_budget
        Stop when this time [s] is over. With the same ``samples`` as the report names, the result is the same bits.
    sampling
        Whether paths start from evenly spread points (scrambled Sobol) or from independent random ones.
    sides
        Where light comes from: ``"front"`` (the room), ``"back"`` (outside) or both.
    color
        Whether to keep colour, of the visible band: Y, u′, v′ of trees, X, Y, Z of matrices.
    bands
        What light is counted, each as a band of its own in the result: ``"Visible"`` (CIE Y in equal-energy light),
        ``"Solar"``, ``"NIR"``, ``"UV"`` (sunlight from 300 to 2500, 780 to 2500, 300 to 380 nm), a wavelength in nm as
        ``"550"``, or a mean over wavelengths with a name as ``"PAR:400-700"``. Materials with spectra are traced by
        wavelengths. A mapping gives for a band ``None``, or Radiance files of materials that the device has in that
        band under the same names, or a whole :class:`Device`: ``{"Visible": None, "Solar": "solar.rad"}``.
    reciprocity
        Whether to average pairs of directions with the same pairs swapped; by default, where both must be equal: all
        materials are reciprocal, and the device repeats (``tile``) or is flat, so that no light leaves by its sides.
        Not for rank 3.
    reuse
        Whether diffused light is followed to and from patches of surface, which all directions share, and corrected by
        full paths (trees of rank 4).
    prune
        Whether to merge cells of a tree that differ only by noise.
    dim
        ``xmin xmax ymin ymax zmin zmax`` [unit] of the box that stands for the device, instead of its bounding box.
    tile
        Whether the device repeats for ever: what leaves one period by a side enters the next, so that nothing is
        lost at the edges of a finite sample. The period is ``dim``, or the one that a parametric device knows.
    unit
        Unit of length in scene files and in the header of the result.
    up
        The axis that points up in the drawing: x, -x, y, -y, z or -z.
    geometry
        Whether to put the device into the file too, as MGF, its middle at x = y = 0, as genBSDF does.
    seed
        Equal seeds give equal bits, whatever the number of threads.
    threads
        Number of threads; all processors by default.
    checkpoint
        A directory, new or empty at first, that keeps what was counted. A generation that was interrupted, in whatever
        way, goes on where it was when it is called again, and ends with the same bits; one that is done goes on to more
        ``samples`` (from the last power of two, or multiple of 16 384, so that the bits are those of as many at once).
        Another device, or an option that changes what is counted, is refused. The directory stays when all is done.
    engine
        What traces: our own tracer, or Radiance's ``rcontrib`` (with the extra ``radiance``), for scenes with what ours
        does not know, and to compare. Radiance's results differ a little in each run. It knows no ``tolerance``,
        ``time_budget``, ``detail``, ``tile`` or ``checkpoint``, and takes lengths as they stand in the files.
    rcontrib
        With Radiance, more options of its program, such as ``["-ab", "8"]``. Those of genBSDF come first:
        ``-ab 5 -ad 700 -lw 3e-6``.
    cull_percent
        With Radiance, how much of a tree its reducer culls, in [0, 100); nothing is culled without ``prune``.
    allow_commands
        Programs that ``!`` commands of scene files may run besides those that are understood.
    progress
        Called about 10 times a second with paths done and paths to do.
    resumed
        Called once if something of the checkpoint was used, with where the generation goes on.
    report
        Called once at the end with what was done.

    Raises
    ------
    ValueError
        If the device or an option is not understood, or the checkpoint is of another generation or cannot be written.
    """
    if sampling not in ("sobol", "random"):
        raise ValueError(f"sampling {sampling!r}; expected 'sobol' or 'random'")
    if dim is not None and len(dim) != 6:
        raise ValueError(f"dim has {len(dim)} numbers; expected xmin xmax ymin ymax zmin zmax")
    if engine == "radiance":
        unknown = {
            "tolerance": tolerance is not None,
            "time_budget": time_budget is not None,
            "detail": detail is not None,
            "tile": tile,
            "checkpoint": checkpoint is not None,
            "sampling": sampling == "random",
            "bands": list(bands) != ["Visible"],
        }
        for option in (name for name, given in unknown.items() if given):
            advice = "use engine 'bsdftree' or leave it out"
            if option == "bands":
                advice = (
                    "it counts Visible; use engine 'bsdftree', or give it the materials that the device has in a band "
                    "and call what comes out by that name"
                )
            raise ValueError(f"the engine radiance knows no {option}; {advice}")
        return generate_by_radiance(
            device,
            rank=0 if klems is not None else rank,
            log2_res=log2_res,
            klems=klems if klems is None or isinstance(klems, str) else list(klems),
            subdivide=subdivide,
            samples=2000 if samples is None else samples,
            sides=sides,
            color=color,
            reciprocity=reciprocity is True,
            cull_percent=cull_percent if prune else None,
            dim=dim,
            unit=unit,
            up=up,
            geometry=geometry,
            seed=seed,
            processes=threads or os.cpu_count() or 1,
            options=rcontrib,
            allow_commands=allow_commands,
            progress=progress,
            report=report,
        )
    if engine != "bsdftree":
        raise ValueError(f"engine {engine!r}; expected 'bsdftree' or 'radiance'")
    device = as_device(device, unit, allow_commands)
    names, own = _of_bands(device, bands, unit, allow_commands)
    if up.lstrip("+").lower() != "y":
        device = device.turned_up(up)
        own = [(name, other.turned_up(up)) for name, other in own]
    aperture = None
    if dim is not None:
        aperture = (tuple(map(float, dim[0::2])), tuple(map(float, dim[1::2])))
    generation = _core.generate(
        device._core,
        rank=rank,
        log2_res=log2_res,
        klems=klems if klems is None or isinstance(klems, str) else [(lower, upper, n) for lower, upper, n in klems],
        subdivide=subdivide,
        samples=samples if samples is not None else 2000 if tolerance is None and time_budget is None else 2**20,
        tolerance=tolerance,
        direction_tolerance=direction_tolerance,
        detail=detail,
        time_budget=time_budget,
        stratified=sampling == "sobol",
        sides=sides,
        color=color,
        bands=names,
        own=[(name, other._core) for name, other in own],
        reciprocity=reciprocity,
        reuse=reuse,
        pruned=prune,
        aperture=aperture,
        tile=tile,
        unit=unit,
        seed=seed,
        threads=threads,
        checkpoint=None if checkpoint is None else os.fspath(checkpoint),
        geometry=geometry,
    )
    told = False
    try:
        while True:
            ended = generation.wait(0.1)
            if resumed is not None and not told and (where := generation.resumed()) is not None:
                told = True
                resumed(Resumed(*where))
            if ended:
                break
            if progress is not None:
                progress(*generation.paths())
    except BaseException:
        # Ctrl-C, or an error in what is called: let the threads end before it goes on its way.
        generation.cancel()
        generation.wait(60.0)
        raise
    core, errors, done = generation.result()
    if progress is not None:
        progress(*generation.paths())
    reports = tuple(
        BandReport(name, error, direction_error, dict(totals)) for name, error, direction_error, totals in done["bands"]
    )
    summary = GenerationReport(
        done["paths"],
        done["samples"],
        done["stop"],
        done["error"],
        done["direction_error"],
        Bsdf(errors),
        reports[0].totals,
        done["lost"],
        done["tracing_seconds"],
        done["reducing_seconds"],
        done["aperture"],
        tuple(done["warnings"]),
        reports,
    )
    if report is not None:
        report(summary)
    what = f"rank {rank} 2^{log2_res}"
    if klems is not None:
        what = f"klems {klems if isinstance(klems, str) else 'of own rings'}" + f" {subdivide}x{subdivide}" * (
            subdivide > 1
        )
    made = (
        f"Created by: bsdftree {_core.__version__} generate ({what}, {summary.samples} samples per incident cell, "
        f"{summary.paths} paths, seed {seed}, sides {sides}{', tiled' if tile else ''}{', color' if color else ''}"
        f"{'' if list(bands) == ['Visible'] else ', bands ' + ' '.join(bands)}"
        f"{'' if reciprocity is None else ', reciprocity' if reciprocity else ', no reciprocity'}"
        f"{', random' if sampling == 'random' else ''}{'' if prune or klems else ', not pruned'}, "
        f"estimated error {100 * summary.error:.1f} % of the whole)"
    )
    return Bsdf(core.with_header(None, None, None, [made]))


def _of_bands(
    device: Device, bands: Bands, unit: str, allow_commands: Sequence[str]
) -> tuple[list[str], list[tuple[str, Device]]]:
    """The bands that the device itself has, and those with materials of their own."""
    if isinstance(bands, str):
        raise ValueError(f"bands {bands!r}; expected a sequence such as ['Visible', 'Solar'], or a mapping")
    if not isinstance(bands, Mapping):
        return list(bands), []
    own: list[tuple[str, Device]] = []
    for name, given in bands.items():
        if isinstance(given, Device):
            own.append((name, given))
        elif given is not None:
            files = [given] if isinstance(given, str | os.PathLike) else list(given)
            own.append((name, device.with_materials(*files, unit=unit, allow_commands=allow_commands)))
    return [name for name, given in bands.items() if given is None], own
