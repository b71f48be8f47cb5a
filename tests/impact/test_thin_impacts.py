"""Impacts on shells and beams by the default call, against plate theory and resolved contact."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from thinmeshes import bar

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BALL = ao.ball(radius=0.005, material=STEEL)


def sheet(
    t: float, n: int = 30, size: float = 0.15, kind: str = "quad", of: Any = STEEL, **given: Any
) -> Any:
    mesh = ao.sheet_mesh((size, size), (n, n), kind=kind)
    return ao.FEModel.from_mesh(mesh, ao.Shell(t, of), **given)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("t", "peak", "rebound", "tolerance"),
    [(2e-3, 215.10, -0.1936, 0.015), (4e-3, 347.72, -0.665, 0.015)],
)
def test_a_ball_on_a_sheet(t: float, peak: float, rebound: float, tolerance: float) -> None:
    """C. Zener's infinite plate (Phys. Rev. 59, 669, 1941) with Hertz's law.

    An elastic layer has 213.5 and 347.3 N and rebounds of -0.188 and -0.650 m/s: it shears.
    """
    hit = ao.simulate(BALL, sheet(t).contact(point=(0.075, 0.075, 0)), 1.0, duration=100e-6)
    assert hit.peak_force == pytest.approx(peak, rel=tolerance)
    assert hit.rebound_velocity == pytest.approx(rebound, rel=0.035)
    assert hit.error["peak_force"].total < 0.02


@pytest.mark.slow
def test_an_upright_sheet_is_struck_like_a_lying_one() -> None:
    """Normals then have components of rounding, along rotations without mass."""
    mesh = ao.sheet_mesh((0.1, 0.1), (20, 20))
    turn = np.array([[1, 0, 0], [0, math.cos(math.pi / 2), -1], [0, 1, math.cos(math.pi / 2)]])
    peaks = []
    for axes in (np.eye(3), turn):
        body = ao.FEModel.from_mesh(
            ao.Mesh(mesh.nodes @ axes.T, mesh.cells, "quad"), ao.Shell(2e-3, STEEL)
        )
        tip = body.contact(point=axes @ (0.0525, 0.0475, 0.0))
        peaks.append(ao.simulate(BALL, tip, 1.0, duration=60e-6).peak_force)
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-6)


@pytest.mark.slow
def test_a_ball_on_a_thin_sheet() -> None:
    """Elements of 5 mm are nearly three lengths of the bending wave, and finer ones half of it."""
    tip = sheet(1e-3, 60, 0.3).contact(point=(0.15, 0.15, 0))
    hit = ao.simulate(BALL, tip, 1.0, duration=300e-6, quantity="peak_force")
    assert hit.peak_force == pytest.approx(83.64, rel=0.015)


@pytest.mark.parametrize("n", [2, *(pytest.param(of, marks=pytest.mark.slow) for of in (4, 16))])
def test_elements_that_outgrow_the_wave_have_an_error_without_bound(n: int) -> None:
    """A beam of 2 m: its peak is up to 58 % off those of 256 elements, and finer ones miss that."""
    peaks = []
    for count in (n, 256):
        section, ends = ao.RectangularSection(0.01, 0.01), [([0, count], "xyz", "xyz")]
        body = bar(section, STEEL, 2.0, count, fixed=ends)
        tip = body.contact(point=(1, 0, 0), direction=(0, 0, -1))
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            peaks.append(ao.simulate(ao.ball(0.01, STEEL), tip, 1.0))
            assert (peaks[-1].error["peak_force"].mesh == math.inf) is (count == n)
        assert any("bending waves" in str(one.message) for one in found) is (count == n)
    assert peaks[0].peak_force > 1.1 * peaks[1].peak_force


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["quad", "triangle"])
def test_a_rigid_ball_on_a_sheet(kind: str) -> None:
    """Resolved by finite elements of 8 µm: 241.7 N, in contact for 41.9 µs."""
    law = ao.Hertz(4 / 3 * STEEL.plane_strain_modulus * math.sqrt(0.005))
    tip = sheet(2e-3, 36, kind=kind).contact(point=(0.075, 0.075, 0))
    hit = ao.simulate(ao.rigid(mass=4.0841e-3), tip, 1.0, law=law, duration=100e-6)
    assert hit.peak_force == pytest.approx(241.7, rel=0.015 if kind == "quad" else 0.025)
    assert hit.contact_duration == pytest.approx(41.9e-6, rel=0.025)


@pytest.mark.slow
@pytest.mark.parametrize("place", [(0.0775, 0.0775), (0.0762, 0.0737), (0.0775, 0.075)])
def test_a_contact_may_be_anywhere_on_an_element(place: tuple[float, float]) -> None:
    body = sheet(2e-3)
    node, between = (
        ao.simulate(BALL, body.contact(point=(*at, 0)), 1.0, duration=100e-6)
        for at in ((0.075, 0.075), place)
    )
    assert between.peak_force == pytest.approx(node.peak_force, rel=6e-3)
    assert between.impulse == pytest.approx(node.impulse, rel=5e-3)


def bent(size: Any, n: Any, place: Any) -> Any:
    """A sheet of (x, y), 2 mm thick, with its nodes at (x, *place(y))."""
    mesh = ao.sheet_mesh(size, n)
    y, z = place(mesh.nodes[:, 1] - 0.5 * size[1])
    nodes = np.stack([mesh.nodes[:, 0], y, z], axis=1)
    return ao.FEModel.from_mesh(ao.Mesh(nodes, mesh.cells, "quad"), ao.Shell(2e-3, STEEL))


def peak(body: Any, point: Any, **given: Any) -> float:
    return float(ao.simulate(BALL, body.contact(point=point, **given), 1.0).peak_force)


@pytest.mark.slow
@pytest.mark.parametrize("given", [{}, {"radius": 5e-4}], ids=["point", "patch"])
def test_a_curved_shell_may_be_touched_anywhere_on_an_element(given: Any) -> None:
    """Half a tube, R/t = 7.5, elements of 2 t: at a node, on edges and within elements alike."""
    R, turn = 0.015, math.radians(15)
    body = bent((0.06, 12 * turn), (15, 12), lambda angle: (R * np.sin(angle), R * np.cos(angle)))
    node = peak(body, (0.028, 0.0, R), **given)
    for x, share in ((0.030, 0.0), (0.0287, 0.3), (0.0295, 0.5)):
        first, last = ((R * math.sin(a), R * math.cos(a)) for a in (0.0, turn))
        place = (1.0 - share) * np.array(first) + share * np.array(last)
        assert peak(body, (x, *place), **given) == pytest.approx(node, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [5.0, 20.0])
def test_a_fold_may_be_touched_anywhere(degrees: float) -> None:
    c, s = np.cos(np.radians(degrees / 2)), np.sin(np.radians(degrees / 2))
    body = bent((0.08, 0.08), (16, 16), lambda y: (c * y, -s * np.abs(y)))
    node = peak(body, (0.04, 0.0, 0.0))
    assert peak(body, (0.0425, 0.0, 0.0)) == pytest.approx(node, rel=0.01)
    beside = peak(body, (0.04, 5e-3 * c, -5e-3 * s))
    assert peak(body, (0.042, 5e-3 * c, -5e-3 * s)) == pytest.approx(beside, rel=0.01)


def test_resultant_and_moment_of_a_contact_within_an_element() -> None:
    tip = sheet(2e-3).contact(point=(0.0762, 0.0737, 0))
    assert tip.resultant == pytest.approx([0, 0, -1])


@pytest.mark.parametrize("role", ["target", "projectile"])
@pytest.mark.parametrize("direction", [None, (0, 0, 1), (0, 0, -1)])
@pytest.mark.slow
def test_both_sides_of_a_shell_are_alike(role: str, direction: Any) -> None:
    tip = sheet(2e-3).contact(point=(0.075, 0.075, 0), direction=direction)
    pair = (BALL, tip) if role == "target" else (tip, BALL)
    hit = ao.simulate(*pair, 1.0, duration=100e-6)
    assert hit.peak_force == pytest.approx(213.5, rel=3e-3)  # that of the layer


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_curved_shell_is_touched_outside_and_inside(side: float) -> None:
    """1/R adds to the ball's curvature outside, and is taken off inside: Hertz's k by both."""
    R = 0.1
    mesh = ao.sheet_mesh((1.0, 0.1), (24, 24))
    turn = mesh.nodes[:, 0] - 0.5
    nodes = np.stack([R * np.sin(turn), mesh.nodes[:, 1], R * np.cos(turn)], axis=1)
    body = ao.FEModel.from_mesh(ao.Mesh(nodes, mesh.cells[:, ::-1], "quad"), ao.Shell(2e-3, STEEL))
    tip = body.contact(point=(0, 0.05, R), direction=(0, 0, -side))
    assert tip.normal == pytest.approx([0, 0, side], abs=1e-9)
    model = ao.antioscillators(tip, 8, method="krylov", contact_time=50e-6, duration=150e-6)
    hit = ao.simulate(BALL, model, 1.0, duration=150e-6)
    expected = ao.Hertz.between(STEEL, 0.005, STEEL, (side * R, math.inf))
    assert hit.law.k == pytest.approx(expected.k, rel=2e-3)


def skin_on_a_web(n: int, *, web: float = 1e-3, at: int | None = None) -> Any:
    """A skin of n x n elements, 0.1 m, 2 mm thick, and a web below it under a line of nodes."""
    x = np.linspace(-0.05, 0.05, n + 1)
    flat = ao.sheet_mesh((0.1, 0.1), (n, n))
    m, line = n // 4, x[n // 2 if at is None else at]
    along, down = np.meshgrid(x, -np.linspace(0, 0.025, m + 1)[1:], indexing="ij")
    hung = np.column_stack([np.full(along.size, line), along.ravel(), down.ravel()])
    nodes = flat.nodes - (0.05, 0.05, 0)
    on = np.flatnonzero(np.abs(nodes[:, 0] - line) < 1e-9)
    i = np.column_stack(
        [on[np.argsort(nodes[on, 1])], len(nodes) + np.arange(along.size).reshape(n + 1, m)]
    )
    below = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 4)
    cells, count = np.vstack([flat.cells, below]), len(flat.cells)
    groups = {"skin": np.arange(count), "web": np.arange(count, len(cells))}
    mesh = ao.Mesh(np.vstack([nodes, hung]), cells, "quad", cell_sets=groups)
    shells = {"skin": ao.Shell(2e-3, STEEL), "web": ao.Shell(web, STEEL)}
    return ao.FEModel.from_mesh(mesh, shells)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of a coarse mesh
@pytest.mark.parametrize("place", [0.0, 5e-3])
def test_a_skin_is_struck_over_and_beside_a_web_as_solids_are(place: float) -> None:
    """Both 2 mm thick, on elements of 2.5 and 1.25 thicknesses; direction and shell of the skin."""
    share = np.cumsum(1.3 ** np.arange(14))
    share /= share[-1]
    last, between = max(1e-3, place), np.linspace(1e-3, place, 8)[1:] if place else []
    left, right = -1e-3 - 0.049 * share[::-1], last + (0.05 - last) * share
    lines = [
        np.concatenate([left, [-1e-3, 0.0, 1e-3], between, right]),
        0.05 * np.concatenate([-share[::-1], [0.0], share]),
        np.array([-25.0, -17.0, -10.0, -6.0, -3.5, -2.0, -1.0, 0.0, 1.0]) / 1e3,
    ]
    n = [len(x) - 1 for x in lines]
    box = ao.box_mesh(n, n, kind="hexahedron20")
    columns = zip(box.nodes.T, lines, strict=True)
    nodes = np.stack([np.interp(at, np.arange(len(x)), x) for at, x in columns], axis=1)
    x, _, z = nodes[box.cells].mean(axis=1).T
    used, cells = np.unique(box.cells[(abs(x) < 1e-3) | (z > -1e-3)], return_inverse=True)
    solid = ao.FEModel.from_mesh(ao.Mesh(nodes[used], cells.reshape(-1, 20), box.kind), STEEL)
    tip = solid.contact(point=(place, 0, 1e-3), direction=(0, 0, -1))
    known = ao.simulate(BALL, tip, 1.0, quantity="peak_force", duration=60e-6).peak_force
    for n in (20, 40):
        tip = skin_on_a_web(n, web=2e-3).contact(point=(place, 0, 0))
        assert tip.direction == pytest.approx([0, 0, -1], abs=1e-12)
        assert tip.thin == ao.Shell(2e-3, STEEL)
        hit = ao.simulate(BALL, tip, 1.0, quantity="peak_force", duration=60e-6)
        assert abs(hit.peak_force / known - 1.0) < min(hit.error["peak_force"].total, 0.02)


@pytest.mark.slow
def test_the_mesh_error_of_a_spring_at_a_node_of_a_shell() -> None:
    """Deflection by shear depends on the mesh under any law; a finer one is within the error."""
    coarse, fine = (
        ao.simulate(
            ao.rigid(mass=4e-3),
            sheet(4e-3, n, 0.1).contact(point=(0.05, 0.05, 0)),
            1.0,
            law=ao.Linear(k=2e7),
            quantity="peak_force",
            duration=60e-6,
        )
        for n in (10, 30)
    )
    apart = abs(coarse.peak_force / fine.peak_force - 1.0)
    assert 0.0 < apart < coarse.error["peak_force"].total


def thrown_off(n: int, kind: str = "quad", **given: Any) -> ao.Result:
    """The waves of a held sheet throw a ball off: small elements have three touches."""
    held = [(edge, "xyz", "xyz") for edge in ("xmin", "xmax", "ymin", "ymax")]
    light = ao.Material(E=70e9, nu=0.33, rho=2700)
    tip = sheet(2e-3, n, 0.1, kind, light, fixed=held).contact(point=(0.05, 0.05, 0))
    return ao.simulate(BALL, tip, 1.0, **given)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*mesh makes an error")
def test_numbers_of_all_touches_are_off_where_there_is_one_less() -> None:
    exact, rough = thrown_off(32), thrown_off(8, "triangle")
    for name in ("impulse", "rebound_velocity"):
        assert abs(rough.value(name) / exact.value(name) - 1.0) > 0.2
        assert math.isfinite(exact.error[name].mesh)


@pytest.mark.filterwarnings("ignore:.*mesh makes an error")
def test_numbers_of_all_touches_have_no_bound_where_one_run_has_more_of_them() -> None:
    hit = thrown_off(8, "triangle")
    assert hit.error["impulse"].mesh == hit.error["rebound_velocity"].mesh == math.inf
    apart = thrown_off(12, duration=86e-6)  # and as meshed still in touch
    assert apart.error["rebound_velocity"].total == math.inf > apart.rebound_velocity
    assert math.isnan(apart.beside.rebound_velocity)


@pytest.mark.filterwarnings("ignore:.*mesh makes an error", "ignore:the contact makes an error")
@pytest.mark.parametrize(
    ("n", "kind"), [(8, "hexahedron"), pytest.param(10, "hexahedron20", marks=pytest.mark.slow)]
)
def test_a_heavy_tup_is_thrown_back_with_all_its_momentum(n: int, kind: str) -> None:
    """But for the waves that it leaves in the plate, and known as well as these are."""
    edges = [(name, "xyz") for name in ("xmin", "xmax", "ymin", "ymax")]
    mesh = ao.box_mesh((0.1, 0.1, 0.002), (n, n, 1), kind=kind)
    held = ao.FEModel.from_mesh(mesh, STEEL, fixed=edges).contact(point=(0.05, 0.05, 0.002))
    hit = ao.simulate(ao.ball(0.008, STEEL, mass=1.0), held, 0.3)
    assert abs(hit.impulse / 0.6 - 1.0) < hit.error["impulse"].total < 0.02


def test_a_fold_has_no_normal() -> None:
    """A web along the rim of the skin: neither goes on."""
    with pytest.raises(ao.InputError, match=r"^point"):
        skin_on_a_web(8, at=0).contact(point=(-0.05, 0, 0))


def test_a_laminate_is_pressed_on_the_ply_that_faces_the_ball() -> None:
    soft = ao.Orthotropic((10e9, 10e9, 5e9), (3e9, 3e9, 2e9), (0.3, 0.3, 0.3), rho=1500)
    stiff = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    stack = ao.Laminate([ao.Ply(1e-3, soft), ao.Ply(1e-3, stiff)], fibre_axis=(1, 0, 0))
    body = ao.FEModel.from_mesh(ao.sheet_mesh((0.1, 0.1), (10, 10)), stack)
    for side, ply in ((1, stiff), (-1, soft)):
        tip = body.contact(point=(0.05, 0.05, 0), direction=(0, 0, -side))
        assert tip.material == ply.half_space((0, 0, 1))


def beam(n: int = 50) -> ao.FEModel:
    """The paper's beam: 1 m, 20 x 20 mm of aluminium, simply supported."""
    section, metal = ao.RectangularSection(0.02, 0.02), ao.Material(70e9, 0.3, 2400)
    return bar(section, metal, 1.0, n, fixed=[([0, n], "xyz", "x")])


