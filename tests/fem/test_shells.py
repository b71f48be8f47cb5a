"""Shell elements: rigid motion, constant strain, obstacle courses, plates that vibrate, folds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from thinmeshes import dofs, frequencies, grid, matrices, pressed, rigid_motions, solved, turned

import aoimpact as ao
from aoimpact import InputError, Shell

FloatArray = npt.NDArray[np.float64]


STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
KINDS = pytest.mark.parametrize("kind", ["quad", "triangle"])

# The published problems are in inches, pounds, or nothing: not what solids have in SI units.
pytestmark = pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")


def material(E: float, nu: float) -> ao.Material:
    return ao.Material(E=E, nu=nu, rho=1000.0)


def assembled(nodes: FloatArray, cells: Any, layers: Shell) -> tuple[Any, Any]:
    return matrices(nodes, (cells, layers))


@pytest.mark.parametrize("corners", [3, 4])
@pytest.mark.parametrize("offset", [0.0, 0.004])
def test_an_element_resists_all_but_rigid_motion(corners: int, offset: float) -> None:
    warped = np.array([[0, 0, 0], [1.1, 0.1, 0.1], [0.9, 1.2, 0], [-0.1, 0.8, 0.05]])[:corners]
    K = assembled(warped, np.arange(corners)[None], Shell(0.01, STEEL, offset))[0].toarray()
    assert np.array_equal(K, K.T)
    assert abs(K @ rigid_motions(warped)).max() < 1e-13 * abs(K).max()
    energies = np.linalg.eigvalsh(K / np.sqrt(np.outer(np.diag(K), np.diag(K))))
    assert (abs(energies) < 1e-12).sum() == 6
    assert energies[6] > 1e-8


@KINDS
def test_mass_is_that_of_a_solid_plate(kind: str) -> None:
    """In rigid motion: mass, and moments of inertia but t²/12 about the normal."""
    a, b, t = 0.3, 0.2, 0.02
    nodes, cells, _, _ = grid(4, 3, lambda r, s: (a * (r - 0.5), b * (s - 0.5), 0 * r), kind)
    M = assembled(nodes, cells, Shell(t, STEEL))[1]
    motions = rigid_motions(nodes)
    m = 7800 * a * b * t
    exact = [m, m, m, m * (b * b + t * t) / 12, m * (a * a + t * t) / 12, m * (a * a + b * b) / 12]
    assert motions.T @ M @ motions == pytest.approx(np.diag(exact), rel=1e-12, abs=1e-15)


# The mesh of R. H. MacNeal and R. L. Harder's patch tests, Finite Elem. Anal. Des. 1, 3 (1985).
PATCH = np.array(
    [
        *([0, 0], [0.24, 0], [0.24, 0.12], [0, 0.12]),
        *([0.04, 0.02], [0.18, 0.03], [0.16, 0.08], [0.08, 0.08]),
    ]
)
PATCH_CELLS = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]])


@pytest.mark.parametrize("kind", ["quad", "triangle", "mixed"])
@pytest.mark.parametrize("state", ["membrane", "bending"])
@pytest.mark.parametrize("offset", [0.0, 3e-4])
def test_a_distorted_mesh_has_constant_strain_exactly(kind: str, state: str, offset: float) -> None:
    """Inner nodes that follow a field of constant strain meet no force, in any plane of space."""
    x, y = PATCH.T
    moved = np.zeros((8, 6))
    if state == "membrane":
        moved[:, 0], moved[:, 1] = 1e-3 * (x + y / 2), 1e-3 * (y + x / 2)
    else:
        moved[:, 2] = 5e-4 * (x**2 + x * y + y**2)
        moved[:, 3], moved[:, 4] = 5e-4 * (x + 2 * y), -5e-4 * (2 * x + y)
    turn = turned()
    nodes = np.column_stack([x, y, 0 * x]) @ turn.T
    moved = np.hstack([moved[:, :3] @ turn.T, moved[:, 3:] @ turn.T])
    sheet = Shell(1e-3, material(1e6, 0.25), offset)
    triangles = np.vstack([PATCH_CELLS[:, :3], PATCH_CELLS[:, [0, 2, 3]]])
    parts = {
        "quad": [PATCH_CELLS],
        "triangle": [triangles],
        "mixed": [PATCH_CELLS[:3], triangles[[3, 4, 8, 9]]],
    }[kind]
    K, _ = matrices(nodes, *((cells, sheet) for cells in parts))
    force = (K @ moved.ravel()).reshape(8, 6)
    size = (abs(K) @ abs(moved.ravel())).max()
    assert abs(force[4:]).max() < 1e-14 * size


def test_in_plane_bending_of_slender_elements_does_not_lock() -> None:
    """One row of elements ten times as long as wide, under a couple: u'' = M/(E I)."""
    nodes, cells, r, s = grid(5, 1, lambda r, s: (10 * r, 0.2 * s, 0 * r))
    K, _ = assembled(nodes, cells, Shell(0.1, material(1e7, 0.0)))
    force = np.zeros((len(nodes), 6))
    force[(r == 1) & (s == 1), 0] = -1.0
    force[(r == 1) & (s == 0), 0] = 1.0
    x = solved(K, force.ravel(), dofs((r == 0) & (s == 0), range(6)), dofs(r == 0, [0]))
    second = 0.1 * 0.2**3 / 12
    assert x[r == 1, 1] == pytest.approx(0.2 * 10**2 / (2 * 1e7 * second), rel=2e-3)


def cook(n: int, kind: str) -> float:
    """Deflection over 23.96 (R. D. Cook, J. Struct. Div. ASCE 100, 1851, 1974)."""
    nodes, cells, r, s = grid(n, n, lambda r, s: (48 * r, 44 * r + s * (44 - 28 * r), 0 * r), kind)
    K, _ = assembled(nodes, cells, Shell(1.0, material(1.0, 1 / 3)))
    force = np.zeros((len(nodes), 6))
    force[r == 1, 1] = np.where((s == 0) | (s == 1), 0.5, 1.0)[r == 1] / n
    x = solved(K, force.ravel(), dofs(r == 0, [0, 1]), dofs(r >= 0, [2, 3, 4]))
    return float(x[(r == 1) & (abs(s - 0.5) < 1e-9), 1][0]) / 23.96


def scordelis_lo(n: int, kind: str) -> float:
    """Deflection of the roof's free edge over 0.3024 (MacNeal and Harder)."""
    arc = math.radians(40)
    nodes, cells, r, s = grid(
        n, n, lambda r, s: (25 * np.sin(arc * r), 25 * s, 25 * np.cos(arc * r)), kind
    )
    roof = Shell(0.25, material(4.32e8, 0.0))
    K, _ = assembled(nodes, cells, roof)
    fixed = (dofs(r == 0, [0, 4, 5]), dofs(s == 0, [1, 3, 5]), dofs(s == 1, [0, 2]))
    x = solved(K, pressed(nodes, cells, roof, (0, 0, -90)), *fixed)
    return -float(x[(r == 1) & (s == 0), 2][0]) / 0.3024


