"""Shape functions are those of scikit-fem, of every kind that it has."""

from __future__ import annotations

import numpy as np
import pytest
import skfem

from aoimpact.mesh.elements import reference_element

THEIRS = {
    "tetra": skfem.ElementTetP1(),
    "tetra10": skfem.ElementTetP2(),
    "hexahedron": skfem.ElementHex1(),
    "hexahedron20": skfem.ElementHexS2(),
    "hexahedron27": skfem.ElementHex2(),
    "wedge": skfem.ElementWedge1(),
}


@pytest.mark.parametrize("kind", THEIRS)
def test_values_and_derivatives(kind: str) -> None:
    element, theirs = reference_element(kind), THEIRS[kind]
    points = np.random.default_rng(1).uniform(-0.2, 1.2, (50, 3))
    shape, gradient = element.evaluate(points)
    for i, place in enumerate(np.asarray(theirs.doflocs)):
        (a,) = np.flatnonzero(np.abs(element.nodes - place).max(axis=1) < 1e-12)
        value, derivatives = theirs.lbasis(points.T, i)
        assert shape[:, a] == pytest.approx(value + np.zeros(50), abs=1e-13)
        for alpha in range(3):
            slope = derivatives[alpha] + np.zeros(50)
            assert gradient[:, a, alpha] == pytest.approx(slope, abs=1e-12)
