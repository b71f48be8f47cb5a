"""Strain, gauges, accelerations and reactions against closed forms and conservation of momentum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.signal import butter, freqz, lfilter

import aoimpact as ao
from aoimpact.fields import Channel

FloatArray = npt.NDArray[np.float64]

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)
LAW = ao.Linear(k=2e6)
DOWN = (0.0, 0.0, -1.0)

# The models give the force; what else they give here is compared as they have it.
pytestmark = pytest.mark.filterwarnings("ignore:.*may be off by", "ignore:the record of")


def inner_edge(nodes: FloatArray) -> Any:
    return (nodes[:, 1] < 1e-9) & (nodes[:, 0] > 0.01) & (nodes[:, 0] < 0.09)


HELD = {
    "supports": {"fixed": [("xmin", "xyz"), ("xmax", "xyz")]},
    "springs": {"fixed": [("xmin", "xyz")], "springs": [(inner_edge, "z", 1e6)]},
    "springs only": {"springs": [("zmin", "xyz", 1e6)]},
    "guided": {"fixed": [("xmin", "z"), ("xmax", "z")]},
    "weights": {"fixed": [("xmin", "xyz")], "masses": [("xmax", 0.05)]},
}


def pressed(cells: tuple[int, int, int]) -> ao.ContactPoint:
    mesh = ao.box_mesh((0.1, 0.08, 0.005), cells, kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, **HELD["supports"])
    return body.contact(point=(0.04, 0.03, 0.005), direction=DOWN, radius=5e-3)


def plate(held: str, damping: Any = None) -> ao.ContactPoint:
    mesh = ao.box_mesh((0.1, 0.08, 0.005), (5, 4, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, damping=damping, **HELD[held])
    return body.contact(point=(0.04, 0.03, 0.005), direction=DOWN, radius=0)


def impulse(force: FloatArray, dt: float) -> FloatArray:
    """∫ F dt by the rule by which Newmark's steps change velocities, exactly."""
    return np.concatenate([[0.0], np.cumsum(0.5 * dt * (force[1:] + force[:-1]))])


@pytest.mark.slow
@pytest.mark.parametrize("reduced", [True, False], ids=["reduced", "full"])
@pytest.mark.parametrize("held", HELD)
def test_reactions_change_the_momentum(held: str, reduced: bool) -> None:
    tip = plate(held)
    target = ao.antioscillators(tip, 6) if reduced else ao.full(tip)
    dt = 2e-6
    hit = ao.simulate(
        ao.rigid(mass=0.1), target, 1.0, law=LAW, duration=4e-4, solver=ao.Newmark(dt=dt)
    )
    reaction = hit.target.reaction()
    mass = tip.body.mass
    assert mass is not None
    momentum = mass * hit.target.centre_velocity
    along = reaction.force @ DOWN
    scale = np.abs(impulse(hit.force, dt)).max()
    np.testing.assert_allclose(impulse(hit.force + along, dt), momentum, atol=1e-9 * scale)
    np.testing.assert_allclose(
        reaction.nodal_force.sum(axis=1), reaction.force, atol=1e-7 * np.abs(along).max()
    )
    lever = reaction.points - reaction.centre
    moment = np.cross(lever, reaction.nodal_force).sum(axis=1)
    np.testing.assert_allclose(moment, reaction.moment, atol=1e-7 * np.abs(reaction.moment).max())


@pytest.mark.parametrize("reduced", [True, False], ids=["reduced", "full"])
def test_dashpots_to_the_ground_take_their_share_of_the_momentum(reduced: bool) -> None:
    """C = αM + βK: α slows the body as the ground would; β K is in the reactions."""
    damping, dt = ao.Rayleigh(alpha=300.0, beta=1e-6), 2e-6
    tip = plate("springs", damping)
    target = ao.antioscillators(tip, 6) if reduced else ao.full(tip)
    hit = ao.simulate(
        ao.rigid(mass=0.1), target, 1.0, law=LAW, duration=4e-4, solver=ao.Newmark(dt=dt)
    )
    mass = tip.body.mass
    assert mass is not None
    speed = hit.target.centre_velocity
    force = hit.force + hit.target.reaction().force @ DOWN - damping.alpha * mass * speed
    scale = np.abs(impulse(hit.force, dt)).max()
    np.testing.assert_allclose(impulse(force, dt), mass * speed, atol=1e-9 * scale)


