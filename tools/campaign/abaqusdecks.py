"""Abaqus decks of a body, written in any way that the format allows."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .deckbody import Body, Dialect, Drawn, Expected, Groups, System, runs, shared_out, trials
from .outcome import FloatArray

# Keywords and data lines that must stay together in this order; one entry may have several lines.
Unit = list[str]

_TYPES = {
    "tetra": "C3D4 C3D4H C3D4T",
    "pyramid": "C3D5",
    "wedge": "C3D6 C3D6T",
    "hexahedron": "C3D8 C3D8R C3D8I C3D8T c3d8rt C3D8S",
    "tetra10": "C3D10 C3D10M C3D10HS",
    "pyramid13": "C3D13",
    "wedge15": "C3D15",
    "hexahedron20": "C3D20 C3D20R C3D20RH",
}

# Keywords without influence on the mesh, each with its data lines.
_OTHERS = """
*HEADING
plate, 3 x 2 and a * in the text
second line

*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*DENSITY
7.8E-9

*SOLID SECTION, ELSET=NOWHERE, MATERIAL=STEEL
,

*SURFACE, TYPE=ELEMENT, NAME=S1
NOWHERE, S3

*AMPLITUDE, NAME=A
0., 0., 1., 1.
2., 0.

*STEP, NLGEOM
*STATIC
0.1, 1.
*BOUNDARY,
1, 1, 3
*END STEP

*NODE PRINT
U
*EL FILE
S

*Node Output
U, V
*Element Output, directions=YES
S, E

*RIGID BODY, REF NODE=1, ELSET=NOWHERE

*PREPRINT, echo=NO, model=NO

