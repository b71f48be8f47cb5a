"""Added masses, springs to the ground, and rigid attachments."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from bodies import rigid_motions

import aoimpact as ao
from aoimpact import AOImpactWarning
from aoimpact.contact import static_mode

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BLOCK = ao.box_mesh((0.06, 0.04, 0.02), (3, 2, 1))
VOLUME = 0.06 * 0.04 * 0.02


def inertia_of(body: ao.FEModel) -> npt.NDArray[np.float64]:
    """Mass of translations and of rotations about the origin, shape (6, 6)."""
    assert body.nodes is not None
    motions = rigid_motions(body.nodes)
    found: npt.NDArray[np.float64] = motions.T @ (body.M @ motions)
    return found


def test_an_added_mass_is_seen_in_every_direction() -> None:
    body = ao.FEModel.from_mesh(BLOCK, STEEL, masses=[("xmax", 5.0), ([0, 1], 1.0)])
    assert body.mass == pytest.approx(STEEL.rho * VOLUME + 6.0, rel=1e-12)
    assert inertia_of(body)[:3, :3] == pytest.approx(body.mass * np.eye(3), abs=1e-12)
    for along in np.eye(3):
        tip = ao.ContactPoint(body, body.com_functional(along))
        assert static_mode(tip).mass == pytest.approx(body.mass, rel=1e-9)
    assert body.rigid_modes.shape[1] == 6
    assert np.abs(body.K @ body.rigid_modes).max() < 1e-12 * abs(body.K).max()


@pytest.mark.parametrize("nodes", ["xmax", [0, 5, 11, 20]])
def test_a_rigid_mass_has_its_centre_and_inertia(nodes: Any) -> None:
    """The parallel-axes theorem, for a mass far off its seat and turned axes."""
    mass, centre = 5.0, np.array([0.2, 0.1, -0.05])
    turn = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
    own = turn @ np.diag([0.02, 0.03, 0.04]) @ turn.T
    mount = ao.RigidMass(nodes, mass, centre=centre, inertia=own)
    added = inertia_of(ao.FEModel.from_mesh(BLOCK, STEEL, masses=[mount]))
    added -= inertia_of(ao.FEModel.from_mesh(BLOCK, STEEL))
    cross = np.cross(np.eye(3), centre)
    about_origin = own + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    exact = np.block([[mass * np.eye(3), mass * cross.T], [mass * cross, about_origin]])
    assert added == pytest.approx(exact, abs=1e-12)


def test_a_rigid_mass_at_the_end_of_a_cantilever() -> None:
    """A massless beam with a rigid body at its end: 2 x 2 of deflection and slope.

    Its stiffness there is EI [[12/L³, -6/L²], [-6/L², 4/L]] (Euler and Bernoulli).
    """
    length, side, mass, arm, inertia = 0.5, 0.005, 2.0, 0.05, 1e-3
    light = ao.Material(E=70e9, nu=0.0, rho=25.0)
    bar = ao.box_mesh((length, side, side), (40, 1, 1), kind="hexahedron20")
    mount = ao.RigidMass("xmax", mass, (length + arm, side / 2, side / 2), 3 * (inertia,))
    body = ao.FEModel.from_mesh(
        bar, light, [("xmin", "xyz"), (lambda x: x[:, 1] > -1, "y")], masses=[mount]
    )
    bending = light.E * side**4 / 12.0
    K = bending * np.array([[12 / length**3, -6 / length**2], [-6 / length**2, 4 / length]])
    M = np.array([[mass, mass * arm], [mass * arm, inertia + mass * arm**2]])
    exact = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)) / (2.0 * math.pi)
    assert body.frequencies(2) == pytest.approx(exact, rel=2e-3)  # the beam weighs 0.02 % of it


# K's entries are 1e10 N/m: of springs softer than 10 N/m, its rounding is more than 1e-5.
@pytest.mark.parametrize("stiffness", [10.0, 1e4, 1e8])
def test_springs_however_soft_hold_the_body(stiffness: float) -> None:
    """On springs far softer than itself a body swings as a rigid one: √(k/m)."""
    body = ao.FEModel.from_mesh(
        BLOCK, STEEL, springs=[("zmin", "z", stiffness), ("zmin", "xy", 2.0 * stiffness)]
    )
    assert body.rigid_modes.shape[1] == 0
    assert body.mechanism is None
    assert body.mass is not None
    if stiffness < 1e7:
        low = body.frequencies(6)
        along_z = math.sqrt(stiffness / body.mass) / (2.0 * math.pi)
        assert np.abs(low / along_z - 1.0).min() < 1e-4


def test_a_spring_in_one_direction_leaves_the_other_motions_free() -> None:
    body = ao.FEModel.from_mesh(BLOCK, STEEL, springs=[("zmin", "z", 1e3)])
    assert body.rigid_modes.shape[1] == 3
    total = ao.FEModel.from_mesh(BLOCK, STEEL).K - body.K
    assert -total.sum() == pytest.approx(1e3, rel=1e-4)
    assert "12 springs to the ground" in repr(body)


def test_what_hangs_on_springs_is_no_mechanism() -> None:
    """Two blocks that share an edge turn about it, unless springs hold both."""
    cells = np.vstack([BLOCK.cells, BLOCK.cells + BLOCK.n_nodes])
    nodes = np.vstack([BLOCK.nodes, BLOCK.nodes + np.array([0.06, 0.0, 0.02])])
    merged, number = np.unique(nodes.round(9), axis=0, return_inverse=True)
    mesh = ao.Mesh(merged, number.ravel()[cells], BLOCK.kind)
    assert ao.FEModel.from_mesh(mesh, STEEL).mechanism is not None
    held = ao.FEModel.from_mesh(mesh, STEEL, springs=[(np.arange(len(merged)), "xyz", 1e5)])
    assert held.mechanism is None


# ------------------------------------------------------------------- a tup, by scikit-fem


def test_the_carriage_makes_the_impact_of_its_mass() -> None:
    """On a spring far softer than the tup the whole of its mass is stopped: π √(m/k)."""
    nose = ao.box_mesh((0.02, 0.02, 0.1), (2, 2, 8))
    body = ao.FEModel.from_mesh(nose, STEEL, masses=[("zmax", 5.0)])
    tip = body.contact(point=(0.01, 0.01, 0.0), direction=(0, 0, -1), radius=0.0)
    k, m = 1e6, 5.0 + 7800 * 4e-5
    hit = ao.simulate(projectile=tip, target=ao.rigid(math.inf), law=ao.Linear(k), velocity=2.0)
    assert hit.contact_duration == pytest.approx(math.pi * math.sqrt(m / k), rel=5e-3)
    assert hit.peak_force == pytest.approx(2.0 * math.sqrt(m * k), rel=2e-2)
    assert hit.impulse == pytest.approx(2.0 * m * 2.0, rel=5e-3)


def test_a_mass_on_constrained_nodes_is_said() -> None:
    with pytest.warns(AOImpactWarning, match=r"^masses"):
        ao.FEModel.from_mesh(BLOCK, STEEL, fixed=[("xmin", "xyz")], masses=[("xmin", 5.0)])


def test_a_mass_so_far_off_that_rounding_takes_its_inertia_is_named() -> None:
    far = ao.RigidMass("xmax", 2.0, centre=(0.2, 0.0, 4e9), inertia=(1e-3, 1e-3, 1e-3))
    mesh = ao.box_mesh((0.1, 0.02, 0.02), (3, 1, 1))
    with pytest.warns(AOImpactWarning, match=r"^masses"):
        body = ao.FEModel.from_mesh(mesh, STEEL, masses=[far])
    with pytest.raises(ao.SingularError, match=r"^M"):
        _ = body.rigid_modes
