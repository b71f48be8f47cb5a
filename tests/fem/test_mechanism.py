"""Pieces that swing about what they share with the rest: found by rank, and named at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rows import each

import aoimpact as ao
from aoimpact import box_mesh
from aoimpact.mesh import KINDS

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
D = 0.02

# Where equal blocks stand, in their own widths; which joints they make is in the name.
SHAPES = {
    "a block": [(0, 0, 0)],
    "two by a face": [(0, 0, 0), (1, 0, 0)],
    "two by an edge": [(0, 0, 0), (1, 0, 1)],
    "two at a point": [(0, 0, 0), (1, 1, 1)],
    "two apart": [(0, 0, 0), (2, 0, 0)],
    "three by parallel edges": [(0, 0, 0), (1, 0, 1), (0, 0, 2)],
    "a ring of four by parallel edges": [(0, 0, 0), (1, 0, 1), (0, 0, 2), (-1, 0, 1)],
    "three by edges across each other": [(0, 0, 0), (1, 1, 0), (0, 1, 1)],
}


def end(x: Any) -> Any:
    return x[:, 0] < x[:, 0].min() + 1e-9


def blocks(places: Any, kind: str = "hexahedron", each: Any = (1, 2, 1)) -> ao.Mesh:
    """Blocks of some elements each; nodes at the same place are one."""
    block = box_mesh((D, D, D), each, kind=kind)
    nodes = np.vstack([block.nodes + D * np.array(place) for place in places])
    cells = np.vstack([block.cells + block.n_nodes * i for i in range(len(places))])
    _, first, number = np.unique(nodes.round(9), axis=0, return_index=True, return_inverse=True)
    return ao.Mesh(nodes[first], number.ravel()[cells], kind)


def motions_without_force(body: ao.FEModel) -> int:
    """By the eigenvalues of K."""
    values = np.linalg.eigvalsh(body.K.toarray())
    return int((values < 1e-10 * values[-1]).sum())


def found(body: ao.FEModel) -> int:
    loose = body.mechanism
    motions = np.zeros((body.n_dofs, 0)) if loose is None else loose.motions
    every = np.column_stack([body.rigid_modes, motions])
    np.testing.assert_allclose(every.T @ (body.M @ every), np.eye(every.shape[1]), atol=1e-9)
    strained = np.abs(body.K @ motions).max(initial=0.0)
    assert strained <= 1e-11 * body.K.diagonal().max() * np.abs(motions).max(initial=0.0)
    return every.shape[1]


@pytest.mark.filterwarnings("ignore:.*parts that share no nodes")
@each("fixed", [None, [(end, "xyz")], [(end, "x")]])
@each("shape", SHAPES)
def test_motions_without_force_are_rigid_ones_and_mechanisms(shape: str, fixed: Any) -> None:
    for kind in KINDS[::2] if fixed is None else ("hexahedron",):
        body = ao.FEModel.from_mesh(blocks(SHAPES[shape], kind), STEEL, fixed=fixed)
        assert found(body) == motions_without_force(body), kind


@pytest.mark.filterwarnings("ignore:.*parts that share no nodes")
@each("seed", range(6))
def test_elements_joined_at_random(seed: int) -> None:
    """Some of the cells of a box: loose ones, joints, rings of joints, and parts of several."""
    whole = box_mesh((3 * D, 3 * D, 3 * D), (3, 3, 3))
    chosen = np.random.default_rng(seed).random(whole.n_cells) < (0.3, 0.5)[seed % 2]
    used, cells = np.unique(whole.cells[chosen], return_inverse=True)
    mesh = ao.Mesh(whole.nodes[used], cells.reshape(-1, 8), whole.kind)
    for fixed in (None, [(end, "xyz")]):
        body = ao.FEModel.from_mesh(mesh, STEEL, fixed=fixed)
        assert found(body) == motions_without_force(body)


@pytest.mark.slow
def test_every_edge_of_a_staircase_is_a_hinge() -> None:
    """More motions of parts than dense matrices are taken for."""
    stairs = blocks([(i, 0, i) for i in range(90)], each=(1, 1, 1))
    assert found(ao.FEModel.from_mesh(stairs, STEEL)) == 6 + 89


@each("digits", [6, 5])
def test_a_hinge_of_rounded_coordinates_is_one(digits: int) -> None:
    """Turned in space, its nodes are on a line only as far as a mesh file has digits."""
    mesh = blocks(SHAPES["two by an edge"], "hexahedron20")
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    nodes = np.vectorize(lambda x: float(f"{x:.{digits}g}"))(mesh.nodes @ turn.T)
    body = ao.FEModel.from_mesh(ao.Mesh(nodes, mesh.cells, mesh.kind), STEEL)
    corner = nodes[mesh.nodes.sum(axis=1).argmax()]
    tip = body.contact(point=corner, direction=turn @ [0, -0.3, -1], radius=0)
    with pytest.raises(ao.SingularError, match="mechanism"):
        ao.antioscillators(tip, 3, method="krylov")


@each("fixed", [None, [(end, "xyz")]])
@each("shape", ["two by an edge", "two at a point"])
@each(
    "settings",
    [
        {"n": 0, "method": "krylov"},
        {"n": 3, "method": "krylov"},
        {"n": 12, "method": "krylov", "contact_time": 1e-4},
        {"n": 3},
        {"n": 3, "order": "frequency"},
    ],
)
def test_a_mechanism_that_the_contact_moves_is_named(
    shape: str, fixed: Any, settings: dict[str, Any]
) -> None:
    """However few oscillators are asked for, with the joint where it is."""
    mesh = blocks(SHAPES[shape], "hexahedron20")
    tip = ao.FEModel.from_mesh(mesh, STEEL, fixed=fixed).contact(
        point=mesh.nodes.max(axis=0), direction=(0, -0.3, -1), radius=0
    )
    with pytest.raises(ao.SingularError, match=r"^part"):
        ao.antioscillators(tip, **settings)


def test_a_mechanism_that_the_contact_does_not_move_does_no_harm() -> None:
    """Struck along the hinge and in its plane of symmetry, two blocks are what they are welded."""
    swinging = ao.FEModel.from_mesh(blocks(SHAPES["two by an edge"], "hexahedron20"), STEEL)
    tip = swinging.contact(point=(D, 0, D), direction=(0, 1, 0), radius=0)
    assert swinging.mechanism is not None
    assert not swinging.mechanism.moved_by(tip.b)
    few = ao.antioscillators(tip, 8, method="krylov", contact_time=2e-5)
    every = ao.antioscillators(tip, order="frequency")
    assert few.k0 == every.k0 == 0.0
    assert few.static_mass == pytest.approx(every.static_mass, rel=1e-9)
    np.testing.assert_allclose(few.frequencies[:2], every.frequencies[:2], rtol=1e-3)


@each("fixed", [None, [(end, "xyz")], [(end, "x")]])
@each("fine", [False, True])
@each("shape", ["two by a face", "two by an edge", "two at a point"])
def test_nodes_without_a_mesh(shape: str, fine: bool, fixed: Any) -> None:
    """The matrices alone say so, too, up to what is factorised to check them."""
    kind = "hexahedron27" if fine else "hexahedron"
    mesh = blocks(SHAPES[shape], kind, (2, 3, 2) if fine else (1, 2, 1))
    whole = ao.FEModel.from_mesh(mesh, STEEL, fixed=fixed)
    body = ao.FEModel(K=whole.K, M=whole.M, nodes=mesh.nodes, free=whole.free)
    if shape == "two by a face":
        assert body.mechanism is None
        return
    assert body.mechanism is not None
    assert whole.mechanism is not None
    # It is one of those that the mesh has.
    part = whole.mechanism.motions.T @ (body.M @ body.mechanism.motions[:, 0])
    assert np.linalg.norm(part) == pytest.approx(1.0, rel=1e-6)
    tip = body.contact(point=mesh.nodes.max(axis=0), direction=(0, -0.3, -1), radius=0)
    for method in ("eigen", "krylov"):
        with pytest.raises(ao.SingularError, match=r"^part"):
            ao.antioscillators(tip, 3, method=method)


def test_matrices_alone_count_a_hinge_among_the_rigid_motions() -> None:
    """Seen from a dof that swings the body weighs less than without the hinge, and is right."""
    whole = ao.FEModel.from_mesh(blocks(SHAPES["two by an edge"]), STEEL)
    bare = ao.FEModel(K=whole.K, M=whole.M)
    assert bare.rigid_modes.shape[1] == 7
    dof = int(np.abs(whole.mechanism.motions[:, 0]).argmax()) if whole.mechanism else 0
    r = bare.rigid_modes[dof]
    star = ao.antioscillators(bare.contact(dof=dof), 4, method="krylov")
    assert star.static_mass == pytest.approx(1.0 / (r @ r), rel=1e-9)
    assert star.static_mass < 0.9 / (whole.rigid_modes[dof] @ whole.rigid_modes[dof])
