"""Scenes of many bodies: what SciPy, Newmark's rule, closed forms and symmetry say of them."""

import dataclasses
import itertools
import math
import pickle

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize
import scipy.sparse.linalg
from campaign.case import Body, Case, Contact, Law
from campaign.oracle import Oracle

import aoimpact as ao
from aoimpact import box_mesh

MASS, K = 0.0327, 1e10
BALL, WALL = ao.rigid(mass=MASS), ao.rigid(mass=math.inf)
HERTZ = ao.Hertz(k=K)
EARTH = 9.81
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
# A held body of a few frequencies, with a contact mass.
BEAM = ao.AOModel(m0=0.02, k0=2e5, m=[0.1, 0.05, 0.02], k=[3e5, 2e6, 9e6])


def row_of_balls(count, velocity=1.0, law=HERTZ):
    scene = ao.Scene()
    balls = [scene.add(BALL, velocity=velocity if i == 0 else 0.0) for i in range(count)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, law)
    return scene, balls


def bouncing(gap=1e-3, law=HERTZ):
    """A ball that falls on a floor, and the time from bounce to bounce."""
    scene = ao.Scene(gravity=EARTH)
    ball, floor = scene.add(BALL), scene.add(WALL)
    scene.connect(ball, floor, law, gap=gap)
    return scene, ball, 2.0 * math.sqrt(2.0 * gap / EARTH)


def velocities(run, bodies):
    return np.array([run[body].velocity[-1] for body in bodies])


# ---------------------------------------------------------------------- rows of balls


def by_scipy(count, mass, stiffness, duration):
    """A row of balls, struck at 1 m/s, by the campaign's plain equations."""
    balls = [Body(mass, velocity=0.0 if i else 1.0) for i in range(count)]
    contacts = [Contact(i, i + 1, Law("Hertz", {"k": stiffness})) for i in range(count - 1)]
    return Oracle(Case(tuple(balls), tuple(contacts), duration=duration), rtol=1e-11).run()


@pytest.mark.parametrize("count", [2, 3, 6])
def test_newtons_cradle_against_scipy(count):
    duration = 120e-6 * count
    scene, balls = row_of_balls(count)
    run = scene.simulate(duration=duration, solver=ao.Adaptive(rtol=1e-9))
    exact = by_scipy(count, MASS, K, duration).velocities
    np.testing.assert_allclose(velocities(run, balls), exact, rtol=0, atol=1e-8)
    # All have let go: these are the outgoing velocities.
    assert (np.diff(velocities(run, balls)) > 0.0).all()
    assert not run.in_contact_at_end
    assert run.error.energy < 1e-9


def wave(count, rtol):
    """The peak forces of a wave along a row, the times between them, and a few states."""
    duration = 30.5e-6 * count + 50e-6
    scene, balls = row_of_balls(count)
    run = scene.simulate(duration=duration, solver=ao.Adaptive(rtol=rtol))
    peaks = np.array([event.peak_force for event in run.events])
    pace = np.diff([event.peak_time for event in run.events])
    # Behind the wave all have let go: what is solved for in a step does not grow with the row.
    ends = np.array([event.contacts[-1][1] for event in run.events if event.contacts])
    assert (ends > 0.999 * duration).sum() < 15
    few = run.at(np.linspace(0.0, duration, 9))
    momentum = sum(MASS * few[ball].velocity for ball in balls)
    return peaks, pace, momentum / MASS, few.energy.total / (0.5 * MASS)


def steadiness(values):
    return np.ptp(values) / values.mean()


def test_a_solitary_wave_keeps_its_height_and_speed():
    peaks, pace, momentum, energy = wave(45, 1e-10)
    assert steadiness(peaks[25:40]) < 1e-6
    assert steadiness(pace[25:40]) < 1e-6
    assert np.abs(momentum - 1.0).max() < 1e-12
    assert np.abs(energy - 1.0).max() < 1e-10


def pace_by_scipy():
    """Time from ball to ball of the wave with m = k = peak force = 1."""
    found = by_scipy(24, 1.0, 1.0, 24.0)
    return float(np.diff(found.peak_times[16:19]).mean() * found.peaks[17] ** (1 / 6))


