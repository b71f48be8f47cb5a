"""Properties and materials of Nastran decks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ..base import FloatArray, IntArray, MeshError
from ..fem import Material, OneMaterial, Orthotropic, Ply, Solid
from .nastran import PROPERTIES, Entries, NastranDeck
from .profiles import NASTRAN, Profile, named
from .raw import number, rows_of
from .sections import Source, across, common, layered, refusing

# Fields of surface elements, from their number on, by the kind of all their nodes: angle or system
# of the material, offset, and thickness at the nodes.
_THETA = {"quad": 6, "triangle": 5, "triangle6": 8, "quad8": 14}
_ZOFFS = {kind: at + 1 for kind, at in _THETA.items()}
_NODAL = {kind: slice(10, 14 if kind.startswith("quad") else 13) for kind in _THETA}

_WTMASS = re.compile(rb"\s*PARAM[\s,*]+WTMASS[\s,]+([^\s,]+)")

# Beginnings of OFFT, or the older flag there: a bar's vector is in the axes of its node, or basic.
_FRAMES = [b"", b"G", b"1", b"2", b"B"]

# A beam's y and z in the axes z and y of its section.
_AXES = np.array([[-1.0, 0.0], [0.0, 1.0]])

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
        return number(self.text(at))

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


@dataclass(eq=False)
class Reader:
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
    def properties(self) -> dict[int, dict[int, _Card]]:
        """All properties by the dimension of their elements, also those that are not read."""
        names = self.deck.bulk.names
        return {dim: self.cards(filter(of.fullmatch, names)) for dim, of in PROPERTIES.items()}

    @cached_property
    def materials(self) -> dict[int, _Card]:
        """The materials that are read."""
        return self.cards(tuple(_MATERIALS))

    @cached_property
    def weight(self) -> float:
        """The factor on densities: PARAM,WTMASS of bulk data or of case control."""
        control, bulk = self.deck.control, self.deck.bulk
        found = [
            (number(of[1]), bulk.lines, line)
            for line, of in bulk.long_entries("PARAM")
            if of[:1] == ["WTMASS"]
        ]
        for line, text in enumerate(control.text):
            if of := _WTMASS.match(text):
                found.append((number(of[1].decode()), control, line))
        for value, lines, line in found:
            if value != found[0][0]:
                raise lines.refused(line, "PARAM", f"another WTMASS is {found[0][0]:g}; keep one")
        return found[0][0] if found else 1.0

    def sections(self) -> dict[str, OneMaterial]:
        """Return the sections by group."""
        parts = self.deck.parts
        dims = np.repeat([part.block.dim for part in parts], [len(p.properties) for p in parts])
        found: dict[str, OneMaterial] = {}
        for name, members in self.source.raw.cell_sets.items():
            if not name.startswith("property "):
                continue
            label, dim = int(name.split()[1]), int(dims[members].max())
            if (of := self.source.instead(name, dim)) is not None:
                found[name] = of
                continue
            own = [  # without edges that a mesher gave the same number
                Entries(p.table.select(rows), p.block, p.properties[rows], p.layout)
                for p in parts
                if p.block.dim == dim and (rows := p.properties == label).any()
            ]
            card = self.properties[dim].get(label)
            if card is None:
                if dim == dims.max():
                    why = f"its {name} is not there, or is of elements of another kind"
                    raise own[0].table.refused(0, why)
                continue  # sides and edges of a mesher
            if card.name not in _PROPERTIES:
                raise card.error(f"it is not read; give read_sections(given={{{name!r}: ...}})")
            if (read := _PROPERTIES[card.name]) is None:
                self.source.left_out.append(f"{card.name}, which carries no bending, is left out")
                continue
            with refusing(card.error):
                found[name] = read(self, card, _Place(own, members[dims[members] == dim]))
        bulk = self.deck.bulk
        for entry in bulk.names.keys() & {"NSM", "NSM1", "NSML", "NSML1", "NSMADD"}:
            why = "its mass is not supported; delete it, and take the mass into densities (given=)"
            raise bulk.lines.refused(int(bulk.names[entry][0]), entry, why)
        return found

    # ------------------------------------------------------------------- materials

    def material(self, label: str, card: _Card) -> Solid:
        """Return a material by its number; the card is the one that names it."""
        given: Solid | None = self.source.instead(f"material {label}")
        if given is not None:
            return given
        if not label.isdigit() or int(label) not in self.materials:
            raise card.error(
                f"material {label!r} is none of {', '.join(_MATERIALS)}; give it by "
                "read_sections(given=)"
            )
        own = self.materials[int(label)]
        if int(label) not in self._made:
            for entry in ("MATT1", "MATT8", "MATT11"):
                if int(label) in self.cards((entry,)):
                    raise own.error(f"it depends on temperature by {entry}, which is not supported")
            if int(label) in self.cards(("MATS1",)):
                self.source.left_out.append(f"material {label} is elastic, without its MATS1")
            make, at, damping = _MATERIALS[own.name]
            if own.real(damping, "GE", 0.0):
                self.source.left_out.append(f"material {label} has no damping, GE is left out")
            if not (rho := own.real(at, "RHO", 0.0) * self.weight):
                raise own.error(
                    "RHO is 0 or blank; write it, or give read_sections(given="
                    f"{{'material {label}': Material(...)}})"
                )
            with refusing(own.error):
                self._made[int(label)] = make(self.source, own, rho)
        return self._made[int(label)]

    # ------------------------------------------------------------ fields of elements

    def offset(self, place: _Place, card: _Card) -> float:
        """Return what ZOFFS of all elements is, in metres; refuse thickness at nodes."""
        for part in place.parts:
            part.table.refuse_first(
                np.any(~part.table.blank[:, _NODAL[part.layout]], axis=1),
                "thickness at the nodes is not supported; give it in the property",
            )
        found = np.concatenate([p.table.reals(_ZOFFS[p.layout], 1)[:, 0] for p in place.parts])
        if np.any(found != found[0]):
            raise card.error("ZOFFS of its elements differs; give properties of their own")
        return float(found[0]) * self.source.length

    def axes(self, label: int, place: _Place, card: _Card) -> FloatArray:
        """Return the unit axes of a rectangular system in rows."""
        found = self.deck.grids.axes(label, place.parts[0].table, 0)
        if found.kind != "R":
            raise card.error(f"system {label} is not rectangular")
        return found.axes

    def fibres(self, place: _Place, card: _Card) -> tuple[float, ...]:
        """Return the direction whose projection is the material's axis on all elements."""
        normals = self.source.directions(place.members)
        x = across(self.source.directions(place.members, edges=True), normals)
        columns = [p.table.fields[:, _THETA[p.layout] :][:, :1] for p in place.parts]
        texts = [c if c.size else np.full((len(c), 1), b"") for c in columns]
        words, of = np.unique(np.char.strip(np.concatenate(texts)[:, 0]), return_inverse=True)
        angles = np.radians([0.0 if w.isdigit() or not w else number(w.decode()) for w in words])
        along = np.cos(angles)[of, None] * x + np.sin(angles)[of, None] * np.cross(normals, x)
        for i, word in enumerate(words.tolist()):
            if word.isdigit():  # MCID
                along[of == i] = self.axes(int(word), place, card)[0]
        return common(along, normals)

    def towards(self, place: _Place) -> tuple[FloatArray, FloatArray]:
        """Return the direction of plane 1 of each bar, and its offset; refuse hinges."""
        found, moved = [], []
        for part in place.parts:
            table, nodes, grids = part.table, self.source.raw.nodes, self.deck.grids
            offt, ends = np.char.strip(table.fields[:, 7]), table.reals(10, 6)
            frames, rows = offt.astype("S1"), rows_of(grids.labels, table.integers(2, 1)[:, 0])
            turned = (np.char.count(offt, b"O") > 0) | (grids.output_systems[rows] > 0)
            wrong: dict[str, Any] = {
                "it has no orientation, X1 to X3 or G0": np.all(table.blank[:, 4:7], axis=1),
                "OFFT must begin with G or B": ~np.isin(frames, _FRAMES),
                "hinges PA, PB are not supported": np.any(~table.blank[:, 8:10], axis=1),
                "its offsets WA and WB differ": np.any(ends[:, :3] != ends[:, 3:], axis=1),
                "its offsets need CD = 0, and OFFT without O": ends.any(axis=1) & turned,
            }
            for why, which in wrong.items():
                table.refuse_first(which, why)
            whole = np.array([b"." not in text for text in table.fields[:, 4]])
            by_node = whole & np.all(table.blank[:, 5:7], axis=1)
            third = np.zeros(len(table), int)
            third[by_node] = table.select(by_node).integers(4, 1)[:, 0]
            third = rows_of(grids.labels, third)
            table.refuse_first(by_node & (third < 0), "its node G0 is not there")
            vectors = nodes[third] - nodes[rows]
            vectors[~by_node] = table.select(~by_node).reals(4, 3)
            systems = np.where(by_node | (frames == b"B"), 0, grids.output_systems[rows])
            for label in np.unique(systems[systems > 0]).tolist():  # X1 to X3 are in that of GA
                own = np.flatnonzero(systems == label)
                axes = grids.axes(label, table, int(own[0])).directions(nodes[rows[own]])
                vectors[own] = np.einsum("ni,nij->nj", vectors[own], axes)
            found.append(vectors)
            moved.append(ends[:, :3] * self.source.length)
        return np.concatenate(found), np.concatenate(moved)


