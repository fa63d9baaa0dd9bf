"""In which exitant cell a ray counts, as a function file for ``rcontrib``.

In: the cells. Out: text of a ``.cal`` file that defines ``bin`` from the direction Dx, Dy, Dz in which a ray leaves.
Invariant: the same cells as `CONVENTIONS.md` describes; patches by the rule of Radiance's ``klems_full.cal``
(centred on their azimuths, counter-clockwise from +X), squares by its ``disk2square.cal``, which has to be read first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

Rings = Sequence[tuple[float, float, int]]


def square_bins(n: int, azimuth: float = 0.0) -> str:
    """Cells of the square, n along each axis, of directions turned back by ``azimuth`` [radian] about Z."""
    cos, sin = math.cos(azimuth), math.sin(azimuth)
    return (
        f"in_disk_x = {cos:.17g}*Dx + {sin:.17g}*Dy;\nin_disk_y = {cos:.17g}*Dy - {sin:.17g}*Dx;\n"
        f"square_cell(c) : if(c*{n} - {n - 1}, {n - 1}, if(c, floor(c*{n}), 0));\n"
        f"bin = square_cell(out_square_x)*{n} + square_cell(out_square_y);\n"
    )


def klems_bins(rings: Rings) -> str:
    """Patches of rings: lower and upper polar angle [degree] and number of patches."""
    text = "turn = atan2(Dy, Dx)/(2*PI);\nwrapped(k, n) : k - n*floor(k/n);\n"
    text += "patch(n) = wrapped(floor(turn*n + .5), n);\nsine2 = Dx*Dx + Dy*Dy;\n"
    before = sum(n for _, _, n in rings)
    expression = ""
    for _, upper, n in reversed(rings):
        before -= n
        patch = f"{before} + patch({n})"
        border = math.sin(math.radians(upper)) ** 2
        expression = patch if not expression else f"if({border:.17g} - sine2, {patch},\n\t{expression})"
    return f"{text}bin = {expression};\n"
