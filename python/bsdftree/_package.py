"""A BSDF file as Radiance objects to put into a scene: a rectangle of it, with the geometry that the file holds.

In goes a BSDF file. Out come, in one folder, NAME.rad in metres, the XML that it names, and on request NAME.oct. The
rectangle has the width and height of the file, its middle on the Z axis, and faces +Z, the room; the device lies in
z ≤ 0, up is +Y.

* **With geometry** the rectangle stands for it (a *proxy*): rays of view and shadow go on to the geometry, others take
  the BSDF and leave beyond its thickness. A second rectangle behind the geometry is for light from the outside, if the
  file has its reflection.
* **Without** it is the device itself, of thickness 0; and where the file has a peak straight through, it is an
  ``aBSDF``, in which Radiance keeps that light sharp.

Source: Radiance's manual pages of pkgBSDF and of the materials BSDF and aBSDF. Deviations: pkgBSDF knows no aBSDF and
refuses files without width and height, of which a square of 1 m is made here; it reads geometry by ``mgf2rad``, we by
our own reader.
"""

from __future__ import annotations

import os
import re
import warnings
from pathlib import Path

from bsdftree._bsdf import Bsdf, load
from bsdftree._device import Device
from bsdftree._radiance.programs import run
from bsdftree._whole_file import write_whole

# Between the rectangles and the geometry: more than Radiance's smallest distance of a hit, 10⁻⁶.
_LEAST_MARGIN, _MARGIN = 1e-5, 1e-4


def package(
    path: str | os.PathLike[str],
    directory: str | os.PathLike[str] = ".",
    *,
    size: tuple[float, float] | None = None,
    through: bool | None = None,
    instance: bool = False,
    strict: bool = True,
) -> Path:
    """Write a BSDF file as Radiance objects, to be put into a scene by ``!xform NAME.rad``.

    Radiance looks for the XML, and for the octree, where it runs and in RAYPATH: run it in the directory.

    Parameters
    ----------
    path
        The BSDF file. If it is not in the directory, or is a ``.bsdft``, its XML is written there.
    directory
        Where to write; it is made if it is not there.
    size
        Width and height of the rectangle [m], instead of the file's.
    through
        Whether light straight through stays sharp (``aBSDF``); by default, if the file has no geometry and a peak
        straight through.
    instance
        Write the geometry as a frozen octree, which takes less memory where there are many. Needs the extra
        ``radiance``.
    strict
        As in :func:`load`.

    Returns
    -------
    Path
        The scene file.

    Raises
    ------
    ValueError
        If the file or its geometry is not understood, ``through`` is asked of a file with geometry, or another XML of
        that name is in the directory.
    OSError
        If something cannot be written.

    Warns
    -----
    UserWarning
        If the file does not say how large it is, or its geometry reaches into the room.
    """
    source, folder = Path(path), Path(directory)
    bsdf = load(source, strict=strict)
    bsdf.verify()
    device = Device.read(source) if bsdf.geometry else None
    if device is not None and through:
        raise ValueError(f"{source}: it has geometry, which is seen through itself; an aBSDF stands for none")
    # What Radiance takes for a word that needs no quotes.
    name = re.sub(r"[^\w.-]+", "_", source.stem, flags=re.ASCII)
    xml, octree = (folder / f"{name}.{ending}" for ending in ("xml", "oct"))
    width, height = _size(source, bsdf, size)
    scene = [f"# {_line(bsdf.name)} by {_line(bsdf.manufacturer)}, packaged by bsdftree from {_line(source.name)}"]
    if device is None:
        if through is None:
            through = has_peak_through(bsdf)
        material = f"aBSDF m_{name}\n5 {xml.name}" if through else f"BSDF m_{name}\n6 0 {xml.name}"
        scene += [f"void {material} 0 1 0 .\n0\n0", _rectangle(name, width, height, 0.0)]
    else:
        scene += _proxies(bsdf, device, name, xml.name, width, height)
    folder.mkdir(parents=True, exist_ok=True)
    _put_xml(source, bsdf, xml)
    if device is not None:
        geometry = device.to_rad()
        if instance:
            write_whole(octree, run("oconv", "-f", "-", stdin=geometry.encode()))
            geometry = f"void instance {name}_geometry\n1 {octree.name}\n0\n0\n"
        scene.append(geometry)
    made = folder / f"{name}.rad"
    write_whole(made, ("\n\n".join(scene) + "\n").encode())
    return made


def has_peak_through(bsdf: Bsdf) -> bool:
    """Whether a transmission has a specular peak straight through."""
    return any(f.kind == "straight" and f.component.startswith("transmission") for f in bsdf.peaks())


def _proxies(bsdf: Bsdf, device: Device, name: str, xml: str, width: float, height: float) -> list[str]:
    """Return one rectangle before the geometry, and one behind it if there is light to be reflected from there."""
    assert device.bounds is not None
    least, most = (corner[2] for corner in device.bounds)
    # What is drawn behind the thickness of the file, as a frame may be, is not of the BSDF.
    depth = bsdf.thickness or max(0.0, -least)
    margin = max(_LEAST_MARGIN, _MARGIN * depth)
    if most > margin:
        warnings.warn(f"{name}: its geometry reaches {most:.4g} m into the room, through its rectangle", stacklevel=3)
    # From one rectangle to a little beyond where the other is, or would be.
    thickness = depth + 3 * margin
    made = [
        f"void BSDF m_{name}_front\n6 {thickness:.9g} {xml} 0 1 0 .\n0\n0",
        _rectangle(f"{name}_front", width, height, margin),
    ]
    if "reflection_front" in bsdf.components:
        made += [
            f"void BSDF m_{name}_back\n6 {-thickness:.9g} {xml} 0 1 0 .\n0\n0",
            _rectangle(f"{name}_back", width, height, -depth - margin),
        ]
    return made


def _rectangle(name: str, width: float, height: float, z: float) -> str:
    x, y = width / 2, height / 2
    corners = "\n".join(f"\t{a:.9g} {b:.9g} {z:.9g}" for a, b in ((-x, -y), (x, -y), (x, y), (-x, y)))
    return f"m_{name} polygon {name}\n0\n0\n12\n{corners}"


def _size(source: Path, bsdf: Bsdf, size: tuple[float, float] | None) -> tuple[float, float]:
    if size is not None:
        width, height = size
        if not (0 < width < float("inf") and 0 < height < float("inf")):
            raise ValueError(f"size {width} {height}; expected a width and a height above 0 [m]")
        return width, height
    if bsdf.width and bsdf.height:
        return bsdf.width, bsdf.height
    warnings.warn(f"{source}: does not say how wide and high it is: taken as 1 m by 1 m; give a size", stacklevel=3)
    return 1.0, 1.0


def _put_xml(source: Path, bsdf: Bsdf, xml: Path) -> None:
    """Have the file's XML where the scene names it."""
    if xml.exists() and source.exists() and xml.samefile(source):
        return
    is_binary = source.suffix.lower() == ".bsdft"
    content = bsdf.to_xml().encode() if is_binary or bsdf.repairs else source.read_bytes()
    if xml.exists() and xml.read_bytes() != content:
        raise ValueError(f"{xml}: another file of that name is there; give another directory")
    write_whole(xml, content)


def _line(text: str) -> str:
    """Return a text that stays in its comment."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split()) or "unnamed"
