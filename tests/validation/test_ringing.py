"""Bodies that ring in a long contact, against plain coordinates integrated turn by turn."""

from __future__ import annotations

import math

import pytest
from rigid_pair import against_a_wall

import aoimpact as ao

K, BALL, M0, M = 1e9, 1.0, 1.0, 10.0
TIME = 7.8e-4  # s: about how long the contact lasts


def omega_of(turns: float) -> float:
    return 2.0 * math.pi * turns / TIME


def scene_of(law: ao.ContactLaw, turns: float, damping: float) -> ao.Scene:
    """Return a ball that meets a body of which a load has just let go."""
    omega = omega_of(turns)
    model = ao.AOModel(
        m0=M0,
        m=[M],
        k=[omega**2 * M0 * M / (M0 + M)],
        damping=ao.ModalDamping(damping) if damping else None,
    )
    scene = ao.Scene()
    body = scene.add(model)
    ball = scene.add(ao.rigid(mass=BALL), velocity=1.0)
    scene.connect(ball, body, law, gap=20.0 / omega)
    push = 0.5 * omega
    scene.apply(body, force=([0.0, 1.0 / omega, 1.001 / omega], [push, push, 0.0]))
    return scene


@pytest.mark.parametrize("damping", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("turns", [3e3, 1e5])
def test_a_damped_body_loses_what_it_must_however_often_it_turns(
    turns: float, damping: float
) -> None:
    found = []
    for rtol in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        run = scene_of(ao.Hertz(K), turns, damping).simulate(
            duration=1.3 * TIME, solver=ao.Adaptive(rtol=rtol)
        )
        assert run.error.energy < rtol
        found.append((rtol, run.contacts[0].impulse, run.energy.dissipated[-1]))
    for rtol, impulse, lost in found:
        assert impulse == pytest.approx(found[-1][1], rel=2.0 * rtol)
        assert lost == pytest.approx(found[-1][2], rel=2.0 * rtol)


def test_a_ledger_that_does_not_balance_is_said() -> None:
    # An energy that is not the work of the force.
    law = ao.UserLaw(
        lambda d, v: K * d**1.5, energy=lambda d, v: 0.5 * K * d**2.5, depends_on_rate=False
    )
    ball, wall = ao.rigid(mass=1.0), ao.rigid(mass=math.inf)
    run = ao.simulate(ball, wall, 1.0, law=law, duration=1e-3, solver=ao.Adaptive())
    with pytest.warns(ao.AOImpactWarning, match="energy"):
        assert run.error.energy > 0.1


@pytest.mark.parametrize("law", [ao.HuntCrossley(1e11, 0.12, n=1.0), ao.HuntCrossley(1e12, 0.3)])
def test_a_force_goes_on_where_a_load_bends(law):
    """A light point rings in the force from then on, but the force does not jump."""
    point = ao.AOModel(m0=1e-3, m=[1.35, 40.0], k=[6e10, 1.3e8])
    scene, _ = against_a_wall(point, law, ([4e-5, 1e-4], [3e6, 1e6]))
    run = scene.simulate(duration=2e-4, preload=True, solver=ao.Adaptive(rtol=1e-6))
    assert run.at([4e-5]).contacts[0].force[0] == pytest.approx(3e6, rel=5e-6)