@pytest.mark.parametrize("held", ["supports", "springs only", "weights"])
def test_supports_carry_the_weight_at_rest(held: str) -> None:
    scene = ao.Scene(gravity=9.81)
    tip = plate(held)
    few = ao.antioscillators(tip, 6, method="krylov", contact_time=1e-3)
    target = scene.add(tip if held == "supports" else few)
    ball = scene.add(ao.rigid(mass=0.2))
    scene.connect(ball, target, LAW)
    run = scene.simulate(duration=1e-4, preload=True)
    reaction = run[target].reaction(times=[0.0, 1e-4])
    assert tip.body.mass is not None
    weight = 9.81 * (tip.body.mass + 0.2)
    np.testing.assert_allclose(reaction.force @ DOWN, -weight, rtol=1e-6)


def test_springs_carry_what_they_are_deflected_by() -> None:
    tip = plate("springs")
    hit = ao.simulate(
        ao.rigid(mass=0.1), ao.full(tip), 1.0, law=LAW, duration=4e-4, solver=ao.Newmark(dt=2e-6)
    )
    moved = hit.target.probe(nodes=inner_edge).displacement
    by_springs = -1e6 * moved.mean(axis=1)[:, 2]
    found = hit.target.reaction(inner_edge).force
    np.testing.assert_allclose(found[:, 2], by_springs, atol=1e-9 * np.abs(by_springs).max())
    assert not found[:, :2].any()


def column(length: float, side: float, count: int, **options: Any) -> ao.FEModel:
    """A rod of a material without lateral contraction, whose waves are those of one dimension."""
    mesh = ao.box_mesh((length, side, side), (count, 1, 1), kind="hexahedron20")
    return ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.0, rho=2700), **options)


def end_face(body: ao.FEModel) -> ao.ContactPoint:
    """A uniform pressure of 1 N in all on the face x = 0, by the shape functions of its side."""
    mesh = body.mesh
    assert mesh is not None
    nodes = mesh.node_sets["xmin"]
    places = mesh.nodes[nodes][:, 1:]
    at_corner = (np.abs(places - places.mean(axis=0)) > 1e-9).all(axis=1)
    b = np.zeros(body.n_dofs)
    b[3 * nodes] = np.where(at_corner, -1.0 / 12.0, 1.0 / 3.0)
    return body.contact(b=b)


@pytest.mark.slow
def test_the_strain_of_a_rod_that_a_mass_strikes() -> None:
    """F'' + (k/Z) F' + (k/m) F = 0 of a mass on a spring on a long rod; ε = -F(t - x/c)/(E A)."""
    side, mass, k, speed = 0.01, 0.1, 5e7, 1.0
    rod = column(0.4, side, 200)
    area, at = side**2, 0.1
    c = math.sqrt(70e9 / 2700.0)
    decay = 0.5 * k / (2700.0 * c * area)
    omega = math.sqrt(k / mass - decay**2)
    hit = ao.simulate(
        ao.rigid(mass=mass),
        end_face(rod),
        speed,
        law=ao.Linear(k=k),
        duration=8e-5,
        quantity=ao.StrainAt(rod, (at, 0.5 * side, 0.0), "xx"),
        rtol=2e-3,
    )
    t = np.linspace(0.0, 8e-5, 400)
    late = np.maximum(t - at / c, 0.0)
    force = k * speed / omega * np.exp(-decay * late) * np.sin(omega * late)
    known = -force / (70e9 * area)
    largest = np.abs(known).max()
    found = hit.target.probe((at, 0.5 * side, 0.0), times=t).strain["xx"]
    np.testing.assert_allclose(found, known, atol=5e-3 * largest)
    gauge = hit.target.gauge((at, 0.5 * side, 0.0), (1, 0, 0), length=2e-3, times=t)
    np.testing.assert_allclose(gauge.strain, known, atol=5e-3 * largest)


