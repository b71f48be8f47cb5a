"""Shells, laminates and beams by the default call, against plate and beam theory and solids.

Plates are those of three-dimensional elasticity (`tests/navier.py`), beams Timoshenko's in closed
form, frames the exact dynamic stiffness of their members. None shares anything with the package.
"""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import Any

import navier
import numpy as np
import numpy.typing as npt
import pytest
import scipy.linalg
import scipy.optimize
from scipy.integrate import solve_ivp
from scipy.spatial import cKDTree
from thinmeshes import bar

import aoimpact as ao

FloatArray = npt.NDArray[np.float64]

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALL_SIDES = [("xmin", "yz", "x"), ("xmax", "yz", "x"), ("ymin", "xz", "y"), ("ymax", "xz", "y")]


def ball_mass(radius: float, material: ao.Material) -> float:
    return 4.0 / 3.0 * math.pi * radius**3 * material.rho


def shell(side: float, n: int, layers: Any, kind: str = "quad") -> ao.ContactPoint:
    """The middle of a simply supported square plate."""
    mesh = ao.sheet_mesh((side, side), (n, n), kind=kind)
    body = ao.FEModel.from_mesh(mesh, layers, fixed=ALL_SIDES)
    return body.contact(point=(side / 2, side / 2, 0.0))


@cache
def elastic(side: float, t: float, radius: float, lasts: float) -> tuple[FloatArray, float]:
    """Force over time steps of 20 ns, and the ball's last velocity: steel, 1 m/s."""
    E, nu = STEEL.E, STEEL.nu
    stiffness = navier.orthotropic([E] * 3, [STEEL.shear_modulus] * 3, [nu] * 3)
    plies = [navier.Sheet(t / 4, stiffness, STEEL.rho)] * 4
    plate = navier.plate((side, side), plies, 0.06 * radius, moving=100)
    hertz = 4.0 / 3.0 * E / (2.0 * (1.0 - nu**2)) * math.sqrt(radius)
    return navier.struck(plate, hertz, ball_mass(radius, STEEL), 1.0, lasts, 2e-8)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["quad", "triangle"])
