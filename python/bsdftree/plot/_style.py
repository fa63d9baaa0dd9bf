"""What the pictures share: colours, scales, axes, a figure that notebooks show, files."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from bsdftree._whole_file import whole_file

Array = NDArray[np.float64]
ZERO = "#1c1c1c"
INK = "#333333"
FAINT = "#8a8a8a"
# M. Okabe and K. Ito's colours, which the colour-blind tell apart: blue, orange, green, vermilion.
OKABE_ITO = ("#0072B2", "#E69F00", "#009E73", "#D55E00")
VERMILION = OKABE_ITO[3]
ROOM_COLOR, OUTSIDE_COLOR = OKABE_ITO[0], VERMILION
# Blue below, white at none, red above.
DIVERGING = "RdBu_r"
FORMATS = ("png", "svg", "pdf")
_GREYS = LinearSegmentedColormap.from_list("lightness", [(0.22,) * 3, (1.0,) * 3])
# Linear sRGB (IEC 61966-2-1) of X, Y, Z, each row divided by its sum: the white of equal energy, which greys have in
# files, is that of the screen.
_SRGB_OF_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
_SRGB_OF_XYZ /= _SRGB_OF_XYZ.sum(axis=1, keepdims=True)
# Values fainter than this many decades below the brightest are drawn in the last colour.
_DECADES = 5


class Picture(Figure):
    """A figure outside of pyplot; notebooks show it by itself."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()


def figure(width_px: float, height_px: float, dpi: int = 100) -> Picture:
    """Make an empty figure of this many pixels."""
    return Picture(figsize=(width_px / dpi, height_px / dpi), dpi=dpi, facecolor="white")


def save(picture: Figure, path: str | os.PathLike[str], *, dpi: float | None = None) -> None:
    """Write a figure as PNG, SVG or PDF: the same bytes each time, and the file replaced only when complete.

    Parameters
    ----------
    picture
        From any function of this module.
    path
        File to write; its ending chooses the format.
    dpi
        Pixels per inch, 100 by default: an overview is 16 inches wide.

    Raises
    ------
    ValueError
        If the ending is none of ``.png``, ``.svg`` and ``.pdf``.
    OSError
        If the file cannot be written.
    """
    # Of a link, what it leads to is replaced.
    target = Path(path).resolve()
    format_ = target.suffix.lower().lstrip(".")
    if format_ not in FORMATS:
        raise ValueError(f"{target}: ending {target.suffix!r}; expected .png, .svg or .pdf")
    # Dates and random identifiers would make each file different.
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(format_, {})
    with whole_file(target) as temporary, matplotlib.rc_context({"svg.hashsalt": "bsdftree"}):
        picture.savefig(temporary, format=format_, metadata=metadata, dpi="figure" if dpi is None else dpi)


