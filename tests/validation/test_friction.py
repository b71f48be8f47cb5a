"""Friction of the core against rings on a half-space, closed forms and measured impacts."""

import ctypes
import math

import numpy as np
import pytest
from maw import MEASURED, Rings, impact

from aoimpact import _core

LIKE = 2.0 * (1.0 - 0.3) / (2.0 - 0.3)  # G*/E* of two like materials of Poisson's ratio 0.3
SPHERE = 3.5  # acceleration of the contact point of a unit mass, 1/m + R^2/J

ROOM = 800


class _Spring(ctypes.Structure):
    _fields_ = [
        ("depth", ctypes.c_double),
        ("along", ctypes.c_double * 2),
        ("law", ctypes.c_double * 2),
    ]


class _State(ctypes.Structure):
    _fields_ = [
        ("room", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
        ("spring", ctypes.POINTER(_Spring)),
        ("spare", ctypes.POINTER(_Spring)),
        ("indentation", ctypes.c_double),
        ("reach", ctypes.c_double),
        ("share", ctypes.c_double),
    ]


class _Value(ctypes.Structure):
    _fields_ = [
        ("force", ctypes.c_double * 2),
        ("by_slide", ctypes.c_double * 4),
        ("by_indentation", ctypes.c_double * 2),
        ("by_share", ctypes.c_double * 2),
        ("stuck", ctypes.c_double),
        ("terms", ctypes.c_double),
    ]


class Friction:
    """One contact by Hertz's law with friction, through the public functions in C."""

    def __init__(self, k: float, ratio: float, mu: float, precision: float = 1e-5) -> None:
        self.core = ctypes.CDLL(_core.__file__)
        law, self.law = ctypes.create_string_buffer(4096), ctypes.create_string_buffer(4096)
        parameter = (ctypes.c_double * 1)(k)
        assert self.core.aoi_law_create(law, b"hertz", ctypes.c_size_t(1), parameter) == 0
        numbers = (ctypes.c_double(number) for number in (mu, ratio, precision))
        assert self.core.aoi_friction_create(self.law, law, *numbers) == 0
        self.springs = [(_Spring * ROOM)() for _ in range(2)]
        self.state = _State(ROOM, 0, *self.springs, 0.0, 0.0, 0.0)
        self.slide = 0.0

    def force(self, depth: float, slide: float) -> float:
        """Return the force after the next step: at an indentation, having slid so far in all."""
        value, d = _Value(), ctypes.c_double(depth)
        along, state = (ctypes.c_double * 2)(slide - self.slide, 0.0), ctypes.byref(self.state)
        self.core.aoi_friction_try(
            self.law, state, d, ctypes.c_double(1.0), along, ctypes.byref(value)
        )
        assert self.core.aoi_friction_move(self.law, state, d, ctypes.c_double(1.0), along) == 0
        self.slide = slide
        return float(value.force[0])


def test_force_of_a_winding_path_is_that_of_rings():
    # To and fro while the normal force rises and falls; the error of the rings halves.
    k, mu, depth = 4.0 / 3.0, 0.3, 0.01
    t = np.linspace(0.0, 1.0, 401)[1:]
    depths = depth * np.sin(math.pi * 0.999 * t)
    slides = mu / LIKE * depth * (0.9 * np.sin(5.0 * t) + 0.5 * t)
    core = Friction(k, LIKE, mu)
    force = np.array([core.force(*at) for at in zip(depths, slides, strict=True)])
    errors = []
    for count in (25, 50, 100):
        rings = Rings(1.0, LIKE, 1.0, mu, 1.001 * depth, count)
        found = np.array([rings.force(*at) for at in zip(depths, slides, strict=True)])
        errors.append(np.abs(found - force).max() / (mu * k * depth**1.5))
    assert errors[2] < 5e-4
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2.0, rtol=0.1)


@pytest.mark.parametrize("psi", [0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 4.5])
def test_tangential_rebound_is_that_of_maw_barber_and_fawcett(psi):
    # psi = (G*/E*) v_t/(mu v_n) of the contact point.
    k, mu, v = 4.0 / 3.0, 0.2, 1e-3
    unit = mu * v / LIKE
    _, after = impact(Friction(k, LIKE, mu).force, k, SPHERE, (v, psi * unit), 400)
    coarse, fine = (
        impact(
            Rings(1.0, LIKE, 1.0, mu, 1.01 * (1.25 * v * v / k) ** 0.4, count).force,
            k,
            SPHERE,
            (v, psi * unit),
            400,
        )[1]
        for count in (40, 80)
    )
    assert after / unit == pytest.approx((2.0 * fine - coarse) / unit, abs=2e-3 * max(psi, 1.0))


@pytest.mark.parametrize("beyond", [1.001, 1.5, 5.0])
def test_gross_slip_is_the_closed_form(beyond):
    k, mu, v = 4.0 / 3.0, 0.2, 1e-3
    chi = 0.5 * LIKE * SPHERE
    psi, unit = beyond * (4.0 * chi - 1.0), mu * v / LIKE
    out, after = impact(Friction(k, LIKE, mu).force, k, SPHERE, (v, psi * unit), 20_000)
    assert out == pytest.approx(-v, rel=1e-6)
    assert after / unit == pytest.approx(psi - 4.0 * chi, rel=2e-6)


@pytest.mark.parametrize(("angle", "restitution", "spin"), MEASURED)
def test_measured_tangential_restitution_of_an_alumina_ball_on_glass(angle, restitution, spin):
    # Unit mass; the peak force is right to scale, since only k/m counts.
    ball, glass, R, speed = (380e9, 0.23), (70e9, 0.25), 2.5e-3, 3.9
    normal = 1.0 / sum((1.0 - nu * nu) / E for E, nu in (ball, glass))
    tangential = 4.0 / sum((2.0 - nu) * 2.0 * (1.0 + nu) / E for E, nu in (ball, glass))
    k = 4.0 / 3.0 * normal * math.sqrt(R) / (4000.0 * 4.0 / 3.0 * math.pi * R**3)
    theta = math.radians(angle)
    vn, vt = speed * math.cos(theta), speed * math.sin(theta)
    friction = Friction(k, tangential / normal, 0.092)
    _, contact = impact(friction.force, k, SPHERE, (vn, vt), 800)
    # The impulse P takes v_t by P and the contact point's velocity by 7/2 P; spin is 5/2 P/R.
    impulse = (vt - contact) / SPHERE
    if spin is None:
        assert 1.0 - impulse / vt == pytest.approx(restitution, abs=0.03)
    else:  # 6.3 % too much at 10.98 degrees, which is 0.022 of v_t
        assert impulse / vt == pytest.approx(0.4 * R * spin / vt, abs=0.03)
