"""Sections and materials of decks of Abaqus and CalculiX."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..base import FloatArray, IntArray
from ..fem import Beam, OneMaterial, Orthotropic, Ply, Solid, TubularSection
from .abaqus import AbaqusDeck
from .abaqusdeck import Keyword, key
from .profiles import ABAQUS, named
from .sections import Source, across, layered, refusing, unit

# Options of a material that change its answer and are left out.
_LEFT_OUT = re.compile(
    "(CYCLIC|RATEDEPENDENT|)PLASTIC|CYCLICHARDENING|RATEDEPENDENT|CREEP|DAMPING|VISCO.*|HYSTERESIS"
    "|DAMAGE.*|.*FAIL.*|SUPERELASTIC.*|HYPER.*|.*PLASTICITY|.*CRACKING|NOCOMPRESSION|NOTENSION|USERMATERIAL"
)

# Keywords that add to a section: to that of their ELSET, or to the one before them.
_ADDING = re.compile(
    "NONSTRUCTURALMASS|TRANSVERSESHEAR(STIFFNESS)?|SECTIONSTIFFNESS|REBAR(LAYER)?|CENTROID"
    "|SHEARCENTER|BEAM(ADDED|FLUID)INERTIA|BEAMSECTIONOFFSET"
)

# Keywords that add mass or stiffness between sections and beside them.
_BESIDE = ("FOUNDATION", "MASSADJUST")

# Least share of an orientation's axis along the normals of the shell that it is for.
_ALONG = 1e-3

# Sine of the angle to the normal below which x is no direction on a shell: 0.1 degrees.
_NORMAL = 1.745e-3

# A beam's y and z in axes 1 and 2 of its section.
_AXES = np.array([[0.0, -1.0], [1.0, 0.0]])

# Largest difference of an angle between two orientations over a shell, rad.
_ANGLE = 1e-4

_ALWAYS = ("ELSET", "MATERIAL", "CONTROLS")


class _Place(NamedTuple):
    """Where a section is: its part, the turn of the instance, and its cells."""

    part: str
    turn: FloatArray
    members: IntArray


@dataclass(eq=False)
class Reader:
    """The cards of a deck by name, and its materials, each made once."""

    source: Source
    deck: AbaqusDeck
    _made: dict[str, Solid] = field(default_factory=dict)

    @cached_property
    def normals(self) -> Keyword | None:
        """The first card with normals, which turn beams."""
        for _, card in self.deck.cards:
            if card.name == "NORMAL" or (
                card.name == "NODE" and any(text.rstrip(", ").count(",") > 3 for text in card.data)
            ):
                return card
        return None

    @cached_property
    def cards(self) -> dict[str, dict[str, Keyword]]:
        """The options of each material by their names."""
        found: dict[str, dict[str, Keyword]] = {}
        own: dict[str, Keyword] = {}
        for _, card in self.deck.cards:
            if card.name == "MATERIAL":
                own = found.setdefault(key(card.options.get("NAME", "")), {})
            elif card.name == "STEP":
                break
            if card.name in own:
                raise card.error("the material has it twice")
            if card.name in ("MATERIAL", "ELASTIC", "DENSITY") or _LEFT_OUT.fullmatch(card.name):
                own[card.name] = card
        return found

    def sections(self) -> dict[str, OneMaterial]:
        """Return the sections by group: those that hold elements of their kind."""
        groups = {key(name): name for name in self.source.raw.cell_sets}
        found: dict[str, OneMaterial] = {}
        adding: list[tuple[str, Keyword]] = []
        elset = ""
        for part, card in self.deck.cards:
            if card.name not in _SECTIONS and not _ADDING.fullmatch(card.name):
                continue
            elset = card.options.get("ELSET", "" if card.name in _SECTIONS else elset)
            for before, turn in self.deck.instances.get(part, []):
                if card.name not in _SECTIONS:
                    adding.append((before + elset, card))
                    continue
                read, dim, types, options = _SECTIONS[card.name]
                name = groups.get(key(before + elset))
                if name is None:
                    raise card.error(f"there is no ELSET {elset!r}")
                members = self.source.raw.cell_sets[name]
                own = [re.match(types, of) is not None for of in self.deck.types[members].tolist()]
                if not any(own):
                    continue  # of trusses, membranes and the like, which no body has
                if name in found:
                    raise card.error(f"{name} has another section")
                if (of := self.source.instead(name, dim)) is not None:
                    found[name] = of
                    continue
                card.check_options(*_ALWAYS, *options)
                with refusing(card.error):
                    found[name] = read(self, card, _Place(part, turn, members[own]))
        for of_name, card in adding:
            name = groups.get(key(of_name), "")
            if name not in found or found[name] is not self.source.given.get(key(name)):
                raise card.error(
                    f"it is not supported; take it into the section of {of_name} by "
                    "read_sections(given=), or delete it"
                )
        if self.normals and not all(isinstance(each, Solid | Beam) for each in found.values()):
            self.source.left_out.append(
                "normals at nodes are left out: shells have normals of their elements"
            )
        for _, card in self.deck.cards:
            if card.name == "RELEASE" and any(isinstance(each, Beam) for each in found.values()):
                raise card.error(
                    "hinges are not supported; delete it if the beams may be joined rigidly"
                )
            if card.name in _BESIDE:
                self.source.left_out.append(f"*{card.name} is left out")
        return found

    # ------------------------------------------------------------------- materials

    def material(self, name: str, card: Keyword) -> Solid:
        """Return a material by its name; the card is the one that names it."""
        at = key(name)
        given: Solid | None = self.source.instead(name)
        if given is not None:
            return given
        if at not in self._made:
            if at not in self.cards:
                raise card.error(f"there is no *MATERIAL {name!r}")
            own = self.cards[at]
            if missing := {"ELASTIC", "DENSITY"}.difference(own):
                raise own["MATERIAL"].error(
                    f"{name} has no *{min(missing)}; write it, or give read_sections(given="
                    f"{{{name!r}: Material(...)}})"
                )
            if left := [f"*{each}" for each in own if _LEFT_OUT.fullmatch(each)]:
                self.source.left_out.append(f"{name} is elastic, without its {', '.join(left)}")
            own["DENSITY"].check_options()
            (rho,) = _constants(own["DENSITY"], 1)
            elastic = own["ELASTIC"]
            elastic.check_options("TYPE", "MODULI")
            kind = key(elastic.options.get("TYPE", "ISO"))
            if kind not in _ELASTIC:
                raise elastic.error(f"TYPE={kind} is none of {', '.join(_ELASTIC)}")
            count, make = _ELASTIC[kind]
            with refusing(elastic.error):
                self._made[at] = make(self.source, *_constants(elastic, count), rho)
        return self._made[at]

    # ---------------------------------------------------------------- orientations

    def axes(self, name: str, card: Keyword, place: _Place) -> tuple[FloatArray, int]:
        """Return an orientation's unit axes in rows, and the number of the one in its second line.

        The other axes are turned about this one. Without such a line it is the third; where it is
        blank there the first, as in Abaqus.
        """
        found = {
            part: one
            for part, one in self.deck.cards
            if one.name == "ORIENTATION" and key(one.options.get("NAME", "")) == key(name)
        }
        own = found.get(place.part) or found.get("")
        if own is None:
            raise card.error(f"there is no *ORIENTATION {name!r}")
        own.check_options("NAME", "SYSTEM", "DEFINITION")
        kind = [key(own.options.get(each, "")) for each in ("SYSTEM", "DEFINITION")]
        if kind[0] not in ("", "RECTANGULAR") or kind[1] not in ("", "COORDINATES"):
            raise own.error("only rectangular axes by coordinates are supported")
        first, *rest = own.real_rows(9, 2, what="points on the axes, and an axis and an angle") or [
            []
        ]
        a, b, c = np.array([*first, *[0.0] * 9][:9]).reshape(3, 3)
        x, z = a - c, np.cross(a - c, b - c)
        if not np.linalg.norm(z) > _NORMAL * np.linalg.norm(x) * np.linalg.norm(b - c):
            raise own.error("its points are on one line")
        axes = unit(np.array([x, np.cross(z, x), z]))
        about, angle = [*rest[0], 0.0, 0.0][:2] if rest else (3.0, 0.0)
        if not about and angle:
            self.differs(f"{name}: its angle is about axis 1, which is blank", "leaves it out")
        about = about or 1.0
        if about not in (1.0, 2.0, 3.0):
            raise own.error(f"the axis of rotation must be 1, 2 or 3, got {about:g}")
        turn = Rotation.from_rotvec(angle * axes[int(about) - 1], degrees=True)
        return turn.apply(axes) @ place.turn.T, int(about)

    def along(self, name: str, card: Keyword, place: _Place) -> FloatArray:
        """Return the direction whose projection is axis 1 of a shell with an orientation.

        It is the axis that follows the one near the normal, which is the third without a second
        line. Without a name it is x; z where x is the normal.
        """
        normals = self.source.directions(place.members)
        if not name:
            level = np.linalg.norm(np.cross(normals, [1.0, 0.0, 0.0]), axis=1) < _NORMAL
            if level.any() and not level.all():
                raise card.error("x is the normal of some elements; give an *ORIENTATION")
            return np.array([0.0, 0.0, 1.0] if level.all() else [1.0, 0.0, 0.0])
        axes, near = self.axes(name, card, place)
        if np.abs(normals @ axes[near - 1]).min() < _ALONG:
            raise card.error(
                f"axis {near} of the orientation {name} lies in some elements; name the axis "
                "along the normal in the second line of *ORIENTATION"
            )
        if near != 3:
            self.differs(f"{name}: axis {near} is along the normals", "projects axis 1 on them")
        return np.asarray(axes[near % 3])

    def differs(self, of: str, other: str) -> None:
        """Name an orientation that CalculiX takes otherwise, if the deck may be for it."""
        if len(self.deck.instances) == 1:  # CalculiX has no parts
            self.source.left_out.append(
                f"*ORIENTATION {of}: taken as in Abaqus; CalculiX {other} (write the fibres as "
                "axis 1, and 3 in the second line)"
            )

    def angle(self, name: str, reference: FloatArray, card: Keyword, place: _Place) -> float:
        """Return the angle, degrees, from a direction to axis 1 of a ply's own orientation."""
        normals = self.source.directions(place.members)
        first, own = (across(v, normals) for v in (reference, self.along(name, card, place)))
        sine = np.einsum("ni,ni->n", np.cross(first, own), normals)
        angles = np.arctan2(sine, np.einsum("ni,ni->n", first, own))
        if np.abs(np.exp(1j * angles) - np.exp(1j * angles[0])).max() > _ANGLE:
            raise card.error(
                f"the orientation {name} is at several angles to that of the first ply"
            )
        return float(np.degrees(angles[0]))


