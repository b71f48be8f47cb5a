"""Newmark's rule: its order, and that every kind of body steps alike."""

import math
import warnings

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize
from rigid_pair import against_a_wall, on_a_wall, rigid_power
from rows import each

import aoimpact as ao

from slender import beam, rod

# Matrices without a mesh have the indentation of the half-space twice, which is no matter here.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh")

HERTZ = ao.Hertz(k=1.0878565864408424e10)
MASS = 4 / 3 * math.pi * 0.01**3 * 7800


def pair(dt, *, projectile=None, target=None, law=HERTZ, velocity=1.0, duration=100e-6, **rule):
    ball = ao.rigid(mass=MASS)
    return ao.simulate(
        projectile=projectile or ball,
        target=target or ball,
        law=law,
        velocity=velocity,
        duration=duration,
        solver=ao.Newmark(dt=dt, **rule),
    )


# ----------------------------------------------------------------------- order and closed forms


def test_second_order_to_the_rigid_pairs_closed_form():
    peak, time = rigid_power(HERTZ.k, 1.5, MASS / 2, 1.0)
    assert peak == pytest.approx(1001.536, abs=5e-4)  # the published value
    assert time == pytest.approx(60.01e-6, abs=5e-9)
    steps = [4e-7, 2e-7, 1e-7, 5e-8]
    hits = [pair(dt) for dt in steps]
    errors = np.array([abs(hit.peak_force / peak - 1) for hit in hits])
    order = np.log2(errors[:-1] / errors[1:])
    assert order.mean() == pytest.approx(2.0, abs=0.15)
    assert hits[-1].contact_duration == pytest.approx(time, rel=1e-5)
    assert hits[-1].restitution == pytest.approx(1.0, abs=1e-7)


def ringing_star():
    return ao.AOModel(m0=2e-3, k0=3e5, m=[0.01, 0.02, 5e-3], k=[4e6, 2e6, 9e7])


# ----------------------------------------------------------------- one rule on every kind of body


DAMPED = ao.Rayleigh(alpha=0.05, beta=0.02), ao.ModalDamping(0.05)


@each("fixed, damping", [([0, 24], None), ([], None), *(([0, 24], of) for of in DAMPED)])
def test_star_modal_and_full_model_of_one_body_are_one(fixed, damping):
    """In exact arithmetic Newmark does not depend on the coordinates."""
    K, M = beam(12, fixed=fixed)
    tip = ao.FEModel(K=K, M=M, damping=damping).contact(dof=11 if fixed else 12)
    options = {"law": ao.Hertz(k=1e4), "velocity": 0.1, "duration": 2.0}
    ball = ao.rigid(mass=0.1)
    full = pair(2e-3, projectile=ball, target=ao.full(tip), **options)
    star = pair(2e-3, projectile=ball, target=ao.antioscillators(tip), **options)
    modal = pair(2e-3, projectile=ball, target=ao.modal(tip, K.shape[0]), **options)
    assert full.peak_force > 0
    for other in (star, modal):
        np.testing.assert_allclose(other.force, full.force, atol=1e-8 * full.peak_force)
        for name in ("displacement", "velocity", "centre_displacement"):
            expected = getattr(full.target, name)
            atol = 1e-8 * np.abs(expected).max()
            np.testing.assert_allclose(getattr(other.target, name), expected, atol=atol)
        for name in ("kinetic", "elastic"):
            expected = getattr(full.target.energy, name)
            atol = 1e-8 * expected.max()
            np.testing.assert_allclose(getattr(other.target.energy, name), expected, atol=atol)


def test_full_models_as_projectile_and_target():
    """Two equal free rods, end to end on a spring: Saint-Venant's impact, softened.

    Until the waves are back from the far ends, F = ZV/2 (1 - exp(-2kt/Z)) with Z = EA/c = 1.
    """
    K, M = rod(200)
    body = ao.FEModel(K=K, M=M)
    k, v = 10.0, 1e-3
    hit = pair(
        1e-3,
        projectile=ao.full(body.contact(dof=200)),
        target=ao.full(body.contact(dof=0)),
        law=ao.Linear(k=k),
        velocity=v,
        duration=4.0,
    )
    before = hit.t < 1.7  # the shortest waves of a mesh run ahead of the front
    expected = v / 2 * (1 - np.exp(-2 * k * hit.t[before]))
    np.testing.assert_allclose(hit.force[before], expected, atol=2e-3 * v)
    assert 2.0 < hit.contact_duration < 2.4
    assert hit.target.centre_velocity[-1] == pytest.approx(v, rel=0.06)
    momentum = hit.projectile.centre_velocity + hit.target.centre_velocity
    assert np.ptp(momentum) < 1e-12


