"""Bodies that ring in a long contact, against plain coordinates integrated turn by turn."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import DOP853

import aoimpact as ao

K, BALL, M0, M = 1e9, 1.0, 1.0, 10.0
TIME = 7.8e-4  # s: about how long the contact lasts

LAWS = {
    "Hertz": (ao.Hertz(K), lambda d, v: K * d**1.5),
    "Linear": (ao.Linear(1.6e7), lambda d, v: 1.6e7 * d),
    "HuntCrossley": (ao.HuntCrossley(K, 0.3), lambda d, v: K * d**1.5 * (1.0 + 0.3 * v)),
    "KelvinVoigt": (
        ao.KelvinVoigt(1.6e7, 300.0, end="indentation"),
        lambda d, v: 1.6e7 * d + 300.0 * v,
    ),
}


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


def plain(name: str, turns: float, damping: float) -> tuple[float, float, float]:
    """Return peak force, impulse and the ball's velocity at the end by DOP853."""
    omega, force = omega_of(turns), LAWS[name][1]
    spring = omega**2 * M0 * M / (M0 + M)
    dashpot = 2.0 * damping * omega * M0 * M / (M0 + M)
    push, gap = 0.5 * omega, 20.0 / omega

    def contact(y: np.ndarray) -> float:
        deep = y[2] - y[0] - gap
        return force(deep, y[5] - y[3]) if deep > 0.0 else 0.0

    def contacts(y: np.ndarray) -> np.ndarray:
        deep = np.maximum(y[2] - y[0] - gap, 0.0)
        return np.where(deep > 0.0, force(deep, y[5] - y[3]), 0.0)

    def rate(t: float, y: np.ndarray) -> list[float]:
        between = spring * (y[0] - y[1]) + dashpot * (y[3] - y[4])
        load = push * min(max((1.001 - omega * t) / 0.001, 0.0), 1.0)
        f = contact(y)
        return [y[3], y[4], y[5], (f + load - between) / M0, between / M, -f / BALL, f]

    y, top = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), 0.0
    small = np.array([1e-13 / omega] * 3 + [1e-13] * 4)
    for begin, end in ((0.0, 1.0), (1.0, 1.001), (1.001, 20.0), (20.0, 1.3 * TIME * omega)):
        run = DOP853(
            rate, begin / omega, y, end / omega, rtol=1e-12, atol=small, max_step=0.3 / omega
        )
        while run.status == "running":
            run.step()
            if contact(run.y) > 0.9 * top:
                inside = run.dense_output()
                beyond = (run.t - run.t_old) / 12.0
                times = np.linspace(run.t_old - beyond, run.t + beyond, 15)
                forces = contacts(inside(times))
                at = int(np.argmax(forces))
                if 0 < at < 14:  # a parabola
                    b, m, a = forces[at - 1 : at + 2]
                    top = max(top, m - (a - b) ** 2 / (8.0 * (a - 2.0 * m + b)))
                top = max(top, *forces[1:-1])
        y = run.y
    return top, float(y[6]), float(y[5])


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
    scene = ao.Scene()
    point = scene.add(ao.AOModel(m0=1e-3, m=[1.35, 40.0], k=[6e10, 1.3e8]))
    scene.connect(point, scene.add(ao.rigid(mass=math.inf)), law)
    scene.apply(point, force=([4e-5, 1e-4], [3e6, 1e6]))
    run = scene.simulate(duration=2e-4, preload=True, solver=ao.Adaptive(rtol=1e-6))
    assert run.at([4e-5]).contacts[0].force[0] == pytest.approx(3e6, rel=5e-6)
