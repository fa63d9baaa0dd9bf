"""What a check found, and what was mended."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

Direction = tuple[float, float, float]

#: What findings are about, in the order in which they are mended.
KINDS = ("values", "units", "orientation", "sides", "reciprocity", "energy", "colour", "noise")


@dataclass(frozen=True)
class Finding:
    """Something to know.

    Attributes
    ----------
    kind
        What it is about: one of ``values``, ``units``, ``orientation``, ``sides``, ``reciprocity``, ``energy``,
        ``colour``, ``noise``.
    severity
        ``"violation"`` of physics or of the format, ``"warning"`` of what may not be meant, or ``"note"``: a guess, or
        something to know.
    part
        The component, if it is about one; ``transmission_front`` also for both transmissions against each other.
    incident, exitant
        Where it is worst, if it is somewhere.
    amount
        How much, as the message says in words.
    message
        What, where and how much.
    advice
        What to do, if there is something.
    repair
        Whether :meth:`Bsdf.repaired` can mend it.
    """

    kind: str
    severity: Literal["violation", "warning", "note"]
    part: str | None
    incident: Direction | None
    exitant: Direction | None
    amount: float
    message: str
    advice: str
    repair: bool


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
    over
        Share of incident directions, by projected solid angle, whose total is over 1.
    """

    side: str
    reflected: float
    transmitted: float
    max: float
    at: Direction
    over: float


@dataclass(frozen=True)
class Reciprocity:
    """Difference under swapping of directions: |a - b| / (a + b), drawn by flux.

    Attributes
    ----------
    part
        A reflection, or ``"transmission"``: the two against each other.
    mean, max
        By flux, and the largest of the pairs drawn.
    at
        Incident and exitant direction of the largest.
    """

    part: str
    mean: float
    max: float
    at: tuple[Direction, Direction]


@dataclass(frozen=True)
class Symmetry:
    """How much a component changes when the device is mirrored or turned: means of |a - b| / (a + b) by flux."""

    part: str
    left_right: float
    top_bottom: float
    quarter_turn: float


@dataclass(frozen=True)
class Noise:
    """Relative standard deviation of a value, told from the data alone.

    Attributes
    ----------
    level
        The smaller of the estimates; None if there is none.
    neighbours
        From values beside each other, where ``coverage`` of the light is.
    reversal
        From swapped pairs of directions; None if there are none, or the data was made reciprocal.
    """

    part: str
    level: float | None
    neighbours: float | None
    coverage: float
    reversal: float | None


@dataclass(frozen=True)
class Gamut:
    """Colours of a component.

    Attributes
    ----------
    impossible
        Share of its light beyond the spectral locus.
    beyond_rgb
        Share of its light of which Radiance's RGB would be negative.
    max
        How far the worst is beyond the locus [u'v'].
    uv, at
        Its u', v', and its incident and exitant direction.
    """

    part: str
    impossible: float
    beyond_rgb: float
    max: float
    uv: tuple[float, float]
    at: tuple[Direction, Direction]


@dataclass(frozen=True)
class BandCheck:
    """Results for one band; findings, the worst first."""

    band: str
    energy: tuple[Energy, ...]
    reciprocity: tuple[Reciprocity, ...]
    symmetry: tuple[Symmetry, ...]
    noise: tuple[Noise, ...]
    gamut: tuple[Gamut, ...]
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing is violated."""
        return all(finding.severity != "violation" for finding in self.findings)


@dataclass(frozen=True)
class Check:
    """Results for a BSDF: ``findings`` are those of its header, ``bands`` have their own."""

    findings: tuple[Finding, ...]
    bands: tuple[BandCheck, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing is violated."""
        return all(finding.severity != "violation" for _, finding in self.all())

    def all(self) -> Iterator[tuple[str | None, Finding]]:
        """All findings with the band that they are about, or None."""
        yield from ((None, finding) for finding in self.findings)
        for band in self.bands:
            yield from ((band.band, finding) for finding in band.findings)


@dataclass(frozen=True)
class Mended:
    """One thing that was mended: ``measure`` says what the numbers ``before`` and ``after`` are."""

    kind: str
    band: str | None
    part: str | None
    what: str
    measure: str
    before: float
    after: float


def check_of(findings: list[dict[str, Any]], bands: list[dict[str, Any]]) -> Check:
    """Objects from what the extension returns."""
    kinds = {"energy": Energy, "reciprocity": Reciprocity, "symmetry": Symmetry, "noise": Noise, "gamut": Gamut}

    def made(cls: type[Any], row: dict[str, Any]) -> Any:
        return cls(**{key: _frozen(value) for key, value in row.items()})

    def band_of(band: dict[str, Any]) -> BandCheck:
        rows = {key: tuple(made(cls, row) for row in band[key]) for key, cls in kinds.items()}
        return BandCheck(band["band"], **rows, findings=tuple(made(Finding, f) for f in band["findings"]))

    return Check(tuple(made(Finding, f) for f in findings), tuple(band_of(band) for band in bands))


def _frozen(value: Any) -> Any:
    return tuple(_frozen(v) for v in value) if isinstance(value, list) else value