def test_the_papers_beam_as_a_beam() -> None:
    """A steel ball at mid-span; the solid of 459 nodes has 965 N by its middle node in 28 AOs."""
    body = beam()
    tip = body.contact(point=(0.5, 0, 0), direction=(0, 0, -1))
    star = ao.antioscillators(tip, n=28, method="eigen")
    assert star.m.sum() + star.m0 == pytest.approx(0.4672, rel=5e-3)
    hit = ao.simulate(ao.ball(0.01, STEEL), tip, 1.0, duration=200e-6)
    fine = beam(200).contact(point=(0.5, 0, 0), direction=(0, 0, -1))
    finer = ao.simulate(ao.ball(0.01, STEEL), fine, 1.0, duration=200e-6)
    assert hit.peak_force == pytest.approx(finer.peak_force, rel=5e-3)


def test_a_beam_may_be_touched_between_its_nodes() -> None:
    """Two meshes with and without a node at the place."""
    place = (0.415, 0, 0)
    hits = [
        ao.simulate(
            ao.ball(0.01, STEEL),
            beam(n).contact(point=place, direction=(0, 0, -1)),
            1.0,
            duration=150e-6,
        )
        for n in (100, 200)
    ]
    assert hits[0].peak_force == pytest.approx(hits[1].peak_force, rel=0.01)
    tip = beam(50).contact(point=place, direction=(0, 0, -1))
    assert tip.resultant == pytest.approx([0, 0, -1])


