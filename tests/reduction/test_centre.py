"""Bodies given by K and M alone: their rebound is what momentum says, or it is not known."""

import math
from functools import cache

import numpy as np
import pytest

import aoimpact as ao

# A bar without a mesh has a half-space's indentation twice, which is no matter here.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh")

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
MESH = ao.box_mesh((0.2, 0.02, 0.02), (8, 1, 1), kind="hexahedron20")
BAR = ao.FEModel.from_mesh(MESH, STEEL)
BARE = ao.FEModel(K=BAR.K, M=BAR.M)
OFF, CENTRAL = (0.175, 0.01, 0.0), (0.1, 0.01, 0.0)

MODELS = {
    "full": ao.full,
    "eigen": lambda tip: ao.antioscillators(tip, 5),
    "krylov": lambda tip: ao.antioscillators(tip, 5, method="krylov", contact_time=1e-4),
    "modal": lambda tip: ao.modal(tip, 12),
}


def dof_at(point):
    return 3 * int(np.argmin(np.linalg.norm(MESH.nodes - point, axis=1))) + 2


def impact(**changes):
    case = {
        "target": ao.rigid(mass=math.inf),
        "law": ao.Hertz(k=1e10),
        "velocity": 1.0,
        "duration": 6e-4,
    }
    return case | changes


@pytest.mark.parametrize("model", MODELS)
def test_off_centre_the_rebound_is_not_known_and_the_cure_works(model):
    make = MODELS[model]
    with pytest.warns(ao.AOImpactWarning, match=r"^projectile"):
        hit = ao.simulate(projectile=make(BARE.contact(dof=dof_at(OFF))), **impact())
    assert np.isnan([hit.rebound_velocity, hit.restitution]).all()
    assert np.isnan(hit.projectile.centre_velocity).all()
    assert np.isnan(hit.projectile.centre_displacement).all()
    assert hit.projectile.mass is None
    assert "rebound velocity   not known" in repr(hit)
    assert "mass not known" in repr(hit)
    cured = ao.FEModel(K=BAR.K, M=BAR.M, nodes=MESH.nodes).contact(dof=dof_at(OFF))
    known = ao.simulate(projectile=make(cured), **impact())
    assert known.rebound_velocity == pytest.approx(1.0 - known.impulse / BAR.mass, rel=1e-6)
    # A modal truncation may take either of two modes of one frequency.
    assert known.impulse == pytest.approx(hit.impulse, rel=1e-5)


@pytest.mark.parametrize("model", MODELS)
def test_struck_through_its_centre_the_body_moves_as_one(model):
    hit = ao.simulate(projectile=MODELS[model](BARE.contact(dof=dof_at(CENTRAL))), **impact())
    assert hit.projectile.mass == pytest.approx(BAR.mass, rel=1e-6)
    assert hit.rebound_velocity == pytest.approx(1.0 - hit.impulse / BAR.mass, rel=1e-6)
    assert hit.restitution == -hit.rebound_velocity


def test_a_free_target_of_unknown_centre_leaves_the_restitution_open():
    target = ao.antioscillators(BARE.contact(dof=dof_at(OFF)), 5)
    ball = ao.rigid(mass=0.05)
    with pytest.warns(ao.AOImpactWarning, match=r"^target"):
        hit = ao.simulate(**impact(projectile=ball, target=target))
    assert hit.rebound_velocity == pytest.approx(1.0 - hit.impulse / 0.05, rel=1e-6)
    assert math.isnan(hit.restitution)


def test_in_a_scene_the_centre_is_not_known_either():
    scene = ao.Scene()
    bar = scene.add(BARE.contact(dof=dof_at(OFF)), velocity=1.0, name="bar")
    wall = scene.add(ao.rigid(mass=math.inf))
    scene.connect(bar, wall, ao.Hertz(k=1e10))
    with pytest.warns(ao.AOImpactWarning, match=r"^body"):
        run = scene.simulate(duration=1e-4)
    assert np.isnan(run[bar].centre_velocity).all()
    assert np.isfinite(run[bar].velocity).all()


@cache
def held_column():
    """A beam held at one end; the same by its matrices alone."""
    frame = ao.FEModel.from_mesh(MESH, STEEL, fixed=[("xmin", "xyz")])
    return frame, ao.FEModel(K=frame.K, M=frame.M)


def test_a_held_target_needs_no_centre():
    frame, bare = held_column()
    tip = frame.contact(point=OFF, direction=(0, 0, 1), radius=0)
    other = bare.contact(dof=int(np.argmax(tip.b)))
    ball = ao.rigid(mass=0.05)
    law = ao.PowerLaw(1e10, 1.5)  # Hertz's contains the compliance of a node, known with a mesh
    hits = [
        ao.simulate(**impact(projectile=ball, target=ao.antioscillators(one, 5), law=law))
        for one in (tip, other)
    ]
    assert hits[1].restitution == pytest.approx(hits[0].restitution, rel=1e-9)
    assert np.isnan(hits[1].target.centre_velocity).all()


def test_the_weight_of_a_held_body_without_nodes_is_not_made_up():
    """Its static mode's mass under gravity is not its weight: none is taken, and that is said."""
    star = ao.antioscillators(held_column()[1].contact(dof=100), 5)
    scene = ao.Scene(gravity=9.81)
    body = scene.add(star)
    with pytest.warns(ao.AOImpactWarning, match=r"^gravity"):
        run = scene.simulate(duration=1e-3)
    assert not run[body].displacement.any()