def test_karas_plate(kind: str) -> None:
    """200 x 200 x 8 mm, ball of 20 mm, 1 m/s (K. Karas, Ing.-Arch. 10, 237, 1939): 1391 N.

    Karas' thin plate is within 0.2 % of elasticity's 1389 N.
    """
    force, speed = elastic(0.2, 8e-3, 0.01, 1e-4)
    hit = ao.simulate(ao.ball(0.01, STEEL), shell(0.2, 20, ao.Shell(8e-3, STEEL), kind), 1.0)
    times = 2e-8 * np.arange(len(force))
    within = times < hit.duration
    off = np.abs(hit.at(times[within]).force - force[within]).max()
    assert hit.peak_force == pytest.approx(force.max(), rel=0.01)
    assert hit.peak_force == pytest.approx(1391.0, rel=0.01)
    assert off < 0.02 * force.max()
    assert hit.rebound_velocity == pytest.approx(speed, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("t", [2e-3, 4e-3, 8e-3])
def test_a_sheet_of_shells_is_that_of_elasticity(t: float) -> None:
    """120 x 120 mm, ball of 10 mm: force within 1 %, impulse within 0.5 %."""
    force, _ = elastic(0.12, t, 0.005, 1e-4)
    hit = ao.simulate(
        ao.ball(0.005, STEEL), shell(0.12, 24, ao.Shell(t, STEEL)), 1.0, duration=1e-4
    )
    assert hit.peak_force == pytest.approx(force.max(), rel=0.01)
    assert hit.impulse == pytest.approx(2e-8 * force.sum(), rel=5e-3)


def brick(t: float, layers: int) -> ao.ContactPoint:
    """120 x 120 mm of quadratic bricks, finer towards the middle of the plate."""
    mesh = ao.box_mesh((2.0, 2.0, 1.0), (24, 24, layers), kind="hexahedron20")
    x, y, z = (mesh.nodes - [1.0, 1.0, 0.0]).T
    x, y = (0.06 * (0.4 * c + 0.6 * np.sign(c) * np.abs(c) ** 2) for c in (x, y))
    nodes = np.column_stack([x, y, t * z])
    sides = [np.flatnonzero(np.isclose(np.abs(nodes[:, i]), 0.06)) for i in (0, 1)]
    fixed = [(sides[0], "yz"), (sides[1], "xz")]
    body = ao.FEModel.from_mesh(ao.Mesh(nodes, mesh.cells, mesh.kind), STEEL, fixed=fixed)
    return body.contact(point=(0.0, 0.0, t))


@pytest.mark.slow
@pytest.mark.parametrize("t", [2e-3, 4e-3, 8e-3])
def test_shells_agree_with_solids(t: float) -> None:
    """Two quadratic bricks through the thickness: force within 1 %, impulse within 0.5 %."""
    one, other = (
        ao.simulate(ao.ball(0.005, STEEL), tip, 1.0, duration=1e-4)
        for tip in (shell(0.12, 24, ao.Shell(t, STEEL)), brick(t, 2))
    )
    assert one.peak_force == pytest.approx(other.peak_force, rel=0.01)
    assert one.impulse == pytest.approx(other.impulse, rel=5e-3)


def plate_of(shells: bool, web: bool) -> ao.Mesh:
    """A plate of 40 x 40 x 2 mm, its web from below x = 0, or the half of it beyond x = 0."""
    half, deep = 0.02, 0.012
    if not shells:
        sizes = ((0.04, 0.04, deep), (40, 20, 12)) if web else ((half, 0.04, 2e-3), (20, 20, 2))
        box = ao.box_mesh(*sizes)
        nodes = box.nodes - [half if web else 0.0, half, sizes[0][2]]
        x, _, z = nodes[box.cells].mean(axis=1).T
        used, cells = np.unique(box.cells[(z > -2e-3) | (np.abs(x) < 1e-3)], return_inverse=True)
        return ao.Mesh(nodes[used], cells.reshape(-1, 8), "hexahedron")
    skin = ao.sheet_mesh((2 * half if web else half, 0.04), (16 if web else 8, 16))
    nodes = skin.nodes - np.array([half if web else 0.0, half, 0.0])
    if not web:
        return ao.Mesh(nodes, skin.cells, "quad")
    stem = ao.sheet_mesh((deep - 1e-3, 0.04), (4, 16))
    below = (stem.nodes - [0.0, half, 0.0])[:, [2, 1, 0]] * [1.0, 1.0, -1.0]
    both, cells = np.vstack([nodes, below]), np.vstack([skin.cells, stem.cells + len(nodes)])
    _, rows, back = np.unique(both.round(9), axis=0, return_index=True, return_inverse=True)
    return ao.Mesh(both[rows], back.reshape(-1)[cells], "quad")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "x"), [("web", 0.0), ("web", 2.5e-3), ("edge", 2e-3), ("clamp", 2.5e-3)]
)
def test_shells_agree_with_solids_near_webs_and_edges(place: str, x: float) -> None:
    """Force within 2 %, and within what both claim."""
    found = []
    for shells in (True, False):
        held = (lambda at: at[:, 0] < 1e-9, *["xyz"] * (1 + shells))
        body = ao.FEModel.from_mesh(
            plate_of(shells, place == "web"),
            ao.Shell(2e-3, STEEL) if shells else STEEL,
            fixed=[held] if place == "clamp" else None,
            order=None if shells else 2,
        )
        tip = body.contact(point=(x, 0.0, 0.0), direction=(0, 0, -1))
        found.append(ao.simulate(ao.ball(0.005, STEEL), tip, 1.0))
    one, other = found
    assert one.peak_force == pytest.approx(other.peak_force, rel=0.02)
    claimed = sum(hit.error["peak_force"].total for hit in found)
    assert one.peak_force == pytest.approx(other.peak_force, rel=claimed)


