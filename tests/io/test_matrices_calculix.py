"""CalculiX itself: its matrices are ours, and a star is a deck of its springs and masses."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from decks import ccx, frequencies
from test_matrices import ALU, DOWN, force

import aoimpact as ao

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")

MESH = ao.box_mesh((0.1, 0.02, 0.01), (6, 2, 1))
TYPES = {"hexahedron": "C3D8", "hexahedron20": "C3D20"}
STORED = "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n*END STEP\n"


def deck(mesh: ao.Mesh, fixed: Any, element: str = "", step: str = STORED) -> Iterator[str]:
    """A deck of this project's own: nodes called 101, 103, …, and their matrices stored."""
    yield "*NODE, NSET=NALL"
    for i, (x, y, z) in enumerate(mesh.nodes):
        yield f"{101 + 2 * i}, {x:.12e}, {y:.12e}, {z:.12e}"
    yield f"*ELEMENT, TYPE={element or TYPES[mesh.kind]}, ELSET=EALL"
    for i, cell in enumerate(mesh.cells):
        words = list(map(str, [i + 1, *(101 + 2 * cell)]))
        yield ",\n".join(", ".join(words[start : start + 11]) for start in range(0, len(words), 11))
    if len(fixed):
        yield "*BOUNDARY"
        for node in fixed:
            yield f"{101 + 2 * node}, 1, 3"
    yield "*MATERIAL, NAME=ALU\n*ELASTIC\n70e9, 0.3\n*DENSITY\n2700."
    yield "*SOLID SECTION, ELSET=EALL, MATERIAL=ALU"
    yield step


def run(folder: Path, lines: Iterator[str]) -> Path:
    return ccx(folder / "bar.inp", lines)


@pytest.mark.filterwarnings("ignore:.*with_mesh")
@pytest.mark.parametrize("held", [True, False])
def test_calculix_s_matrices_are_ours(held: bool, tmp_path: Path) -> None:
    fixed = np.flatnonzero(MESH.nodes[:, 0] == 0.0) if held else np.zeros(0, int)
    file = run(tmp_path, deck(MESH, fixed))
    body = ao.read_matrices(file.with_suffix(".sti"), file.with_suffix(".mas"), nodes=file)
    ours = ao.FEModel.from_mesh(MESH, ALU, fixed=[(fixed, "xyz")] if held else None)
    assert body.free is not None
    assert ours.free is not None
    rows = np.argsort(body.free)
    assert (body.free[rows] == ours.free).all()
    for name in ("K", "M"):
        read, true = getattr(body, name), getattr(ours, name)
        off = np.abs(read[rows][:, rows] - true).max()
        assert off < 1e-12 * np.abs(true.data).max(), name
    assert body.labels is not None
    assert (body.labels[:, 0] == 101 + 2 * (body.free // 3)).all()
    if held:
        tip = len(MESH.nodes) - 1
        off = force(body, node=101 + 2 * tip) - force(ours, node=tip)
        assert np.abs(off).max() < 1e-7 * force(ours, node=tip).max()
    else:
        assert body.mass == pytest.approx(ours.mass, rel=1e-12)
        assert body.rigid_modes.shape[1] == 6
        assert body.contact(node=101, direction=DOWN).node == 0


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize(
    ("element", "kind"),
    [
        ("C3D4", "tetra"),
        ("C3D6", "wedge"),
        ("C3D8R", "hexahedron"),
        ("C3D10", "tetra10"),
        ("C3D15", "wedge15"),
        ("C3D20R", "hexahedron20"),
    ],
)
def test_elements_that_integrate_their_mass_in_part_have_calculix_s_frequencies(
    element: str, kind: str, held: bool, tmp_path: Path
) -> None:
    """Free, M of each is singular; CalculiX' own eigensolver is the second method."""
    mesh = ao.box_mesh((0.1, 0.02, 0.01), (5, 2, 1), kind=kind)
    fixed = np.flatnonzero(mesh.nodes[:, 0] == 0.0) if held else np.zeros(0, int)
    file = run(tmp_path, deck(mesh, fixed, element))
    body = ao.read_matrices(file.with_suffix(".sti"), file.with_suffix(".mas"), nodes=file)
    run(tmp_path, deck(mesh, fixed, element, "*STEP\n*FREQUENCY\n9\n*END STEP\n"))
    theirs = frequencies(file)[:9]
    rigid = 0 if held else 6
    assert body.rigid_modes.shape[1] == rigid
    assert body.frequencies(9)[rigid:] == pytest.approx(theirs[rigid:], rel=1e-5)


def test_inner_nodes_of_incompatible_modes_are_called_so(tmp_path: Path) -> None:
    file = run(tmp_path, deck(MESH, np.zeros(0, int), "C3D8I"))
    files = file.with_suffix(".sti"), file.with_suffix(".mas")
    with pytest.raises(ao.InputError, match="nodes"):
        ao.read_matrices(*files, nodes=file)
    body = ao.read_matrices(*files)
    assert (body.frequencies(7)[:6] < 1.0).all()
    assert body.frequencies(7)[6] > 1000.0


def test_a_deck_of_quadratic_elements_gives_patch_and_force_of_the_mesh(tmp_path: Path) -> None:
    mesh = ao.box_mesh((0.1, 0.04, 0.02), (5, 2, 1), kind="hexahedron20")
    fixed = np.flatnonzero(mesh.nodes[:, 0] == 0.0)
    file = run(tmp_path, deck(mesh, fixed))
    files = file.with_suffix(".sti"), file.with_suffix(".mas")
    theirs = ao.read_matrices(*files, mesh=file, material=ALU)
    ours = ao.FEModel.from_mesh(mesh, ALU, fixed=[(fixed, "xyz")])
    np.testing.assert_allclose(theirs.frequencies(6), ours.frequencies(6), rtol=1e-8)
    ball = ao.ball(radius=0.01, material=ALU)
    hits = [
        ao.simulate(projectile=ball, target=body.contact(point=(0.08, 0.02, 0.02)), velocity=1.0)
        for body in (theirs, ours)
    ]
    assert hits[0].peak_force == pytest.approx(hits[1].peak_force, rel=1e-6)


def test_a_star_is_a_deck_of_springs_and_masses(tmp_path: Path) -> None:
    """CalculiX assembles the star's own matrices and natural frequencies from it."""
    star = ao.AOModel(m0=0.1, k0=1e6, m=[0.5, 0.2, 0.05], k=[2e6, 3e6, 9e6])
    files = ao.write_matrices(star, tmp_path)
    run(tmp_path, iter([files["deck"].read_text() + STORED]))
    body = ao.read_matrices(tmp_path / "bar.sti", tmp_path / "bar.mas")
    assert body.labels is not None
    rows = np.argsort(body.labels[:, 0])
    K, M, _ = star.matrices()
    np.testing.assert_allclose(body.K.toarray()[rows][:, rows], K, rtol=1e-12)
    np.testing.assert_allclose(body.M.toarray()[rows][:, rows], M, rtol=1e-12)
    np.testing.assert_allclose(body.frequencies(4), star.natural_frequencies, rtol=1e-9)
