"""Decks of Abaqus and CalculiX: parts, their instances and the assembly become one raw mesh.

A keyword that is not understood is refused unless it is known to have no influence on mesh and
groups.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray, MeshError, warn
from .abaqusdeck import Keyword, key, read_keywords
from .abaqusnames import CONNECTIONS, HARMLESS, SECTIONS, SIDES, STRUCTURAL, UNSUPPORTED
from .abaqusscope import Elements, Scope, Which, moved
from .raw import RawBlock, RawMesh

_OF_SCOPES = frozenset(("NODE", "NGEN", "ELEMENT", "ELGEN", "NSET", "ELSET", "SYSTEM"))

# Nodes of C3D27 in meshio's order, where the middle comes before those of faces 1 to 6, and of B32,
# where it comes before the second end.
_ORDERS = {"hexahedron27": (*range(20), 26, 24, 23, 25, 21, 22, 20), "line3": (0, 2, 1)}


@dataclass(eq=False)
class _Instance:
    """An instance of a part: its place, and keywords of its own.

    `keyword` is None for a part that stands for itself.
    """

    name: str
    part: str
    keyword: Keyword | None = None
    own: list[Keyword] = field(default_factory=list)


@dataclass(eq=False)
class _Model:
    """Keywords of a deck, by what they belong to.

    `outside` has those of the assembly, or of a deck without parts. Parts and instances are found
    by their names in capitals. `connections` counts keywords that connect nodes, and `changes`
    those of steps that remove or add elements. `cards` are all others, and *NODE, with their parts.
    """

    outside: list[Keyword] = field(default_factory=list)
    parts: dict[str, list[Keyword]] = field(default_factory=dict)
    instances: dict[str, _Instance] = field(default_factory=dict)
    called: dict[str, str] = field(default_factory=dict)
    connections: Counter[str] = field(default_factory=Counter)
    changes: int = 0
    cards: list[tuple[str, Keyword]] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class AbaqusDeck:
    """Keywords of a deck beyond its mesh.

    Attributes
    ----------
    cards : list of (str, Keyword)
        The part to which each belongs, in capitals; "" outside of parts.
    instances : mapping of str to list of (str, ndarray)
        By part, the beginning of the names of its sets in the mesh, such as "Bar-1.", and the
        matrix by which the instance is turned.
    types : ndarray of str, shape (n_cells,)
        The elements' types in capitals, through all blocks.
    towards : ndarray of bool, shape (n_cells,)
        Beams that name a node towards which their section is turned.
    """

    cards: list[tuple[str, Keyword]]
    instances: dict[str, list[tuple[str, FloatArray]]]
    types: npt.NDArray[np.str_]
    towards: npt.NDArray[np.bool_]

    @property
    def sections(self) -> str:
        """Keywords on shells and beams, as in "2 *SHELLSECTION"."""
        return _listed(Counter(f"*{c.name}" for _, c in self.cards if SECTIONS.fullmatch(c.name)))

    @property
    def elements(self) -> str:
        """The elements by their types, as in "100 CPS4"."""
        return _listed(Counter(self.types.tolist()))


def read(file: Path) -> RawMesh:
    """Return the mesh of a deck of Abaqus or CalculiX.

    A set of an instance is called "instance.set", and "set" as well where no other has one of that
    name. An instance is the group of its solids. Nodes of the assembly itself, which are
    reference points, are left out.

    Raises
    ------
    MeshError
        With file, line and keyword, if something that may concern nodes, elements or sets is not
        understood.
    MissingFileError
        If a file that it includes is not there.

    Warns
    -----
    AOImpactWarning
        If elements are no solids, parts have no instance, sets name missing members, or nodes are
        connected by more than elements.
    """
    try:
        with np.errstate(all="ignore"):  # coordinates out of reach are refused later
            return _joined(file, _sorted(read_keywords(file)))
    except RecursionError:
        raise MeshError(
            f"mesh file {str(file)!r}: its sets, or the files that it includes, are nested too deep"
        ) from None


def _sorted(keywords: list[Keyword]) -> _Model:
    """Give each keyword to its part, its instance or the assembly, and refuse unknown ones."""
    model = _Model()
    within: list[tuple[str, list[Keyword]]] = [("", model.outside)]
    loose: Keyword | None = None
    part = ""
    for keyword in keywords:
        name = keyword.name
        model.connections[name] += CONNECTIONS.fullmatch(name) is not None
        model.changes += name == "MODELCHANGE"
        if name in _OF_SCOPES:
            within[-1][1].append(keyword)
            if name == "NODE":
                model.cards.append((part, keyword))  # may hold normals
            if len(within) == 1 and name in ("NODE", "ELEMENT"):
                loose = keyword
        elif name == "PART":
            keyword.check_options("NAME")
            part = _new(keyword, model.parts)
            model.called[part] = keyword.options["NAME"].strip('"')
            within.append((name, model.parts.setdefault(part, [])))
        elif name == "ASSEMBLY":
            within.append((name, model.outside))
        elif name == "INSTANCE":
            keyword.check_options("NAME", "PART")
            instance, of = _new(keyword, model.instances), keyword.options.get("PART", "")
            if key(of) not in model.parts:
                raise keyword.error(f"there is no part {of}")
            called = keyword.options["NAME"].strip('"')
            model.instances[instance] = made = _Instance(called, key(of), keyword)
            within.append((name, made.own))
        elif name in ("ENDPART", "ENDASSEMBLY", "ENDINSTANCE"):
            if within.pop()[0] != name[3:]:
                raise keyword.error(f"it ends no *{name[3:]}")
            part = ""
        elif UNSUPPORTED.fullmatch(name):
            raise keyword.error("it is not supported; write the mesh out without it")
        elif not HARMLESS.match(name):
            raise keyword.error("it is not known, and may change the mesh; leave it out")
        else:
            model.cards.append((part, keyword))
    if len(within) > 1:
        raise keywords[-1].error(f"*END {within[-1][0]} is missing")
    if model.parts and loose is not None:
        raise loose.error("in a deck with parts, it must belong to one of them")
    if model.parts and not model.instances:
        model.instances = {part: _Instance(model.called[part], part) for part in model.parts}
    return model


def _new(keyword: Keyword, known: Mapping[str, object]) -> str:
    """Return the name of a part or instance in capitals."""
    name = key(keyword.options.get("NAME", ""))
    if not name or name in known:
        raise keyword.error("it needs a NAME of its own")
    return name


def _joined(file: Path, model: _Model) -> RawMesh:
    """Put instances in their places, one after the other, and find all sets."""
    whole = Scope()
    parts: dict[str, Scope] = {}
    for name, instance in model.instances.items():
        scope = parts.get(instance.part)
        if instance.own or scope is None:
            scope = Scope().read([*model.parts[instance.part], *instance.own])
        if not instance.own:
            parts[instance.part] = scope
        whole.inner[name] = scope = scope.placed(instance.keyword, whole.first)
        whole.first = scope.behind()
    whole.read(model.outside)
    scopes = [*whole.inner.values(), whole]
    bodies = [*whole.inner.values()] or [whole]
    blocks = [block for scope in scopes for block in scope.elements]
    rows = [block.nodes + of.first["NSET"] for of in scopes for block in of.elements]
    node_sets, cell_sets = _named(whole, model)
    kinds = np.repeat(np.arange(len(blocks)), [len(block.labels) for block in blocks])
    solid = np.array([block.type[:3] == "C3D" for block in blocks], dtype=bool)
    if not solid.any():  # a body of shells and beams: nothing else with a shape is part of it
        blocks = [b if STRUCTURAL.match(b.type) else replace(b, kind="") for b in blocks]
    unread = np.array([not block.kind for block in blocks], dtype=bool)
    bodies_named = {instance.name for instance in model.instances.values()}
    left_out = {}
    for name, members in cell_sets.items():
        of_kind = kinds[members]
        others = ~solid[of_kind] if solid[of_kind].any() else unread[of_kind]
        if others.any() and name not in bodies_named:
            listed = Counter(blocks[i].type for i in of_kind[others].tolist())
            left_out[name] = _listed(listed)
    _warn(file, whole, model, blocks)
    n_nodes = sum(len(body.labels) for body in bodies)
    return RawMesh(
        np.concatenate([body.places for body in bodies]),
        tuple(
            RawBlock(
                block.kind or "other", cells[:, _ORDERS.get(block.kind, slice(None))], block.labels
            )
            for block, cells in zip(blocks, rows, strict=True)
        ),
        {name: members[members < n_nodes] for name, members in node_sets.items()},
        cell_sets,
        np.concatenate([body.labels for body in bodies]),
        left_out,
        AbaqusDeck(
            model.cards,
            _turned(model),
            np.array([block.type for block in blocks], dtype=str)[kinds],
            np.array([block.towards for block in blocks], dtype=bool)[kinds],
        ),
    )


def _turned(model: _Model) -> dict[str, list[tuple[str, FloatArray]]]:
    """Return the instances of each part, as `AbaqusDeck` has them."""
    found = {"": [("", np.eye(3))]}
    for instance in model.instances.values():
        points = np.vstack([np.zeros(3), np.eye(3)])
        if instance.keyword is not None:
            points = moved(instance.keyword, points)
        found.setdefault(instance.part, []).append(
            (f"{instance.name}.", (points[1:] - points[0]).T)
        )
    return found


def _named(whole: Scope, model: _Model) -> tuple[dict[str, IntArray], dict[str, IntArray]]:
    """Return all sets by the names that users know: members' numbers among those of all scopes."""
    sets: dict[tuple[Which, str], list[tuple[str, IntArray]]] = {
        at: [(called, whole.members(*at))] for at, called in whole.names.items()
    }
    own = set(sets)
    for name, instance in model.instances.items():
        scope = whole.inner[name]
        for (which, inner), called in scope.names.items():
            members = scope.members(which, inner)
            full = f"{instance.name}.{called}"
            sets.setdefault((which, key(full)), []).append((full, members))
            if (which, inner) not in own:
                sets.setdefault((which, inner), []).append((called, members))
        every = np.arange(scope.first["ELSET"], scope.behind()["ELSET"])
        sets.setdefault(("ELSET", name), []).append((instance.name, every))
    named: dict[Which, dict[str, IntArray]] = {"NSET": {}, "ELSET": {}}
    for (which, _), found in sets.items():
        called, members = found[0]
        if all(np.array_equal(members, other) for _, other in found):  # else of several instances
            named[which][called] = members
    return named["NSET"], named["ELSET"]


