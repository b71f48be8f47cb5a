"""Velocities in three directions and friction: what is refused, and what stays as it was."""

from __future__ import annotations

import math

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BALL, WALL = ao.ball(0.01, STEEL), ao.wall(STEEL)
RULE = ao.Newmark(dt=2e-7, estimate=False)
BLOCK = ao.FEModel.from_mesh(ao.box_mesh((0.02, 0.02, 0.02), (2, 2, 2), kind="hexahedron20"), STEEL)
TOP = BLOCK.contact(point=(0.01, 0.01, 0.02))
DOWN = (0.0, 0.3, -1.0)


def test_all_contacts_of_a_scene_need_friction():
    scene = ao.Scene()
    ball, wall = scene.add(BALL, velocity=DOWN), scene.add(WALL)
    scene.connect(ball, wall)
    with pytest.raises(ao.InputError, match="friction=0"):
        scene.simulate(duration=1e-4)


def test_smooth_surfaces_leave_the_tangential_velocity():
    hit = ao.simulate(BALL, WALL, DOWN, friction=0.0, solver=RULE)
    straight = ao.simulate(BALL, WALL, 1.0, solver=RULE)
    np.testing.assert_allclose(hit.force, straight.force, rtol=0, atol=1e-9 * hit.peak_force)
    assert hit.projectile.final_velocity == pytest.approx([0.0, 0.3, 1.0], abs=1e-4)
    assert hit.tangential_restitution == pytest.approx(1.0)
    assert not hit.friction_force.any()
    assert not hit.projectile.final_spin.any()


@pytest.mark.parametrize("law", [ao.HuntCrossley(1e10, 0.4), ao.Thornton(1e10, 100.0)])
def test_smooth_surfaces_take_any_law(law):
    hit = ao.simulate(BALL, WALL, DOWN, friction=0, law=law, solver=RULE, duration=2e-4)
    straight = ao.simulate(BALL, WALL, 1.0, law=law, solver=RULE, duration=2e-4)
    np.testing.assert_allclose(hit.force, straight.force, rtol=0, atol=1e-9 * hit.peak_force)
    assert hit.restitution == pytest.approx(straight.restitution)
    assert hit.tangential_restitution == pytest.approx(1.0)
    assert hit.energy.dissipated == pytest.approx(straight.energy.dissipated, abs=1e-12)
    assert hit.slip_intervals == hit.contacts


def test_back_spin_is_the_closed_form():
    # All slips: friction takes μ of the normal impulse 2 m v, and 5/2 of that over R of the spin.
    mu, spin, along = 0.1, np.array([0.0, -300.0, 50.0]), 0.4
    hit = ao.simulate(BALL, WALL, (along, 0, -1), friction=mu, spin=spin)
    assert hit.slip_intervals == hit.contacts
    after, turns = hit.projectile.final_velocity, hit.projectile.final_spin
    assert after == pytest.approx([along - 2 * mu, 0.0, 1.0], rel=1e-6, abs=1e-9)
    assert turns == pytest.approx(spin + np.array([0.0, 5 * mu / 0.01, 0.0]), rel=1e-6, abs=1e-6)
    assert "spin (0, -300, 50) rad/s" in repr(hit)


def test_spin_is_a_moving_contact_point():
    # A ball that spins is one that slides, in a frame that moves along.
    spin = np.array([30.0, 20.0, 0.0])
    along = np.cross(spin, [0.0, 0.0, -0.01])
    spun = ao.simulate(BALL, WALL, 1.0, friction=0.4, spin=spin, solver=RULE)
    slid = ao.simulate(BALL, WALL, (*along[:2], -1.0), friction=0.4, solver=RULE)
    near = 1e-9 * np.abs(slid.friction_force).max()
    np.testing.assert_allclose(spun.friction_force, slid.friction_force, rtol=0, atol=near)