def test_a_round_beam_is_curved_across() -> None:
    body = bar(ao.CircularSection(0.01), STEEL, 0.5)
    tip = body.contact(node=10, direction=(0, 0, -1))
    hit = ao.simulate(BALL, tip, 1.0, duration=100e-6)
    assert hit.law.k == pytest.approx(
        ao.Hertz.between(STEEL, 0.005, STEEL, (0.01, math.inf)).k, rel=1e-6
    )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of a coarse mesh
def test_a_contact_wider_than_a_shell_is_thick_is_said() -> None:
    """√(Rδ) above t/2 warns, and the contact's part of the error is large but finite."""
    ball, tip = ao.ball(0.05, STEEL), sheet(5e-4, 20, 0.1).contact(point=(0.05, 0.05, 0))
    for speed in (3.0, 4.0):
        with pytest.warns(ao.AOImpactWarning, match="more than half the thickness of the shell"):
            hit = ao.simulate(ball, tip, speed, quantity="peak_force", rtol=0.05, duration=2e-4)
        assert 0.1 < hit.error["peak_force"].contact < math.inf


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of a coarse mesh
def test_a_skin_over_a_web_has_one_side() -> None:
    """However its elements were drawn; the web stands on it as it did, and no skin is turned."""
    body = skin_on_a_web(12, web=2e-3)
    cells = body.mesh.cells.copy()
    beyond = body.mesh.nodes[cells, 0].mean(axis=1) > 1e-6
    cells[beyond] = cells[beyond][:, ::-1]
    with pytest.warns(ao.AOImpactWarning, match="surface"):
        mended = ao.FEModel.from_mesh(
            ao.Mesh(body.mesh.nodes, cells, "quad"), ao.Shell(2e-3, STEEL)
        )
    force = [
        ao.simulate(BALL, of.contact(point=(0, 0, 0)), 1.0, duration=50e-6).peak_force
        for of in (body, mended)
    ]
    assert force[1] == pytest.approx(force[0], rel=1e-9)


