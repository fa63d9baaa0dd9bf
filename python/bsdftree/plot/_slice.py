"""Goniometric diagrams: slices in the plane of incidence, with the value as the radius."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.projections.polar import PolarAxes
from numpy.typing import ArrayLike, NDArray

from bsdftree import Bsdf
from bsdftree.plot._curve import step_curve
from bsdftree.plot._parts import ROOM, band_of, heading_of, scatters
from bsdftree.plot._style import FAINT, INK, figure, round_limits

Array = NDArray[np.float64]
Quantity = Literal["bsdf", "intensity"]
Radius = Literal["log", "linear"]
FROM_ROOM = (0.0, 30.0, 60.0)
FROM_OUTSIDE = (180.0, 150.0, 120.0)
_DECADES = 4
_UP_DEG = 90.0


def slice(
    bsdf: Bsdf,
    *,
    theta_deg: ArrayLike | None = None,
    phi_deg: ArrayLike = _UP_DEG,
    band: str | None = None,
    quantity: Quantity = "bsdf",
    radius: Radius = "log",
    title: str | None = None,
) -> Figure:
    """Draw slices in the plane of incidence for several incident directions.

    The surface lies across the middle, the room above, outside below. Light comes from the left, so that mirrored
    light leaves to the right. Curves are steps: the BSDF is constant over each cell, and the edges of cells are found
    exactly. Where the plane itself runs along an edge between cells, the upper cell counts.

    Parameters
    ----------
    bsdf
        Trees or Klems matrices.
    theta_deg
        Incident polar angles from +Z [degree]; over 90 is light from outside. 0, 30 and 60 by default, or 180, 150
        and 120 if nothing becomes of light from the room.
    phi_deg
        Azimuth from which the light comes [degree], counter-clockwise from +X; one, or one for each angle. 90 is from
        above.
    band
        Spectral band; ``Visible`` or the only one by default.
    quantity
        ``"bsdf"`` [1/sr], or ``"intensity"``: BSDF × cos θ, so that areas compare with flux.
    radius
        ``"log"``: four to five decades at most, smaller values at the centre; or ``"linear"``.
    title
        Heading; the name of the product by default.

    Raises
    ------
    ValueError
        If there is no such band, angles do not pair up, or an option is not one of those above.
    """
    band = band_of(bsdf, band)
    if theta_deg is None:
        theta_deg = FROM_ROOM if scatters(bsdf, ROOM, band) else FROM_OUTSIDE
    theta, phi = (np.ravel(a) for a in np.broadcast_arrays(np.asarray(theta_deg, float), np.asarray(phi_deg, float)))
    if not (np.isfinite(phi).all() and ((theta >= 0.0) & (theta <= 180.0)).all()):
        raise ValueError(f"incident angles {theta.tolist()}, {phi.tolist()}; expected θ from 0 to 180 degrees")
    picture = figure(1100, 960)
    axes = picture.add_axes((240 / 1100, 70 / 960, 740 / 1100, 740 / 960), projection="polar")
    assert isinstance(axes, PolarAxes)
    draw_slice(axes, bsdf, theta.tolist(), phi.tolist(), band, quantity, radius)
    picture.text(0.03, 0.97, heading_of(bsdf, band, title), fontsize=15, va="center", color=INK)
    return picture


def draw_slice(
    axes: PolarAxes,
    bsdf: Bsdf,
    theta_deg: Sequence[float],
    phi_deg: Sequence[float],
    band: str,
    quantity: Quantity = "bsdf",
    radius: Radius = "log",
) -> None:
    """Draw the diagram into polar axes."""
    if quantity not in ("bsdf", "intensity") or radius not in ("log", "linear"):
        raise ValueError(f"{quantity!r}, {radius!r}; expected 'bsdf' or 'intensity', and 'log' or 'linear'")
    curves = [step_curve(bsdf, t, p, band) for t, p in zip(theta_deg, phi_deg, strict=True)]
    if quantity == "intensity":
        curves = [(angle, f * np.abs(np.cos(np.radians(angle)))) for angle, f in curves]
    to_radius, end, ticks, labels = _radii(np.concatenate([f for _, f in curves]), radius)
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_ylim(0.0, end)
    colors = matplotlib.colormaps["plasma"](np.linspace(0.0, 0.8, max(len(curves), 2)))
    # Where curves coincide, those beneath show at the edges.
    widths = iter(np.linspace(2.8, 1.3, len(curves)))
    for (angle, f), theta, phi, color in zip(curves, theta_deg, phi_deg, colors, strict=False):
        axes.plot(
            np.radians(angle), to_radius(f), color=color, linewidth=next(widths), label=_name(theta, phi, phi_deg)
        )
        # Where the light comes from.
        axes.annotate(
            "", xy=(np.radians(-theta), 0.86 * end), xytext=(np.radians(-theta), 1.0 * end), annotation_clip=False,
            arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
    axes.plot(np.radians([-90, 90]), [end, end], color=INK, linewidth=1.6)
    _label(axes, end, ticks, labels, phi_deg)
    unit = "BSDF [1/sr]" if quantity == "bsdf" else "BSDF × cos θ [1/sr]"
    axes.legend(
        title=f"{unit}\nlight from", loc="upper right", bbox_to_anchor=(-0.03, 1.14), fontsize=9, title_fontsize=9,
        alignment="left", frameon=False, handlelength=1.4, borderpad=0,
    )  # fmt: skip


def _name(theta_deg: float, phi_deg: float, all_phi_deg: Sequence[float]) -> str:
    azimuth = f", φ {phi_deg:g}°" if len(set(all_phi_deg)) > 1 else ""
    return f"θ {theta_deg:g}°{azimuth}"


def _radii(values: Array, radius: Radius) -> tuple[Callable[[Array], Array], float, Array, list[str]]:
    """The radius of a value, the radius of the rim, and ticks with their labels."""
    if radius == "linear":
        top = float(values.max()) or 1.0
        step = 10.0 ** np.floor(np.log10(top))
        step *= next(m for m in (0.2, 0.5, 1.0, 2.0) if top / (m * step) <= 5.0)
        ticks = np.arange(1, int(np.ceil(top / step - 1e-9)) + 1) * step
        return (lambda f: f), float(ticks[-1]), ticks, [f"{t:g}" for t in ticks]
    low, high = round_limits(values, _DECADES)
    end = float(np.log10(high / low))
    decades = np.arange(1, int(end + 1e-6) + 1)
    labels = [f"$10^{{{round(np.log10(low)) + d}}}$" for d in decades]
    return (lambda f: np.log10(np.maximum(f, low) / low)), end, decades.astype(float), labels


def _label(axes: PolarAxes, end: float, ticks: Array, labels: list[str], phi_deg: Sequence[float]) -> None:
    angles = np.arange(-150, 181, 30)
    names = {0: "room\n0°", 90: "", 180: "180°\noutside"}
    axes.set_xticks(np.radians(angles % 360), [names.get(abs(a), f"{abs(a)}°") for a in angles.tolist()])
    # Near the centre labels would cover each other.
    labels = [label if tick > 0.25 * end else "" for tick, label in zip(ticks, labels, strict=True)]
    axes.set_rgrids(ticks, labels, angle=84, fontsize=9, color=INK, ha="center")
    for label in axes.get_yticklabels():
        label.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
    axes.tick_params(axis="x", labelsize=9, colors=FAINT, pad=4)
    axes.grid(color="#dddddd", linewidth=0.7)
    axes.spines["polar"].set_color("#bbbbbb")
    if len(set(phi_deg)) == 1:
        azimuths = {0.0: "right", 90.0: "up", 180.0: "left", 270.0: "down"}
        for angle, phi in ((-90, phi_deg[0] % 360), (90, (phi_deg[0] + 180) % 360)):
            text = azimuths.get(round(phi, 6), f"φ {phi:g}°")
            ha = "right" if angle < 0 else "left"
            axes.text(np.radians(angle), 1.04 * end, text, fontsize=10, color=INK, ha=ha, va="center")
