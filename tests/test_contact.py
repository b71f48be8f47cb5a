"""Contact points: a node in a direction, or a dof; what is near a node is said, not guessed."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from aoimpact.errors import AOImpactWarning, InputError
from aoimpact.fem import FEModel
from aoimpact.generate import box_mesh
from aoimpact.material import Material

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
BLOCK = box_mesh((0.04, 0.02, 0.02), (4, 2, 2))  # nodes 10 mm apart
FREE = FEModel.from_mesh(BLOCK, STEEL)
HELD = FEModel.from_mesh(BLOCK, STEEL, fixed=[("xmin", "xz")])
DOWN = (0.0, 0.0, -1.0)


@pytest.mark.parametrize("error", [0.0, 1e-9])
def test_a_node_s_own_place_is_taken_as_it_is(error: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tip = FREE.contact(point=(0.02 + error, 0.01, 0.02), direction=DOWN)
    assert tip.point is not None
    np.testing.assert_allclose(tip.point, (0.02, 0.01, 0.02), rtol=1e-15)


def test_a_point_between_nodes_goes_to_the_nearest_and_says_so() -> None:
    said = r"\(0\.023, 0\.01, 0\.02\) m is no node.* {} at \(0\.02, 0\.01, 0\.02\) m, 0\.003 m off"
    node = FREE.contact(point=(0.02, 0.01, 0.02), direction=DOWN).node
    with pytest.warns(AOImpactWarning, match=said.format(node)) as caught:
        tip = FREE.contact(point=(0.023, 0.01, 0.02), direction=DOWN)
    assert tip.node == node
    assert caught[0].filename == __file__


def test_a_point_off_the_body_is_refused() -> None:
    with pytest.raises(InputError, match=r"\(23, 10, 20\) m is .* from the nearest .*in metres"):
        FREE.contact(point=(23.0, 10.0, 20.0), direction=DOWN)


def test_a_node_that_is_held_is_refused_with_the_cure() -> None:
    words = r"point \(0, 0, 0\.02\) m with direction \(0, 0, -1\): .* is held .*; choose another"
    with pytest.raises(InputError, match=words):
        HELD.contact(point=(0.0, 0.0, 0.02), direction=DOWN)
    assert HELD.contact(point=(0.0, 0.0, 0.02), direction=(0.0, 1.0, 0.0)).b.sum() == 1.0
