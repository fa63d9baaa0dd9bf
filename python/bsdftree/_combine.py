"""One BSDF of several: merged side by side, or stacked as layers."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bsdftree import _core
from bsdftree._bsdf import Bsdf


def merge(parts: Sequence[Bsdf]) -> Bsdf:
    """Join BSDFs that have different components or bands of one device.

    Parameters
    ----------
    parts
        BSDFs; :meth:`Bsdf.select` chooses what to take of each. The header is that of the first.

    Returns
    -------
    Bsdf
        All components of all bands.

    Raises
    ------
    ValueError
        If two have the same component of the same band, or they are of different kinds: a file holds trees of one rank,
        or matrices over one basis.

    Warns
    -----
    UserWarning
        If sizes differ, or more light leaves the device than comes in.

    Examples
    --------
    >>> import numpy as np
    >>> from bsdftree import Tree
    >>> white = Tree.from_grid(np.full((1, 1, 1, 1), 0.1))
    >>> front, back = (Bsdf.from_trees({f"reflection_{side}": white}) for side in ("front", "back"))
    >>> sorted(merge([front, back]).components)
    ['reflection_back', 'reflection_front']
    """
    core, remarks = _core.merge([part._core for part in parts])
    made = Bsdf(core)
    for remark in remarks:
        warnings.warn(remark, stacklevel=2)
    for band in made.check().bands:
        for energy in band.energy:
            if energy.max > 1.01:
                message = f"{band.band}: {100 * energy.max:.1f} % of the light from the {energy.side} leaves"
                warnings.warn(message, stacklevel=2)
    return made


def stack(
    layers: Sequence[Bsdf],
    *,
    klems: str | list[tuple[float, float, int]] | None = None,
    subdivide: int = 1,
    log2_res: int | None = None,
    tolerance: float = 0.0,
) -> Bsdf:
    """Stack layers, such as glazing and a shade, with all light that goes to and fro between them.

    Parameters
    ----------
    layers
        From the outside (*front* in WINDOW) to the room.
    klems, subdivide
        Stack over the patches of this basis, as in :meth:`Bsdf.to_klems`.
    log2_res, tolerance
        Stack over cells of rank-4 trees, 2^log2_res per axis, 1 to 6, as in :meth:`Bsdf.to_tree`. Without either, the
        finest trees decide, up to 2^5, if all layers are trees of rank 4; otherwise the basis of the first matrix, or
        Klems full.

    Returns
    -------
    Bsdf
        All four components of each band that all layers have. An absent transmission is the other one reversed, an
        absent reflection black. Colour is followed as Radiance's red, green and blue.

    Raises
    ------
    ValueError
        If there is no layer or no common band, or light between two layers never leaves.

    Notes
    -----
    J. H. Klems, ASHRAE Transactions 100, 1994: T = T2 (I - R1b R2f)^-1 T1. Light leaves a cell evenly over all of it,
    so peaks get wider by up to a cell at each layer.

    Examples
    --------
    >>> import numpy as np
    >>> from bsdftree import Tree
    >>> pane = Tree.from_grid(np.full((1, 1, 1, 1), 0.5 / np.pi))
    >>> layer = Bsdf.from_trees({"transmission_front": pane})
    >>> round(float(stack([layer, layer]).hemispherical([0, 0, 1])), 4)
    0.25
    """
    return Bsdf(_core.stack([layer._core for layer in layers], klems, subdivide, log2_res, tolerance))


def layer_absorptances(
    layers: Sequence[Bsdf],
    band: str = "Visible",
    *,
    klems: str | list[tuple[float, float, int]] | None = None,
    subdivide: int = 1,
    log2_res: int | None = None,
) -> NDArray[np.float64]:
    """Find what each layer of a stack absorbs, with all light that goes to and fro.

    Parameters
    ----------
    layers
        From the outside (*front* in WINDOW) to the room.
    band
        Of all layers.
    klems, subdivide, log2_res
        Over what they are stacked, as in :func:`stack`.

    Returns
    -------
    ndarray
        (layers, 2, cells): of light from each incident cell of the outside and of the room, the fraction that is left
        in the layer. With what the stack transmits and reflects they sum to 1. Less than 0 where a file has more light
        than came. Patches are in the order of the basis; cells of trees by x, then by y.

    Raises
    ------
    ValueError
        As :func:`stack`.

    Examples
    --------
    >>> from bsdftree import Tree
    >>> pane = Tree.from_grid(np.full((1, 1, 1, 1), 0.5 / np.pi))
    >>> layer = Bsdf.from_trees({"transmission_front": pane})
    >>> layer_absorptances([layer, layer])[:, 0, 0].round(4).tolist()
    [0.5, 0.25]
    """
    return _core.layer_absorptances([layer._core for layer in layers], band, klems, subdivide, log2_res)
