"""Running Radiance's ``rcontrib``: rays in, what they contribute to each exitant cell out.

In: a scene, the face of its box, the cells. Out: for each incident cell and replicate, the fractions of light by side
of exit and exitant cell, in red, green and blue. Invariant: records come in the order of the rays.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import threading
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from bsdftree import _core
from bsdftree._radiance.programs import RadianceError, environment, failure, run, words_of
from bsdftree._radiance.scene import SceneText

REPLICATES = 8
"""Of `bsdftree_generate::random::Stratified`: path k belongs to replicate k modulo this."""
OPTIONS = ("-ab", "5", "-ad", "700", "-lw", "3e-6")
"""What genBSDF gives to rcontrib."""
CLEARANCE = 2e-5
"""Least distance of starting points from the box; Radiance takes no hits nearer than 1e-6 of a unit."""
RECEIVERS = """
void glow bsdftree_receiver_front
0
0
4 1 1 1 0

bsdftree_receiver_front source bsdftree_front
0
0
4 0 0 1 180

void glow bsdftree_receiver_back
0
0
4 1 1 1 0

bsdftree_receiver_back source bsdftree_back
0
0
4 0 0 -1 180
"""


@dataclass(frozen=True)
class Rays:
    """Which rays start from one side.

    Attributes
    ----------
    layout
        The cells.
    dim
        xmin, xmax, ymin, ymax, zmin, zmax of the box that they start on.
    from_back
        Whether they start on its back.
    samples
        Rays of an incident cell, a multiple of 8.
    seed
        Of their starting points.
    """

    layout: _core.Layout
    dim: tuple[float, ...]
    from_back: bool
    samples: int
    seed: int

    def of_cell(self, cell: int, replicates: Sequence[int], azimuth: float | None) -> bytes:
        """Return rays of an incident cell, replicate after replicate: origin and direction as 64-bit numbers.

        With ``azimuth`` [radian] all travel that way.
        """
        starts = self.layout.starts(self.from_back, cell, self.samples, self.seed)
        starts = np.concatenate([starts[k::REPLICATES] for k in replicates])
        x, y, s, t = starts.T
        if azimuth is not None:
            radius = np.hypot(x, y)
            x, y = radius * np.cos(azimuth), radius * np.sin(azimuth)
        z = np.sqrt(np.maximum(0.0, 1.0 - x * x - y * y))
        x0, x1, y0, y1, z0, z1 = self.dim
        rays = np.empty((len(starts), 6))
        rays[:, 3], rays[:, 4], rays[:, 5] = x, y, z if self.from_back else -z
        rays[:, 0], rays[:, 1], rays[:, 2] = x0 + s * (x1 - x0), y0 + t * (y1 - y0), z0 if self.from_back else z1
        # A little before the face, along the ray: what lies in the face is met.
        rays[:, :3] -= rays[:, 3:] * max(CLEARANCE, 1e-4 * min(x1 - x0, y1 - y0))
        return rays.tobytes()


@dataclass(frozen=True)
class Run:
    """One run of rcontrib: the function file of its bins, its replicates, and the azimuth of its rays if it has one."""

    bins: str
    replicates: tuple[int, ...]
    azimuth: float | None = None


def bounds(scene: SceneText) -> tuple[float, ...]:
    """Smallest and largest x, y, z of a scene, as genBSDF asks for them."""
    numbers = run("getbbox", "-h", "-w", stdin=scene.text, directories=scene.directories).split()
    box = tuple(map(float, numbers))
    # Of nothing, the box is inside out.
    if len(box) != 6 or box[0] > box[1]:
        raise RadianceError("the scene has no surfaces")
    return box


def compiled(scene: SceneText, folder: Path) -> Path:
    """Compile the device and what catches the light."""
    path = folder / "device.oct"
    path.write_bytes(run("oconv", "-w", "-", stdin=scene.text + RECEIVERS.encode(), directories=scene.directories))
    return path


def contributions(
    octree: Path,
    directories: Sequence[str],
    rays: Rays,
    run: Run,
    options: Sequence[str],
    processes: int,
    *,
    is_square: bool,
) -> Iterator[NDArray[np.float32]]:
    """Run rcontrib; yield, for each incident cell, (replicate, front or back, exitant cell, colour).

    Raises
    ------
    RadianceError
        If rcontrib fails.
    """
    n_incident, n_exitant = rays.layout.n_incident, rays.layout.n_exitant
    function = octree.with_name("bins.cal")
    function.write_text(run.bins)
    files = ["-f", "disk2square.cal"] if is_square else []
    receivers = [("-b", "bin", "-bn", n_exitant, "-m", f"bsdftree_receiver_{side}") for side in ("front", "back")]
    words = words_of(
        "rcontrib",
        *("-h", "-w-", *OPTIONS, *options, "-n", processes, "-fdf", "-c", rays.samples // REPLICATES),
        *(*files, "-f", function, *receivers[0], *receivers[1], octree),
    )
    shape = (len(run.replicates), 2, n_exitant, 3)
    size = 4 * int(np.prod(shape))
    with tempfile.TemporaryFile() as messages:
        process = subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=messages,
            env=environment([*directories, os.fspath(octree.parent)]),
        )
        assert process.stdin is not None and process.stdout is not None
        pieces = (rays.of_cell(cell, run.replicates, run.azimuth) for cell in range(n_incident))
        feeder = threading.Thread(target=_feed, args=(process.stdin, pieces), daemon=True)
        feeder.start()
        try:
            for _ in range(n_incident):
                data = process.stdout.read(size)
                if len(data) < size:
                    code = process.wait()
                    messages.seek(0)
                    raise failure("rcontrib", code, messages.read())
                yield np.frombuffer(data, np.float32).reshape(shape)
        finally:
            process.kill()
            feeder.join()
            process.stdout.close()
            process.wait()


def _feed(stdin: IO[bytes], pieces: Iterable[bytes]) -> None:
    """Give rays to rcontrib; if it ends before them, its message says why."""
    try:
        for piece in pieces:
            stdin.write(piece)
        stdin.close()
    except (BrokenPipeError, ValueError):
        pass
