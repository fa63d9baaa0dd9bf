"""The devices: scene files with a title, and what has to be made before they can be read.

In: a folder of `.rad` and `.mgf` files of ours, each with comments at its head: `Title`, `Features`, and where it
differs from the usual, `Oracle` (how Radiance is asked), `Jitter` (its -ss), `Colour: yes` (X, Y and Z are compared,
not Y alone) and `Known` (why Radiance differs). Out: a working folder with all that a device needs.
"""

from __future__ import annotations

import html
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np

import bsdftree

from .oracle import run

FOLDER = Path(__file__).parent / "scenes"
Oracle = Literal["rays", "sources", "rays and sources", "rays, reflection by sources"]
"""How Radiance is asked: see `oracle` and `run`."""


@dataclass(frozen=True)
class Published:
    """A Klems matrix that the authors of a device made of it, with so many rays for each incident patch."""

    path: Path
    rays: int


@dataclass(frozen=True)
class Scene:
    """A device: a file in a folder, with all that it names; `text` stands in its place."""

    name: str
    title: str
    features: tuple[str, ...]
    folder: Path
    oracle: Oracle = "rays"
    colour: bool = False
    known: str = ""
    jitter: float = 1.0
    text: str | None = None
    dim: tuple[float, ...] | None = None
    published: Published | None = None

    def prepare(self, work: Path) -> Path:
        """Copy the device and make what it needs; return its file."""
        for path in self.folder.iterdir():
            if path.is_file():
                shutil.copyfile(path, work / path.name)
        file = work / self.name
        if self.text is not None:
            file = work / "device.rad"
            file.write_text(self.text)
        text = file.read_text(errors="replace")
        for name, make in MADE.items():
            if name in text.split():
                make(work)
        return file


def head(text: str, key: str, default: str | None = None) -> str:
    """The value of `# key: value` among the comments."""
    found = re.search(rf"^# {key}: (.+)$", text, re.MULTILINE)
    if found is None and default is None:
        raise ValueError(f"a device has no comment '# {key}: …'")
    return found[1].strip() if found is not None else str(default)


def own() -> list[Scene]:
    """The devices of this folder, by name."""
    scenes = []
    for path in sorted([*FOLDER.glob("*.rad"), *FOLDER.glob("*.mgf")]):
        text = path.read_text()
        oracle = head(text, "Oracle", "rays")
        if oracle not in get_args(Oracle):
            raise ValueError(f"{path}: no such oracle: {oracle!r}")
        scenes.append(
            Scene(
                path.name,
                head(text, "Title"),
                tuple(head(text, "Features").split(", ")),
                FOLDER,
                oracle,  # type: ignore[arg-type]
                head(text, "Colour", "no") == "yes",
                head(text, "Known", ""),
                float(head(text, "Jitter", "1")),
            )
        )
    return scenes


def as_radiance(file: Path) -> Path:
    """What Radiance reads of a device: of MGF, also in a BSDF file, what mgf2rad makes of it."""
    if file.suffix == ".xml":
        block = re.search(r"<MGFblock[^>]*>(.*?)</MGFblock>", file.read_text(), re.DOTALL)
        if block is None:
            raise ValueError(f"{file} has no geometry")
        file = file.with_name(f"{file.stem}-geometry.mgf")
        file.write_text(html.unescape(block[1]))
    if file.suffix == ".mgf":
        scene = file.with_name(f"{file.stem}-by-mgf2rad.rad")
        scene.write_bytes(run("mgf2rad", file, folder=file.parent))
        return scene
    return file


def picture(work: Path) -> None:
    """Make `tiles.hdr`, 8 × 4 pixels, from numbers."""
    pixels = (work / "tiles.pixels").read_bytes()
    made = run("pvalue", "-r", "-h", "-H", "-d", "-y", 4, "+x", 8, folder=work, stdin=pixels)
    (work / "tiles.hdr").write_bytes(made)


def mesh(work: Path) -> None:
    """Make `dome.rtm` from an OBJ file, with its materials in it."""
    picture(work)
    run("obj2mesh", "-a", "dome.part", "dome.obj", "dome.rtm", folder=work)


def octree(work: Path) -> None:
    """Make `knobs.oct`, frozen, with its materials in it."""
    (work / "knobs.oct").write_bytes(run("oconv", "-f", "knobs.part", folder=work))


def pleats(work: Path) -> None:
    """Make `pleats.xml`, a tensor tree of rank 4 that varies little from cell to cell: Radiance blurs by one."""
    device = bsdftree.Device.read(work / "pleats.part")
    made = bsdftree.generate(device, log2_res=3, samples=20000, dim=(0, 1, 0, 1, -0.05, 0), tile=True, seed=11)
    made.save(work / "pleats.xml")


def klems(work: Path) -> None:
    """Make `klems.xml`, a Klems matrix."""
    made = bsdftree.generate("blinds:angle=30", klems="full", samples=2000, tile=True, seed=12)
    made.save(work / "klems.xml")


def pane(work: Path) -> None:
    """Make `pane.xml`, a Klems matrix of clear glass, of which most light goes straight through."""
    text = "void glass clear\n0\n0\n3 .9 .9 .9\nclear polygon sheet\n0\n0\n12 0 0 0 1 0 0 1 1 0 0 1 0\n"
    made = bsdftree.generate(bsdftree.Device.parse(text), klems="full", samples=2000, seed=13)
    made.save(work / "pane.xml")


def spectra(work: Path) -> None:
    """Make `plates.spc`, 3 × 3 pixels, each with a flank of its own in 20 parts from 780 to 380 nm."""
    head = "#?RADIANCE\nNCOMP=20\nWAVELENGTH_SPLITS= 780 588 480 380\nFORMAT=Radiance_spectra\n\n-Y 3 +X 3\n"
    place, flank = np.arange(9)[:, None], np.arange(20) / 20
    values = 0.3 + 0.6 / (1 + np.exp((flank - 0.1 - 0.09 * place) * np.where(place % 2 == 0, 20, -20)))
    mantissas = (values * 256).astype(np.uint8)
    exponents = np.full((9, 1), 128, np.uint8)
    (work / "plates.spc").write_bytes(head.encode() + np.hstack([mantissas, exponents]).tobytes())


MADE: dict[str, Callable[[Path], None]] = {
    "tiles.hdr": picture,
    "plates.spc": spectra,
    "dome.rtm": mesh,
    "knobs.oct": octree,
    "pleats.xml": pleats,
    "klems.xml": klems,
    "pane.xml": pane,
}
