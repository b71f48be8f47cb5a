"""Scenes whose models are chosen for a quantity of interest: the true error is within rtol."""

import itertools
import math

import numpy as np
import pytest

import aoimpact as ao
from aoimpact import box_mesh

from twelve import as_meshed

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
HERTZ = ao.Hertz(k=1e10)
PLACES, SPEEDS, GAPS = (0.1, 0.15, 0.25), (1.0, 0.5, 0.8), (0.0, 1e-5, 5e-6)
DURATION = 2.5e-4
DOWN = (0.0, 0.0, -1.0)


def beam(divisions=(10, 1, 1), kind="hexahedron20", ends=("xmin", "xmax")):
    mesh = box_mesh((0.3, 0.02, 0.02), divisions, kind=kind)
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[(end, "xyz") for end in ends])


def tips_of(body, places=PLACES):
    return [body.contact(point=(x, 0.01, 0.02), direction=DOWN, radius=0) for x in places]


def struck_in_three_places(tips):
    scene = ao.Scene()
    struck = scene.add(tips, name="beam")
    for i, (speed, gap) in enumerate(zip(SPEEDS, GAPS, strict=True)):
        ball = scene.add(ao.rigid(mass=0.02), velocity=speed)
        scene.connect(ball, struck.port(i), HERTZ, gap=gap)
    return scene, struck


def forces(run):
    return np.array([contact.force for contact in run.contacts])


def relative(mine, right):
    """The largest difference of histories, each relative to its own largest value."""
    return (np.abs(mine - right).max(axis=-1) / np.abs(right).max(axis=-1)).max()


@pytest.fixture(scope="module", params=[("xmin", "xmax"), pytest.param((), marks=pytest.mark.slow)])
def three(request):
    """A scene, the body in it, and what the full model says, by Newmark's rule."""
    tips = tips_of(beam(ends=request.param))
    whole, _ = struck_in_three_places(ao.full(tips))
    full = whole.simulate(duration=DURATION, solver=ao.Newmark(dt=5e-8, estimate=False))
    scene, struck = struck_in_three_places(tips)
    assert full[struck.body].label == f"full({tips[0].body.n_dofs})"
    return scene, struck, full


@pytest.mark.slow
def test_forces_of_a_body_touched_in_three_places_by_larger_models_for_less_error(three):
    (scene, struck, full), orders = three, []
    for rtol in (1e-1, 1e-2, 1e-3):
        run = scene.simulate(duration=DURATION, rtol=rtol)
        orders.append(run.models[struck.body].n)
        found = as_meshed(run)
        assert relative(forces(found.at(full.t)), forces(full)) <= rtol
        assert run.error.model <= rtol
        assert found.models[struck.body].n < 90 < full.models[struck.body].dofs
        assert run[struck].port_displacements.shape[0] == 3
    assert orders[0] < orders[2]


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3])
def test_displacement_of_one_of_the_places(three, rtol):
    scene, struck, full = three
    run = scene.simulate(duration=DURATION, quantity=struck.port(1), rtol=rtol)
    mine = as_meshed(run).at(full.t)[struck].port_displacements[1]
    assert relative(mine, full[struck.body].port_displacements[1]) <= rtol


@pytest.mark.slow
def test_displacement_of_a_point_that_nothing_touches(three):
    scene, struck, full = three
    body, times = full.plan.bodies[struck.body].tips[0].body, np.linspace(0.0, DURATION, 100)
    point = body.contact(point=(0.21, 0.0, 0.0), direction=DOWN, radius=0)
    run = scene.simulate(duration=DURATION, quantity=point, rtol=1e-2)
    right = full[struck.body].probe(point=point.point, direction=DOWN, times=times).displacement
    assert relative(as_meshed(run)[struck].displacement_of(point.b, times), right) <= 1e-2


@pytest.mark.parametrize(
    "quantity", ["peak_force", "peak_time", "impulse", "contact_duration", "contact_count"]
)
def test_numbers_of_contacts(three, quantity):
    scene, _, full = three
    run = scene.simulate(duration=DURATION, quantity=quantity, rtol=1e-2)
    for i in range(len(PLACES)):
        name = f"contacts.{i}.{quantity}"
        assert as_meshed(run).value(name) == pytest.approx(full.value(name), rel=1e-2)
        assert getattr(run.contacts[i], quantity) == run.value(name)


