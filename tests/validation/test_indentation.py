"""The indentation of a result is the contact law's own, whatever mesh lies under the contact.

Checked by the closed form of Hertz's law, δ = (F/k)^(2/3), by the work ∫F dδ of the recorded curve,
and by the sum of all energies.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)
BALL = ao.ball(0.01, STEEL)


def plate(divisions: tuple[int, int, int], **options: Any) -> ao.ContactPoint:
    mesh = ao.box_mesh((0.1, 0.08, 0.01), divisions, kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    return body.contact(point=(0.05, 0.04, 0.01), **options)


def sheet() -> ao.ContactPoint:
    body = ao.FEModel.from_mesh(
        ao.sheet_mesh((0.1, 0.1), (10, 10)),
        ao.Shell(thickness=3e-3, material=ALUMINIUM),
        fixed=[("xmin", "xyz", "xyz")],
    )
    return body.contact(point=(0.05, 0.05, 0.0), direction=(0, 0, -1))


# How often the sheet is touched, and what models leave out, is no matter here.
pytestmark = pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")

PLACES = {
    "fine bricks": lambda: plate((6, 6, 2)),
    "coarse bricks": lambda: plate((4, 4, 1)),
    "radius": lambda: plate((6, 6, 2), radius=1e-3),
    "node": lambda: plate((6, 6, 2), radius=0),
    "shell": sheet,
}


@cache
def model(place: str) -> ao.AOModel:
    return ao.antioscillators(PLACES[place](), n=6, method="krylov", contact_time=1e-4)


@pytest.mark.parametrize(
    ("place", "solver"),
    [
        *((place, None) for place in PLACES),
        *((of, ao.Newmark(dt=2e-7)) for of in ("radius", "shell")),
    ],
)
def test_force_over_indentation_is_hertz_s_law(place: str, solver: Any) -> None:
    hit = ao.simulate(BALL, model(place), 1.0, duration=3e-4, solver=solver)
    pressed = hit.force > 0.01 * hit.peak_force
    law = (hit.force[pressed] / hit.law.k) ** (2 / 3)
    np.testing.assert_allclose(hit.indentation[pressed], law, rtol=1e-4)
    # a² = R δ and p = 3 F/(2 π a²) of a ball on a flat; Newmark's peak lies between its steps.
    deepest, near = hit.indentation.max(), 1e-3 if solver else 1e-6
    assert hit.contact_radius == pytest.approx(math.sqrt(0.01 * deepest), rel=1e-9)
    pressure = 1.5 * hit.law.force(deepest) / (math.pi * 0.01 * deepest)
    assert hit.hertz_pressure == pytest.approx(pressure, rel=near)


@pytest.mark.parametrize("place", ["coarse bricks", "radius", "shell"])
def test_the_contact_s_energy_is_the_work_of_that_curve(place: str) -> None:
    hit = ao.simulate(BALL, model(place), 1.0, duration=3e-4)
    times = np.linspace(0.0, hit.peak_time, 20_000)
    rise = hit.at(times)
    work = np.trapezoid(rise.force, rise.indentation)
    assert rise.energy.contact[-1] == pytest.approx(work, rel=1e-5)
    contact = rise.each_contact[0]
    np.testing.assert_array_equal(contact.elastic, rise.energy.contact)
    started = 0.5 * BALL.mass * 1.0**2
    np.testing.assert_allclose(hit.energy.total, started, rtol=1e-5)


def test_friction_leaves_the_normal_law_as_it_is() -> None:
    tip = plate((6, 6, 1))
    scene = {"velocity": (0.0, 0.5, -1.0), "friction": 0.2, "duration": 1.5e-4}
    hit = ao.simulate(BALL, tip, **scene)
    pressed = hit.force > 0.01 * hit.peak_force
    law = (hit.force[pressed] / hit.law.k) ** (2 / 3)
    np.testing.assert_allclose(hit.indentation[pressed], law, rtol=1e-3)
