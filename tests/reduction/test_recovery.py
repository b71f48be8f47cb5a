"""From star coordinates back to the body: exact where closed forms say what is exact."""

from __future__ import annotations

import pickle
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
from rows import each

import aoimpact as ao
from aoimpact.reduction import Recovery

FloatArray = npt.NDArray[np.float64]

MATERIAL = ao.Material(E=70e9, nu=0.3, rho=2700)
SUPPORTS: list[Any] = [(("xmin", "xyz"),), (("xmin", "x"),), None]
MODELS: list[Any] = [
    lambda tip: ao.antioscillators(tip, 1).modal,
    lambda tip: ao.antioscillators(tip, 5).modal,
    lambda tip: ao.antioscillators(tip, 4, method="krylov", contact_time=1e-4).modal,
    lambda tip: ao.modal(tip, 8),
    lambda tip: ao.modal(tip, 30),
]

# Far below all natural frequencies that are not zero, so that the correction is the static one.
SLOW = 1.0


@cache
def tip_of(fixed: Any) -> ao.ContactPoint:
    mesh = ao.box_mesh((0.2, 0.02, 0.02), (6, 1, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, MATERIAL, fixed=fixed)
    return body.contact(point=(0.2, 0.01, 0.02), direction=(0, 0, -1), radius=0)


@cache
def made(model: Any, fixed: Any) -> Any:
    return model(tip_of(fixed))


def flexibility(tip: ao.ContactPoint) -> FloatArray:
    """Σ φ_j φ_jᵀb / ω_j² over the elastic modes, for a unit force at the contact."""
    omega2, modes = la.eigh(tip.body.K.toarray(), tip.body.M.toarray())
    elastic = modes[:, tip.body.rigid_modes.shape[1] :]
    return elastic @ (elastic.T @ tip.b / omega2[-elastic.shape[1] :])


def some_motion(model: ao.Body) -> FloatArray:
    """Coordinates in which every mode is strained alike, at two times."""
    force = np.random.default_rng(0).uniform(0.5, 1.0, (len(model.omega), 2))
    return np.where(model.omega[:, None] > 0.0, force / model.omega[:, None].clip(1.0) ** 2, 1e-3)


def recovery_of(model: ao.Body, s: float) -> Recovery:
    return Recovery(model, model.loads(), s)


@each("fixed", SUPPORTS)
def test_a_star_with_all_its_oscillators_leaves_nothing_to_correct(fixed: Any) -> None:
    star = ao.antioscillators(tip_of(fixed)).modal
    coordinates, force = some_motion(star), np.array([[1e3, -2e3]])
    found = recovery_of(star, 1e5).displacement(coordinates, force)
    exact = star.expand(coordinates)
    if star.following is not None:
        exact = exact + star.following @ force
    np.testing.assert_allclose(found, exact, atol=1e-7 * np.abs(exact).max())


@each("s", [1e3, 1e5])
@each("model", MODELS)
@each("fixed", SUPPORTS)
def test_growth_at_its_own_pace_is_exact_with_any_model(fixed: Any, model: Any, s: float) -> None:
    # Under F e^{st}: X = (K + s²M)⁻¹ b F, and the modes' amplitudes from their own equations.
    tip = tip_of(fixed)
    reduced, force = made(model, fixed), 1e3
    coordinates = force * reduced.participation.T / (reduced.omega[:, None] ** 2 + s**2)
    found = recovery_of(reduced, s).displacement(coordinates, np.array([[force]]))[:, 0]
    exact = np.linalg.solve((tip.body.K + s**2 * tip.body.M).toarray(), force * tip.b)
    np.testing.assert_allclose(found, exact, atol=1e-7 * np.abs(exact).max())


@each("fixed", SUPPORTS)
def test_growth_under_several_forces_is_exact_with_few_modes(fixed: Any) -> None:
    tip, s = tip_of(fixed), 5e4
    other = tip.body.contact(point=(0.1, 0.01, 0.02), direction=(0, 0, -1), radius=0)
    model = ao.interface([tip, other], 10, contact_time=1e-4)
    forces = np.array([[1e3], [-400.0]])
    coordinates = model.participation.T @ forces / (model.omega**2 + s**2)[:, None]
    found = recovery_of(model, s).displacement(coordinates, forces)[:, 0]
    loads = np.stack([tip.b, other.b], axis=1) @ forces[:, 0]
    exact = np.linalg.solve((tip.body.K + s**2 * tip.body.M).toarray(), loads)
    np.testing.assert_allclose(found, exact, atol=1e-7 * np.abs(exact).max())


@each("model", MODELS)
def test_a_steady_push_deforms_a_free_body_as_inertia_relief_says(model: Any) -> None:
    tip = tip_of(None)
    reduced, force, place = model(tip), 1e3, 1e-5
    still = reduced.omega[:, None] == 0.0
    yielding = (
        force * reduced.participation.T / np.where(still, np.inf, reduced.omega[:, None]) ** 2
    )
    coordinates = np.where(still, place, yielding)
    found = recovery_of(reduced, SLOW).displacement(coordinates, np.array([[force]]))[:, 0]
    rigid = found - force * flexibility(tip)
    modes = tip.body.rigid_modes
    only_rigid = modes @ (modes.T @ (tip.body.M @ rigid))
    np.testing.assert_allclose(rigid, only_rigid, atol=1e-6 * np.abs(found).max())


@each("model", MODELS)
def test_the_momentum_of_a_free_body_needs_no_correction(model: Any) -> None:
    tip = tip_of(None)
    star = model(tip)
    coordinates = some_motion(star)
    found = recovery_of(star, 1e4).displacement(coordinates, np.array([[1e3, -2e3]]))
    momentum = tip.body.rigid_modes.T @ (tip.body.M @ (found - star.expand(coordinates)))
    size = np.abs(tip.body.rigid_modes.T @ (tip.body.M @ found)).max()
    assert np.abs(momentum).max() < 1e-8 * size


def test_it_survives_pickling() -> None:
    star = ao.antioscillators(tip_of(None), 3).modal
    coordinates, force = some_motion(star), np.array([[1e3, -2e3]])
    recovery = recovery_of(star, 1e5)
    expected = recovery.displacement(coordinates, force)
    again = pickle.loads(pickle.dumps(recovery))
    np.testing.assert_array_equal(again.displacement(coordinates, force), expected)
