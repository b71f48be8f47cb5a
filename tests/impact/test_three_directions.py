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
SHEET = ao.FEModel.from_mesh(ao.sheet_mesh((0.1, 0.1), (4, 4)), ao.Shell(1e-3, STEEL))
OSCILLATOR = ao.AOModel(m0=0.1, k0=1e5)
DOWN = (0.0, 0.3, -1.0)


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"velocity": DOWN}, "friction=0"),
        ({"velocity": DOWN, "friction": -0.1}, "friction"),
        ({"velocity": (0.0, 1.0), "friction": 0.1}, "velocity"),
        ({"velocity": (0, 0, 0), "friction": 0.1}, "velocity"),
        ({"velocity": (0, 0.3, 1.0), "friction": 0.1}, "does not approach"),
        ({"velocity": DOWN, "friction": 0.1, "target": OSCILLATOR}, "one direction"),
        ({"velocity": DOWN, "friction": 0.1, "solver": ao.Adaptive()}, "Newmark"),
        (
            {
                "velocity": DOWN,
                "friction": 0.1,
                "law": ao.Hertz(1e9),
                "projectile": TOP,
                "target": TOP,
            },
            "same side",
        ),
        ({"velocity": DOWN, "friction": 0.1, "law": ao.KelvinVoigt(1e8, 10.0)}, "elastic"),
        (
            {
                "velocity": DOWN,
                "friction": 0.1,
                "law": ao.Hertz(1e9),
                "target": SHEET.contact(point=(0.05, 0.05, 0.0)),
            },
            "shells",
        ),
        (
            {
                "velocity": (1.0, 0, 0),
                "friction": 0.1,
                "law": ao.Hertz(1e9),
                "target": BLOCK.contact(point=(0.01, 0.01, 0.02), direction=(0.5, 0, -1.0)),
            },
            "along the normal",
        ),
        (
            {
                "velocity": DOWN,
                "friction": 0.1,
                "projectile": BLOCK.contact(point=(0.0, 0.01, 0.01)),
                "target": TOP,
                "law": ao.Hertz(1e9),
            },
            "turn the mesh",
        ),
    ],
)
def test_refusals_name_the_cure(keywords, words):
    law = {"law": ao.Hertz(k=1e10)} if keywords.get("target") is OSCILLATOR else {}
    with pytest.raises(ao.InputError, match=words):
        ao.simulate(**{"projectile": BALL, "target": WALL, **law, **keywords})


@pytest.mark.parametrize(
    "given",
    [
        {"inertia": -1.0},
        {"inertia": (1.0, 1.0, 3.0)},
        {"inertia": np.ones((2, 2))},
        {"arm": (0, 0, 1.0)},
        {"inertia": 1.0, "arm": (0, 1.0)},
    ],
)
def test_bodies_that_cannot_be_are_refused(given):
    with pytest.raises(ao.InputError):
        ao.rigid(0.1, **given)


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
    assert "final spin" in repr(hit)
    assert hit.value("peak_friction_force") == pytest.approx(
        np.linalg.norm(hit.friction_force, axis=1).max()
    )
    stick = hit.stuck[(hit.t > 2e-5) & (hit.t < 4e-5)]
    assert ((stick > 0.0) & (stick <= 1.0)).all()
    assert math.isclose(hit.energy.friction[-1], hit.energy.dissipated[-1])


def test_slip_lies_within_contact():
    hit = ao.simulate(BALL, WALL, DOWN, friction=0.2, gap=1e-6)
    ((start, end),) = hit.contacts
    slips = hit.slip_intervals
    assert len(slips) == 2  # at first, and at last
    assert start == slips[0][0] < slips[0][1] < slips[1][0] < slips[1][1] == end


@pytest.fixture(scope="module")
def held():
    mesh = ao.box_mesh((0.02, 0.02, 0.02), (2, 2, 2), kind="hexahedron20")
    block = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("zmin", "xyz")])
    return block.contact(point=(0.01, 0.01, 0.02))


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


def test_points_of_a_reduced_body_move_as_those_of_all_of_it(held):
    at = {"point": (0.02, 0.01, 0.015), "direction": (1, 0, 0)}
    hit, full = (
        ao.simulate(BALL, body, DOWN, friction=0.3, duration=1.5e-4)
        for body in (held, ao.full(held))
    )
    times = np.linspace(0.0, 1.5e-4, 40)
    found, right = (of.target.probe(**at, times=times).displacement for of in (hit, full))
    np.testing.assert_allclose(found, right, rtol=0, atol=0.02 * abs(right).max())


def test_scene_files_have_velocities_in_three_directions_and_friction(tmp_path):
    path = tmp_path / "oblique.toml"
    path.write_text(
        """\
[materials.steel]
E = 210e9
nu = 0.3
rho = 7800

[bodies.ball]
ball = 0.01
material = "steel"

[bodies.floor]
wall = "steel"

[impact]
projectile = "ball"
target = "floor"
velocity = [0.0, 0.3, -1.0]
friction = 0.3
solver = { type = "Newmark", dt = 2e-7, estimate = false }
""",
        encoding="utf-8",
    )
    hit, same = (
        ao.read_scene(path).simulate(),
        ao.simulate(BALL, WALL, DOWN, friction=0.3, solver=RULE),
    )
    assert (hit.friction_force == same.friction_force).all()
