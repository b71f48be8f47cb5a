"""What is read of runs with finer elements than the bodies were meshed with."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy

import aoimpact as ao

ALUMINIUM = ao.Material(E=70e9, nu=0.0, rho=2700)
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
LENGTH, WIDTH, HEIGHT = 0.2, 0.02, 0.02
SECOND = WIDTH * HEIGHT**3 / 12

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*elements of first order"),
    pytest.mark.filterwarnings("ignore:.*may be off by"),
    pytest.mark.filterwarnings("ignore:.*the mesh makes an error"),
]


@pytest.fixture(
    scope="module", params=["tetra", "hexahedron", pytest.param("wedge", marks=pytest.mark.slow)]
)
def bent(request: Any) -> Any:
    """A cantilever of one layer of elements, pushed so slowly that it bends statically."""
    mesh = ao.box_mesh((LENGTH, WIDTH, HEIGHT), (8, 1, 1), kind=request.param)
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz")])
    b = np.zeros(body.nodes.shape)
    b[mesh.node_sets["xmax"], 2] = -0.25
    end = body.contact(b=b.ravel()[body.free])
    law = ao.Linear(k=1e3)
    return ao.simulate(ao.rigid(mass=10.0), end, 0.1, law=law, duration=0.4, quantity="force")


def test_a_cantilever_of_elements_that_lock_bends_as_a_beam(bent: Any) -> None:
    """F x² (3L - x)/6EI with shear 1.2 F x/GA, between nodes as well; ±F (L - x) h/2I in it."""
    now, force = [bent.peak_time], bent.peak_force
    x = np.array([0.06, 0.08, 0.1, 0.1125, 0.125])
    line = np.column_stack([x, np.full((len(x), 2), 0.5 * WIDTH)])
    sag = bent.target.probe(line, (0, 0, -1), times=now).displacement[0]
    sheared = 1.2 * force * x / (0.5 * ALUMINIUM.E * WIDTH * HEIGHT)
    beam = force * x**2 * (3 * LENGTH - x) / (6 * ALUMINIUM.E * SECOND) + sheared
    assert sag == pytest.approx(beam, rel=0.02)
    moment = force * (LENGTH - x)
    for z, sign in ((0.0, -1), (HEIGHT, 1)):
        line[:, 2] = z
        probe = bent.target.probe(line, times=now)
        direct = sign * moment * 0.5 * HEIGHT / SECOND
        assert probe.stress["xx"][0] == pytest.approx(direct, rel=0.05)
        assert probe.strain["xx"][0] == pytest.approx(direct / ALUMINIUM.E, rel=0.05)
    gauge = bent.target.gauge((0.1, 0.01, HEIGHT), (1, 0, 0), 0.03, times=now).strain
    strain = force * (LENGTH - 0.1) * 0.5 * HEIGHT / (ALUMINIUM.E * SECOND)
    assert gauge == pytest.approx([strain], rel=0.02)
    # On average over some periods of the vibrations aside, which tetrahedra are not alike to.
    around = now[0] + np.linspace(-2e-3, 2e-3, 41)
    reaction = bent.target.reaction("xmin", times=around)
    assert reaction.force.mean(axis=0) == pytest.approx([0, 0, force], rel=0.01, abs=1e-3 * force)
    about = [0, -force * LENGTH, 0]
    assert reaction.moment.mean(axis=0) == pytest.approx(about, rel=0.01, abs=1e-3 * force * LENGTH)
    assert reaction.nodal_force[0].sum(axis=0) == pytest.approx(reaction.force[0], abs=1e-6 * force)


def test_a_field_is_that_of_the_given_mesh(bent: Any, tmp_path: Any) -> None:
    body, field = bent.models[1].body.given, bent.target.field()
    assert field.body is body
    assert field.displacement.shape == (1, len(body.nodes), 3)
    at = bent.target.probe(nodes=[5, 12], times=field.times)
    assert at.displacement == pytest.approx(field.displacement[:, [5, 12]], rel=1e-9)
    stress = field.stress()
    assert at.stress.components == pytest.approx(stress.components[:, [5, 12]], rel=1e-6)
    own = body.mesh.blocks[0].element.stiffness_rule.points
    assert field.stress("gauss").components.shape == (1, body.mesh.n_cells, len(own), 6)
    assert field.to_vtu(tmp_path / "bar").name == "bar.pvd"
    # The elements as they were meshed bend too little, by more than the largest of what they say.
    assert np.max(at.error["displacement"]) > 0.2


@pytest.mark.parametrize("kind", ["hexahedron20", pytest.param("tetra", marks=pytest.mark.slow)])
def test_what_holds_a_plate_and_the_blow_change_its_momentum(kind: str) -> None:
    """m x(t) of its centre of mass is ∫∫ F + R: with added masses, springs, two materials."""
    box = ao.box_mesh((0.1, 0.08, 0.01), (6, 4, 1), kind=kind)
    left = box.nodes[box.cells].mean(axis=1)[:, 0] < 0.05
    groups = {"left": np.flatnonzero(left), "right": np.flatnonzero(~left)}
    mesh = ao.Mesh(box.nodes, box.cells, kind, box.node_sets, groups)
    body = ao.FEModel.from_mesh(
        mesh,
        {"left": ALUMINIUM, "right": STEEL},
        fixed=[("xmin", "xyz")],
        masses=[(lambda x: (x[:, 0] > 0.03) & (x[:, 1] == 0.0), 0.05)],
        springs=[("xmax", "z", 1e7)],
    )
    struck = body.contact(point=(0.055, 0.04, 0.01))
    hit = ao.simulate(ao.ball(0.01, STEEL), struck, 1.0, duration=2e-4)
    t = np.linspace(0.0, 2e-4, 4001)
    held = -hit.target.reaction(times=t).force[:, 2]
    pushed = np.interp(t, hit.t, hit.force)
    for _ in range(2):
        held, pushed = (
            scipy.integrate.cumulative_simpson(of, x=t, initial=0.0) for of in (held, pushed)
        )
    moved = body.mass * np.interp(t, hit.t, hit.target.centre_displacement)
    assert pushed + held == pytest.approx(moved, abs=2e-3 * np.abs(pushed).max())
    assert np.abs(held).max() > 0.1 * np.abs(pushed).max()
