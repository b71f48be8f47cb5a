"""The half-space under a tangential force, and the compliance of bodies beyond it.

Compliances of bodies are in units of 1/(G* a), G* = 4G/(2 - ν), in which Mindlin's contact has 1/2.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from halfspaces import INSIDE, A

import aoimpact as ao
from aoimpact.contact import ShearedHalfSpace, Splitting, spread

FloatArray = npt.NDArray[np.float64]

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
SPACES = [
    ShearedHalfSpace(material, A)
    for material in (
        STEEL,
        ao.Material(E=10e6, nu=0.499, rho=1100),
        ao.Material(E=30e9, nu=0.0, rho=2000),
    )
]


def superposed(space: ShearedHalfSpace, place: FloatArray) -> FloatArray:
    """Cerruti's point loads (Johnson, eqs. 3.75 to 3.77) over the disc."""
    node, weight = np.polynomial.legendre.leggauss(400)
    b = 0.25 * math.pi * (node + 1.0)
    angle = 2.0 * math.pi * (np.arange(400) + 0.5) / 400
    load = (0.75 / math.pi * np.cos(b) ** 2 * np.sin(b) * weight)[:, None] * math.pi**2 / 400
    x = place[0] - A * np.sin(b)[:, None] * np.cos(angle)
    y = place[1] - A * np.sin(b)[:, None] * np.sin(angle)
    z, nu = place[2], space.nu
    rho = np.sqrt(x * x + y * y + z * z)
    s = rho + z
    u = [
        1.0 / rho + x * x / rho**3 + (1.0 - 2.0 * nu) * (1.0 / s - x * x / (rho * s * s)),
        x * y / rho**3 - (1.0 - 2.0 * nu) * x * y / (rho * s * s),
        x * z / rho**3 + (1.0 - 2.0 * nu) * x / (rho * s),
    ]
    return np.array([(load * part).sum() for part in u]) / (
        4.0 * math.pi * space.material.shear_modulus
    )


@pytest.mark.parametrize("space", SPACES)
def test_displacement_is_that_of_superposed_point_loads(space: ShearedHalfSpace) -> None:
    # Close to the disc the superposition itself is right to 1e-7.
    for place in INSIDE:
        wanted = superposed(space, place)
        exact = 1e-11 if place[2] > 0.2 * A else 1e-3
        np.testing.assert_allclose(
            space.displacement(place), wanted, atol=exact * np.abs(wanted).max()
        )


# ------------------------------------------------------------------------ bodies beyond it

BOX, ON_TOP = (0.06, 0.06, 0.03), np.array([0.0311, 0.0287, 0.03])
UP = np.array([0.0, 0.0, 1.0])
S2 = 4.5e9


def beyond(
    body: ao.FEModel,
    point: FloatArray,
    normal: FloatArray,
    tangent: FloatArray,
    a: float,
    s2: float = S2,
) -> float:
    """R of a body along a tangent, in units of 1/(G* a)."""
    compliance = Splitting(body, point, normal, a, body.inverse(s2), tangent).compliance
    return compliance * a * 4.0 * body.material.shear_modulus / (2.0 - body.material.nu)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "divisions"),
    [("hexahedron20", (4, 4, 2)), ("tetra10", (4, 4, 2)), ("hexahedron27", (6, 6, 3))],
)
def test_tangential_compliance_of_a_block_is_the_same_on_every_mesh(
    kind: str, divisions: tuple[int, int, int]
) -> None:
    body = ao.FEModel.from_mesh(ao.box_mesh(BOX, divisions, kind=kind), ALU)
    fine = ao.FEModel.from_mesh(ao.box_mesh(BOX, (8, 8, 4), kind="hexahedron27"), ALU)
    along = np.array([0.6, 0.8, 0.0])
    wanted = beyond(fine, ON_TOP, UP, along, 1e-3)
    assert beyond(body, ON_TOP, UP, along, 1e-3) == pytest.approx(wanted, abs=2e-4)


def test_a_resolved_patch_has_the_half_space_and_what_is_beyond() -> None:
    # One solution for the patch itself, without any half-space, on a mesh that resolves the patch.
    body = ao.FEModel.from_mesh(ao.box_mesh(BOX, (12, 12, 6), kind="hexahedron20"), ALU)
    tangent, r, solver = np.array([1.0, 0.0, 0.0]), 0.012, body.inverse(S2)
    weights = spread(body.surface, ON_TOP, UP, r).weights
    b = np.outer(weights, tangent).reshape(-1)[body.free]
    whole = float(b @ solver.solve(b))
    rest = Splitting(body, ON_TOP, UP, r, solver, tangent).compliance
    half = ShearedHalfSpace(ALU, r).mean_displacement
    assert whole - rest == pytest.approx(half, rel=0.01)
