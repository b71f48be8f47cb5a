"""Properties and materials of Nastran decks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ..base import FloatArray, IntArray, MeshError
from ..fem import (
    Beam,
    BeamSection,
    CircularSection,
    Material,
    OneMaterial,
    Orthotropic,
    Ply,
    RectangularSection,
    Solid,
    TubularSection,
)
from ..mesh import Entries, NastranDeck, Table, number
from .common import Source, across, common, layered, refusing

# Fields of surface elements, from their number on, by the kind of all their nodes: angle or system
# of the material, offset, and thickness at the nodes.
_THETA = {"quad": 6, "triangle": 5, "triangle6": 8, "quad8": 14}
_ZOFFS = {kind: at + 1 for kind, at in _THETA.items()}
_NODAL = {kind: slice(10, 14 if kind.startswith("quad") else 13) for kind in _THETA}

# Properties of solids, shells and beams, also those that are not read.
_ANY = re.compile(
    "P(SOLID|LSOLID|COMPL?S|SHELL|COMPG?|SHEAR|L?PLANE|SHLN[12]|BAR|BARL|BEAM|BEAML|BEAM3|BCOMP"
    "|B[MR]SECT|BEND|ROD|TUBE)"
)

# Beginnings of OFFT, or the older flag there: a bar's vector is in the axes of its node, or basic.
_FRAMES = [b"", b"G", b"1", b"2", b"B"]

# Relative difference from a number with few digits, such as 0.833 for 5/6.
_DIGITS = 1e-3

# Relative difference of G from E/(2 (1 + nu)) from which on a material is not isotropic.
_ISOTROPIC = 0.01


@dataclass(frozen=True, eq=False)
class _Card:
    """An entry of bulk data with its fields, counted from its number."""

    name: str
    fields: list[str]
    error: Callable[[str], MeshError]

    def text(self, at: int) -> str:
        """Return a field; blank beyond the last one."""
        return self.fields[at] if at < len(self.fields) else ""

    def real(self, at: int, what: str, default: float | None = None) -> float:
        """Return a field as a number; refuse a blank one without a default."""
        if not self.text(at):
            if default is None:
                raise self.error(f"{what} is blank")
            return default
        try:
            return number(self.text(at))
        except ValueError as wrong:
            raise self.error(f"{what}: {wrong}") from None

    def reals(self, first: int, names: str) -> list[float]:
        """Return numbers by their names, none of them blank."""
        return [self.real(first + i, name) for i, name in enumerate(names.split())]

    def must_be(self, at: int, what: str, wanted: float) -> None:
        """Refuse another value than the one that a blank field stands for."""
        value = self.real(at, what, wanted)
        if abs(value - wanted) > _DIGITS * abs(wanted):
            raise self.error(f"{what}={value:g} is not supported; only {wanted:g} is")


class _Place(NamedTuple):
    """The elements of one property: their entries, and the cells of the mesh."""

    parts: list[Entries]
    members: IntArray


def sections(source: Source, deck: NastranDeck) -> dict[str, OneMaterial]:
    """Return the sections of a deck by the groups of its mesh."""
    return _Reader(source, deck).sections()


@dataclass(eq=False)
class _Reader:
    """The properties and materials of a deck by number, and its materials, each made once."""

    source: Source
    deck: NastranDeck
    _made: dict[int, Solid] = field(default_factory=dict)

    def cards(self, names: Iterable[str]) -> dict[int, _Card]:
        """Return the entries of some names by their numbers."""
        found: dict[int, _Card] = {}
        for name in names:
            for line, fields in self.deck.bulk.long_entries(name):
                card = _Card(name, fields, partial(self.deck.bulk.lines.refused, line, name))
                label = card.text(0)
                if not label.isdigit() or found.setdefault(int(label), card).fields != fields:
                    raise card.error(f"its number {label!r} is none, or another entry has it")
        return found

    @cached_property
    def properties(self) -> dict[int, _Card]:
        """All properties of elements, also those that are not read."""
        return self.cards(filter(_ANY.fullmatch, self.deck.bulk.names))

    @cached_property
    def materials(self) -> dict[int, _Card]:
        """The materials that are read."""
        return self.cards(tuple(_MATERIALS))

    @cached_property
    def weight(self) -> float:
        """The factor on densities, PARAM,WTMASS."""
        for line, fields in self.deck.bulk.long_entries("PARAM"):
            if fields[:1] == ["WTMASS"]:
                card = _Card("PARAM", fields, partial(self.deck.bulk.lines.refused, line, "PARAM"))
                return card.real(1, "WTMASS")
        return 1.0

    def sections(self) -> dict[str, OneMaterial]:
        """Return the sections by group."""
        parts = self.deck.parts
        numbers = np.concatenate([np.zeros(0, int), *(part.properties for part in parts)])
        dims = np.repeat([part.block.dim for part in parts], [len(p.properties) for p in parts])
        found: dict[str, OneMaterial] = {}
        for label in np.unique(numbers[numbers > 0]).tolist():
            name, members = f"property {label}", np.flatnonzero(numbers == label)
            if (of := self.source.instead(name)) is not None:
                found[name] = of
                continue
            card, dim = self.properties.get(label), int(dims[members].max())
            own = [  # without edges that a mesher gave the same number
                Entries(p.table.select(rows), p.block, p.properties[rows], p.layout)
                for p in parts
                if p.block.dim == dim and (rows := p.properties == label).any()
            ]
            if card is None:
                if dim == dims.max():
                    raise own[0].table.refused(0, f"its {name} is not there")
                continue  # sides and edges of a mesher
            if card.name not in _PROPERTIES:
                raise card.error(f"it is not read; give read_sections(given={{{name!r}: ...}})")
            read, of_dim = _PROPERTIES[card.name]
            if dim != of_dim:
                raise card.error("its elements are of another kind")
            if read is None:
                self.source.left_out.append(f"{card.name}, which carries no bending, is left out")
                continue
            with refusing(card.error):
                found[name] = read(self, card, _Place(own, members[dims[members] == dim]))
        for entry in {"NSM", "NSM1", "NSML", "NSML1"}.intersection(self.deck.bulk.names):
            self.source.left_out.append(f"mass of {entry} is left out")
        return found

    # ------------------------------------------------------------------- materials

    def material(self, label: str, card: _Card) -> Solid:
        """Return a material by its number; the card is the one that names it."""
        if isinstance(given := self.source.instead(f"material {label}"), Solid):
            return given
        if not label.isdigit() or int(label) not in self.materials:
            raise card.error(
                f"material {label!r} is none of {', '.join(_MATERIALS)}; give it by "
                "read_sections(given=)"
            )
        own = self.materials[int(label)]
        if int(label) not in self._made:
            for entry in ("MATT1", "MATT8", "MATT11", "MATS1"):
                if not any(of[:1] == [label] for _, of in self.deck.bulk.long_entries(entry)):
                    continue
                if entry != "MATS1":
                    raise own.error(f"it depends on temperature by {entry}, which is not supported")
                self.source.left_out.append(f"material {label} is elastic, without its MATS1")
            make, at = _MATERIALS[own.name]
            rho = own.real(at, "RHO", 0.0) * self.weight
            if not rho:
                raise own.error(
                    "RHO is 0 or blank; write it, or give read_sections(given="
                    f"{{'material {label}': Material(...)}})"
                )
            with refusing(own.error):
                self._made[int(label)] = make(self.source, own, rho)
            if own.name == "MAT8":
                self.source.left_out.append(f"material {label} has no E3: that of contact is E2")
        return self._made[int(label)]

    # ------------------------------------------------------------ fields of elements

    def offset(self, place: _Place) -> float:
        """Return what ZOFFS of all elements is, in metres; refuse thickness at nodes."""
        found: list[float] = []
        for part in place.parts:
            at = _ZOFFS[part.layout]
            part.table.refuse_first(
                np.any(~part.table.blank[:, _NODAL[part.layout]], axis=1),
                "thickness at the nodes is not supported; give it in the property",
            )
            found += part.table.reals(at, 1)[:, 0].tolist()
            different = part.table.reals(at, 1)[:, 0] != found[0]
            part.table.refuse_first(
                different, f"ZOFFS differs from {found[0]:g} of another element"
            )
        return float(found[0]) * self.source.length

    def fibres(self, place: _Place, card: _Card) -> tuple[float, ...]:
        """Return the direction whose projection is the material's axis on all elements."""
        normals = self.source.directions(place.members)
        x = across(self.source.directions(place.members, edges=True), normals)
        texts: list[tuple[Table, int, str]] = []
        for part in place.parts:
            own = part.table.fields[:, _THETA[part.layout] :][:, :1].reshape(-1)
            words = [text.decode().strip() for text in own] or [""] * len(part.table)
            texts += [(part.table, row, text) for row, text in enumerate(words)]
        angles = np.zeros(len(texts))
        systems: dict[str, FloatArray] = {}
        for i, (table, row, text) in enumerate(texts):
            if text.isdigit() and text not in systems:
                axes = self.deck.grids.axes(int(text), table, row)
                if axes.kind != "R":
                    raise table.refused(row, f"system {text} (MCID) is not rectangular")
                systems[text] = axes.axes[0]
            elif text and not text.isdigit():
                angles[i] = np.radians(number(text))
        found = np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * np.cross(normals, x)
        for i, (_, _, text) in enumerate(texts):
            found[i] = systems.get(text, found[i])
        axis = common(found, normals)
        if axis is None:
            raise card.error(
                "its elements have fibres in several directions by THETA or MCID; give one system "
                "(MCID) to all, or properties of their own"
            )
        return axis

    def towards(self, place: _Place, card: _Card) -> tuple[float, ...]:
        """Return the direction of the plane 1 of all bars; refuse offsets and hinges."""
        found = []
        for part in place.parts:
            table, cells = part.table, self.source.raw.nodes
            frames = np.char.strip(table.fields[:, 7]).astype("S1")
            wrong: dict[str, Any] = {
                "it has no orientation, X1 to X3 or G0": np.all(table.blank[:, 4:7], axis=1),
                "OFFT must begin with G or B": ~np.isin(frames, _FRAMES),
                "hinges PA, PB are not supported": np.any(~table.blank[:, 8:10], axis=1),
                "offsets are not supported": np.any(table.reals(10, 6) != 0.0, axis=1),
            }
            for why, rows in wrong.items():
                table.refuse_first(rows, why)
            whole = np.array([b"." not in text for text in table.fields[:, 4]])
            by_node: Any = whole & np.all(table.blank[:, 5:7], axis=1)
            vectors = np.zeros((len(table), 3))
            start, _ = table.integers(2, 2).T
            rows = np.searchsorted(self.deck.grids.labels, start)
            third = table.select(by_node).integers(4, 1)[:, 0]
            at = np.searchsorted(self.deck.grids.labels, third).clip(max=len(cells) - 1)
            table.select(by_node).refuse_first(
                self.deck.grids.labels[at] != third, "its node G0 is not there"
            )
            vectors[by_node] = cells[at] - cells[rows[by_node]]
            vectors[~by_node] = table.select(~by_node).reals(4, 3)
            systems = np.where(by_node | (frames == b"B"), 0, self.deck.grids.output_systems[rows])
            for label in np.unique(systems[systems > 0]).tolist():  # X1 to X3 are in that of GA
                own = np.flatnonzero(systems == label)
                axes = self.deck.grids.axes(label, table, int(own[0])).directions(cells[rows[own]])
                vectors[own] = np.einsum("ni,nij->nj", vectors[own], axes)
            found.append(vectors)
        axis = common(np.concatenate(found), self.source.directions(place.members))
        if axis is None:
            raise card.error(
                "its bars have orientations for which no one direction stands; give properties of "
                "their own"
            )
        return axis


