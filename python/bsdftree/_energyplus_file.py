"""Objects of EnergyPlus in a file: as epJSON, or as text for an IDF.

In go objects as epJSON has them, with fields in the order of EnergyPlus's IDD: an IDF knows fields by their order.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from bsdftree._whole_file import write_whole

Objects = dict[str, dict[str, dict[str, Any]]]
"""Type of object, name, fields."""


def save_energyplus(path: str | os.PathLike[str], objects: Objects) -> None:
    """Write what :func:`energyplus` made: an IDF if the path ends in .idf, else epJSON.

    Parameters
    ----------
    path
        The file; it is replaced when it is complete.
    objects
        What :func:`energyplus` returned.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    target = Path(path)
    text = idf_text(objects) if target.suffix.lower() == ".idf" else json.dumps(objects, indent=1) + "\n"
    write_whole(target, text.encode())


def idf_text(objects: Objects) -> str:
    """Return the objects as text for an IDF."""
    # An IDF knows fields by their order; that of ours is EnergyPlus's, but for the optical fields a layer leaves empty.
    return "".join(_idf_object(kind, name, fields) for kind, all_ in objects.items() for name, fields in all_.items())


def _idf_object(kind: str, name: str, fields: Mapping[str, Any]) -> str:
    return ",\n  ".join([kind, name, *_idf_fields(kind, fields)]) + ";\n\n"


def _idf_fields(kind: str, fields: Mapping[str, Any]) -> Iterator[str]:
    for key, value in fields.items():
        if key == "values":
            # Short lines: earlier versions read 500 characters.
            numbers = [repr(each["value"]) for each in value]
            yield from (", ".join(numbers[i : i + 10]) for i in range(0, len(numbers), 10))
        elif kind == "Construction:ComplexFenestrationState" and key.startswith("gap_"):
            # What the gas absorbs, "reserved for future use".
            yield from [value, "", ""]
        elif kind == "WindowMaterial:Glazing" and key == "thickness":
            # Transmittances and reflectances of a layer that has none but its construction's.
            yield from ["", repr(value), *[""] * 6]
        else:
            yield value if isinstance(value, str) else repr(value)