def test_a_spinning_block_of_finite_elements_is_the_rigid_one_in_its_first_moment():
    # Under a soft law: the momentum of K and M is that of the tensor of inertia.
    mesh = ao.box_mesh((0.02, 0.02, 0.02), (2, 2, 2), kind="hexahedron20")
    block = ao.FEModel.from_mesh(mesh, STEEL)
    mass, spin, law = block.mass, (20.0, -40.0, 5.0), ao.Linear(2e4)
    tip = block.contact(point=(0.01, 0.01, 0.0), radius=0)
    rigid = ao.rigid(mass, inertia=mass * 0.02**2 / 6.0, arm=(0, 0, -0.01))
    run = {"velocity": (0.1, 0, -1.0), "spin": spin, "friction": 0.3, "law": law}
    run |= {"duration": 8e-3, "solver": ao.Newmark(dt=1e-5, estimate=False)}
    elastic, hard = ao.simulate(tip, WALL, **run), ao.simulate(rigid, WALL, **run)
    assert elastic.peak_force == pytest.approx(hard.peak_force, rel=2e-3)
    for of in ("final_velocity", "final_spin"):
        found, right = (getattr(hit.projectile, of) for hit in (elastic, hard))
        np.testing.assert_allclose(found, right, rtol=0, atol=2e-3 * np.abs(right).max())


@pytest.mark.slow
def test_a_speed_with_friction_is_straight():
    hit = ao.simulate(BALL, TOP, 1.0, friction=0.5, solver=RULE, duration=1e-4)
    straight = ao.simulate(BALL, TOP, (0, 0, -1.0), friction=0.5, solver=RULE, duration=1e-4)
    assert (hit.force == straight.force).all()
    assert math.isnan(hit.tangential_restitution)


def test_an_impact_along_one_direction_has_no_vectors():
    hit = ao.simulate(BALL, WALL, 1.0)
    with pytest.raises(ao.InputError, match="friction"):
        hit.friction_force  # noqa: B018
    with pytest.raises(ao.InputError, match="friction"):
        hit.projectile.final_velocity  # noqa: B018


@pytest.mark.slow
def test_axes_are_those_of_the_target():
    # The same impact on the top and on a side of the block, turned with it.
    side = BLOCK.contact(point=(0.02, 0.01, 0.01))
    above, beside = (
        ao.simulate(BALL, place, velocity, friction=0.2, solver=RULE, duration=1e-4)
        for place, velocity in ((TOP, (0.0, 0.3, -1.0)), (side, (-1.0, 0.3, 0.0)))
    )
    turn = np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]])  # z to x
    assert beside.peak_force == pytest.approx(above.peak_force, rel=1e-3)
    here = beside.projectile.final_velocity
    assert here == pytest.approx(turn @ above.projectile.final_velocity, abs=1e-3)
    assert beside.projectile.final_spin == pytest.approx(
        turn @ above.projectile.final_spin, abs=1e-3 * np.abs(above.projectile.final_spin).max()
    )


def test_two_like_balls_exchange_their_tangential_impulse():
    hit = ao.simulate(BALL, BALL, DOWN, friction=0.3, solver=RULE)
    momentum = hit.projectile.final_velocity + hit.target.final_velocity
    assert momentum == pytest.approx(DOWN, abs=1e-12)
    assert hit.projectile.final_spin == pytest.approx(hit.target.final_spin, rel=1e-12)