def backed_plate(skin: bool) -> ao.FEModel:
    """60 x 60 x 6 mm, of which the lowest 2 mm are a shell on the face of the rest, or solid."""
    side, deep = 0.06, 4e-3 if skin else 6e-3
    kind = "hexahedron" if skin else "hexahedron20"
    mesh = ao.box_mesh((side, side, deep), (12, 12, 2 if skin else 3), kind=kind)
    fixed = [("xmin", "xyz"), ("xmax", "xyz")]
    if not skin:
        return ao.FEModel.from_mesh(mesh, STEEL, fixed=fixed)
    lowest = mesh.cells[np.isclose(mesh.nodes[mesh.cells[:, 0], 2], 0.0)][:, [0, 3, 2, 1]]
    groups = {"block": np.arange(288), "skin": np.arange(288, 432)}
    both: Any = [("hexahedron", mesh.cells), ("quad", lowest)]
    mixed = ao.Mesh(mesh.nodes, both, "mixed", mesh.node_sets, groups)
    parts = {"block": STEEL, "skin": ao.Shell(2e-3, STEEL, offset=1e-3)}
    return ao.FEModel.from_mesh(mixed, parts, fixed=[(ends, "xyz", "xyz") for ends, _ in fixed])


@pytest.mark.filterwarnings("ignore:stress may be off")  # of two bricks over the thickness
def test_solids_on_a_shell_are_struck() -> None:
    """Force within 1 %, impulse within 0.5 % of solids alone; stress is known everywhere."""
    one, other = (
        ao.simulate(
            ao.ball(0.005, STEEL), body.contact(point=(0.03, 0.03, top)), 2.0, duration=5e-5
        )
        for body, top in ((backed_plate(True), 4e-3), (backed_plate(False), 6e-3))
    )
    assert one.peak_force == pytest.approx(other.peak_force, rel=0.01)
    assert one.impulse == pytest.approx(other.impulse, rel=5e-3)
    assert np.isfinite(one.target.field().stress().von_mises).all()
    assert one.error["peak_force"].mesh is None  # the shell is not made finer


@pytest.mark.slow
def test_a_sheet_with_a_boss_is_struck_beside_it() -> None:
    """As the sheet alone is for 50 µs, in which no wave comes to the boss and back."""
    sheet, block = (
        ao.sheet_mesh((0.16, 0.16), (32, 32)),
        ao.box_mesh((0.02, 0.02, 0.008), (4, 4, 2)),
    )
    at = cKDTree(sheet.nodes).query(block.nodes)
    number = np.where(at[0] < 1e-9, at[1], np.cumsum(at[0] > 1e-9) + sheet.n_nodes - 1)
    nodes = np.vstack([sheet.nodes, block.nodes[at[0] > 1e-9]])
    cells = [("quad", sheet.cells), ("hexahedron", number[block.cells])]
    sets = {"sheet": np.arange(1024), "boss": 1024 + np.arange(32)}
    parts = {"sheet": ao.Shell(2e-3, STEEL), "boss": STEEL}
    both = ao.FEModel.from_mesh(ao.Mesh(nodes, cells, cell_sets=sets), parts)
    alone = ao.FEModel.from_mesh(sheet, parts["sheet"])
    one, other = (
        ao.simulate(ao.ball(0.003, STEEL), body.contact(point=(0.1, 0.1, 0.0)), 1.0, duration=50e-6)
        for body in (both, alone)
    )
    assert one.peak_force == pytest.approx(other.peak_force, rel=0.01)


def test_a_shell_that_lies_on_solids_is_not_struck() -> None:
    tip = backed_plate(True).contact(point=(0.03, 0.03, 0.0), direction=(0, 0, 1))
    with pytest.raises(ao.InputError, match=r"^point"):
        ao.simulate(ao.ball(0.005, STEEL), tip, 2.0)


# Sun and Chen's graphite and epoxy: E and G in Pa, ν of 12, 13 and 23.
GRAPHITE: Any = ((120e9, 7.9e9, 7.9e9), (5.5e9, 5.5e9, 5.5e9), (0.3, 0.3, 0.3))


