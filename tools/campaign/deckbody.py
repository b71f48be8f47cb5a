"""Random bodies to be written as decks, and their comparison with the meshes read."""

from __future__ import annotations

import random
import shutil
import warnings
from argparse import Namespace
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from runpy import run_path

import numpy as np
from scipy.spatial.transform import Rotation

import aoimpact as ao
from aoimpact.mesh import KINDS

from .outcome import FloatArray, Trial, Verdict

Groups = dict[str, set[int]]

_TESTS = Path(__file__).parents[2] / "tests"


@dataclass(frozen=True)
class Body:
    """A mesh with labels, and groups of the labels.

    Attributes
    ----------
    mesh : Mesh
    nodes, cells : list of int
        Labels of nodes and elements, in the mesh's order.
    parts : list of list of int
        Labels of the elements of each part; each element is in one part.
    node_sets, element_sets : list of list of int
        Labels of random sets.
    """

    mesh: ao.Mesh
    nodes: list[int]
    cells: list[int]
    parts: list[list[int]]
    node_sets: list[list[int]]
    element_sets: list[list[int]]

    @cached_property
    def members(self) -> Groups:
        """Labels of the nodes of each element, by its label."""
        return {label: set(nodes) for label, (_, nodes) in _elements(self.mesh).items()}

    def nodes_of(self, elements: Iterable[int]) -> set[int]:
        """Return the labels of the nodes of elements."""
        return set().union(*(self.members[label] for label in elements))


def draw(rng: random.Random) -> Body:
    """Return a distorted box of a few elements, of one kind or of four, with labels at random.

    Coordinates have three decimals, so that all ways to write them give the same number.
    """
    lengths, counts = (2.0, 1.5, 1.0), (rng.randint(1, 3), rng.randint(1, 2), rng.randint(1, 2))
    kind = rng.choice([*(kind for kind in KINDS if kind != "hexahedron27"), "mixed", "mixed"])
    if kind == "mixed":
        mixed_box = run_path(str(_TESTS / "bodies.py"))["mixed_box"]
        mesh = mixed_box(lengths, (counts[0], counts[1], 3), order=rng.choice((1, 2)))
    else:
        mesh = ao.box_mesh(lengths, counts, kind=kind)
    pushed = [rng.uniform(-0.01, 0.01) for _ in range(mesh.nodes.size)]
    places = np.round(mesh.nodes + np.reshape(pushed, mesh.nodes.shape), 3)
    most = rng.choice((200, 10_000, 99_990_000))  # a field holds eight digits
    nodes = rng.sample(range(1, most + 10 * mesh.n_nodes), mesh.n_nodes)
    cells = rng.sample(range(1, most + 10 * mesh.n_cells), mesh.n_cells)
    if rng.random() < 0.5:
        nodes.sort()
        cells.sort()
    labelled = ao.Mesh(
        places,
        [(block.kind, block.cells) for block in mesh.blocks],
        "mixed",
        node_labels=np.array(nodes),
        cell_labels=np.array(cells),
    )
    parts = {}
    for label in cells:
        parts.setdefault(rng.randrange(3), []).append(label)
    sets = [
        [rng.sample(labels, rng.randint(1, len(labels))) for _ in range(rng.randrange(3))]
        for labels in (nodes, cells)
    ]
    return Body(labelled, nodes, cells, list(parts.values()), *sets)


# ------------------------------------------------------------------ what both formats write


@dataclass(frozen=True)
class System:
    """Coordinate system: kind ("R", "C" or "S": Cartesian, cylindrical, spherical), origin, axes.

    The axes are rows.
    """

    kind: str = "R"
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    axes: FloatArray = field(default_factory=lambda: np.eye(3))

    @classmethod
    def drawn(cls, rng: random.Random, kind: str) -> System:
        origin = np.array([rng.uniform(-3, 3) for _ in range(3)])
        turn = Rotation.from_rotvec([rng.uniform(-3, 3) for _ in range(3)])
        return cls(kind, origin, turn.as_matrix())

    def local(self, places: FloatArray) -> FloatArray:
        """Return the coordinates of places, angles in degrees; in "S" the polar angle is second."""
        x, y, z = self.axes @ (places - self.origin).T
        across, turn = np.hypot(x, y), np.degrees(np.arctan2(y, x))
        if self.kind == "S":
            return np.stack([np.hypot(across, z), np.degrees(np.arctan2(across, z)), turn], 1)
        return np.stack([across, turn, z] if self.kind == "C" else [x, y, z], 1)


class Drawn:
    """Base of a random deck, and the groups, as labels, that a reader should find in it."""

    def __init__(self, rng: random.Random) -> None:
        self.rng, self.pick = rng, rng.choice
        self.node_sets, self.cell_sets = Groups(), Groups()

    def chance(self, share: float) -> bool:
        return self.rng.random() < share


def shared_out(rng: random.Random, numbers: Iterable[int]) -> list[list[int]]:
    """Return numbers shuffled and divided into one to three parts."""
    shuffled = list(numbers)
    rng.shuffle(shuffled)
    cuts = sorted(rng.randint(0, len(shuffled)) for _ in range(rng.randint(0, 2)))
    return [shuffled[a:b] for a, b in pairwise([0, *cuts, len(shuffled)]) if a < b]


