"""Pictures of a BSDF: the whole of it at once, polar slices, one hemisphere, and an overview of all.

Every function takes a :class:`bsdftree.Bsdf` and returns a matplotlib Figure that belongs to no window and no pyplot
state; notebooks show it, :func:`save` writes it. Colours and radii are BSDF values [1/sr] without cosine unless said
otherwise. Everything is drawn as seen from the room: X to the right, Y up.

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

from bsdftree.plot._fit import fit
from bsdftree.plot._hemisphere import hemisphere
from bsdftree.plot._image import whole_image
from bsdftree.plot._measurement import measurement
from bsdftree.plot._overview import overview
from bsdftree.plot._polar import polar
from bsdftree.plot._style import save
from bsdftree.plot._whole import whole

__all__ = ["fit", "hemisphere", "measurement", "overview", "polar", "save", "whole", "whole_image"]
