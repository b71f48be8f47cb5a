"""Sensors of a plate: within their claimed errors of the full model."""

from __future__ import annotations

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)
DOWN = (0.0, 0.0, -1.0)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:.*the mesh makes an error"),
    pytest.mark.filterwarnings("ignore:.*may be off by"),
    pytest.mark.filterwarnings("ignore:the record of"),
]


def test_an_accelerometer_and_supports_of_a_plate() -> None:
    """A ball on 200 x 150 x 6 mm: 30 mm from the contact behind CFC 1000, and two supports.

    The full model has all of its modes, so that it has no error by its steps.
    """
    mesh = ao.box_mesh((0.2, 0.15, 0.006), (12, 9, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    tip = body.contact(point=(0.1, 0.075, 0.006), radius=0.001)
    at, duration = (0.13, 0.075, 0.0), 3.2e-3  # of which the filter takes the last 1 ms
    ball = ao.ball(0.01, STEEL)
    times = np.arange(0.0, duration, 4e-6)
    full = ao.simulate(
        ball, ao.full(tip), 1.0, duration=duration, solver=ao.Adaptive(rtol=1e-6), energies=False
    )

    def acceleration(hit: ao.Result) -> np.ndarray:
        return np.asarray(hit.target.probe(at, DOWN, times=times).filtered(cfc=1000).acceleration)

    def reaction(hit: ao.Result) -> np.ndarray:
        return np.asarray(hit.target.reaction("xmin", times=times).force @ DOWN)

    for quantity, read, rtol in (
        (ao.AccelerationAt(at, DOWN, cfc=1000), acceleration, 1e-2),
        (ao.ReactionAt("xmin", DOWN), reaction, 5e-2),
    ):
        hit = ao.simulate(ball, tip, 1.0, duration=duration, quantity=quantity, rtol=rtol)
        right = read(full)
        assert hit.error.model is not None
        assert hit.error.model <= rtol
        apart, largest = np.nanmax(np.abs(read(hit) - right)), np.nanmax(np.abs(right))
        assert apart <= hit.error.model * largest
