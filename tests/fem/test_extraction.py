"""The compliance of bodies beyond the half-space at their contact: it belongs to the body alone.

Compliances are in units of 1/(E* a), in which Hertz's contact has 3/4: with R off by 0.001 a force
is off by less than 0.1 %.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from bodies import mixed_box
from scipy.sparse.linalg import spsolve

import aoimpact as ao
from aoimpact import ContactPoint
from aoimpact.contact import Compliance
from aoimpact.mesh import KINDS

FloatArray = npt.NDArray[np.float64]

ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
A = 1e-3
UNIT = ALU.plane_strain_modulus * A
BOX, ON_TOP = (0.06, 0.06, 0.03), (0.0311, 0.0287, 0.03)
S2 = 4.5e9  # of an impact of some 150 µs
LINEAR = ("hexahedron", "tetra", "wedge", "pyramid")
MARKS = dict.fromkeys(("hexahedron", "hexahedron27", "wedge15", "pyramid"), pytest.mark.slow)


def block(kind: str, divisions: tuple[int, int, int], **more: Any) -> ao.FEModel:
    material = more.pop("material", ALU)
    return ao.FEModel.from_mesh(ao.box_mesh(BOX, divisions, kind=kind), material, **more)


def tip_at(body: ao.FEModel, point: Any = ON_TOP, a: float = A, **more: Any) -> ContactPoint:
    return body.contact(point=point, **({"radius": 0} | more)).at_impact(a, body.inverse(S2))


def extraction(body: ao.FEModel, point: Any = ON_TOP, a: float = A, **more: Any) -> Compliance:
    found = tip_at(body, point, a, **more).extraction
    assert found is not None
    return found


def finer(tip: ContactPoint, a: float = A) -> Compliance:
    """The compliances with finer elements."""
    assert tip.finer is not None
    found = tip.finer.at_impact(a, tip.finer.body.inverse(S2)).extraction
    assert found is not None
    return found


def with_error(*at: Any, a: float = A, **more: Any) -> tuple[float, float]:
    """R, and its difference to that with finer elements."""
    tip = tip_at(*at, a=a, **more)
    assert tip.extraction is not None
    beyond = tip.extraction.beyond
    return beyond, abs(finer(tip, a).beyond - beyond)


@cache
def fine() -> Compliance:
    """The compliances of the free block, by 256 bricks of 27 nodes."""
    return extraction(block("hexahedron27", (8, 8, 4)))


# ------------------------------------------------------------- the same on every mesh


@pytest.mark.parametrize("kind", [pytest.param(kind, marks=MARKS.get(kind, ())) for kind in KINDS])
def test_every_kind_of_element_has_the_same_compliance_to_its_error(kind: str) -> None:
    """A discrete w has too little energy, of which finer elements add all but a part."""
    tip = tip_at(block(kind, (6, 6, 3) if kind in LINEAR else (4, 4, 2)))
    assert tip.extraction is not None
    below = fine().beyond - tip.extraction.beyond
    assert 0.0 < UNIT * below < 1e-3
    if kind == "pyramid13":  # has no finer elements
        assert tip.finer is None
        return
    error = finer(tip).beyond - tip.extraction.beyond
    assert UNIT * error < 1e-3
    assert 0.5 * error < below < 2.0 * error


@pytest.mark.parametrize(
    "kind", [pytest.param(of, marks=MARKS.get(of, ())) for of in KINDS if of != "pyramid13"]
)
def test_what_finer_elements_remove_is_the_compliance_of_their_patch(kind: str) -> None:
    """c + R = G of the finer body, with G solved for directly."""
    tip = tip_at(block(kind, (3, 3, 2)), radius=2.0 * A)
    found, finest = finer(tip), tip.finer
    assert finest is not None
    K, M, b = finest.body.K, finest.body.M, finest.b
    G = float(b @ spsolve((K + S2 * M).tocsc(), b))
    assert found.removed + found.beyond == pytest.approx(G, rel=1e-6)


@pytest.mark.slow
def test_elements_that_are_long_and_thin_hardly_change_it() -> None:
    """With w to a residual of 3e-2, R lacks 0.007/(E* a) there."""
    mesh = ao.box_mesh((1.0, 1.0, 1.0), (10, 8, 6), kind="hexahedron20")
    x, y, z = mesh.nodes.T
    y = 2.0 * y - 1.0
    nodes = np.stack(
        [
            BOX[0] * x**2,
            0.0287 + np.where(y < 0.0, 0.0287, 0.0313) * np.sign(y) * np.abs(y) ** 1.5,
            BOX[2] * (1.0 - (1.0 - z) ** 1.7),
        ],
        axis=1,
    )
    graded = ao.Mesh(nodes, mesh.cells, mesh.kind, {"xmin": np.flatnonzero(x == 0.0)})
    body = ao.FEModel.from_mesh(graded, ALU, fixed=[("xmin", "xyz")])
    tip = tip_at(body, (0.004, 0.0287, 0.03))
    assert tip.extraction is not None
    assert UNIT * abs(finer(tip).beyond - tip.extraction.beyond) < 2e-4


def test_elements_of_several_kinds_do_as_well() -> None:
    mesh = mixed_box(BOX, (4, 4, 4), order=2)
    beyond, error = with_error(ao.FEModel.from_mesh(mesh, ALU))
    assert abs(beyond - fine().beyond) < 2.0 * error
    assert UNIT * error < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "divisions", "order"),
    [("hexahedron", (6, 6, 3), 1), ("tetra", (6, 6, 3), 1), ("hexahedron20", (4, 4, 2), 2)],
)
def test_its_error_falls_with_twice_the_order_of_the_elements(
    kind: str, divisions: tuple[int, int, int], order: int
) -> None:
    """R - R_h = O(h^2p), less by an order at most on meshes as coarse as these."""
    errors = [
        fine().beyond - extraction(block(kind, divisions)).beyond,
        fine().beyond - extraction(block(kind, tuple(2 * n for n in divisions))).beyond,  # type: ignore[arg-type]
    ]
    assert math.log2(errors[0] / errors[1]) > 2.0 * order - 1.0


def test_what_is_removed_and_what_is_beyond_are_the_compliance_of_any_patch() -> None:
    """c + R = G; R does not know over which nodes the force is spread, and c has all of that."""
    body = block("hexahedron20", (4, 4, 2))
    solver, at_node = body.inverse(S2), extraction(body)
    for radius in (0.0, 1.0 * A, 1.4 * A, 3.0 * A):
        tip = body.contact(point=ON_TOP, radius=radius).at_impact(A, solver)
        found = tip.extraction
        assert found is not None
        G = float(tip.b @ solver.solve(tip.b))
        assert found.removed + found.beyond == pytest.approx(G, rel=1e-10)
        assert found.beyond == pytest.approx(at_node.beyond, rel=1e-6)


def test_the_contact_s_own_radius_hardly_matters() -> None:
    """R of a block is that of a point force, and a change of a second order of its width."""
    body = block("hexahedron20", (4, 4, 2))
    (wide, error), (narrow, other) = (with_error(body, a=a) for a in (2.0 * A, 0.25 * A))
    assert wide == pytest.approx(narrow, abs=2.0 * (error + other))
    assert abs(wide - narrow) * UNIT < 1e-3


@pytest.mark.slow
def test_on_a_ball_of_a_few_tetrahedra_it_is_that_of_many() -> None:
    """The mean of w under the pressure is 0.004/(E* a) off there, its energy 0.001/(E* a)."""
    (few, error), (many, _) = (
        with_error(ao.FEModel.from_mesh(ao.sphere_mesh(0.01, size), STEEL), (0.0, 0.0, 0.01))
        for size in (0.005, 0.003)
    )
    unit = STEEL.plane_strain_modulus * A
    assert unit * few == pytest.approx(unit * many, abs=2e-3)
    assert unit * error < 1e-3


# ------------------------------------------------------------------------- invariances


def test_turned_moved_and_scaled_bodies_have_the_same_compliance() -> None:
    mesh = ao.box_mesh(BOX, (4, 4, 2), kind="tetra10")
    here = extraction(ao.FEModel.from_mesh(mesh, ALU))
    turn = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    shift = np.array([0.3, -0.2, 0.7])
    turned = ao.Mesh(mesh.nodes @ turn.T + shift, mesh.cells, mesh.kind)
    there = extraction(ao.FEModel.from_mesh(turned, ALU), turn @ ON_TOP + shift)
    assert there.beyond == pytest.approx(here.beyond, rel=1e-6)
    assert there.removed == pytest.approx(here.removed, rel=1e-6)
    # Lengths three times as large at a third of the frequency: compliances are a third.
    large = ao.FEModel.from_mesh(ao.Mesh(3.0 * mesh.nodes, mesh.cells, mesh.kind), ALU)
    tip = large.contact(point=3.0 * np.array(ON_TOP), radius=0)
    scaled = tip.at_impact(3.0 * A, large.inverse(S2 / 9.0)).extraction
    assert scaled is not None
    assert 3.0 * scaled.beyond == pytest.approx(here.beyond, rel=1e-6)
    assert 3.0 * scaled.removed == pytest.approx(here.removed, rel=1e-6)


def test_a_projectile_has_the_compliance_that_it_has_as_a_target() -> None:
    body = block("hexahedron20", (4, 4, 2))
    into, out = (extraction(body, direction=(0, 0, sign)) for sign in (-1, 1))
    assert out.removed == pytest.approx(into.removed, rel=1e-12)
    np.testing.assert_allclose(out.mesh_field, into.mesh_field, atol=1e-6 * A / UNIT)
    tip = tip_at(body)
    assert tip.reversed.extraction is tip.extraction


# ------------------------------------------------------- supports, masses and springs


def test_far_masses_and_springs_leave_what_is_removed() -> None:
    """It stands for the half-space under the contact. All that is far off is in R."""
    free = extraction(block("hexahedron20", (3, 3, 2)))
    for more in (
        {"masses": [("xmin", 0.5)]},
        {"springs": [("zmin", "z", 3e9)]},
        {"fixed": [("zmin", "z")]},
        {"fixed": [("zmin", "xyz")]},
    ):
        found = extraction(block("hexahedron20", (3, 3, 2), **more))
        assert abs(found.beyond - free.beyond) > 0.01 / UNIT
        assert found.removed == pytest.approx(free.removed, abs=1e-3 / UNIT)


@pytest.mark.slow
def test_next_to_a_clamped_face_meshes_agree() -> None:
    """4 mm from it, in elements of 10 and 5 mm: finer elements know the rest better there."""
    places = [
        ("hexahedron20", (6, 6, 4)),
        ("tetra10", (6, 6, 4)),
        ("hexahedron20", (12, 6, 6)),
        ("tetra10", (12, 12, 8)),
    ]
    found = []
    for kind, divisions in places:
        tip = tip_at(block(kind, divisions, fixed=[("xmin", "xyz")]), (0.004, 0.0287, 0.03))
        assert tip.extraction is not None
        found.append((finer(tip).beyond, abs(finer(tip).beyond - tip.extraction.beyond)))
    *coarse, (best, rest) = found
    for beyond, error in coarse:
        assert beyond == pytest.approx(best, abs=error + rest)
        assert UNIT * error < 2e-3
    # Clamped, the body gives way less there than the half-space does.
    assert all(beyond < 0.0 for beyond, _ in found)


# --------------------------------------------------------------------------- materials


def layered(kind: str, divisions: tuple[int, int, int], thick: float = 0.003) -> ao.Mesh:
    """The block with its highest layer of elements as a group, 3 mm thick."""
    mesh = ao.box_mesh((*BOX[:2], 1.0), divisions, kind=kind)
    below = 1.0 - 1.0 / divisions[2]
    z = mesh.nodes[:, 2]
    height = np.interp(z, [0.0, below, 1.0], [0.0, BOX[2] - thick, BOX[2]])
    nodes = np.column_stack([mesh.nodes[:, :2], height])
    skin = z[mesh.cells].mean(axis=1) > below
    sets = {"skin": np.flatnonzero(skin), "core": np.flatnonzero(~skin)}
    return ao.Mesh(nodes, mesh.cells, kind, mesh.node_sets, sets)


@pytest.mark.slow
def test_under_a_steel_skin_on_aluminium_meshes_agree() -> None:
    *coarse, (best, rest) = [
        with_error(ao.FEModel.from_mesh(layered(kind, divisions), {"skin": STEEL, "core": ALU}))
        for kind, divisions in (
            ("hexahedron20", (6, 6, 3)),
            ("tetra10", (8, 8, 3)),
            ("hexahedron20", (10, 10, 4)),
        )
    ]
    for beyond, error in coarse:
        assert beyond == pytest.approx(best, abs=error + rest)
    # The core is softer than the half-space of steel.
    assert best > 2.0 * fine().beyond


@pytest.mark.slow
def test_on_a_ply_meshes_agree() -> None:
    ply = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    (one, error), (other, rest) = [
        with_error(block(kind, divisions, material=ply))
        for kind, divisions in (("tetra10", (3, 3, 2)), ("hexahedron20", (5, 5, 3)))
    ]
    assert one == pytest.approx(other, abs=error + rest)


# ----------------------------------------------------------------------- curved bodies


def tube(kind: str, divisions: tuple[int, int, int]) -> ao.FEModel:
    """40 mm long, with radii of 12 and 16 mm: a box that was bent and welded to a ring."""
    mesh = ao.box_mesh((0.004, 1.0, 0.04), divisions, kind=kind)
    r, turn = 0.012 + mesh.nodes[:, 0], 2.0 * np.pi * mesh.nodes[:, 1]
    places = np.column_stack([r * np.cos(turn), r * np.sin(turn), mesh.nodes[:, 2] - 0.02])
    nodes, number = np.unique(places.round(9), axis=0, return_inverse=True)
    return ao.FEModel.from_mesh(ao.Mesh(nodes, number.ravel()[mesh.cells], kind), ALU)


@pytest.mark.slow
@pytest.mark.parametrize("x", [0.016, 0.012], ids=["outside", "inside"])
def test_of_a_tube_meshes_agree(x: float) -> None:
    """From inside the tube goes round behind the contact, where the half-space's field ends."""
    bodies = [tube("hexahedron20", divisions) for divisions in ((1, 16, 6), (2, 24, 10))]
    assert extraction(bodies[0], (x, 0.0, 0.0)).splitting.behind == (x == 0.012)
    (coarse, error), (middle, rest) = (with_error(body, (x, 0.0, 0.0)) for body in bodies)
    assert coarse == pytest.approx(middle, abs=error + rest)


