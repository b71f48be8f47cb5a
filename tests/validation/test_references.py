"""Default impacts against references: contact resolved by axisymmetric elements, fine meshes."""

from __future__ import annotations

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)


def is_within_its_error(hit: ao.Result, reference: float, most: float) -> None:
    true = abs(hit.peak_force / reference - 1.0)
    total = hit.error["peak_force"].total
    assert total is not None
    assert true < min(total, most), f"{hit.peak_force:.2f} N, {true:.2%}, ± {total:.2%}"


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.009, pytest.param(0.006, marks=pytest.mark.slow)])
def test_two_balls_of_aluminium(size: float) -> None:
    """R 20 mm, 4 m/s: 7446 N with contact resolved by explicit elements of 8 µm."""
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(radius=0.02, size=size), ALU)
    top, bottom = (ball.contact(point=(0.0, 0.0, z)) for z in (0.02, -0.02))
    is_within_its_error(ao.simulate(top, bottom, 4.0), 7446.0, 3e-3)


def disc(around: int, layers: int) -> ao.FEModel:
    """R 30 mm, 6 mm thick: a box whose squares became circles, finer toward its middle."""
    mesh = ao.box_mesh((2.0, 2.0, 0.006), (around, around, layers), kind="hexahedron20")
    x, y = (0.5 * c + 0.5 * c**3 for c in (mesh.nodes[:, :2] - 1.0).T)
    flat = np.stack([x * np.sqrt(1 - 0.5 * y * y), y * np.sqrt(1 - 0.5 * x * x)], axis=1)
    nodes = np.column_stack([0.03 * flat, mesh.nodes[:, 2] - 0.006])
    return ao.FEModel.from_mesh(ao.Mesh(nodes, mesh.cells, "hexahedron20"), ALU)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("around", "layers", "most"),
    [(10, 2, 1.5e-2), pytest.param(20, 3, 3e-3, marks=pytest.mark.slow)],
)
def test_a_rigid_ball_on_a_disc(around: int, layers: int, most: float) -> None:
    """R 6 mm, 7 g, 1.5 m/s: 605.4 N with contact resolved by explicit elements of 8 µm."""
    law = ao.Hertz(k=4.0 / 3.0 * ALU.plane_strain_modulus * 0.006**0.5, relative_radius=0.006)
    tip = disc(around, layers).contact(point=(0.0, 0.0, 0.0))
    is_within_its_error(ao.simulate(ao.rigid(0.007), tip, 1.5, law=law), 605.4, most)


@pytest.mark.slow
def test_a_ball_on_a_simply_supported_plate() -> None:
    """200 × 150 × 6 mm, all four sides held across: 659.9 N, 116.5 µs on fine meshes."""
    mesh = ao.box_mesh((0.2, 0.15, 0.006), (30, 22, 2), kind="hexahedron20")
    x, y, _ = mesh.nodes.T
    sides = (x < 1e-9) | (x > 0.2 - 1e-9) | (y < 1e-9) | (y > 0.15 - 1e-9)
    plate = ao.FEModel.from_mesh(mesh, ALU, fixed=[(sides, "z")])
    hit = ao.simulate(ao.ball(0.01, STEEL), plate.contact(point=(0.12, 0.06, 0.006)), 1.0)
    is_within_its_error(hit, 659.9, 5e-3)
    assert hit.contact_duration == pytest.approx(116.5e-6, rel=1e-2)
