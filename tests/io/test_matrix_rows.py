"""Rows of matrices, places of nodes, and matrices written for other programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_matrices import BAR, DOWN, LABELS, NODES, K, M
from writers import market

import aoimpact as ao

WORDS = ("UX", "UY", "UZ")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    market(tmp_path / "K.mtx", K, None)
    market(tmp_path / "M.mtx", M, None)
    return tmp_path / "K.mtx", tmp_path / "M.mtx"


def mapping(order: Any) -> str:
    """A mapping file of Ansys' HBMAT, its equations in any order."""
    rows = [f"{i + 1:10d}{LABELS[i, 0]:10d}     {WORDS[LABELS[i, 1] - 1]}" for i in order]
    return "\n".join([" Matrix Eqn      Node     DOF", *rows, ""])


@pytest.mark.parametrize(
    "text",
    [
        mapping(range(len(LABELS))),
        mapping(np.random.default_rng(2).permutation(len(LABELS))),
        "".join(f"{node}.{c}\n" for node, c in LABELS),
        "".join(f"{node}, {c}\n" for node, c in LABELS),
    ],
)
def test_rows_are_known_from_a_file(text: str, files: tuple[Path, Path], tmp_path: Path) -> None:
    (tmp_path / "rows.txt").write_text(text)
    body = ao.read_matrices(*files, dofs=tmp_path / "rows.txt", nodes=NODES)
    np.testing.assert_array_equal(body.labels, LABELS)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (mapping(range(50)), "dofs"),
        (mapping([*range(40), *range(41, 72)]), "dofs"),
        ("1.1\n1.2\nx\n", r"line 3\b"),
        ("hello\n", r"rows\.txt"),
        ("1.1\n" * 72, "dofs"),
    ],
)
def test_a_spoilt_file_of_rows_is_refused(
    text: str, named: str, files: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "rows.txt").write_text(text)
    with pytest.raises(ao.InputError, match=named):
        ao.read_matrices(*files, dofs=tmp_path / "rows.txt")


def abaqus() -> str:
    lines = [f"{int(n)}, {x!r}, {y!r}, {z!r}" for n, x, y, z in NODES.tolist()]
    return "\n".join(["*HEADING", "*Node, nset=N", "** those:", *lines, "*ELEMENT, TYPE=C3D8", ""])


def small(value: float) -> str:
    return f"{value:8.4f}"


def grids() -> str:
    return "".join(
        f"GRID    {int(n):8d}{'':8}{small(x)}{small(y)}{small(z)}\n" for n, x, y, z in NODES
    )


def large_grids() -> str:
    return "".join(
        f"GRID*   {int(n):16d}{0:16d}{x:16.9E}{y:16.9E}\n*       {z:16.9E}\n"
        for n, x, y, z in NODES
    )


def free_grids() -> str:
    return "BEGIN BULK\n" + "".join(f"GRID,{int(n)},,{x},{y},{z}\n" for n, x, y, z in NODES)


@pytest.mark.parametrize(
    "text",
    [
        abaqus(),
        grids(),
        large_grids(),
        free_grids(),
        grids().replace("  0.1000", "    1.-1"),
        "".join(f"{int(n)} {x} {y} {z} 0. 0. 0.\n" for n, x, y, z in NODES[::-1]),
    ],
    ids=["abaqus", "grid", "grid*", "grid,", "1.-1", "table"],
)
def test_nodes_are_known_from_a_deck(text: str, files: tuple[Path, Path], tmp_path: Path) -> None:
    (tmp_path / "deck.inp").write_text(text)
    body = ao.read_matrices(*files, dofs=LABELS, nodes=tmp_path / "deck.inp")
    assert body.nodes is not None
    np.testing.assert_allclose(body.nodes, BAR.nodes, atol=1e-12)
    assert body.contact(node=159, direction=DOWN).node == 29


def test_nodes_in_coordinate_systems(files: tuple[Path, Path], tmp_path: Path) -> None:
    """Coordinates are brought into basic axes; K in other axes than these is refused."""
    moved = NODES - [0.0, 0.5, 0.0, 0.0]
    shifted = "CORD2R,7,,0.5,0.,0.,0.5,0.,1.\n,1.5,0.,0.\n"
    turned = "CORD2C,8,,0.5,0.,0.,0.5,0.,1.\n,1.5,0.,0.\n"
    deck = tmp_path / "deck.bdf"

    def grids(system: int) -> str:
        return "".join(f"GRID,{int(n)},7,{x},{y},{z},{system}\n" for n, x, y, z in moved)

    deck.write_text(shifted + grids(7))
    body = ao.read_matrices(*files, dofs=LABELS, nodes=deck)
    assert body.nodes is not None
    np.testing.assert_allclose(body.nodes, BAR.nodes, atol=1e-12)
    deck.write_text(shifted + turned + grids(8))
    with pytest.raises(ao.InputError, match="nodes"):
        ao.read_matrices(*files, dofs=LABELS, nodes=deck)


def test_nodes_in_the_order_of_their_labels(files: tuple[Path, Path]) -> None:
    used = np.isin(NODES[:, 0], LABELS[:, 0])
    body = ao.read_matrices(*files, dofs=LABELS, nodes=NODES[used, 1:])
    assert body.nodes is not None
    np.testing.assert_array_equal(body.nodes, NODES[used, 1:])
    with pytest.raises(ao.InputError, match="nodes"):
        ao.read_matrices(*files, dofs=LABELS, nodes=NODES[:, 1:])


# ---------------------------------------------------------------------------- writing


def test_what_is_written_is_read_as_it_was(tmp_path: Path) -> None:
    tip = BAR.contact(point=(0.08, 0.013, 0.01), radius=0.0)
    files = ao.write_matrices(tip, tmp_path / "new")
    body = ao.read_matrices(files["K"], files["M"], dofs=files["dofs"], nodes=files["nodes"])
    for name in ("K", "M"):
        assert abs(getattr(body, name) - getattr(BAR, name)).max() == 0.0
    np.testing.assert_array_equal(body.nodes, BAR.nodes)
    np.testing.assert_array_equal(body.free, BAR.free)
    import scipy.io

    np.testing.assert_array_equal(scipy.io.mmread(files["b"]).ravel(), tip.b)
    again = ao.write_matrices(body, tmp_path / "again")
    assert again["dofs"].read_bytes() == files["dofs"].read_bytes()


def test_a_star_is_written_with_all_its_digits(tmp_path: Path) -> None:
    tip = BAR.contact(point=(0.08, 0.013, 0.01), radius=0.0)
    star = ao.antioscillators(tip, n=6)
    files = ao.write_matrices(star, tmp_path)
    said = json.loads(files["json"].read_text())
    same = ao.AOModel(**said)
    for name in ("m0", "k0", "m", "k"):
        np.testing.assert_array_equal(getattr(same, name), getattr(star, name))
    K, M, b = star.matrices()
    body = ao.FEModel(K=K, M=M)
    np.testing.assert_allclose(body.frequencies(7), star.natural_frequencies, rtol=1e-9)
    found = ao.antioscillators(body.contact(b=b), n=6)
    assert found.k0 == pytest.approx(star.k0, rel=1e-9)
    assert found.m0 == pytest.approx(star.m0, rel=1e-6)


@pytest.mark.parametrize("what", [None, 3, np.eye(3)])
def test_what_has_no_matrices_is_not_written(what: Any, tmp_path: Path) -> None:
    with pytest.raises(ao.InputTypeError, match="what"):
        ao.write_matrices(what, tmp_path)