def test_histories_and_summary_have_friction(tmp_path):
    hit = ao.simulate(BALL, WALL, DOWN, friction=0.3, solver=RULE)
    hit.to_csv(tmp_path / "hit.csv")
    header = (tmp_path / "hit.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "friction force y [N]" in header
    assert "stuck [1]" in header
    assert "friction energy [J]" in header
    assert "projectile spin y [rad/s]" in header
    assert "target spin y [rad/s]" not in header  # it is held
    np.testing.assert_allclose(hit.projectile.spin[-1], hit.projectile.final_spin, rtol=1e-9)
    assert hit.value("projectile.final_spin.1") == hit.projectile.final_spin[1]
    with pytest.raises(ao.InputTypeError, match=r"projectile.final_spin.0"):
        hit.value("projectile.final_spin")
    for name, words in {
        "final_velocity.1": r"^name",
        "projectile.final_velocity.3": r"^name",
        "stuck": r"^name",
    }.items():
        with pytest.raises((ao.InputError, ao.InputTypeError), match=words):
            hit.value(name)
    assert "final spin" in repr(hit)
    assert hit.value("peak_friction_force") == pytest.approx(
        np.linalg.norm(hit.friction_force, axis=1).max()
    )
    stick = hit.stuck[(hit.t > 2e-5) & (hit.t < 4e-5)]
    assert ((stick > 0.0) & (stick <= 1.0)).all()
    assert math.isclose(hit.energy.friction[-1], hit.energy.dissipated[-1])


@pytest.mark.parametrize("solver", [None, ao.Newmark()])
def test_a_spin_that_lifts_the_contact_point_at_once_is_told(solver):
    # The arm is 1 cm to the side: the point rises at 3 m/s, and the centre falls at 1 m/s.
    body = ao.rigid(0.02, inertia=1e-6, arm=(0.01, 0, -0.005))
    with pytest.warns(ao.AOImpactWarning, match=r"^projectile"):
        hit = ao.simulate(
            body,
            WALL,
            (0, 0, -1.0),
            spin=(0, -300.0, 0),
            law=ao.Hertz(k=1e9),
            friction=0.1,
            solver=solver,
        )
    assert hit.contact_count == 0
    assert hit.duration < 1e-2  # not until bodies that have flown away would meet
    assert hit.projectile.final_velocity == pytest.approx([0.0, 0.0, -1.0])


def test_slip_lies_within_contact():
    hit = ao.simulate(BALL, WALL, DOWN, friction=0.2, gap=1e-6)
    ((start, end),) = hit.contacts
    slips = hit.slip_intervals
    assert len(slips) == 2  # at first, and at last
    assert start == slips[0][0] < slips[0][1] < slips[1][0] < slips[1][1] == end
    assert hit.stick_intervals == [(slips[0][1], slips[1][0])]


@pytest.fixture(scope="module")
def held():
    mesh = ao.box_mesh((0.02, 0.02, 0.02), (2, 2, 2), kind="hexahedron20")
    block = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("zmin", "xyz")])
    return block.contact(point=(0.01, 0.01, 0.02))


@pytest.mark.slow
def test_supports_and_contact_change_the_momentum_of_a_reduced_body(held):
    hit = ao.simulate(BALL, held, DOWN, friction=0.3, duration=1.5e-4)
    end = hit.contacts[-1][1]
    times = hit.t[hit.t <= end]
    pushed = hit.target.reaction(times=times).force + hit.friction_force[: len(times)]
    pushed[:, 2] -= hit.force[: len(times)]
    gained = np.trapezoid(pushed, times, axis=0)
    passed = np.trapezoid(hit.force, hit.t)
    momentum = held.body.mass * hit.target.final_velocity
    np.testing.assert_allclose(gained, momentum, rtol=0, atol=1e-3 * passed)


@pytest.mark.slow
def test_points_of_a_reduced_body_move_as_those_of_all_of_it(held):
    at = {"point": (0.02, 0.01, 0.015), "direction": (1, 0, 0)}
    hit, full = (
        ao.simulate(BALL, body, DOWN, friction=0.3, duration=1.5e-4)
        for body in (held, ao.full(held))
    )
    times = np.linspace(0.0, 1.5e-4, 40)
    runs = (hit.beside, full)  # of the given elements
    found, right = (of.target.probe(**at, times=times).displacement for of in runs)
    np.testing.assert_allclose(found, right, rtol=0, atol=0.02 * abs(right).max())


def test_a_normal_blow_with_friction_is_that_of_smooth_surfaces(held):
    """A symmetric body gives no friction, however many oscillations its modes make in contact."""
    places = ao.simulate(BALL, held, (0, 0, -1), friction=0.2, rtol=0.05).models[1].tips
    model = ao.interface(places, n=60, contact_time=6e-5)
    fine = {"duration": 1e-4, "solver": ao.Adaptive(rtol=1e-7)}
    hit, smooth = (ao.simulate(BALL, model, (0, 0, -1), friction=mu, **fine) for mu in (0.2, 0.0))
    assert abs(hit.friction_force).max() < 1e-3 * hit.peak_force
    assert hit.impulse == pytest.approx(smooth.impulse, rel=1e-6)
    assert hit.peak_force == pytest.approx(smooth.peak_force, rel=2e-4)