# ------------------------------------------------------------------------------- hard cases


@each("dt", [1e-2, 1e-1, 1.0])
@each("velocity", [1e-6, 1e3])
def test_far_too_large_a_step_is_solved_and_called_far_too_large(dt, velocity):
    with pytest.warns(ao.AOImpactWarning, match=r"^dt"):
        hit = pair(dt, velocity=velocity, duration=20 * dt)
    assert hit.error.time == 1.0
    assert np.isfinite(hit.force).all()


def test_without_a_step_the_tolerance_is_met():
    peak, _ = rigid_power(HERTZ.k, 1.5, MASS / 2, 1.0)
    for rtol in (1e-2, 1e-4, 1e-6):
        hit = ao.simulate(
            projectile=ao.rigid(mass=MASS),
            target=ao.rigid(mass=MASS),
            law=HERTZ,
            velocity=1.0,
            duration=100e-6,
            solver=ao.Newmark(rtol=rtol),
        )
        assert hit.error.time <= rtol
        assert hit.peak_force == pytest.approx(peak, rel=rtol)


@each("damping", [20.0, 200.0, 1000.0, 1900.0])
@each("gap", [0.0, 1e-5, 1.234e-5, 3.3e-5])
def test_the_error_estimate_knows_of_a_force_that_jumps_at_touch(damping, gap):
    """A damped spring in closed form: its force begins with c V, at a time within a step."""
    mass, k = 0.1, 1e7
    decay = damping / (2.0 * mass)
    omega = math.sqrt(k / mass - decay**2)
    time = np.linspace(0.0, math.pi / omega, 200_001)
    turn = (omega**2 - decay**2) / omega * np.sin(omega * time)
    force = mass * np.exp(-decay * time) * (2.0 * decay * np.cos(omega * time) + turn)
    law = ao.KelvinVoigt(k=k, c=damping)
    for dt in (3e-6, 1e-6, 3e-7):
        result = on_a_wall(law, mass, 1.0, ao.Newmark(dt=dt), duration=1e-3, gap=gap)
        true = abs(result.peak_force / force.max() - 1.0)
        assert true <= result.error.time + 1e-9
        assert result.error.time < 0.2


def test_a_step_beyond_the_stability_limit_ends_with_an_error_not_with_nan():
    """β = 1/6 (linear acceleration) is stable only for ω dt < √12."""
    stiff = ao.AOModel(m0=1e-6, m=[0.03], k=[3e8])
    with pytest.raises(ao.ConvergenceError):
        pair(1e-5, target=stiff, duration=1.0, beta=1 / 6)


def test_a_damper_that_stops_the_bodies_within_a_step_is_said() -> None:
    scene = {
        "projectile": ao.rigid(mass=0.016),
        "target": ao.rigid(mass=0.016),
        "law": ao.KelvinVoigt(k=1e6, c=1e6),
        "velocity": 1.0,
        "duration": 1e-6,
    }
    with pytest.warns(ao.AOImpactWarning, match=r"^dt"):
        hit = ao.simulate(**scene, solver=ao.Newmark(dt=1e-7))
    assert hit.error.time == 1.0
    hit = ao.simulate(**scene, solver=ao.Newmark(dt=1e-9))  # an eighth of m/c
    assert hit.error.time < 0.1
    assert hit.projectile.velocity[-1] == pytest.approx(0.5, rel=1e-2)


# --------------------------------------------------- contact points without mass, at the start


def dampers_in_series(k: float, c: float, mass: float, spring: float, t: np.ndarray) -> np.ndarray:
    """A mass at 1 m/s under k δ + c δ̇ against a massless point on a spring, while they touch.

    The spring's force makes the rate of the indentation, and with it the velocity of the point.
    """

    def slope(_, y):
        u, x, v = y
        return [v - (spring * u - k * (x - u)) / c, v, -spring * u / mass]

    span = 0.0, float(t[-1])
    found = scipy.integrate.solve_ivp(
        slope, span, [0.0, 0.0, 1.0], method="Radau", rtol=1e-10, atol=1e-14, t_eval=t
    )
    return spring * found.y[0]


