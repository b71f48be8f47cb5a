"""Nodes, elements and sets of one part of a deck: all that share their numbers and names.

A deck without parts is one scope. Else each instance of a part is one, and so is the assembly,
whose sets may name members of the instances.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import scipy

from ..base import FloatArray, IntArray, MeshError, require
from .abaqusdeck import MOST, Keyword, key
from .abaqusnames import element_type
from .raw import cylindrical, joined, repeats, rows_of

# Sets of nodes or of elements.
Which = Literal["NSET", "ELSET"]

# Bytes that a generated node takes, Python's objects included.
_PER_NODE = 400

# Sine of an angle below which two directions are the same.
_PARALLEL = 1e-9

# Share of a radius by which two nodes of one arc may differ.
_ROUND = 1e-3


@dataclass(frozen=True, eq=False)
class Elements:
    """Elements of one type.

    Attributes
    ----------
    type, kind : str
        The deck's name, and meshio's; the latter is empty if nodes are not read.
    labels : ndarray of int, shape (n,)
    nodes : ndarray of int, shape (n, nodes per element)
        First their labels, at last rows of the scope's nodes.
    keyword : Keyword
    towards : bool
        True of beams that name a node more, towards which their section is turned.
    """

    type: str
    kind: str
    labels: IntArray
    nodes: IntArray
    keyword: Keyword
    towards: bool = False


@dataclass(frozen=True, eq=False)
class _Piece:
    """A piece of a set: numbers, ranges of them, names of sets, or the nodes of an ELSET.

    `order` counts keywords. `instance` is the one that has these numbers and sets.
    """

    keyword: Keyword
    order: int
    numbers: IntArray
    ranges: tuple[tuple[int, int, int], ...] = ()
    names: tuple[str, ...] = ()
    instance: str = ""
    of_elements: str = ""


@dataclass(eq=False)
class Scope:
    """Nodes, elements and sets that share their numbers and names.

    Attributes
    ----------
    part : Scope or None
        The part of which it is an instance.
    inner : mapping of str to Scope
        Instances of an assembly, by their names in capitals.
    first : mapping of Which to int
        Number of the first node and element among those of all scopes.
    labels : ndarray of int, shape (n,), ascending
        Numbers of the nodes.
    places : ndarray, shape (n, 3)
    elements : list of Elements
        In the order of the deck.
    names : mapping of (Which, str) to str
        By the names of sets as they are compared, the names as they are written first.
    missing : mapping of str to int
        By sets, the first of their numbers that is not defined.
    """

    part: Scope | None = None
    inner: dict[str, Scope] = field(default_factory=dict)
    first: dict[Which, int] = field(default_factory=lambda: {"NSET": 0, "ELSET": 0})
    labels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    elements: list[Elements] = field(default_factory=list)
    names: dict[tuple[Which, str], str] = field(default_factory=dict)
    missing: dict[str, int] = field(default_factory=dict)
    _points: list[tuple[Keyword, IntArray, FloatArray]] = field(default_factory=list)
    _sets: dict[tuple[Which, str], list[_Piece]] = field(default_factory=dict)
    _found: dict[tuple[Which, str], IntArray | None] = field(default_factory=dict)
    # Ascending labels, and the rows of their nodes or elements.
    _known: dict[Which, tuple[IntArray, IntArray]] = field(default_factory=dict)
    _order: int = 0

    def placed(self, keyword: Keyword | None, first: dict[Which, int]) -> Scope:
        """Return it as an instance, moved by the data lines of *INSTANCE, if there are any."""
        places = self.places if keyword is None else moved(keyword, self.places)
        return replace(self, part=self, first=first, places=places)

    def behind(self) -> dict[Which, int]:
        """Return the numbers, as `first`, that follow those of its nodes and elements."""
        return {which: self.first[which] + len(self._known[which][0]) for which in self.first}

    # -------------------------------------------------------------------- keywords

    def read(self, keywords: Iterable[Keyword]) -> Scope:
        """Read keywords, all at once, and return the scope."""
        frame = _Frame()
        generated: list[tuple[int, Keyword, _Frame]] = []
        for self._order, keyword in enumerate(keywords):
            match keyword.name:
                case "SYSTEM":
                    frame = _Frame.of(keyword)
                case "NODE":
                    self._node(keyword, frame)
                case "ELEMENT":
                    self._element(keyword)
                case "NSET" | "ELSET":
                    self._set(keyword)
                case _:  # made of nodes and elements that may come later
                    generated.append((self._order, keyword, frame))
        for self._order, keyword, frame in generated:
            if keyword.name == "NGEN":
                self._ngen(keyword, frame)
        for self._order, keyword, _ in generated:
            if keyword.name == "ELGEN":
                self._elgen(keyword)
        self._number()
        return self

    def _node(self, keyword: Keyword, frame: _Frame) -> None:
        keyword.check_options("NSET", "SYSTEM", "INPUT")
        labels, places = keyword.points()
        system = key(keyword.options.get("SYSTEM", "R"))
        if system not in ("R", "C", "S", "RECTANGULAR", "CYLINDRICAL", "SPHERICAL"):
            raise keyword.error(f"SYSTEM must be R, C or S, got {system}")
        if system[0] == "C":
            places = cylindrical(*places.T)
        elif system[0] == "S":  # r, the angle about z, and that from the plane of x and y
            r, turn, rise = places.T
            rise = np.radians(rise)
            places = cylindrical(r * np.cos(rise), turn, r * np.sin(rise))
        self._points.append((keyword, labels, places @ frame.axes.T + frame.origin))
        self._define(keyword, "NSET", labels)

    def _ngen(self, keyword: Keyword, frame: _Frame) -> None:
        """Add nodes between two others, on a straight line or an arc."""
        keyword.check_options("NSET", "LINE")
        line = key(keyword.options.get("LINE", ""))
        if line not in ("", "C"):
            raise keyword.error(f"LINE={line} is not supported; write the nodes out")
        where: dict[int, FloatArray] = {}
        for _, labels, places in self._points:
            where.update(zip(labels.tolist(), places, strict=True))
        made: dict[int, FloatArray] = {}
        ends: list[int] = []
        for row, texts in enumerate(keyword.rows):
            first, last, step = keyword.span(row, texts[:3])
            n, rest = divmod(last - first, step)
            if rest or not n:
                raise keyword.error(f"no step of {step} leads from {first} to {last}", row)
            require(n * _PER_NODE, f"*NGEN of {n} nodes", "check the numbers in the deck")
            centre = keyword.integers(row, texts[3:4])[0] if line == "C" and any(texts[3:4]) else 0
            for end in (first, last, centre or first):
                if end not in where:
                    raise keyword.error(f"node {end} is not defined", row)
            share = np.arange(1, n)[:, None] / n
            if line == "C":
                numbers = keyword.reals(row, texts[4:])
                given = np.array([*numbers, *[0.0] * 6][:6])
                about = where[centre] if centre else frame.origin + frame.axes @ given[:3]
                normal = frame.axes @ given[3:] if len(numbers) > 3 else None
                between = None
                if centre or numbers:
                    between = _arc(where[first], where[last], share, about, normal)
                if between is None:
                    raise keyword.error("no arc leads from node to node about the centre", row)
            else:
                if len(texts) > 3:
                    raise keyword.error("only LINE=C takes more than three numbers", row)
                between = where[first] + share * (where[last] - where[first])
            new = dict(zip(range(first + step, last, step), between, strict=True))
            where.update(new)
            made.update(new)
            ends += [first, last]
        labels = np.fromiter(made, dtype=np.int64)
        self._points.append((keyword, labels, np.reshape([*made.values()], (-1, 3))))
        self._define(keyword, "NSET", joined([np.array(ends, dtype=np.int64), labels]))

    def _element(self, keyword: Keyword) -> None:
        keyword.check_options("TYPE", "ELSET", "INPUT")
        name = key(keyword.options.get("TYPE", ""))
        found = element_type(name)
        if found is None:
            raise keyword.error(f"elements of type {name!r} are not known")
        kind, n_nodes = found
        if self.inner and name.startswith("C3D"):
            raise keyword.error("solids belong into a part")
        if kind and not self.inner:  # between instances, nodes have names
            towards = False
            try:
                table = keyword.connectivity(n_nodes)
            except MeshError:
                if name[0] != "B":
                    raise
                table, towards = keyword.connectivity(n_nodes + 1)[:, : n_nodes + 1], True
            new = Elements(name, kind, table[:, 0], table[:, 1:], keyword, towards)
        else:
            labels = keyword.first_numbers()
            none = np.zeros((len(labels), 0), dtype=np.int64)
            new = Elements(name, "", labels, none, keyword)
        self.elements.append(new)
        self._define(keyword, "ELSET", new.labels)

    def _elgen(self, keyword: Keyword) -> None:
        """Add elements like a first one, in a row, a layer of rows, and layers."""
        keyword.check_options("ELSET")
        every = []
        n_nodes = sum(len(labels) for _, labels, _ in self._points)
        for row, texts in enumerate(keyword.rows):
            master, *numbers = keyword.integers(row, [text or "1" for text in texts])
            if not 1 <= len(numbers) <= 9:
                raise keyword.error("give an element, and how many to make of it", row)
            numbers += [1, 1, 1, 1, 0, 0, 1, 0, 0][len(numbers) :]
            counts, steps = numbers[0::3], np.array([numbers[1::3], numbers[2::3]]).T
            if min(counts) < 1 or math.prod(counts) > n_nodes:
                raise keyword.error("it makes no elements, or more than there are nodes", row)
            of = [
                (block, i)
                for block in self.elements
                for i in np.flatnonzero(block.labels == master)
            ]
            if not of:
                raise keyword.error(f"element {master} is not defined", row)
            block, i = of[-1]
            shifts = np.zeros((1, 2), dtype=np.int64)  # of nodes' and elements' numbers
            for count, step in zip(counts, steps, strict=True):
                shifts = (np.arange(count)[:, None, None] * step + shifts).reshape(-1, 2)
            labels = master + shifts[:, 1]
            nodes = block.nodes[i] + shifts[1:, :1]
            self.elements.append(replace(block, labels=labels[1:], nodes=nodes, keyword=keyword))
            every.append(labels)
        self._define(keyword, "ELSET", joined(every))

    def _set(self, keyword: Keyword) -> None:
        which: Which = "NSET" if keyword.name == "NSET" else "ELSET"
        known = {"NSET", "ELSET"} if which == "NSET" else {"ELSET"}
        keyword.check_options(*known, "GENERATE", "UNSORTED", "INTERNAL", "INSTANCE", "INPUT")
        options = keyword.options
        if which not in options:
            raise keyword.error(f"{which}=name is missing")
        instance = key(options.get("INSTANCE", ""))
        if instance and instance not in self.inner:
            raise keyword.error(f"there is no instance {options['INSTANCE']}")
        given: dict[str, Any] = {"instance": instance}
        if which == "NSET":
            given["of_elements"] = options.get("ELSET", "")
        numbers: list[int] = []
        if "GENERATE" in options:
            ranges = [keyword.span(row, texts) for row, texts in enumerate(keyword.rows)]
            for row, (_, _, step) in enumerate(ranges):
                if step < 0:
                    raise keyword.error("the step must be positive", row)
            given["ranges"] = tuple(ranges)
        else:
            fields = [text for texts in keyword.rows for text in texts if text]
            numbers = [int(text) for text in fields if text.isdecimal()]
            given["names"] = tuple(text for text in fields if not text.isdecimal())
        if max(numbers, default=0) >= MOST:
            raise keyword.error(f"the number {max(numbers)} is too large")
        self._define(keyword, which, np.array(numbers, dtype=np.int64), **given)

    def _define(self, keyword: Keyword, which: Which, numbers: IntArray, **given: Any) -> None:
        """Add to the set that a keyword names, if it names one."""
        if which in keyword.options:
            name = keyword.options[which]
            at = which, key(name)
            if not at[1]:
                raise keyword.error(f"{which}= has no name")
            self.names.setdefault(at, name.strip('"'))
            self._sets.setdefault(at, []).append(_Piece(keyword, self._order, numbers, **given))

    def _number(self) -> None:
        """Sort the nodes by their labels, and find the rows of the elements' nodes."""
        labels = joined(labels for _, labels, _ in self._points)
        places = np.concatenate([np.zeros((0, 3)), *(places for _, _, places in self._points)])
        order = np.argsort(labels, kind="stable")
        labels, places = labels[order], places[order]
        again = np.flatnonzero(labels[1:] == labels[:-1]) + 1
        for label in labels[again[(places[again] != places[again - 1]).any(axis=1)]].tolist():
            keyword = [one for one, own, _ in self._points if (own == label).any()][-1]
            raise keyword.error(f"node {label} is defined twice, at different places")
        self.labels, self.places = np.delete(labels, again), np.delete(places, again, axis=0)
        for i, block in enumerate(self.elements):
            rows = rows_of(self.labels, block.nodes)
            for element, node in np.argwhere(rows < 0)[:1]:
                label, missing = block.labels[element], block.nodes[element, node]
                raise block.keyword.error(
                    f"element {label} has node {missing}, which is not defined"
                )
            self.elements[i] = replace(block, nodes=rows)
        labels = joined(block.labels for block in self.elements)
        for label in labels[repeats(labels)[:1]].tolist():
            keyword = [one.keyword for one in self.elements if (one.labels == label).any()][-1]
            raise keyword.error(f"element {label} is defined twice")
        order = np.argsort(labels, kind="stable")
        self._known["NSET"] = self.labels, np.arange(len(self.labels))
        self._known["ELSET"] = labels[order], order

    # ------------------------------------------------------------------------ sets

    def members(self, which: Which, name: str) -> IntArray:
        """Return the sorted numbers, among those of all scopes, of a set's members."""
        at = which, name
        if self.part is not None:
            return self.part.members(which, name) + self.first[which]
        if at not in self._found:
            self._found[at] = None
            self._found[at] = np.unique(joined(self._resolved(which, of) for of in self._sets[at]))
        found = self._found[at]
        if found is None:
            raise self._sets[at][0].keyword.error(f"the set {name} is a part of itself")
        return found

    def _resolved(self, which: Which, piece: _Piece) -> IntArray:
        scope = self.inner.get(piece.instance, self)
        found = scope._numbered(which, piece.numbers)
        absent = piece.numbers[found < 0].tolist()
        parts = [found[found >= 0]]
        known, order = scope._known[which]
        for start, stop, step in piece.ranges:
            inside = slice(*np.searchsorted(known, [start, stop + 1]).tolist())
            chosen = order[inside][(known[inside] - start) % step == 0]
            parts.append(chosen + scope.first[which])
            absent += [] if len(chosen) else [start]
        parts += [scope._named(which, name, piece) for name in piece.names]
        if piece.of_elements:
            elements = scope._named("ELSET", piece.of_elements, piece)
            parts.append(scope._nodes_of(elements, piece.keyword))
        if absent:
            self.missing[f"{which} {piece.keyword.options[which]}"] = absent[0]
        return np.concatenate(parts)

    def _numbered(self, which: Which, labels: IntArray) -> IntArray:
        """Return the numbers of nodes or elements among those of all scopes; -1 for others."""
        known, order = self._known[which]
        if not len(known):
            return np.full(len(labels), -1)
        at = np.searchsorted(known, labels).clip(max=len(known) - 1)
        return np.where(known[at] == labels, order[at] + self.first[which], -1)

    def _named(self, which: Which, name: str, piece: _Piece) -> IntArray:
        """Return the members of a name in a piece of a set: a set, instance.set, instance.5."""
        at = which, key(name)
        if at in self._sets:
            orders = [one.order for one in self._sets[at]]
            if min(orders) < piece.order < max(orders):
                raise piece.keyword.error(
                    f"it is made of the set {name}, which grows afterwards; define {name} before"
                )
            return self.members(*at)
        outer, _, rest = name.partition(".")
        scope = self.inner.get(key(outer))
        if rest and scope is not None:
            if not rest.strip().isdecimal():
                return scope._named(which, rest, piece)
            found = scope._numbered(which, np.array([int(rest)]))
            if found[0] >= 0:
                return found
        why = ""
        if rest and scope is None:
            why = f", and no instance {outer}; in a deck without parts give the numbers alone"
        raise piece.keyword.error(f"there is no {which} {name}{why}")

    def _nodes_of(self, elements: IntArray, keyword: Keyword) -> IntArray:
        """Return the sorted numbers of the nodes of elements, both among those of all scopes.

        The keyword is the one that asks for them, for errors.
        """
        found = [scope._nodes_of(elements, keyword) for scope in self.inner.values()]
        start = self.first["ELSET"]
        for block in self.elements:
            own = elements - start
            own = own[(own >= 0) & (own < len(block.labels))]
            if block.kind:
                found.append(block.nodes[own].ravel() + self.first["NSET"])
            elif len(own):
                raise keyword.error(f"nodes of elements of type {block.type} are not read")
            start += len(block.labels)
        return np.unique(joined(found))


