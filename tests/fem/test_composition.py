"""Bodies of several materials: bars against closed forms, stress at interfaces, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.optimize
from bodies import mixed_box, no_solid
from pickled import elsewhere

import aoimpact as ao
from aoimpact import InputError, read_mesh
from aoimpact.fem import Materials, body_stress_rows, gauss_stress, nodal_stress
from aoimpact.laws import own_law

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
LENGTH, SHARE = 1.0, 0.4


def halves(kind: str = "hexahedron20", n: int = 20) -> ao.Mesh:
    """A bar along x whose first 40 % are "left", the others "right"."""
    bar = ao.box_mesh((LENGTH, 0.01, 0.01), (n, 1, 1), kind=kind)
    left = bar.nodes[bar.cells].mean(axis=1)[:, 0] < SHARE * LENGTH
    groups = {"left": np.flatnonzero(left), "right": np.flatnonzero(~left)}
    return ao.Mesh(bar.nodes, bar.cells, bar.kind, bar.node_sets, groups)


def axial(mesh: ao.Mesh, material: Any, **more: Any) -> ao.FEModel:
    """A bar that moves along x alone, held at its left end unless it is told otherwise."""
    everywhere = (np.arange(mesh.n_nodes), "yz")
    ends = more.pop("fixed", [("xmin", "x")])
    return ao.FEModel.from_mesh(mesh, material, [everywhere, *ends], **more)


def test_frequencies_of_a_bar_of_two_materials() -> None:
    """E₁κ₁ cot κ₁L₁ = E₂κ₂ tan κ₂L₂ with κ = ω √(ρ/E): stress and displacement agree between."""
    one, other = no_solid(E=210e9, nu=0.0, rho=7800.0), no_solid(E=70e9, nu=0.0, rho=2700.0)
    found = axial(halves(), {"left": one, "right": other}).frequencies(2)
    lengths = SHARE * LENGTH, (1.0 - SHARE) * LENGTH

    def misfit(omega: float) -> float:
        (k1, z1), (k2, z2) = (
            (omega * math.sqrt(m.rho / m.E), math.sqrt(m.rho * m.E)) for m in (one, other)
        )
        a, b = k1 * lengths[0], k2 * lengths[1]
        return z1 * math.cos(a) * math.cos(b) - z2 * math.sin(a) * math.sin(b)

    grid = np.linspace(1.0, 3e4, 400)
    values = [misfit(x) for x in grid]
    exact = [
        scipy.optimize.brentq(misfit, grid[i], grid[i + 1]) / (2.0 * math.pi)
        for i in range(len(grid) - 1)
        if values[i] * values[i + 1] < 0.0
    ]
    assert found == pytest.approx(exact[:2], rel=2e-6)


LAYERS = ao.box_mesh((0.2, 0.1, 0.02), (4, 2, 2), kind="hexahedron20")
SPLIT = ao.Mesh(
    LAYERS.nodes,
    LAYERS.cells,
    LAYERS.kind,
    LAYERS.node_sets,
    {
        "lower": np.flatnonzero(LAYERS.nodes[LAYERS.cells].mean(axis=1)[:, 2] < 0.01),
        "upper": np.flatnonzero(LAYERS.nodes[LAYERS.cells].mean(axis=1)[:, 2] > 0.01),
    },
)


def stretched() -> tuple[ao.FEModel, np.ndarray]:
    """Two layers, ν = 0, stretched by the same strain: stress jumps from one to the other."""
    materials = {"lower": no_solid(70e9, 2700.0, 0.0), "upper": no_solid(210e9, 7800.0, 0.0)}
    body = ao.FEModel.from_mesh(SPLIT, materials)
    moved = np.zeros((SPLIT.n_nodes, 3))
    moved[:, 0] = 1e-3 * SPLIT.nodes[:, 0]
    return body, moved


def test_stress_jumps_between_materials_and_is_not_averaged() -> None:
    body, moved = stretched()
    assert body.material is not None
    assert body.mesh is not None
    at_nodes = nodal_stress(body.mesh, body.material, moved)["xx"]
    stiff = body.mesh.nodes[:, 2] > 0.0099  # the interface shows the stiffer side
    assert at_nodes == pytest.approx(np.where(stiff, 210e6, 70e6), rel=1e-10)
    inside = gauss_stress(body.mesh, body.material, moved)
    assert inside["xx"] == pytest.approx(
        np.where(inside.points[..., 2] > 0.01, 210e6, 70e6), rel=1e-10
    )
    some = [0, 5, int(np.argmin(np.abs(body.mesh.nodes[:, 2] - 0.01)))]
    places = scipy.sparse.csr_array(np.eye(body.mesh.n_nodes)[some])
    rows = body_stress_rows(body.mesh, body.material, places).rows @ moved.reshape(-1)
    assert rows.reshape(-1, 6)[:, 0] == pytest.approx(at_nodes[some], rel=1e-10)


def test_the_contact_meets_the_material_of_its_own_element() -> None:
    mesh = mixed_box((0.1, 0.1, 0.1), (8, 8, 3))
    of = {"low": STEEL, "wedges": STEEL, "middle": ALU, "high": ALU}
    body = ao.FEModel.from_mesh(mesh, of)
    top, bottom = (body.contact(point=(0.05, 0.05, z), radius=0.04) for z in (0.1, 0.0))
    assert top.material == ALU
    assert bottom.material == STEEL
    assert top.patch is not None
    assert top.extraction is not None
    assert top.extraction.splitting.space.stiffness[2, 2, 2, 2] == ALU.stiffness[2, 2]
    assert top.contact_surface is not None
    assert top.contact_surface.material == ALU
    model = ao.antioscillators(top, 3, method="krylov", contact_time=1e-4)
    hit = ao.simulate(ao.ball(0.01, STEEL), model, 1.0, duration=1e-4)
    assert own_law(hit.law) == ao.Hertz.between(STEEL, 0.01, ALU, math.inf)


def test_a_body_of_several_materials_can_be_pickled() -> None:
    body = ao.FEModel.from_mesh(
        SPLIT,
        {"lower": ALU, "upper": STEEL},
        fixed=[("ymin", "y")],
        masses=[("xmax", 1.0)],
        springs=[("xmin", "xz", 1e6)],
    )
    again = elsewhere(body)
    assert (again.K != body.K).nnz == 0
    assert (again.M != body.M).nnz == 0
    assert isinstance(again.material, Materials)
    assert again.material.groups == {"lower": ALU, "upper": STEEL}
    assert not again.mesh.cell_sets["lower"].flags.writeable
    assert repr(again) == repr(body)
    assert again.frequencies(3) == pytest.approx(body.frequencies(3), rel=1e-9)


def test_matrices_of_another_program_stay_when_a_body_with_their_mesh_is_pickled() -> None:
    made = ao.FEModel.from_mesh(SPLIT, ALU)
    given = ao.FEModel(K=2.0 * made.K, M=3.0 * made.M, nodes=SPLIT.nodes)
    again = elsewhere(given.with_mesh(SPLIT, {"lower": ALU, "upper": STEEL}))
    assert (again.K != given.K).nnz == 0
    assert (again.M != given.M).nnz == 0


def test_parts_of_a_file_are_bodies_of_their_own() -> None:
    whole = ao.FEModel.from_mesh(SPLIT, ALU, part="upper")
    assert whole.mass == pytest.approx(2700 * 0.2 * 0.1 * 0.01)
    assert whole.mesh is not None
    assert set(whole.mesh.node_sets) == {"xmin", "xmax", "ymin", "ymax", "zmax"}
    assert set(whole.mesh.cell_sets) == {"upper"}
    assert read_mesh(SPLIT, part=["lower", "upper"]).n_cells == 16
    with pytest.raises(InputError, match=r"^part"):
        read_mesh(SPLIT, part="uppr")