class Scale(NamedTuple):
    """A logarithmic colour scale [1/sr]; zero has a colour of its own.

    ``clipped`` says that there are values below ``low``; they have its colour.
    """

    low: float
    high: float
    colors: Colormap
    clipped: bool = False

    @classmethod
    def of(cls, images: Iterable[Array], limits: tuple[float, float] | None = None, colors: str = "viridis") -> Scale:
        """A scale that holds all values of some images, within five decades, or one with given limits.

        Raises
        ------
        ValueError
            If the limits are not 0 < lower < upper.
        """
        colormap = matplotlib.colormaps[colors].with_extremes(under=ZERO, bad=(0, 0, 0, 0))
        positive = np.concatenate([image[image > 0.0] for image in images])
        if limits is not None:
            low, high = limits
            if not 0.0 < low < high < np.inf:
                raise ValueError(f"limits {low:g} to {high:g} of the scale; expected 0 < lower < upper")
        else:
            low, high = round_limits(positive, _DECADES)
        return cls(low, high, colormap, bool(np.any(positive < low * (1.0 - 1e-5))))

    def rgba(self, values: Array) -> Array:
        """Colours of values, (..., 4)."""
        seen = np.where(values > 0.0, np.maximum(values, self.low), 0.5 * self.low)
        return np.asarray(self.colors(LogNorm(self.low, self.high)(seen)))

    def in_color(self) -> Scale:
        """The same values as lightness, for images of X, Y, Z, which have hues of their own."""
        return self._replace(colors=_GREYS.with_extremes(under=ZERO, bad=(0, 0, 0, 0)))

    def draw(self, axes: Axes, image: Array, extent: tuple[float, float, float, float]) -> AxesImage:
        """Draw an image, (n, m), or X, Y, Z, (n, m, 3). Pixels keep their edges."""
        if image.ndim == 3:
            return axes.imshow(self._rgba_of_xyz(image), extent=extent, interpolation="nearest")
        seen = np.where(image > 0.0, np.maximum(image, self.low), np.where(np.isnan(image), np.nan, 0.5 * self.low))
        norm = LogNorm(self.low, self.high)
        return axes.imshow(seen, cmap=self.colors, norm=norm, extent=extent, interpolation="nearest")

    def _rgba_of_xyz(self, xyz: Array) -> Array:
        """The hue of X, Y, Z as it is on screens, as light as the scale says of Y."""
        rgba = self.rgba(np.nan_to_num(xyz[..., 1]))
        linear = np.maximum(np.nan_to_num(xyz) @ _SRGB_OF_XYZ.T, 0.0)
        most = linear.max(axis=-1, keepdims=True)
        hue = np.divide(linear, most, out=np.ones_like(linear), where=most > 0.0)
        rgba[..., :3] *= hue ** (1.0 / 2.2)
        rgba[np.isnan(xyz[..., 1])] = 0.0
        return rgba

    def bar(self, picture: Figure, box: Sequence[float]) -> Colorbar:
        """Draw the scale with its decades and the colour of zero, upright in a box of the figure."""
        axes = picture.add_axes((box[0], box[1], box[2], box[3]))
        # Of the same size in pixels whatever the height of the bar.
        zero = 30.0 / (box[3] * picture.bbox.height)
        bar = picture.colorbar(
            ScalarMappable(LogNorm(self.low, self.high), self.colors),
            cax=axes,
            extend="min",
            extendrect=True,
            extendfrac=zero,
        )
        bar.locator = LogLocator(10, numticks=12)
        bar.minorlocator = LogLocator(10, subs=range(2, 10), numticks=12)
        bar.formatter = FuncFormatter(self._tick)
        if self.high < 30.0 * self.low:
            bar.minorformatter = FuncFormatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] in "25" else "")
        bar.update_ticks()
        bar.ax.tick_params(labelsize=9, colors=INK)
        bar.ax.tick_params(which="minor", labelsize=8, labelcolor=INK)
        bar.ax.text(1.55, -0.8 * zero, "0", transform=bar.ax.transAxes, fontsize=9, va="center", color=INK)
        bar.ax.set_title("BSDF [1/sr]", fontsize=9, color=INK, pad=10)
        return bar

    def _tick(self, value: float, _: object) -> str:
        at_most = "≤ " if self.clipped and np.isclose(value, self.low) else ""
        return f"{at_most}$10^{{{round(np.log10(value))}}}$"


def round_limits(values: Array, n_decades: int) -> tuple[float, float]:
    """A power of ten below the positive values and 1, 2 or 5 times one above them; 0.1 to 1 if there are none.

    They span at least a decade and less than ``n_decades`` + 1.
    """
    positive = values[values > 0.0]
    if positive.size == 0:
        return 0.1, 1.0
    # A value that is round but for its own rounding needs no further step.
    most = float(positive.max()) * (1.0 - 1e-6)
    decade = int(np.floor(np.log10(most)))
    high = next(m for m in (1, 2, 5, 10) if m * 10.0**decade >= most) * 10.0**decade
    low = max(int(np.floor(np.log10(positive.min()) + 1e-6)), decade - n_decades)
    return 10.0 ** min(low, int(np.floor(np.log10(high) + 1e-6)) - 1), float(high)


def bare(axes: Axes) -> None:
    """Take ticks and frame away."""
    axes.xaxis.set_major_locator(NullLocator())
    axes.yaxis.set_major_locator(NullLocator())
    for spine in axes.spines.values():
        spine.set_visible(False)


def line_axes(axes: Axes) -> None:
    """Grid, frame and ticks of curves and bars."""
    axes.grid(color="#e4e4e4", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=9, colors=INK)
    for spine in axes.spines.values():
        spine.set_color("#bbbbbb")
