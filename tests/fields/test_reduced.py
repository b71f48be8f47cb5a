"""Reduced models as motion of their body: projections of K, M and the loads."""

from __future__ import annotations

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.fields.reduced import Reduced, reduced_interface, reduced_star


def tip(x: float = 0.2, body: ao.FEModel | None = None) -> ao.ContactPoint:
    if body is None:
        mesh = ao.box_mesh((0.2, 0.02, 0.02), (6, 1, 1), kind="hexahedron20")
        alu = ao.Material(E=70e9, nu=0.3, rho=2700)
        body = ao.FEModel.from_mesh(mesh, alu, fixed=[("xmin", "xyz")])
    return body.contact(point=(x, 0.01, 0.02), direction=(0, 0, -1))


def models() -> list[Reduced]:
    end = tip()
    both = [end, tip(0.1, end.body)]
    return [
        reduced_star(ao.antioscillators(end, 5), gravity=9.81),
        reduced_star(ao.antioscillators(end, 4, method="krylov", contact_time=1e-4)),
        reduced_star(ao.modal(end, 12).star, gravity=9.81),
        reduced_interface(ao.interface(both, 8, contact_time=1e-4), gravity=9.81),
    ]


@pytest.mark.parametrize("which", range(4))
def test_mass_and_stiffness_are_those_of_the_body_in_its_shapes(which: int) -> None:
    reduced = models()[which]
    for matrix, projected in (
        (np.diag(reduced.mass), reduced.basis.T @ (reduced.body.M @ reduced.basis)),
        (reduced.stiffness, reduced.basis.T @ (reduced.body.K @ reduced.basis)),
    ):
        scale = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
        assert np.abs((matrix - projected) / scale).max() < 1e-6


@pytest.mark.parametrize("which", range(4))
def test_accelerations_obey_newton(which: int) -> None:
    reduced = models()[which]
    springs, push = reduced.accelerations
    rng = np.random.default_rng(0)
    q, f = rng.standard_normal(reduced.n), rng.standard_normal(reduced.loads.shape[1])
    inertia = reduced.mass * (springs @ q + push @ f)
    forces = reduced.basis.T @ (reduced.loads @ f) - reduced.stiffness @ q
    np.testing.assert_allclose(inertia, forces, atol=1e-9 * np.abs(forces).max())


def test_gravity_pulls_at_every_node_with_its_share_of_the_weight() -> None:
    reduced = models()[0]
    whole = ao.FEModel.from_mesh(reduced.body.mesh, reduced.body.material)
    weight = 9.81 * (whole.M @ whole.translation((0, 0, -1)))
    np.testing.assert_allclose(reduced.loads[:, 1], weight[reduced.body.free], atol=1e-12)
