"""What a file says of a BSDF, beside its values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bsdftree import _core

if TYPE_CHECKING:
    from typing_extensions import Self


class Described:
    """A BSDF of the library, and its header."""

    def __init__(self, core: _core.Bsdf) -> None:
        self._core = core
        header = core.header
        self.name: str = header["name"]
        self.manufacturer: str = header["manufacturer"]
        self.width: float | None = header["width"]
        self.height: float | None = header["height"]
        self.thickness: float | None = header["thickness"]
        self.unit: str = header["unit"]
        self.geometry: str | None = header["geometry"]
        self.provenance: list[str] = header["provenance"]
        self.properties: dict[str, str] = dict(header["properties"])
        self.repairs: list[str] = core.repairs
        self.bands: list[str] = core.bands

    def with_header(
        self,
        *,
        name: str | None = None,
        manufacturer: str | None = None,
        unit: str | None = None,
        provenance: list[str] | None = None,
        size: tuple[float | None, float | None, float | None] | None = None,
        geometry: tuple[str, str] | None = None,
        properties: Mapping[str, str] | None = None,
    ) -> Self:
        """Return a copy with some of the header replaced.

        Parameters
        ----------
        name, manufacturer
            Of the product.
        unit
            Of lengths in the file: meter, foot, inch, centimeter or millimeter.
        provenance
            Comments at the head of the file.
        size
            Width, height and thickness [m].
        geometry
            MGF text, none if empty, and its unit of length.
        properties
            What else the file says of the material, by element, such as ``ThermalConductivity``.

        Raises
        ------
        ValueError
            If there is no such unit, or a file can hold no such property.
        """
        others = None if properties is None else list(properties.items())
        return type(self)(self._core.with_header(name, manufacturer, unit, provenance, size, geometry, others))