@pytest.mark.slow
def test_sun_and_chens_laminate() -> None:
    """[0/90/0/90/0]s, 200 x 200 x 2.69 mm, ball of 12.7 mm and 8.537 g at 3 m/s.

    C. T. Sun and J. K. Chen, J. Comp. Mat. 19, 490, 1985, with Hertz's law of E2. Thin plates of
    classical laminate theory have 309.6 N, elasticity 299.0 N.
    """
    angles, ply, radius = [0, 90, 0, 90, 0, 0, 90, 0, 90, 0], 0.269e-3, 6.35e-3
    ball = ao.Material(E=200e9, nu=0.3, rho=7960)
    hertz = 4.0 / 3.0 * math.sqrt(radius) / (0.91 / 200e9 + 1 / 7.9e9)
    sheets = [navier.Sheet(ply, navier.orthotropic(*GRAPHITE, angle), 1580.0) for angle in angles]
    plate = navier.plate((0.2, 0.2), sheets, 5e-4)
    force, _ = navier.struck(plate, hertz, ball_mass(radius, ball), 3.0, 2e-4, 1e-7)
    carbon = ao.Orthotropic(*GRAPHITE, rho=1580)
    stack = ao.Laminate([ao.Ply(ply, carbon, angle) for angle in angles], (1, 0, 0))
    hit = ao.simulate(
        ao.ball(radius, ball), shell(0.2, 40, stack), 3.0, law=ao.Hertz(hertz), duration=3e-4
    )
    assert ball_mass(radius, ball) == pytest.approx(8.537e-3, rel=1e-3)
    assert hit.peak_force == pytest.approx(force.max(), rel=0.01)
    off = np.abs(hit.at(1e-7 * np.arange(len(force))).force - force).max()
    assert off < 0.04 * force.max()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:the record of")
def test_a_laminate_of_16_plies() -> None:
    """[0/90]4s of carbon and epoxy, 120 x 120 x 2 mm: lowest frequency, force of a light ball."""
    carbon: Any = ((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4))
    angles, ply = [0, 90] * 4 + [90, 0] * 4, 0.125e-3
    made = ao.Orthotropic(*carbon, rho=1550)
    stack = ao.Laminate([ao.Ply(ply, made, angle) for angle in angles], (1, 0, 0))
    sheets = [navier.Sheet(ply, navier.orthotropic(*carbon, angle), 1550.0) for angle in angles]
    plate = navier.plate((0.12, 0.12), sheets, 4e-4)
    law = ao.Hertz.between(STEEL, 0.005, made.half_space((0, 0, 1)), math.inf)
    force, _ = navier.struck(plate, law.k, ball_mass(0.005, STEEL), 1.0, 1.2e-4, 4e-8)
    tip = shell(0.12, 40, stack)
    hit = ao.simulate(ao.ball(0.005, STEEL), tip, 1.0, law=law, duration=1.2e-4)
    assert tip.body.frequencies(1)[0] == pytest.approx(plate.omega.min() / (2 * math.pi), rel=5e-3)
    assert hit.peak_force == pytest.approx(force.max(), rel=0.015)


def timoshenko(
    length: float, side: float, ball: float, metal: ao.Material, lasts: float
) -> FloatArray:
    """Force under a ball at mid-span at 10 mm/s, by the modes of Timoshenko's pinned beam."""
    area, second, E = side**2, side**4 / 12, metal.E
    shear = 10 * (1 + metal.nu) / (12 + 11 * metal.nu) * metal.shear_modulus * area
    omega2, shape = [], []
    for j in range(1, 120, 2):
        k = j * math.pi / length
        K = np.array([[shear * k * k, -shear * k], [-shear * k, E * second * k * k + shear]])
        found, modes = scipy.linalg.eigh(K, metal.rho * np.diag([area, second]) * length / 2)
        omega2 += list(found * length / 2)
        shape += list(abs(modes[0]))
    stiff, phi, n = np.array(omega2), np.array(shape), len(shape)
    hertz, mass = ao.Hertz.between(metal, ball, metal, math.inf).k, ball_mass(ball, metal)

    def motion(_: float, y: FloatArray) -> FloatArray:
        force = hertz * max(y[-2] - phi @ y[:n], 0.0) ** 1.5
        rates = [y[n : 2 * n], phi * force - stiff * y[:n], [y[-1], -force / mass]]
        return np.concatenate(rates)

    start = np.zeros(2 * n + 2)
    start[-1] = 0.01
    run = solve_ivp(
        motion, (0, lasts), start, method="DOP853", rtol=1e-8, atol=1e-14, max_step=2e-6
    )
    return np.asarray(hertz * np.maximum(run.y[-2] - phi @ run.y[:n], 0.0) ** 1.5)


