"""Bodies at rest bear what presses on them: balance, and springs in series and parallel."""

import itertools
import math

import numpy as np
import pytest
import scipy.optimize
import scipy.sparse as sp
from every_law import LAWS, law_of
from rows import each

import aoimpact as ao

WALL, BODY = ao.rigid(mass=math.inf), ao.rigid(mass=1.0)
EARTH = 9.81
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def at_rest(scene):
    """The contacts' forces at t = 0; and nothing moves."""
    rule = ao.Newmark(dt=1e-10, estimate=False)
    run = scene.simulate(duration=1e-9, solver=rule, preload=True)
    assert max(np.abs(body.velocity).max() for body in run.bodies) < 1e-12
    return np.array([contact.force[0] for contact in run.contacts])


def on_a_floor(law, gap=0.0, body=BODY, gravity=EARTH):
    scene = ao.Scene(gravity=gravity)
    scene.connect(scene.add(body), scene.add(WALL), law, gap=gap)
    return scene


def loop(stiffness, gap=0.0, gravity=EARTH):
    """A body on one that stands on a floor, which the upper one touches as well."""
    scene = ao.Scene(gravity=gravity)
    upper, lower, floor = scene.add(BODY), scene.add(BODY), scene.add(WALL)
    for one, other, k, way in zip(
        (upper, lower, upper), (lower, floor, floor), stiffness, (gap, gap, 2 * gap), strict=True
    ):
        scene.connect(one, other, ao.Linear(k=k), gap=way)
    return scene


@each("name", sorted(LAWS))
def test_a_column_bears_its_weight(name):
    law = law_of(name, k=1e9)
    scene = ao.Scene(gravity=EARTH)
    column = [scene.add(BODY) for _ in range(5)]
    floor = scene.add(WALL)
    for above, below in zip(column, [*column[1:], floor], strict=True):
        scene.connect(above, below, law)
    run = scene.simulate(duration=5e-3, preload=True)
    for i, contact in enumerate(run.contacts):
        np.testing.assert_allclose(contact.force, (i + 1) * EARTH, rtol=1e-9)
    assert run[floor].displacement.max() == 0.0


def test_a_law_that_cannot_carry_the_load_is_said_to_be_none():
    """k d / (1 + d/l) stays below k l = 100 N."""
    law = ao.UserLaw(lambda d, v: 1e6 * d / (1.0 + d / 1e-4), depends_on_rate=False)

    def rest(load):
        scene = ao.Scene()
        body = scene.add(BODY)
        scene.connect(body, scene.add(WALL), law)
        scene.apply(body, force=load)
        return scene.simulate(duration=1e-3, preload=True)

    assert rest(50.0).contacts[0].peak_force == pytest.approx(50.0, rel=1e-9)
    with pytest.raises(ao.ConvergenceError, match=r"^preload"):
        rest(500.0)


@each("stiffness", [(1e6, 1e6, 1e6), (1e9, 1e6, 2e6), (1e4, 1e9, 3e5)])
def test_a_closed_loop_of_contacts_shares_the_weight_by_its_stiffness(stiffness):
    """Springs in series and parallel: (k_a + k_c) x - k_a y = w and -k_a x + (k_a + k_b) y = w,
    where the upper body comes down the farther, so that all three are closed."""
    a, b, c = stiffness
    x, y = np.linalg.solve([[a + c, -a], [-a, a + b]], [EARTH, EARTH])
    # Else the lower body sinks away under the upper one.
    expected = [a * (x - y), b * y, c * x] if x > y else [0.0, EARTH, EARTH]
    assert at_rest(loop(stiffness)) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_body_squeezed_between_walls_of_very_different_stiffness():
    """One digit in twelve of the stiff side's indentation is rounding of where the body is."""
    soft, stiff, overlap = 1e3, 1e15, 1e-4
    scene = ao.Scene()
    left, body, right = scene.add(WALL), scene.add(BODY), scene.add(WALL)
    scene.connect(left, body, ao.Hertz(k=soft), gap=-overlap)
    scene.connect(body, right, ao.Hertz(k=stiff), gap=-overlap)
    forces = at_rest(scene)
    assert forces[0] == pytest.approx(soft * (2 * overlap) ** 1.5, rel=1e-6)
    assert forces[1] == pytest.approx(forces[0], rel=1e-6)


def test_bodies_that_overlap_and_that_nothing_presses_part():
    scene = ao.Scene()
    one, other, third = (scene.add(BODY) for _ in range(3))
    for a, b, gap in ((one, other, -1e-5), (other, third, -1e-5), (one, third, -2e-5)):
        scene.connect(a, b, ao.Hertz(k=1e9), gap=gap)
    assert at_rest(scene) == pytest.approx(0.0, abs=1e-12)


@each("gap", [1e-3, 2e-3])
@each("k", [1e15, 1e18, 1e25])
def test_contacts_that_do_not_give_way_leave_forces_undetermined(k, gap):
    with pytest.raises(ao.InputError, match=r"^preload"):
        at_rest(loop((k, k, k), gap))