# -------------------------------------------------------------------------------- sections


def _solid(reader: Reader, card: Keyword, place: _Place) -> OneMaterial:
    found = reader.material(card.options.get("MATERIAL", ""), card)
    if isinstance(found, Orthotropic) and (name := card.options.get("ORIENTATION")):
        axes: Any = reader.axes(name, card, place)[0]
        return replace(found, axes=axes)
    return found


def _shell(reader: Reader, card: Keyword, place: _Place) -> OneMaterial:
    options, name = card.options, card.options.get("ORIENTATION", "")
    rows = [[*texts, "", "", ""][:4] for texts in card.rows]
    if "COMPOSITE" not in options:
        if not options.get("MATERIAL") or len(rows) != 1:
            raise card.error("give MATERIAL=, and its thickness in one line")
        rows = [[rows[0][0], "", options["MATERIAL"], ""]]
    if not rows:
        raise card.error("it has no plies")
    made = [reader.material(row[2], card) for row in rows]
    fibrous = [row[3] for row, of in zip(rows, made, strict=True) if isinstance(of, Orthotropic)]
    # CalculiX gives plies orientations, Abaqus angles from that of the section.
    axis = name or (fibrous[0] if fibrous and all(map(_is_name, fibrous)) else "")
    plies = []
    for i, ((thickness, _, _, turned), own) in enumerate(zip(rows, made, strict=True)):
        length, angle = card.reals(i, [thickness, "" if _is_name(turned) else turned])
        if isinstance(own, Orthotropic) and _is_name(turned):
            angle = reader.angle(turned, reader.along(axis, card, place), card, place)
        plies.append(Ply(length * reader.source.length, own, angle))
    if "SYMMETRIC" in options:
        plies += plies[::-1]
    total = sum(ply.thickness for ply in plies)
    text = key(options.get("OFFSET", "0"))
    (nodes,) = card.reals(0, [{"SPOS": "0.5", "SNEG": "-0.5"}.get(text, text)])
    return layered(
        plies, lambda: tuple(reader.along(axis, card, place).tolist()), 0.0 - nodes * total
    )