@pytest.mark.slow
def test_a_solitary_wave_through_a_thousand_balls():
    peaks, pace, momentum, energy = wave(1000, 3e-10)
    assert steadiness(peaks[100:990]) < 1e-8
    assert steadiness(pace[100:990]) < 1e-8
    assert np.abs(momentum - 1.0).max() < 1e-10
    assert np.abs(energy - 1.0).max() < 1e-10
    # Nesterenko (1983): by dimensions the time from ball to ball is √m k^(-1/3) F^(-1/6), times one
    # number.
    unit = math.sqrt(MASS) * K ** (-1 / 3) * peaks[500] ** (-1 / 6)
    assert pace[500] / unit == pytest.approx(pace_by_scipy(), rel=1e-5)


# ---------------------------------------------------------------------- several contacts


def slender_body(ends=("xmin", "xmax")):
    mesh = box_mesh((0.3, 0.02, 0.02), (6, 1, 1))
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[(end, "xyz") for end in ends])


def midspan(body):
    return body.contact(point=(0.15, 0.01, 0.02), direction=(0.0, 0.0, -1.0), radius=0)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*elements of first order")  # models are compared, not meshes
@pytest.mark.filterwarnings("ignore:velocity of body .* may be off by")
def test_a_body_struck_in_three_places_is_all_of_its_modes():
    body = slender_body()
    tips = [
        body.contact(point=(x, 0.01, 0.02), direction=(0, 0, -1), radius=0)
        for x in (0.1, 0.15, 0.25)
    ]
    speeds, gaps, duration = (1.0, 0.5, 0.8), (0.0, 1e-5, 5e-6), 2.5e-4
    balls = [ao.rigid(mass=0.02)] * 3
    # At nodes, whose own compliance only laws like Hertz's contain.
    law = ao.PowerLaw(k=K, n=1.5)
    omega2, modes = scipy.linalg.eigh(body.K.toarray(), body.M.toarray())
    shapes = np.array([tip.b for tip in tips]) @ modes
    n = len(omega2)

    def motion(_, y):
        ball, ball_rate, x, rate = np.split(y, [3, 6, 6 + n])
        force = K * np.maximum(ball - shapes @ x - gaps, 0.0) ** 1.5
        return np.concatenate([ball_rate, -force / 0.02, rate, force @ shapes - omega2 * x])

    start = np.concatenate([np.zeros(3), speeds, np.zeros(2 * n)])
    full = scipy.integrate.solve_ivp(
        motion, (0.0, duration), start, method="DOP853", rtol=1e-10, atol=1e-14
    ).y[3:6, -1]
    errors = []
    for order in (24, n):
        scene = ao.Scene()
        beam = scene.add(ao.interface(tips, n=order))
        struck = [scene.add(ball, velocity=v) for ball, v in zip(balls, speeds, strict=True)]
        for i, (ball, gap) in enumerate(zip(struck, gaps, strict=True)):
            scene.connect(ball, beam.port(i), law, gap=gap)
        run = scene.simulate(duration=duration, solver=ao.Adaptive(rtol=1e-9))
        assert run[beam].port_velocities.shape[0] == 3
        assert run.error.energy < 1e-8
        errors.append(np.abs(velocities(run, struck) - full).max())
    assert errors[0] < 1e-3
    assert errors[1] < 1e-6


# ---------------------------------------------------------------------- many contacts


