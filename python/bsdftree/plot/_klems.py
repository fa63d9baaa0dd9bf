"""The matrix view: incident patch to the right, exitant patch downwards, as WINDOW's files have them."""

from __future__ import annotations

from matplotlib.figure import Figure

from bsdftree import Bsdf, Tree
from bsdftree.plot._mosaic import draw_panels, panel_of
from bsdftree.plot._parts import band_of, heading_of, parts_of

_EDGE = 1024


def klems(
    bsdf: Bsdf,
    *,
    part: str | None = None,
    band: str | None = None,
    basis: str | None = None,
    limits: tuple[float, float] | None = None,
    colors: str = "viridis",
    title: str | None = None,
) -> Figure:
    """Draw Klems matrices [1/sr], trees as the matrices that they become by exact overlap.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    part
        One component; all that there are by default.
    band
        Spectral band; ``Visible`` or the only one by default.
    basis
        Angle basis as of :meth:`bsdftree.Bsdf.to_klems`; by default the file's, for trees ``"full"`` (145).
    limits, colors, title
        As of :func:`bsdftree.plot.mosaic`.

    Raises
    ------
    ValueError
        If there is no such part, band or basis.
    """
    band = band_of(bsdf, band)
    parts = parts_of(bsdf, part, band)
    if len(bsdf.bands) > 1:
        bsdf = bsdf.select(bands=[band])
    if basis is not None or any(isinstance(c, Tree) for c in bsdf.components_of(band).values()):
        bsdf = bsdf.to_klems(basis or "full")
    panels = [panel_of(bsdf, p, band, layout="matrix", max_px=_EDGE) for p in parts]
    return draw_panels(panels, heading_of(bsdf, band, title), limits, colors)
