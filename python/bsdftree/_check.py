"""What a check found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Energy:
    """Scattered light from one side.

    Attributes
    ----------
    side
        ``"front"`` (the room) or ``"back"``.
    reflected, transmitted
        Means over all incident directions by projected solid angle.
    max
        Largest total.
    at
        Incident direction of the largest total.
    """

    side: str
    reflected: float
    transmitted: float
    max: float
    at: tuple[float, float, float]


@dataclass(frozen=True)
class Reciprocity:
    """Difference under swapping of directions: |a - b| / (a + b), drawn by flux."""

    part: str
    mean: float
    max: float


@dataclass(frozen=True)
class Finding:
    """Something to know: ``severity`` is ``"violation"`` or ``"warning"``."""

    severity: str
    message: str


@dataclass(frozen=True)
class BandCheck:
    """Results for one band."""

    band: str
    energy: tuple[Energy, ...]
    reciprocity: tuple[Reciprocity, ...]
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing is violated."""
        return all(finding.severity != "violation" for finding in self.findings)


def band_checks(bands: list[dict[str, Any]]) -> list[BandCheck]:
    """Objects from what the extension returns."""
    return [
        BandCheck(
            band["band"],
            tuple(Energy(**{**e, "at": tuple(e["at"])}) for e in band["energy"]),
            tuple(Reciprocity(**r) for r in band["reciprocity"]),
            tuple(Finding(**f) for f in band["findings"]),
        )
        for band in bands
    ]
