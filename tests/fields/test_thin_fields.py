"""Stress, probes, files and pictures of shells and beams."""

from __future__ import annotations

import math
from typing import Any

import matplotlib
import numpy as np
import pytest

import aoimpact as ao
from aoimpact.fields import motion_rows, place_rows

matplotlib.use("Agg")

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
CARBON = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
XX, YY = range(2)


def strip(layers: Any, n: int = 16, angle: float = 0.0) -> Any:
    """A cantilever along x, 200 x 20 mm, turned about y by an angle."""
    mesh = ao.sheet_mesh((0.2, 0.02), (n, 2))
    c, s = math.cos(angle), math.sin(angle)
    nodes = mesh.nodes @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    turned = ao.Mesh(nodes, mesh.cells, "quad", mesh.node_sets)
    return ao.FEModel.from_mesh(turned, layers, fixed=[("xmin", "xyz", "xyz")])


def pushed(body: Any, point: Any, direction: Any, force: float = 10.0) -> Any:
    """The body at rest under a force that a slow, soft spring puts on it: F(t) is a half sine."""
    tip = body.contact(point=point, direction=direction)
    model = ao.antioscillators(tip, 1, method="krylov", contact_time=3.0)
    law = ao.Linear(k=1.0)  # soft: the body follows as at rest
    velocity = force  # peak k x = √(k m) v
    return ao.simulate(ao.rigid(mass=1.0), model, velocity, law=law, duration=4.0)


@pytest.mark.parametrize("angle", [0.6, pytest.param(0.0, marks=pytest.mark.slow)])
def test_stress_of_a_cantilever_on_either_face(angle: float) -> None:
    """σ = ± 6 F (L - x)/(b t²) along the strip; nothing in the middle surface but shear."""
    t, F = 2e-3, 10.0
    body = strip(ao.Shell(t, ao.Material(210e9, 0.0, 7800)), angle=angle)
    c, s = math.cos(angle), math.sin(angle)
    axis, normal = np.array([c, 0, s]), np.array([-s, 0, c])
    hit = pushed(body, 0.2 * axis + [0, 0.01, 0], -normal, F)
    field = hit.target.field()
    node = int(np.linalg.norm(body.nodes - (0.1 * axis + [0, 0.01, 0]), axis=1).argmin())
    bending = 6 * hit.peak_force * 0.1 / (0.02 * t**2)
    for layer, sign in (("top", 1), ("middle", 0), ("bottom", -1)):
        tensor = field.stress(layer=layer).tensor[0, node]
        assert axis @ tensor @ axis == pytest.approx(sign * bending, rel=0.01, abs=1e-3 * bending)
        assert normal @ tensor @ normal == pytest.approx(0.0, abs=1e-6 * bending)
    at = hit.target.probe(body.nodes[node], times=[hit.peak_time])
    assert axis @ at.strain.tensor[0] @ axis == pytest.approx(bending / 210e9, rel=0.01)
    reaction = hit.target.reaction("xmin", times=[hit.peak_time])
    assert reaction.force[0] == pytest.approx(hit.peak_force * normal, rel=0.01, abs=0.1)
    arm = np.cross(0.2 * axis, -hit.peak_force * normal)  # of the force about the clamp
    assert reaction.moment[0] == pytest.approx(-arm, rel=0.02, abs=0.02 * np.linalg.norm(arm))
    shear = axis @ field.stress(layer="middle").tensor[0, node] @ normal
    assert abs(shear) == pytest.approx(1.5 * hit.peak_force / (0.02 * t), rel=0.02)
    assert field.rotation.shape == field.displacement.shape
    deflection = hit.peak_force * 0.2**3 / (3 * 210e9 * 0.02 * t**3 / 12)
    probe = hit.target.probe(0.2 * axis + [0, 0.01, 0], -normal, times=[hit.peak_time])
    assert probe.displacement[0] == pytest.approx(deflection, rel=0.01)


