"""Nastran decks of a body, written in any way that the format allows."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

import numpy as np
import numpy.typing as npt

from aoimpact.mesh import reference_element

from .deckbody import Body, differences, draw, read

FloatArray = npt.NDArray[np.float64]

# A field: text as it stands, a decimal number with all its digits, or one with as many as fit.
Field = str | Decimal | float
Entry = list[Field]

_NAMES = {"tetra": "CTETRA", "hexahedron": "CHEXA", "wedge": "CPENTA", "pyramid": "CPYRAM"}

# Edges by their corners from 1, in the order of the nodes in their middles.
_EDGES = {
    "CTETRA": "12 23 31 14 24 34",
    "CPYRAM": "12 23 34 41 15 25 35 45",
    "CPENTA": "12 23 31 14 25 36 45 56 64",
    "CHEXA": "12 23 34 41 15 26 37 48 56 67 78 85",
}

# Corners in the other sense.
_MIRRORED = {
    "CTETRA": [0, 2, 1, 3],
    "CPYRAM": [0, 3, 2, 1, 4],
    "CPENTA": [0, 2, 1, 3, 5, 4],
    "CHEXA": [0, 3, 2, 1, 4, 7, 6, 5],
}

# Labels of nodes and elements that are no part of the body, and of the elements on its sides.
_SPARE, _SIDES = 99_999_100, 99_999_000

# Warnings that the decks call for.
_CALLED_FOR = ("belong to no volume element", "left out", "share no nodes")

_OTHERS: tuple[Entry, ...] = (
    ["MAT1", "1", "2.1+11", "", ".3", "7800."],
    ["PSOLID", "1", "1", "0"],
    ["SPC1", "1", "123", "1", "THRU", "4"],
    ["FORCE", "1", "1", "0", "1.", "0.", "0.", "1."],
    ["PARAM", "POST", "-1"],
    ["EIGRL", "1", "", "", "10"],
    ["TEMPD", "1", "20."],
    ["SPOINT", "99999990"],
    ["CONM2", "99999991", "1", "", "5.2"],
    ["CELAS2", "99999992", "1.+5", "1", "1"],
    ["RBE3", "99999993", "", "1", "123", "1.", "123", "2", "3"],
    ["TABLED1", "1", "", "", "", "", "", "", "", "0.", "0.", "1.", "1.", "ENDT"],
)


# ----------------------------------------------------------------------------------- contents


@dataclass(frozen=True)
class _System:
    """A coordinate system: its kind, "R", "C" or "S", origin, and axes in rows."""

    kind: str
    origin: FloatArray
    axes: FloatArray

    def local(self, place: FloatArray) -> list[float]:
        """Return the coordinates of a place, angles in degrees."""
        x, y, z = (float(c) for c in self.axes @ (place - self.origin))
        if self.kind == "R":
            return [x, y, z]
        rho, phi = math.hypot(x, y), math.degrees(math.atan2(y, x))
        if self.kind == "C":
            return [rho, phi, z]
        return [math.hypot(rho, z), math.degrees(math.atan2(rho, z)), phi]


@dataclass
class _Content:
    """Entries of a body, and the groups that a reader should find in them, by labels."""

    rng: random.Random
    body: Body
    entries: list[Entry] = field(default_factory=list)
    control: list[str] = field(default_factory=list)
    node_sets: dict[str, set[int]] = field(default_factory=dict)
    cell_sets: dict[str, set[int]] = field(default_factory=dict)
    systems: dict[int, _System] = field(default_factory=dict)
    exact: bool = True

    def __post_init__(self) -> None:
        mesh = self.body.mesh
        assert mesh.node_labels is not None
        assert mesh.cell_labels is not None
        self.nodes: list[int] = mesh.node_labels.tolist()
        self.cells: list[int] = mesh.cell_labels.tolist()
        self.mirrored = self.rng.choice((0.0, 0.0, 0.5, 1.0))  # share of elements
        self.members: dict[int, set[int]] = {}  # nodes by the label of the element
        if self.rng.random() < 0.6:
            for i in range(self.rng.randint(1, 4)):
                self._add_system(7 + i)
        self._add_grids()
        self._add_elements()
        self._add_sides()
        self._add_sets()
        self.entries += self.rng.sample(_OTHERS, self.rng.randint(0, len(_OTHERS)))

    def _add_system(self, label: int) -> None:
        """By three points in a system before it, or by three nodes."""
        rng = self.rng
        normal = np.array([rng.gauss(0, 1) for _ in range(6)]).reshape(2, 3)
        z = normal[0] / np.linalg.norm(normal[0])
        y = np.cross(z, normal[1])
        y /= np.linalg.norm(y)
        axes = np.stack([np.cross(y, z), y, z])
        origin = np.array([rng.uniform(-3, 3) for _ in range(3)])
        places = [origin, origin + rng.uniform(1, 3) * z]
        places.append(origin + rng.uniform(1, 3) * axes[0] + rng.uniform(-1, 1) * z)
        of = rng.choice([0, *self.systems])
        coordinates = [self._coordinates(of, place) for place in places]
        kind = rng.choice("RCS")
        if rng.random() < 0.5:
            numbers = [number for three in coordinates for number in three]
            self.entries.append([f"CORD2{kind}", str(label), str(of or ""), *numbers])
        else:
            nodes = [_SPARE + 3 * label + i for i in range(3)]
            for node, three in zip(nodes, coordinates, strict=True):
                self.entries.append(["GRID", str(node), str(of), *three])
            self.entries.append([f"CORD1{kind}", str(label), *map(str, nodes)])
        self.systems[label] = _System(kind, origin, axes)
        self.exact = False

    def _coordinates(self, system: int, place: FloatArray) -> list[Field]:
        if system:
            return list(self.systems[system].local(place))
        return list(map(float, place))

    def _add_grids(self) -> None:
        rng = self.rng
        default = rng.choice([0, *self.systems]) if rng.random() < 0.5 else 0
        for label, place in zip(self.nodes, self.body.mesh.nodes, strict=True):
            system = rng.choice([0, *self.systems])
            numbers = self._coordinates(system, place)
            if not system:
                numbers = [Decimal(f"{c:.3f}") for c in place]
            named = system != default or rng.random() < 0.5
            displaced = rng.choice(("", "", *map(str, self.systems)))
            self.entries.append(["GRID", str(label), str(system) if named else "", *numbers])
            self.entries[-1] += [displaced] if displaced else []
        last = self.entries[-1]
        if rng.random() < 0.2 and not any(isinstance(one, float) for one in last):
            self.entries.append(list(last))
        if default:
            self.entries.append(["GRDSET", "", str(default)])

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
            for label, cell in zip(self.cells[block.numbers], block.cells, strict=True):
                order = orders[self.rng.random() < self.mirrored]
                nodes = [self.nodes[node] for node in cell]
                number = part_of[label]
                self.entries.append(
                    [name, str(label), str(number), *(str(nodes[i]) for i in order)]
                )
                self.members[label] = set(nodes)
                self.cell_sets.setdefault(f"property {number}", set()).add(label)
                self.node_sets.setdefault(f"property {number}", set()).update(nodes)

    def _add_sides(self) -> None:
        """A triangle and a line on corners: groups of nodes by their properties."""
        corners = [self.nodes[node] for node in self.body.mesh.blocks[0].cells[0][:3]]
        for i, (names, count) in enumerate(((("CTRIA3", "CTRIAR"), 3), (("CBAR", "CROD"), 2))):
            if self.rng.random() < 0.5:
                nodes = corners[:count]
                self.entries.append(
                    [self.rng.choice(names), str(_SIDES + i), str(2000 + i), *map(str, nodes)]
                )
                self.members[_SIDES + i] = set(nodes)
                self.node_sets[f"property {2000 + i}"] = set(nodes)

    def _add_sets(self) -> None:
        sets = [(self.nodes, one) for one in self.body.node_sets]
        sets += [(self.cells, one) for one in self.body.element_sets]
        for number, (labels, wanted) in enumerate(sets, start=1):
            words = self._words(wanted, labels)
            kinds = ["nodes", "elements"]
            name = self.rng.choice(("SET", "SET1", "SET3"))
            if name == "SET":
                self.control += _wrapped(self.rng, f"SET {number} = ", words)
            elif name == "SET1":
                self.entries.append(["SET1", str(number), *words])
            else:
                kinds = ["nodes" if labels is self.nodes else "elements"]
                self.entries.append(
                    ["SET3", str(number), "GRID" if kinds == ["nodes"] else "ELEM", *words]
                )
            if "nodes" in kinds and (found := _meant(words, self.nodes)):
                self.node_sets[f"{name} {number} nodes"] = found
            if "elements" in kinds and (found := _meant(words, list(self.members))):
                group = f"{name} {number} elements"
                self.node_sets[group] = set().union(*(self.members[label] for label in found))
                self.cell_sets[group] = found.intersection(self.cells)
        self.cell_sets = {name: cells for name, cells in self.cell_sets.items() if cells}

    def _words(self, wanted: tuple[int, ...], labels: list[int]) -> list[str]:
        """Members in any order, or those that follow each other as ranges."""
        if self.rng.random() < 0.5:
            return [str(one) for one in wanted]
        ordered, runs = sorted(labels), []
        for one in sorted(wanted):
            place = ordered.index(one)
            if runs and runs[-1][-1] == place - 1:
                runs[-1].append(place)
            else:
                runs.append([place])
        words: list[str] = []
        for run in runs:
            members = [str(ordered[place]) for place in run]
            words += members if len(run) < 3 else [members[0], "THRU", members[-1]]
        return words


def _nastran_order(kind: str, name: str, mirrored: bool) -> list[int]:
    """Return meshio's numbers of an element's nodes in Nastran's order.

    Nastran goes round the sides of an element in either sense.
    """
    element = reference_element(kind)
    order = list(_MIRRORED[name] if mirrored else range(element.n_corners))
    corners = element.nodes[order]
    if element.quadratic:
        for one, other in _EDGES[name].split():
            middle = (corners[int(one) - 1] + corners[int(other) - 1]) / 2
            order.append(int(np.linalg.norm(element.nodes - middle, axis=1).argmin()))
    return order


def _meant(words: list[str], labels: list[int]) -> set[int]:
    """Return the labels that a set holds; none if one that it names is not there."""
    found: set[int] = set()
    i = 0
    while i < len(words):
        if words[i + 1 : i + 2] == ["THRU"]:
            first, last = int(words[i]), int(words[i + 2])
            found.update(label for label in labels if first <= label <= last)
            i += 3
        else:
            if int(words[i]) not in labels:
                return set()
            found.add(int(words[i]))
            i += 1
    return found


def _wrapped(rng: random.Random, head: str, words: list[str]) -> list[str]:
    """A line of the case control, which goes on after a comma."""
    text = ", ".join(words).replace(", THRU, ", " THRU ")
    lines = [head]
    for part in text.split(", "):
        if len(lines[-1]) > 8 and (len(lines[-1]) > 50 or rng.random() < 0.1):
            lines.append("   ")
        lines[-1] += part + ", "
    return [line.rstrip() for line in lines[:-1]] + [lines[-1].rstrip(", ")]


# -------------------------------------------------------------------------------------- style


@dataclass
class _Style:
    """Ways to write entries as lines."""

    rng: random.Random
    marks: int = 0

    def __post_init__(self) -> None:
        rng = self.rng
        self.forms = rng.sample(["small", "large", "free", "free large"], rng.randint(1, 4))
        self.joins = rng.sample(["blank", "plus", "named", "end"], rng.randint(1, 4))
        self.lower, self.tabs = rng.random() < 0.2, rng.random() < 0.2
        self.long = rng.choice((0.0, 0.0, 0.3))
        self.comments = rng.choice((0.0, 0.0, 0.1))

    def pieces(self, entry: Entry) -> list[list[str]]:
        """Return the lines of an entry, cut where a continuation has a mark of its own."""
        name, *fields = entry
        if "free" in self.forms and len(fields) > 9 and self.rng.random() < self.long:
            texts = [self.text(one, "free") for one in fields]
            if texts[8][:1] not in ("", "+", "*"):
                return [[self._cased(",".join([str(name), *texts]))]]
        groups = [fields[i : i + 8] for i in range(0, max(len(fields), 1), 8)]
        lines: list[tuple[str, list[str]]] = []  # form and fields
        for group in groups:
            form = self._form(group)
            texts = [self.text(one, form) for one in group]
            if form in ("small", "free"):
                lines.append((form, texts))
            else:
                lines.append((form, texts[:4]))
                if len(texts) > 4 or group is not groups[-1] or self.rng.random() < 0.3:
                    lines.append((form, texts[4:]))
        pieces: list[list[str]] = [[]]
        head = str(name)
        for i, (form, texts) in enumerate(lines):
            join = self.rng.choice(self.joins) if i + 1 < len(lines) else ""
            tail, following = self._join(join)
            pieces[-1].append(self._line(head, form, texts, tail))
            head = following
            if join == "named":
                pieces.append([])
        return [piece for piece in pieces if piece]

    def _form(self, group: list[Field]) -> str:
        form = self.rng.choice(self.forms)
        if form == "small" and any(isinstance(one, float) for one in group):
            return self.rng.choice(("large", "free", "free large"))
        return form

    def text(self, one: Field, form: str) -> str:
        """Return a field as text; numbers in any way that fits."""
        rng = self.rng
        if isinstance(one, str):
            return one
        if isinstance(one, float):
            if form == "large" or rng.random() < 0.5:
                return f"{one:.9E}".replace("E", rng.choice("ED"))
            return repr(one) if "e" not in repr(one) else repr(one).replace("e-", "-")
        if not one:
            return rng.choice(("", "0.", "0.0", "-0.", "0.+0"))
        plain = f"{one.normalize():f}"
        plain = plain if "." in plain else plain + "."
        shift = rng.choice((-1, 0, 1, 2))
        moved = f"{one.scaleb(-shift).normalize():f}"
        moved = moved if "." in moved else moved + "."
        ways = [plain, plain.replace("0.", ".", 1) if abs(one) < 1 else plain]
        ways += [f"{moved}{mark}{shift:+d}" for mark in ("", "E", "D")] + [f"{moved}E{shift}"]
        width = 8 if form == "small" else 16
        return rng.choice([way for way in ways if len(way) <= width])

    def _join(self, join: str) -> tuple[str, str]:
        """Return the marks at the end of a line and at the beginning of the next."""
        self.marks += 1
        mark = f"{self.marks:X}"
        return {
            "": ("", ""),
            "blank": ("", ""),
            "plus": ("+", "+"),
            "named": (f"+{mark}", f"+{mark}"),
            "end": (f"+{mark}", "+"),
        }[join]

    def _line(self, head: str, form: str, texts: list[str], tail: str) -> str:
        if form in ("large", "free large"):
            head = "*" + head[1:] if head[:1] in ("", "+") else head + "*"
        count, width = (4, 16) if form in ("large", "free large") else (8, 8)
        if form.startswith("free"):
            if tail:
                texts = texts + [""] * (count - len(texts)) + [tail]
            space = self.rng.choice(("", "", " "))
            return self._cased(("," + space).join([head, *texts]))
        columns = [
            one.ljust(width) if self.rng.random() < 0.7 else one.rjust(width) for one in texts
        ]
        if self.tabs and form == "small" and not tail and max(map(len, texts), default=0) < 8:
            return self._cased("\t".join([head, *texts]) if len(head) < 8 else head)
        columns = [head.ljust(8), *columns, *[" " * width] * (count - len(columns))]
        return self._cased("".join(columns) + tail if tail else "".join(columns).rstrip())

    def _cased(self, line: str) -> str:
        return line.lower() if self.lower else line

    def adorned(self, lines: list[str]) -> Iterator[str]:
        """Yield lines with comments at their ends and between them, and with blank lines."""
        for line in lines:
            if self.rng.random() < self.comments:
                yield self.rng.choice(("$ a comment, of GRID,1", "", "   ", "$", "$ für später"))
            yield line + " $ end" if self.rng.random() < self.comments else line


def _write(rng: random.Random, body: Body, folder: Path) -> tuple[Path, _Content]:
    content, style = _Content(rng, body), _Style(rng)
    entries = content.entries
    if rng.random() < 0.7:
        rng.shuffle(entries)
    pieces = [piece for entry in entries for piece in style.pieces(entry)]
    if rng.random() < 0.3:
        rng.shuffle(pieces)
    bulk = list(style.adorned([line for piece in pieces for line in piece]))
    control = []
    if content.control or rng.random() < 0.5:
        control = ["SOL 103", "CEND", "TITLE = A DECK, BEGIN TO END", *content.control]
        control = [style._cased(line) for line in control]
    begin = rng.choice(("BEGIN BULK", "begin bulk", "BEGIN  BULK $ now"))
    ending = rng.choice((["ENDDATA"], ["enddata", "GRID,1,7,nonsense"], []))
    files = {Path("deck.bdf"): [*control, begin, *_included(rng, bulk, folder), *ending]}
    if not control and rng.random() < 0.4:
        files[Path("deck.bdf")].remove(begin)
    file = folder / f"deck.{rng.choice(('bdf', 'nas', 'dat', 'fem', 'blk', 'BDF'))}"
    _save(rng, file, files[Path("deck.bdf")])
    return file, content


def _included(rng: random.Random, lines: list[str], folder: Path, depth: int = 0) -> list[str]:
    """Put some of the lines into files of their own, and those in turn."""
    if rng.random() < (0.6, 0.6, 1.0)[depth] or len(lines) < 3:
        return lines
    first, last = sorted(rng.sample(range(len(lines)), 2))
    name = rng.choice(("part", "a part", "sub/part")) + f"{depth}.inc"
    (folder / name).parent.mkdir(exist_ok=True)
    inner = _included(rng, lines[first:last], (folder / name).parent, depth + 1)
    _save(rng, folder / name, inner)
    quote = rng.choice("'\"")
    written = rng.choice((name, name.replace("/", "\\"))) if "/" in name else name
    statement = [f"{rng.choice(('INCLUDE', 'include'))} {quote}{written}{quote}"]
    if " " not in name and rng.random() < 0.3:
        statement = [f"INCLUDE {written}"]
    elif rng.random() < 0.2:
        statement = [f"INCLUDE {quote}{written[:3]}", f"{written[3:]}{quote}"]
    return [*lines[:first], *statement, *lines[last:]]


def _save(rng: random.Random, file: Path, lines: list[str]) -> None:
    end = rng.choice(("\n", "\n", "\r\n"))
    encoding = rng.choice(("utf-8", "latin-1", "utf-8-sig", "utf-16"))
    file.write_bytes((end.join(lines) + rng.choice(("", end))).encode(encoding))


# --------------------------------------------------------------------------------------- trying


def tried(seed: int, number: int, folder: Path) -> str:
    """Write a deck, read it, and return the differences; none if it is read as it was meant."""
    rng = random.Random(f"{seed} nastran {number}")
    file, content = _write(rng, draw(rng), folder)
    mesh = read(file, None, _CALLED_FOR)
    if isinstance(mesh, str):
        return mesh
    return differences(
        content.body,
        mesh,
        content.node_sets,
        content.cell_sets,
        tolerance=0.0 if content.exact else 1e-7,  # of ten digits, one system in the other
    )
