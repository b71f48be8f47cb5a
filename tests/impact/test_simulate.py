"""`simulate`: gaps, misses, bodies hit off their centre, and arguments that make no sense."""

import math

import numpy as np
import pytest

import aoimpact as ao

BALL = ao.rigid(mass=0.0327)
LAW = ao.Hertz(k=1e10)


def hit(**changes):
    arguments = {
        "projectile": BALL,
        "target": BALL,
        "law": LAW,
        "velocity": 1.0,
        "duration": 100e-6,
        "solver": ao.Newmark(dt=1e-7),
    }
    return ao.simulate(**(arguments | changes))


@pytest.mark.slow
def test_a_model_made_before_the_impact_suits_a_plate():
    """A patch as wide as an element of 7.5 mm, of 6 mm depth, gives 2.9 % more."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    ball, place = ao.ball(0.01, steel), (0.03, 0.03, 0.006)
    coarse, fine = (
        ao.FEModel.from_mesh(
            ao.box_mesh((0.06, 0.06, 0.006), (n, n, layers), kind="hexahedron20"), steel
        ).contact(point=place)
        for n, layers in ((8, 1), (12, 2))
    )
    made = ao.simulate(ball, ao.antioscillators(coarse, n=30), 1.0)
    right = ao.simulate(ball, fine, 1.0)
    assert made.peak_force == pytest.approx(right.peak_force, rel=0.008)


def test_a_gap_only_delays_the_impact():
    now, later = hit(), hit(gap=50e-6, duration=150e-6)
    assert later.contacts[0][0] == pytest.approx(50e-6, abs=1e-7)
    assert later.peak_force == pytest.approx(now.peak_force, rel=1e-5)
    assert later.contact_duration == pytest.approx(now.contact_duration, rel=1e-4)


@pytest.mark.parametrize("gap", [0.0, 1e-4])
def test_a_projectile_that_flies_away_is_refused(gap):
    with pytest.raises(ao.InputError, match=r"^velocity"):
        hit(velocity=-1.0, gap=gap)
    pair = {"projectile": ao.rigid(mass=1.0), "target": ao.rigid(mass=2.0)}
    case = pair | {"law": ao.Hertz(k=1e9), "velocity": -1.0, "duration": 1e-3}
    for keep in (None, "peak_force"):
        assert isinstance(ao.simulate_many([case], keep=keep)[0], ao.InputError)


@pytest.mark.parametrize("solver", [ao.Adaptive(), ao.Newmark(dt=2e-8)])
def test_a_projectile_on_a_spring_swings_back(solver):
    """Half a period of the spring later it is where it was, as fast as it was."""
    mass, spring, speed = 0.2, 1e6, 1.0
    swing = ao.simulate(
        projectile=ao.AOModel(m0=mass, k0=spring),
        target=ao.rigid(mass=math.inf),
        law=ao.Hertz(k=1e10),
        velocity=-speed,
        duration=1.8e-3,
        solver=solver,
    )
    assert swing.contacts[0][0] == pytest.approx(math.pi * math.sqrt(mass / spring), rel=1e-5)
    assert swing.peak_force == pytest.approx(
        (1.25 * mass * speed**2) ** 0.6 * 1e10**0.4, rel=1e-2
    )  # of the mass alone: the impact is short for the spring


def test_duration_is_covered_by_whole_steps():
    assert hit(duration=100e-6).t[-1] == pytest.approx(100e-6, rel=1e-12)
    assert len(hit(duration=100e-6).t) == 1001
    assert hit(duration=100.01e-6).t[-1] == 100.01e-6


@pytest.mark.filterwarnings("ignore:.*with_mesh")
def test_a_star_of_a_body_hit_off_its_centre_keeps_all_its_mass_and_energy():
    """A bar of two balls, hit at one of them: the other does not feel it at first."""
    nodes = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1e-3, 0.0], [0.5, 0.0, 1e-3]])
    spacing = nodes[:, None] - nodes
    K = np.zeros((12, 12))
    for i in range(4):
        for j in range(i):
            along = spacing[i, j] / np.linalg.norm(spacing[i, j])
            stretch = np.zeros(12)
            stretch[3 * i : 3 * i + 3], stretch[3 * j : 3 * j + 3] = along, -along
            K += 1e9 * np.outer(stretch, stretch)
    masses = np.repeat([1.0, 1.0, 1e-3, 1e-3], 3)
    body = ao.FEModel(K=K, M=np.diag(masses), nodes=nodes)
    tip = body.contact(point=(0.0, 0.0, 0.0), direction=(0.0, 1.0, 0.0), radius=0)
    star = ao.antioscillators(tip, 0)
    # Effective mass at the end: translation and rotation take part, the far ball does not move.
    assert star.static_mass < 1.01
    assert star.mass == pytest.approx(masses.sum() / 3, rel=1e-12)
    flying = hit(projectile=star, target=ao.rigid(mass=1.0), duration=1e-3)
    # Momentum of the bar's centre of mass and of the target.
    momentum = star.mass * flying.projectile.centre_velocity + flying.target.centre_velocity
    assert momentum[0] == pytest.approx(star.mass, rel=1e-9)
    assert np.ptp(momentum) < 1e-9 * star.mass
    assert flying.energy.total[0] == pytest.approx(0.5 * star.mass, rel=1e-9)
    # Newton's rule e = 1 holds at the contact point.
    approach = flying.projectile.velocity - flying.target.velocity
    assert approach[-1] == pytest.approx(-approach[0], rel=1e-4)


@pytest.mark.filterwarnings("ignore:projectile is touched along")
def test_a_partly_held_projectile_struck_obliquely_starts_alike_as_star_and_as_full_model():
    """Held along x it cannot translate along (1, 1, 0): both move as the static mode."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    mesh = ao.box_mesh((0.1, 0.02, 0.02), (6, 2, 2))
    body = ao.FEModel.from_mesh(mesh, steel, fixed=[("xmin", "x")])
    tip = body.contact(point=(0.1, 0.01, 0.01), direction=(1.0, 1.0, 0.0), radius=0)
    options = {"target": ao.rigid(mass=0.2), "duration": 400e-6, "solver": ao.Newmark(dt=1e-6)}
    full, star = (hit(projectile=of, **options) for of in (ao.full(tip), ao.antioscillators(tip)))
    assert star.energy.total[0] == pytest.approx(full.energy.total[0], rel=1e-9)
    assert star.peak_force == pytest.approx(full.peak_force, rel=1e-9)


def test_velocities_that_are_rounding_are_0() -> None:
    """A ball that comes along y and z has nothing along x, and does not turn about y or z."""
    ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))
    wall = ao.wall(ao.Material(E=70e9, nu=0.33, rho=2700))
    hit = ao.simulate(ball, wall, (0.0, 0.5, -1.0), friction=0.1)
    assert hit.projectile.final_velocity[0] == 0.0
    assert not hit.projectile.final_spin[1:].any()
    assert "inf" not in repr(hit.target)
    assert "not known" not in repr(hit)
