"""Draw the pictures of docs/gallery.md and write the page: ``python docs/gallery.py``.

Enters nothing but seeds, leave docs/img/gallery-*.png, each under 150 KB, and the page with the
commands that draw them. What the page prints is what is run here, in a temporary folder. Pillow
packs the pictures, and is there with matplotlib, which needs it.
"""

from __future__ import annotations

import io
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
MOST_BYTES = 150_000
MADE = (
    "bsdftree generate --device blinds:angle=30 --tile --log2-res 4 --samples 1000 --seed 1 -o blinds.xml",
    "bsdftree reduce blinds.xml -o small.xml --l1 20",
    "bsdftree generate --device prism --tile --log2-res 5 --samples 500 --seed 1 -o prism.xml",
    "bsdftree generate --device blinds:angle=30 --tile --rank 3 --log2-res 5 --samples 2000 --seed 1 -o rank3.xml",
    "bsdftree convert blinds.xml klems.xml --klems full",
)
# Heading, words, command; -o is added, and --dpi so that files are small.
PICTURES = (
    ("overview", "The default: the whole BSDF, slices, totals; here isotropic.", "bsdftree plot rank3.xml", 58),
    ("polar", "Polar maps: where light from some directions goes.", "bsdftree plot blinds.xml --kind polar", 60),
    ("one", "One incident direction, large.", "bsdftree plot prism.xml --kind polar --incident 135 90", 60),
    ("lobes", "The same as solids.", "bsdftree plot prism.xml --kind lobes --incident 180 0 --incident 150 90", 80),
    ("slice", "Curves in the plane of incidence.", "bsdftree plot prism.xml --kind slice --incident 150 90", 65),
    (
        "mosaic",
        "The whole BSDF: a tile for each incident direction, in it all exitant ones.",
        "bsdftree plot blinds.xml --kind mosaic --part transmission_front",
        65,
    ),
    (
        "hemispherical",
        "Reflectance and transmittance by incident angle.",
        "bsdftree plot blinds.xml --kind hemispherical",
        70,
    ),
    (
        "compare",
        "Two files: maps, difference, ratio, errors. Here a tree and itself, reduced to a fifth of error.",
        "bsdftree plot blinds.xml small.xml --incident 150 90",
        65,
    ),
    (
        "klems",
        "The matrix of Klems patches; of trees, what they become.",
        "bsdftree plot klems.xml --kind klems --part transmission_front",
        60,
    ),
    (
        "stats",
        "Leaves by depth, their share of directions and of light, values.",
        "bsdftree plot blinds.xml --kind stats",
        65,
    ),
)
HEAD = """\
# Gallery
What `bsdftree plot` draws; in Python, functions of the same names in `bsdftree.plot`. PNG,
SVG or PDF by the ending of `-o`. All is seen from the room, X to the right and Y up; values are [1/sr] without
cosine on a logarithmic scale, on which zero has a colour of its own; colours are those that the colour-blind tell
apart. This page is made by `python docs/gallery.py`, of:

```console
"""
FOOT = """
## In notebooks
A `Bsdf` at the end of a cell is shown as a table of its components and a small picture of all of them (the table alone
without matplotlib); figures of `bsdftree.plot` show themselves.
"""


def run(command: str, folder: str) -> None:
    """Run a command of ours in a folder."""
    _, *arguments = shlex.split(command)
    subprocess.run([sys.executable, "-m", "bsdftree", *arguments], cwd=folder, check=True, capture_output=True)


def small(path: Path) -> bytes:
    """The same pixels without transparency, packed as well as can be."""
    stream = io.BytesIO()
    with Image.open(path) as picture:
        picture.convert("RGB").save(stream, "png", optimize=True)
    return stream.getvalue()


def main() -> None:
    """Draw all and write the page."""
    page = [HEAD + "".join(f"$ {command}\n" for command in MADE) + "```\n"]
    with tempfile.TemporaryDirectory() as folder:
        for command in MADE:
            run(command, folder)
        for name, words, command, dpi in PICTURES:
            full = f"{command} -o {name}.png --dpi {dpi}"
            run(full, folder)
            content = small(Path(folder) / f"{name}.png")
            print(f"{name}: {len(content):,} bytes")
            if len(content) > MOST_BYTES:
                raise SystemExit(f"{name}.png has {len(content):,} bytes, over {MOST_BYTES:,}: lower its dpi")
            (DOCS / "img" / f"gallery-{name}.png").write_bytes(content)
            page.append(f"\n{words}\n\n```console\n$ {full}\n```\n\n![{name}](img/gallery-{name}.png)\n")
    (DOCS / "gallery.md").write_text("".join(page) + FOOT, encoding="utf-8")


if __name__ == "__main__":
    main()
