"""Nodes, elements and sets of one part of a deck: all that share their numbers and names.

A deck without parts is one scope. Else each instance of a part is one, and so is the assembly,
whose sets may name what is in the instances.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ...base import FloatArray, IntArray, require
from .inpfile import Keyword, key
from .inpgeometry import Frame, arc, in_system
from .inptypes import element_type

__all__ = ["Elements", "Place", "Scope", "Which"]

# Nodes or elements: what a set is of.
Which = Literal["NSET", "ELSET"]

# By which numbers the nodes and elements of a scope begin among those of all scopes.
Place = dict[Which, int]

# Bytes that a generated node takes, Python's objects included.
_PER_NODE = 400


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
    """

    type: str
    kind: str
    labels: IntArray
    nodes: IntArray
    keyword: Keyword


@dataclass(frozen=True, eq=False)
class _Piece:
    """A piece of a set: numbers, ranges of them, names of sets, or the nodes of an ELSET.

    `order` counts keywords. `instance` says whose numbers and sets these are.
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
    inner : mapping of str to (Scope, Place)
        Of an assembly: its instances, by their names in capitals.
    first : Place
    labels : ndarray of int, shape (n,), ascending
        Numbers of the nodes.
    places : ndarray, shape (n, 3)
    elements : list of Elements
        In the order of the deck.
    element_labels : ndarray of int
    names : mapping of (Which, str) to str
        By the names of sets as they are compared, the names as they are written first.
    missing : mapping of str to int
        By sets, the first of the numbers in them that nothing has.
    """

    inner: dict[str, tuple[Scope, Place]] = field(default_factory=dict)
    first: Place = field(default_factory=lambda: {"NSET": 0, "ELSET": 0})
    labels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    elements: list[Elements] = field(default_factory=list)
    element_labels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    names: dict[tuple[Which, str], str] = field(default_factory=dict)
    missing: dict[str, int] = field(default_factory=dict)
    _points: list[tuple[Keyword, IntArray, FloatArray]] = field(default_factory=list)
    _sets: dict[tuple[Which, str], list[_Piece]] = field(default_factory=dict)
    _found: dict[tuple[Which, str], IntArray | None] = field(default_factory=dict)
    _sorted: dict[Which, tuple[IntArray, IntArray]] = field(default_factory=dict)
    _order: int = 0

    # -------------------------------------------------------------------- keywords

    def read(self, keywords: Iterable[Keyword]) -> Scope:
        """Read keywords, all at once, and return the scope."""
        frame = Frame()
        generated: list[tuple[int, Keyword, Frame]] = []
        for order, keyword in enumerate(keywords):
            self._order = order
            match keyword.name:
                case "SYSTEM":
                    keyword.check_options(())
                    frame = Frame.of(keyword)
                case "NODE":
                    self._node(keyword, frame)
                case "ELEMENT":
                    self._element(keyword)
                case "NSET" | "ELSET":
                    self._set(keyword)
                case _:  # made of nodes and elements that may come later
                    generated.append((order, keyword, frame))
        for name in ("NGEN", "ELGEN"):
            for self._order, keyword, frame in generated:
                if keyword.name == name == "NGEN":
                    self._ngen(keyword, frame)
                elif keyword.name == name:
                    self._elgen(keyword)
        self._number_nodes()
        self._number_elements()
        return self

    def _node(self, keyword: Keyword, frame: Frame) -> None:
        keyword.check_options(("NSET", "SYSTEM", "INPUT"))
        labels, places = keyword.points()
        system = key(keyword.options.get("SYSTEM", "R"))
        if system not in ("R", "C", "S", "RECTANGULAR", "CYLINDRICAL", "SPHERICAL"):
            raise keyword.error(f"SYSTEM must be R, C or S, got {system}")
        self._points.append((keyword, labels, frame.to_global(in_system(system[0], places))))
        self._define_also(keyword, "NSET", labels)

    def _ngen(self, keyword: Keyword, frame: Frame) -> None:
        """Add nodes between two others, on a straight line or an arc."""
        keyword.check_options(("NSET", "LINE"))
        line = key(keyword.options.get("LINE", ""))
        if line not in ("", "C"):
            raise keyword.error(f"LINE={line} is not supported; write the nodes out")
        where: dict[int, FloatArray] = {}
        for _, labels, places in self._points:
            where.update(zip(labels.tolist(), places, strict=True))
        made: dict[int, FloatArray] = {}
        ends: list[int] = []
        for row, texts in enumerate(keyword.rows()):
            first, last, step = keyword.span(row, texts[:3])
            n, rest = divmod(last - first, step)
            if rest or not n:
                raise keyword.error(f"no step of {step} leads from {first} to {last}", row)
            require(n * _PER_NODE, f"*NGEN of {n} nodes", "check the numbers in the deck")
            for end in (first, last):
                if end not in where:
                    raise keyword.error(f"node {end} is not defined", row)
            share = np.arange(1, n)[:, None] / n
            start, end_place = where[first], where[last]
            if line == "C":
                label = keyword.integers(row, texts[3:4])[0] if texts[3:4] and texts[3] else 0
                if label and label not in where:
                    raise keyword.error(f"node {label} is not defined", row)
                numbers = keyword.reals(row, texts[4:])
                between = arc(start, end_place, share, where.get(label), numbers, frame)
                if between is None:
                    raise keyword.error("no arc leads from node to node about the centre", row)
            else:
                if len(texts) > 3:
                    raise keyword.error("only LINE=C takes more than three numbers", row)
                between = start + share * (end_place - start)
            new = dict(zip(range(first + step, last, step), between, strict=True))
            where.update(new)
            made.update(new)
            ends += [first, last]
        labels = np.fromiter(made, dtype=np.int64)
        self._points.append((keyword, labels, np.reshape([*made.values()], (-1, 3))))
        self._define_also(keyword, "NSET", np.concatenate([np.array(ends, dtype=np.int64), labels]))

    def _element(self, keyword: Keyword) -> None:
        keyword.check_options(("TYPE", "ELSET", "INPUT"))
        name = key(keyword.options.get("TYPE", ""))
        found = element_type(name)
        if found is None:
            raise keyword.error(f"elements of type {name!r} are not known")
        if self.inner and found.solid:
            raise keyword.error("solids belong into a part")
        if found.kind and not self.inner:  # between instances, nodes have names
            table = keyword.connectivity(found.n_nodes)
            new = Elements(name, found.kind, table[:, 0], table[:, 1:], keyword)
        else:
            none = np.zeros((0, 0), dtype=np.int64)
            new = Elements(name, "", keyword.first_numbers(), none, keyword)
        self.elements.append(new)
        self._define_also(keyword, "ELSET", new.labels)

    def _elgen(self, keyword: Keyword) -> None:
        """Add elements like a first one, in a row, a layer of rows, and layers."""
        keyword.check_options(("ELSET",))
        every = [np.zeros(0, dtype=np.int64)]
        n_nodes = sum(len(labels) for _, labels, _ in self._points)
        for row, texts in enumerate(keyword.rows()):
            master, *numbers = keyword.integers(row, [text or "1" for text in texts])
            if not 1 <= len(numbers) <= 9:
                raise keyword.error("give an element, and how many to make of it", row)
            numbers += [1, 1, 1, 1, 0, 0, 1, 0, 0][len(numbers) :]
            counts = numbers[0::3]
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
            for count, steps in zip(
                counts, zip(numbers[1::3], numbers[2::3], strict=True), strict=True
            ):
                along = np.arange(count)[:, None, None] * np.array(steps, dtype=np.int64)
                shifts = (along + shifts).reshape(-1, 2)
            labels = master + shifts[:, 1]
            nodes = block.nodes[i] + shifts[1:, :1] if block.kind else block.nodes
            self.elements.append(Elements(block.type, block.kind, labels[1:], nodes, keyword))
            every.append(labels)
        self._define_also(keyword, "ELSET", np.concatenate(every))

    def _set(self, keyword: Keyword) -> None:
        which: Which = "NSET" if keyword.name == "NSET" else "ELSET"
        known = ("NSET", "ELSET") if which == "NSET" else ("ELSET",)
        keyword.check_options((*known, "GENERATE", "UNSORTED", "INTERNAL", "INSTANCE", "INPUT"))
        options = keyword.options
        if which not in options:
            raise keyword.error(f"{which}=name is missing")
        given: dict[str, Any] = {"instance": key(options.get("INSTANCE", ""))}
        if given["instance"] and given["instance"] not in self.inner:
            raise keyword.error(f"there is no instance {options['INSTANCE']}")
        if which == "NSET" and "ELSET" in options:
            given["of_elements"] = options["ELSET"]
        numbers: list[int] = []
        if "GENERATE" in options:
            ranges = []
            for row, texts in enumerate(keyword.rows()):
                start, stop, step = keyword.span(row, texts)
                if step < 0:
                    raise keyword.error("the step must be positive", row)
                ranges.append((start, stop, step))
            given["ranges"] = tuple(ranges)
        else:
            fields = [text for texts in keyword.rows() for text in texts if text]
            numbers = [int(text) for text in fields if text.isdecimal()]
            given["names"] = tuple(text for text in fields if not text.isdecimal())
        if max(numbers, default=0) >= 2**53:
            raise keyword.error(f"the number {max(numbers)} is too large")
        self._define(keyword, which, np.array(numbers, dtype=np.int64), **given)

    def _define_also(self, keyword: Keyword, which: Which, numbers: IntArray) -> None:
        """Put what a keyword defines into a set, if it names one."""
        if which in keyword.options:
            self._define(keyword, which, numbers)

    def _define(self, keyword: Keyword, which: Which, numbers: IntArray, **given: Any) -> None:
        name = keyword.options[which]
        at = which, key(name)
        if not at[1]:
            raise keyword.error(f"{which}= has no name")
        self.names.setdefault(at, name.strip('"'))
        self._sets.setdefault(at, []).append(_Piece(keyword, self._order, numbers, **given))

    # -------------------------------------------------- numbers within the scope

    def _number_nodes(self) -> None:
        labels = np.concatenate([self.labels, *(labels for _, labels, _ in self._points)])
        places = np.concatenate([self.places, *(places for _, _, places in self._points)])
        order = np.argsort(labels, kind="stable")
        labels, places = labels[order], places[order]
        again = np.flatnonzero(labels[1:] == labels[:-1]) + 1
        for label in labels[again[(places[again] != places[again - 1]).any(axis=1)]].tolist():
            keyword = [one for one, own, _ in self._points if (own == label).any()][-1]
            raise keyword.error(f"node {label} is defined twice, at different places")
        self.labels, self.places = np.delete(labels, again), np.delete(places, again, axis=0)
        self._points.clear()

    def _number_elements(self) -> None:
        for i, block in enumerate(self.elements):
            if block.kind:
                rows, there = _found(self.labels, block.nodes)
                for element, node in np.argwhere(~there)[:1].tolist():
                    raise block.keyword.error(
                        f"element {block.labels[element]} has node {block.nodes[element, node]}, "
                        "which is not defined"
                    )
                self.elements[i] = Elements(
                    block.type, block.kind, block.labels, rows, block.keyword
                )
        self.element_labels = np.concatenate(
            [self.element_labels, *(block.labels for block in self.elements)]
        )
        ordered = np.sort(self.element_labels)
        for label in ordered[1:][ordered[1:] == ordered[:-1]][:1].tolist():
            keyword = [one.keyword for one in self.elements if (one.labels == label).any()][-1]
            raise keyword.error(f"element {label} is defined twice")

    def _numbered(self, which: Which, labels: IntArray) -> tuple[IntArray, IntArray]:
        """Return the numbers of what has these labels, and the labels that nothing has."""
        known, order = self._sorted_labels(which)
        at, there = _found(known, labels)
        return order[at[there]] + self.first[which], labels[~there]

    def _sorted_labels(self, which: Which) -> tuple[IntArray, IntArray]:
        """Return all labels, ascending, and the numbers of their nodes or elements."""
        if which not in self._sorted:
            labels = self.labels if which == "NSET" else self.element_labels
            order = np.argsort(labels, kind="stable")
            self._sorted[which] = labels[order], order
        return self._sorted[which]

    # ------------------------------------------------------------------------ sets

    def members(self, which: Which, name: str) -> IntArray:
        """Return the sorted numbers, among those of all scopes, of a set's members."""
        at = which, name
        if at not in self._found:
            self._found[at] = None
            parts = [self._resolved(which, piece) for piece in self._sets[at]]
            self._found[at] = np.unique(np.concatenate(parts))
        found = self._found[at]
        if found is None:
            raise self._sets[at][0].keyword.error(f"the set {name} is a part of itself")
        return found

    def _resolved(self, which: Which, piece: _Piece) -> IntArray:
        scope, place = self.inner.get(piece.instance, (self, {"NSET": 0, "ELSET": 0}))
        found, absent = scope._numbered(which, piece.numbers)
        parts = [found + place[which]]
        known, order = scope._sorted_labels(which)
        for start, stop, step in piece.ranges:
            inside = slice(*np.searchsorted(known, [start, stop + 1]).tolist())
            chosen = order[inside][(known[inside] - start) % step == 0]
            parts.append(chosen + scope.first[which] + place[which])
            if not len(chosen):
                absent = np.append(absent, start)
        parts += [scope._named(which, name, piece) + place[which] for name in piece.names]
        if piece.of_elements:
            elements = scope._named("ELSET", piece.of_elements, piece)
            parts.append(scope.nodes_of(elements, piece.keyword) + place["NSET"])
        if len(absent):
            self.missing[f"{which} {piece.keyword.options[which]}"] = int(absent[0])
        return np.concatenate(parts)

    def _named(self, which: Which, name: str, piece: _Piece) -> IntArray:
        """Return the members of what a piece of a set names: a set, instance.set, instance.5."""
        at = which, key(name)
        if at in self._sets:
            orders = [one.order for one in self._sets[at]]
            if min(orders) < piece.order < max(orders):
                raise piece.keyword.error(
                    f"it is made of the set {name}, which grows afterwards; define {name} before"
                )
            return self.members(*at)
        outer, _, rest = name.partition(".")
        if rest and key(outer) in self.inner:
            scope, place = self.inner[key(outer)]
            if not rest.strip().isdecimal():
                return scope._named(which, rest, piece) + place[which]
            found, absent = scope._numbered(which, np.array([int(rest)]))
            if not len(absent):
                return found + place[which]
        why = ""
        if rest and key(outer) not in self.inner:
            why = f", and no instance {outer}; in a deck without parts give the numbers alone"
        raise piece.keyword.error(f"there is no {which} {name}{why}")

    def nodes_of(self, elements: IntArray, keyword: Keyword) -> IntArray:
        """Return the sorted numbers of the nodes of elements, both among those of all scopes.

        The keyword is the one that asks for them, for errors.
        """
        found = [np.zeros(0, dtype=np.int64)]
        for scope, place in self.inner.values():
            own = elements - place["ELSET"]
            own = own[(own >= 0) & (own < len(scope.element_labels))]
            found.append(scope.nodes_of(own, keyword) + place["NSET"])
        start = self.first["ELSET"]
        for block in self.elements:
            own = elements - start
            own = own[(own >= 0) & (own < len(block.labels))]
            if block.kind:
                found.append(block.nodes[own].ravel() + self.first["NSET"])
            elif len(own):
                raise keyword.error(f"nodes of elements of type {block.type} are not read")
            start += len(block.labels)
        return np.unique(np.concatenate(found))


def _found(known: IntArray, wanted: IntArray) -> tuple[IntArray, Any]:
    """Return the places of labels among ascending ones, and which of them are there."""
    if not len(known):
        return np.zeros_like(wanted), np.zeros(wanted.shape, dtype=bool)
    at = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return at, known[at] == wanted
