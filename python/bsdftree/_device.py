"""Devices: geometry and materials."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NamedTuple

from bsdftree import _core


class Parameter(NamedTuple):
    """A parameter of a parametric device."""

    name: str
    unit: str
    default: str
    range: str
    meaning: str


class Family(NamedTuple):
    """A kind of parametric device."""

    name: str
    summary: str
    drawing: str
    parameters: list[Parameter]


def device_families() -> list[Family]:
    """The parametric devices that :meth:`Device.from_spec` knows."""
    return [
        Family(f["name"], f["summary"], f["drawing"], [Parameter(*p) for p in f["parameters"]])
        for f in _core.device_families()
    ]


class Device:
    """Something that scatters light, lying in z ≤ 0 with the room at +Z and up at +Y. Lengths in metres.

    Attributes
    ----------
    n_surfaces : int
        Number of surfaces.
    bounds : list or None
        Smallest and largest x, y, z [m]; None for an empty device.
    tile : list or None
        Smallest and largest x, y, z of one period [m], for parametric devices that repeat.
    warnings : list of str
        What the reader did that you should know.
    """

    def __init__(self, core: _core.Device) -> None:
        self._core = core
        self.n_surfaces = core.n_surfaces
        self.bounds = core.bounds
        self.tile = core.tile
        self.warnings = core.warnings

    @classmethod
    def read(cls, *paths: str | os.PathLike[str], unit: str = "meter") -> Device:
        """Read Radiance scene files, in order, as one scene.

        Parameters
        ----------
        *paths
            The files.
        unit
            Unit of length in the files: meter, foot, inch, centimeter or millimeter.

        Raises
        ------
        ValueError
            If a file cannot be read or is not understood; the message names file and line and what to do.
        """
        return cls(_core.Device._read_rad([os.fspath(p) for p in paths], unit))

    @classmethod
    def parse(cls, text: str, *, directory: str | os.PathLike[str] = ".", unit: str = "meter") -> Device:
        """Read a Radiance scene from a string; files that it names are looked for in ``directory``."""
        return cls(_core.Device._parse_rad(text, os.fspath(directory), unit))

    @classmethod
    def from_spec(cls, spec: str) -> Device:
        """Make a parametric device.

        Parameters
        ----------
        spec
            ``family`` or ``family:parameter=value,…``, for instance ``blinds:depth=0.05,spacing=0.04,angle=30``;
            :func:`device_families` lists what there is.

        Raises
        ------
        ValueError
            If there is no such family or parameter, or values do not fit; the message lists what there is.
        """
        return cls(_core.Device._from_spec(spec))

    def turned_up(self, up: str) -> Device:
        """Turn a drawing whose ``up`` (x, -x, y, -y, z, -z) is not Y; with Z up, the room is towards its -Y."""
        return Device(self._core._turned_up(up))

    def to_rad(self) -> str:
        """Return the device as a Radiance scene in metres."""
        return self._core.to_rad()

    def __repr__(self) -> str:
        return repr(self._core)


def as_device(device: Device | str | os.PathLike[str] | Sequence[str | os.PathLike[str]], unit: str) -> Device:
    """Return a device from what people pass: a Device, a path, paths, or the spec of a parametric device."""
    if isinstance(device, Device):
        return device
    if isinstance(device, (str, os.PathLike)):
        text = os.fspath(device)
        family = text.partition(":")[0]
        if not os.path.exists(text) and family in {f.name for f in device_families()}:
            return Device.from_spec(text)
        return Device.read(text, unit=unit)
    return Device.read(*device, unit=unit)
