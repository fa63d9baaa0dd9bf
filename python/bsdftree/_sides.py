"""Which sides of the surface each component joins."""

from __future__ import annotations

from typing import NamedTuple

from bsdftree._queries import Part

ROOM, OUTSIDE = 1.0, -1.0


class Sides(NamedTuple):
    """Sign of z of the incident and of the exitant direction of a component."""

    incident: float
    exitant: float

    @property
    def kind(self) -> Part:
        """``"reflection"`` or ``"transmission"``."""
        return "reflection" if self.incident == self.exitant else "transmission"

    def __str__(self) -> str:
        name = {ROOM: "room", OUTSIDE: "outside"}
        return f"{name[self.incident]} → {name[self.exitant]}"


# WINDOW's names, in which the front is outside.
SIDES = {
    "reflection_back": Sides(ROOM, ROOM),
    "transmission_back": Sides(ROOM, OUTSIDE),
    "reflection_front": Sides(OUTSIDE, OUTSIDE),
    "transmission_front": Sides(OUTSIDE, ROOM),
}
