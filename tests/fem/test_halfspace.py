"""The half-space under Hertz's pressure, or such a traction: an elastic field that has it there."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from aoimpact import FEModel, Material, Orthotropic, box_mesh
from aoimpact.contact import (
    AnisotropicHalfSpace,
    HalfSpace,
    IsotropicHalfSpace,
    ShearedHalfSpace,
    Splitting,
    spread,
)

FloatArray = npt.NDArray[np.float64]

A = 0.002  # radius of the pressed disc, m

# Inside the body: under the disc, below its rim, near the axis, far off, and close to the surface.
INSIDE = A * np.array(
    [
        [0.3, 0.2, 0.5],
        [0.9, -0.4, 0.05],
        [0.02, 0.01, 1.3],
        [-2.0, 1.0, 0.7],
        [6.0, -5.0, 0.4],
        [0.4, 0.4, 0.02],
        [12.0, 3.0, 20.0],
    ]
)
# Behind the tangent plane, where the surface of a concave body may be.
BEHIND = A * np.array([[2.0, 0.5, -0.3], [-1.5, 1.5, -0.8], [0.3, 0.2, -0.02], [8.0, 1.0, -4.0]])

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
PLY = Orthotropic(E=(120e9, 8e9, 8e9), nu=(0.3, 0.3, 0.4), G=(5e9, 5e9, 3e9), rho=1600.0)
P0 = 1.5 / (math.pi * A * A)


def of_orthotropic(material: Orthotropic, angle: float = 0.3) -> AnisotropicHalfSpace:
    """A half-space whose fibres lie in its surface, at an angle to the first local axis."""
    turn = np.array(
        [
            [math.cos(angle), math.sin(angle), 0.0],
            [-math.sin(angle), math.cos(angle), 0.0],
            [0, 0, 1],
        ]
    )
    turned = np.einsum("ai,bj,ck,dl,ijkl->abcd", turn, turn, turn, turn, material.tensor)
    like = material.half_space(np.array([0.0, 0.0, 1.0]))
    return AnisotropicHalfSpace(turned, A, like.plane_strain_modulus, like.nu)


SOFT = Material(E=10e6, nu=0.499, rho=1100.0)
CORK = Material(E=30e9, nu=0.0, rho=2000.0)
PRESSED: dict[str, HalfSpace] = {
    "steel": IsotropicHalfSpace(STEEL, A),
    "nearly incompressible": IsotropicHalfSpace(SOFT, A),
    "ply": of_orthotropic(PLY),
}
SHEARED: dict[str, ShearedHalfSpace] = {
    f"sheared, nu={of.nu}": ShearedHalfSpace(of, A) for of in (STEEL, SOFT, CORK)
}
# With the direction of the force.
SPACES: dict[str, tuple[HalfSpace | ShearedHalfSpace, int]] = {
    **{name: (space, 2) for name, space in PRESSED.items()},
    **{name: (space, 0) for name, space in SHEARED.items()},
}

MODULI = {
    "steel": 210e9 / 0.91,
    "nearly incompressible": 10e6 / (1.0 - 0.499**2),
    "ply": PLY.half_space((0.0, 0.0, 1.0)).plane_strain_modulus,
    # By Mindlin's ratio: 4G/(2 - ν) for E*.
    **{
        name: 4.0 * of.material.shear_modulus / (2.0 - of.material.nu)
        for name, of in SHEARED.items()
    },
}


def difference(of: object, places: FloatArray, step: float = 1e-4 * A) -> FloatArray:
    """Derivatives of a field along x, y, z by central differences of fourth order, last axis."""
    slopes = []
    for axis in np.eye(3):
        near, far = (
            of(places + k * step * axis) - of(places - k * step * axis)  # type: ignore[operator]
            for k in (1, 2)
        )
        slopes.append((8.0 * near - far) / (12.0 * step))
    return np.stack(slopes, axis=-1)


def places(name: str) -> FloatArray:
    return INSIDE if name == "ply" else np.vstack([INSIDE, BEHIND])


@pytest.mark.parametrize("name", SPACES)
def test_stress_is_that_of_the_displacement_and_in_equilibrium(name: str) -> None:
    (space, _), x = SPACES[name], places(name)
    stress = space.displacement_stress(x)[1]
    slope = difference(space.displacement, x, 1e-3 * A)
    strain = 0.5 * (slope + slope.swapaxes(1, 2))
    own = np.linalg.norm(np.einsum("ijkl,nkl->nij", space.softness, stress) - strain, axis=(1, 2))
    assert (own < 1e-5 * np.linalg.norm(strain, axis=(1, 2))).all()
    slope = difference(lambda y: space.displacement_stress(y)[1], x, 1e-3 * A)
    scale = np.abs(slope).max(axis=(1, 2, 3))
    assert (np.abs(np.einsum("nijj->ni", slope)).max(axis=1) < 1e-5 * scale).all()


@pytest.mark.parametrize("name", SPACES)
def test_the_surface_carries_the_traction_alone(name: str) -> None:
    space, along = SPACES[name]
    x = A * np.array([[0.03, 0.04], [0.3, 0.1], [0.2, -0.7], [1.2, 0.3], [-3.0, 4.0]])
    surface = np.column_stack([x, np.zeros(len(x))])
    found = space.displacement_stress(surface)[1][:, :, 2]
    wanted = np.zeros((len(x), 3))
    wanted[:, along] = -P0 * np.sqrt(np.maximum(1.0 - (x * x).sum(axis=1) / A**2, 0.0))
    # A logarithm is summed over angles on the surface of the ply, with an error of their order.
    within = 1.0 / 128 if name == "ply" else 2e-8
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=within * P0)


@pytest.mark.parametrize("name", SPACES)
def test_its_mean_displacement_is_that_of_hertz_or_mindlin(name: str) -> None:
    """Under its own pressure, 0.6/(a E*), by Gauss's rule in √(1 - r²/a²)."""
    space, along = SPACES[name]
    x, w = np.polynomial.legendre.leggauss(24)
    sink = 0.5 * (1.0 + x)
    r, share = A * np.sqrt(1.0 - sink**2), 1.5 * w * sink**2
    angle = 2.0 * math.pi * (np.arange(32) + 0.3) / 32
    at = np.stack(
        np.broadcast_arrays(np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), 0.0), axis=-1
    )
    mean = share @ space.displacement(at)[..., along].mean(axis=1)
    assert mean == pytest.approx(0.6 / (A * MODULI[name]), rel=2e-5)
    assert space.mean_displacement == pytest.approx(0.6 / (A * MODULI[name]), rel=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
def test_displacement_is_that_of_boussinesq_s_point_loads(nu: float) -> None:
    """K. L. Johnson, Contact Mechanics, eq. (3.18), summed up over the pressure."""
    material = Material(E=70e9, nu=nu, rho=2700.0)
    t, wt = np.polynomial.legendre.leggauss(160)
    sink, angle = 0.5 * (1.0 + t), 2.0 * math.pi * np.arange(320) / 320
    r, share = A * np.sqrt(1.0 - sink**2), np.repeat(1.5 * wt * sink**2 / 320, 320)
    source = np.column_stack(
        [np.outer(r, np.cos(angle)).ravel(), np.outer(r, np.sin(angle)).ravel()]
    )
    for x in INSIDE[[0, 2, 3, 4, 6]]:
        arm, z = x[:2] - source, x[2]
        away = np.hypot(np.hypot(*arm.T), z)
        across = z / away**3 - (1.0 - 2.0 * nu) / (away * (away + z))
        along = z * z / away**3 + 2.0 * (1.0 - nu) / away
        moved = share @ np.column_stack([arm * across[:, None], along])
        found = IsotropicHalfSpace(material, A).displacement(x)
        np.testing.assert_allclose(
            found, moved / (4.0 * math.pi * material.shear_modulus), rtol=1e-7, atol=1e-16
        )


@pytest.mark.parametrize("name", ["steel", "nearly incompressible"])
@pytest.mark.parametrize("x", [(0.2, 0.1), (2.0, -1.0)])
def test_it_continues_smoothly_through_the_tangent_plane(name: str, x: tuple[float, float]) -> None:
    """Under the disc and beside it, displacement and stress have all derivatives there."""
    space = PRESSED[name]
    z = A * 0.02 * np.arange(-4, 5)
    line = np.column_stack([np.full(9, A * x[0]), np.full(9, A * x[1]), z])
    u, stress = space.displacement_stress(line)
    for field in (u, stress.reshape(9, 9)):
        # The eighth difference of a smooth function is tiny; that of |z| is 70 times its step.
        signs = np.array([math.comb(8, k) * (-1.0) ** k for k in range(9)])
        assert np.abs(signs @ field).max() < 1e-6 * np.abs(field).max()


@pytest.mark.parametrize("off", [0.0, 1e-5])
def test_an_anisotropic_half_space_with_isotropic_constants_is_the_isotropic_one(
    off: float,
) -> None:
    """Stroh's roots coincide there."""
    E, nu, G = STEEL.E, STEEL.nu, STEEL.shear_modulus
    near = Orthotropic(
        E=(E, E * (1 + off), E * (1 - off)),
        nu=(nu, nu * (1 - off), nu),
        G=(G * (1 + off), G, G * (1 - off)),
        rho=7800.0,
    )
    one, other = of_orthotropic(near), PRESSED["steel"]
    for found, exact in zip(
        one.displacement_stress(INSIDE), other.displacement_stress(INSIDE), strict=True
    ):
        size = np.abs(exact.reshape(len(INSIDE), -1)).max(axis=1)
        error = np.abs((found - exact).reshape(len(INSIDE), -1)).max(axis=1)
        assert (error < 1e-4 * size).all()


@pytest.mark.parametrize("space", PRESSED.values(), ids=PRESSED)
def test_on_axis_and_rim_the_field_is_finite(space: HalfSpace) -> None:
    at = A * np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    u, stress = space.displacement_stress(at)
    assert np.isfinite(u).all()
    assert np.isfinite(stress).all()
    # Hertz: the middle of the disc sinks by 3/(4 E* a).
    assert u[0, 2] == pytest.approx(space.mean_displacement / 0.8, rel=1e-3)


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


@pytest.mark.parametrize("space", SHEARED.values(), ids=SHEARED)
def test_displacement_is_that_of_cerruti_s_point_loads(space: ShearedHalfSpace) -> None:
    # Close to the disc the superposition itself is right to 1e-7.
    for place in INSIDE:
        wanted = superposed(space, place)
        exact = 1e-11 if place[2] > 0.2 * A else 1e-3
        np.testing.assert_allclose(
            space.displacement(place), wanted, atol=exact * np.abs(wanted).max()
        )


def test_a_resolved_patch_that_is_sheared_has_the_half_space_and_what_is_beyond() -> None:
    # One solution for the patch itself, without any half-space, on a mesh that resolves the patch.
    mesh = box_mesh((0.06, 0.06, 0.03), (12, 12, 6), kind="hexahedron20")
    body = FEModel.from_mesh(mesh, Material(E=70e9, nu=0.33, rho=2700.0))
    point, up = np.array([0.0311, 0.0287, 0.03]), np.array([0.0, 0.0, 1.0])
    tangent, r, solver = np.array([1.0, 0.0, 0.0]), 0.012, body.inverse(4.5e9)
    weights = spread(body.surface, point, up, r).weights
    b = np.outer(weights, tangent).reshape(-1)[body.free]
    whole = float(b @ solver.solve(b))
    rest = Splitting(body, point, up, r, solver, [tangent]).compliance[1, 1]
    half = ShearedHalfSpace(body.material, r).mean_displacement
    assert whole - rest == pytest.approx(half, rel=0.01)