@each("count", [1, 2, 3])
@each("dt", [1e-7, 1e-5])
def test_dampers_in_touch_with_a_massless_point_begin_as_its_springs_allow(count, dt):
    """Masses of 1, 2 … kg under laws as strong move as one; and so heavy a body stands still."""
    k, c, spring, still = 1e6, 3000.0, 1e4, 1e9
    shares = np.arange(1.0, count + 1.0)
    duration = min(0.01, 2e4 * dt)
    total, times = shares.sum(), dt * np.arange(round(duration / dt) + 1)
    right = dampers_in_series(total * k, total * c, total, spring, times)
    for damping in (None, ao.ModalDamping(0.0)):
        scene = ao.Scene()
        point = scene.add(ao.AOModel(m0=0.0, m=[still], k=[spring], damping=damping))
        for share in shares:
            ball = scene.add(ao.rigid(mass=share), velocity=1.0)
            scene.connect(ball, point, ao.KelvinVoigt(share * k, share * c))
        run = scene.simulate(duration=duration, solver=ao.Newmark(dt=dt))
        np.testing.assert_allclose(run.t, times, rtol=1e-12)
        for contact, share in zip(run.contacts, shares, strict=True):
            force = contact.force * total / share
            np.testing.assert_allclose(force, right, atol=20.0 * dt * right.max())  # first order
            assert abs(force[0]) < 1e-8 * right.max()
        assert run.error.time < 1e-3


@each("damping", [None, ao.ModalDamping(0.0)])
def test_a_load_on_a_free_massless_point_has_moved_it_at_the_start(damping):
    scene = ao.Scene()
    body = scene.add(ao.AOModel(m0=0.0, m=[1.0], k=[1e5], damping=damping), velocity=2.0)
    scene.apply(body, force=([0.0, 1.0], [50.0, 1050.0]))
    run = scene.simulate(duration=1e-3, solver=ao.Newmark(dt=1e-5))
    assert run[body].displacement[0] == pytest.approx(50.0 / 1e5, rel=1e-5)
    assert run[body].velocity[0] == pytest.approx(2.0 + 1000.0 / 1e5, rel=1e-4)


# ------------------------------------------------------------------ the end of the record


@pytest.mark.filterwarnings("ignore:the record of")
@each("solver", [{"dt": 3e-6}, {"rtol": 1e-3}, {"rtol": 1e-5}])
@each("duration", [1e-4, 1.37e-4, 2.1e-4])
def test_a_contact_that_the_record_cuts_is_as_exact_as_claimed(solver, duration):
    scene = {
        "projectile": ao.rigid(mass=1.0),
        "target": ao.rigid(mass=2.0),
        "law": ao.Hertz(k=1e9),
        "velocity": 1.0,
        "duration": duration,
    }
    hit = ao.simulate(**scene, solver=ao.Newmark(**solver))
    exact = ao.simulate(**scene, solver=ao.Adaptive(rtol=1e-10))
    assert hit.t[-1] == hit.duration == duration
    assert hit.t[1] <= solver.get("dt", 1.0)
    np.testing.assert_allclose(np.diff(hit.t), hit.t[1], rtol=1e-9)
    assert abs(hit.peak_force / exact.peak_force - 1.0) <= hit.error.time
    assert abs(hit.impulse / exact.impulse - 1.0) <= hit.error.time


# ------------------------------------------------------------------ a tolerance that is asked for


def ringing_pair(solver):
    return ao.simulate(
        projectile=ao.rigid(mass=MASS),
        target=ringing_star(),
        law=HERTZ,
        velocity=1.0,
        duration=400e-6,
        quantity="peak_force",
        rtol=1e-3,
        solver=solver,
    )


def test_a_step_that_does_not_keep_the_tolerance_is_refused_and_the_cure_works():
    with pytest.raises(ao.ConvergenceError, match=r"^rtol") as refused:
        ringing_pair(ao.Newmark(dt=1e-6))
    finer = float(str(refused.value).split("take dt=")[1].split()[0])
    exact = ringing_pair(None)
    for solver in (ao.Newmark(dt=finer), ao.Newmark()):
        hit = ringing_pair(solver)
        assert hit.error.time + hit.error.model <= 1e-3
        assert hit.peak_force == pytest.approx(exact.peak_force, rel=1.1e-3)


def test_a_scene_keeps_or_refuses_its_tolerance_too():
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=MASS), velocity=1.0)
    scene.connect(ball, scene.add(ringing_star()), HERTZ)
    with pytest.raises(ao.ConvergenceError, match=r"^rtol"):
        scene.simulate(duration=100e-6, rtol=1e-3, solver=ao.Newmark(dt=1e-6))
    with pytest.raises(ao.ConvergenceError, match=r"^rtol"):
        scene.simulate(duration=100e-6, rtol=1e-6, solver=ao.Adaptive(rtol=1e-2))
    with pytest.raises(ao.InputError, match=r"^solver"):
        scene.simulate(duration=100e-6, rtol=1e-3, solver=ao.Newmark(dt=1e-8, estimate=False))