# ------------------------------------------------------------------------------------ geometry


@dataclass(frozen=True, eq=False)
class _Frame:
    """Rectangular axes: local coordinates x become origin + axes @ x."""

    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    axes: FloatArray = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(cls, keyword: Keyword) -> _Frame:
        """Return the axes of *SYSTEM.

        They are given by their origin, a point on x, and one in the plane of x and y. Without the
        last one z stays as it is, and x is projected; without any, the axes are global again.
        """
        keyword.check_options()
        rows = keyword.real_rows(6, 3, what="the points a and b in one line, and c in the next")
        if not rows:
            return cls()
        first, second = ([*row, *[0.0] * 6] for row in [*rows, []][:2])
        origin = np.array(first[:3])
        if len(rows[0]) <= 3:
            return cls(origin)
        x, beside = np.array(first[3:6]) - origin, np.array(second[:3]) - origin
        if len(rows) == 1:
            x[2] = 0.0
            beside = np.array([-x[1], x[0], 0.0])
        z = np.cross(x, beside)
        if not np.linalg.norm(z) > _PARALLEL * np.linalg.norm(x) * np.linalg.norm(beside):
            raise keyword.error("the points a, b and c are on one line")
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        return cls(origin, np.column_stack([x, np.cross(z, x), z]))


