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


def block(kind: str, divisions: tuple[int, int, int], **more: Any) -> ao.FEModel:
    material = more.pop("material", ALU)
    return ao.FEModel.from_mesh(ao.box_mesh(BOX, divisions, kind=kind), material, **more)


def tip_at(body: ao.FEModel, point: Any = ON_TOP, a: float = A, **more: Any) -> ContactPoint:
    return body.contact(point=point, **({"radius": 0} | more)).at_impact(a, body.inverse(S2))


def extraction(body: ao.FEModel, point: Any = ON_TOP, a: float = A, **more: Any) -> Compliance:
    found = tip_at(body, point, a, **more).extraction
    assert found is not None
    return found


@cache
def fine() -> Compliance:
    """The compliances of the free block, by 256 bricks of 27 nodes."""
    return extraction(block("hexahedron27", (8, 8, 4)))


# ------------------------------------------------------------- the same on every mesh


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_element_has_the_same_compliance_to_its_error(kind: str) -> None:
    found = extraction(block(kind, (6, 6, 3) if kind in LINEAR else (4, 4, 2)))
    assert abs(found.beyond - fine().beyond) < 2.0 * found.error
    assert UNIT * found.error < 1e-3
    # A discrete w has too little energy, which the stress of neighbouring elements tells.
    below = fine().beyond - found.splitting.compliance
    assert 0.5 * found.error < below < 3.0 * found.error


def test_elements_of_several_kinds_do_as_well() -> None:
    mesh = mixed_box(BOX, (4, 4, 4), order=2)
    found = extraction(ao.FEModel.from_mesh(mesh, ALU))
    assert abs(found.beyond - fine().beyond) < 2.0 * found.error
    assert UNIT * found.error < 1e-3


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
        fine().beyond - extraction(block(kind, divisions)).splitting.compliance,
        fine().beyond
        - extraction(block(kind, tuple(2 * n for n in divisions))).splitting.compliance,  # type: ignore[arg-type]
    ]
    assert math.log2(errors[0] / errors[1]) > 2.0 * order - 1.0


@pytest.mark.parametrize(
    "radius",
    [
        0.0,
        pytest.param(1.0 * A, marks=pytest.mark.slow),
        pytest.param(1.4 * A, marks=pytest.mark.slow),
        3.0 * A,
    ],
)
def test_what_is_removed_and_what_is_beyond_are_the_compliance_of_any_patch(radius: float) -> None:
    """c + R = G; R does not know over which nodes the force is spread, and c has all of that."""
    body = block("hexahedron20", (4, 4, 2))
    tip = tip_at(body, radius=radius)
    found = tip.extraction
    assert found is not None
    G = float(tip.b @ body.inverse(S2).solve(tip.b))
    assert found.removed + found.beyond == pytest.approx(G, rel=1e-10)
    assert found.beyond == pytest.approx(extraction(body).beyond, rel=1e-6)


def test_the_contact_s_own_radius_hardly_matters() -> None:
    """R of a block is that of a point force, and a change of a second order of its width."""
    body = block("hexahedron20", (4, 4, 2))
    wide, narrow = (extraction(body, a=a) for a in (2.0 * A, 0.25 * A))
    assert wide.beyond == pytest.approx(narrow.beyond, abs=2.0 * wide.error + 2.0 * narrow.error)
    assert abs(wide.beyond - narrow.beyond) * UNIT < 1e-3


@pytest.mark.slow
def test_on_a_ball_of_a_few_tetrahedra_it_is_that_of_many() -> None:
    """The mean of w under the pressure is 0.004/(E* a) off there, its energy 0.001/(E* a)."""
    few, many = (
        extraction(ao.FEModel.from_mesh(ao.sphere_mesh(0.01, size), STEEL), (0.0, 0.0, 0.01))
        for size in (0.005, 0.003)
    )
    unit = STEEL.plane_strain_modulus * A
    assert unit * few.beyond == pytest.approx(unit * many.beyond, abs=2e-3)
    assert unit * few.error < 1e-3


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
    free = extraction(block("hexahedron20", (4, 4, 2)))
    for more in (
        {"masses": [("xmin", 0.5)]},
        {"springs": [("zmin", "z", 3e9)]},
        {"fixed": [("zmin", "z")]},
        {"fixed": [("zmin", "xyz")]},
    ):
        found = extraction(block("hexahedron20", (4, 4, 2), **more))
        assert abs(found.beyond - free.beyond) > 0.01 / UNIT
        assert found.removed == pytest.approx(free.removed, abs=1e-3 / UNIT)