@pytest.mark.filterwarnings("ignore:.*with_mesh")
def test_a_held_body_of_several_places_starts_alike_by_both_ways():
    K = np.diag([0.0, 1e6, 1e6, 3e5, 1e6, 1e6])
    K[np.ix_([0, 3], [0, 3])] += 1e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    body = ao.FEModel(K=K, M=np.eye(6), nodes=[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    ends = [body.contact(point=(x, 0.0, 0.0), direction=(1, 0, 0), radius=0) for x in (0.0, 1.0)]
    for solver in (ao.Adaptive(), ao.Newmark(dt=1e-6)):
        scene = ao.Scene()
        moving, wall = scene.add(ends, velocity=4.0), scene.add(WALL)
        scene.connect(moving.port(0), wall, HERTZ, gap=1.0)
        with pytest.warns(ao.AOImpactWarning, match=r"^body"):
            run = scene.simulate(duration=1e-4, solver=solver)
        np.testing.assert_allclose(run[moving].centre_velocity[0], 4.0, rtol=1e-12)
        np.testing.assert_allclose(run[moving].port_displacements[:, -1], [4e-4, 4e-4], rtol=1e-2)


def squeezed(ratio):
    """A ball of mass 1 at rest between a wall and one `ratio` times as heavy that moves in."""
    scene = ao.Scene()
    wall, ball = scene.add(WALL), scene.add(ao.rigid(mass=1.0), position=1.0)
    heavy = scene.add(ao.rigid(mass=ratio), velocity=-1.0, position=2.0)
    scene.connect(wall, ball, ao.Hertz(k=1e22))
    scene.connect(ball, heavy, ao.Hertz(k=1e22))
    return scene, heavy


def collisions(run):
    return sum(len(contact.intervals) for contact in run.contacts)


@pytest.mark.slow
def test_a_closing_gap_counts_the_digits_of_pi():
    """Galperin (2003): a ratio of 100^n gives as many collisions as the first digits of pi say."""
    scene, heavy = squeezed(100.0**2)
    run = scene.simulate(duration=20.0, solver=ao.Adaptive(rtol=1e-11))
    assert collisions(run) == 314
    assert run.error.energy < 1e-9
    # In the plane of √M V and √m v a collision mirrors, the wall mirrors: both turn by one angle.
    out = -math.cos(157 * 2.0 * math.atan(0.01))
    assert run[heavy].velocity[-1] == pytest.approx(out, rel=1e-6)


def test_a_ball_bounces_until_it_rests():
    law = ao.HuntCrossley(k=1e8, damping=2.0)
    scene, ball, _ = bouncing(law=law)
    run = scene.simulate(duration=3.0, solver=ao.Adaptive(rtol=1e-6))
    assert run.in_contact_at_end
    assert len(run.contacts[0].intervals) > 50
    depth = (MASS * EARTH / law.k) ** (2 / 3)
    assert run[ball].displacement[-1] == pytest.approx(1e-3 + depth, abs=0.02 * depth)
    assert run.energy.contact[-1] + run.energy.dissipated[-1] == pytest.approx(
        run.energy.work[-1], rel=1e-5
    )


# ---------------------------------------------------------------------- loads and rest


def test_a_load_that_lifts_a_ball_off_its_floor():
    """Pressed on by its weight; the load grows straight until nothing is left of that."""
    stiffness, rise = 1e6, 40.0
    scene = ao.Scene(gravity=EARTH)
    ball, floor = scene.add(BALL), scene.add(WALL)
    scene.connect(ball, floor, ao.Linear(k=stiffness))
    scene.apply(ball, force=([0.0, 1.0], [0.0, -rise]))
    weight, omega = MASS * EARTH, math.sqrt(stiffness / MASS)

    def depth(t):
        return (weight - rise * t + rise * math.sin(omega * t) / omega) / stiffness

    off = scipy.optimize.brentq(depth, 0.0, 2.0 * weight / rise, xtol=1e-16)
    run = scene.simulate(duration=2.0 * off, solver=ao.Adaptive(rtol=1e-10), preload=True)
    (start, end), *_ = run.contacts[0].intervals
    assert start == 0.0
    assert end == pytest.approx(off, rel=1e-9)
    assert run.contacts[0].force[0] == pytest.approx(weight, rel=1e-11)
    assert run.error.energy < 1e-9


def pressed(body, law, times, forces, rtol=1e-8):
    """The largest force of a body that touches a wall at rest under a load that rises."""
    scene = ao.Scene()
    ball, wall = scene.add(body), scene.add(WALL)
    contact = scene.connect(ball, wall, law)
    scene.apply(ball, force=(times, forces))
    run = scene.simulate(duration=4e-3, solver=ao.Adaptive(rtol=rtol))
    assert abs(run.error.energy) < 10.0 * rtol
    return run.contacts[contact].peak_force


@pytest.mark.parametrize("start", [0.0, 3e-5])
@pytest.mark.parametrize("seat", [math.inf, 1e8, 1e6])
def test_a_load_that_rises_from_nothing_presses_a_body_at_touch(start, seat):
    """A mass, alone or behind a spring whose end touches without mass, and a linear law."""
    mass, k, top, rise = 1.0, 1e7, 1000.0, 1e-4
    body = ao.rigid(mass) if math.isinf(seat) else ao.AOModel(m0=0.0, k0=0.0, m=[mass], k=[seat])
    share = 1.0 if math.isinf(seat) else seat / (seat + k)
    omega = math.sqrt(share * k / mass)
    swing = top / rise / omega * 2.0 * math.sin(omega * rise / 2.0)
    peak = pressed(body, ao.Linear(k), [start, start + rise, 1.0], [0.0, top, top])
    assert peak == pytest.approx(top + share * swing, rel=1e-8)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-11])