@pytest.mark.slow
def test_a_flying_laminate_is_touched_on_the_side_ahead_of_it() -> None:
    """Along its normal its top is ahead, as where no direction is given; turned over, the other."""
    plies = [ao.Ply(1e-3, STEEL), ao.Ply(2e-3, ao.Material(E=70e9, nu=0.33, rho=2700))]
    ball, force = ao.ball(0.01, STEEL), []
    for stack, z in ((plies, None), (plies, 1), (plies[::-1], -1)):
        body = ao.FEModel.from_mesh(
            ao.sheet_mesh((0.1, 0.1), (12, 12)), ao.Laminate(stack, (1, 0, 0))
        )
        tip = body.contact(point=(0.05, 0.05, 0), direction=None if z is None else (0, 0, z))
        force.append(ao.simulate(tip, ball, 1.0, quantity="peak_force", rtol=1e-5).peak_force)
    assert force[1:] == pytest.approx(force[:1] * 2, rel=1e-5)


@pytest.mark.slow
def test_a_law_between_layers_is_that_by_default() -> None:
    """A laminate is touched on its top ply, a shell on its material, a ply across its fibres."""
    carbon = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
    alu = ao.Material(E=70e9, nu=0.33, rho=2700)
    stack = ao.Laminate([ao.Ply(1e-3, alu), ao.Ply(1e-3, carbon)], fibre_axis=(1, 0, 0))
    body = ao.FEModel.from_mesh(ao.sheet_mesh((0.1, 0.1), (20, 20)), stack)
    hit = ao.simulate(BALL, body.contact(point=(0.05, 0.05, 0.0)), 1.0, duration=2e-4)
    law = ao.Hertz.between(STEEL, 0.005, stack, math.inf)
    assert hit.law.k == pytest.approx(law.k, rel=1e-12)
    assert law == ao.Hertz.between(STEEL, 0.005, carbon, math.inf)
    of_shell = ao.Hertz.between(ao.Shell(1e-3, alu), math.inf, STEEL, 0.005)
    assert of_shell.k == pytest.approx(ao.Hertz.between(alu, math.inf, STEEL, 0.005).k, rel=1e-12)
    with pytest.raises(ao.InputTypeError, match="material_2"):
        ao.Hertz.between(STEEL, 0.005, "carbon", math.inf)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("radius", [1.8e-3, 3.5e-3])
