"""Radiance as the oracle: its library and its programs as they come in the pyradiance wheel.

In: paths, and directions as (n, 3) unit vectors. Out: NumPy arrays, text. The library is asked in a process of its own
(this file, run as a script), because malformed files can crash it and it is not thread-safe.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bsdftree._radiance.programs import environment, find_folder

FOLDER = find_folder()
SECONDS = 200

needs_radiance = pytest.mark.skipif(
    FOLDER is None, reason="SKIPPED: no pyradiance; pip install 'bsdftree[radiance]' brings Radiance"
)

REFLECTION, TRANSMISSION, ALL = 13, 14, 15
"""What `sample` and `hemispherical` ask of the library: Lambertian and specular parts of one or both sides."""

REAL_FILES = [
    "bsdfxmlparser/2011-SA1.XML",
    "frads/blinds30.xml",
    "frads/ec60.xml",
    "ignis/simple_klems_through_trans.xml",
    "ignis/simple_tensor_d2_refl.xml",
    "ignis/simple_tensor_d2_t3_trans.xml",
    "ignis/simple_tensor_d3_t3_refl.xml",
    "ignis/simple_tensor_front_refl.xml",
    "ignis/simple_tensor_refl.xml",
    "ignis/simple_tensor_trans.xml",
    "mermet/E_Screen_3pct_White.xml",
    "pyradiance/blinds.xml",
    "pyradiance/blindsT3.xml",
    "pyradiance/clear.xml",
    "pyradiance/t3.xml",
    "pyradiance/ven45.xml",
    "radiance/sawtooth.xml",
    "radiance/testBSDF.xml",
]
TRUNCATED_FILES = ["bsdfxmlparser/2011-SA1-Small-CommaSeparated.XML", "bsdfxmlparser/2011-SA1-Small-TabSeparated.XML"]

PARTS = {"reflection": REFLECTION, "transmission": TRANSMISSION, "all": ALL}


def run(program: str, *arguments: object, stdin: str | bytes = b"", cwd: Path | None = None) -> bytes:
    """Output of one of Radiance's programs; its message, if it fails."""
    assert FOLDER is not None
    done = subprocess.run(
        [FOLDER / "bin" / program, *map(str, arguments)],
        input=stdin.encode() if isinstance(stdin, str) else stdin,
        capture_output=True,
        cwd=cwd,
        env=environment(),
        timeout=SECONDS,
    )
    if done.returncode != 0:
        raise RuntimeError(f"{program} {' '.join(map(str, arguments))}: {done.returncode}\n{done.stderr.decode()}")
    return done.stdout


def degrees(directions: np.ndarray) -> np.ndarray:
    """Polar angle and azimuth of directions [degree], (n, 2)."""
    x, y, z = directions.T
    return np.degrees(np.stack([np.arctan2(np.hypot(x, y), z), np.arctan2(y, x) % (2 * np.pi)], axis=1))


class Library:
    """Questions to Radiance's BSDF library about one file; each is one process, of which a crash is an error."""

    def __init__(self, path: os.PathLike[str] | str) -> None:
        self.path = os.fspath(path)

    def _ask(self, **questions: Any) -> dict[str, np.ndarray]:
        done = subprocess.run(
            [sys.executable, __file__],
            input=pickle.dumps((self.path, questions)),
            capture_output=True,
            timeout=SECONDS,
        )
        if done.returncode != 0:
            raise RuntimeError(f"Radiance's library on {self.path}: {done.returncode}\n{done.stderr.decode()[-2000:]}")
        return pickle.loads(done.stdout)

    def answers(
        self,
        *,
        pairs: tuple[np.ndarray, np.ndarray] | None = None,
        resolution: tuple[np.ndarray, np.ndarray] | None = None,
        incident: np.ndarray | None = None,
        sample: tuple[np.ndarray, int, int] | None = None,
    ) -> dict[str, np.ndarray]:
        """Answer several questions with one reading of the file.

        `xyz` (n, 3) for pairs; `solid_angle` (n, 2: smallest, largest) for pairs of `resolution`; `all`, `reflection`,
        `transmission` (n,) for incident directions; `samples` (m, n, 3) for m incident directions, n samples each.
        """
        return self._ask(
            pairs=None if pairs is None else np.hstack([degrees(d) for d in pairs]),
            resolution=None if resolution is None else np.hstack([degrees(d) for d in resolution]),
            incident=None if incident is None else degrees(incident),
            sample=None if sample is None else (degrees(sample[0]), *sample[1:]),
        )


def refuses(path: os.PathLike[str]) -> bool:
    """Whether Radiance's library refuses a file, or crashes on it."""
    try:
        Library(path).answers()
    except RuntimeError:
        return True
    return False


def generate(device: Path, into: Path, *, rank: int = 0, log2_res: int = 0, samples: int, basis: str = "kq") -> Path:
    """Generate a BSDF as genBSDF does (its settings, rfluxmtx); of a tree, nothing is culled or averaged.

    Rank 0 is Klems of a basis (kf, kh, kq). Rays are as many as `samples` or some more for each incident cell.
    """
    from pyradiance.genbsdf import generate_bsdf, generate_xml

    made = generate_bsdf(
        str(device), tensortree=rank, ttlog2=log2_res, basis=basis, nsamp=samples, nproc=2, pctcull=0, recip=False
    )
    into.write_bytes(generate_xml(vis_results=made, basis=f"t{rank}" if rank else basis))
    return into


def _answer(path: str, pairs: Any, resolution: Any, incident: Any, sample: Any) -> dict[str, np.ndarray]:
    import pyradiance.bsdf as library

    held = library.load_file(path)
    if held is None:
        raise ValueError("load_file gave nothing")
    answers = {}
    if pairs is not None:
        answers["xyz"] = np.array([library.query(held, *pair) for pair in pairs.tolist()]).reshape(-1, 3)
    if resolution is not None:
        extrema = library.QUERY_MIN | library.QUERY_MAX
        answers["solid_angle"] = np.array([library.size2(held, *pair, extrema) for pair in resolution.tolist()])
    if incident is not None:
        for name, flags in PARTS.items():
            answers[name] = np.array([library.direct_hemi(held, *angles, flags) for angles in incident])
    if sample is not None:
        angles, n, flags = sample
        answers["samples"] = np.array([library.sample(held, *a, n, flags)[:, :3] for a in angles])
    return answers


if __name__ == "__main__":
    _path, _questions = pickle.loads(sys.stdin.buffer.read())
    sys.stdout.buffer.write(pickle.dumps(_answer(_path, **_questions)))
    sys.stdout.flush()
    os._exit(0)  # Without the library's destructors: they free some files' data twice.