def test_a_weight_that_shakes_on_its_spring_for_a_thousand_periods_keeps_in_time(rtol):
    """In one contact that never opens: closed form of a weight, and a load that rises beside it."""
    mass, k, top = 0.1, 1e6, 50.0
    omega = math.sqrt(k / mass)
    period = 2.0 * math.pi / omega
    scene = ao.Scene(gravity=EARTH)
    weight, floor = scene.add(ao.rigid(mass)), scene.add(WALL)
    contact = scene.connect(weight, floor, ao.Linear(k))
    scene.apply(weight, force=([0.0, period / 4.0, 1e9], [0.0, top, top]))
    run = scene.simulate(duration=1000 * period, solver=ao.Adaptive(rtol=rtol))

    def ramp(since):
        return np.maximum(since, 0.0) - np.where(since > 0.0, np.sin(omega * since) / omega, 0.0)

    times = np.linspace(990.0, 1000.0, 400) * period
    rise = top / (period / 4.0) / k
    exact = mass * EARTH / k * (1.0 - np.cos(omega * times))
    exact += rise * (ramp(times) - ramp(times - period / 4.0))
    error = np.abs(run.at(times)[weight].displacement - exact).max() / exact.max()
    assert len(run.contacts[contact].intervals) == 1
    assert error <= rtol


def test_a_free_mass_under_a_force_of_straight_pieces():
    times, forces = [1e-3, 2e-3, 4e-3], [0.0, 6.0, -2.0]
    scene = ao.Scene()
    ball = scene.add(BALL, velocity=0.5)
    scene.apply(ball, force=(times, forces))
    scene.apply(ball, force=1.5)
    for solver in (ao.Adaptive(rtol=1e-10), ao.Newmark(dt=1e-5)):
        run = scene.simulate(duration=6e-3, solver=solver)
        impulse = 3e-3 + 2.0 * 2e-3 - 2.0 * 2e-3 + 1.5 * 6e-3
        assert run[ball].velocity[-1] == pytest.approx(0.5 + impulse / MASS, rel=1e-11)
        assert run.contacts == ()
        assert run.error.energy < 1e-9


def test_a_constrained_body_deflects_under_gravity_and_a_free_one_falls():
    held, free = slender_body(("xmin",)), slender_body(())
    tip = held.contact(point=(0.3, 0.01, 0.02), direction=(0.0, 0.0, 1.0), radius=0)
    weight = free.M @ free.translation((0.0, 0.0, 1.0)) * -EARTH
    pull = weight[np.repeat(free.nodes[:, 0] > 0.0, 3)]
    deflection = tip.b @ scipy.sparse.linalg.spsolve(held.K.tocsc(), pull)
    scene = ao.Scene(gravity=-EARTH)
    beam = scene.add(ao.antioscillators(tip))
    loose = scene.add(
        ao.antioscillators(free.contact(point=(0.3, 0.01, 0.02), direction=(0, 0, 1), radius=0))
    )
    run = scene.simulate(duration=1e-2, solver=ao.Adaptive(rtol=1e-9))
    assert run[loose].centre_velocity[-1] == pytest.approx(-EARTH * 1e-2, rel=1e-9)
    # Let go from straight, the beam swings about where it would hang.
    assert run[beam].displacement.min() == pytest.approx(2.0 * deflection, rel=0.1)
    still = ao.Scene(gravity=-EARTH)
    hung = still.add(ao.antioscillators(tip))
    rest = still.simulate(duration=1e-2, solver=ao.Adaptive(rtol=1e-9), preload=True)
    np.testing.assert_allclose(rest[hung].displacement, deflection, rtol=1e-8)
    by_newmark = still.simulate(duration=1e-3, solver=ao.Newmark(dt=1e-5), preload=True)
    np.testing.assert_allclose(by_newmark[hung].displacement, deflection, rtol=1e-8)


