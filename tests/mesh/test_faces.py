"""The sides of the elements carry the nodes that lie on them."""

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
        uv = np.array([[0.2, 0.3], [0.5, 0.1], [0.0, 1.0]])
        shape, slopes = face.evaluate(uv)
        inside = shape @ element.nodes[face.nodes]
        # On a side only its own nodes have a say.
        whole = np.zeros((3, element.n_nodes))
        whole[:, face.nodes] = shape
        np.testing.assert_allclose(element.shape(inside), whole, atol=1e-14)
        step = np.array([1e-6, 0.0])
        ahead = (face.evaluate(uv + step)[0] - face.evaluate(uv - step)[0]) / 2e-6
        np.testing.assert_allclose(slopes[..., 0], ahead, atol=1e-9)