# -------------------------------------------------------------------------------- properties


def _solid(reader: _Reader, card: _Card, place: _Place) -> OneMaterial:
    found = reader.material(card.text(1), card)
    if card.text(6) not in ("", "SMECH"):
        raise card.error(f"FCTN={card.text(6)} is no solid")
    if isinstance(found, Orthotropic) and card.text(2) not in ("", "0"):
        table = place.parts[0].table
        axes = reader.deck.grids.axes(int(card.real(2, "CORDM")), table, 0)
        if axes.kind != "R" or card.text(2).startswith("-"):
            raise card.error("CORDM must be a rectangular system")
        own: Any = axes.axes
        return replace(found, axes=own)
    return found


def _shell(reader: _Reader, card: _Card, place: _Place) -> OneMaterial:
    own = card.text(1)
    material = reader.material(own, card)
    if card.text(3) != own:
        raise card.error(f"MID2={card.text(3)!r} of bending must be MID1={own}")
    for at, what in ((5, "MID3"), (10, "MID4")):
        if card.text(at) not in ("", "0", own if at == 5 else ""):
            raise card.error(f"{what}={card.text(at)} is not supported")
    card.must_be(4, "12I/T**3", 1.0)
    card.must_be(6, "TS/T", 5.0 / 6.0)
    card.must_be(7, "NSM", 0.0)
    plies = [Ply(card.real(2, "T") * reader.source.length, material)]
    return layered(plies, lambda: reader.fibres(place, card), reader.offset(place))