def test_a_given_radius_hardly_matters_on_a_thick_laminate(radius: float) -> None:
    """A clamped plate of 5 mm, orthotropic, under 5 kg at 3 J: quadratic bricks have 7308 N.

    What the plate yields under the patch is made good for the contact itself, which is narrower.
    """
    E, G, nu = (53e9, 53e9, 9.5e9), (53e9 / 2.6, 3.94e9, 3.94e9), (0.3, 0.32, 0.32)
    stack = ao.Laminate([ao.Ply(5.11e-3, ao.Orthotropic(E, G, nu, rho=1590))], (1, 0, 0))
    mesh = ao.sheet_mesh((0.125, 0.075), (30, 18))
    body = ao.FEModel.from_mesh(mesh, stack, fixed=[("rim", "xyz", "xyz")])
    tip = body.contact(point=(0.0625, 0.0375, 0.0), radius=radius)
    tup, speed = ao.ball(0.008, STEEL, mass=5.0), math.sqrt(2.0 * 3.0 / 5.0)
    hit = ao.simulate(tup, tip, speed, quantity="peak_force", rtol=5e-3)
    assert abs(hit.peak_force / 7308.0 - 1.0) < min(hit.error["peak_force"].total, 5e-3)


def test_a_tup_has_a_nose_and_a_mass() -> None:
    """Hertz's peak of a mass on a wall goes with m^(3/5); a guided tup does not turn."""
    tup, wall = ao.ball(0.005, STEEL, mass=5.0), ao.wall(STEEL)
    heavy, light = (ao.simulate(of, wall, 1.0).peak_force for of in (tup, BALL))
    ratio = 5.0 / (4.0 / 3.0 * math.pi * 0.005**3 * STEEL.rho)
    assert heavy / light == pytest.approx(ratio**0.6, rel=1e-4)
    slid = ao.simulate(tup, wall, (0.0, 0.5, -1.0), friction=0.1)
    assert np.abs(slid.projectile.final_spin).max() == 0.0
    assert slid.projectile.final_velocity[1] == pytest.approx(0.5 - 0.1 * 2.0, rel=1e-3)
    with pytest.raises(ao.InputError, match="mass"):
        ao.ball(0.005, STEEL, mass=-1.0)


