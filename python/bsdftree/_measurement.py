"""Measured BSDFs: scattered values, as goniophotometers give them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bsdftree import _core
from bsdftree._whole_file import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Symmetry = Literal["anisotropic", "half_turn", "bilateral_x", "bilateral_y", "quadrilateral", "isotropic"]
Side = Literal["front", "back"]
Path_ = str | os.PathLike[str]


class Scan(NamedTuple):
    """Values for one incident direction.

    Directions are unit vectors away from the surface, +Z the front (the room). Exitant directions may lie on both
    sides.
    """

    incident: Array
    """Where the light came from, (3,)."""
    exitant: Array
    """Where it was measured, (n, 3)."""
    values: Array
    """BSDF [1/sr] without a cosine, (n,), or (n, 3) for X, Y and Z. Noise may make values negative."""
    errors: Array | None
    """Standard errors of the values [1/sr], of the same shape, if they are known."""
    source: str
    """Where it is from: file, and block or sheet if the file has several."""


@dataclass(frozen=True)
class ScanSummary:
    """What was measured of one part with light from one direction.

    Attributes
    ----------
    scan
        Which of :attr:`Measurement.scans`.
    part
        ``reflection_front``, ``reflection_back``, ``transmission_front`` or ``transmission_back``; front is the
        outside here, as in WINDOW.
    incident_theta_deg, incident_phi_deg
        Where the light came from [degree], theta from +Z.
    n_points
        How many exitant directions.
    theta_range_deg
        Smallest and largest angle from the normal of the side that it was measured on [degree].
    azimuth_coverage_deg
        Azimuths that there are points at, in steps of 10 [degree]; 360 is all.
    spacing_deg
        Median angle from a point to the nearest other one [degree]; None of one point.
    hole_deg
        Farthest that a direction of the hemisphere, down to 8 above the horizon, is from any point [degree].
        Of isotropic samples, mirror images of points at the plane of incidence count too.
    value_range
        Smallest and largest value [1/sr], of colour those of Y.
    n_negative
        How many values are below 0.
    relative_error
        Median of standard error over value; None if errors are not known.
    asymmetry
        How far values are from those mirrored at the plane of incidence, relative (L1, by projected solid angle); of
        isotropic samples this is noise. None of vertical light, and of points on one side.
    total
        Estimate of the fraction of the light that is scattered there; None if a hole is larger than 20 degrees.
    """

    scan: int
    part: str
    incident_theta_deg: float
    incident_phi_deg: float
    n_points: int
    theta_range_deg: tuple[float, float]
    azimuth_coverage_deg: float
    spacing_deg: float | None
    hole_deg: float
    value_range: tuple[float, float]
    n_negative: int
    relative_error: float | None
    asymmetry: float | None
    total: float | None


class Measurement:
    """All that was measured of one sample.

    Parameters
    ----------
    scans
        For each incident direction a tuple (incident, exitant, values) or (incident, exitant, values, errors), or a
        :class:`Scan`. Shapes as there; vectors need not be of unit length.
    name, manufacturer
        Of the sample.
    symmetry
        What turns and mirrors the sample looks the same after, if it is known: ``bilateral_x`` is a mirror at the
        plane y = 0, ``bilateral_y`` at x = 0, ``quadrilateral`` both; ``half_turn`` is half a turn without a mirror.
    wavelength_nm
        Wavelength of the source [nm], if there is one.
    notes
        What was assumed, repaired or left out, a sentence each.

    Raises
    ------
    ValueError
        If shapes do not fit, a value is not finite, a vector has no direction, or only some scans have colour.

    Examples
    --------
    >>> from bsdftree import direction_from_polar
    >>> exitant = direction_from_polar([0, 30, 60], 0)
    >>> white = Measurement([([0, 0.6, 0.8], exitant, [0.25, 0.25, 0.25])], name="white")
    >>> white.parts
    ['reflection_back']
    >>> white.scans[0].exitant.shape
    (3, 3)
    """

    FORMATS = _core.MEASUREMENT_FORMATS
    """Names of the formats that are read."""

    def __init__(
        self,
        scans: Iterable[Scan | Sequence[ArrayLike | None]],
        *,
        name: str | None = None,
        manufacturer: str | None = None,
        symmetry: Symmetry | None = None,
        wavelength_nm: float | None = None,
        notes: Sequence[str] = (),
    ) -> None:
        rows = [_scan_arrays(k, scan) for k, scan in enumerate(scans)]
        if not rows:
            raise ValueError("no scans; expected one or more")
        channels = {row[2].shape[1] for row in rows}
        if len(channels) > 1:
            raise ValueError("some scans have one value for each direction and some three; expected the same of all")
        self._core = _core.Measurement.of_arrays(
            rows,
            n_channels=channels.pop(),
            name=name,
            manufacturer=manufacturer,
            symmetry=symmetry,
            wavelength_nm=wavelength_nm,
            notes=list(notes),
        )

    @classmethod
    def load(
        cls,
        paths: Path_ | Iterable[Path_],
        *,
        columns: str | Mapping[str, str | int] | None = None,
        side: Side = "front",
        format: str | None = None,
        grazing: float | Literal["auto"] | None = None,
    ) -> Measurement:
        """Read the files of one sample.

        Parameters
        ----------
        paths
            One or more files of one format. What they are, is seen from their content.
        columns
            Of tables (CSV): which column is what, by name or by number from 1, as
            ``"theta_i=INC,phi_i=2,theta_o=5,phi_o=6,value=BSDF"`` or a dictionary. ``phi_i`` and ``phi_o`` may be
            absent; ``x_i``, ``y_i``, ``z_i`` and ``x_o``, ``y_o``, ``z_o`` are vectors; ``X``, ``Y``, ``Z`` may stand
            for ``value``; ``error`` is its standard error. Beside them ``angles=rad``, ``values=dsf`` (a cosine is in
            the values), ``percent=yes``.
        side
            The side of the device that was the sample's front when it was measured: ``front`` is the room. With
            ``back`` the sample is turned about the vertical, so that up stays up.
        format
            If the content does not tell: one of :attr:`FORMATS`.
        grazing
            Points nearer to the surface than this [degree] are left out, where scans are noisy and see edges; with
            ``"auto"`` those nearer than the lowest incident direction.

        Returns
        -------
        Measurement
            Scans of the same incident direction are one. ``notes`` says what was assumed.

        Raises
        ------
        ValueError
            If a file is not as it must be, with the line, cell or byte.
        OSError
            If a file cannot be read.
        """
        names = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
        if isinstance(columns, Mapping):
            columns = ",".join(f"{name}={column}" for name, column in columns.items())
        paths_ = [os.fspath(name) for name in names]
        angle = float("inf") if grazing == "auto" else grazing
        return cls._of(_core.Measurement.read(paths_, format=format, columns=columns, side=side, grazing=angle))

    @classmethod
    def _of(cls, core: _core.Measurement) -> Measurement:
        made = cls.__new__(cls)
        made._core = core
        return made

    @cached_property
    def scans(self) -> list[Scan]:
        """Values by incident direction."""
        grey = self.n_channels == 1
        return [
            Scan(
                incident,
                exitant,
                values[:, 0] if grey else values,
                errors if errors is None or not grey else errors[:, 0],
                source,
            )
            for incident, exitant, values, errors, source in self._core.scans
        ]

    @property
    def n_channels(self) -> int:
        """Numbers for each pair of directions: 1, or 3 for CIE X, Y and Z."""
        return self._core.n_channels

    @property
    def name(self) -> str | None:
        """What the sample is called."""
        return self._core.name

    @property
    def manufacturer(self) -> str | None:
        """Who made it."""
        return self._core.manufacturer

    @property
    def symmetry(self) -> Symmetry | None:
        """The symmetry that the file states."""
        return self._core.symmetry  # type: ignore[return-value]

    @property
    def wavelength_nm(self) -> float | None:
        """Wavelength of the source [nm]."""
        return self._core.wavelength_nm

    @property
    def notes(self) -> list[str]:
        """What was assumed, repaired or left out in reading, a sentence each."""
        return self._core.notes

    @property
    def parts(self) -> list[str]:
        """The components that there are values of, as ``reflection_front``; front is the outside here, as in WINDOW."""
        return self._core.parts

    def summary(self) -> list[ScanSummary]:
        """Say what was measured: one row for each part of each scan."""
        return [ScanSummary(**row) for row in self._core.summary()]

    def plot(self, *, title: str | None = None, limits: tuple[float, float] | None = None) -> Figure:
        """Draw what was measured: :func:`bsdftree.plot.measurement`."""
        from bsdftree.plot import measurement

        return measurement(self, title=title, limits=limits)

    def save(self, directory: Path_) -> list[Path]:
        """Write pab-opto's text, which Radiance's pabopto2bsdf takes: one file for each part of each scan.

        Parameters
        ----------
        directory
            Made if it is not there. Files of the same names are replaced.

        Returns
        -------
        list of Path
            What was written. Errors and notes have no place in the format.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        folder = Path(directory)
        folder.mkdir(parents=True, exist_ok=True)
        written = []
        for name, text in self._core.to_pab_opto():
            write_whole(folder / name, text.encode())
            written.append(folder / name)
        return written

    def __repr__(self) -> str:
        n_points = sum(len(scan.exitant) for scan in self.scans)
        name = f"{self.name!r}, " if self.name else ""
        what = "XYZ" if self.n_channels == 3 else "grey"
        return f"Measurement({name}{len(self.scans)} scans, {n_points} points, {what}, {', '.join(self.parts)})"


