"""Stress of beams: bending about both axes, torsion, shear, joints, stiffeners of skins."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
L, ARM = 0.5, 0.2
TUBE = ao.TubularSection(0.02, 0.002)
BAR = ao.RectangularSection(width=0.02, height=0.04)


def angled(section: Any, n: int = 5) -> Any:
    """A post along x, clamped at the origin, and an arm from its end along y."""
    post = [(L * i / n, 0, 0) for i in range(n + 1)]
    arm = [(L, ARM * i / n, 0) for i in range(1, n + 1)]
    nodes = np.array(post + arm)
    cells = np.column_stack([np.arange(2 * n), np.arange(1, 2 * n + 1)])
    groups = {"post": np.arange(n), "arm": n + np.arange(n)}
    mesh = ao.Mesh(nodes, cells, "line", cell_sets=groups)
    beam = ao.Beam(section, STEEL, orientation=(0, 0, 1))
    return ao.FEModel.from_mesh(mesh, beam, fixed=[(0, "xyz", "xyz")])


def pushed(body: Any, point: Any, direction: Any) -> Any:
    """The body nearly at rest under F sin t of a soft spring: it still swings by F/ω, 0.4 %."""
    tip = body.contact(point=point, direction=direction)
    law = ao.Linear(k=1.0)
    return ao.simulate(
        ao.rigid(mass=1.0), tip, 10.0, law=law, duration=4.0, quantity="force", rtol=1e-3
    )


@pytest.fixture(scope="module")
def frames() -> dict[str, Any]:
    """Angled frames under a force along z at the end of the arm."""
    return {
        name: pushed(angled(section), (L, ARM, 0), (0, 0, -1))
        for name, section in (("tube", TUBE), ("bar", BAR))
    }


@pytest.mark.parametrize("way", [(0, 0, -1), (0, -1, 0), (0, -1, -1)])
def test_a_cantilever_bends_about_either_axis(way: Any) -> None:
    """σ = M_y c/I_y + M_z c/I_z: at the corners where both act."""
    body = angled(BAR)
    hit = pushed(body, (L, 0, 0), way)
    force = hit.peak_force * np.array(way) / np.linalg.norm(way)
    by_z, by_y = (6 * abs(force[i]) * L / (0.02 * 0.04 * c) for i, c in ((2, 0.04), (1, 0.02)))
    at = {"times": [hit.peak_time]}
    largest = hit.target.probe((0, 0, 0), **at).stress
    assert abs(largest["xx"][0]) == pytest.approx(by_z + by_y, rel=5e-3)
    for layer, sign, stress in (
        ("top", 1, by_z),
        ("bottom", -1, by_z),
        ("left", 1, by_y),
        ("right", -1, by_y),
        ((0.01, 0.02), 1, by_y + by_z),
    ):
        found = hit.target.probe((0, 0, 0), layer=layer, **at).stress["xx"][0]
        assert found == pytest.approx(sign * stress, rel=5e-3, abs=5e-3 * (by_y + by_z))


def test_an_oblique_force_on_a_tube_is_largest_in_its_own_plane() -> None:
    hit = pushed(angled(TUBE), (L, 0, 0), (0, -0.6, -0.8))
    second = math.pi / 4 * (0.02**4 - 0.018**4)
    stress = hit.target.field().stress().components[0, 0]
    assert abs(stress[0]) == pytest.approx(hit.peak_force * L * 0.02 / second, rel=5e-3)


def test_a_tube_under_torque_and_bending(frames: Any) -> None:
    """τ = T R/J and σ = M R/I at the clamped end."""
    hit = frames["tube"]
    second = math.pi / 4 * (0.02**4 - 0.018**4)
    F = hit.peak_force
    sigma, tau = F * L * 0.02 / second, F * ARM * 0.02 / (2 * second)
    root = hit.target.field().stress()
    assert root.von_mises[0, 0] == pytest.approx(math.hypot(sigma, math.sqrt(3) * tau), rel=5e-3)
    assert abs(root.tensor[0, 0, 0, 1:]).max() == pytest.approx(tau, rel=5e-3)


def test_a_rectangle_under_torque(frames: Any) -> None:
    """τ = T/(k a b²) on the long sides: k = 0.246 of sides 2 to 1 (Timoshenko and Goodier)."""
    hit = frames["bar"]
    torque, shear = hit.peak_force * ARM, 1.5 * hit.peak_force / (0.02 * 0.04)
    at = {"times": [hit.peak_time], "part": "post"}
    tau = torque / (0.246 * 0.04 * 0.02**2)
    sides = [hit.target.probe((L, 0, 0), layer=of, **at).stress for of in ("left", "right")]
    twisted = [side["xz"][0] for side in sides]
    assert abs(twisted[0] - twisted[1]) / 2 == pytest.approx(tau, rel=5e-3)
    assert abs(sum(twisted)) / 2 == pytest.approx(shear, rel=5e-3)
    corner = hit.target.probe((L, 0, 0), layer=(0.01, 0.02), **at).stress
    assert abs(corner["xz"][0]) < 2e-3 * tau


def test_a_rectangle_bent_and_twisted_is_stressed_most_within_a_side() -> None:
    """σ² + 3 τ² is largest between the corners, where σ is, and the middle, where τ is."""
    b, h, lever, way = 0.02, 0.04, 0.2, np.array([0, 1, -2.5])
    hit = pushed(angled(BAR), (L, ARM, 0), way)
    fy, fz = abs(hit.peak_force * way[1:] / np.linalg.norm(way))
    z = np.linspace(-h / 2, h / 2, 2001)
    n = np.arange(1, 60, 2)[:, None]
    constant = b**3 * h / 3
    constant *= 1 - 192 * b / (np.pi**5 * h) * (np.tanh(n * np.pi * h / 2 / b) / n**5).sum()
    series = np.cosh(n * np.pi * z / b) / np.cosh(n * np.pi * h / 2 / b) / n**2
    twisted = fz * ARM / constant * (b - 8 * b / np.pi**2 * series.sum(axis=0))
    sheared = 1.5 * fz / (b * h) * (1 - (2 * z / h) ** 2)
    bent = lever * (12 * fz * z / (b * h**3) + 6 * fy / (b**2 * h))
    largest = np.sqrt(bent**2 + 3 * (twisted + sheared) ** 2)
    assert largest.argmax() not in (0, 1000, 2000)
    found = hit.target.probe((L - lever, 0, 0), times=[hit.peak_time]).stress.von_mises[0]
    assert found == pytest.approx(largest.max(), rel=5e-3)


def test_members_at_a_joint_keep_their_own_stress(frames: Any) -> None:
    """The arm is bent and the post is twisted by F a; without a part the larger one is shown."""
    hit = frames["tube"]
    moment = hit.peak_force * ARM
    second = math.pi / 4 * (0.02**4 - 0.018**4)
    at = {"times": [hit.peak_time]}
    post, arm, both = (
        hit.target.probe((L, 0, 0), part=part, **at).stress for part in ("post", "arm", None)
    )
    bent, twisted = moment * 0.02 / second, moment * 0.02 / (2 * second)
    assert abs(arm["yy"][0]) == pytest.approx(bent, rel=5e-3)
    assert abs(arm["xx"][0]) < 1e-6 * bent
    shear = 2 * hit.peak_force / (math.pi * (0.02**2 - 0.018**2))
    assert post.von_mises[0] == pytest.approx(math.sqrt(3) * (twisted + shear), rel=0.02)
    assert both.von_mises[0] == max(post.von_mises[0], arm.von_mises[0])
    field = hit.target.field().stress(part="arm")
    assert np.isnan(field.von_mises[0, :5]).all()
    assert field["yy"][0, 5] == pytest.approx(arm["yy"][0], rel=1e-6)
    between = hit.target.probe((L, 0.1, 0), **at).stress["yy"][0]
    assert abs(between) == pytest.approx(bent / 2, rel=5e-3)


def test_axial_strain_and_stress_of_a_bar() -> None:
    """N/A everywhere, ε = σ/E, and -ν ε across."""
    hit = pushed(angled(TUBE), (L, 0, 0), (-1, 0, 0))
    found = hit.target.probe((0.25, 0, 0), layer="middle", times=[hit.peak_time])
    stress = -hit.peak_force / (math.pi * (0.02**2 - 0.018**2))
    assert found.stress["xx"][0] == pytest.approx(stress, rel=5e-3)
    assert found.strain["xx"][0] == pytest.approx(stress / 210e9, rel=5e-3)
    assert found.strain["yy"][0] == pytest.approx(-0.3 * stress / 210e9, rel=5e-3)


@pytest.mark.slow
def test_a_stiffener_has_its_own_stress() -> None:
    """σ = M z/I about the axis common to a strip and its rib, in both."""
    t, width, height = 2e-3, 0.04, 0.02
    strip = ao.sheet_mesh((0.8, width), (32, 2))
    middle = np.flatnonzero(abs(strip.nodes[:, 1] - width / 2) < 1e-9)
    groups = {"skin": np.arange(64), "rib": 64 + np.arange(32)}
    spine = np.column_stack([middle[:-1], middle[1:]])
    blocks: Any = [("quad", strip.cells), ("line", spine)]
    mesh = ao.Mesh(strip.nodes, blocks, "mixed", strip.node_sets, groups)
    metal, d = ao.Material(210e9, 0.0, 7800), (t + height) / 2
    rib = ao.Beam(ao.RectangularSection(5e-3, height), metal, (0, 0, 1), offset=(0, -d))
    body = ao.FEModel.from_mesh(
        mesh, {"skin": ao.Shell(t, metal), "rib": rib}, fixed=[("xmin", "xyz", "xyz")]
    )
    hit = pushed(body, (0.8, width / 2, 0), (0, 0, -1))
    plate, web = width * t, 5e-3 * height
    below = web * d / (plate + web)  # common axis under the plate's middle
    second = (plate * t**2 + web * height**2) / 12 + plate * web / (plate + web) * d**2
    moment, at = hit.peak_force * 0.4, {"times": [hit.peak_time]}
    place = body.nodes[middle[16]]
    skin = hit.target.probe(place, layer="top", **at).stress["xx"][0]
    foot = hit.target.probe(place, layer="bottom", part="rib", **at).stress["xx"][0]
    assert skin == pytest.approx(moment * (below + t / 2) / second, rel=0.02)
    assert foot == pytest.approx(-moment * (height + t / 2 - below) / second, rel=0.02)
    quantity = ao.StressAt(body, place, "xx", layer="bottom", part="rib")
    again = ao.simulate(
        ao.rigid(mass=1.0),
        body.contact(point=(0.8, width / 2, 0), direction=(0, 0, -1)),
        10.0,
        law=ao.Linear(k=1.0),
        duration=4.0,
        quantity=quantity,
        rtol=1e-2,
    )
    found = again.target.probe(place, layer="bottom", part="rib", times=[again.peak_time])
    assert found.stress["xx"][0] == pytest.approx(foot, rel=0.02)
    with pytest.raises(ao.InputError, match=r"^layer"):
        _ = hit.target.probe(body.nodes[0], part="rib", **at).stress
    with pytest.raises(ao.InputError, match=r"^part"):
        ao.StressAt(body, place, "xx", part="ribs")


@pytest.mark.parametrize(
    "layer", ["upper", (0, "left"), (0.1, "top"), (True, "top"), (1, 2, 3), 3, ("a", "b")]
)
def test_layers_that_are_none(layer: Any, frames: Any) -> None:
    with pytest.raises(ao.InputError, match=r"^layer"):
        frames["tube"].target.probe((0, 0, 0), layer=layer)


def test_a_beam_has_no_plies(frames: Any) -> None:
    with pytest.raises(ao.InputError, match=r"^layer"):
        _ = frames["tube"].target.probe((0, 0, 0), layer=(0, "top")).stress


@pytest.mark.parametrize("place", [(0.0, 0.03), (0.0, 0.017), (0.0, 0.0)])
def test_places_off_the_section_are_refused(place: Any, frames: Any) -> None:
    """Outside of a tube, and in its bore."""
    with pytest.raises(ao.InputError, match=r"^layer"):
        _ = frames["tube"].target.probe((0, 0, 0), layer=place).stress


def test_a_section_without_points_warns_that_bending_is_left_out() -> None:
    hit = pushed(angled(ao.BeamSection(8e-4, 1e-7, 3e-8, 7e-8)), (L, 0, 0), (0, 0, -1))
    with pytest.warns(ao.AOImpactWarning, match=r"^stress"):
        _ = hit.target.probe((0, 0, 0)).stress