def test_a_beam_touched_on_its_side_knows_its_direction() -> None:
    on = beam().contact(point=(0.5, 0.0, 0.005))
    across = beam().contact(point=(0.5, 0.0, 0.0), direction=(0, 0, -1))
    assert on.direction == pytest.approx([0.0, 0.0, -1.0])
    assert on.b == pytest.approx(across.b)
    with pytest.raises(ao.InputTypeError, match="direction"):
        beam().contact(point=(0.5, 0.0, 0.0))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of the rim
def test_a_corner_of_a_sheet_is_struck_as_that_of_solids() -> None:
    """2 mm from both edges of a free sheet of 2 mm: what the mesh of a shell yields there is hers.

    The law would otherwise lose more than it has.
    """
    bricks = ao.box_mesh((1.0, 1.0, 2e-3), (16, 16, 2), kind="hexahedron20")
    nodes = bricks.nodes * [0.04, 0.04, 1.0]
    nodes[:, :2] *= np.sqrt(bricks.nodes[:, :2])  # finer towards the corner
    solid = ao.FEModel.from_mesh(ao.Mesh(nodes, bricks.cells, bricks.kind), STEEL)
    tips = [solid.contact(point=(2e-3, 2e-3, 2e-3))]
    tips += [sheet(2e-3, n, 0.04).contact(point=(2e-3, 2e-3, 0.0)) for n in (8, 32)]
    ball = ao.ball(radius=0.02, material=STEEL)
    known, *hits = (
        ao.simulate(ball, tip, 1.0, quantity="peak_force", duration=1e-4) for tip in tips
    )
    for hit in hits:  # elements of 5 mm hold the corner and the contact, those of 1.25 mm do not
        off = abs(hit.peak_force / known.peak_force - 1.0)
        assert off < hit.error["peak_force"].total < 0.1
    assert off < 0.02


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of a coarse mesh
def test_a_foil_is_no_mechanism() -> None:
    """Forces of balls that are as small as the foil is thin go with the square of that."""

    def force(t: float) -> float:
        tip = sheet(t, 6, 0.1).contact(point=(0.05, 0.05, 0))
        return ao.simulate(ao.ball(0.1 * t, STEEL), tip, 1e-3).peak_force / t**2

    assert force(1e-7) == pytest.approx(force(1e-5), rel=1e-3)