def test_a_stack_at_rest_stays_at_rest():
    """Every contact carries the weight above it."""
    scene = ao.Scene(gravity=EARTH)
    stack = [scene.add(ao.rigid(mass=mass)) for mass in (0.1, 0.2, 0.4)]
    beam = scene.add(ao.antioscillators(midspan(slender_body()), n=4))
    for one, other in itertools.pairwise([*stack, beam]):
        scene.connect(one, other, HERTZ)
    for solver in (ao.Adaptive(rtol=1e-9), ao.Newmark(dt=1e-6)):
        run = scene.simulate(duration=1e-3, solver=solver, preload=True)
        for contact, mass in zip(run.contacts, (0.1, 0.3, 0.7), strict=True):
            np.testing.assert_allclose(contact.force, mass * EARTH, rtol=1e-7)


@pytest.mark.filterwarnings("ignore:gravity has no effect")
def test_damped_bodies_under_loads_balance_and_newmark_tends_to_them():
    damped = ao.AOModel(
        m0=2e-2, k0=3e5, m=[0.01, 0.1], k=[4e6, 1e6], damping=ao.Rayleigh(alpha=20.0, beta=1e-6)
    )
    scene = ao.Scene(gravity=EARTH)
    ball, beam = scene.add(BALL, velocity=1.0), scene.add(damped)
    scene.connect(ball, beam, ao.HuntCrossley(k=1e9, damping=0.3))
    scene.apply(beam, force=([0.0, 1e-3], [0.0, -300.0]))
    exact = scene.simulate(duration=1e-3, solver=ao.Adaptive(rtol=1e-11))
    assert exact.error.energy < 1e-9
    errors = []
    for dt in (4e-7, 2e-7):
        run = scene.simulate(duration=1e-3, solver=ao.Newmark(dt=dt, estimate=False))
        off = velocities(run, (ball, beam)) - velocities(exact, (ball, beam))
        errors.append(np.abs(off).max())
    assert exact.energy.dissipated[-1] > 1e-3 * exact.energy.kinetic[0]
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


# ---------------------------------------------------------------------- at the same time


def test_a_mirror_image_stays_one():
    """Two balls strike a third, and it two more, from both sides at once."""
    scene = ao.Scene()
    speeds = (1.0, 0.0, 0.0, 0.0, -1.0)
    places = (-2e-4, -1e-4, 0.0, 1e-4, 2e-4)
    balls = [scene.add(BALL, velocity=v, position=x) for v, x in zip(speeds, places, strict=True)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, HERTZ)
    run = scene.simulate(duration=1e-3, solver=ao.Adaptive(rtol=1e-9))
    out = velocities(run, balls)
    # Rounding says which of two touches at one time comes first, to the error of a step.
    assert np.abs(out + out[::-1]).max() < 1e-2 * 1e-9
    assert abs(run[balls[2]].displacement).max() < 1e-2 * 1e-9 * 1e-5
    assert [len(c.intervals) for c in run.contacts] == [
        len(c.intervals) for c in run.contacts[::-1]
    ]


