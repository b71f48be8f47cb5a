"""A reduced model knows at which frequencies it has the receptance of its body."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import aoimpact as ao

LENGTH, HEIGHT = 0.3, 0.02
MESH = ao.box_mesh((LENGTH, HEIGHT, HEIGHT), (30, 2, 2), kind="hexahedron20")
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
FREE = ao.FEModel.from_mesh(MESH, ALU)
HELD = ao.FEModel.from_mesh(MESH, ALU, fixed=[("xmin", "xyz")])
SHORT = 5e-5


def tips(body: ao.FEModel) -> list[ao.ContactPoint]:
    return [body.contact(point=(x, 0.01, 0.02), radius=0) for x in (0.05, 0.2)]


def averaged(body: ao.FEModel, frequency: float) -> np.ndarray:
    """Receptances of the whole body at the imaginary frequency, at both places."""
    solver = body.inverse((2.0 * np.pi * frequency) ** 2, solutions=2)
    return np.array([tip.b @ solver.solve(tip.b) for tip in tips(body)])


@pytest.mark.parametrize("body", [FREE, HELD], ids=["free", "held"])
@pytest.mark.parametrize(
    "duration", [SHORT, pytest.param(math.inf, marks=pytest.mark.slow)], ids=["short", "for ever"]
)
def test_the_error_of_the_receptance_is_bounded_and_in_the_band_it_is_small(
    body: ao.FEModel, duration: float
) -> None:
    model = ao.interface(tips(body), 20, contact_time=SHORT, duration=duration)
    low, high = model.band
    assert high > 4e4
    for frequency in (300.0, 3e3, 3e4, 1e5):
        omega = 2.0 * np.pi * frequency
        ours = (model.participation**2 / (model.omega**2 + omega**2)).sum(axis=1)
        error = float((1.0 - ours / averaged(body, frequency)).max())
        known = float(np.interp(np.log(omega), np.log(model._band.omega), model._band.error))
        assert -1e-9 < error < 1.2 * known + 1e-9  # interpolated between frequencies
        if low <= frequency <= high:
            assert error < 1e-3


@pytest.mark.slow
def test_the_lowest_bending_of_a_free_bar_is_right_by_default() -> None:
    """4.730² √(EI/ρA)/(2π L²), less 3 % of shear and rotary inertia at this slenderness."""
    bernoulli = 4.730**2 * math.sqrt(70e9 / 2700 / 12) * HEIGHT / (2 * np.pi * LENGTH**2)
    for n in (16, 20, 40):
        model = ao.interface(tips(FREE), n)
        lowest = model.frequencies[model.omega > 0.0][0]
        assert lowest == pytest.approx(FREE.frequencies(8)[6], rel=1e-3)
        assert lowest == pytest.approx(0.97 * bernoulli, rel=0.02)
        assert model.band[0] == 0.0


def test_a_receptance_outside_the_band_warns_with_the_cure() -> None:
    bending = 2.0 * np.pi * 1.1e3
    model = ao.interface(tips(FREE), 20, contact_time=SHORT, duration=SHORT)
    assert model.band[0] > 5e3
    with pytest.warns(ao.AOImpactWarning, match="duration"):
        model.receptance(bending)
    star = ao.antioscillators(tips(FREE)[0], 8, method="krylov", contact_time=1e-3)
    with pytest.warns(ao.AOImpactWarning, match="contact_time"):
        star.receptance(2.0 * np.pi * 1e5)
    paper = ao.antioscillators(tips(HELD)[0], 5)
    with pytest.warns(ao.AOImpactWarning, match="larger"):
        paper.receptance([0.0, 1e6])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ao.interface(tips(FREE), 20).receptance([0.0, bending])
        star.receptance(bending)
        paper.receptance(0.0)


def test_what_is_the_body_itself_is_right_everywhere() -> None:
    assert ao.AOModel(m0=0.1, k0=1e5, m=[0.2], k=[1e6]).band == (0.0, math.inf)
    small = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.01, 0.01), (4, 1, 1)), ALU)
    tip = small.contact(point=(0.1, 0.0, 0.0), direction=(-1.0, 0.0, 0.0), radius=0)
    assert ao.antioscillators(tip).band == (0.0, math.inf)