@pytest.mark.slow
def test_a_ball_has_the_compliance_of_an_independent_prototype() -> None:
    """-2.04e-10 m/N beyond the half-space and the ball's own motion."""
    a, s2 = 3e-4, (10.0 / 60e-6) ** 2
    for size in (0.005, 0.003):
        ball = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, size), STEEL)
        assert ball.mass is not None
        tip = ball.contact(point=(0.01, 0.0, 0.0), radius=0).at_impact(a, ball.inverse(s2))
        assert tip.extraction is not None
        within = 1e-3 / (STEEL.plane_strain_modulus * a)
        elastic = tip.extraction.beyond - 1.0 / (s2 * ball.mass)
        assert elastic == pytest.approx(-2.04e-10, abs=within)


# -------------------------------------------------------------------- edges and others


def test_at_edges_and_corners_there_is_no_half_space() -> None:
    body = block("hexahedron", (3, 3, 2))
    for point in ((0.02, 0.0, 0.03), (0.0, 0.0, 0.03)):
        tip = body.contact(point=point, direction=(0.0, 0.0, -1.0), radius=0)
        assert tip.extraction is None


def test_what_has_neither_mesh_nor_place_has_none() -> None:
    body = block("hexahedron", (3, 3, 2))
    assert body.contact(dof=5).extraction is None
    bare = ao.FEModel(K=body.K, M=body.M, nodes=body.nodes)
    assert bare.contact(point=(0.02, 0.02, 0.03), direction=(0, 0, -1)).extraction is None