@pytest.mark.parametrize("gap", [0.0, 3e-5])
def test_one_ball_on_two_at_once_is_one_on_both_together(gap):
    """Twins behave alike to rounding, and as one twice as heavy behind twice the spring."""
    scene = ao.Scene()
    ball = scene.add(BALL, velocity=1.0)
    twins = [scene.add(BALL) for _ in range(2)]
    for twin in twins:
        scene.connect(ball, twin, HERTZ, gap=gap)
    run = scene.simulate(duration=2e-4, solver=ao.Adaptive(rtol=1e-10))
    one, other = run.contacts
    np.testing.assert_allclose(one.force, other.force, rtol=0, atol=1e-11 * one.peak_force)
    alone = ao.simulate(
        projectile=BALL,
        target=ao.rigid(mass=2 * MASS),
        law=ao.Hertz(k=2 * K),
        velocity=1.0,
        gap=gap,
        duration=2e-4,
        solver=ao.Adaptive(rtol=1e-10),
    )
    assert velocities(run, [ball])[0] == pytest.approx(alone.rebound_velocity, rel=1e-9)
    assert 2.0 * one.peak_force == pytest.approx(alone.peak_force, rel=1e-9)


# ---------------------------------------------------------------------- what is refused


def pair():
    scene = ao.Scene()
    return scene, scene.add(BALL, velocity=1.0, name="ball"), scene.add(BEAM)


def test_senseless_connections_are_named():
    scene, ball, beam = pair()
    with pytest.raises(ao.InputError):
        scene.connect(ball, ball, HERTZ)
    with pytest.raises(ao.InputError, match=r"^b"):
        scene.connect(ball, beam.port(1), HERTZ)
    with pytest.raises(ao.InputError, match=r"^body"):
        scene.connect(scene.add(WALL), scene.add(WALL), HERTZ)


def test_handles_of_another_scene_are_refused():
    (scene, ball, beam), (_, stranger, _) = pair(), pair()
    with pytest.raises(ao.InputError, match="scene"):
        scene.connect(stranger, beam, HERTZ)
    with pytest.raises(ao.InputError, match=r"^body"):
        scene.apply(stranger, force=1.0)
    copied, same = pickle.loads(pickle.dumps((scene, ball)))
    assert copied.connect(same, beam, HERTZ) == 0


def test_a_run_is_read_by_its_own_handles_only():
    scene, (ball, *_) = row_of_balls(2)
    others, (stranger, *_) = row_of_balls(3)
    run = scene.simulate(duration=1e-4)
    assert run[ball].velocity[0] == 1.0
    assert pickle.loads(pickle.dumps(run))[pickle.loads(pickle.dumps(ball))].velocity[0] == 1.0
    with pytest.raises(ao.InputError, match="scene"):
        run[stranger]
    # Where there are as many bodies as in this run, and more.
    with pytest.raises(ao.InputError, match="scene"):
        run[others.add(BALL)]
    with pytest.raises(ao.InputError, match="scene"):
        ao.simulate(projectile=BALL, target=WALL, law=HERTZ, velocity=1.0, duration=1e-4)[ball]


def test_a_wall_takes_no_load():
    scene = ao.Scene()
    with pytest.raises(ao.InputError, match=r"^body"):
        scene.apply(scene.add(WALL), force=1.0)


@pytest.mark.parametrize("damping", [None, ao.Rayleigh(alpha=70.0)], ids=["undamped", "damped"])
def test_bodies_that_fall_side_by_side_do_not_press_each_other(damping):
    scene = ao.Scene(gravity=EARTH)
    first, second = (
        scene.add(ao.AOModel(m0=m0, m=[2.6e-4], k=[217.0], damping=damping), velocity=0.1)
        for m0 in (5.8e-4, 9.3e-8)
    )
    scene.connect(first, second, HERTZ)
    run = scene.simulate(duration=0.1)
    assert run.contacts[0].intervals == []
    assert run.contacts[0].peak_force == 0.0
    rate = 0.0 if damping is None else 70.0  # α m on each element: v' = g - α v
    fallen = 0.1 + EARTH * 0.1 if not rate else EARTH / rate + (0.1 - EARTH / rate) * np.exp(-7.0)
    assert [run[body].velocity[-1] for body in (first, second)] == pytest.approx([fallen] * 2)