def test_a_gauge_on_either_face_of_a_shell() -> None:
    """ε = 6 F (L - x)/(E b t²): bending is linear, so that the mean is that of the middle."""
    body = strip(ao.Shell(2e-3, ao.Material(210e9, 0.0, 7800)))
    hit = pushed(body, (0.2, 0.01, 0), (0, 0, -1))
    strain = 6 * hit.peak_force * 0.1 / (210e9 * 0.02 * 4e-6)
    for layer, z, sign in ((None, 1e-3, 1), ("top", 0.0, 1), ("bottom", 0.0, -1)):
        gauge = hit.target.gauge(
            (0.1, 0.01, z), (1, 0, 0), 0.03, layer=layer, times=[hit.peak_time]
        )
        assert gauge.strain[0] == pytest.approx(sign * strain, rel=0.01)
    along = hit.target.gauge((0.1, 0.01, 0), (1, 1, 0), 0.01, times=[hit.peak_time])
    assert along.strain[0] == pytest.approx(strain / 2, rel=0.01)
    quantity = ao.StrainAt(body, (0.1, 0.01, 0), (1, 0, 0), length=0.03, layer="bottom")
    tip = body.contact(point=(0.2, 0.01, 0), direction=(0, 0, -1))
    again = ao.simulate(
        *(ao.rigid(mass=1.0), tip, 10.0), law=ao.Linear(k=1.0), duration=4.0, quantity=quantity
    )
    gauge = again.target.gauge(
        (0.1, 0.01, 0), (1, 0, 0), 0.03, layer="bottom", times=[hit.peak_time]
    )
    assert gauge.strain[0] == pytest.approx(-strain, rel=0.02)


@pytest.mark.parametrize("kind", ["quad", "triangle"])
def test_a_sensor_within_an_element_follows_its_bending(kind: str) -> None:
    """w = x² - xy + y²/2 with its rotations (∂w/∂y, -∂w/∂x) at the nodes is w anywhere."""
    sheet = ao.sheet_mesh((0.04, 0.06), (4, 4), kind=kind)
    body = ao.FEModel.from_mesh(sheet, ao.Shell(2e-3, STEEL))
    x, y, still = sheet.nodes.T
    moved = np.transpose([still, still, x**2 - x * y + y**2 / 2])
    turned = np.transpose([y - x, y - 2 * x, still])
    places = np.array([[0.013, 0.02, 0], [0.0137, 0.0421, 0], [0.025, 0.0075, 0], [0.04, 0.05, 0]])
    rows = motion_rows(body, place_rows(body, places), np.eye(3)[2:])
    x, y, _ = places.T
    at_places = rows @ np.concatenate([moved, turned]).ravel()
    assert at_places == pytest.approx(x**2 - x * y + y**2 / 2, rel=1e-12)


@pytest.mark.parametrize("place", [(0.013, 0.02), (0.02, 0.0251)])
def test_a_sensor_within_an_element_of_a_ball_turns_with_it(place: Any) -> None:
    """A sphere turned about any axis: u = θ × x, though the facets' normals are not the nodes'."""
    sheet, R = ao.sheet_mesh((0.04, 0.04), (8, 8)), 0.05
    turns = (sheet.nodes[:, :2] - 0.02) / R
    nodes = R * np.transpose(
        [
            np.sin(turns[:, 0]) * np.cos(turns[:, 1]),
            np.sin(turns[:, 1]),
            np.cos(turns[:, 0]) * np.cos(turns[:, 1]),
        ]
    )
    mesh = ao.Mesh(nodes, sheet.cells, "quad")
    body = ao.FEModel.from_mesh(mesh, ao.Shell(2e-3, STEEL))
    axis = np.array([0.3, -0.5, 0.8])
    motion = np.concatenate([np.cross(axis, nodes), np.tile(axis, (len(nodes), 1))])
    weights = place_rows(
        ao.FEModel.from_mesh(sheet, ao.Shell(2e-3, STEEL)), np.array([[*place, 0.0]])
    )
    at_place = motion_rows(body, weights, np.eye(3)) @ motion.ravel()
    assert at_place == pytest.approx(np.cross(axis, (weights @ nodes)[0]), rel=1e-4, abs=1e-6)


def test_a_sensor_between_the_nodes_of_a_cantilever() -> None:
    """One element: w = F x² (3L - x)/(6 EI) + F x/(κGA), as Timoshenko has it."""
    L, side, F, x = 0.3, 0.02, 10.0, 0.11
    mesh = ao.Mesh([[0, 0, 0], [L, 0, 0]], [[0, 1]], "line")
    section = ao.Beam(ao.RectangularSection(side, side), STEEL, (0, 0, 1))
    body = ao.FEModel.from_mesh(mesh, section, fixed=[([0], "xyz", "xyz")])
    sensor = pushed(body, (L, 0, 0), (0, 0, -1), F).target.probe((x, 0, 0), (0, 0, -1))
    shear = section.numbers.shear_factors[1] * STEEL.shear_modulus * side**2
    exact = F * x**2 * (3 * L - x) / (6 * STEEL.E * side**4 / 12) + F * x / shear
    assert np.abs(sensor.displacement).max() == pytest.approx(exact, rel=1e-3)