def _scan_arrays(k: int, scan: Scan | Sequence[ArrayLike | None]) -> tuple[Array, Array, Array, Array | None, str]:
    """A scan as the core takes it: values and errors are tables."""
    if not 3 <= len(scan) <= 5:
        raise ValueError(f"scan {k} has {len(scan)} parts; expected incident, exitant, values and perhaps errors")
    incident, exitant = (np.ascontiguousarray(a, float) for a in scan[:2])
    if incident.shape != (3,):
        raise ValueError(f"scan {k}: incident has shape {incident.shape}; expected (3,)")
    if exitant.ndim != 2 or exitant.shape[1] != 3:
        raise ValueError(f"scan {k}: exitant has shape {exitant.shape}; expected (n, 3)")
    if not len(exitant):
        raise ValueError(f"scan {k} has no exitant directions; expected one or more")
    values = np.ascontiguousarray(scan[2], float)
    if values.shape not in ((len(exitant),), (len(exitant), 3)):
        n = len(exitant)
        raise ValueError(f"scan {k}: values have shape {values.shape}; expected ({n},), or ({n}, 3) for X, Y and Z")
    errors = None
    if len(scan) > 3 and scan[3] is not None:
        errors = np.ascontiguousarray(scan[3], float)
        if errors.shape != values.shape:
            raise ValueError(f"scan {k}: errors have shape {errors.shape}; expected {values.shape}, as values")
        errors = errors.reshape(len(exitant), -1)
    source = scan[4] if len(scan) > 4 else ""
    return incident, exitant, values.reshape(len(exitant), -1), errors, str(source)