@pytest.mark.filterwarnings("ignore:force. its error from the models")  # of waves of a step
def test_a_load_that_sets_in_at_once_doubles_the_deflection_without_any_contact():
    tip = beam().contact(point=(0.15, 0.01, 0.02), direction=DOWN, radius=0)
    scene = ao.Scene()
    scene.apply(scene.add(tip), force=10.0)
    run = scene.simulate(duration=2e-2)
    static = 10.0 / ao.antioscillators(tip, 4, method="krylov", contact_time=1e-4).k0
    assert np.abs(run.bodies[0].displacement).max() == pytest.approx(2.0 * static, rel=0.02)
    assert not run.plot_force().get_lines()


def test_what_is_there_twice_is_reduced_alike():
    """A ball between two beams that are one and the same model."""
    tip = beam().contact(point=(0.15, 0.01, 0.02), direction=DOWN, radius=0)
    scene = ao.Scene()
    upper, ball, lower = scene.add(tip), scene.add(ao.rigid(mass=0.02), velocity=1.0), None
    lower = scene.add(tip)
    scene.connect(upper, ball, HERTZ)
    scene.connect(ball, lower, HERTZ)
    run = scene.simulate(duration=DURATION, rtol=1e-2)
    above, below = run.models[upper.body], run.models[lower.body]
    assert above.omega.tobytes() == below.omega.tobytes()
    # The one is struck from below, the other from above: out of the one, into the other.
    np.testing.assert_array_equal(above.tips[0].b, -below.tips[0].b)
    assert run.models[ball.body].label == "rigid"
    assert run[lower].label == run.models[lower.body].label


# ------------------------------------------------------------------------------------- bad input


def test_what_belongs_elsewhere_is_refused(three):
    scene = three[0]
    other, struck = struck_in_three_places(tips_of(beam((6, 1, 1), "hexahedron")))
    with pytest.raises(ao.InputError, match=r"^quantity"):
        scene.simulate(duration=DURATION, quantity=struck)
    with pytest.raises(ao.InputError, match=r"^quantity"):
        scene.simulate(duration=DURATION, quantity=tips_of(beam())[0])
    with pytest.raises(ao.InputError, match=r"^quantity"):
        other.simulate(duration=DURATION, quantity=struck.port(3))
    alone = ao.Scene()
    alone.add(ao.rigid(mass=1.0), velocity=1.0)
    with pytest.raises(ao.InputError, match=r"^quantity"):
        alone.simulate(duration=DURATION, rtol=1e-2)


def free_plate():
    mesh = box_mesh((0.1, 0.1, 0.004), (8, 8, 1), kind="hexahedron20")
    plate = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    return plate.contact(point=(0.05, 0.05, 0.004))


def test_a_given_model_is_run_as_it_is_whatever_else_a_scene_holds():
    """Two impacts that share no body: neither the first nor its errors know of the second."""
    ball, tip, runs = ao.ball(0.006, STEEL), free_plate(), []
    given = ao.antioscillators(tip, 20, method="krylov", contact_time=5e-5)
    for other in (False, True):
        scene = ao.Scene()
        scene.connect(scene.add(ball, velocity=0.5), scene.add(given))
        if other:
            scene.connect(scene.add(ball, velocity=1.0), scene.add(tip))
        runs.append(scene.simulate(duration=1.2e-4))
    alone, beside = runs
    force = "contacts.0.peak_force"
    assert beside.value(force) == pytest.approx(alone.value(force), rel=1e-4)
    assert alone.error[force].mesh > 0.001
    assert beside.error[force].mesh == pytest.approx(alone.error[force].mesh, rel=0.01)
    moved = [run[1].error["displacement"].max() for run in runs]
    assert moved[1] == pytest.approx(moved[0], rel=0.01)
    assert alone.models[1].label == beside.models[1].label == given.label


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rebound_velocity", "restitution"])
def test_a_scene_of_two_has_what_an_impact_has(name):
    """The same models and errors; seen from a train, the same restitution (Galilei)."""
    tip, ball = free_plate(), ao.ball(0.01, STEEL)
    hit = ao.simulate(projectile=ball, target=tip, velocity=1.0, quantity=name)
    for train in (0.0, 0.5) if name == "restitution" else (0.0,):
        scene = ao.Scene()
        moving, struck = scene.add(ball, velocity=1.0 + train), scene.add(tip, velocity=train)
        scene.connect(moving, struck)
        run = scene.simulate(quantity=name)
        assert run.models[1].n == hit.models[1].n
        ours, theirs = run.compared_velocities - train
        assert theirs - ours == pytest.approx(hit.restitution, rel=1e-3)
        assert run.error.model <= 1e-2
        assert run.error[name].total == pytest.approx(run.error.total)
        assert run.error.total == pytest.approx(hit.error.total, rel=0.5)