def test_bodies_that_part_from_zero_beside_a_blow_have_not_touched():
    scene = ao.Scene()
    striker = scene.add(BALL, velocity=3.0)
    struck, leaving = scene.add(BALL), scene.add(BALL, velocity=1e-3)
    scene.connect(striker, struck, HERTZ)
    scene.connect(struck, leaving, HERTZ)
    run = scene.simulate(duration=5e-4)
    ((start, _),) = run.contacts[1].intervals
    assert start > 0.0


def test_gravity_on_a_held_star_of_numbers_says_that_it_does_nothing():
    scene = ao.Scene(gravity=EARTH)
    beam = scene.add(BEAM)
    with pytest.warns(ao.AOImpactWarning, match=r"^gravity"):
        run = scene.simulate(duration=1e-3)
    assert not run[beam].displacement.any()


def test_senseless_scenes_are_named():
    with pytest.raises(ao.InputError, match="scene"):
        ao.Scene().simulate(duration=1.0)
    scene, ball, beam = pair()
    scene.connect(ball, beam, HERTZ, gap=-1e-6)
    with pytest.raises(ao.InputError, match=r"^contact"):
        scene.simulate(duration=1e-3)


@pytest.mark.parametrize("connected", [False, True])
def test_a_ball_that_nothing_holds_has_no_rest(connected):
    scene = ao.Scene(gravity=-EARTH)
    ball = scene.add(BALL)
    if connected:
        scene.connect(ball, scene.add(WALL), HERTZ)  # it falls away from it
    with pytest.raises(ao.ConvergenceError, match=r"^preload"):
        scene.simulate(duration=1.0, preload=True)


# ---------------------------------------------------------------------- what a run is


def test_without_contacts_bodies_fly():
    scene = ao.Scene()
    ball, beam = scene.add(BALL, velocity=1.0, position=3.0), scene.add(BEAM, velocity=2.0)
    run = scene.simulate(duration=1e-2)
    np.testing.assert_allclose(run[ball].displacement, run.t, rtol=1e-14)
    assert run.contacts == ()
    assert not run.in_contact_at_end
    assert run[beam].velocity.min() < 0.0
    assert run.error.energy < 1e-12


def test_a_run_read_at_other_times_is_the_same_run():
    scene, balls = row_of_balls(5)
    run = scene.simulate(duration=4e-4, solver=ao.Adaptive(rtol=1e-9))
    few = run.at([0.0, 1e-4, 4e-4])
    np.testing.assert_array_equal(few.t, [0.0, 1e-4, 4e-4])
    assert few[balls[4]].velocity[-1] == run[balls[4]].velocity[-1]
    assert few.contacts[2].peak_force == run.contacts[2].peak_force
    assert few.events == run.events
    whole = np.interp(1e-4, run.t, run.contacts[2].force)
    assert few.contacts[2].force[1] == pytest.approx(whole, rel=1e-3)
    with pytest.raises(ao.InputError, match=r"^times"):
        run.at([5e-4])
    with pytest.raises(ao.InputTypeError):
        run["ball"]
    with pytest.raises(ao.InputError, match=r"^body"):
        run[5]


@pytest.mark.slow
def test_a_body_between_two_others_passes_the_blow_on_whatever_is_left_out():
    """Three like balls in a row: the middle one is touched on both sides."""
    body = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.008), STEEL)
    front, back = (0, 0, 0.01), (0, 0, -0.01)
    runs = []
    for given in ({}, {"direction": (0, 0, -1)}):
        scene = ao.Scene()
        one = scene.add(body.contact(point=back, **given), velocity=1.0)
        two = scene.add([body.contact(point=place, **given) for place in (front, back)])
        three = scene.add(body.contact(point=front, **given))
        scene.connect(one, two.port(0))
        scene.connect(two.port(1), three)
        # As meshed: finer elements are solved for roughly, and the directions differ by 2e-6.
        run = scene.simulate().beside
        runs.append([contact.events.peak_force for contact in run.contacts])
    assert runs[0] == pytest.approx(runs[1], rel=1e-6)
    assert runs[0][1] > 0.8 * runs[0][0]


