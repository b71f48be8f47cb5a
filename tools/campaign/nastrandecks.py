"""Nastran decks of a body, written in any way that the format allows."""

from __future__ import annotations

import random
from collections.abc import Iterable
from decimal import Decimal
from pathlib import Path

import numpy as np

from aoimpact.mesh import reference_element

from .deckbody import Body, Dialect, Drawn, Expected, System, runs, trials
from .outcome import FloatArray

# A field: text or an integer, a Decimal to be written with all digits, or a float with the digits
# that fit.
Field = str | int | Decimal | float
Entry = list[Field]

_NAMES = {"tetra": "CTETRA", "hexahedron": "CHEXA", "wedge": "CPENTA", "pyramid": "CPYRAM"}

# Edges by their corners, from 1, in Nastran's order of midside nodes; and the order of corners,
# from 0, that numbers the element in the opposite sense.
_ORDERS = {
    "CTETRA": ("12 23 31 14 24 34", "0213"),
    "CPYRAM": ("12 23 34 41 15 25 35 45", "03214"),
    "CPENTA": ("12 23 31 14 25 36 45 56 64", "021354"),
    "CHEXA": ("12 23 34 41 15 26 37 48 56 67 78 85", "03214765"),
}

# First labels of nodes and elements that are no part of the body, and of elements on its sides.
_SPARE, _SIDES = 99_999_100, 99_999_000

# Words of the warnings that the decks may cause.
_CALLED_FOR = ("belong to no element", "left out", "share no nodes")

# Entries without influence on the mesh.
_OTHERS = """
MAT1,1,2.1+11,,.3,7800.
PSOLID,1,1,0
SPC1,1,123,1,THRU,4
FORCE,1,1,0,1.,0.,0.,1.
PARAM,POST,-1
EIGRL,1,,,10
TEMPD,1,20.
SPOINT,99999990
CONM2,99999991,1,,5.2
CELAS2,99999992,1.+5,1,1
RBE3,99999993,,1,123,1.,123,2,3
TABLED1,1,,,,,,,,0.,0.,1.,1.,ENDT
"""


# ----------------------------------------------------------------------------------- contents


def _include(rng: random.Random, name: str) -> str:
    """Return a statement that includes a file, whose name may be quoted and cut in two."""
    quote = rng.choice("'\"")
    written = rng.choice((name, name.replace("/", "\\")))
    if " " not in name and rng.random() < 0.3:
        return f"INCLUDE {name}"
    if "/" not in name and rng.random() < 0.2:
        return f"INCLUDE {quote}{name[:3]}\n{name[3:]}{quote}"
    return f"{rng.choice(('INCLUDE', 'include'))} {quote}{written}{quote}"


_DIALECT = Dialect(
    ("$ a comment, of GRID,1", "", "   ", "$", "$ für später"), _include, nested=True
)


