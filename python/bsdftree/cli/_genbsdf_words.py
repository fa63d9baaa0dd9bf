"""The words of Radiance's genBSDF.

In: the words of a command line. Out: what is asked for, or what is wrong. Source: the manual page genBSDF(1), and how
the program takes its words: options come before files, signs matter (``+f``, ``-f``), names may be cut short to one
letter (``+forward``, ``+f``), and the last of several counts. Options that begin with ``--`` are ours.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field

UNITS = ("meter", "foot", "inch", "centimeter", "millimeter")
SHORTHAND = {
    "m": "Manufacturer",
    "n": "Name",
    "d": "DeviceType",
    "c": "ThermalConductivity",
    "ef": "EmissivityFront",
    "eb": "EmissivityBack",
    "eo": "EffectiveOpennessFraction",
    "t": "Thickness",
    "h": "Height",
    "w": "Width",
}
"""Of wrapBSDF(1)."""
USAGE = (
    "Usage: bsdftree genbsdf [-n Nproc][-c Nsamp][-W][-t{3|4} Nlog2][-t percent][-r 'ropts'][-s 'x=string;y=string']"
    "[-dim xmin xmax ymin ymax zmin zmax][{+|-}C][{+|-}a][{+|-}f][{+|-}b][{+|-}mgf][{+|-}geom unit] [input ..]\n"
    "   or: bsdftree genbsdf -recover tempdir"
)


class UsageError(ValueError):
    """Words that are not understood."""


@dataclass
class Request:
    """What a command line of genBSDF asks for; defaults are genBSDF's.

    Attributes
    ----------
    samples
        Per incident patch or cell.
    processes
        At most as many at once.
    rank, log2_res
        0 for Klems' full basis; else of the tree.
    cull_percent
        How much of a tree is culled; negative for nothing.
    forward, backward
        Whether light comes from outside, from the room.
    color, average
        Whether colour is kept, whether pairs are averaged with swapped pairs.
    mgf, geometry
        Whether the input is MGF, whether the file is to hold the geometry.
    unit
        Of lengths.
    dim
        xmin, xmax, ymin, ymax, zmin, zmax of the device's box.
    window
        Whether the file is for WINDOW.
    fields
        Elements of the file's material, as text.
    rcontrib
        Options for rcontrib.
    files
        Input; standard input if there is none.
    engine, seed, checkpoint, materials, allow_commands
        Options that genBSDF does not have.
    recover
        The directory of a run that was interrupted.
    """

    samples: int = 2000
    processes: int = 1
    rank: int = 0
    log2_res: int = 4
    cull_percent: float = 90.0
    forward: bool = False
    backward: bool = True
    color: bool = False
    average: bool = True
    mgf: bool = False
    geometry: bool = True
    unit: str = "meter"
    dim: tuple[float, ...] | None = None
    window: bool = False
    fields: dict[str, str] = field(default_factory=dict)
    rcontrib: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    engine: str = "bsdftree"
    seed: int = 0
    checkpoint: str | None = None
    materials: str | None = None
    allow_commands: list[str] = field(default_factory=list)
    recover: str | None = None


def request(words: Sequence[str]) -> Request:
    """Understand a command line.

    Raises
    ------
    UsageError
        If a word is not understood, or nothing is asked for.
    """
    if len(words) == 2 and words[0].startswith("-rec"):
        return Request(recover=words[1])
    asked = Request()
    left = _Words(words)
    while left.words and _is_option(left.words[0]):
        _take(asked, left.next("an option"), left)
    asked.files = left.words
    if not asked.forward and not asked.backward:
        raise UsageError("Must have at least one of +forward or +backward")
    return asked


class _Words:
    """Words still to be understood."""

    def __init__(self, words: Sequence[str]) -> None:
        self.words = list(words)

    def next(self, after: str) -> str:
        if not self.words:
            raise UsageError(f"{after} is followed by nothing")
        return self.words.pop(0)

    def integer(self, option: str, least: int = 1) -> int:
        word = self.next(option)
        try:
            number = int(word)
        except ValueError:
            number = least - 1
        if number < least:
            raise UsageError(f"{option} {word}: expected an integer of at least {least}")
        return number

    def number(self, option: str) -> float:
        word = self.next(option)
        try:
            number = float(word)
        except ValueError:
            number = float("nan")
        if not abs(number) < float("inf"):
            raise UsageError(f"{option} {word}: expected a number")
        return number


def _is_option(word: str) -> bool:
    return len(word) > 1 and word[0] in "-+"


def _take(asked: Request, option: str, left: _Words) -> None:
    """Understand one option and the words that belong to it."""
    if option.startswith("--"):
        _take_own(asked, option, left)
        return
    on, name = option[0] == "+", option[1:]
    exact = {
        "-r": lambda: asked.rcontrib.extend(_split(left.next(option), option)),
        "-s": lambda: asked.fields.update(_fields(left.next(option))),
        "-W": lambda: setattr(asked, "window", True),
        "-c": lambda: setattr(asked, "samples", left.integer(option)),
        "-n": lambda: setattr(asked, "processes", left.integer(option)),
        "-t": lambda: setattr(asked, "cull_percent", _percent(left.number(option))),
    }
    if option in exact:
        exact[option]()
    elif option in ("-t3", "-t4"):
        asked.rank, asked.log2_res = int(option[2]), left.integer(option)
    elif option == "-f" and left.words and "=" in left.words[0]:
        # What -s is today was -f until 2015.
        asked.fields.update(_fields(left.next(option)))
    elif name[0] == "g":
        asked.geometry, asked.unit = on, _unit(left.next(option))
    elif name[0] == "d" and not on:
        asked.dim = tuple(left.number(option) for _ in range(6))
    elif name[0] in "mCafb":
        setattr(asked, _SIGNED[name[0]], on)
    else:
        raise UsageError(f"genBSDF has no option {option}\n{USAGE}")


_SIGNED = {"m": "mgf", "C": "color", "a": "average", "f": "forward", "b": "backward"}


def _take_own(asked: Request, option: str, left: _Words) -> None:
    name, is_joined, value = option.partition("=")
    if is_joined:
        left.words.insert(0, value)
    if name == "--engine":
        asked.engine = left.next(name)
        if asked.engine not in ("bsdftree", "radiance"):
            raise UsageError(f"--engine {asked.engine}: expected bsdftree or radiance")
    elif name == "--seed":
        asked.seed = left.integer(name, 0)
    elif name in ("--checkpoint", "--materials"):
        setattr(asked, name[2:], left.next(name))
    elif name == "--allow-command":
        asked.allow_commands.append(left.next(name))
    else:
        raise UsageError(f"there is no option {option}\n{USAGE}")


def _split(text: str, option: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError as error:
        raise UsageError(f"{option} {text!r}: {error}") from None


def _percent(number: float) -> float:
    if number >= 100:
        raise UsageError("Illegal -t culling percentage, must be < 100")
    return number


def _unit(word: str) -> str:
    if word.lower() not in UNITS:
        expected = "meter, foot, inch, centimeter, or millimeter"
        raise UsageError(f"Illegal geometry unit '{word}': must be {expected}")
    return word.lower()


def _fields(text: str) -> dict[str, str]:
    """Understand ``m=ACME;Name=Blinds``."""
    fields = {}
    for assignment in filter(None, (piece.strip() for piece in text.split(";"))):
        name, is_assigned, value = assignment.partition("=")
        name = name.strip()
        if not is_assigned or not name:
            raise UsageError(f"bad tag name in assignment '{assignment}'; expected name=text")
        fields[SHORTHAND.get(name, name)] = value.strip().strip("\"'")
    return fields
