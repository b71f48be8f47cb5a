"""Bodies that are written as decks in many ways, and their comparison with the meshes read."""

from __future__ import annotations

import random
import warnings
from dataclasses import dataclass
from pathlib import Path
from runpy import run_path

import numpy as np
import numpy.typing as npt

import aoimpact as ao
from aoimpact.mesh import KINDS

IntArray = npt.NDArray[np.int64]

_TESTS = Path(__file__).parents[2] / "tests"
_ROUNDING = 1e-12
_MATERIAL = ao.Material(E=1e9, nu=0.3, rho=1e3)


@dataclass(frozen=True)
class Body:
    """A mesh with labels, and groups of the labels.

    Attributes
    ----------
    mesh : Mesh
    parts : tuple of tuple of int
        Labels of elements, each of them in one part.
    node_sets, element_sets : tuple of tuple of int
        Labels, any.
    """

    mesh: ao.Mesh
    parts: tuple[tuple[int, ...], ...]
    node_sets: tuple[tuple[int, ...], ...]
    element_sets: tuple[tuple[int, ...], ...]


def draw(rng: random.Random) -> Body:
    """Return a distorted box of a few elements, of one kind or of four, with labels at random.

    Coordinates have three decimals, so any way to write them gives the same number.
    """
    lengths, counts = (2.0, 1.5, 1.0), (rng.randint(1, 3), rng.randint(1, 2), rng.randint(1, 2))
    kind = rng.choice([*(kind for kind in KINDS if kind != "hexahedron27"), "mixed", "mixed"])
    if kind == "mixed":
        mixed_box = run_path(str(_TESTS / "bodies.py"))["mixed_box"]
        mesh = mixed_box(lengths, (counts[0], counts[1], 3), order=rng.choice((1, 2)))
    else:
        mesh = ao.box_mesh(lengths, counts, kind=kind)
    pushed = [rng.uniform(-0.01, 0.01) for _ in range(mesh.nodes.size)]
    nodes = np.round(mesh.nodes + np.reshape(pushed, mesh.nodes.shape), 3)
    most = rng.choice((200, 10_000, 99_999_999))
    node_labels = rng.sample(range(1, most + 10 * mesh.n_nodes), mesh.n_nodes)
    cell_labels = rng.sample(range(1, most + 10 * mesh.n_cells), mesh.n_cells)
    if rng.random() < 0.5:
        node_labels.sort()
        cell_labels.sort()
    if max(node_labels + cell_labels) > 99_999_999:  # eight digits are all that a field has
        node_labels, cell_labels = [list(range(1, 1 + len(x))) for x in (node_labels, cell_labels)]
    blocks = [(block.kind, block.cells) for block in mesh.blocks]
    labelled = ao.Mesh(
        nodes,
        blocks,
        "mixed",
        node_labels=np.array(node_labels),
        cell_labels=np.array(cell_labels),
    )
    parts: dict[int, list[int]] = {}
    for label in cell_labels:
        parts.setdefault(rng.randrange(3), []).append(label)
    return Body(
        labelled,
        tuple(tuple(part) for part in parts.values()),
        tuple(_some(rng, node_labels) for _ in range(rng.randrange(3))),
        tuple(_some(rng, cell_labels) for _ in range(rng.randrange(3))),
    )


def _some(rng: random.Random, labels: list[int]) -> tuple[int, ...]:
    return tuple(rng.sample(labels, rng.randint(1, len(labels))))


def read(file: Path, part: str | None, called_for: tuple[str, ...]) -> ao.Mesh | str:
    """Return the mesh in a deck, or a text if it is refused or warned of for no reason.

    `called_for` has words of the warnings that the deck calls for.
    """
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            mesh = ao.read_mesh(file, part=part)
        except ao.AOImpactError as error:
            return f"refused: {error}"
    for one in said:
        if not any(words in str(one.message) for words in called_for):
            return f"warned: {one.message}"
    return mesh


def differences(
    body: Body,
    read: ao.Mesh,
    node_sets: dict[str, set[int]],
    cell_sets: dict[str, set[int]],
    *,
    tolerance: float,
) -> str:
    """Return how a mesh differs from the body, and its groups of labels from those wanted."""
    wanted = body.mesh
    found = []
    assert wanted.node_labels is not None
    assert read.node_labels is not None
    if set(wanted.node_labels) != set(read.node_labels):
        return "labels of nodes"
    order = _places(read.node_labels, wanted.node_labels)
    if np.abs(read.nodes[order] - wanted.nodes).max() > tolerance:
        found.append(f"nodes are off by {np.abs(read.nodes[order] - wanted.nodes).max():.2g}")
    if _elements(wanted) != _elements(read):
        return "elements"
    for what, sets, labels, names in (
        ("nodes", read.node_sets, read.node_labels, node_sets),
        ("elements", read.cell_sets, read.cell_labels, cell_sets),
    ):
        assert labels is not None
        groups = {name: set(labels[ids].tolist()) for name, ids in sets.items()}
        if groups != names:
            found.append(f"groups of {what}: {groups} instead of {names}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)  # of a size that no body has
        models = [ao.FEModel.from_mesh(mesh, _MATERIAL) for mesh in (wanted, read)]
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    for name in ("K", "M"):
        ours, theirs = (getattr(model, name) for model in models)
        theirs = theirs[rows][:, rows]
        if abs(ours - theirs).max() > (1e3 * tolerance + _ROUNDING) * abs(ours).max():
            found.append(name)
    masses = [model.M.sum() for model in models]
    if abs(masses[1] - masses[0]) > (1e3 * tolerance + _ROUNDING) * masses[0]:
        found.append("mass")
    return "; ".join(found)


def _places(labels: IntArray, wanted: IntArray) -> IntArray:
    """Return where each of `wanted` is in `labels`."""
    order = np.argsort(labels)
    places: IntArray = order[np.searchsorted(labels, wanted, sorter=order)]
    return places


def _elements(mesh: ao.Mesh) -> dict[int, tuple[str, list[int]]]:
    """Return kind and labels of the nodes of each element, by its label."""
    assert mesh.node_labels is not None
    assert mesh.cell_labels is not None
    return {
        int(label): (block.kind, mesh.node_labels[cell].tolist())
        for block in mesh.blocks
        for label, cell in zip(mesh.cell_labels[block.numbers], block.cells, strict=True)
    }