UP, MIDSPAN = (0, 0, 1), (0.5, 0, 0)


@pytest.mark.parametrize(
    ("body", "given", "words"),
    [
        (beam, {"point": MIDSPAN}, r"^contact"),
        (beam, {"point": (0.5, 0, 0.1), "direction": UP}, r"^point"),
        (beam, {"point": MIDSPAN, "direction": UP, "radius": 0.01}, r"^radius"),
        (beam, {"point": (0, 0, 0), "direction": UP}, r"^point"),
        (sheet, {"point": (0.075, 0.075, 0.1)}, r"^point"),
        (sheet, {"point": (0.075, 0.075, 0), "direction": (1, 0, 0)}, r"^direction"),
    ],
)
def test_refusals(body: Any, given: Any, words: str) -> None:
    with pytest.raises((ao.InputError, ao.InputTypeError), match=words):
        (body() if body is beam else body(2e-3)).contact(**given)


def bricks(t: float, n: int, layers: int = 1, size: float = 0.1) -> Any:
    mesh = ao.box_mesh((size, size, t), (n, n, layers), kind="hexahedron20")
    rims = [("xmin", "xyz"), ("xmax", "xyz")]
    return ao.FEModel.from_mesh(mesh, STEEL, rims).contact(point=(size / 2, size / 2, t))


