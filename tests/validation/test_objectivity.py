"""The force of an impact on solids belongs to the bodies, not to their meshes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from bodies import ball_of_octants

from aoimpact.base.errors import AOImpactWarning
from aoimpact.fem.contact import ContactPoint
from aoimpact.fem.halfspace import check_patch
from aoimpact.fem.material import Material
from aoimpact.fem.model import FEModel
from aoimpact.impact.simulate import simulate
from aoimpact.laws import Hertz
from aoimpact.mesh.generate import box_mesh, paper_sphere_mesh, sphere_mesh
from aoimpact.mesh.mesh import Mesh
from aoimpact.reduction.reduction import antioscillators
from aoimpact.reduction.star import AOModel, rigid
from aoimpact.results.result import Result

pytestmark = pytest.mark.slow

FloatArray = npt.NDArray[np.float64]

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
ALU = Material(E=70e9, nu=0.3, rho=2400.0)
SPHERES = Hertz.between(STEEL, 0.01, STEEL, 0.01)
ON_FLAT = Hertz.between(STEEL, 0.01, ALU, float("inf"))
BALL = rigid(mass=0.0327)

# Two spheres at 1 m/s, their contact resolved: test_resolved.py.
FORCE, DURATION = 1014.7, 59.41e-6


def model(tip: ContactPoint, contact_time: float) -> AOModel:
    return antioscillators(tip, n=8, method="krylov", contact_time=contact_time)


def spread(values: Iterable[float]) -> float:
    found = list(values)
    return (max(found) - min(found)) / min(found)


def unresolved_said(make: Callable[[], ContactPoint]) -> tuple[ContactPoint, bool]:
    """A contact point, and whether the mesh was said to be too coarse for it."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        tip = make()
    assert all("too coarse" in str(one.message) for one in said)
    assert all(one.category is AOImpactWarning for one in said)
    return tip, bool(said)


def finer_toward_x(mesh: Mesh, share: float) -> Mesh:
    """The ball's conformal image that is finer about +x and coarser about -x.

    With |a| = `share` the elements there are (1 + a)/(1 - a) times smaller (hyperbolic geometry's
    translation of the unit ball).
    """
    radius = np.abs(mesh.nodes).max()
    x = mesh.nodes / radius
    a = np.array([share, 0.0, 0.0])
    square, along = (x**2).sum(axis=1, keepdims=True), x @ a[:, None]
    moved = (1 + 2 * along + square) * a + (1 - share**2) * x
    return Mesh(radius * moved / (1 + 2 * along + share**2 * square), mesh.cells, mesh.kind)


# ------------------------------------------------------------------------- two spheres

SPHERE_MESHES: dict[str, Callable[[], Mesh]] = {
    "309": lambda: sphere_mesh(0.01, 0.008),
    "309, graded": lambda: finer_toward_x(sphere_mesh(0.01, 0.008), 0.25),
    "377, graded": lambda: finer_toward_x(ball_of_octants(0.01, 3), 0.15),
    "833": lambda: ball_of_octants(0.01, 4),
    "1053": paper_sphere_mesh,
    "2057": lambda: sphere_mesh(0.01, 0.005),
    "2057, graded": lambda: finer_toward_x(sphere_mesh(0.01, 0.005), 0.25),
    "6525": lambda: sphere_mesh(0.01, 0.003),
    "14993": lambda: sphere_mesh(0.01, 0.002),
    "19649": lambda: ball_of_octants(0.01, 12),
}
RADII = (0.0, 0.002, 0.003, 0.004)  # 0: one node


@cache
def sphere(mesh: str) -> FEModel:
    return FEModel.from_mesh(SPHERE_MESHES[mesh](), STEEL)


def pair(tip: ContactPoint) -> Result:
    body = model(tip, 60e-6)
    return simulate(
        projectile=body, target=body, law=SPHERES, velocity=1.0, duration=100e-6, energies=False
    )


@cache
def sphere_pairs(mesh: str) -> dict[float, tuple[Result, bool]]:
    """By radius, the impact, and whether the mesh was said to be too coarse."""
    runs = {}
    for radius in RADII if mesh != "19649" else RADII[1:3]:  # a quarter of a minute each
        tip, coarse = unresolved_said(
            lambda r=radius: sphere(mesh).contact(  # type: ignore[misc]
                point=(0.01, 0, 0), direction=(1, 0, 0), radius=r
            )
        )
        runs[radius] = pair(tip), coarse
    return runs


@pytest.mark.parametrize("mesh", SPHERE_MESHES)
def test_spheres_meet_with_the_resolved_force_on_every_mesh_that_resolves_the_patch(
    mesh: str,
) -> None:
    resolved = [hit for r, (hit, coarse) in sphere_pairs(mesh).items() if r and not coarse]
    assert resolved or mesh == "309"
    for hit in resolved:
        assert hit.peak_force == pytest.approx(FORCE, rel=5e-3)
        assert hit.contact_duration == pytest.approx(DURATION, rel=5e-3)
        assert hit.restitution == pytest.approx(1.0, abs=1e-4)