@pytest.mark.slow
def test_a_gauge_on_a_simply_supported_plate() -> None:
    """30 mm beside the contact and opposite: Mindlin's theory under the same force.

    Navier's modes are each integrated exactly for a force that is straight between the times. By
    shear and rotation each has 1 + k² h²/12 (1 + 2/(κ (1 - ν))) times its mass, with κ = 5/6.
    """
    a, b, h, at = 0.3, 0.2, 0.003, (0.18, 0.1)
    mesh = ao.box_mesh((a, b, h), (30, 20, 1), kind="hexahedron20")
    sides = [("xmin", "yz"), ("xmax", "yz"), ("ymin", "xz"), ("ymax", "xz")]
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=sides)
    hit = ao.simulate(
        ao.rigid(mass=0.05),
        body.contact(point=(0.15, 0.1, h), direction=DOWN, radius=0.002),
        0.5,
        law=ao.Linear(k=5e5),
        duration=3e-3,
        quantity=ao.StrainAt(body, (*at, 0.0), (1, 0, 0), length=3e-3),
        rtol=5e-3,
    )
    t = np.linspace(0.0, 3e-3, 1501)
    force = hit.at(t).force
    kx, ky = (x.ravel() for x in np.mgrid[1:60, 1:60] * np.pi / np.reshape([a, b], (2, 1, 1)))
    D = ALUMINIUM.E * h**3 / (12.0 * (1.0 - ALUMINIUM.nu**2))
    heavier = 1.0 + (kx**2 + ky**2) * h**2 / 12.0 * (1.0 + 2.4 / (1.0 - ALUMINIUM.nu))
    omega = (kx**2 + ky**2) * np.sqrt(D / (ALUMINIUM.rho * h * heavier))
    seen = np.sin(kx * at[0]) * np.sin(ky * at[1]) * kx**2
    seen *= np.sin(kx * 0.15) * np.sin(ky * 0.1) * 0.5 * h / (ALUMINIUM.rho * h * a * b / 4.0)
    seen /= heavier
    c, s = np.cos(omega * t[1]), np.sin(omega * t[1])
    q, v = np.zeros((2, len(omega)))
    known = [0.0]
    for f, drift in zip(force, np.diff(force)[:, None] / t[1] / omega**2, strict=False):
        off, rate = q - f / omega**2, v - drift
        q = (f / omega**2 + drift * t[1]) + off * c + rate / omega * s
        v = drift - off * omega * s + rate * c
        known.append(float(seen @ q))
    gauge = hit.target.gauge((*at, 0.0), (1, 0, 0), 3e-3, times=t).strain
    np.testing.assert_allclose(gauge, known, atol=0.015 * np.abs(known).max())


def published_filter(values: FloatArray, cfc: float, dt: float) -> FloatArray:
    """SAE J211-1, appendix C: its difference equation, forward and backward."""
    omega = math.tan(math.pi * cfc * 2.0775 * dt)
    root = math.sqrt(2.0) * omega
    scale = 1.0 + root + omega**2
    a = [omega**2 / scale, 2.0 * omega**2 / scale, omega**2 / scale]
    b = [1.0, 2.0 * (omega**2 - 1.0) / scale, (1.0 - root + omega**2) / scale]
    once = lfilter(a, b, values)
    return np.asarray(lfilter(a, b, once[::-1])[::-1])


def light_cube(duration: float) -> tuple[ao.Result, float]:
    cube = ao.FEModel.from_mesh(ao.box_mesh((0.01,) * 3, (1, 1, 1)), STEEL)
    tip = cube.contact(point=(0.005, 0.005, 0.01), direction=DOWN, radius=0)
    hit = ao.simulate(
        ao.rigid(mass=0.1),
        ao.antioscillators(tip, 1),
        0.1,
        law=ao.Linear(k=1e5),
        duration=duration,
    )
    assert cube.mass is not None
    return hit, cube.mass


def test_the_acceleration_of_a_light_cube() -> None:
    """ẍ = F/m at any time, with a warning; behind a filter as the standard's equations have it."""
    hit, mass = light_cube(3e-3)
    dt = 2e-6
    probe = hit.target.probe((0.005, 0.005, 0.005), DOWN, dt=dt)  # its centre of mass
    assert len(probe.t) == 1501
    known = hit.at(probe.t).force / mass
    with pytest.warns(ao.AOImpactWarning, match="cfc="):
        raw = probe.acceleration
    # At the beginning it is a mean over the first thousandth of the contact.
    np.testing.assert_allclose(raw[1:], known[1:], atol=1e-3 * known.max())
    space = np.zeros(2000)
    padded = published_filter(np.concatenate([space, known, space]), 1000.0, dt)
    smooth = probe.filtered(cfc=1000).acceleration
    known_until = probe.t <= 3e-3 - Channel(cfc=1000.0).settling_time
    assert Channel(cfc=1000.0).settling_time == pytest.approx(1e-3, rel=5e-3)  # the class's period
    np.testing.assert_array_equal(np.isnan(smooth), ~known_until)
    np.testing.assert_allclose(
        smooth[known_until], padded[2000:-2000][known_until], atol=2e-3 * known.max()
    )