def test_restitution_is_of_one_contact_and_rebounds_are_of_every_body():
    """Newton's cradle of equal balls under a linear law in turn: the last takes all the speed."""
    scene = ao.Scene()
    balls = [scene.add(ao.rigid(mass=1.0), velocity=v) for v in (1.0, 0.0, 0.0)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, ao.Linear(k=1e8), gap=1e-3)
    run = scene.simulate(quantity="rebound_velocity")
    np.testing.assert_allclose(run.compared_velocities, [0.0, 0.0, 1.0], atol=1e-4)
    with pytest.raises(ao.InputError, match=r"^quantity"):
        scene.simulate(quantity="restitution")


def test_restitution_compares_with_the_speed_at_which_bodies_meet():
    """Dropped from 0.1 m on an elastic floor a mass comes and parts at √(2 g h) (Galilei)."""
    scene = ao.Scene()
    dropped, floor = scene.add(ao.rigid(mass=1.0)), scene.add(ao.rigid(mass=math.inf))
    scene.connect(dropped, floor, ao.Linear(k=1e8), gap=0.1)
    with pytest.raises(ao.InputError, match=r"^quantity"):
        scene.simulate(quantity="restitution", duration=0.2)
    scene.gravity = 9.81
    run = scene.simulate(quantity="restitution", duration=0.2)
    assert run.value("restitution") == pytest.approx(1.0, rel=1e-6)
    assert run[dropped].centre_velocity.max() == pytest.approx(math.sqrt(2 * 9.81 * 0.1), rel=1e-3)


def test_a_body_that_touches_nothing_changes_no_force():
    ball, runs = ao.ball(0.01, STEEL), []
    model = ao.antioscillators(free_plate(), 12, method="krylov", contact_time=5e-5)
    for speed in (0.0, 1000.0):
        scene = ao.Scene()
        contact = scene.connect(scene.add(ball, velocity=1.0), scene.add(model))
        scene.add(ao.rigid(mass=1.0), velocity=speed)
        runs.append(scene.simulate(duration=1e-4).contacts[contact].peak_force)
    assert runs[0] == pytest.approx(runs[1], rel=1e-9)


def test_a_held_body_leaves_the_rebounds_of_others_their_bound():
    mesh = ao.box_mesh((0.04, 0.04, 0.01), (4, 4, 2), kind="hexahedron20")
    block = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    scene = ao.Scene()
    ball = scene.add(ao.ball(0.005, STEEL), velocity=1.0)
    scene.connect(ball, scene.add(block.contact(point=(0.02, 0.02, 0.01))))
    run = scene.simulate(quantity="rebound_velocity")
    assert math.isnan(run.value("bodies.1.rebound_velocity"))
    assert run.error.total == run.error["bodies.0.rebound_velocity"].total < 0.1


def test_rest_has_no_restitution():
    scene = ao.Scene(gravity=9.81)
    mass, floor = scene.add(ao.rigid(mass=1.0)), scene.add(ao.rigid(mass=math.inf))
    scene.connect(mass, floor, ao.Linear(k=1e6))
    with pytest.raises(ao.InputError, match=r"^quantity"):
        scene.simulate(quantity="restitution", preload=True, duration=1e-2)


def test_tangential_restitution_is_of_bodies_that_move_past_each_other():
    """While it slides a sphere loses μ (1 + e) of its normal speed; gravity turns its path."""
    ball, floor = ao.ball(0.01, STEEL), ao.wall(STEEL)
    with pytest.raises(ao.InputError, match=r"^quantity"):
        ao.simulate(ball, floor, velocity=1.0, friction=0.1, quantity="tangential_restitution")
    scene = ao.Scene(gravity=(2.0, 0.0, -9.81))
    moving = scene.add(ball, velocity=(1.0, 0.0, -0.5))
    scene.connect(moving, scene.add(floor), friction=0.1, gap=0.1)
    run = scene.simulate(quantity="tangential_restitution", duration=0.15)
    down = math.sqrt(0.5**2 + 2 * 9.81 * 0.1)
    along = 1.0 + 2.0 * (down - 0.5) / 9.81
    kept = 1.0 - 0.1 * 2.0 * down / along
    assert run.value("tangential_restitution") == pytest.approx(kept, rel=1e-3)
