"""Damping: what it is in numbers, on every kind of model, and that all of them die away alike."""

import math

import numpy as np
import pytest

import aoimpact as ao

from slender import beam

# Their matrices are of no solid elements, in which a force at a node sinks in.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh:aoimpact.AOImpactWarning")

STAR = {"m0": 0.02, "k0": 1e7, "m": [0.3, 0.1], "k": [4e8, 2e9]}


def dashpot_receptance(star, alpha, beta, omega):
    """u/f of the star's own springs, masses and dashpots, put together by hand."""

    def spring(k):
        return k * (1 + 1j * omega * beta)

    def mass(m):
        return -(omega**2) * m + 1j * omega * alpha * m

    hung = sum(1 / (1 / spring(k) + 1 / mass(m)) for m, k in zip(star.m, star.k, strict=True))
    return 1 / (spring(star.k0) + mass(star.m0) + hung)


@pytest.mark.parametrize(("alpha", "beta"), [(200.0, 0.0), (0.0, 3e-7), (50.0, 1e-6)])
def test_rayleigh_on_a_star_is_dashpots_beside_its_springs_and_to_the_ground(alpha, beta):
    star = ao.AOModel(**STAR, damping=ao.Rayleigh(alpha=alpha, beta=beta))
    omega = np.geomspace(1e2, 1e6, 50)
    expected = dashpot_receptance(star, alpha, beta, omega)
    np.testing.assert_allclose(star.receptance(omega), expected, rtol=1e-9)
    assert isinstance(star.receptance(1e4), complex)
    assert np.isrealobj(ao.AOModel(**STAR).receptance(omega))


def test_a_massless_contact_keeps_its_springs_and_is_the_limit_of_a_light_one():
    omega = np.geomspace(1e2, 3e4, 20)
    light, none = (
        ao.AOModel(**{**STAR, "m0": m0}, damping=ao.ModalDamping(0.01)) for m0 in (1e-9, 0.0)
    )
    np.testing.assert_allclose(none.receptance(omega), light.receptance(omega), rtol=1e-4)


def test_models_inherit_the_bodys_damping():
    K, M = beam(10, fixed=[0, 20])
    damping = ao.Rayleigh(alpha=0.1, beta=1e-3)
    body = ao.FEModel(K=K, M=M, damping=damping)
    tip = body.contact(dof=9)
    omega = np.linspace(0.1, 30.0, 40)
    C = 0.1 * M + 1e-3 * K
    expected = [
        np.linalg.solve((K - w**2 * M + 1j * w * C).toarray(), tip.b) @ tip.b for w in omega
    ]
    star, modes = ao.antioscillators(tip), ao.modal(tip, body.n_dofs).star
    assert star.damping == star.truncated(3).damping == modes.damping == damping
    for model in (star, modes):
        np.testing.assert_allclose(model.receptance(omega), expected, rtol=1e-6)


# ---------------------------------------------------------------------------------- in time


@pytest.mark.parametrize("damping", [ao.Rayleigh(alpha=300.0, beta=1e-5), ao.ModalDamping(0.05)])
@pytest.mark.filterwarnings("ignore:.*no contact")
def test_an_oscillator_dies_away_as_in_its_closed_form(damping):
    k, m, load = 5e5, 0.2, 500.0
    omega = math.sqrt(k / m)
    sigma = damping.decay(omega)
    fast = math.sqrt(omega**2 - sigma**2)
    errors = []
    for steps in (2000, 4000):
        scene = ao.Scene()
        body = scene.add(ao.AOModel(m0=m, k0=k, damping=damping))
        scene.connect(body, scene.add(ao.rigid(math.inf)), ao.Hertz(1e9), gap=1.0)
        scene.apply(body, force=load)
        run = scene.simulate(duration=0.02, solver=ao.Newmark(dt=0.02 / steps))
        t = run.t
        swing = np.exp(-sigma * t) * (np.cos(fast * t) + sigma / fast * np.sin(fast * t))
        errors.append(np.abs(run[body].displacement - load / k * (1.0 - swing)).max())
        energy = run.energy
        stored = energy.kinetic + energy.elastic + energy.dissipated
        np.testing.assert_allclose(stored, energy.work, atol=1e-12 * stored[-1])
        assert energy.dissipated[-1] > 0.2 * energy.work.max()
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)