@pytest.mark.slow
def test_next_to_a_clamped_face_meshes_agree() -> None:
    """4 mm from it, in elements of 10 and 5 mm."""
    places = [
        ("hexahedron20", (6, 6, 4)),
        ("tetra10", (6, 6, 4)),
        ("hexahedron20", (12, 6, 6)),
    ]
    found = [
        extraction(block(kind, divisions, fixed=[("xmin", "xyz")]), (0.004, 0.0287, 0.03))
        for kind, divisions in places
    ]
    for one in found[:2]:
        assert one.beyond == pytest.approx(found[2].beyond, abs=one.error + found[2].error)
    # Clamped, the body gives way less there than the half-space does.
    assert all(one.beyond < 0.0 for one in found)


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
    found = [
        extraction(ao.FEModel.from_mesh(layered(kind, divisions), {"skin": STEEL, "core": ALU}))
        for kind, divisions in (
            ("hexahedron20", (6, 6, 3)),
            ("tetra10", (8, 8, 3)),
            ("hexahedron20", (10, 10, 4)),
        )
    ]
    for one in found[:2]:
        assert one.beyond == pytest.approx(found[2].beyond, abs=one.error + found[2].error)
    # The core is softer than the half-space of steel.
    assert found[2].beyond > 2.0 * fine().beyond


@pytest.mark.slow
def test_on_a_ply_meshes_agree() -> None:
    ply = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    found = [
        extraction(block(kind, divisions, material=ply))
        for kind, divisions in (("tetra10", (3, 3, 2)), ("hexahedron20", (5, 5, 3)))
    ]
    assert found[0].beyond == pytest.approx(found[1].beyond, abs=found[0].error + found[1].error)


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
    coarse, middle = (
        extraction(tube(*of), (x, 0.0, 0.0))
        for of in (("hexahedron20", (1, 16, 6)), ("hexahedron20", (2, 24, 10)))
    )
    assert coarse.splitting.behind == (x == 0.012)
    assert coarse.beyond == pytest.approx(middle.beyond, abs=coarse.error + middle.error)


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


@pytest.mark.parametrize(
    ("kind", "divisions"),
    [
        ("hexahedron", (6, 6, 4)),
        *(
            pytest.param(*of, marks=pytest.mark.slow)
            for of in (("tetra", (6, 6, 4)), ("tetra10", (4, 4, 3)))
        ),
    ],
)
def test_near_an_edge_meshes_agree_on_how_a_normal_force_moves_the_surface_sideways(
    kind: str, divisions: tuple[int, int, int]
) -> None:
    def beyond(kind: str, divisions: tuple[int, int, int]) -> tuple[FloatArray, Compliance]:
        mesh = ao.box_mesh((0.03, 0.03, 0.02), divisions, kind=kind)
        body = ao.FEModel.from_mesh(mesh, ALU)
        tip = body.contact(point=(0.0155, 0.004, 0.02), radius=0)
        tip = replace(tip, tangents=np.eye(3)[:2]).at_impact(A, body.inverse(S2))
        found = tip.extraction
        assert found.oblique is not None
        inverse, loads = body.inverse(S2), [of.b for of in tip.functionals]
        moved = np.array([[one @ inverse.solve(load) for load in loads] for one in loads])
        return UNIT * (moved - found.oblique), found

    right, best = beyond("hexahedron20", (8, 8, 6))
    coarse, found = beyond(kind, divisions)
    assert found.crosswise is not None
    assert best.crosswise is not None
    apart = float(np.linalg.norm((coarse - right)[0, 1:]))
    assert apart <= UNIT * float(np.linalg.norm(found.crosswise + best.crosswise))
    assert apart < 0.01  # of 0.1 that it is
    assert np.linalg.norm(right[0, 1:]) > 0.1