class _Content(Drawn):
    """Entries of a deck of a body, and the groups to be read."""

    def __init__(self, rng: random.Random, body: Body) -> None:
        super().__init__(rng)
        self.body, self.entries, self.control = body, list[Entry](), list[str]()
        self.systems = {}
        self.mirrored = rng.choice((0.0, 0.0, 0.5, 1.0))  # share of elements of opposite sense
        self.members = dict(self.body.members)  # labels of nodes by element
        if self.chance(0.6):
            for i in range(rng.randint(1, 4)):
                self._add_system(7 + i)
        self._add_grids()
        self._add_elements()
        self._add_sides()
        self._add_sets()
        others = _OTHERS.split()
        self.entries += [one.split(",") for one in rng.sample(others, rng.randint(0, len(others)))]

    def _add_system(self, label: int) -> None:
        """Add a coordinate system by three points in an earlier system, or by three nodes."""
        rng = self.rng
        system = System.drawn(rng, rng.choice("RCS"))
        (x, _, z), origin, kind = system.axes, system.origin, system.kind
        places = [origin, origin + rng.uniform(1, 3) * z]
        places.append(origin + rng.uniform(1, 3) * x + rng.uniform(-1, 1) * z)
        of = rng.choice([0, *self.systems])
        coordinates = [self._coordinates(of, place) for place in places]
        if self.chance(0.5):
            numbers = [number for three in coordinates for number in three]
            self.entries.append([f"CORD2{kind}", label, of or "", *numbers])
        else:
            nodes = [_SPARE + 3 * label + i for i in range(3)]
            for node, three in zip(nodes, coordinates, strict=True):
                self.entries.append(["GRID", node, of, *three])
            self.entries.append([f"CORD1{kind}", label, *nodes])
        self.systems[label] = system

    def _coordinates(self, system: int, place: FloatArray) -> list[Field]:
        local = self.systems[system].local(place[None])[0] if system else place
        return list(local.tolist())

    def _add_grids(self) -> None:
        rng = self.rng
        default = rng.choice([0, *self.systems]) if self.chance(0.5) else 0
        for label, place in zip(self.body.nodes, self.body.mesh.nodes, strict=True):
            system = rng.choice([0, *self.systems])
            numbers = self._coordinates(system, place)
            if not system:
                numbers = [Decimal(f"{c:.3f}") for c in place]
            named = system != default or self.chance(0.5)
            displaced = rng.choice(([], [], *([one] for one in self.systems)))
            self.entries.append(["GRID", label, system if named else "", *numbers, *displaced])
        last = self.entries[-1]
        if self.chance(0.2) and not any(isinstance(one, float) for one in last):
            self.entries.append(list(last))
        if default:
            self.entries.append(["GRDSET", "", default])

    def _add_elements(self) -> None:
        numbers = self.rng.sample(range(1, 1000), len(self.body.parts))
        part_of = {
            label: number
            for number, part in zip(numbers, self.body.parts, strict=True)
            for label in part
        }
        for block in self.body.mesh.blocks:
            name = _NAMES[block.kind.rstrip("0123456789")]
            orders = [_nastran_order(block.kind, name, mirrored) for mirrored in (False, True)]
            for label, cell in zip(self.body.cells[block.numbers], block.cells, strict=True):
                order = orders[self.chance(self.mirrored)]
                nodes = [self.body.nodes[cell[i]] for i in order]
                self.entries.append([name, label, part_of[label], *nodes])
        for number, part in zip(numbers, self.body.parts, strict=True):
            self.cell_sets[f"property {number}"] = set(part)
            self.node_sets[f"property {number}"] = self.body.nodes_of(part)

    def _add_sides(self) -> None:
        """Add a triangle and a line on corners, whose properties are groups of nodes."""
        corners = [self.body.nodes[node] for node in self.body.mesh.blocks[0].cells[0][:3]]
        for i, (names, count) in enumerate(((("CTRIA3", "CTRIAR"), 3), (("CBAR", "CROD"), 2))):
            if self.chance(0.5):
                nodes = corners[:count]
                self.entries.append([self.pick(names), _SIDES + i, 2000 + i, *nodes])
                self.members[_SIDES + i] = set(nodes)
                self.node_sets[f"property {2000 + i}"] = set(nodes)

    def _add_sets(self) -> None:
        body = self.body
        sets = [("GRID", one) for one in body.node_sets]
        sets += [("ELEM", one) for one in body.element_sets]
        for number, (what, wanted) in enumerate(sets, start=1):
            labels, name = (
                body.nodes if what == "GRID" else body.cells,
                self.pick(("SET", "SET1", "SET3")),
            )
            spans = [(one, one) for one in wanted]
            if self.chance(0.5):
                spans = [(run[0], run[-1]) for run in runs(wanted, labels)]
            words: list[Field] = []
            for first, last in spans:
                words += [first] if first == last else [first, "THRU", last]
            if name == "SET":
                self.control += _wrapped(self.rng, f"SET {number} = ", words)
            else:
                self.entries.append([name, number, *([what] if name == "SET3" else []), *words])
            if (name != "SET3" or what == "GRID") and (found := _meant(spans, body.nodes)):
                self.node_sets[f"{name} {number} nodes"] = found
            if (name != "SET3" or what == "ELEM") and (found := _meant(spans, self.members)):
                group = f"{name} {number} elements"
                self.node_sets[group] = set().union(*(self.members[label] for label in found))
                self.cell_sets[group] = found.intersection(body.cells)
        self.cell_sets = {name: cells for name, cells in self.cell_sets.items() if cells}