@pytest.mark.filterwarnings("ignore:target. the patch has a radius")
def test_a_record_that_is_left_out_is_no_longer_than_the_impact():
    """On a soft cantilever the contact lasts far longer than of rigid bodies."""
    mesh = ao.box_mesh((0.4, 0.02, 0.005), (40, 2, 1), kind="hexahedron20")
    beam = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    tip = beam.contact(point=(0.3, 0.01, 0.005))
    star = ao.antioscillators(tip, 16, method="krylov", contact_time=1.6e-4, duration=5e-3)
    hit = ao.simulate(projectile=ao.ball(0.01, STEEL), target=star, velocity=0.2)
    assert 2.0 <= hit.duration / hit.contacts[-1][1] < 2.1
    assert hit.duration < 20e-3


def test_a_drop_from_rest_needs_no_duration():
    """50 mm: it meets the floor after √(2h/g), at √(2gh), where m v²/2 = k δ^2.5/2.5."""
    gravity, height, mass, law = 9.81, 0.05, 0.03, ao.Hertz(k=1e9)
    scene = ao.Scene(gravity=gravity)
    ball, floor = scene.add(ao.rigid(mass=mass)), scene.add(ao.rigid(mass=math.inf))
    scene.connect(ball, floor, law, gap=height)
    run = scene.simulate()
    (first, *_) = run.contacts[0].intervals
    assert first[0] == pytest.approx(math.sqrt(2.0 * height / gravity), rel=1e-6)
    energy = mass * gravity * height
    assert run.contacts[0].peak_force == pytest.approx(
        law.k * (2.5 * energy / law.k) ** 0.6, rel=1e-3
    )
    assert run.duration < 1.0


def test_a_duration_that_cannot_be_foreseen_says_why():
    scene = ao.Scene()
    ball, floor = scene.add(ao.rigid(mass=1.0)), scene.add(ao.rigid(mass=math.inf))
    scene.connect(ball, floor, ao.Hertz(k=1e9), gap=0.01)
    with pytest.raises(ao.InputError, match=r"^duration"):
        scene.simulate()


def test_all_degrees_of_freedom_damped_by_their_modes_die_away_as_in_closed_form() -> None:
    k, m, zeta, force = 5e5, 0.2, 0.05, 100.0
    K, M = np.array([[k]]), np.array([[m]])
    body = ao.FEModel(K=K, M=M, damping=ao.ModalDamping(zeta))
    scene = ao.Scene()
    loaded = scene.add(ao.full(body.contact(dof=0)))
    scene.apply(loaded, force=force)
    run = scene.simulate(duration=0.01, solver=ao.Newmark(dt=2e-6))
    omega = math.sqrt(k / m)
    fast, decay = omega * math.sqrt(1.0 - zeta**2), np.exp(-zeta * omega * run.t)
    ringing = np.cos(fast * run.t) + zeta * omega / fast * np.sin(fast * run.t)
    exact = force / k * (1.0 - decay * ringing)
    np.testing.assert_allclose(run[loaded].displacement, exact, atol=1e-5 * force / k)


def test_a_copy_of_a_model_with_other_numbers_is_one_of_these() -> None:
    """A body of finite elements and then some mass on its contact: a star of numbers."""
    chain = ao.FEModel(K=np.array([[2e6, -1e6], [-1e6, 1e6]]), M=np.diag([0.5, 0.5]))
    star = ao.antioscillators(chain.contact(dof=1))
    heavier = dataclasses.replace(star, m0=star.m0 + 0.3)
    numbers = ao.AOModel(m0=star.m0 + 0.3, k0=star.k0, m=star.m, k=star.k)
    hits = [
        ao.simulate(ao.rigid(mass=0.1), one, 1.0, law=ao.Linear(k=1e6), duration=2e-3)
        for one in (heavier, numbers, star)
    ]
    assert hits[0].peak_force == pytest.approx(hits[1].peak_force, rel=1e-12)
    assert hits[2].peak_force < 0.99 * hits[0].peak_force
