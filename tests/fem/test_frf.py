"""Frequency response functions against SciPy's solutions with the full matrices."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import splu, spsolve

import aoimpact as ao

ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)

DAMPING = {
    "undamped": None,
    "Rayleigh": ao.Rayleigh(alpha=20.0, beta=1e-6),
    "modes": ao.ModalDamping(0.02),
}
SUPPORTS: dict[str, Any] = {"clamped": [("xmin", "xyz")], "free": None, "guided": [("zmin", "z")]}


@cache
def plate(damping: Any, held: str, across: int) -> tuple[ao.FEModel, ao.ContactPoint, Any]:
    mesh = ao.box_mesh((0.2, 0.1, 0.01), (across, across // 2, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=SUPPORTS[held], damping=damping)
    corner = (0.2, 0.1, 0.01)
    first = body.contact(point=(0.1, 0.05, 0.01), direction=(1, 0, -1), radius=0)
    return body, first, body.contact(point=corner, direction=(1, 1, 0), radius=0)


def damping_matrix(body: ao.FEModel) -> npt.NDArray[np.float64]:
    damping = body.damping
    if damping is None:
        return np.zeros(body.K.shape)
    if isinstance(damping, ao.Rayleigh):
        return np.asarray((damping.alpha * body.M + damping.beta * body.K).toarray())
    omega2, phi = scipy.linalg.eigh(body.K.toarray(), body.M.toarray())
    moved = body.M @ phi
    omega = np.where(omega2 < 1e-9 * omega2[-1], 0.0, np.sqrt(np.abs(omega2)))  # rigid: rounding
    return np.asarray((moved * (2.0 * damping.ratio * omega)) @ moved.T)


@pytest.mark.parametrize("held", SUPPORTS)
@pytest.mark.parametrize("damped", DAMPING)
def test_all_modes_give_the_solutions_of_the_full_matrices(damped: str, held: str) -> None:
    body, first, second = plate(DAMPING[damped], held, 4)
    frequencies = np.linspace(50.0, 6000.0, 21)
    found = body.frf(excitation=first, response=second, frequencies=frequencies, kind="accelerance")
    K, C, M = body.K.toarray(), damping_matrix(body), body.M.toarray()
    for frequency, value in zip(frequencies, found.values, strict=True):
        omega = 2.0 * math.pi * frequency
        dynamic = K + 1j * omega * C - omega**2 * M
        known = -(omega**2) * (second.b @ np.linalg.solve(dynamic, first.b))
        assert abs(value - known) <= 1e-6 * abs(known)


@pytest.mark.slow
@pytest.mark.parametrize("held", SUPPORTS)
@pytest.mark.parametrize("damped", ["undamped", "Rayleigh"])
def test_few_modes_and_a_series_do_as_well(damped: str, held: str) -> None:
    body, first, second = plate(DAMPING[damped], held, 10)
    assert body.n_dofs > 1000
    frequencies = np.linspace(100.0, 4000.0, 5)
    found = body.frf(excitation=first, response=second, frequencies=frequencies, kind="mobility")
    assert found.modes < 60
    alpha, beta = (20.0, 1e-6) if damped == "Rayleigh" else (0.0, 0.0)
    for frequency, value, bound in zip(frequencies, found.values, found.error, strict=True):
        omega = 2.0 * math.pi * frequency
        C = alpha * body.M + beta * body.K
        dynamic = sp.csc_array(body.K + 1j * omega * C - omega**2 * body.M)
        known = 1j * omega * (second.b @ spsolve(dynamic, first.b.astype(complex)))
        assert bound <= 1e-6 * abs(known)
        assert abs(value - known) <= 1e-6 * abs(known)


def test_few_frequencies_above_many_modes_are_solved_for_directly() -> None:
    body, first, second = plate(ao.Rayleigh(alpha=20.0, beta=1e-7), "clamped", 10)
    found = body.frf(excitation=first, response=second, frequencies=[6e4], kind="receptance")
    assert found.modes == 0
    omega = 2.0 * math.pi * 6e4
    dynamic = body.K + 1j * omega * (20.0 * body.M + 1e-7 * body.K) - omega**2 * body.M
    known = second.b @ spsolve(sp.csc_array(dynamic), first.b.astype(complex))
    assert (
        abs(found.values[0] - known) <= 2.0 * found.error[0] <= 1e-7 * abs(known)
    )  # and SciPy's rounding


@pytest.mark.parametrize("off", [pytest.param(1e-3, marks=pytest.mark.slow), 1e-9])
def test_the_bound_holds_beside_a_resonance_without_damping(off: float) -> None:
    body, first, second = plate(None, "clamped", 10)
    frequency = (1.0 + off) * float(body.frequencies(1)[0])
    found = body.frf(excitation=first, response=second, frequencies=[frequency], kind="receptance")
    assert found.modes > 0
    dynamic = sp.csc_array(body.K - (2.0 * math.pi * frequency) ** 2 * body.M)
    known = second.b @ spsolve(dynamic, first.b)
    assert abs(found.values[0] - known) <= found.error[0]


@pytest.mark.slow
def test_modal_damping_of_a_large_body_is_within_its_bound() -> None:
    """Against the sum over all modes."""
    damping = ao.ModalDamping(0.02)
    body, first, second = plate(damping, "clamped", 10)
    frequencies = np.linspace(100.0, 2000.0, 5)
    found = body.frf(excitation=first, response=second, frequencies=frequencies)
    omega2, phi = scipy.linalg.eigh(body.K.toarray(), body.M.toarray())
    omega = 2.0 * math.pi * frequencies[:, None]
    weights = (phi.T @ first.b) * (phi.T @ second.b)
    known = (weights / (omega2 - omega**2 + 0.04j * np.sqrt(omega2) * omega)).sum(axis=1)
    assert found.modes < body.n_dofs / 4
    assert (np.abs(found.values - known) <= found.error + 1e-7 * np.abs(known)).all()
    assert (found.error <= 2e-2 * np.abs(known).max()).all()


def test_a_response_without_bound_is_named() -> None:
    """A free body at 0 Hz, and a spring at its natural frequency."""
    spring = ao.FEModel(K=np.array([[(318.0 * math.pi) ** 2]]), M=np.eye(1))
    for point, frequency in ((plate(None, "free", 4)[1], 0.0), (spring.contact(dof=0), 159.0)):
        with pytest.raises(ao.InputError, match=r"^frequencies"):
            point.body.frf(excitation=point, frequencies=[frequency])


@pytest.mark.parametrize("across", [4, pytest.param(10, marks=pytest.mark.slow)])
@pytest.mark.parametrize("damping", [None, ao.Rayleigh(beta=1e-7)])
def test_a_free_body_moves_at_low_frequency_as_a_rigid_one(across: int, damping: Any) -> None:
    """a = (1/m + (r × n)ᵀ J⁻¹ (r × n)) F under a force along n at r from the centre of mass."""
    body, point, _ = plate(damping, "free", across)
    found = body.frf(excitation=point, frequencies=[1e-3, 0.1, 1.0, 2e5], kind="accelerance")
    lengths = np.array([0.2, 0.1, 0.01])
    mass = 2700.0 * lengths.prod()
    inertia = mass / 12.0 * ((lengths**2).sum() - lengths**2)
    along = np.array([1.0, 0.0, -1.0]) / math.sqrt(2.0)
    turning = np.cross(np.array([0.1, 0.05, 0.01]) - 0.5 * lengths, along)
    known = 1.0 / mass + (turning**2 / inertia).sum()
    assert found.values[:3].real == pytest.approx(known, rel=1e-5)
    assert (found.error[:3] <= 1e-9 * known).all()


@pytest.mark.parametrize("across", [4, pytest.param(10, marks=pytest.mark.slow)])
@pytest.mark.parametrize("held", ["clamped", "free"])
def test_the_bound_holds_far_above_all_modes(held: str, across: int) -> None:
    """Of two points that are apart the terms of the sum nearly cancel; refined in long double."""
    body, first, second = plate(None, held, across)
    frequencies = np.array([1e6, 1e7, 1e8])
    found = body.frf(excitation=first, response=second, frequencies=frequencies)
    K, M = (of.toarray().astype(np.longdouble) for of in (body.K, body.M))
    for frequency, value, bound in zip(frequencies, found.values, found.error, strict=True):
        omega2 = np.longdouble(2.0 * math.pi * frequency) ** 2
        solve = splu(sp.csc_matrix(body.K - float(omega2) * body.M)).solve
        x = solve(first.b).astype(np.longdouble)
        for _ in range(5):
            x = x + solve((first.b - (K @ x - omega2 * (M @ x))).astype(float))
        known = float(second.b @ x)
        assert abs(value - known) <= bound <= 1e-6 * abs(known)