def _nastran_order(kind: str, name: str, mirrored: bool) -> list[int]:
    """Return meshio's numbers of an element's nodes in Nastran's order.

    Nastran allows both senses of numbering around the sides; `mirrored` is the opposite one.
    """
    element = reference_element(kind)
    edges, other = _ORDERS[name]
    order = [*map(int, other)] if mirrored else list(range(element.n_corners))
    corners = element.nodes[order]
    if element.quadratic:
        for one, other in edges.split():
            middle = (corners[int(one) - 1] + corners[int(other) - 1]) / 2
            order.append(int(np.linalg.norm(element.nodes - middle, axis=1).argmin()))
    return order


def _meant(spans: list[tuple[int, int]], labels: Iterable[int]) -> set[int]:
    """Return the labels that a set holds, or none if it names a single label that is missing."""
    there = set(labels)
    if any(first == last and first not in there for first, last in spans):
        return set()
    return {one for one in there if any(first <= one <= last for first, last in spans)}


def _wrapped(rng: random.Random, head: str, words: list[Field]) -> list[str]:
    """Return a line of the case control, continued on further lines after commas."""
    text = ", ".join(map(str, words)).replace(", THRU, ", " THRU ")
    lines = [head]
    for part in text.split(", "):
        if len(lines[-1]) > 8 and (len(lines[-1]) > 50 or rng.random() < 0.1):
            lines.append("   ")
        lines[-1] += part + ", "
    return [line.rstrip() for line in lines[:-1]] + [lines[-1].rstrip(", ")]


# -------------------------------------------------------------------------------------- style


