"""Abaqus decks of a body, written in any way that the format allows."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

import aoimpact as ao

from .deckbody import Body, differences, draw, read

FloatArray = npt.NDArray[np.float64]

# Keywords and data lines that stay together, in this order; a keyword may take several lines.
Unit = list[str]

_TYPES = {
    "tetra": ("C3D4", "C3D4H", "C3D4T"),
    "pyramid": ("C3D5",),
    "wedge": ("C3D6", "C3D6T"),
    "hexahedron": ("C3D8", "C3D8R", "C3D8I", "C3D8T", "c3d8rt", "C3D8S"),
    "tetra10": ("C3D10", "C3D10M", "C3D10HS"),
    "pyramid13": ("C3D13",),
    "wedge15": ("C3D15",),
    "hexahedron20": ("C3D20", "C3D20R", "C3D20RH"),
}

# Keywords without influence on the mesh.
_OTHERS: tuple[Unit, ...] = (
    ["*HEADING", "plate, 3 x 2 and a * in the text", "second line"],
    ["*MATERIAL, NAME=STEEL", "*ELASTIC", "210000., 0.3", "*DENSITY", "7.8E-9"],
    ["*SOLID SECTION, ELSET=NOWHERE, MATERIAL=STEEL", ","],
    ["*SURFACE, TYPE=ELEMENT, NAME=S1", "NOWHERE, S3"],
    ["*AMPLITUDE, NAME=A", "0., 0., 1., 1.", "2., 0."],
    ["*STEP, NLGEOM", "*STATIC", "0.1, 1.", "*BOUNDARY,", "1, 1, 3", "*END STEP"],
    ["*NODE PRINT", "U", "*EL FILE", "S"],
    ["*Node Output", "U, V", "*Element Output, directions=YES", "S, E"],
    ["*RIGID BODY, REF NODE=1, ELSET=NOWHERE"],
    ["*PREPRINT, echo=NO, model=NO"],
    ["*TRANSFORM, NSET=NOWHERE", "1., 0., 0., 0., 1., 0."],
)  # fmt: skip

# Warnings that the decks call for.
_CALLED_FOR = (
    *("belong to no volume element", "no solids", "share no nodes", "at the same place"),
    "connections between nodes",
)

# Labels from here on are of nodes and elements that are no part of the body.
_SPARE = 200_000_000


@dataclass
class _Writer:
    """Lines of a deck, and the groups that a reader should find, by labels.

    Names of groups are in capitals, as Abaqus compares them.
    """

    rng: random.Random
    exact: bool = True
    node_sets: dict[str, set[int]] = field(default_factory=dict)
    cell_sets: dict[str, set[int]] = field(default_factory=dict)
    names: int = 0

    # ------------------------------------------------------------------------ how it looks

    def keyword(self, name: str, *options: str) -> str:
        """Return a keyword with its options, in any order, case and number of lines."""
        parts = [name, *self.rng.sample(options, len(options))]
        if self.rng.random() < 0.5:
            case = self.rng.choice((str.lower, str.title, str.upper))
            parts = [part if '"' in part or "." in part else case(part) for part in parts]
        text = parts[0]
        for part in parts[1:]:
            text += self.rng.choice((",", ", ", " ,  ", ",\n", ", \n** a comment\n  "))
            text += part.replace("=", self.rng.choice(("=", " = ")), 1)
        return text

    def row(self, fields: Iterable[object], *, end: bool = True) -> str:
        """Return a data line, perhaps with blanks and a comma at its end."""
        comma = self.rng.choice((",", ", ", " , ", ",\t"))
        last = self.rng.choice(("", "", "", ",", " ")) if end else ""
        return self.rng.choice(("", "", "   ")) + comma.join(map(str, fields)) + last

    def number(self, value: float) -> str:
        """Return a number with all of its digits."""
        if value == int(value) and self.rng.random() < 0.5:
            return (
                self.rng.choice(("{}.", "{}", "{}.0", "{}.D0", "+{}."))
                .format(int(value))
                .replace("+-", "-")
            )
        style = self.rng.choice(("{!r}", "{:.17g}", "{:.16E}", "{:.16e}", "D"))
        return f"{value:.16E}".replace("E", "D") if style == "D" else style.format(value)

    def name(self) -> str:
        self.names += 1
        return self.rng.choice((f"SET-{self.names}", f"_S{self.names}", f'"A, B {self.names}"'))

    # -------------------------------------------------------------------------- the body

    def nodes(self, labels: Sequence[int], places: FloatArray) -> list[Unit]:
        """Return blocks of nodes, some of them in systems of their own."""
        units = []
        for part in self.parts(range(len(labels))):
            unit: Unit = []
            local = places[part]
            if self.rng.random() < 0.3:
                origin = np.array([self.rng.uniform(-2, 2) for _ in range(3)])
                turn = Rotation.from_rotvec([self.rng.uniform(-3, 3) for _ in range(3)]).as_matrix()
                if self.rng.random() < 0.3:
                    turn = np.eye(3)
                points = [origin, origin + 2 * turn[0], origin + 0.5 * turn[0] + 3 * turn[1]]
                values = [[self.number(float(x)) for x in point] for point in points]
                lines = [self.row(values[0] + values[1]), self.row(values[2])]
                if (turn == np.eye(3)).all():
                    lines = [self.row(values[0])]
                unit += [self.keyword("*SYSTEM"), *lines]
                local = (local - origin) @ turn.T
                self.exact = False
            system = self.rng.choice("RRRCS")
            if system != "R":
                local = _curved(system, local)
                self.exact = False
            options = [f"SYSTEM={system}"] if system != "R" or self.rng.random() < 0.2 else []
            if self.rng.random() < 0.2:
                name = self.name()
                options.append(f"NSET={name}")
                self.node_sets[_key(name)] = {labels[i] for i in part}
            rows = []
            for i, place in zip(part, local.tolist(), strict=True):
                texts = [
                    "" if x == 0.0 and self.rng.random() < 0.3 else self.number(x) for x in place
                ]
                if place[2] == 0.0 and self.rng.random() < 0.3:
                    texts = texts[:2]
                rows.append(self.row([labels[i], *texts]))
            back = ["*SYSTEM"] if unit else []
            units.append([*unit, self.keyword("*NODE", *options), *rows, *back])
        return units

    def elements(self, body: Body) -> list[Unit]:
        """Return blocks of elements, and the groups of which they are parts."""
        mesh, units = body.mesh, []
        group = {label: number for number, part in enumerate(body.parts) for label in part}
        names = {number: self.name() for number in range(len(body.parts))}
        by_block = self.rng.random() < 0.6
        for block in mesh.blocks:
            labels = _labels(mesh.cell_labels)[block.numbers]
            for part in self.parts(range(len(labels))):
                chosen: dict[int, list[int]] = {}
                for i in part:
                    chosen.setdefault(group[int(labels[i])] if by_block else -1, []).append(i)
                for number, own in chosen.items():
                    kind = self.rng.choice(_TYPES[block.kind])
                    options = [f"TYPE={kind}", *([f"ELSET={names[number]}"] if by_block else [])]
                    rows = []
                    for i in own:
                        nodes = _labels(mesh.node_labels)[block.cells[i]].tolist()
                        rows += self.broken([int(labels[i]), *nodes])
                    units.append([self.keyword("*ELEMENT", *options), *rows])
        for number, part in enumerate(body.parts):
            if by_block:
                self.cell_sets[_key(names[number])] = set(part)
            else:
                units += self.group(
                    "ELSET", names[number], part, _labels(mesh.cell_labels).tolist()
                )
        return units

    def broken(self, numbers: list[int]) -> Unit:
        """Return an element in one line or in several."""
        if self.rng.random() < 0.6 and len(numbers) <= 16:
            return [self.row(numbers)]
        cut = self.rng.randint(1, min(15, len(numbers) - 1))
        rest = self.broken(numbers[cut:]) if len(numbers[cut:]) > 1 else [self.row(numbers[cut:])]
        return [self.row(numbers[:cut], end=False) + ",", *rest]

    # ------------------------------------------------------------------------------- sets

    def group(
        self, which: str, name: str, members: Iterable[int], every: list[int], *also: str
    ) -> list[Unit]:
        """Return a set, in one of the ways to write it."""
        wanted = set(members)
        sets = self.node_sets if which == "NSET" else self.cell_sets
        sets[_key(name)] = wanted
        listed = self.rng.sample(sorted(wanted), len(wanted))
        option = [f"{which}={name}", *also, *self.rng.choice(([], ["INTERNAL"], ["UNSORTED"]))]
        way = self.rng.choice(("pieces", "generate", "nested"))
        if way == "generate":
            rows = self.rng.sample(self.ranges(wanted, every), len(self.ranges(wanted, every)))
            cut = self.rng.randint(0, len(rows))
            return [
                [self.keyword(f"*{which}", *option, "GENERATE"), *some]
                for some in (rows[:cut], rows[cut:])
                if some
            ]
        if way == "nested" and not also and len(listed) > 1:
            cut = self.rng.randint(1, len(listed) - 1)
            inner = [(self.name(), listed[:cut]), (self.name(), listed[cut:])]
            units = []
            for other, some in inner[: self.rng.randint(1, 2)]:
                sets[_key(other)] = set(some)
                units.append([self.keyword(f"*{which}", f"{which}={other}"), *self.lines(some)])
            mine = [other for other, _ in inner[: len(units)]]
            rest = [] if len(units) == 2 else inner[1][1]
            whole = [self.keyword(f"*{which}", *option), *self.lines([*mine, *rest])]
            return [_flat(self.rng.choice(([*units, whole], [whole, *units])))]
        return [
            [self.keyword(f"*{which}", *option), *self.lines([listed[i] for i in part])]
            for part in self.parts(range(len(listed)))
        ]

    def lines(self, members: Sequence[object]) -> Unit:
        step = self.rng.randint(1, 16)
        return [self.row(members[i : i + step]) for i in range(0, len(members), step)]

    def ranges(self, wanted: set[int], every: list[int]) -> Unit:
        """Return rows of GENERATE; numbers between that nothing has are passed over."""
        rows, run = [], []
        for label in [*sorted(every), -1]:
            if label in wanted:
                run.append(label)
            elif run:
                rows.append([run[0], run[-1], *self.rng.choice(([], [1]))])
                run = []
        return [self.row(row) for row in rows]

    def parts(self, numbers: range) -> list[list[int]]:
        """Return numbers in some parts, each in any order."""
        shuffled = self.rng.sample(numbers, len(numbers))
        cuts = sorted(self.rng.randint(0, len(numbers)) for _ in range(self.rng.randint(0, 2)))
        bounds = [0, *cuts, len(numbers)]
        return [shuffled[a:b] for a, b in pairwise(bounds) if a < b]

    def others(self, body: Body) -> list[Unit]:
        """Return elements that are no solids, nodes of no element, and other keywords."""
        units = [list(unit) for unit in self.rng.sample(_OTHERS, self.rng.randint(0, 4))]
        nodes = [int(n) for n in _labels(body.mesh.node_labels)[:4]]
        if self.rng.random() < 0.3:
            units.append(["*ELEMENT, TYPE=MASS, ELSET=M", f"{_SPARE}, {nodes[0]}"])
        if self.rng.random() < 0.3:
            units.append(["*ELEMENT,TYPE=SPRINGA", f"{_SPARE + 1}, {nodes[0]}, {nodes[1]}"])
        if self.rng.random() < 0.3:
            units.append(
                ["*ELEMENT,TYPE=S4R, ELSET=SHELL", ",".join(map(str, [_SPARE + 2, *nodes]))]
            )
            self.node_sets["SHELL"] = set(nodes)
        if self.rng.random() < 0.3:
            units.append(["*NODE", f"{_SPARE}, 5., 5., 5."])
        return units


def _flat(units: Iterable[Unit]) -> Unit:
    return [line for unit in units for line in unit]


def _labels(labels: npt.NDArray[np.int64] | None) -> npt.NDArray[np.int64]:
    assert labels is not None
    return labels


def _remade(mesh: ao.Mesh, nodes: FloatArray, **sets: dict[str, npt.NDArray[np.int64]]) -> ao.Mesh:
    """Return the mesh with its nodes elsewhere, and with other groups."""
    blocks = [(block.kind, block.cells) for block in mesh.blocks]
    labels = {"node_labels": mesh.node_labels, "cell_labels": mesh.cell_labels}
    return ao.Mesh(nodes, blocks, **labels, **sets)  # type: ignore[arg-type]


def _key(name: str) -> str:
    return name.strip('"').upper()


def _curved(system: str, places: FloatArray) -> FloatArray:
    """Return cylindrical or spherical coordinates, angles in degrees."""
    x, y, z = places.T
    radius, turn = np.hypot(x, y), np.degrees(np.arctan2(y, x))
    if system == "C":
        return np.column_stack([radius, turn, z])
    return np.column_stack([np.hypot(radius, z), turn, np.degrees(np.arctan2(z, radius))])


# ------------------------------------------------------------------------------ whole decks


@dataclass(frozen=True)
class _Placement:
    """Translation of an instance, and the rotation after it."""

    shift: FloatArray
    axis: FloatArray
    angle: float

    @classmethod
    def drawn(cls, rng: random.Random) -> _Placement:
        def some() -> FloatArray:
            return np.array([round(rng.uniform(-2, 2), 3) for _ in range(3)])

        angle = rng.choice((0.0, 90.0, rng.uniform(-180, 180)))
        return cls(some() * rng.choice((0, 1, 1)), np.array([some(), some()]), angle)

    def lines(self, writer: _Writer) -> Unit:
        numbers = [*self.axis.ravel(), self.angle]
        rows = [self.shift, numbers] if self.angle else [self.shift] if self.shift.any() else []
        return [writer.row([writer.number(float(x)) for x in row]) for row in rows]

    def __call__(self, places: FloatArray) -> FloatArray:
        return self.turn(places + self.shift, 1.0)

    def before(self, places: FloatArray) -> FloatArray:
        return self.turn(places, -1.0) - self.shift

    def turn(self, places: FloatArray, sense: float) -> FloatArray:
        start, end = self.axis
        along = (end - start) / np.linalg.norm(end - start)
        v, angle = places - start, sense * math.radians(self.angle)
        turned = v * math.cos(angle) + np.cross(along, v) * math.sin(angle)
        return start + turned + np.outer(v @ along, along) * (1.0 - math.cos(angle))


def _write(rng: random.Random, folder: Path) -> tuple[Path, list[tuple[str, Body, _Writer]]]:
    """Write a deck, and return the bodies that should be read: by part, or by "" as a whole."""
    writer = _Writer(rng)
    placed = [_Placement.drawn(rng) for _ in range(2)]
    style = rng.choice(("flat", "flat", "flat", "parts", "instance", "within", "two"))
    moved = style in ("instance", "within", "two")
    body = draw(rng)
    places = body.mesh.nodes
    if moved:
        writer.exact = False
        places = placed[0].before(places)
    units = writer.nodes(_labels(body.mesh.node_labels).tolist(), places)
    units += writer.elements(body)
    nodes, cells = (_labels(x).tolist() for x in (body.mesh.node_labels, body.mesh.cell_labels))
    outer: list[Unit] = []
    for which, groups, every in (
        ("NSET", body.node_sets, nodes),
        ("ELSET", body.element_sets, cells),
    ):
        for members in groups:
            name = writer.name()
            if style in ("instance", "within") and rng.random() < 0.5:
                outer += writer.group(which, name, members, every, "INSTANCE=I-1")
            else:
                units += writer.group(which, name, members, every)
    outside = {_key(_option(unit[0])) for unit in outer}
    last: Unit = []
    name = rng.choice(sorted(set(writer.cell_sets) - outside))
    if rng.random() < 0.3 and "," not in name:  # after all of its pieces
        last = [writer.keyword("*NSET", "NSET=OF-ELEMENTS", f"ELSET={name}")]
        writer.node_sets["OF-ELEMENTS"] = _nodes_of(body, writer.cell_sets)[name]
    others = writer.others(body)
    rng.shuffle(outer)
    inner_sets = (
        {k: set(v) for k, v in writer.node_sets.items()},
        {k: set(v) for k, v in writer.cell_sets.items()},
    )
    own = [
        unit
        for unit in others
        if unit[0].upper().startswith(("*ELEMENT,", "*NODE")) and "OUTPUT" not in unit[0].upper()
    ]
    model = [unit for unit in others if unit not in own]
    units += own
    if style == "flat":
        units += model
    rng.shuffle(units)
    lines = [*_flat(units), *last]
    if style == "flat":
        return _stored(rng, folder, lines), [("", body, writer)]
    lines = _assembled(rng, writer, style, lines, outer, model, placed)
    names = ["BAR"] if style == "parts" else ["I-1", "I-2"] if style == "two" else ["I-1"]
    expected = []
    for i, instance in enumerate(names):
        mesh = body.mesh
        if i == 1:
            mesh = _remade(mesh, placed[1](placed[0].before(mesh.nodes)))
        sets, groups = (
            _of_instance(instance, those, outside, alone=len(names) == 1) for those in inner_sets
        )
        said = replace(writer, node_sets=sets, cell_sets=groups | {instance: set(cells)})
        expected.append((instance if len(names) > 1 else "", replace(body, mesh=mesh), said))
    return _stored(rng, folder, lines), expected


def _of_instance(
    instance: str, sets: dict[str, set[int]], outside: set[str], *, alone: bool
) -> dict[str, set[int]]:
    """Return sets by the names that a reader finds: those within an instance have its name."""
    found = {}
    for name, members in sets.items():
        if name not in outside:
            found[f"{instance}.{name}"] = members
        if name in outside or alone:
            found[name] = members
    return found


def _option(keyword: str) -> str:
    """Return the name of the set that a keyword defines."""
    parts = keyword.replace("\n", " ").replace("** a comment", " ")
    for which in ("NSET", "ELSET"):
        if parts.upper().startswith(f"*{which}"):
            at = parts.upper().index(which, 5)
            value = parts[at + len(which) :].strip().lstrip("=").strip()
            return (
                value[: value.index('"', 1) + 1] if value[0] == '"' else value.split(",")[0].strip()
            )
    raise ValueError(keyword)


def _assembled(
    rng: random.Random,
    writer: _Writer,
    style: str,
    lines: Unit,
    outer: list[Unit],
    model: list[Unit],
    placed: list[_Placement],
) -> Unit:
    """Put the lines of a part into a part, an instance, or a part of two instances."""
    keyword = writer.keyword
    before, after = model[: len(model) // 2], model[len(model) // 2 :]
    if style == "within":
        part = [keyword("*PART", "NAME=BAR"), "*End Part"]
        inside = lines
    else:
        part, inside = [keyword("*PART", "NAME=BAR"), *lines, "*END PART"], []
    if style == "parts":
        return [*_flat(before), *part, *_flat(after)]
    instances = []
    for number in range(2 if style == "two" else 1):
        head = keyword("*INSTANCE", f"NAME=I-{number + 1}", "PART=BAR")
        instances += [head, *placed[number].lines(writer), *inside, keyword("*END INSTANCE")]
    end = keyword("*END ASSEMBLY")
    points = ["*NODE", "1, 9., 9., 9."] if rng.random() < 0.3 else []
    inside_assembly = [*instances, *points, *_flat(outer)]
    assembly = [keyword("*ASSEMBLY", "NAME=A"), *inside_assembly, end]
    return [*_flat(before), *part, *assembly, *_flat(after)]


def _nodes_of(body: Body, groups: dict[str, set[int]]) -> dict[str, set[int]]:
    """Return the labels of the nodes of groups of elements."""
    mesh = body.mesh
    nodes = {
        int(label): set(_labels(mesh.node_labels)[cell].tolist())
        for block in mesh.blocks
        for label, cell in zip(_labels(mesh.cell_labels)[block.numbers], block.cells, strict=True)
    }
    return {name: set().union(*(nodes[e] for e in members)) for name, members in groups.items()}


def _stored(rng: random.Random, folder: Path, lines: Unit) -> Path:
    """Write lines, some of them into files that are included, with comments between."""
    encoding, mark, line_end = rng.choice(
        (
            *((("utf-8", "", "\n"),) * 4),
            ("latin-1", "", "\n"),
            ("utf-8-sig", "", "\r\n"),
            ("utf-16", "", "\n"),
        )
    )
    count = 0

    def written(some: Unit, name: str, depth: int) -> Path:
        nonlocal count
        text = []
        for line in some:
            while rng.random() < 0.06:
                text.append(rng.choice(("** Prüfkörper", "", "   ", "**", "  ** *NODE")))
            text.append(rng.choice(("", "", "", " ")) + line)
        while depth < 3 and len(text) > 3 and rng.random() < 0.25:
            a, b = sorted(rng.sample(range(len(text)), 2))
            count += 1
            other = rng.choice(("part{}.inc", "sub/part{}.txt")).format(count)
            written(text[a:b], other, depth + 1)
            text[a:b] = [rng.choice(("*INCLUDE, INPUT={}", '*include,input="{}"')).format(other)]
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_bytes((mark + "\n".join(text) + "\n").replace("\n", line_end).encode(encoding))
        return file

    return written(lines, "deck.inp", 0)


def tried(seed: int, number: int, folder: Path) -> str:
    """Write a deck, read it, and return the differences; none if it is read as it was meant."""
    rng = random.Random(f"{seed} abaqus {number}")
    file, expected = _write(rng, folder)
    for part, body, wanted in expected:
        mesh = read(file, part or None, _CALLED_FOR)
        if isinstance(mesh, str):
            return mesh
        sets = _nodes_of(body, wanted.cell_sets) | wanted.node_sets
        named = {
            "node_sets": {name.upper(): ids for name, ids in mesh.node_sets.items()},
            "cell_sets": {name.upper(): ids for name, ids in mesh.cell_sets.items()},
        }
        wrong = differences(
            body,
            _remade(mesh, mesh.nodes, **named),
            sets,
            wanted.cell_sets,
            tolerance=0.0 if wanted.exact else 1e-12,
        )
        if wrong:
            return wrong
    return ""
