"""Bodies whose elements have functions of the next degree: what these can say, they say exactly."""

from __future__ import annotations

import pickle
from itertools import product
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact.fem import body_stress_rows, gauss_stress, nodal_stress
from aoimpact.mesh import enriched, weights_at

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)

# The degree of displacements that an element has with the functions that are added to it.
DEGREES = {
    "tetra": 2,
    "hexahedron": 2,
    "wedge": 2,
    "pyramid": 2,
    "tetra10": 3,
    "hexahedron20": 3,
    "hexahedron27": 3,
    "wedge15": 3,
}


class Polynomial:
    """A displacement of a degree, its gradient, and the stress."""

    def __init__(self, degree: int) -> None:
        each = product(range(degree + 1), repeat=3)
        self.powers = np.array([of for of in each if sum(of) <= degree])
        self.factors = np.random.default_rng(7).standard_normal((len(self.powers), 3))

    def __call__(self, x: Any) -> Any:
        return (x[..., None, :] ** self.powers).prod(axis=-1) @ self.factors

    def stress(self, x: Any) -> Any:
        slope = np.zeros((*x.shape[:-1], 3, 3))
        for axis in range(3):
            lower = np.maximum(self.powers - np.eye(3, dtype=int)[axis], 0)
            values = self.powers[:, axis] * (x[..., None, :] ** lower).prod(axis=-1)
            slope[..., axis] = values @ self.factors
        strain = 0.5 * (slope + slope.swapaxes(-1, -2))
        lam, mu = STEEL.lame
        return 2 * mu * strain + lam * np.trace(strain, axis1=-2, axis2=-1)[
            ..., None, None
        ] * np.eye(3)


@pytest.mark.parametrize("kind", DEGREES)
def test_displacement_and_stress_of_the_next_degree_are_exact_at_nodes_and_anywhere(
    kind: str,
) -> None:
    """In a mesh of parallelepipeds and what these are cut into, whichever way edges run."""
    rng, across = np.random.default_rng(3), 2 if kind.startswith("hexa") else 1
    box = ao.box_mesh((1.5, 1, 1), (2, across, 1), kind=kind)
    shear = np.eye(3) + 0.2 * rng.standard_normal((3, 3))
    mesh, exact = ao.Mesh(box.nodes @ shear.T, box.cells, kind), Polynomial(DEGREES[kind])
    shapes = enriched(mesh)[0]

    def rows(places: Any) -> Any:
        found = sp.lil_array((len(places), shapes.n_nodes))
        for row, place in enumerate(places):
            nodes, weights = weights_at(mesh, place, shapes)
            found[row, nodes] = weights
        return found.tocsr()

    count = 3 * shapes.n_nodes // mesh.n_cells
    shares = rng.dirichlet(np.full(mesh.cells.shape[1], 0.2), (count, mesh.n_cells))
    inside = np.einsum("kcn,cni->kci", shares, mesh.nodes[mesh.cells]).reshape(-1, 3)
    fitted = rows(np.vstack([inside, mesh.nodes]))
    right = exact(np.vstack([inside, mesh.nodes]))
    moved = sp.linalg.spsolve((fitted.T @ fitted).tocsc(), fitted.T @ right)
    size = np.abs(right).max()
    assert fitted @ moved == pytest.approx(right, abs=1e-9 * size)
    elsewhere = rng.random((20, 3)) * [1.5, 1, 1] @ shear.T
    assert rows(elsewhere) @ moved == pytest.approx(exact(elsewhere), abs=1e-9 * size)

    size = np.abs(exact.stress(mesh.nodes)).max()
    nodal, within = (of(shapes, STEEL, moved) for of in (nodal_stress, gauss_stress))
    for of in (nodal, within):
        assert of.tensor == pytest.approx(exact.stress(of.points), abs=1e-8 * size)
    every = sp.eye_array(mesh.n_nodes, format="csr")
    by_rows = body_stress_rows(shapes, STEEL, every).rows @ moved.reshape(-1)
    assert by_rows.reshape(-1, 6) == pytest.approx(nodal.components, abs=1e-9 * size)


def test_elements_33_times_as_wide_as_thick_have_factors_where_iterations_fail() -> None:
    mesh = ao.box_mesh((0.133, 0.133, 0.001), (4, 4, 1), kind="tetra10")
    finer = ao.FEModel.from_mesh(mesh, STEEL).finer
    solver, force = finer.inverse(1e8), np.eye(1, finer.n_dofs, 2)[0]
    x = solver.solve_roughly(force, 1e-3)[0]
    assert np.linalg.norm(finer.K @ x + solver.s2 * (finer.M @ x) - force) < 1e-6


def test_a_finer_body_comes_back_from_a_pickle_as_that_of_its_body() -> None:
    mesh = ao.box_mesh((1, 1, 1), (2, 1, 1))
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    assert pickle.loads(pickle.dumps(body.finer)) is body.finer