def test_a_load_that_jumps_leaves_the_peak_on_the_curve():
    """A sudden pull on a place without mass raises a damper's force there, within its peak."""
    scene = ao.Scene()
    place = scene.add(ao.AOModel(m0=0.0, m=[1.0], k=[1e6]))
    ball = scene.add(ao.rigid(mass=1.0), velocity=1.0)
    scene.connect(ball, place, ao.KelvinVoigt(1e6, 500.0))
    scene.apply(place, force=([1e-3, 1e-3 + 1e-9], [0.0, -100.0]))
    exact = scene.simulate(duration=1.5e-3, solver=ao.Adaptive(rtol=1e-9)).events[0].peak_force
    run = scene.simulate(duration=1.5e-3, solver=ao.Newmark(dt=1e-6))
    assert run.events[0].peak_force == run.contacts[0].force.max()
    assert run.events[0].peak_force == pytest.approx(exact, rel=run.error.time)


def shaken(onset: float, ramp: float) -> ao.Scene:
    """A mass on a spring, pushed by F within `ramp`, and a ball at 1.5 F/k from it."""
    force, stiffness = 100.0, MASS * SHAKEN**2
    scene = ao.Scene()
    mass = scene.add(ao.AOModel(m0=MASS, k0=stiffness))
    ball = scene.add(ao.rigid(mass=0.3))
    scene.connect(mass, ball, ao.Hertz(k=1e9), gap=1.5 * force / stiffness)
    scene.apply(mass, force=([onset, onset + ramp], [0.0, force]))
    return scene


SHAKEN = 2.0 * math.pi * 1e4  # rad/s


@each("onset", [1.1e-3, 1.73e-3, 5.02e-3])
def test_vibration_that_first_steps_do_not_resolve_is_not_missed(onset):
    """A load at once makes the spring swing to 2 F/k, though its mean place is F/k."""
    run = shaken(onset, 1e-7).simulate(duration=1e-2, solver=ao.Newmark(rtol=1e-2))
    touch = onset + 0.5e-7 + math.acos(-0.5) / SHAKEN
    assert run.contacts[0].intervals[0][0] == pytest.approx(touch, abs=1e-6)
    exact = shaken(onset, 1e-7).simulate(duration=1e-2, solver=ao.Adaptive(rtol=1e-8))
    assert run.contacts[0].peak_force == pytest.approx(exact.contacts[0].peak_force, rel=1e-2)


def thrown(k, solver):
    """1 kg, thrown against 100 N, that comes by 5 nm nearer to a spring than there is room."""
    gap = 5e-3 * (1.0 - 1e-6)
    scene, _ = against_a_wall(ao.rigid(1.0), ao.Linear(k), -100.0, gap=gap, velocity=1.0)
    return scene.simulate(duration=19.97e-3, solver=solver)


@each("k", [1e5, 1e9])
def test_a_touch_between_steps_is_not_missed(k):
    touch = 1e-3  # m/s, v² = 1 - 2 · 100 N/kg · gap
    peak = -100.0 + math.sqrt(100.0**2 + touch**2 * k)
    run = thrown(k, ao.Newmark())
    assert run.events[0].peak_force == pytest.approx(peak, rel=1e-3)


def test_a_load_that_steps_on_a_massless_point_is_seen_at_the_ends_of_a_step():
    """m x'' = k (u - x) with k (u - x) + F = K u: an oscillator of k K/(k + K), in closed form."""
    mass, k, stiff, when = 1.0, 1e6, 1e7, 7.3e-3
    load = [0.0, when, when + 1e-9, 1.0], [100.0, 100.0, 150.0, 150.0]
    scene, _ = against_a_wall(ao.AOModel(m0=0.0, m=[mass], k=[k]), ao.Linear(stiff), load)
    omega = math.sqrt(k * stiff / (k + stiff) / mass)
    before, after = 100.0 / stiff, 150.0 / stiff
    offset = before * (1.0 - math.cos(omega * when)) - after
    swing = math.hypot(offset, before * math.sin(omega * when))
    peak = stiff * (150.0 + k * (after + swing)) / (k + stiff)
    run = scene.simulate(duration=20e-3, solver=ao.Newmark(dt=1e-6))
    assert abs(run.events[0].peak_force / peak - 1.0) < run.error.time < 1e-4