class _Style(Drawn):
    """Random style in which entries are written as lines."""

    def __init__(self, rng: random.Random) -> None:
        super().__init__(rng)
        self.marks = 0
        self.forms = rng.sample(["small", "large", "free", "free large"], rng.randint(1, 4))
        self.joins = rng.sample(["blank", "plus", "named", "end"], rng.randint(1, 4))
        self.tabs = self.chance(0.2)
        self.long = rng.choice((0.0, 0.0, 0.3))

    def pieces(self, entry: Entry) -> list[list[str]]:
        """Return the lines of an entry in pieces, cut at continuations with named marks."""
        name, *fields = entry
        if "free" in self.forms and len(fields) > 9 and self.chance(self.long):
            texts = [self.text(one, "free") for one in fields]
            if texts[8][:1] not in ("", "+", "*"):
                return [[",".join([str(name), *texts])]]
        groups = [fields[i : i + 8] for i in range(0, max(len(fields), 1), 8)]
        lines: list[tuple[str, list[str]]] = []  # form and fields
        for group in groups:
            form = self._form(group)
            texts = [self.text(one, form) for one in group]
            if form in ("small", "free"):
                lines.append((form, texts))
            else:
                lines.append((form, texts[:4]))
                if len(texts) > 4 or group is not groups[-1] or self.chance(0.3):
                    lines.append((form, texts[4:]))
        pieces: list[list[str]] = [[]]
        head = str(name)
        for i, (form, texts) in enumerate(lines):
            join = self.pick(self.joins) if i + 1 < len(lines) else ""
            tail, following = self._join(join)
            pieces[-1].append(self._line(head, form, texts, tail))
            head = following
            if join == "named":
                pieces.append([])
        return [piece for piece in pieces if piece]

    def _form(self, group: list[Field]) -> str:
        form = self.pick(self.forms)
        if form == "small" and any(isinstance(one, float) for one in group):
            return self.pick(("large", "free", "free large"))
        return form

    def text(self, one: Field, form: str) -> str:
        """Return a field as text, with numbers written in any way that fits."""
        rng = self.rng
        if isinstance(one, (str, int)):
            return str(one)
        if isinstance(one, float):
            if form == "large" or self.chance(0.5):
                return f"{one:.9E}".replace("E", rng.choice("ED"))
            return repr(one) if "e" not in repr(one) else repr(one).replace("e-", "-")
        if not one:
            return rng.choice(("", "0.", "0.0", "-0.", "0.+0"))
        shift = rng.choice((-1, 0, 1, 2))
        plain, moved = (
            (text if "." in text else text + ".")
            for text in (f"{number.normalize():f}" for number in (one, one.scaleb(-shift)))
        )
        ways = [plain, plain.replace("0.", ".", 1) if abs(one) < 1 else plain, f"{moved}E{shift}"]
        ways += [f"{moved}{mark}{shift:+d}" for mark in ("", "E", "D")]
        width = 8 if form == "small" else 16
        return rng.choice([way for way in ways if len(way) <= width])

    def _join(self, join: str) -> tuple[str, str]:
        """Return the continuation marks at the end of a line and the beginning of the next."""
        self.marks += 1
        own = f"+{self.marks:X}"
        following = {"plus": "+", "named": own, "end": "+"}.get(join, "")
        return following if join != "end" else own, following

    def _line(self, head: str, form: str, texts: list[str], tail: str) -> str:
        if form in ("large", "free large"):
            head = "*" + head[1:] if head[:1] in ("", "+") else head + "*"
        count, width = (4, 16) if form in ("large", "free large") else (8, 8)
        if form.startswith("free"):
            if tail:
                texts = texts + [""] * (count - len(texts)) + [tail]
            space = self.pick(("", "", " "))
            return ("," + space).join([head, *texts])
        columns = [one.ljust(width) if self.chance(0.7) else one.rjust(width) for one in texts]
        if self.tabs and form == "small" and not tail and max(map(len, texts), default=0) < 8:
            return "\t".join([head, *texts]) if len(head) < 8 else head
        columns = [head.ljust(8), *columns, *[" " * width] * (count - len(columns))]
        return "".join(columns) + tail if tail else "".join(columns).rstrip()


def _written(rng: random.Random, body: Body, folder: Path) -> tuple[Path, list[Expected]]:
    content, style = _Content(rng, body), _Style(rng)
    entries = content.entries
    if rng.random() < 0.7:
        rng.shuffle(entries)
    pieces = [piece for entry in entries for piece in style.pieces(entry)]
    if rng.random() < 0.3:
        rng.shuffle(pieces)
    ends = rng.choice(([""], [""], [*9 * [""], " $ end"]))
    bulk = [line + rng.choice(ends) for piece in pieces for line in piece]
    control = []
    if content.control or rng.random() < 0.5:
        control = ["SOL 103", "CEND", "TITLE = A DECK, BEGIN TO END", *content.control]
    begin = [rng.choice(("BEGIN BULK", "begin bulk", "BEGIN  BULK $ now"))]
    if not control and rng.random() < 0.4:
        begin = []
    ending = rng.choice((["ENDDATA"], ["enddata", "GRID,1,7,nonsense"], []))
    name = f"deck.{rng.choice(('bdf', 'nas', 'dat', 'fem', 'blk', 'BDF'))}"
    lines = [*control, *begin, *bulk, *ending]
    if rng.random() < 0.2:
        lines = [line.lower() for line in lines]
    file = _DIALECT.stored(rng, folder, name, lines)
    tolerance = 1e-7 if content.systems else 0.0  # ten digits, in nested coordinate systems
    sets = content.node_sets, content.cell_sets
    return file, [Expected(body.mesh.nodes, *sets, tolerance)]


trial = trials("nastran", _written, _CALLED_FOR)
