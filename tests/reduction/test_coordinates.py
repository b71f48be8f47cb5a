"""A reduced model's coordinates are those of its body: its matrices, its weight, Newton's law."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.reduction import GeneralizedCoordinates

MESH = ao.box_mesh((0.2, 0.02, 0.02), (6, 1, 1), kind="hexahedron20")
MATERIAL = ao.Material(E=70e9, nu=0.3, rho=2700)


@cache
def reduced_models() -> list[GeneralizedCoordinates]:
    body = ao.FEModel.from_mesh(MESH, MATERIAL, fixed=[("xmin", "xyz")])
    both = [body.contact(point=(x, 0.01, 0.02), direction=(0, 0, -1), radius=0) for x in (0.2, 0.1)]
    end = both[0]
    found = [
        ao.antioscillators(end, 5).coordinates(gravity=9.81),
        ao.antioscillators(end, 4, method="krylov", contact_time=1e-4).coordinates(),
        ao.modal(end, 12).star.coordinates(gravity=9.81),
        ao.interface(both, 8, contact_time=1e-4).coordinates(gravity=9.81),
    ]
    return [one for one in found if one is not None]


@pytest.mark.parametrize("which", range(4))
def test_mass_and_stiffness_are_those_of_the_body_in_its_shapes(which: int) -> None:
    reduced = reduced_models()[which]
    for matrix, projected in (
        (np.diag(reduced.mass), reduced.basis.T @ (reduced.body.M @ reduced.basis)),
        (reduced.stiffness, reduced.basis.T @ (reduced.body.K @ reduced.basis)),
    ):
        scale = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
        assert np.abs((matrix - projected) / scale).max() < 1e-6


@pytest.mark.parametrize("which", range(4))
def test_accelerations_obey_newton(which: int) -> None:
    reduced = reduced_models()[which]
    springs, push = reduced.accelerations
    rng = np.random.default_rng(0)
    q, f = rng.standard_normal(reduced.n), rng.standard_normal(reduced.loads.shape[1])
    inertia = reduced.mass * (springs @ q + push @ f)
    forces = reduced.basis.T @ (reduced.loads @ f) - reduced.stiffness @ q
    np.testing.assert_allclose(inertia, forces, atol=1e-9 * np.abs(forces).max())


def test_gravity_pulls_at_every_node_with_its_share_of_the_weight() -> None:
    reduced = reduced_models()[0]
    whole = ao.FEModel.from_mesh(reduced.body.mesh, reduced.body.material)
    weight = 9.81 * (whole.M @ whole.translation((0, 0, -1)))
    np.testing.assert_allclose(reduced.loads[:, 1], weight[reduced.body.free], atol=1e-12)


def test_a_model_given_by_numbers_moves_no_body() -> None:
    assert ao.AOModel(m0=1.0).coordinates() is None
    assert ao.AOModel(m0=1.0).omitted_translation is None


def test_shapes_and_what_they_omit_carry_the_whole_body() -> None:
    """Struck off its centre a free body also turns; with that its unit translation is complete."""
    free = ao.FEModel.from_mesh(MESH, MATERIAL)
    tip = free.contact(point=(0.2, 0.01, 0.02), direction=(0, 0, -1), radius=0)
    star = ao.antioscillators(tip, 3)
    coordinates, omitted = star.coordinates(), star.omitted_translation
    assert coordinates is not None
    assert omitted is not None
    moved = coordinates.basis.sum(axis=1) + omitted
    np.testing.assert_allclose(moved, free.translation((0, 0, -1)), atol=1e-9)
    assert np.abs(omitted).max() > 0.1