def test_a_stiffness_beyond_all_numbers_is_named():
    with pytest.raises(ao.InputError, match=r"^preload"):
        at_rest(on_a_floor(ao.Hertz(k=1e308)))


@each("level", [8.0, EARTH, 12.0])
def test_a_table_with_a_level_stretch_carries_the_weight(level):
    law = ao.Tabulated([0.0, 1e-5, 2e-5, 3e-5], [0.0, level, level, 20.0])
    assert at_rest(on_a_floor(law)) == pytest.approx(EARTH, rel=1e-9)


def test_a_law_that_ends_before_rest_says_so():
    law = ao.Tabulated([0.0, 1e-5, 2e-5], [0.0, 2.0, 5.0])
    with pytest.raises(ao.InputError, match=r"^preload"):
        at_rest(on_a_floor(law))


def test_the_top_of_a_high_pile_rests_as_exactly_as_its_foot():
    scene, height = ao.Scene(gravity=9.81), 200
    balls = [scene.add(ao.rigid(mass=1.0)) for _ in range(height)]
    for below, above in itertools.pairwise([*balls, scene.add(ao.rigid(mass=math.inf))]):
        scene.connect(below, above, ao.Hertz(k=1e10))
    run = scene.simulate(duration=1e-5, preload=True, energies=False)
    forces = [contact.force[0] for contact in run.contacts]
    assert forces == pytest.approx(9.81 * np.arange(1, height + 1), rel=1e-10)


def test_a_row_that_nothing_holds_is_pressed_where_its_centre_of_mass_stays():
    scene, masses, press = ao.Scene(), [1.0, 3.0, 0.5], 100.0
    row = [scene.add(ao.rigid(mass=mass)) for mass in masses]
    for one, other in itertools.pairwise(row):
        scene.connect(one, other, ao.Linear(k=1e6), gap=1e-4)
    scene.apply(row[0], force=press)
    scene.apply(row[2], force=-press)
    run = scene.simulate(duration=1e-6, preload=True)
    places = np.array([body.displacement[0] for body in run.bodies])
    assert np.diff(places) == pytest.approx(-(1e-4 + press / 1e6), rel=1e-9)
    assert masses @ places == pytest.approx(0.0, abs=1e-15)


@each("solver", [ao.Adaptive(), ao.Newmark(dt=1e-6, estimate=False)])
@each("damping", [None, ao.Rayleigh(beta=1e-5)])
@pytest.mark.filterwarnings("ignore:body 1.*beta")  # nothing moves
def test_loads_and_contacts_at_a_massless_place_are_in_balance(solver, damping):
    """A ground spring and a linear contact share what is pressed on them by load and body."""
    ground, stop, load = 1e6, 3e6, 50.0
    star = ao.AOModel(m0=0.0, k0=ground, m=[1.0, 0.5], k=[2e6, 1e7], damping=damping)
    scene = ao.Scene()
    above, middle, wall = scene.add(BODY), scene.add(star), scene.add(WALL)
    scene.connect(above, middle, ao.Hertz(k=1e9))
    scene.connect(middle, wall, ao.Linear(k=stop))
    scene.apply(above, force=load)
    scene.apply(middle, force=load)
    run = scene.simulate(duration=1e-3, preload=True, solver=solver)
    for contact, force in zip(run.contacts, (load, 2 * load * stop / (ground + stop)), strict=True):
        np.testing.assert_allclose(contact.force, force, rtol=1e-9)


def test_all_degrees_of_freedom_start_at_rest_where_the_contact_has_no_mass():
    """Two springs in series, held at one end, a mass between them and none at the other."""
    k, load = 1e5, 20.0
    K, M = np.array([[2.0 * k, -k], [-k, k]]), np.diag([1.0, 0.0])
    place = ao.FEModel(K=sp.csr_array(K), M=sp.csr_array(M)).contact(dof=1)
    scene = ao.Scene()
    above, below = scene.add(BODY), scene.add(ao.full(place))
    scene.connect(above, below, ao.Linear(k=1e6))
    scene.apply(above, force=load)
    run = scene.simulate(duration=1e-3, preload=True, solver=ao.Newmark(dt=1e-5))
    np.testing.assert_allclose(run.contacts[0].force, load, rtol=1e-9)
    assert run[below].displacement == pytest.approx(2.0 * load / k, rel=1e-9)


def test_a_free_beam_on_two_stops_obeys_the_law_of_the_lever():
    meshed = ao.FEModel.from_mesh(ao.box_mesh((0.3, 0.02, 0.02), (6, 2, 1)), STEEL)
    body = ao.FEModel(K=meshed.K, M=meshed.M, nodes=meshed.nodes)
    places, load = (0.05, 0.1, 0.25), 30.0
    down = (0.0, 0.0, -1.0)
    tips = [body.contact(point=(x, 0.01, 0.0), direction=down, radius=0) for x in places]
    scene = ao.Scene()
    beam, left, right = scene.add(ao.interface(tips, 12)), scene.add(WALL), scene.add(WALL)
    scene.connect(beam.port(0), left, ao.Linear(k=1e6))
    scene.connect(beam.port(2), right, ao.Linear(k=3e6))
    scene.apply(beam.port(1), force=load)
    share = (places[1] - places[0]) / (places[2] - places[0])
    assert at_rest(scene) == pytest.approx([load * (1.0 - share), load * share], rel=1e-8)


