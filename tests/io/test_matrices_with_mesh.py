"""Matrices on the mesh that they are of: patches, laws and stresses as of the meshed body."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

# Matrices without a mesh have the indentation of the half-space twice, which is no matter here.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh")

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800.0)
MESH = ao.sphere_mesh(0.01, 0.008)
BALL = ao.FEModel.from_mesh(MESH, STEEL)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    files = ao.write_matrices(BALL, tmp_path_factory.mktemp("ball"))
    return {name: files[name] for name in ("K", "M", "dofs", "nodes")}


@pytest.mark.slow
def test_a_patch_and_the_law_are_those_of_the_mesh(files: dict[str, Any]) -> None:
    body = ao.read_matrices(**files, mesh=MESH, material=STEEL)
    wall = ao.rigid(np.inf)
    hits = [
        ao.simulate(projectile=one.contact(point=(0, 0, -0.01)), target=wall, law=law, velocity=1.0)
        for one in (body, BALL)
        for law in (ao.Hertz.between(STEEL, 0.01, STEEL, np.inf),)
    ]
    runs = [hit.beside for hit in hits]
    assert runs[0].peak_force == pytest.approx(runs[1].peak_force, rel=1e-9)
    # Finer models end with their solutions by iteration, which hang on rounding.
    assert hits[0].peak_force == pytest.approx(hits[1].peak_force, rel=1e-6)
    assert hits[0].error.contact == pytest.approx(hits[1].error.contact, abs=1e-6)
    assert body.mass == pytest.approx(BALL.mass)


def test_nodes_in_another_order_are_found_by_their_places(files: dict[str, Any]) -> None:
    order = np.random.default_rng(4).permutation(MESH.n_nodes)
    table = np.column_stack([order + 1, 1e3 * MESH.nodes[order]])
    given = files | {"nodes": table}
    body = ao.read_matrices(**given, mesh=MESH, material=STEEL, length=1e-3)
    np.testing.assert_array_equal(body.free, BALL.free)
    np.testing.assert_array_equal(body.nodes, MESH.nodes)


def test_another_mesh_is_refused(files: dict[str, Any]) -> None:
    other = ao.box_mesh((0.01, 0.01, 0.01), (2, 2, 2))
    with pytest.raises(ao.InputError, match="mesh"):
        ao.read_matrices(**files, mesh=other, material=STEEL)
    with pytest.raises(ao.InputTypeError, match=r"^mesh"):
        ao.read_matrices(**files, material=STEEL)


@pytest.mark.slow
def test_matrices_of_a_shell_have_its_contact_stress_and_errors(tmp_path: Path) -> None:
    """Rotations about the normal have no mass; the rim is simply supported."""
    mesh, layers = ao.sheet_mesh((0.1, 0.1), (20, 20), kind="triangle"), ao.Shell(2e-3, STEEL)
    plate = ao.FEModel.from_mesh(mesh, layers, fixed=[("rim", "xyz")])
    made = ao.write_matrices(plate, tmp_path)
    given = {"dofs": made["dofs"], "nodes": made["nodes"]}
    known = ao.read_matrices(made["K"], made["M"], **given)
    assert repr(known) == repr(plate).replace("800 triangle, ", "").replace(", 0.156 kg", "")
    read = ao.read_matrices(made["K"], made["M"], mesh=mesh, material=layers, **given)
    ball, tips = ao.ball(0.005, STEEL), [of.contact(point=(0.05, 0.05, 0)) for of in (read, plate)]
    one, other = (
        ao.simulate(ball, tip, 1.0, duration=100e-6, quantity="peak_force") for tip in tips
    )
    assert one.peak_force == pytest.approx(other.beside.peak_force, rel=1e-9)
    assert one.error["peak_force"].mesh is None  # matrices are of no finer elements
    assert one.error["peak_force"].model == pytest.approx(other.error["peak_force"].model, rel=0.1)
    stress = []
    for tip in tips:  # under a load: the law of a contact takes up more where the mass is not known
        scene = ao.Scene()
        struck = scene.add(ao.modal(tip, 120))
        scene.apply(struck, force=([0.0, 5e-5, 1e-4], [0.0, 200.0, 0.0]))
        found = scene.simulate(duration=1e-4)[struck]
        stress.append(found.probe((0.05, 0.03, 0), layer="bottom", times=[5e-5]).stress["xx"][0])
    assert stress[0] == pytest.approx(stress[1], rel=1e-6)