def test_plies_have_their_own_stress_along_their_fibres() -> None:
    """A cross-ply cantilever: M = Σ σ over z, and strain is straight through the thickness."""
    stack = [ao.Ply(0.5e-3, CARBON, angle) for angle in (0, 90, 90, 0)]
    body = strip(ao.Laminate(stack, fibre_axis=(1, 0, 0)))
    hit = pushed(body, (0.2, 0.01, 0), (0, 0, -1))
    field = hit.target.field([hit.peak_time])
    node = int(np.linalg.norm(body.nodes - [0.1, 0.01, 0], axis=1).argmin())
    moment = 0.0
    for ply in range(4):
        low, high = (
            field.stress(layer=(ply, side)).components[0, node] for side in ("bottom", "top")
        )
        along = (XX, YY)[ply in (1, 2)]  # of the ply's axes, along the strip
        z = 1e-3 * (0.5 * ply - 1.0)
        one, other = low[along], high[along]
        # ∫ σ z over a ply in which σ is straight.
        moment += 0.5e-3 * (z * (one + other) / 2 + 0.5e-3 * (one + 2 * other) / 6)
        if ply in (0, 3):
            assert abs(one) > 5 * abs(low[YY])
    assert 0.02 * moment == pytest.approx(hit.peak_force * 0.1, rel=0.02)
    with pytest.raises(ao.InputError, match=r"^layer"):
        field.stress(layer="left")
    with pytest.raises(ao.InputError, match=r"^layer"):
        field.stress(layer=(4, "top"))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*the mesh makes an error")
@pytest.mark.filterwarnings("ignore:stress may be off")  # by smaller models of the meshed body
def test_stress_at_a_point_as_the_quantity() -> None:
    """Its error by the mesh, beside that against elements of half the size."""
    place, times, hits = (0.03, 0.05, 0), np.linspace(0.0, 100e-6, 300), []
    for across in (20, 40):
        mesh, fixed = ao.sheet_mesh((0.1, 0.1), (across, across)), [("rim", "xyz", "xyz")]
        body = ao.FEModel.from_mesh(mesh, ao.Shell(2e-3, STEEL), fixed=fixed)
        hits.append(
            ao.simulate(
                ao.ball(0.005, STEEL),
                body.contact(point=(0.05, 0.05, 0)),
                0.2,
                duration=100e-6,
                quantity=ao.StressAt(body, place, "xx", layer="bottom"),
                rtol=0.05,
            )
        )
    stress, finer = (
        hit.target.probe(place, layer="bottom", times=times).stress["xx"] for hit in hits
    )
    true = np.abs(stress - finer).max() / np.abs(finer).max()
    assert true < hits[0].error.mesh < 5.0 * true
    top = hits[0].target.probe(place, layer="top", times=times)
    assert stress == pytest.approx(-top.stress["xx"], abs=1e-3 * top.stress["xx"].max())


def test_files_and_pictures(tmp_path: Any) -> None:
    import meshio

    mesh = ao.sheet_mesh((0.2, 0.02), (8, 2))
    spine = np.flatnonzero(abs(mesh.nodes[:, 1] - 0.01) < 1e-9)
    blocks: Any = [("quad", mesh.cells), ("line", np.column_stack([spine[:-1], spine[1:]]))]
    groups = {"skin": np.arange(16), "rib": 16 + np.arange(8)}
    panel = ao.Mesh(mesh.nodes, blocks, "mixed", mesh.node_sets, groups)
    rib = ao.Beam(ao.RectangularSection(2e-3, 5e-3), STEEL, (0, 0, 1), offset=(0, -3.5e-3))
    body = ao.FEModel.from_mesh(
        panel, {"skin": ao.Shell(1e-3, STEEL), "rib": rib}, fixed=[("xmin", "xyz", "xyz")]
    )
    hit = pushed(body, (0.2, 0.01, 0), (0, 0, -1), 1.0)
    field = hit.target.field([hit.peak_time])
    listing = field.to_vtu(tmp_path / "panel")
    read = meshio.read(tmp_path / "panel_0.vtu")
    assert listing.name == "panel.pvd"
    assert {block.type for block in read.cells} == {"quad", "line"}
    assert read.point_data["stress_bottom"].shape == (27, 6)
    assert read.point_data["rotation"] == pytest.approx(field.rotation[0])
    assert read.cell_data["thickness"][0] == pytest.approx(1e-3)
    of_rib = field.stress(part="rib").von_mises[0]
    largest = dict(
        zip([block.type for block in read.cells], read.cell_data["von_mises_of_beams"], strict=True)
    )
    assert largest["line"].max() == pytest.approx(np.nanmax(of_rib))
    assert not largest["quad"].any()
    with pytest.raises(ao.InputError, match=r"^at"):
        field.stress("gauss")
    with pytest.raises(ao.InputError, match=r"^layer"):
        field.stress(layer="upper")
