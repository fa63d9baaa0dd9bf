"""Radiance's way from scans to a tree: pabopto2bsdf, then bsdf2ttree or bsdf2klems, live, on the same files.

Options are those of its manual pages, in its favour where there is a choice: symmetry by the incident directions given
(one azimuth: isotropic, four quadrants: anisotropic); trees are not culled (`-t -1`, "may be useful for comparisons"),
so that nothing is lost to reduction; 256 samples in cells that differ from their neighbours (default). Results are kept
in the cache under a hash of the files and the commands, with what they cost.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benches.generate.process import Cost, run

import bsdftree
from bsdftree._radiance.programs import environment, words_of


@dataclass(frozen=True)
class Outcome:
    """The XML file, and what both programs cost."""

    path: Path
    interpolant: Cost
    resampling: Cost

    def bsdf(self) -> bsdftree.Bsdf:
        """Radiance's files have what strict reading refuses."""
        return bsdftree.load(self.path, strict=False)


def tree(scans: Sequence[Path], log2_res: int, cache: Path) -> Outcome:
    """A tree of 2^log2_res cells per axis, of the rank that the incident directions say."""
    return _kept(scans, ["bsdf2ttree", "-p", "-t", "-1", "-g", log2_res], cache)


def klems(scans: Sequence[Path], cache: Path) -> Outcome:
    """A full Klems matrix."""
    return _kept(scans, ["bsdf2klems", "-p"], cache)


def _kept(scans: Sequence[Path], resample: list[object], cache: Path) -> Outcome:
    content = hashlib.sha256(repr(resample).encode())
    for scan in scans:
        content.update(scan.read_bytes())
    name = content.hexdigest()[:16]
    path, costs = cache / f"incumbent-{name}.xml", cache / f"incumbent-{name}.json"
    if not costs.exists():
        cache.mkdir(parents=True, exist_ok=True)
        costs.write_text(json.dumps([vars(cost) for cost in _made(scans, resample, path)]))
    first, second = (Cost(**cost) for cost in json.loads(costs.read_text()))
    return Outcome(path, first, second)


def _made(scans: Sequence[Path], resample: list[object], path: Path) -> tuple[Cost, Cost]:
    with tempfile.TemporaryDirectory(dir=path.parent) as temporary:
        interpolant, xml = Path(temporary) / "scans.sir", Path(temporary) / "made.xml"
        first = run(
            words_of("pabopto2bsdf", "-n", os.cpu_count() or 1, *scans), stdout=interpolant, environment=environment()
        )
        second = run(words_of(*map(str, resample), interpolant), stdout=xml, environment=environment())
        xml.rename(path)
    return first, second
