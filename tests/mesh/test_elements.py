"""Shape functions and quadrature are those of scikit-fem, of every kind that it has."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import skfem
from rows import each
from skfem import refdom
from skfem.quadrature import get_quadrature

from aoimpact.mesh import KINDS, Rule, reference_element

THEIRS = {
    "tetra": skfem.ElementTetP1(),
    "tetra10": skfem.ElementTetP2(),
    "hexahedron": skfem.ElementHex1(),
    "hexahedron20": skfem.ElementHexS2(),
    "hexahedron27": skfem.ElementHex2(),
    "wedge": skfem.ElementWedge1(),
}


@each("kind", THEIRS)
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


# Degrees of the stiffness and mass rules: in all, in the triangle and along the axis, or in each.
DEGREES = {
    "tetra": (1, 2),
    "tetra10": (5, 7),
    "hexahedron": (3, 5),
    "hexahedron20": (5, 9),
    "hexahedron27": (5, 9),
    "wedge": (3, 5),
    "wedge15": (5, 9),
    "pyramid": (3, 5),
    "pyramid13": (7, 11),
}


def integral(kind: str, powers: tuple[int, int, int]) -> float:
    """Return ∫ xⁱ yʲ zᵏ over the reference cell, by scikit-fem's rules of a higher degree."""
    i, j, k = powers
    line, w_line = get_quadrature(refdom.RefLine, 12)
    if kind.startswith("tetra"):
        (x, y, z), weights = get_quadrature(refdom.RefTet, 8)
        return float(weights @ (x**i * y**j * z**k))
    along = [float(w_line @ line[0] ** power) for power in powers]
    if kind.startswith("hexahedron"):
        return along[0] * along[1] * along[2]
    if kind.startswith("wedge"):
        (x, y), weights = get_quadrature(refdom.RefTri, 10)
        return float(weights @ (x**i * y**j)) * along[2]
    z = line[0]  # each cross-section of a pyramid is a square of 1 − z
    return along[0] * along[1] * float(w_line @ ((1 - z) ** (i + j + 2) * z**k))


@each("which", [0, 1])
@each("kind", KINDS)
def test_quadrature_is_exact_to_its_degree(kind: str, which: int) -> None:
    element, degree = reference_element(kind), DEGREES[kind][which]
    rule: Rule = (element.stiffness_rule, element.mass_rule)[which]
    assert (rule.weights > 0.0).all()
    for powers in product(range(degree + 1), repeat=3):
        in_all = sum(powers) if kind.startswith("tetra") else powers[0] + powers[1]
        if in_all > degree and not kind.startswith("hexahedron"):
            continue
        if kind.startswith("pyramid") and sum(powers) + 2 > degree:
            continue
        value = rule.weights @ np.prod(rule.points ** np.array(powers), axis=1)
        assert value == pytest.approx(integral(kind, powers), rel=1e-13, abs=1e-16)


def test_the_rule_of_ten_node_tetrahedra_is_the_same_from_each_corner() -> None:
    """Else K of a curved element would depend on the order of its nodes."""
    rule = reference_element("tetra10").stiffness_rule
    shares = np.column_stack([1.0 - rule.points.sum(axis=1), rule.points])
    turned = shares[:, [1, 2, 3, 0]]
    distance = np.abs(turned[:, None] - shares[None]).max(axis=2)
    assert distance.min(axis=1) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(rule.weights[distance.argmin(axis=1)], rule.weights)