@pytest.mark.filterwarnings("ignore:the record of")
@pytest.mark.parametrize(
    ("length", "ball", "lasts"),
    [
        (0.1535, 0.01, 4e-4),
        (0.307, 0.01, 4e-4),
        pytest.param(0.307, 0.02, 3e-3, marks=pytest.mark.slow),
    ],
)
def test_timoshenkos_three_beams(length: float, ball: float, lasts: float) -> None:
    """Steel, 10 x 10 mm (S. P. Timoshenko, Z. Math. Phys. 62, 198, 1913), with shear and inertia.

    The heavy ball strikes three times, and the largest force is that of the second blow.
    """
    metal = ao.Material(E=216e9, nu=0.3, rho=7960)
    body = bar(ao.RectangularSection(0.01, 0.01), metal, length, 40, fixed=[([0, 40], "xyz", "x")])
    tip = body.contact(point=(length / 2, 0, 0), direction=(0, 0, -1))
    hit = ao.simulate(ao.ball(ball, metal), tip, 0.01, duration=lasts, quantity="peak_force")
    exact = timoshenko(length, 0.01, ball, metal, lasts).max()
    assert hit.peak_force == pytest.approx(exact, rel=3e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "height", "elements"),
    [(0.01, 0.01, (6, 6)), (0.02, 0.006, (10, 4)), (0.006, 0.02, (4, 10))],
)
@pytest.mark.parametrize("along", [False, True], ids=["across", "end"])
def test_what_a_beam_leaves_out_of_its_section_is_claimed(
    width: float, height: float, elements: Any, along: bool
) -> None:
    """A free bar of 150 mm under a ball of 20 mm, against solids of 26 elements along it."""
    length, ball = 0.15, ao.ball(0.01, STEEL)
    box = ao.box_mesh((2.0, width, height), (26, *elements), kind="hexahedron20")
    nodes = box.nodes - [1.0, 0.5 * width, 0.5 * height]
    x = nodes[:, 0]  # -1 to 1; elements are smallest at the contact
    if along:
        nodes[:, 0] = 0.5 * length - length * (0.5 - 0.5 * x) ** 1.8
        place, way = (0.5 * length, 0.0, 0.0), (-1, 0, 0)
    else:
        nodes[:, 0] = 0.5 * length * np.sign(x) * np.abs(x) ** 1.8
        place, way = (0.0, 0.0, 0.5 * height), (0, 0, -1)
    solid = ao.FEModel.from_mesh(ao.Mesh(nodes, box.cells, box.kind), STEEL)
    exact = ao.simulate(ball, solid.contact(point=place, direction=way), 1.0).peak_force
    body = bar(ao.RectangularSection(width, height), STEEL, length, 40)
    tip = body.contact(point=(length if along else 0.5 * length, 0, 0), direction=way)
    hit = ao.simulate(ball, tip, 1.0)
    error = abs(hit.peak_force / exact - 1.0)
    assert 0.25 * hit.error["peak_force"].total < error < hit.error["peak_force"].total + 0.002


# Frames in their plane: corners, members, clamped corners; tubes of a bicycle are as slender.
PORTAL: Any = ([(0, 0), (0, 0.8), (1.2, 0.8), (1.2, 0)], [(0, 1), (1, 2), (2, 3)], [0, 3])
ANGLE: Any = ([(0, 0), (0, 0.5), (0.7, 0.5)], [(0, 1), (1, 2)], [0])
DIAMOND: Any = (
    [(0, 0), (0.42, 0), (0.25, 0.5), (0.85, 0.5)],
    [(0, 1), (0, 2), (1, 2), (2, 3), (1, 3)],
    [0],
)
RADIUS = 0.01


def member(length: float, w: complex) -> Any:
    """Exact stiffness of u, v, θ at both ends of Timoshenko's round bar at ω, by its ODE."""
    area, second = math.pi * RADIUS**2, math.pi * RADIUS**4 / 4
    factor = 6 * (1 + STEEL.nu) / (7 + 6 * STEEL.nu)  # G. R. Cowper, 1966
    inertia = STEEL.rho * (w * w).real
    slope = np.zeros((6, 6))  # of u, v, θ, N, V, M
    slope[0, 3], slope[3, 0] = 1 / (STEEL.E * area), -inertia * area
    slope[1, 2], slope[1, 4] = 1, 1 / (factor * STEEL.shear_modulus * area)
    slope[2, 5], slope[4, 1] = 1 / (STEEL.E * second), -inertia * area
    slope[5, 4], slope[5, 2] = -1, -inertia * second
    whole = scipy.linalg.expm(slope * length)
    (a, b), (c, d) = (np.split(row, 2, axis=1) for row in np.split(whole, 2))
    first = np.linalg.solve(b, np.hstack([-a, np.eye(3)]))
    return np.vstack([-first, np.hstack([c, 0 * c]) + d @ first])