def _is_name(text: str) -> bool:
    return text[:1] not in (*"+-.0123456789", "")


def _beam(reader: Reader, card: Keyword, place: _Place) -> OneMaterial:
    """Return a beam; its z axis is the section's axis 1, and y is against axis 2."""
    source, shape = reader.source, key(card.options.get("SECTION", ""))
    rows = [card.reals(row, texts) for row, texts in enumerate(card.rows)]
    if "MATERIAL" in card.options:
        material: Any = reader.material(card.options["MATERIAL"], card)
    else:
        E, G = [*rows.pop(), 0.0, 0.0][:2] if rows else (0.0, 0.0)
        rho = float(card.options.get("DENSITY") or 0.0)
        if not (E and G and rho):
            raise card.error("give MATERIAL=; or E and G in its third line, and DENSITY=")
        material = source.isotropic(E, 0.5 * E / G - 1.0, rho)
    if shape == "CIRC":
        rows[:1] = [_radius(reader, card, place, row) for row in rows[:1]]
    count, make = (5, None) if shape == "GENERAL" else named(ABAQUS, shape)
    if shape == "ARBITRARY" and rows and rows[0]:  # a line for each wall
        last = int(rows[0][0])
        count, rows = 3 + 3 * last, [[x for row in rows[:last] for x in row], *rows[last:]]
    if [len(row) for row in rows[:2]] not in ([count], [count, 3]):
        raise card.error(f"give {count} numbers of the section, then all three of axis 1")
    if make is None:
        area, I11, I12, I22, J = rows[0]
        section: Any = source.numbers(area, (I22, I12, I11), J, np.eye(2), np.zeros((1, 2)))
    else:
        section = make(*(x * source.length for x in rows[0]))
    if isinstance(section, TubularSection):
        return Beam(section, material)
    if reader.deck.towards[place.members].any():
        raise card.error("nodes of its elements say how it is turned; write axis 1 instead")
    if reader.normals:
        raise reader.normals.error(
            f"normals would turn the beams of {card.options['ELSET']}; write axis 1 in "
            f"*{card.name} instead"
        )
    n1 = [*rows, [0.0, 0.0, -1.0]][1]
    z = (place.turn @ n1)[None, :]
    return source.beam(section, material, z, place.members, _AXES, np.zeros(3))