def pinched_cylinder(n: int, kind: str) -> float:
    """Deflection under the force over 1.8248e-5 (Lindberg, Olson and Cowper, 1969)."""
    nodes, cells, r, s = grid(
        n, n, lambda r, s: (300 * np.sin(np.pi / 2 * r), 300 * s, 300 * np.cos(np.pi / 2 * r)), kind
    )
    K, _ = assembled(nodes, cells, Shell(3.0, material(3e6, 0.3)))
    force = np.zeros((len(nodes), 6))
    top = (r == 0) & (s == 0)
    force[top, 2] = -0.25
    fixed = (dofs(r == 0, [0, 4, 5]), dofs(r == 1, [2, 3, 4]), dofs(s == 0, [1, 3, 5]))
    x = solved(K, force.ravel(), *fixed, dofs(s == 1, [0, 2]))
    return -float(x[top, 2][0]) / 1.8248e-5


def hemisphere(n: int, kind: str) -> float:
    """Deflection under the forces over 0.094 (MacNeal and Harder): a hole of 18°, R/t = 250."""
    up, around = math.radians(72), np.pi / 2
    nodes, cells, r, s = grid(
        n,
        n,
        lambda r, s: (
            10 * np.cos(up * s) * np.cos(around * r),
            10 * np.cos(up * s) * np.sin(around * r),
            10 * np.sin(up * s),
        ),
        kind,
    )
    K, _ = assembled(nodes, cells, Shell(0.04, material(6.825e7, 0.3)))
    force = np.zeros((len(nodes), 6))
    pulled, pushed = (r == 0) & (s == 0), (r == 1) & (s == 0)
    force[pulled, 0], force[pushed, 1] = 1.0, -1.0
    fixed = (dofs(r == 0, [1, 3, 5]), dofs(r == 1, [0, 4, 5]), dofs(pulled, [2]))
    return float(solved(K, force.ravel(), *fixed)[pulled, 0][0]) / 0.094


