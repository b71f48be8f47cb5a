"""The force of an impact on solids belongs to the bodies, not to their meshes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import pytest

from aoimpact import (
    AOModel,
    ContactPoint,
    FEModel,
    Hertz,
    Material,
    Mesh,
    antioscillators,
    box_mesh,
    paper_sphere_mesh,
    rigid,
    simulate,
    sphere_mesh,
)

pytestmark = pytest.mark.slow

FloatArray = npt.NDArray[np.float64]

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
ALU = Material(E=70e9, nu=0.3, rho=2400.0)
SPHERES = Hertz.between(STEEL, 0.01, STEEL, 0.01)
ON_FLAT = Hertz.between(STEEL, 0.01, ALU, float("inf"))
BALL = rigid(mass=0.0327)


def model(tip: ContactPoint, contact_time: float) -> AOModel:
    return antioscillators(tip, n=8, method="krylov", contact_time=contact_time)


def spread(values: Iterable[float]) -> float:
    found = list(values)
    return (max(found) - min(found)) / min(found)


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
    forces = [struck(body, point, radius) for body in beams for radius in (0.0, 0.002, 0.005)]
    assert spread(forces) < 5e-3


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
    forces = [struck(body, point, radius) for body in plates for radius in (0.0, 0.001, 0.003)]
    assert spread(forces) < 5e-3


# ------------------------------------------------------------------------- any form


def pulled(places: FloatArray) -> FloatArray:
    """A ball pulled, twisted and dented into a body of no symmetry."""
    x, y, z = (places / 0.01).T
    return 0.01 * np.stack([1.3 * x + 0.15 * y * z, y + 0.2 * x * x, 0.9 * z + 0.1 * x * y], axis=1)


def freeform(mesh: Mesh) -> Mesh:
    return Mesh(pulled(mesh.nodes), mesh.cells, mesh.kind)


def test_a_free_form_is_struck_alike_along_its_own_normal() -> None:
    point = pulled(0.01 * np.array([[0.48, -0.6, 0.64]]))[0]
    normals, forces = [], []
    for mesh in (paper_sphere_mesh(), sphere_mesh(0.01, 0.005), sphere_mesh(0.01, 0.003)):
        body = FEModel.from_mesh(freeform(mesh), STEEL)
        for radius in (0.0, 0.002, 0.004):
            tip = body.contact(point=point, radius=radius)
            hit = simulate(
                projectile=BALL,
                target=model(tip, 60e-6),
                law=SPHERES,
                velocity=1.0,
                duration=120e-6,
                energies=False,
            )
            forces.append(hit.peak_force)
            normals.append(tip.direction)
    assert spread(forces) < 5e-3
    assert np.ptp(normals, axis=0).max() < 5e-3
    assert np.abs(normals[0]).min() > 0.1  # oblique indeed
