"""A small picture of all components, for lists and notebooks."""

from __future__ import annotations

from matplotlib.figure import Figure

from bsdftree import Bsdf
from bsdftree.plot._image import tiles_of
from bsdftree.plot._parts import SIDES, band_of, parts_of
from bsdftree.plot._style import INK, Scale, bare, figure

_EDGE = 180


def thumbnail(bsdf: Bsdf, *, band: str | None = None) -> Figure:
    """Draw the mosaics of all components side by side, small: see :func:`bsdftree.plot.mosaic` for how to read them.

    Raises
    ------
    ValueError
        If there is no such band.
    """
    band = band_of(bsdf, band)
    parts = parts_of(bsdf, None, band) if bsdf.bands else []
    tiles = [tiles_of(bsdf, part, band, 3, 256) for part in parts]
    scale = Scale.of([t.pixels for t in tiles])
    width, height = 10 + max(len(parts), 1) * (_EDGE + 10) + 96, _EDGE + 36
    picture = figure(width, height)
    for k, (part, mosaic) in enumerate(zip(parts, tiles, strict=True)):
        x = 10 + k * (_EDGE + 10)
        axes = picture.add_axes((x / width, 8 / height, _EDGE / width, _EDGE / height))
        scale.draw(axes, mosaic.pixels, (0, mosaic.columns, 0, mosaic.rows))
        axes.set_anchor("N")
        bare(axes)
        kind = SIDES[part].kind
        text = f"{kind}: {SIDES[part]}"
        picture.text(x / width, 1 - 13 / height, text, fontsize=8, va="center", color=INK)
    scale.bar(picture, ((width - 68) / width, 8 / height, 12 / width, (_EDGE - 16) / height))
    return picture