def twisted_beam(n: int, kind: str, thickness: float, component: int) -> float:
    """Tip's deflection over MacNeal and Harder's, or Belytschko, Wong and Stolarski's (1989)."""
    turn = np.pi / 2
    nodes, cells, r, s = grid(
        n,
        n // 6,
        lambda r, s: (
            12 * r,
            1.1 * (s - 0.5) * np.cos(turn * r),
            1.1 * (s - 0.5) * np.sin(turn * r),
        ),
        kind,
    )
    K, _ = assembled(nodes, cells, Shell(thickness, material(29e6, 0.22)))
    exact = {(0.32, 2): 5.424e-3, (0.32, 1): 1.754e-3, (0.0032, 2): 5256.0, (0.0032, 1): 1294.0}
    force = np.zeros((len(nodes), 6))
    share = np.where((s == 0) | (s == 1), 0.5, 1.0) / (n // 6)
    force[r == 1, component] = share[r == 1]
    x = solved(K, force.ravel(), dofs(r == 0, range(6)))
    return float(x[r == 1, component] @ share[r == 1]) / exact[thickness, component]


def skew_plate(n: int, kind: str) -> float:
    """Deflection in the middle over Morley's (1963), simply supported, 30°, a/t = 100."""
    angle = math.radians(30)
    nodes, cells, r, s = grid(
        n, n, lambda r, s: (100 * (r + s * np.cos(angle)), 100 * s * np.sin(angle), 0 * r), kind
    )
    plate = Shell(1.0, material(1e7, 0.3))
    K, _ = assembled(nodes, cells, plate)
    edge = (r == 0) | (r == 1) | (s == 0) | (s == 1)
    x = solved(K, pressed(nodes, cells, plate, (0, 0, 1)), dofs(edge, [2]), dofs(r >= 0, [0, 1, 5]))
    middle = (abs(r - 0.5) < 1e-9) & (abs(s - 0.5) < 1e-9)
    return float(x[middle, 2][0]) * 1e7 / (12 * 0.91) / 100**4 / 0.408e-3


@pytest.mark.parametrize(
    ("problem", "n", "quads", "triangles"),
    [
        (cook, 16, 0.997, 0.988),
        (scordelis_lo, 8, 1.005, 0.962),
        (pinched_cylinder, 16, 0.932, 0.908),
        pytest.param(scordelis_lo, 16, 0.998, 0.991, marks=pytest.mark.slow),
        pytest.param(pinched_cylinder, 32, 0.990, 0.975, marks=pytest.mark.slow),
        (hemisphere, 16, 0.990, 0.980),
        (skew_plate, 32, 0.990, 0.937),
    ],
)
def test_published_shells(problem: Any, n: int, quads: float, triangles: float) -> None:
    """The ratio to the published value, on meshes that the literature shows."""
    assert problem(n, "quad") == pytest.approx(quads, abs=2e-3)
    assert problem(n, "triangle") == pytest.approx(triangles, abs=2e-3)


@KINDS
@pytest.mark.parametrize("thickness", [0.32, 0.0032])
def test_twisted_beam(kind: str, thickness: float) -> None:
    """Warped elements, thick and thin: along its width at the tip, and across."""
    for component in (1, 2):
        assert twisted_beam(24, kind, thickness, component) == pytest.approx(1.0, abs=0.015)


@KINDS
def test_simply_supported_plate_vibrates_as_mindlins(kind: str) -> None:
    """f(m, n) in closed form, thin and thick, and second order of convergence."""
    a, b = 1.0, 0.8

    def exact(t: float, m: int, n: int) -> float:
        k2 = (m * np.pi / a) ** 2 + (n * np.pi / b) ** 2
        D, S = 210e9 * t**3 / (12 * 0.91), 5 / 6 * STEEL.shear_modulus * t
        mass, inertia = 7800 * t, 7800 * t**3 / 12
        K = np.array([[S * k2, S * math.sqrt(k2)], [S * math.sqrt(k2), D * k2 + S]])
        lowest = np.linalg.eigvals(np.linalg.solve(np.diag([mass, inertia]), K)).min()
        return float(np.sqrt(lowest)) / (2 * np.pi)

    def lowest(t: float, n: int) -> FloatArray:
        nodes, cells, r, s = grid(n, n, lambda r, s: (a * r, b * s, 0 * r), kind)
        K, M = assembled(nodes, cells, Shell(t, STEEL))
        ends, sides = (r == 0) | (r == 1), (s == 0) | (s == 1)
        fixed = (dofs(ends, [2, 3]), dofs(sides, [2, 4]), dofs(r >= 0, [0, 1, 5]))
        return frequencies(K, M, 3, *fixed)

    for t in (0.001, 0.1):
        wanted = sorted(exact(t, m, n) for m, n in ((1, 1), (2, 1), (1, 2)))
        found = lowest(t, 16)
        assert found == pytest.approx(wanted, rel=0.025)
        coarse, fine = (of[0] / wanted[0] - 1 for of in (lowest(t, 8), found))
        assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.25)