*TRANSFORM, NSET=NOWHERE
1., 0., 0., 0., 1., 0.
"""

# Words of the warnings that the decks may cause.
_CALLED_FOR = (
    *("belong to no element", "neither solids", "share no nodes", "at the same place"),
    "connections between nodes",
)

# First label of nodes and elements that are no part of the body.
_SPARE = 200_000_000


def _include(rng: random.Random, name: str) -> str:
    plain = "*INCLUDE, INPUT={}" if " " not in name else '*INCLUDE, INPUT="{}"'
    return rng.choice((plain, '*include,input="{}"')).format(name)


_DIALECT = Dialect(("** Prüfkörper", "", "   ", "**", "  ** *NODE"), _include)


class _Writer(Drawn):
    """Writer of a random deck. Names of groups are in capitals, as Abaqus compares them."""

    names, exact = 0, True

    # ------------------------------------------------------------------------ style

    def keyword(self, name: str, *options: str) -> str:
        """Return a keyword line with its options, in random order, case and number of lines."""
        parts = [name, *self.rng.sample(options, len(options))]
        if self.chance(0.5):
            case = self.pick((str.lower, str.title, str.upper))
            parts = [part if '"' in part or "." in part else case(part) for part in parts]
        text = parts[0]
        for part in parts[1:]:
            text += self.pick((",", ", ", " ,  ", ",\n", ", \n** a comment\n  "))
            text += part.replace("=", self.pick(("=", " = ")), 1)
        return text

    def row(self, fields: Iterable[object], *, end: bool = True) -> str:
        """Return a data line, perhaps with blanks and a comma at its end."""
        comma = self.pick((",", ", ", " , ", ",\t"))
        last = self.pick(("", "", "", ",", " ")) if end else ""
        return self.pick(("", "", "   ")) + comma.join(map(str, fields)) + last

    def number(self, value: float) -> str:
        """Return a number with all of its digits."""
        if value == int(value) and self.chance(0.5):
            return (
                self.pick(("{}.", "{}", "{}.0", "{}.D0", "+{}."))
                .format(int(value))
                .replace("+-", "-")
            )
        style = self.pick(("{!r}", "{:.17g}", "{:.16E}", "{:.16e}", "D"))
        return f"{value:.16E}".replace("E", "D") if style == "D" else style.format(value)

    def name(self) -> str:
        self.names += 1
        return self.pick((f"SET-{self.names}", f"_S{self.names}", f'"A, B {self.names}"'))

    # -------------------------------------------------------------------------- the body

    def nodes(self, labels: Sequence[int], places: FloatArray) -> list[Unit]:
        """Return blocks of nodes, some of them in systems of their own."""
        units = []
        for part in shared_out(self.rng, range(len(labels))):
            unit, system = list[str](), System()
            kind = self.pick("RRRCS")
            if self.chance(0.3):
                system = System.drawn(self.rng, kind)
                if self.chance(0.3):
                    system = System(kind, system.origin)
                x, y, _ = system.axes
                points = system.origin + np.stack([0 * x, 2 * x, 0.5 * x + 3 * y])
                values = [[self.number(float(of)) for of in point] for point in points]
                lines = [self.row(values[0] + values[1]), self.row(values[2])]
                if (system.axes == np.eye(3)).all():
                    lines = [self.row(values[0])]
                unit = [self.keyword("*SYSTEM"), *lines]
            self.exact = self.exact and kind == "R" and not unit
            local = System(kind, system.origin, system.axes).local(places[part])
            if kind == "S":  # Abaqus: the angle about z second, then that from the x-y plane
                local = np.stack([local[:, 0], local[:, 2], 90.0 - local[:, 1]], 1)
            options = [f"SYSTEM={kind}"] if kind != "R" or self.chance(0.2) else []
            if self.chance(0.2):
                name = self.name()
                options.append(f"NSET={name}")
                self.node_sets[_key(name)] = {labels[i] for i in part}
            rows = []
            for i, place in zip(part, local.tolist(), strict=True):
                texts = ["" if x == 0.0 and self.chance(0.3) else self.number(x) for x in place]
                if place[2] == 0.0 and self.chance(0.3):
                    texts = texts[:2]
                rows.append(self.row([labels[i], *texts]))
            back = ["*SYSTEM"] if unit else []
            units.append([*unit, self.keyword("*NODE", *options), *rows, *back])
        return units

    def elements(self, body: Body) -> list[Unit]:
        """Return blocks of elements, and the sets of the body's parts."""
        units, by_block = list[Unit](), self.chance(0.6)
        named = [(self.name(), set(part)) for part in body.parts]
        for block in body.mesh.blocks:
            own = list(zip(body.cells[block.numbers], block.cells, strict=True))
            for part in shared_out(self.rng, range(len(own))):
                for name, members in named if by_block else [("", set(body.cells))]:
                    kind = self.pick(_TYPES[block.kind].split())
                    options = [f"TYPE={kind}", *([f"ELSET={name}"] if by_block else [])]
                    rows = [
                        row
                        for label, cell in (own[i] for i in part)
                        if label in members
                        for row in self.broken([label, *(body.nodes[node] for node in cell)])
                    ]
                    units += [[self.keyword("*ELEMENT", *options), *rows]] if rows else []
        for name, members in named:
            if by_block:
                self.cell_sets[_key(name)] = members
            else:
                units += self.group("ELSET", name, members, body.cells)
        return units

    def broken(self, numbers: list[int]) -> Unit:
        """Return an element in one line or in several."""
        if self.chance(0.6) and len(numbers) <= 16:
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
        option = [f"{which}={name}", *also, *self.pick(([], ["INTERNAL"], ["UNSORTED"]))]
        way = self.pick(("pieces", "generate", "nested"))
        if way == "generate":
            rows = [[run[0], run[-1], *self.pick(([], [1]))] for run in runs(wanted, every)]
            return [
                [self.keyword(f"*{which}", *option, "GENERATE"), *(self.row(rows[i]) for i in some)]
                for some in shared_out(self.rng, range(len(rows)))
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
            return [_flat(self.pick(([*units, whole], [whole, *units])))]
        return [
            [self.keyword(f"*{which}", *option), *self.lines([listed[i] for i in part])]
            for part in shared_out(self.rng, range(len(listed)))
        ]

    def lines(self, members: Sequence[object]) -> Unit:
        step = self.rng.randint(1, 16)
        return [self.row(members[i : i + step]) for i in range(0, len(members), step)]

    def others(self, body: Body) -> list[Unit]:
        """Return elements that are no solids, and nodes of no element."""
        one, two = body.nodes[:2]
        units = [
            ["*ELEMENT, TYPE=MASS, ELSET=M", f"{_SPARE}, {one}"],
            ["*ELEMENT,TYPE=SPRINGA", f"{_SPARE + 1}, {one}, {two}"],
            ["*NODE", f"{_SPARE}, 5., 5., 5."],
        ]
        units = [unit for unit in units if self.chance(0.3)]
        if self.chance(0.3):
            nodes = body.nodes[:4]
            shell = ",".join(map(str, [_SPARE + 2, *nodes]))
            units.append(["*ELEMENT,TYPE=S4R, ELSET=SHELL", shell])
            self.node_sets["SHELL"] = set(nodes)
        return units


def _flat(units: Iterable[Unit]) -> Unit:
    return [line for unit in units for line in unit]


def _key(name: str) -> str:
    return name.strip('"').upper()


# ------------------------------------------------------------------------------ whole decks


@dataclass(frozen=True)
class _Placement:
    """Translation of an instance, then rotation, degrees, about the axis through two points."""

    shift: FloatArray
    axis: FloatArray
    angle: float

    @classmethod
    def drawn(cls, rng: random.Random) -> _Placement:
        shift, start, end = np.round([[rng.uniform(-2, 2) for _ in range(3)] for _ in range(3)], 3)
        angle = rng.choice((0.0, 90.0, rng.uniform(-180, 180)))
        return cls(shift * rng.choice((0, 1, 1)), np.array([start, end]), angle)

    def lines(self, writer: _Writer) -> Unit:
        numbers = [*self.axis.ravel(), self.angle]
        rows = [self.shift, numbers] if self.angle else [self.shift] if self.shift.any() else []
        return [writer.row([writer.number(float(x)) for x in row]) for row in rows]

    def __call__(self, places: FloatArray) -> FloatArray:
        return self._turned(places + self.shift, 1.0)

    def before(self, places: FloatArray) -> FloatArray:
        return self._turned(places, -1.0) - self.shift

    def _turned(self, places: FloatArray, sense: float) -> FloatArray:
        start, along = self.axis[0], self.axis[1] - self.axis[0]
        turn = sense * self.angle * along / np.linalg.norm(along)
        turned: FloatArray = Rotation.from_rotvec(turn, degrees=True).apply(places - start)
        return start + turned


def _written(rng: random.Random, body: Body, folder: Path) -> tuple[Path, list[Expected]]:
    """Write a deck, and return the file and the expected results of reading it."""
    writer = _Writer(rng)
    placed = [_Placement.drawn(rng) for _ in range(2)]
    style = rng.choice(("flat", "flat", "flat", "parts", "instance", "within", "two"))
    places = body.mesh.nodes
    if style in ("instance", "within", "two"):
        places = placed[0].before(places)
    units = writer.nodes(body.nodes, places) + writer.elements(body)
    outer, outside = list[Unit](), set[str]()
    for which, groups, every in (
        ("NSET", body.node_sets, body.nodes),
        ("ELSET", body.element_sets, body.cells),
    ):
        for members in groups:
            name = writer.name()
            if style in ("instance", "within") and rng.random() < 0.5:
                outer += writer.group(which, name, members, every, "INSTANCE=I-1")
                outside.add(_key(name))
            else:
                units += writer.group(which, name, members, every)
    last: Unit = []
    name = rng.choice(sorted(set(writer.cell_sets) - outside))
    if rng.random() < 0.3 and "," not in name:  # placed after all pieces of the element set
        last = [writer.keyword("*NSET", "NSET=OF-ELEMENTS", f"ELSET={name}")]
        writer.node_sets["OF-ELEMENTS"] = body.nodes_of(writer.cell_sets[name])
    others = _OTHERS.strip().split("\n\n")
    model = [unit.splitlines() for unit in rng.sample(others, rng.randint(0, 4))]
    units += writer.others(body) + (model if style == "flat" else [])
    rng.shuffle(units)
    rng.shuffle(outer)
    lines = [*_flat(units), *last]
    if style != "flat":
        lines = _assembled(writer, style, lines, outer, model, placed)
    file = _DIALECT.stored(rng, folder, "deck.inp", lines)
    of_cells = {name: body.nodes_of(of) for name, of in writer.cell_sets.items()}
    sets = of_cells | writer.node_sets, writer.cell_sets
    if style == "flat":
        return file, [Expected(places, *sets, 0.0 if writer.exact else 1e-12)]
    expected = []
    names = ["BAR"] if style == "parts" else ["I-1", "I-2"] if style == "two" else ["I-1"]
    for number, name in enumerate(names):
        moved = placed[number](places) if style != "parts" else places
        node_sets, cell_sets = (
            _of_instance(name, those, outside, alone=len(names) == 1) for those in sets
        )
        node_sets[name], cell_sets[name] = set(body.nodes), set(body.cells)
        part = name if len(names) > 1 else None
        exact = style == "parts" and writer.exact
        expected.append(Expected(moved, node_sets, cell_sets, 0.0 if exact else 1e-12, part))
    return file, expected


def _of_instance(instance: str, sets: Groups, outside: set[str], *, alone: bool) -> Groups:
    """Return sets by the names that a reader gives: sets within an instance have its prefix."""
    inner = {f"{instance}.{name}": of for name, of in sets.items() if name not in outside}
    return inner | {name: of for name, of in sets.items() if name in outside or alone}


def _assembled(
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
    within = lines if style == "within" else []
    part = [keyword("*PART", "NAME=BAR"), *([] if within else lines), "*End Part"]
    if style == "parts":
        return [*_flat(before), *part, *_flat(after)]
    instances = []
    for number in range(2 if style == "two" else 1):
        head = keyword("*INSTANCE", f"NAME=I-{number + 1}", "PART=BAR")
        instances += [head, *placed[number].lines(writer), *within, keyword("*END INSTANCE")]
    points = ["*NODE", "1, 9., 9., 9."] if writer.rng.random() < 0.3 else []
    assembly = [keyword("*ASSEMBLY", "NAME=A"), *instances, *points, *_flat(outer)]
    return [*_flat(before), *part, *assembly, keyword("*END ASSEMBLY"), *_flat(after)]


trial = trials("abaqus", _written, _CALLED_FOR)