def _laminate(reader: _Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PCOMP, with four fields a ply, or PCOMPG, with a number before these in each line."""
    card.must_be(2, "NSM", 0.0)
    if card.text(7) not in ("", "SYM"):
        raise card.error(f"LAM={card.text(7)} is not supported")
    step, first = (8, 9) if card.name == "PCOMPG" else (4, 8)
    plies: list[Ply] = []
    label, thickness = "", None
    for at in range(first, len(card.fields), step):
        if not any(card.fields[at : at + 4]):
            continue
        label = card.text(at) or label
        thickness = card.real(at + 1, f"T{len(plies) + 1}", thickness)
        angle = card.real(at + 2, "THETA", 0.0)
        plies.append(Ply(thickness * reader.source.length, reader.material(label, card), angle))
    if card.text(7) == "SYM":
        plies += plies[::-1]
    total = sum(ply.thickness for ply in plies)
    offset = reader.offset(place)
    if card.text(1):
        offset += card.real(1, "Z0") * reader.source.length + 0.5 * total
    return layered(plies, lambda: reader.fibres(place, card), offset)


def _bar(reader: _Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PBAR: y of the deck is z of the section, and z of the deck is against y."""
    card.must_be(6, "NSM", 0.0)
    card.must_be(18, "I12", 0.0)
    area, I1, I2, J = card.reals(2, "A I1 I2 J")
    places = [card.real(at, "C to F", 0.0) * reader.source.length for at in range(8, 16)]
    factors = [card.real(at, f"K{at - 15}", 1.0) for at in (17, 16)]
    unit = reader.source.length
    section = BeamSection(
        area * unit**2,
        Iy=I1 * unit**4,
        Iz=I2 * unit**4,
        J=J * unit**4,
        shear_factors=(factors[0], factors[1]),
        points=[(-z, y) for y, z in zip(places[::2], places[1::2], strict=True)],
    )
    return _beam(reader, card, place, section)


def _constant(reader: _Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PBEAM, of which all cross-sections must be the same, by its PBAR."""
    names = ("A", "I1", "I2", "I12", "J", "NSM")
    lines = [card.fields[i : i + 8] for i in range(8, len(card.fields), 8)]
    places, rest = [""] * 8, [""] * 16
    if lines and lines[0][0] not in _STATIONS:
        places, lines = lines[0], lines[1:]
    while lines and lines[0][0] in _STATIONS:
        for name, first, other in zip(names, card.fields[2:8], lines[0][2:], strict=False):
            value = number(first or "0")
            if other and abs(number(other) - value) > _DIGITS * abs(value):
                raise card.error(f"{name} changes along the beam, which is not supported")
        lines = lines[2 if lines[0][0] == "YES" else 1 :]
    rest = [text for line in lines for text in line] + rest
    others = ("S1", "S2", "NSI", "NSI", "CW", "CW", *["M, N"] * 8)
    for name, text in zip(others, rest[2:16], strict=True):
        if text and number(text):
            raise card.error(f"{name}={text} is not supported")
    A, I1, I2, I12, J, NSM = card.fields[2:8]
    numbers = [card.text(0), card.text(1), A, I1, I2, J, NSM, "", *places]
    bar = [*numbers, *(text or "1." for text in rest[:2]), I12]
    return _bar(reader, replace(card, fields=bar), place)


def _shaped(reader: _Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PBARL or PBEAML: dimensions, and a mass beside the section's that must be 0."""
    if card.text(3) not in _SHAPES:
        raise card.error(
            f"TYPE={card.text(3)} is not supported; give its Beam by read_sections(given=)"
        )
    names, make = _SHAPES[card.text(3)]
    count = len(names.split())
    if any(card.fields[9 + count :]):
        raise card.error("it has fields after its first cross-section, which is not supported")
    card.must_be(8 + count, "NSM", 0.0)
    section = make(*(x * reader.source.length for x in card.reals(8, names)))
    return _beam(reader, card, place, section)


def _beam(reader: _Reader, card: _Card, place: _Place, section: Any) -> OneMaterial:
    material = reader.material(card.text(1), card)
    if not isinstance(material, Material):
        raise card.error(f"a beam needs a MAT1, and material {card.text(1)} is none")
    return Beam(section, material, orientation=reader.towards(place, card))


# What begins a line of PBEAM that has a cross-section.
_STATIONS = ("YES", "YESA", "NO")

# Shapes of beams: their dimensions, the first along z of the deck, and their sections.
_SHAPES: dict[str, tuple[str, Callable[..., Any]]] = {
    "BAR": ("DIM1 DIM2", RectangularSection),
    "ROD": ("DIM1", CircularSection),
    "TUBE": ("DIM1 DIM2", lambda outer, inner: TubularSection(outer, outer - inner)),
    "TUBE2": ("DIM1 DIM2", TubularSection),
}

# How properties are read, and the dimension of their elements; None for bars without bending.
_PROPERTIES: dict[str, tuple[Callable[..., OneMaterial] | None, int]] = {
    "PSOLID": (_solid, 3),
    "PSHELL": (_shell, 2),
    **dict.fromkeys(("PCOMP", "PCOMPG"), (_laminate, 2)),
    "PBAR": (_bar, 1),
    "PBEAM": (_constant, 1),
    **dict.fromkeys(("PBARL", "PBEAML"), (_shaped, 1)),
    **dict.fromkeys(("PROD", "PTUBE"), (None, 1)),
}


# ------------------------------------------------------------------------------- materials


def _isotropic(source: Source, card: _Card, rho: float) -> Material:
    """Return MAT1, of which one of E, G and NU may be blank."""
    E, G, nu = (card.real(at, "", 0.0) for at in (1, 2, 3))
    if not card.text(3):
        nu = 0.5 * E / G - 1.0
    elif not card.text(1):
        E = 2.0 * G * (1.0 + nu)
    elif G and abs(G - 0.5 * E / (1.0 + nu)) > _ISOTROPIC * G:
        raise card.error(f"G={G:g} is not E/(2 (1 + NU)); leave it blank, or take MAT8")
    return source.isotropic(E, nu, rho)


def _ply(source: Source, card: _Card, rho: float) -> Orthotropic:
    E1, E2, nu12, G12, G13, G23 = card.reals(1, "E1 E2 NU12 G12 G1Z G2Z")
    return source.ply(E1, E2, nu12, G12, G13, G23, rho)


def _orthotropic(source: Source, card: _Card, rho: float) -> Orthotropic:
    of = card.reals(1, "E1 E2 E3 NU12 NU13 NU23 G12 G13 G23")
    return source.orthotropic(of[:3], of[3:6], of[6:], rho)


# Materials, and where their density is.
_MATERIALS: dict[str, tuple[Callable[..., Solid], int]] = {
    "MAT1": (_isotropic, 4),
    "MAT8": (_ply, 7),
    "MAT11": (_orthotropic, 10),
}