def _radius(reader: Reader, card: Keyword, place: _Place, numbers: list[float]) -> list[float]:
    """Return the radius of CIRC, which Abaqus writes; CalculiX writes one or two diameters."""
    if len(numbers) == 2 and numbers[0] != numbers[1]:
        raise card.error("ellipses are not supported")
    if len(numbers) == 2 or any(of.endswith("R") for of in reader.deck.types[place.members]):
        return [0.5 * numbers[0]]  # B31R and B32R are CalculiX' own
    if len(reader.deck.instances) == 1:  # CalculiX has no parts
        of = f"{card.options['ELSET']}: SECTION=CIRC, {numbers[0]:g}"
        reader.source.left_out.append(
            f"{of} is taken for a radius, as in Abaqus; in CalculiX it is the diameter (write it "
            "twice then)"
        )
    return numbers


_OF_SHELLS = (
    *("COMPOSITE", "OFFSET", "ORIENTATION", "SYMMETRIC", "LAYUP", "SECTIONINTEGRATION"),
    *("TEMPERATURE", "POISSON"),
)
_OF_BEAMS = ("SECTION", "TEMPERATURE", "POISSON", "ROTARYINERTIA", "DENSITY")

# How sections are read, their dimension, the types of their elements, and options they may have.
_SECTIONS: dict[str, tuple[Callable[..., OneMaterial], int, str, tuple[str, ...]]] = {
    "SOLIDSECTION": (_solid, 3, "C3D", ("ORIENTATION",)),
    "SHELLSECTION": (_shell, 2, r"S\d|STRI|US\d", _OF_SHELLS),
    "SHELLGENERALSECTION": (_shell, 2, r"S\d|STRI|US\d", _OF_SHELLS),
    "BEAMSECTION": (_beam, 1, r"B3\d", _OF_BEAMS),
    "BEAMGENERALSECTION": (_beam, 1, r"B3\d", _OF_BEAMS),
}


# ------------------------------------------------------------------------------- materials


def _constants(card: Keyword, count: int) -> list[float]:
    """Return the constants of a card that holds at one temperature."""
    rows = [card.reals(row, texts) for row, texts in enumerate(card.rows)]
    numbers = [x for row in rows for x in row]
    if len(rows) > -(-(count + 1) // 8) or len(numbers) > count + 1:
        raise card.error(f"it depends on temperature; write its {count} constants for one")
    if len(numbers) < count:
        raise card.error(f"it has {len(numbers)} of its {count} constants")
    return numbers[:count]


# Kinds of *ELASTIC: the number of their constants, and the materials of these and a density.
_ELASTIC: dict[str, tuple[int, Callable[..., Solid]]] = {
    **dict.fromkeys(("ISO", "ISOTROPIC"), (2, Source.isotropic)),
    "LAMINA": (6, Source.ply),
    "ENGINEERINGCONSTANTS": (9, Source.orthotropic),
}