def test_spheres_agree_across_meshes_and_radii_where_one_node_does_not() -> None:
    assert sphere("377, graded").nodes.shape == (377, 3)  # type: ignore[union-attr]
    assert sphere("19649").nodes.shape == (19649, 3)  # type: ignore[union-attr]
    runs = [sphere_pairs(mesh) for mesh in SPHERE_MESHES]
    patches = [
        hit.peak_force for run in runs for r, (hit, coarse) in run.items() if r and not coarse
    ]
    assert len(patches) >= 16
    assert spread(patches) < 5e-3
    assert spread(run[0.0][0].peak_force for run in runs if 0.0 in run) > 0.1


@pytest.mark.parametrize("radius", [0.0025, 0.003, 0.004])
def test_what_remains_of_the_compliance_tends_to_one_number(radius: float) -> None:
    coarse, middle, fine = (
        check_patch(sphere(mesh).contact(point=(0.01, 0, 0), radius=radius)).remaining[0]
        for mesh in ("2057", "6525", "14993")
    )
    assert abs(fine - middle) < 0.5 * abs(middle - coarse)
    assert fine == pytest.approx(-2.04e-10, rel=0.07)  # m/N, by an independent prototype


# ------------------------------------------------------------------------- beam, plate


def bunched(mesh: Mesh, axes: str, pull: float) -> Mesh:
    """A box whose elements are smaller in the middle, along the axes named."""
    nodes = mesh.nodes.copy()
    for axis in map("xyz".index, axes):
        half = 0.5 * nodes[:, axis].max()
        nodes[:, axis] = half * (1.0 + np.sinh(pull * (nodes[:, axis] / half - 1)) / np.sinh(pull))
    return Mesh(nodes, mesh.cells, mesh.kind, mesh.node_sets)


def struck(body: FEModel, point: tuple[float, float, float], radius: float) -> float:
    tip = body.contact(point=point, direction=(0, 0, -1), radius=radius)
    target = model(tip, 80e-6)
    return simulate(
        projectile=BALL, target=target, law=ON_FLAT, velocity=1.0, duration=400e-6, energies=False
    ).peak_force


def test_a_beam_is_struck_alike_by_bricks_and_tetrahedra() -> None:
    beams = [
        FEModel.from_mesh(
            bunched(box_mesh((0.3, 0.02, 0.02), (24, n, n), kind=kind), "x", 2.0),
            ALU,
            fixed=[("xmin", "xyz"), ("xmax", "xyz")],
        )
        for kind, n in (("hexahedron20", 4), ("hexahedron20", 5), ("tetra10", 4), ("tetra10", 5))
    ]
    point = (0.15, 0.01, 0.02)
    patches = [struck(body, point, radius) for body in beams for radius in (0.005, 0.006)]
    assert spread(patches) < 5e-3
    assert spread(struck(body, point, 0.0) for body in beams) > 0.03


def test_a_plate_8_mm_thick_is_struck_alike_on_every_mesh() -> None:
    plates = [
        FEModel.from_mesh(
            bunched(box_mesh((0.12, 0.12, 0.008), (n, n, layers), kind=kind), "xy", 2.5),
            ALU,
            fixed=[(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")],
        )
        for kind, n, layers in (
            ("hexahedron20", 14, 3),
            ("hexahedron20", 18, 3),
            ("tetra10", 14, 3),
        )
    ]
    point = (0.06, 0.06, 0.008)
    patches = [struck(body, point, radius) for body in plates for radius in (0.003, 0.0035)]
    assert spread(patches) < 5e-3
    assert spread(struck(body, point, 0.0) for body in plates) > 0.03


# ------------------------------------------------------------------------- any form


def pulled(places: FloatArray) -> FloatArray:
    """A ball pulled, twisted and dented into a body of no symmetry."""
    x, y, z = (places / 0.01).T
    return 0.01 * np.stack([1.3 * x + 0.15 * y * z, y + 0.2 * x * x, 0.9 * z + 0.1 * x * y], axis=1)


def freeform(mesh: Mesh) -> Mesh:
    return Mesh(pulled(mesh.nodes), mesh.cells, mesh.kind)


def test_a_free_form_is_struck_alike_along_its_own_normal() -> None:
    point = pulled(0.01 * np.array([[0.48, -0.6, 0.64]]))[0]
    normals, patches, single = [], [], []
    for name in ("1053", "2057", "6525"):
        body = FEModel.from_mesh(freeform(SPHERE_MESHES[name]()), STEEL)
        for radius in (0.0, 0.0035, 0.004):
            tip = body.contact(point=point, radius=radius)
            hit = simulate(
                projectile=BALL,
                target=model(tip, 60e-6),
                law=SPHERES,
                velocity=1.0,
                duration=120e-6,
                energies=False,
            )
            (patches if radius else single).append(hit.peak_force)
            normals.append(tip.direction)
    assert spread(patches) < 5e-3
    assert spread(single) > 0.03
    assert np.ptp(normals, axis=0).max() < 5e-3
    assert np.abs(normals[0]).min() > 0.1  # oblique indeed