def runs(wanted: Iterable[int], every: Iterable[int]) -> list[list[int]]:
    """Return the wanted labels in ascending runs: no other label of `every` lies within a run."""
    members, found = set(wanted), list[list[int]]([[]])
    for label in sorted(every):
        found += [[]] * (label not in members)
        if label in members:
            found[-1] = [*found[-1], label]
    return [run for run in found if run]


@dataclass(frozen=True)
class Dialect:
    """Syntax of a format: its comment lines, and the function that returns an include statement.

    `nested`: whether an included file's path is relative to the file that includes it.
    """

    comments: tuple[str, ...]
    include: Callable[[random.Random, str], str]
    nested: bool = False

    def stored(
        self, rng: random.Random, folder: Path, name: str, lines: list[str], depth: int = 0
    ) -> Path:
        """Write lines with comments between them, and some of them to included files."""
        names = ["part", "a part", *["sub/part"] * (depth == 0 or not self.nested)]
        while depth < 3 and len(lines) > 3 and rng.random() < 0.3:
            first, last = sorted(rng.sample(range(len(lines)), 2))
            other = f"{rng.choice(names)}{rng.randrange(10**6)}.inc"
            inner = (folder / other).parent if self.nested else folder
            inner.mkdir(exist_ok=True)
            file = other if inner == folder else Path(other).name
            self.stored(rng, inner, file, lines[first:last], depth + 1)
            lines = [*lines[:first], self.include(rng, other), *lines[last:]]
            names = names[:2] if self.nested else names  # nested files stay in their folder
        text = list[str]()
        for line in lines:
            text += [rng.choice(self.comments)] * (rng.random() < 0.04) + [line]
        end = rng.choice(("\n", "\n", "\r\n"))
        whole = "\n".join(text).replace("\n", end) + rng.choice(("", end))
        encoding = rng.choice(("utf-8", "utf-8", "latin-1", "utf-8-sig", "utf-16"))
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(whole.encode(encoding))
        return file


# ---------------------------------------------------------------------------- the comparison


@dataclass(frozen=True)
class Expected:
    """Expected result of reading a part or the whole: places of nodes, and groups of labels."""

    places: FloatArray
    node_sets: Groups
    cell_sets: Groups
    tolerance: float
    part: str | None = None


def trials(
    name: str,
    written: Callable[[random.Random, Body, Path], tuple[Path, list[Expected]]],
    called_for: tuple[str, ...],
) -> Callable[[Namespace, Path], Trial]:
    """Return the `trial` of a format, whose decks are written into an empty folder.

    `called_for`: words of the warnings that decks may cause.
    """

    def trial(options: Namespace, folder: Path) -> Trial:
        def one(number: int) -> Verdict:
            place = folder / "deck"
            shutil.rmtree(place, ignore_errors=True)
            place.mkdir()
            rng = random.Random(f"{options.seed} {name} {number}")
            body = draw(rng)
            file, expected = written(rng, body, place)
            wrong = "; ".join(filter(None, (_wrong(body, file, of, called_for) for of in expected)))
            wrong = wrong.replace(f"{place}/", "")
            return Verdict(wrong[:60] or "ok", wrong)

        return one

    return trial


def _wrong(body: Body, file: Path, expected: Expected, called_for: tuple[str, ...]) -> str:
    """Return how the mesh read differs from the expected one, or why it was not read."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            read = ao.read_mesh(file, part=expected.part)
        except ao.AOImpactError as error:
            return f"refused: {error}"
    for one in said:
        if not any(words in str(one.message) for words in called_for):
            return f"warned: {one.message}"
    assert read.node_labels is not None
    assert read.cell_labels is not None
    if set(body.nodes) != set(read.node_labels):
        return "labels of nodes"
    if _elements(body.mesh) != _elements(read):
        return "elements"
    row = {int(label): i for i, label in enumerate(read.node_labels)}
    order, found = np.array([row[label] for label in body.nodes]), []
    if (off := np.abs(read.nodes[order] - expected.places).max()) > expected.tolerance:
        found.append(f"nodes are off by {off:.2g}")
    for what, sets, labels, names in (
        ("nodes", read.node_sets, read.node_labels, expected.node_sets),
        ("elements", read.cell_sets, read.cell_labels, expected.cell_sets),
    ):
        groups = {name.upper(): set(labels[ids].tolist()) for name, ids in sets.items()}
        if groups != {name.upper(): members for name, members in names.items()}:
            found.append(f"groups of {what}: {groups} instead of {names}")
    return "; ".join(found)


def _elements(mesh: ao.Mesh) -> dict[int, tuple[str, list[int]]]:
    """Return kind and labels of the nodes of each element, by its label."""
    assert mesh.node_labels is not None
    assert mesh.cell_labels is not None
    return {
        int(label): (block.kind, mesh.node_labels[cell].tolist())
        for block in mesh.blocks
        for label, cell in zip(mesh.cell_labels[block.numbers], block.cells, strict=True)
    }