def test_a_falling_body_among_many_is_named():
    scene = ao.Scene(gravity=EARTH)
    balls = [scene.add(BODY) for _ in range(50)]
    for above, below in itertools.pairwise([*balls[:-1], scene.add(WALL)]):
        scene.connect(above, below, ao.Hertz(k=1e10))
    with pytest.raises(ao.ConvergenceError, match=r"^preload"):
        scene.simulate(duration=1e-6, preload=True)


@each("gap", [0.0, -1e-3])
def test_plastic_contacts_yield_and_bear_what_is_pressed_on_a_row_of_them(gap):
    scene = ao.Scene()
    row = [scene.add(ao.AOModel(m0=2e-4, m=[0.1], k=[0.2])), *(scene.add(BODY) for _ in range(2))]
    row.append(scene.add(WALL))
    laws = (
        ao.Thornton(k=5526.0, yield_force=0.02),
        ao.Hertz(k=600.0),
        ao.Thornton(k=40.0, yield_force=0.01),
    )
    for one, other, law in zip(row, row[1:], laws, strict=False):
        scene.connect(one, other, law, gap=gap)
    scene.apply(row[0], force=0.1)
    assert at_rest(scene) == pytest.approx(np.full(3, 0.1), rel=1e-9)


def test_a_row_squeezed_between_walls_has_one_force_whatever_its_laws():
    """Nothing loads it but its overlaps: all indentations at the force sum up to these."""
    rng, count = np.random.default_rng(20002), 20
    powers = rng.uniform(1.0, 3.0, count)
    stiffnesses = 10.0 ** rng.uniform(6.0, 10.0, count)
    gaps = rng.uniform(-1e-4, 5e-5, count)
    scene = ao.Scene()
    row = [scene.add(WALL), *(scene.add(BODY) for _ in range(count - 1)), scene.add(WALL)]
    for ends, k, n, gap in zip(itertools.pairwise(row), stiffnesses, powers, gaps, strict=True):
        scene.connect(*ends, ao.PowerLaw(k=k, n=n), gap=gap)

    def too_short(force):
        return ((force / stiffnesses) ** (1.0 / powers)).sum() + gaps.sum()

    force = scipy.optimize.brentq(too_short, 1e-9, 1e9, rtol=1e-14)
    assert at_rest(scene) == pytest.approx(np.full(count, force), rel=1e-6)


@each("law", [ao.Hertz(k=1e9), ao.PowerLaw(k=1e10, n=2.9)])
def test_what_touches_and_is_not_pressed_makes_room(law):
    """A free ball, pushed aside by a spring under load, is where no force is left."""
    scene, load, stiffness = ao.Scene(), 1e3, 1e8
    spring, ball = scene.add(ao.AOModel(m0=1.0, k0=stiffness)), scene.add(BODY)
    scene.connect(spring, ball, law)
    scene.apply(spring, force=load)
    run = scene.simulate(duration=1e-9, solver=ao.Newmark(dt=1e-10, estimate=False), preload=True)
    assert run.contacts[0].force[0] < 1e-12 * load
    assert run[spring].displacement[0] == pytest.approx(load / stiffness, rel=1e-12)


def test_a_light_body_that_falls_beside_a_heavy_one_at_rest_is_named():
    scene = ao.Scene(gravity=EARTH)
    heavy, light = scene.add(ao.rigid(mass=1e3)), scene.add(ao.rigid(mass=1e-16))
    ceiling = scene.add(WALL)
    scene.connect(heavy, ceiling, ao.Hertz(k=1e9))
    scene.connect(ceiling, light, ao.Hertz(k=1e9))
    with pytest.raises(ao.ConvergenceError, match=r"^preload"):
        at_rest(scene)


@each("way", [1.0, -1.0])
def test_what_nothing_presses_stays_where_it_was_put(way):
    """Springs in series, k0 and a law's, move as the load tells; a body off them does not."""
    scene = ao.Scene()
    spring, pressed = scene.add(ao.AOModel(m0=0.1, k0=1e3)), scene.add(BODY)
    coming = scene.add(ao.rigid(mass=0.02), velocity=0.2 * way)
    for one, other, gap in ((pressed, spring, 0.0), (coming, pressed, 1e-3)):
        ends = (one, other) if way > 0.0 else (other, one)
        scene.connect(*ends, ao.Linear(k=1e4), gap=gap)
    scene.apply(pressed, force=4.0 * way)
    run = scene.simulate(duration=1e-9, preload=True)
    places = [run[body].displacement[0] for body in (spring, pressed, coming)]
    assert places == pytest.approx([4e-3 * way, 4.4e-3 * way, 0.0], rel=1e-9, abs=0.0)