@KINDS
@pytest.mark.parametrize(
    ("clamped", "factors"),
    [
        (False, [13.468, 19.596, 24.270, 34.801, 34.801, 61.093]),  # NAFEMS FV12
        (True, [3.4711, 8.5072, 21.285, 27.199, 30.955, 54.187]),  # NAFEMS FV16
    ],
)
def test_free_and_clamped_plates(kind: str, clamped: bool, factors: list[float]) -> None:
    """ω a² √(m/D) of thin square plates, ν = 0.3 (A. W. Leissa, J. Sound Vib. 31, 257, 1973)."""
    nodes, cells, r, _ = grid(20, 20, lambda r, s: (10 * r, 10 * s, 0 * r), kind)
    K, M = assembled(nodes, cells, Shell(0.05, ao.Material(200e9, 0.3, 8000)))
    fixed = (dofs(r >= 0, [0, 1, 5]), dofs((r == 0) & clamped, range(6)))
    found = frequencies(K, M, 9, *fixed)
    rigid = 0 if clamped else 3
    assert (found[:rigid] < 1e-3).all()
    unit = math.sqrt(200e9 * 0.05**3 / (12 * 0.91) / 400) / 100 / (2 * np.pi)
    assert found[rigid:][:6] / unit == pytest.approx(factors, rel=0.02)


@KINDS
def test_an_offset_only_moves_the_nodes(kind: str) -> None:
    """A plate whose nodes are on its face has the frequencies of one with them in the middle."""
    nodes, cells, _, _ = grid(8, 8, lambda r, s: (0.3 * r, 0.2 * s, 0 * r), kind)
    middle, face = (
        frequencies(*assembled(nodes, cells, Shell(0.01, STEEL, offset)), 12)
        for offset in (0, 5e-3)
    )
    assert face[6:] == pytest.approx(middle[6:], rel=2e-3 if kind == "quad" else 0.02)


def square_tube(
    along: int, side: int, a: float, length: float, kind: str
) -> tuple[FloatArray, Any, FloatArray]:
    """Nodes, elements and the position along the tube; walls meet at right angles."""
    u = np.linspace(0.0, 4.0, 4 * side, endpoint=False)
    edge, part = np.floor(u).astype(int), u % 1.0
    corner = a / 2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    around = corner[edge] + part[:, None] * (corner[edge + 1] - corner[edge])
    x = np.linspace(0.0, length, along + 1)
    nodes = np.hstack([np.repeat(x, len(around))[:, None], np.tile(around, (along + 1, 1))])
    i = np.arange(len(nodes)).reshape(along + 1, -1)
    j = np.roll(i, -1, axis=1)
    cells = np.stack([i[:-1], i[1:], j[1:], j[:-1]], axis=-1).reshape(-1, 4)
    if kind == "triangle":
        cells = np.vstack([cells[:, :3], cells[:, [0, 2, 3]]])
    return nodes, cells, nodes[:, 0]


@KINDS
def test_a_square_tube_twists_as_bredts(kind: str) -> None:
    """Walls that meet at folds: θ' = T/(G J), J = a³ t + 4 a t³/3, by shear flow at the ends."""
    a, t, length, side = 0.1, 2e-3, 0.4, 6
    nodes, cells, x = square_tube(24, side, a, length, kind)
    K, _ = assembled(nodes, cells, Shell(t, STEEL))
    force = np.zeros((len(nodes), 6))
    flow = 1.0 / (2 * a * a)  # of a torque of 1 N m
    for end, sign in ((0.0, -1.0), (length, 1.0)):
        ring = np.flatnonzero(x == end)
        edges = nodes[np.roll(ring, -1)] - nodes[ring]
        force[ring, :3] += sign * flow * edges / 2
        force[np.roll(ring, -1), :3] += sign * flow * edges / 2
    moved = solved(K, force.ravel(), dofs(0, range(6)))
    ends = [
        np.cross(nodes[x == end], moved[x == end, :3])[:, 0].mean() / (a * a / 4 * 4 / 3)
        for end in (0.0, length)
    ]
    exact = length / (STEEL.shear_modulus * (a**3 * t + 4 / 3 * a * t**3))
    assert ends[1] - ends[0] == pytest.approx(exact, rel=0.02)


def test_a_fibre_axis_along_the_normal_is_refused() -> None:
    nodes, cells, _, _ = grid(2, 2, lambda r, s: (r, s, 0 * r))
    ply = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    upright = Shell(0.01, ao.Orthotropic(ply.E, ply.G, ply.nu, ply.rho, ((0, 0, 1), (1, 0, 0))))
    with pytest.raises(InputError, match=r"^fibre_axis"):
        assembled(nodes, cells, upright)