def _arc(
    start: FloatArray, end: FloatArray, share: FloatArray, centre: FloatArray, given: Any
) -> FloatArray | None:
    """Return places on an arc, shape (n, 3), or None if there is no such arc.

    Parameters
    ----------
    start, end, centre : ndarray, shape (3,)
    share : ndarray, shape (n, 1)
        Shares of the way from start to end.
    given : ndarray, shape (3,), or None
        A normal of the arc, needed from 180° on.
    """
    arms = start - centre, end - centre
    radii = [float(np.linalg.norm(arm)) for arm in arms]
    normal = np.cross(*arms) if given is None else given
    size = float(np.linalg.norm(normal))
    least = _PARALLEL * radii[0] * radii[1] if given is None else 0.0
    if not (size > least and abs(radii[0] - radii[1]) <= _ROUND * radii[0]):
        return None
    across = np.cross(normal / size, arms[0])
    angle = math.atan2(float(arms[1] @ across), float(arms[1] @ arms[0])) % (2.0 * math.pi)
    if angle < _PARALLEL:
        return None
    places: FloatArray = centre + np.cos(share * angle) * arms[0] + np.sin(share * angle) * across
    return places


def moved(keyword: Keyword, places: FloatArray) -> FloatArray:
    """Return coordinates of an instance by the data lines of *INSTANCE.

    The first is a translation. The second, two points and an angle, turns the translated body.
    """
    rows = keyword.real_rows(3, 7, what="a translation, and a rotation by two points and an angle")
    for row in rows[:1]:
        places = places + np.array([*row, 0.0, 0.0, 0.0][:3])
    for row in rows[1:]:
        points = np.array([*row, *[0.0] * 7][:7])
        start, axis = points[:3], points[3:6] - points[:3]
        if not axis.any():
            raise keyword.error("the two points of the axis of rotation are the same")
        turn = points[6] * axis / np.linalg.norm(axis)
        rotation = scipy.spatial.transform.Rotation.from_rotvec(turn, degrees=True)
        places = rotation.apply(places - start) + start
    return places
