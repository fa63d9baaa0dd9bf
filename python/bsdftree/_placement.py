"""Which way up and round a BSDF is, told by the geometry of its device.

In: a BSDF and a device. Out: the position of the device, of the sixteen that quarter turns, mirroring and turning
round make, whose BSDF is nearest. The device is traced coarsely, over the patches of Klems's quarter basis: positions
that matter differ by far more than what that costs. A BSDF alone does not tell whether it is upside down or inside out.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import Literal

from bsdftree._bsdf import Bsdf
from bsdftree._check import Finding
from bsdftree._device import Device
from bsdftree._generate import generate

# How much nearer another position must be.
CLEARLY = 0.5
# And how near, as relative L1 error: else it is another device.
NEAR = 0.6


@dataclass(frozen=True)
class Position:
    """A device turned round or not, then mirrored left to right or not, then turned by quarters."""

    flip: bool = False
    mirror: bool = False
    turn_deg: Literal[0, 90, 180, 270] = 0

    def of(self, bsdf: Bsdf) -> Bsdf:
        """Return the BSDF of the device in this position."""
        bsdf = bsdf.flipped() if self.flip else bsdf
        bsdf = bsdf.mirrored("x") if self.mirror else bsdf
        return bsdf.rotated(self.turn_deg) if self.turn_deg else bsdf

    def undone(self, bsdf: Bsdf) -> Bsdf:
        """Return the BSDF of the device put back; geometry stays, which says how it should be."""
        turned = bsdf.rotated(360 - self.turn_deg) if self.turn_deg else bsdf
        turned = turned.mirrored("x") if self.mirror else turned
        turned = turned.flipped() if self.flip else turned
        unit = bsdf._core.header["geometry_unit"]
        return turned.with_header(geometry=(bsdf.geometry, unit)) if bsdf.geometry else turned

    def __str__(self) -> str:
        words = ["turned round, front to back"] if self.flip else []
        words += ["mirrored left to right"] if self.mirror else []
        words += [f"turned by {self.turn_deg}° about its normal"] if self.turn_deg else []
        return " and ".join(words) or "as it is"


POSITIONS = [
    Position(flip, mirror, turn) for flip in (False, True) for mirror in (False, True) for turn in (0, 90, 180, 270)
]


def _aperture(bsdf: Bsdf) -> tuple[float, ...] | None:
    """Box that genBSDF was given, which the comment in its files tells."""
    found = re.search(r"genBSDF .*-dim((?: [-+.\d]+(?:[eE][-+]?\d+)?){6})", " ".join(bsdf.provenance))
    return tuple(map(float, found[1].split())) if found else None


def placed(bsdf: Bsdf, device: Device | str | os.PathLike[str], samples: int = 1000) -> list[tuple[float, Position]]:
    """How far the BSDF is from that of the device in each position, nearest first, simplest first of equals.

    Parameters
    ----------
    bsdf
        Its band ``Visible``, or the first.
    device
        What it is said to be of: files with geometry, BSDF files too.
    samples
        Paths per incident patch.

    Returns
    -------
    list of (float, Position)
        Relative L1 errors, means over the components that both have.
    """
    band = "Visible" if "Visible" in bsdf.bands else bsdf.bands[0]
    coarse = bsdf.select(bands=[band], rename=(band, "Visible")).to_klems("quarter")
    traced = generate(device, klems="quarter", samples=samples, dim=_aperture(bsdf))

    def error(position: Position) -> float:
        errors = [e for e in coarse.distance(position.of(traced)).values() if e < float("inf")]
        return sum(errors) / len(errors) if errors else float("inf")

    found = [(error(position), position) for position in POSITIONS]
    # What is nearer by noise only is not nearer: of those, the simplest, which are listed first.
    bound = 1.1 * min(error for error, _ in found) + 0.01
    nearest = [entry for entry in found if entry[0] <= bound]
    return nearest + sorted((entry for entry in found if entry[0] > bound), key=lambda entry: entry[0])


def placement_finding(positions: list[tuple[float, Position]], device: str) -> Finding:
    """What is to be said of it: a note if it is as its geometry is."""
    error, best = positions[0]
    as_it_is = next(error for error, position in positions if position == Position())
    if best == Position() and error < NEAR:
        message = f"as its geometry in {device} is, to {100 * error:.0f} % (relative L1 error of a coarse generation)"
        return Finding("orientation", "note", None, None, None, error, message, "", False)
    if error < CLEARLY * as_it_is and error < NEAR:
        message = (
            f"the data is that of the device in {device} {best}: then it differs by {100 * error:.0f} % (relative L1), "
            f"as it is by {100 * as_it_is:.0f} %"
        )
        advice = "turn it back"
        return Finding("orientation", "warning", None, None, None, as_it_is, message, advice, True)
    message = (
        f"not the data of the device in {device}: as it is, it differs by {100 * as_it_is:.0f} % (relative L1), "
        f"{best} by {100 * error:.0f} %"
    )
    advice = "see whether materials and size are those that it was made with"
    return Finding("orientation", "warning", None, None, None, as_it_is, message, advice, False)