def _listed(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))


def _warn(file: Path, whole: Scope, model: _Model, blocks: list[Elements]) -> None:
    """Name in one warning the contents of the deck that are not in the mesh."""
    said = []
    counts: Counter[str] = Counter()
    for block in blocks:
        counts[block.type] += len(block.labels)
    # No model has plane elements beside solids: a mesher wrote sides, and edges as trusses.
    edges = ("T3D",) if any(map(SIDES.match, counts)) else ()
    for name in list(counts):
        if name.startswith(("C3D", *edges)) or SIDES.match(name):
            del counts[name]
    if connections := +model.connections:
        named = ", ".join(f"{count} *{name}" for name, count in sorted(connections.items()))
        said.append(
            "connections between nodes were left out, and the body is computed without them: "
            + named
        )
    if model.changes:
        said.append(f"{model.changes} *MODEL CHANGE were left out: the body has all elements")
    solids = any(block.type.startswith("C3D") for block in blocks)
    thin = {block.type for block in blocks if block.kind}
    unread = Counter({name: count for name, count in counts.items() if name not in thin})
    if solids and counts != unread:
        said.append(
            "elements that are no solids are not part of the body, unless their groups are named "
            f"as shells and beams: {_listed(counts)}"
        )
    elif unread:
        what = "no solids" if solids else "no solids, shells or beams"
        said.append(f"elements that are {what} are not part of the body: {_listed(unread)}")
    used = {instance.part for instance in model.instances.values()}
    if unused := [model.called[part] for part in model.parts if part not in used]:
        said.append(f"parts without an instance are left out: {', '.join(unused)}")
    missing = dict(whole.missing)
    for scope in whole.inner.values():
        missing |= scope.missing
    if missing:
        name, label = next(iter(missing.items()))
        more = f" (and {len(missing) - 1} sets more)" if len(missing) > 1 else ""
        said.append(f"{name} names {label}, which is not defined{more}")
    if said:
        warn(f"mesh file {str(file)!r}: {'; '.join(said)}")
