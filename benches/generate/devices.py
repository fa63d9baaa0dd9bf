"""The devices that are measured, as Radiance scene files, so that every program reads the same text.

All repeat along Y, extend along X, and are their own mirror images in the plane x = 0 (references make use of it).
They are finite: what leaves by an edge is lost or gained by genBSDF and by us alike. Those that repeat for ever are
not for genBSDF, which has no such thing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bsdftree import Device

SAWTOOTH_MIRROR = ("void mirror mirror", "3 0.8 0.8 0.8")
SLAT = ("void plastic slat", "5 0.7 0.7 0.7 0.0 0.0")
BLINDS = "blinds:angle=30"


@dataclass(frozen=True)
class Scene:
    """A name for tables, and the text of a scene file."""

    name: str
    text: str
    period: tuple[float, ...] = ()
    """The box that repeats for ever, as `dim` has it; none if the device is alone."""

    @property
    def options(self) -> dict[str, Any]:
        """What `generate()` has to be told of it."""
        return {"tile": True, "dim": self.period} if self.period else {}

    def write(self, folder: Path) -> Path:
        path = folder / f"{self.name.replace(' ', '-')}.rad"
        path.write_text(self.text)
        return path


def scene(name: str, spec: str, *changed: tuple[tuple[str, str], tuple[str, str]]) -> Scene:
    """A parametric device, of which materials are changed: type and name, and numbers, from and to."""
    text = Device.from_spec(spec).to_rad()
    for (old_head, old_numbers), (head, numbers) in changed:
        before = f"{old_head}\n0\n0\n{old_numbers}"
        if before not in text:
            raise ValueError(f"{name}: {spec} has no material {before!r}; it was to be changed")
        text = text.replace(before, f"{head}\n0\n0\n{numbers}")
    return Scene(name, text)


def periodic(scene: Scene, spec: str) -> Scene:
    """The same for ever, with the period of the parametric device that it is made from."""
    tile = Device.from_spec(spec).tile
    if tile is None:
        raise ValueError(f"{spec} does not repeat")
    low, high = tile
    period = tuple(float(x) for pair in zip(low, high, strict=True) for x in pair)
    return replace(scene, name=f"endless {scene.name}", period=period)


SAWTOOTH = scene("sawtooth", "sawtooth")
GLOSSY = scene("glossy sawtooth", "sawtooth", (SAWTOOTH_MIRROR, ("void metal mirror", "5 0.8 0.8 0.8 1.0 0.1")))
V_GROOVE = scene("diffuse V-groove", "sawtooth", (SAWTOOTH_MIRROR, ("void plastic mirror", "5 0.5 0.5 0.5 0.0 0.0")))
DIFFUSE_BLINDS = scene("blinds", BLINDS)
GLAZED_BLINDS = scene("blinds and glazing", f"{BLINDS},glazing=0.8")
METAL_BLINDS = scene("metal blinds", BLINDS, (SLAT, ("void metal slat", "5 0.8 0.8 0.8 0.9 0.0")))

ENDLESS = (periodic(SAWTOOTH, "sawtooth"), periodic(GLOSSY, "sawtooth"), periodic(DIFFUSE_BLINDS, BLINDS))

EQUAL_ERROR = (SAWTOOTH, GLOSSY, V_GROOVE, DIFFUSE_BLINDS, GLAZED_BLINDS)
RESOLUTION = (SAWTOOTH, METAL_BLINDS)
