"""The sides of the elements close them, look outward, and carry the nodes that lie on them."""

from __future__ import annotations

import numpy as np
import pytest

from aoimpact.mesh import KINDS, reference_element, reference_faces

# Nodes on each side and corners of it, as the kind's figure in meshio's documentation shows.
COUNTS = {
    "tetra": [(3, 3)] * 4,
    "tetra10": [(6, 3)] * 4,
    "hexahedron": [(4, 4)] * 6,
    "hexahedron20": [(8, 4)] * 6,
    "hexahedron27": [(9, 4)] * 6,
    "wedge": [(4, 4)] * 3 + [(3, 3)] * 2,
    "wedge15": [(8, 4)] * 3 + [(6, 3)] * 2,
    "pyramid": [(3, 3)] * 4 + [(4, 4)],
    "pyramid13": [(6, 3)] * 4 + [(8, 4)],
}


@pytest.mark.parametrize("kind", KINDS)
def test_sides_have_their_nodes(kind: str) -> None:
    element = reference_element(kind)
    for face, (n_nodes, n_corners) in zip(reference_faces(kind), COUNTS[kind], strict=True):
        assert (len(face.nodes), face.n_corners) == (n_nodes, n_corners)
        uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]] if n_corners == 4 else np.eye(3)[:, 1:])
        corners = face.origin + uv @ face.axes
        np.testing.assert_allclose(corners, element.nodes[face.nodes[:n_corners]], atol=1e-15)
        # On a side only its own nodes have a say.
        elsewhere = np.setdiff1d(np.arange(element.n_nodes), face.nodes)
        inside = face.origin + np.array([[0.2, 0.3], [0.5, 0.1]]) @ face.axes
        assert np.abs(element.shape(inside)[:, elsewhere]).max(initial=0.0) < 1e-14


@pytest.mark.parametrize("kind", KINDS)
def test_sides_close_the_element(kind: str) -> None:
    faces = reference_faces(kind)
    triangle = np.array([face.n_corners == 3 for face in faces])
    area = (
        np.array([np.cross(*face.axes) for face in faces]) * np.where(triangle, 0.5, 1.0)[:, None]
    )
    share = np.where(triangle, 1.0 / 3.0, 0.5)
    middle = np.array(
        [f.origin + s * f.axes.sum(axis=0) for f, s in zip(faces, share, strict=True)]
    )
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-15)
    volume = {"tetra": 1 / 6, "wedge": 1 / 2, "pyramid": 1 / 3}.get(
        reference_element(kind).cell.linear, 1.0
    )
    assert np.einsum("fi,fi->", area, middle) / 3.0 == pytest.approx(volume)  # Gauss's theorem