def test_the_end_of_a_record_is_not_the_largest_acceleration() -> None:
    """Of a record that is cut in the middle of vibration, as of a longer one."""
    target = ao.antioscillators(plate("supports"), 12)
    hits = [
        ao.simulate(ao.rigid(mass=0.1), target, 1.0, law=LAW, duration=length)
        for length in (3e-3, 6e-3)
    ]
    t = np.arange(0.0, 3e-3 - Channel(cfc=1000.0).settling_time, 5e-6)
    cut, whole = (
        hit.target.probe((0.06, 0.04, 0.0), DOWN, times=t).filtered(cfc=1000).acceleration
        for hit in hits
    )
    assert np.isfinite(cut).all()
    np.testing.assert_allclose(cut, whole, atol=2e-3 * np.abs(whole).max())


@pytest.mark.slow
@pytest.mark.parametrize("n", [16, 40])
def test_errors_of_sensors_are_not_below_the_true_ones(n: int) -> None:
    """Also of models that few further oscillators add to; against elements half as large."""
    run = {"velocity": 1.0, "law": LAW, "duration": 3e-3, "solver": ao.Adaptive(rtol=1e-7)}
    fit = {"method": "krylov", "contact_time": 3e-4, "duration": 3e-3}
    few, every = (
        ao.simulate(ao.rigid(mass=0.1), ao.antioscillators(tip, of, **fit), **run).target
        for tip, of in ((pressed((5, 4, 1)), n), (pressed((10, 8, 2)), 80))
    )
    t, at = np.arange(0.0, 3e-3, 5e-6), (0.06, 0.04, 0.0)

    def reaction(of: Any) -> Any:
        found = of.reaction("xmin", times=t)
        return found.force @ DOWN, lambda: found.error["force"]

    def gauge(of: Any) -> Any:
        found = of.gauge(at, (1, 0, 0), 3e-3, times=t)
        return found.strain, lambda: found.error

    def acceleration(of: Any) -> Any:
        found = of.probe(at, DOWN, times=t).filtered(corner=4e3)
        return found.acceleration, lambda: found.error

    for read in (reaction, gauge, acceleration):
        (mine, said), (right, _) = read(few), read(every)
        true = np.nanmax(np.abs(mine - right)) / np.nanmax(np.abs(right))
        assert true < np.nanmax(said()) < 5.0 * true + 1e-4


def test_a_corner_is_where_two_passes_leave_half_the_power() -> None:
    _, gain = freqz(*butter(2, Channel(corner=800.0).pole, fs=1e7), worN=[800.0], fs=1e7)
    assert abs(gain[0]) ** 4 == pytest.approx(0.5, rel=1e-6)


def test_bodies_without_the_rows_of_their_supports_have_no_reactions() -> None:
    K = np.array([[2e6, -1e6], [-1e6, 1e6]])
    chain = ao.FEModel(K=K, M=np.diag([0.5, 0.5]))
    hit = ao.simulate(ao.rigid(mass=0.1), ao.antioscillators(chain.contact(dof=1), 1), 1.0, law=LAW)
    with pytest.raises(ao.InputError, match="fixed="):
        hit.target.reaction()


def test_a_point_far_from_a_contact_is_at_rest_as_it_begins() -> None:
    """The half-space's field of a contact that has hardly a width."""
    mesh = ao.box_mesh((0.1, 0.08, 0.005), (5, 4, 1), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz")])
    tip = body.contact(point=(0.05, 0.04, 0.005))
    model = ao.antioscillators(tip, 6, method="krylov", contact_time=5e-5)
    hit = ao.simulate(ao.ball(0.01, STEEL), model, 1.0, duration=5e-5)
    velocity = hit.target.probe((0.08, 0.04, 0.0), times=[0.0, 1e-12]).velocity
    assert np.abs(velocity).max() < 1e-3
