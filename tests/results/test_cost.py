"""What a result cost: seconds of a clock of one's own bound them."""

from __future__ import annotations

import pickle
import time

import aoimpact as ao
from aoimpact.base import held_warnings


def test_models_and_run_share_the_time_of_the_call() -> None:
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    plate = ao.FEModel.from_mesh(
        ao.box_mesh((0.1, 0.08, 0.01), (6, 6, 1), kind="hexahedron20"),
        ao.Material(E=70e9, nu=0.33, rho=2700),
        fixed=[("xmin", "xyz")],
    )
    tip = plate.contact(point=(0.05, 0.04, 0.01))
    ball = ao.ball(radius=0.01, material=steel)
    start = time.perf_counter()
    with held_warnings():  # of the coarse mesh
        hit = ao.simulate(projectile=ball, target=tip, velocity=1.0)
    whole = time.perf_counter() - start
    assert 0.0 < hit.cost.run < hit.cost.model < hit.cost.model + hit.cost.run < whole
    assert hit.cost.model > 0.5 * whole  # else it would be of something else
    with held_warnings():
        assert str(hit.cost) in str(hit)
    assert "model" in str(hit.cost)
    assert pickle.loads(pickle.dumps(hit)).cost == hit.cost


def test_given_models_cost_nothing() -> None:
    models = ao.rigid(mass=1.0), ao.rigid(mass=2.0)
    for solver in (ao.Adaptive(), ao.Newmark(dt=1e-7, estimate=False)):
        hit = ao.simulate(
            models[0], models[1], 1.0, law=ao.Hertz(k=1e9), duration=1e-3, solver=solver
        )
        assert hit.cost.model == 0.0 < hit.cost.run
        assert str(hit.cost).startswith("run ")
