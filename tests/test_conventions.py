"""The worked example of CONVENTIONS.md."""

import math

import numpy as np

import bsdftree
from bsdftree import Bsdf, Tree, direction_from_polar

INCIDENT = direction_from_polar(40, 90)
EXITANT = direction_from_polar(40, 270)


def numbered(rank: int) -> Bsdf:
    """A tree of 2² cells per axis, each of whose values is its own number."""
    shape = (4,) * rank
    return Bsdf.from_trees({"reflection_back": Tree.from_grid(np.arange(4**rank).reshape(shape))})


def test_rank_4_pair_lies_in_grid_value_136():
    b = numbered(4)
    assert b.eval(INCIDENT, EXITANT) == 136
    assert b.projected_solid_angle(INCIDENT, EXITANT) == math.pi / 16


def test_rank_3_pair_lies_in_grid_value_14():
    assert numbered(3).eval(INCIDENT, EXITANT) == 14


def test_branch_of_the_rank_4_pair_is_child_5_then_child_0():
    cells, levels, values = numbered(4).components["reflection_back"].leaves()
    # Leaves come in branch order: child 5 of the root holds leaves 80 to 95, and its child 0 comes first.
    assert values[5 * 16 + 0] == 136
    assert cells[80].tolist() == [2, 0, 2, 0] and levels[80] == 2


def test_klems_patch_is_63():
    mirror = bsdftree.generate("mirror:reflectance=0.9", klems="full", samples=64, sides="front")
    matrix = mirror.components["reflection_back"]
    first = sum(n for _, _, n in matrix.incident_rings[:4])
    assert first == 45 and matrix.incident_rings[4] == (35.0, 45.0, 24)
    assert mirror.eval(INCIDENT, EXITANT) == matrix.values[63, 63]
    angle = mirror.projected_solid_angle(INCIDENT, EXITANT)
    assert abs(angle - 0.022385) < 1e-6
    np.testing.assert_allclose(matrix.values[63, 63] * angle, 0.9, rtol=1e-6)


def test_printed_coordinates_are_right():
    y = -math.sin(math.radians(40))
    assert abs(y + 0.642788) < 1e-6
    # On the axis the square is (r + 1)/2.
    assert abs((y + 1) / 2 - 0.178606) < 1e-6
    assert abs(0.5 - 0.5 * -y - 1e-6 - 0.178605) < 1e-6
    assert abs(1 - (y + 1) / 2 - 0.821394) < 1e-6
