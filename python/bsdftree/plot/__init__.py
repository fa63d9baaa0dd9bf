"""Pictures of a BSDF: all of it at once, polar maps, lobes, slices, totals, matrices, statistics, comparisons.

Every function takes a :class:`bsdftree.Bsdf` (:func:`compare` takes two) and returns a matplotlib Figure that belongs
to no window and no pyplot state; notebooks show it, :func:`save` writes it. Colours and radii are BSDF values [1/sr]
without cosine unless said otherwise. Everything is drawn as seen from the room: X to the right, Y up.

>>> from bsdftree import Bsdf, Tree, plot
>>> white = Bsdf.from_trees({"reflection_back": Tree.from_grid([[[[0.25]]]])})
>>> figure = plot.overview(white, title="white paint")
"""

try:
    import matplotlib as _matplotlib  # noqa: F401
except ModuleNotFoundError as _missing:
    raise ModuleNotFoundError(
        "pictures need matplotlib, which is not installed; install it with: pip install 'bsdftree[plot]'",
        name="matplotlib",
    ) from _missing

from bsdftree.plot._compare import compare
from bsdftree.plot._fit import fit
from bsdftree.plot._hemispherical import hemispherical
from bsdftree.plot._image import mosaic_image
from bsdftree.plot._klems import klems
from bsdftree.plot._lobes import lobes
from bsdftree.plot._measurement import measurement
from bsdftree.plot._mosaic import mosaic
from bsdftree.plot._overview import overview
from bsdftree.plot._polar import polar
from bsdftree.plot._slice import slice
from bsdftree.plot._stats import stats
from bsdftree.plot._style import save
from bsdftree.plot._thumbnail import thumbnail

__all__ = [
    "compare",
    "fit",
    "hemispherical",
    "klems",
    "lobes",
    "measurement",
    "mosaic",
    "mosaic_image",
    "overview",
    "polar",
    "save",
    "slice",
    "stats",
    "thumbnail",
]