def frame_stiffness(frame: Any, w: complex) -> Any:
    corners, members, held = frame
    K = np.zeros((3 * len(corners),) * 2)
    for i, j in members:
        along = np.subtract(corners[j], corners[i])
        length = math.hypot(*along)
        c, s = along / length
        turn = np.kron(np.eye(2), [[c, s, 0], [-s, c, 0], [0, 0, 1]])
        dofs = np.add.outer([3 * i, 3 * j], np.arange(3)).ravel()
        K[np.ix_(dofs, dofs)] += turn.T @ member(length, w) @ turn
    free = np.setdiff1d(np.arange(len(K)), np.add.outer(3 * np.array(held), np.arange(3)))
    return K[np.ix_(free, free)]


def frame_of_beams(frame: Any, n: int) -> ao.FEModel:
    corners, members, held = frame
    nodes = [(*corner, 0.0) for corner in corners]
    cells = []
    for i, j in members:
        share = np.arange(1, n)[:, None] / n
        inner = (1 - share) * np.array(corners[i]) + share * np.array(corners[j])
        chain = [i, *range(len(nodes), len(nodes) + n - 1), j]
        nodes += [(*place, 0.0) for place in inner]
        cells += list(pairwise(chain))
    plane = (list(range(len(nodes))), "z", "xy")
    body = ao.Beam(ao.CircularSection(RADIUS), STEEL)
    return ao.FEModel.from_mesh(
        ao.Mesh(nodes, cells, "line"), body, fixed=[(held, "xyz", "xyz"), plane]
    )


@pytest.mark.parametrize("frame", [PORTAL, ANGLE, DIAMOND], ids=["portal", "angle", "diamond"])
def test_frames_have_the_frequencies_of_their_exact_stiffness(frame: Any) -> None:
    """det K(ω) changes sign at each; eight beams a member, first four modes within 0.02 %."""
    for f in frame_of_beams(frame, 8).frequencies(4):
        signs = [
            np.linalg.slogdet(frame_stiffness(frame, 2 * math.pi * f * (1 + off)))[0]
            for off in (-2e-4, 2e-4)
        ]
        assert signs[0] != signs[1]


@pytest.mark.parametrize("frame", [PORTAL, DIAMOND], ids=["portal", "diamond"])
def test_frames_yield_exactly_to_static_loads(frame: Any) -> None:
    """One element a member. An ω of 0.01/s is static."""
    body = frame_of_beams(frame, 1)
    tip = body.contact(node=2, direction=(1, 0, 0))
    K = frame_stiffness(frame, 1e-2)
    load = np.zeros(len(K))
    load[3 * (2 - sum(node < 2 for node in frame[2]))] = 1.0
    exact = np.linalg.solve(K, load) @ load
    assert tip.b @ body.inverse().solve(tip.b) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("frame", [PORTAL, DIAMOND], ids=["portal", "diamond"])
@pytest.mark.parametrize(("n", "s"), [(2, 600.0), (4, 600.0), (4, 2500.0)])
def test_beams_half_as_long_show_what_a_mesh_of_beams_lacks(frame: Any, n: int, s: float) -> None:
    """Its compliance at i s, against the members' exact stiffness: the error falls by 4 to 16."""
    body = frame_of_beams(frame, n)
    tip = body.contact(node=2, direction=(1, 0, 0))
    K = np.asarray(frame_stiffness(frame, 1j * s)).real
    load = np.zeros(len(K))
    load[3 * (2 - sum(node < 2 for node in frame[2]))] = 1.0
    exact = np.linalg.solve(K, load) @ load
    known = tip.b @ body.inverse(s**2).solve(tip.b)
    finer = tip.finer
    lacking, found = exact - known, finer.b @ finer.body.inverse(s**2).solve(finer.b) - known
    assert 1e-5 < lacking / exact < 0.1
    assert found < lacking < 4.0 / 3.0 * found