# -------------------------------------------------------------------------------- properties


def _solid(reader: Reader, card: _Card, place: _Place) -> OneMaterial:
    found = reader.material(card.text(1), card)
    if card.text(6) not in ("", "SMECH"):
        raise card.error(f"FCTN={card.text(6)} is no solid")
    if isinstance(found, Orthotropic) and card.text(2) not in ("", "0"):
        axes: Any = reader.axes(int(card.real(2, "CORDM")), place, card)
        return replace(found, axes=axes)
    return found


def _shell(reader: Reader, card: _Card, place: _Place) -> OneMaterial:
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
    return layered(plies, lambda: reader.fibres(place, card), reader.offset(place, card))


def _laminate(reader: Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PCOMP, with four fields a ply, or PCOMPG, with a number before these in each line."""
    card.must_be(2, "NSM", 0.0)
    if card.text(7) not in ("", "SYM"):
        raise card.error(f"LAM={card.text(7)} is not supported")
    if card.real(6, "GE", 0.0):
        reader.source.left_out.append(f"{card.name} {card.text(0)} has no damping, GE is left out")
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
    offset = reader.offset(place, card)
    if card.text(1):
        offset += card.real(1, "Z0") * reader.source.length + 0.5 * total
    return layered(plies, lambda: reader.fibres(place, card), offset)


def _bar(reader: Reader, card: _Card, place: _Place, shear: float = math.inf) -> OneMaterial:
    """Return PBAR: y of the deck is z of the section, and z of the deck is against y.

    It is rigid in shear where K1 and K2 are blank, or 0.
    """
    card.must_be(6, "NSM", 0.0)
    area, I1, I2, J = card.reals(2, "A I1 I2 J")
    points = [[card.real(at + i, "C to F", 0.0) for i in (1, 0)] for at in (8, 10, 12, 14)]
    factors = [card.real(at, "K1, K2", shear) or math.inf for at in (17, 16)]
    second = I2, card.real(18, "I12", 0.0), I1
    section = reader.source.numbers(
        area, second, J, np.diag(np.divide(1.0, factors)), np.array(points)
    )
    return _beam(reader, card, place, section)


def _constant(reader: Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PBEAM, of which all cross-sections must be the same, by its PBAR."""
    of = [*card.fields, *[""] * 16]
    if of[8] in _STATIONS:  # without C to F
        of[8:8] = [""] * 8
    card, at = replace(card, fields=of), 16
    while of[at] in _STATIONS:
        for i in range(2, 8):
            card.must_be(at + i, "A to NSM along the beam", card.real(i, "A to NSM", 0.0))
        at += 16 if of[at] == "YES" else 8
    for i in range(at + 2, len(of)):
        card.must_be(i, "a field after K1 and K2", 0.0)
    bar = [*of[:5], *of[6:8], "", *of[8:16], *of[at : at + 2], of[5]]
    return _bar(reader, replace(card, fields=bar), place, 1.0)


def _shaped(reader: Reader, card: _Card, place: _Place) -> OneMaterial:
    """Return PBARL or PBEAML: dimensions, and a mass beside the section's that must be 0."""
    count, make = named(NASTRAN, card.text(3))
    if any(card.fields[9 + count :]):
        raise card.error("it has fields after its first cross-section, which is not supported")
    card.must_be(8 + count, "NSM", 0.0)
    lengths = np.array([card.real(8 + i, f"DIM{i + 1}") for i in range(count)])
    section = make(*(lengths * reader.source.length).tolist())
    if isinstance(section, Profile):  # nodes are at the centroid
        section = section.at(*section.centre)
    return _beam(reader, card, place, section)


def _beam(reader: Reader, card: _Card, place: _Place, section: Any) -> OneMaterial:
    material: Any = reader.material(card.text(1), card)
    z, moved = reader.towards(place)
    return reader.source.beam(section, material, z, place.members, _AXES, moved)


# First field of the lines of PBEAM that have a cross-section.
_STATIONS = ("YES", "YESA", "NO")

# How properties are read; None for bars without bending.
_PROPERTIES: dict[str, Callable[..., OneMaterial] | None] = {
    "PSOLID": _solid,
    "PSHELL": _shell,
    **dict.fromkeys(("PCOMP", "PCOMPG"), _laminate),
    "PBAR": _bar,
    "PBEAM": _constant,
    **dict.fromkeys(("PBARL", "PBEAML"), _shaped),
    **dict.fromkeys(("PROD", "PTUBE"), None),
}


# ------------------------------------------------------------------------------- materials


def _isotropic(source: Source, card: _Card, rho: float) -> Material:
    """Return MAT1, of which one of E, G and NU may be blank; of two, solvers make no solid."""
    E, G, nu = (card.real(at, "", 0.0) for at in (1, 2, 3))
    if sum(bool(card.text(at)) for at in (1, 2, 3)) < 2 or (G == 0.0 and not card.text(3)):
        raise card.error("write two of E, G and NU")
    if not card.text(3):
        nu = 0.5 * E / G - 1.0
    elif not card.text(1):
        E = 2.0 * G * (1.0 + nu)
    elif G and abs(G - 0.5 * E / (1.0 + nu)) > _ISOTROPIC * G:
        raise card.error(
            f"G={G:g} is not E/(2 (1 + NU)) = {0.5 * E / (1.0 + nu):g}; leave NU blank for bars, "
            "and G for shells and solids"
        )
    return source.isotropic(E, nu, rho)


_MAT8 = "E1 E2 NU12 G12 G1Z G2Z"
_MAT11 = "E1 E2 E3 NU12 NU13 NU23 G12 G13 G23"

# Materials, and where their density and damping are.
_MATERIALS: dict[str, tuple[Callable[..., Solid], int, int]] = {
    "MAT1": (_isotropic, 4, 7),
    "MAT8": (lambda source, card, rho: source.ply(*card.reals(1, _MAT8), rho), 7, 16),
    "MAT11": (lambda source, card, rho: source.orthotropic(*card.reals(1, _MAT11), rho), 10, 15),
}