@each("dt", [4e-4, 1e-4, 1e-6])
def test_vibration_of_a_pressed_body_that_steps_do_not_resolve_is_in_the_error(dt):
    """A load at once on a mass behind k on a contact K: x swings to 2 F/K, in 1.9e-4 s."""
    mass, k, stiff, load = 0.0062, 8.7e6, 4.7e7, 70.0
    body = ao.AOModel(m0=0.0, k0=1e4, m=[mass], k=[k])
    scene, _ = against_a_wall(body, ao.Linear(stiff), load)
    peak = load * (stiff + 2.0 * k) / (stiff + k)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", ao.AOImpactWarning)
        run = scene.simulate(duration=14e-3, solver=ao.Newmark(dt=dt))
    assert abs(run.events[0].peak_force / peak - 1.0) < run.error.time + 1e-3  # k0's part
    assert any("in vibration" in str(one.message) for one in said) == (dt == 4e-4)


def test_a_run_that_gains_energy_at_each_touch_says_so():
    """A mass pushed against a stiff stop again and again, 5000 steps: beyond all numbers."""
    parts = {"m": [0.0027462260366687, 0.14332244193417], "k": [5330678.8672, 19277396.4095]}
    body = ao.AOModel(m0=0.00015113070308, k0=19336996.9236, **parts)
    times = [0.0, 0.00562974, 0.00804105, 0.00946852, 0.01298221, 0.02207342, 0.02429331]
    scene = ao.Scene()
    wall, mass = scene.add(ao.rigid(math.inf)), scene.add(body)
    scene.connect(mass, wall, ao.Hertz(801219571940.77), gap=2.12566447e-05)
    scene.apply(mass, force=(times, [217.36, 449.89, 355.45, 364.34, 168.15, 273.58, 372.15]))
    with pytest.raises(ao.ConvergenceError, match="energy"):
        scene.simulate(duration=times[-1], solver=ao.Newmark(dt=times[-1] / 5000))


@pytest.mark.filterwarnings("ignore:.*no contact in")
def test_a_slow_load_needs_no_steps_for_what_it_does_not_excite():
    run = shaken(0.0, 1e-2).simulate(duration=1e-2, solver=ao.Newmark(rtol=1e-2))
    assert run.contacts[0].peak_force == 0.0
    assert len(run.t) < 200


@pytest.mark.filterwarnings("ignore:.*no contact in", "ignore:.*a single node")
@each("gravity", [0.0, 1000.0])
def test_vibration_of_a_mesh_that_steps_do_not_resolve_is_said(gravity):
    """A cantilever that a load, or its own weight, bends at once, and steps beside its period."""
    mesh = ao.box_mesh((0.1, 0.01, 0.01), (6, 1, 1), kind="hexahedron20")
    fixed = [("xmin", "xyz")]
    beam = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.3, rho=2700.0), fixed=fixed)
    tip = beam.contact(point=(0.1, 0.005, 0.01), direction=(0, 0, 1), radius=0)
    at_rest = beam.inverse().solve(
        tip.b if not gravity else beam.M @ tip.body.translation((0, 0, 1))
    )
    bent = float(tip.b @ at_rest) * (gravity or 100.0)
    assert bent > 0.0
    scene = ao.Scene(gravity=gravity)
    end, other = scene.add(ao.full(tip)), scene.add(ao.rigid(math.inf))
    scene.connect(end, other, ao.Hertz(k=1e9), gap=1.5 * bent)
    if not gravity:
        scene.apply(end, force=([1.1e-3, 1.1e-3 + 1e-7], [0.0, 100.0]))
    exact = scene.simulate(duration=1e-2, solver=ao.Adaptive(rtol=1e-4))
    assert exact.contacts[0].peak_force > 0.0
    with pytest.warns(ao.AOImpactWarning, match=r"^dt"):
        assert scene.simulate(duration=1e-2, solver=ao.Newmark(dt=1e-3)).error.time == 1.0


@each("solver", [ao.Newmark(rtol=1e-2), ao.Newmark(dt=1e-5)])
def test_a_damper_on_a_massless_point_carries_all_of_a_load_at_first(solver):
    """Whatever its springs: they have not moved yet. It fades within c / (k + K) = 0.1 µs."""
    body = ao.AOModel(m0=0.0, m=[0.06], k=[1e8])
    scene, _ = against_a_wall(body, ao.KelvinVoigt(k=2e6, c=10.0), 1.5)
    run = scene.simulate(duration=2.5e-3, solver=solver)
    assert run.contacts[0].force[0] == pytest.approx(1.5, rel=1e-6)
