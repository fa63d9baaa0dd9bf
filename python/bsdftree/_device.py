"""Devices: geometry and materials."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

from bsdftree import _core
from bsdftree._radiance.programs import find_folder

Format = Literal["rad", "mgf"]
Materials = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


METERS = {"meter": 1.0, "foot": 0.3048, "inch": 0.0254, "centimeter": 0.01, "millimeter": 0.001}
"""Units of length, as WINDOW's files name them [m]."""
FORMATS = ("rad", "mgf", "obj", "ply", "stl", "rtm", "oct", "xml")
"""Endings of the files that :meth:`Device.read` tells apart."""


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
    def read(
        cls,
        *paths: str | os.PathLike[str],
        unit: str = "meter",
        up: str = "y",
        format: Format | None = None,
        materials: Materials = (),
        material_names: Mapping[str, str] | None = None,
        default_material: str | None = None,
        allow_commands: Sequence[str] = (),
    ) -> Device:
        """Read files, in order, as one device.

        Parameters
        ----------
        *paths
            The files, told apart by their endings: ``.rad`` and what is not known, Radiance scenes; ``.mgf``; meshes
            as ``.obj``, ``.ply``, ``.stl`` and Radiance's ``.rtm``; frozen octrees ``.oct``; ``.xml``, the geometry in
            a BSDF file, which has its own unit.
        unit
            Unit of length in the files: meter, foot, inch, centimeter or millimeter.
        up
            The axis that points up in the drawing: x, -x, y, -y, z or -z; with z, the room is towards its -Y.
        format
            What all files are, whatever their endings: Radiance scenes or MGF.
        materials
            Radiance files of materials for meshes, read before everything else.
        material_names
            Modifiers of those files, by the names that materials have in meshes.
        default_material
            The modifier of what has no material, or one that is not defined.
        allow_commands
            Programs that ``!`` commands of scenes may run, by name, besides those that are understood (``xform``,
            ``genbox`` and so on) and never run. No shell is run.

        Raises
        ------
        ValueError
            If a file cannot be read or is not understood; the message names file and line and what to do.
        """
        reading = _reading(unit, materials, material_names, default_material, allow_commands)
        kind = format or _one_kind([(format_of(path), os.fspath(path)) for path in paths])
        device = cls(_core.Device._read(kind, [os.fspath(path) for path in paths], reading))
        return device if up.lower().lstrip("+") == "y" else device.turned_up(up)

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        directory: str | os.PathLike[str] = ".",
        unit: str = "meter",
        format: Literal["rad", "mgf"] = "rad",
        materials: Materials = (),
        allow_commands: Sequence[str] = (),
    ) -> Device:
        """Read a Radiance or MGF scene from a string; files that it names are looked for in ``directory``.

        See :meth:`read` for the parameters.
        """
        reading = _reading(unit, materials, None, None, allow_commands)
        return cls(_core.Device._parse(format, text, os.fspath(directory), reading))

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

    def with_materials(
        self, *paths: str | os.PathLike[str], unit: str = "meter", allow_commands: Sequence[str] = ()
    ) -> Device:
        """The same device of the materials that Radiance files define under the names of its own.

        Such as what its surfaces are in another band of light. Surfaces in the files do not count.

        Raises
        ------
        ValueError
            As :meth:`read`, and if the files define none of the device's materials.
        """
        reading = _reading(unit, (), None, None, allow_commands)
        return Device(self._core._with_materials([os.fspath(path) for path in paths], reading))

    def turned_up(self, up: str) -> Device:
        """Turn a drawing whose ``up`` (x, -x, y, -y, z, -z) is not Y; with Z up, the room is towards its -Y."""
        return Device(self._core._turned_up(up))

    def to_rad(self) -> str:
        """Return the device as a Radiance scene in metres."""
        return self._core.to_rad()

    def to_mgf(self, unit: str = "meter") -> tuple[str, list[str]]:
        """Return the device as MGF, and sentences on what MGF cannot say of it.

        Parameters
        ----------
        unit
            Unit of its lengths: meter, foot, inch, centimeter or millimeter.
        """
        return self._core.to_mgf(unit)

    def __repr__(self) -> str:
        return repr(self._core)


def _reading(
    unit: str,
    materials: Materials,
    material_names: Mapping[str, str] | None,
    default_material: str | None,
    allow_commands: Sequence[str],
) -> dict[str, object]:
    """Return how files are read, as the extension takes it."""
    several = [materials] if isinstance(materials, (str, os.PathLike)) else materials
    return {
        "unit": unit,
        "search": search_folders(),
        "allow_commands": list(allow_commands),
        "materials": [os.fspath(path) for path in several],
        "material_names": dict(material_names or {}),
        "default_material": default_material,
    }


def search_folders() -> list[str]:
    """Return where function files and others are looked for: as Radiance does, and last in pyradiance's library."""
    folders = os.environ.get("RAYPATH", os.pathsep.join([".", "/usr/local/lib/ray"])).split(os.pathsep)
    radiance = find_folder()
    return [*folders, *([os.fspath(radiance / "lib")] if radiance is not None else [])]


def _one_kind(kinds: Sequence[tuple[str, str]]) -> str:
    """Return the kind that all files have: scenes and meshes are one, in their order."""
    several = [(kind if kind in ("mgf", "xml") else "scene", path) for kind, path in kinds]
    first = several[0] if several else ("scene", "")
    for kind, path in several:
        if kind != first[0]:
            raise ValueError(f"{path} is {kind}, {first[1]} is {first[0]}; MGF and BSDF files stand alone")
    return first[0]


def family_of(device: str | os.PathLike[str]) -> str | None:
    """Return the spec of a parametric device, or None if it is a path."""
    text = os.fspath(device)
    is_family = text.partition(":")[0] in {f.name for f in device_families()}
    return text if is_family and not os.path.exists(text) else None


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the kind of file that a name says: ``rad``, a Radiance scene, if nothing known; ``xml`` for any BSDF."""
    ending = os.path.splitext(os.fspath(path))[1].lower().lstrip(".").replace("bsdft", "xml")
    return ending if ending in FORMATS else "rad"


def as_device(
    device: Device | str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    unit: str,
    allow_commands: Sequence[str] = (),
) -> Device:
    """Return a device from what people pass: a Device, a path, paths, or the spec of a parametric device."""
    if isinstance(device, Device):
        return device
    if isinstance(device, (str, os.PathLike)):
        family = family_of(device)
        if family is not None:
            return Device.from_spec(family)
        device = [device]
    return Device.read(*device, unit=unit, allow_commands=allow_commands)
