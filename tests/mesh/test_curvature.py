"""Curvatures from the nodes of a mesh against those of the surface that was meshed."""

from __future__ import annotations

import numpy as np
import pytest

from aoimpact.mesh import boundary, box_mesh, sphere_mesh, surface_shape


@pytest.mark.parametrize("size", [0.6, 0.25, 0.125])
def test_sphere(size: float) -> None:
    point = np.array([0.3, 0.5, np.sqrt(1.0 - 0.34)])
    shape = surface_shape(boundary(sphere_mesh(1.0, size)), point)
    np.testing.assert_allclose(shape.curvatures, 1.0, atol=shape.error)
    np.testing.assert_allclose(shape.normal, point, atol=1e-3)
    assert shape.error < 0.02


def test_flat() -> None:
    surface = boundary(box_mesh((1.0, 0.02, 0.02), (50, 2, 2)))
    shape = surface_shape(surface, np.array([0.5, 0.01, 0.02]))
    np.testing.assert_array_equal(shape.curvatures, 0.0)
    assert shape.error < 1e-9
