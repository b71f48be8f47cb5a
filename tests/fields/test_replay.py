"""Fields of reduced models against those of the full finite-element model, in impacts."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from paperbodies import LAW, beam_model

import aoimpact as ao

# The models of a pair have the same mesh, whose error is not looked at here.
pytestmark = pytest.mark.filterwarnings("ignore:stress may be off")

FloatArray = npt.NDArray[np.float64]

LENGTH, WIDTH = 0.2, 0.02
ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
BALL = ao.rigid(mass=0.05)


@cache
def cantilever(fixed: Any = (("xmin", "xyz"),)) -> ao.ContactPoint:
    mesh = ao.box_mesh((LENGTH, WIDTH, WIDTH), (10, 1, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALU, fixed=list(fixed))
    return body.contact(point=(LENGTH, WIDTH / 2, WIDTH), direction=(0, 0, -1), radius=0)


def impact(target: Any, solver: Any = None, duration: float = 9.5e-4) -> ao.Result:
    return ao.simulate(BALL, target, 1.0, law=ao.Hertz(k=5e8), duration=duration, solver=solver)


def clamp(x: FloatArray) -> npt.NDArray[np.bool_]:
    return (x[:, 0] == 0.0) & (np.abs(x[:, 2] - WIDTH) < 1e-9)


def at_the_ends(x: FloatArray) -> npt.NDArray[np.bool_]:
    return (np.abs(x[:, 0]) < 1e-9) | (np.abs(x[:, 0] - LENGTH) < 1e-9)


@cache
def full_cantilever() -> ao.Result:
    return impact(ao.full(cantilever()), ao.Newmark(dt=5e-7, estimate=False))


@pytest.mark.slow
@pytest.mark.parametrize(
    "solver", [ao.Adaptive(rtol=1e-8), ao.Newmark(dt=5e-7, estimate=False)], ids=["a", "n"]
)
def test_stress_at_the_clamp_of_a_cantilever_struck_at_its_tip(solver: Any) -> None:
    times = np.linspace(0.0, 9.5e-4, 96)
    exact = full_cantilever().target.probe(nodes=clamp, times=times).stress["xx"]
    hit = impact(ao.antioscillators(cantilever(), 8), solver)
    found = hit.target.probe(nodes=clamp, times=times).stress["xx"]
    assert np.abs(exact).max() > 20e6  # 30 MPa: a stress to speak of
    assert np.abs(found - exact).max() < 2e-3 * np.abs(exact).max()


@cache
def full_beam() -> ao.Result:
    return paper_impact(ao.full(beam_tip()), ao.Newmark(dt=5e-7, estimate=False))


@cache
def every_oscillator() -> ao.AOModel:
    return ao.antioscillators(beam_tip())


def beam_star(many: int) -> ao.AOModel:
    return every_oscillator().truncated(many)


def paper_impact(target: Any, solver: Any = None) -> ao.Result:
    """By a law that does not contain the compliance of the node."""
    ball, law = ao.rigid(mass=0.0327), ao.PowerLaw(LAW.k, 1.5)
    return ao.simulate(ball, target, 1.0, law=law, duration=250e-6, solver=solver)


@cache
def beam_tip() -> ao.ContactPoint:
    return beam_model().contact(point=(0.5, 0.01, 0.02), direction=(0, 0, -1), radius=0)


MIDSPAN = [(0.5, 0.01, 0.0), (0.5, 0.01, 0.02)]  # opposite the sphere, and under it


@pytest.mark.slow
@pytest.mark.parametrize("many", [28, 60])
def test_stress_at_midspan_of_the_papers_beam(many: int) -> None:
    times = np.linspace(0.0, 250e-6, 126)
    exact = full_beam().target.probe(MIDSPAN, times=times).stress["xx"]
    hit = paper_impact(beam_star(many))
    found = hit.target.probe(MIDSPAN, times=times).stress["xx"]
    largest = np.abs(exact).max(axis=0)
    np.testing.assert_allclose(np.abs(found).max(axis=0), largest, rtol=0.01)
    if many == 60:  # and at any time
        assert (np.abs(found - exact).max(axis=0) < 0.01 * largest).all()


def test_five_oscillators_fitted_to_the_contact_give_the_whole_beam_at_the_peak() -> None:
    exact = full_beam().target.field().stress().components
    star = ao.antioscillators(beam_tip(), 5, method="krylov", contact_time=90e-6)
    hit = paper_impact(star)
    found = hit.target.field().stress().components
    assert np.abs(found - exact).max() < 0.01 * np.abs(exact).max()


def test_a_free_body_struck_off_its_centre_flies_turns_and_bends_as_the_full_one() -> None:
    # The projectile is the bar: its AO model contains neither its turning nor all its free motion.
    tip = cantilever(fixed=())
    law, wall = ao.Hertz(k=5e8), ao.AOModel(m0=0.2, k0=1e6)
    runs = [
        ao.simulate(bar, wall, 2.0, law=law, duration=6e-4, solver=solver)
        for bar, solver in (
            (ao.full(tip), ao.Newmark(dt=5e-7, estimate=False)),
            (ao.antioscillators(tip, 12), ao.Adaptive(rtol=1e-8)),
        )
    ]
    times = np.linspace(0.0, 6e-4, 31)
    exact, found = (run.projectile.probe(nodes=at_the_ends, times=times) for run in runs)
    moved = np.abs(exact.displacement).max()
    np.testing.assert_allclose(found.displacement, exact.displacement, atol=2e-4 * moved)
    np.testing.assert_allclose(found.velocity, exact.velocity, atol=2e-2 * 2.0)
    np.testing.assert_allclose(found.velocity[0, :, 2], -2.0, rtol=1e-4)
    middle = (LENGTH / 2, WIDTH / 2, 0.0)
    bent, seen = (run.projectile.probe(middle, times=times).stress["xx"] for run in runs)
    assert np.abs(seen - bent).max() < 0.01 * np.abs(bent).max()


def test_a_full_model_in_an_adaptive_run_is_its_own_field() -> None:
    times = np.linspace(0.0, 9.5e-4, 25)
    exact = full_cantilever().target.field(times)
    found = impact(ao.full(cantilever()), ao.Adaptive(rtol=1e-8)).target.field(times)
    size = np.abs(exact.displacement).max()
    np.testing.assert_allclose(found.displacement, exact.displacement, atol=2e-5 * size)


def test_a_beam_let_go_under_its_own_weight_and_a_load() -> None:
    times = np.linspace(0.0, 4e-3, 41)

    def let_go(beam: Any, solver: Any) -> FloatArray:
        scene = ao.Scene(gravity=9.81)
        held = scene.add(beam)
        scene.apply(held, force=(np.array([0.0, 2e-3]), np.array([0.0, 3.0])))
        run = scene.simulate(duration=4e-3, solver=solver)
        return run[held].probe(nodes=clamp, times=times).stress["xx"]

    exact = let_go(ao.full(cantilever()), ao.Newmark(dt=8e-6, estimate=False))
    for solver in (ao.Adaptive(), ao.Newmark(dt=8e-6, estimate=False)):
        found = let_go(ao.antioscillators(cantilever(), 5), solver)
        assert np.abs(found - exact).max() < 0.01 * np.abs(exact).max()


def test_a_free_bar_falls_and_turns_with_its_field() -> None:
    tip = cantilever(fixed=())
    scene = ao.Scene(gravity=9.81)
    bar = scene.add(ao.antioscillators(tip, 4), velocity=0.5)
    floor = scene.add(ao.rigid(mass=np.inf))
    scene.connect(bar, floor, ao.Hertz(k=5e8), gap=1e-4)
    weights = tip.body.com_functional((0, 0, -1))
    for solver in (ao.Adaptive(), ao.Newmark(dt=1e-6, estimate=False)):
        run = scene.simulate(duration=1e-3, solver=solver)
        field = run[bar].field(run.t[::50])
        size = np.abs(run[bar].centre_displacement).max()
        centre = field.displacement.reshape(len(field.times), -1) @ weights
        np.testing.assert_allclose(centre, run[bar].centre_displacement[::50], atol=1e-6 * size)


def test_a_body_touched_in_two_places_is_recovered_from_few_modes() -> None:
    tip = cantilever()
    middle = tip.body.contact(point=(LENGTH / 2, WIDTH / 2, WIDTH), direction=(0, 0, -1), radius=0)
    times = np.linspace(0.0, 4e-4, 41)

    def struck_twice(n: int, solver: Any) -> ao.Probe:
        scene = ao.Scene()
        beam = scene.add(ao.interface([tip, middle], n, contact_time=3e-4))
        for port, velocity in enumerate((1.0, 0.5)):
            ball = scene.add(BALL, velocity=velocity)
            scene.connect(ball, beam.port(port), ao.Hertz(k=5e8))
        run = scene.simulate(duration=4.5e-4, solver=solver)
        return run[beam].probe(nodes=clamp, times=times)

    exact = struck_twice(80, ao.Adaptive())
    stress = exact.stress["xx"]
    for solver in (ao.Adaptive(), ao.Newmark(dt=5e-7, estimate=False)):
        found = struck_twice(16, solver)
        assert np.abs(found.stress["xx"] - stress).max() < 0.01 * np.abs(stress).max()


def test_damped_bodies_too() -> None:
    mesh = ao.box_mesh((LENGTH, WIDTH, WIDTH), (10, 1, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALU, fixed=[("xmin", "xyz")], damping=ao.ModalDamping(0.02))
    tip = body.contact(point=(LENGTH, WIDTH / 2, WIDTH), direction=(0, 0, -1), radius=0)
    times = np.linspace(0.0, 9.5e-4, 96)
    full, few = (
        impact(target, solver).target.probe(nodes=clamp, times=times).stress["xx"]
        for target, solver in (
            (ao.full(tip), ao.Newmark(dt=2e-6, estimate=False)),
            (ao.antioscillators(tip, 8), ao.Adaptive()),
        )
    )
    assert np.abs(few - full).max() < 0.005 * np.abs(full).max()