def test_a_force_aslant_finds_mindlin_s_share_of_the_half_space() -> None:
    """Along a surface a half-space gives way (2 - ν)/(2 - 2ν) of what it does across."""
    body = block("hexahedron20", (6, 6, 3))
    across = extraction(body, radius=2.0 * A).removed
    aslant = extraction(body, direction=(0.6, 0.0, -0.8), radius=2.0 * A).removed
    ratio = (2.0 - ALU.nu) / (2.0 - 2.0 * ALU.nu)
    assert aslant / across == pytest.approx(0.64 + 0.36 * ratio, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "divisions"),
    [("hexahedron", (6, 6, 4)), ("tetra", (6, 6, 4)), ("tetra10", (4, 4, 3))],
)
def test_near_an_edge_meshes_agree_on_how_a_normal_force_moves_the_surface_sideways(
    kind: str, divisions: tuple[int, int, int]
) -> None:
    def beyond(kind: str, divisions: tuple[int, int, int]) -> list[FloatArray]:
        """Of the elements themselves, and of finer ones."""
        mesh = ao.box_mesh((0.03, 0.03, 0.02), divisions, kind=kind)
        body = ao.FEModel.from_mesh(mesh, ALU)
        tip = body.contact(point=(0.0155, 0.004, 0.02), radius=0)
        tip = replace(tip, tangents=np.eye(3)[:2]).at_impact(A, body.inverse(S2))
        found = []
        for of, at in ((tip, tip.extraction), (tip.finer, finer(tip))):
            assert at is not None
            assert of is not None
            assert at.oblique is not None
            inverse, loads = of.body.inverse(S2), [each.b for each in of.functionals]
            moved = np.array([[one @ inverse.solve(load) for load in loads] for one in loads])
            found.append(UNIT * (moved - at.oblique)[0, 1:])
        return found

    right, best = beyond("hexahedron20", (8, 8, 6))
    coarse, finer_one = beyond(kind, divisions)
    apart = float(np.linalg.norm(finer_one - best))
    assert apart <= np.linalg.norm(coarse - finer_one) + np.linalg.norm(right - best)
    assert apart < 0.002  # of 0.4 that it is
    assert np.linalg.norm(best) > 0.4