@pytest.mark.slow
@pytest.mark.parametrize(("n", "layers", "said"), [(5, 1, True), (10, 2, True), (6, 1, False)])
def test_solids_as_flat_as_a_tenth_of_their_width_should_be_shells(
    n: int, layers: int, said: bool
) -> None:
    """The default call says so when it runs, with the shell to take."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        ao.simulate(BALL, bricks(2e-3, n, layers), 1.0, duration=50e-6)
    texts = [str(one.message) for one in found]
    advice = f"ao.Shell(thickness=0.002, material={STEEL!r})"
    assert any(advice in text for text in texts) is said


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
@pytest.mark.parametrize(("t", "n", "exact"), [(1e-3, 5, 83.6), (2e-3, 3, 215.1)])
def test_the_error_of_solids_that_do_not_carry_bending_waves_has_no_bound(
    t: float, n: int, exact: float
) -> None:
    """C. Zener's sheets; the elements are 3 to 10 times as long as (D/(m s²))^(1/4)."""
    hit = ao.simulate(BALL, bricks(t, n), 1.0, duration=50e-6)
    assert hit.peak_force > 1.15 * exact
    assert hit.error["peak_force"].mesh == math.inf


@pytest.mark.slow
def test_the_error_claimed_of_solids_that_carry_bending_waves_is_the_true_one() -> None:
    hit = ao.simulate(BALL, bricks(2e-3, 24, size=0.12), 1.0, duration=50e-6)
    off = abs(hit.peak_force - 215.1) / hit.peak_force
    assert off < hit.error["peak_force"].total < 0.07


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_beside_a_contact_that_hardly_presses_a_sheet_is_rigid() -> None:
    """Hertz's peak force on a rigid wall is k^(2/5) (5/4 m v²)^(3/5)."""
    velocity = 1e-12
    hit = ao.simulate(BALL, sheet(2e-3, n=10).contact(point=(0.075, 0.075, 0)), velocity)
    rigid = hit.law.k**0.4 * (1.25 * BALL.m0 * velocity**2) ** 0.6
    assert hit.peak_force == pytest.approx(rigid, rel=0.015)
