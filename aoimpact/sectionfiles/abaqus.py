"""Sections and materials of decks of Abaqus and CalculiX."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base import FloatArray, InputError, IntArray
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
from ..mesh import AbaqusDeck, Keyword, key
from .common import Source, across, common, layered, refusing

# Options of a material that change its answer and are left out.
_LEFT_OUT = re.compile(
    "(CYCLIC|RATEDEPENDENT|)PLASTIC|CYCLICHARDENING|RATEDEPENDENT|CREEP|DAMPING|VISCO.*|HYSTERESIS"
    "|DAMAGE.*|FAIL.*|HYPER.*|.*PLASTICITY|.*CRACKING|NOCOMPRESSION|NOTENSION|USERMATERIAL"
)

# Other keywords that change mass or stiffness of shells and beams.
_BESIDE = re.compile("NONSTRUCTURALMASS|NORMAL|TRANSVERSESHEAR(STIFFNESS)?|SECTIONSTIFFNESS")

# Least share of an orientation's axis along the normals of the shell that it is for.
_ALONG = 1e-3

# Sine of the angle to the normal below which x is no direction on a shell: 0.1 degrees.
_NORMAL = 1.745e-3

# Largest difference of an angle between two orientations over a shell, rad.
_ANGLE = 1e-4

_ALWAYS = ("ELSET", "MATERIAL", "CONTROLS")


class _Place(NamedTuple):
    """Where a section is: its part, the turn of the instance, and its cells."""

    part: str
    turn: FloatArray
    members: IntArray


def sections(source: Source, deck: AbaqusDeck) -> dict[str, OneMaterial]:
    """Return the sections of a deck by the groups of its mesh."""
    return _Reader(source, deck).sections()


@dataclass(eq=False)
class _Reader:
    """The cards of a deck by name, and its materials, each made once."""

    source: Source
    deck: AbaqusDeck
    _made: dict[str, Solid] = field(default_factory=dict)

    @cached_property
    def orientations(self) -> dict[tuple[str, str], Keyword]:
        """The orientations by their part and name."""
        return {
            (part, key(card.options.get("NAME", ""))): card
            for part, card in self.deck.cards
            if card.name == "ORIENTATION"
        }

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
        for part, card in self.deck.cards:
            if _BESIDE.fullmatch(card.name):
                self.source.left_out.append(f"*{card.name} is left out")
            if card.name not in _SECTIONS:
                continue
            read, types, options = _SECTIONS[card.name]
            for before, turn in self.deck.instances.get(part, []):
                name = groups.get(key(before + card.options.get("ELSET", "")))
                if name is None:
                    raise card.error(f"there is no ELSET {card.options.get('ELSET', '')!r}")
                members = self.source.raw.cell_sets[name]
                own = [re.match(types, of) is not None for of in self.deck.types[members].tolist()]
                if not any(own):
                    continue  # of trusses, membranes and the like, which no body has
                if name in found:
                    raise card.error(f"{name} has another section")
                if (of := self.source.instead(name)) is not None:
                    found[name] = of
                    continue
                card.check_options(*_ALWAYS, *options)
                with refusing(card.error):
                    found[name] = read(self, card, _Place(part, turn, members[own]))
        return found

    # ------------------------------------------------------------------- materials

    def material(self, name: str, card: Keyword) -> Solid:
        """Return a material by its name; the card is the one that names it."""
        at = key(name)
        if isinstance(given := self.source.instead(name), Solid):
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
                raise elastic.error(
                    f"TYPE={kind} is not supported; it may be {', '.join(_ELASTIC)}"
                )
            count, make = _ELASTIC[kind]
            with refusing(elastic.error):
                self._made[at] = make(self.source, *_constants(elastic, count), rho)
            if kind == "LAMINA":
                self.source.left_out.append(f"{name} has no E3: that of contact is E2")
        return self._made[at]

    # ---------------------------------------------------------------- orientations

    def axes(self, name: str, card: Keyword, place: _Place) -> tuple[FloatArray, int]:
        """Return an orientation's unit axes in rows, and the number of the one in its second line.

        The number is 0 without such a line. The other axes are turned about this one.
        """
        found = [self.orientations.get((part, key(name))) for part in (place.part, "")]
        own = found[0] or found[1]
        if own is None:
            raise card.error(f"there is no *ORIENTATION {name!r}")
        own.check_options("NAME", "SYSTEM", "DEFINITION")
        kind = [key(own.options.get(each, "")) for each in ("SYSTEM", "DEFINITION")]
        if kind[0] not in ("", "RECTANGULAR") or kind[1] not in ("", "COORDINATES"):
            raise own.error("only rectangular axes by coordinates are supported")
        rows = own.real_rows(9, 2, what="points on the axes, and an axis and an angle")
        if not rows:
            raise own.error("it has no points")
        a, b, c = np.array([*rows[0], *[0.0] * 9][:9]).reshape(3, 3)
        x, z = a - c, np.cross(a - c, b - c)
        if not np.linalg.norm(z) > _NORMAL * np.linalg.norm(x) * np.linalg.norm(b - c):
            raise own.error("its points are on one line")
        axes = np.array([x, np.cross(z, x), z])
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        about, angle = [*rows[1], 0.0, 0.0][:2] if len(rows) > 1 else (0.0, 0.0)
        if about not in (0.0, 1.0, 2.0, 3.0):
            raise own.error(f"the axis of rotation must be 1, 2 or 3, got {about:g}")
        if angle:
            i, j = int(about) % 3, (int(about) + 1) % 3
            cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
            axes[[i, j]] = [cos * axes[i] + sin * axes[j], cos * axes[j] - sin * axes[i]]
        return axes @ place.turn.T, int(about)

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
                f"axis {near or 3} of the orientation {name} lies in some elements; name the axis "
                "along the normal in the second line of *ORIENTATION"
            )
        return np.asarray(axes[near % 3])

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


def _solid(reader: _Reader, card: Keyword, place: _Place) -> OneMaterial:
    found = reader.material(card.options.get("MATERIAL", ""), card)
    if isinstance(found, Orthotropic) and (name := card.options.get("ORIENTATION")):
        axes: Any = reader.axes(name, card, place)[0]
        return replace(found, axes=axes)
    return found


def _shell(reader: _Reader, card: Keyword, place: _Place) -> OneMaterial:
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


def _beam(reader: _Reader, card: Keyword, place: _Place) -> OneMaterial:
    """Return a beam; its z axis is the section's axis 1, and y is against axis 2."""
    general, shape = card.name == "BEAMGENERALSECTION", key(card.options.get("SECTION", ""))
    if shape not in _SHAPES or (shape == "GENERAL" and not general):
        raise card.error(
            f"SECTION={shape} is not supported; give its Beam by read_sections(given=)"
        )
    powers, make = _SHAPES[shape]
    rows = [card.reals(row, texts) for row, texts in enumerate(card.rows)]
    if general and len(rows) == 2:  # without a direction
        rows.insert(1, [0.0, 0.0, -1.0])
    first, n1, *rest = [*rows, [0.0, 0.0, -1.0]] if len(rows) == 1 else rows or [[], []]
    if shape == "CIRC":
        first = _radius(reader, card, place, first)
    if len(first) != len(powers) or len(n1) != 3:
        raise card.error(f"give {len(powers)} numbers of the section, then all three of axis 1")
    section = make(*(x * reader.source.length**n for x, n in zip(first, powers, strict=True)))
    if general:
        modulus, shear = [*(rest or [[]])[0], 0.0, 0.0][:2]
        rho = float(card.options.get("DENSITY") or 0.0)
        if not (modulus and shear and rho):
            raise card.error("give E and G in its third line, and DENSITY=")
        material: Solid = reader.source.isotropic(modulus, 0.5 * modulus / shear - 1.0, rho)
    else:
        material = reader.material(card.options.get("MATERIAL", ""), card)
    if not isinstance(material, Material):
        raise card.error("a beam needs an isotropic material")
    if isinstance(section, TubularSection):
        return Beam(section, material)
    if reader.deck.towards[place.members].any():
        raise card.error("nodes of its elements say how it is turned; write axis 1 instead")
    axis = place.turn @ n1
    if common(axis[None, :], reader.source.directions(place.members)) is None:
        raise card.error(f"axis 1, {n1}, is along some of its elements")
    return Beam(section, material, orientation=np.round(axis, 12))


def _radius(reader: _Reader, card: Keyword, place: _Place, numbers: list[float]) -> list[float]:
    """Return the radius of CIRC, which Abaqus writes; CalculiX writes one or two diameters."""
    if len(numbers) == 2 and numbers[0] != numbers[1]:
        raise card.error("ellipses are not supported")
    if len(numbers) == 2 or any(of.endswith("R") for of in reader.deck.types[place.members]):
        return [0.5 * numbers[0]]  # B31R and B32R are CalculiX' own
    reader.source.left_out.append(
        f"CIRC of {card.options['ELSET']} is given by its radius, as in Abaqus (CalculiX takes one "
        "number for the diameter; write it twice then)"
    )
    return numbers


def _numbers(area: float, I11: float, I12: float, I22: float, J: float) -> BeamSection:
    if I12:
        raise InputError(f"I12={I12:g} is not supported: give principal axes")
    return BeamSection(area, Iy=I22, Iz=I11, J=J, shear_factors=(1.0, 1.0))


# Shapes of beams: the powers of length in their numbers, and their sections.
_SHAPES: dict[str, tuple[tuple[int, ...], Callable[..., Any]]] = {
    "RECT": ((1, 1), lambda a, b: RectangularSection(width=b, height=a)),
    "CIRC": ((1,), CircularSection),
    "PIPE": ((1, 1), TubularSection),
    "GENERAL": ((2, 4, 4, 4, 4), _numbers),
}

_OF_SHELLS = (
    *("COMPOSITE", "OFFSET", "ORIENTATION", "SYMMETRIC", "LAYUP", "SECTIONINTEGRATION"),
    *("TEMPERATURE", "POISSON"),
)
_OF_BEAMS = ("SECTION", "TEMPERATURE", "POISSON", "ROTARYINERTIA", "DENSITY")

# How sections are read, the types of their elements, and the options that they may have.
_SECTIONS: dict[str, tuple[Callable[..., OneMaterial], str, tuple[str, ...]]] = {
    "SOLIDSECTION": (_solid, "C3D", ("ORIENTATION",)),
    "SHELLSECTION": (_shell, r"S\d|STRI|US\d", _OF_SHELLS),
    "SHELLGENERALSECTION": (_shell, r"S\d|STRI|US\d", _OF_SHELLS),
    "BEAMSECTION": (_beam, r"B3\d", _OF_BEAMS),
    "BEAMGENERALSECTION": (_beam, r"B3\d", _OF_BEAMS),
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


def _of_engineers(source: Source, *of: float) -> Solid:
    return source.orthotropic(of[:3], of[3:6], of[6:9], of[9])


def _of_stiffness(source: Source, *of: float) -> Solid:
    """D1111, D1122, D2222, D1133, D2233, D3333, D1212, D1313, D2323."""
    compliance = np.linalg.inv(np.array(of)[[[0, 1, 3], [1, 2, 4], [3, 4, 5]]])
    E = 1.0 / np.diag(compliance)
    nu = [-compliance[i, j] * E[i] for i, j in ((0, 1), (0, 2), (1, 2))]
    return source.orthotropic(E.tolist(), nu, of[6:9], of[9])


# Kinds of *ELASTIC: the number of their constants, and the materials of these and a density.
_ELASTIC: dict[str, tuple[int, Callable[..., Solid]]] = {
    **dict.fromkeys(("ISO", "ISOTROPIC"), (2, Source.isotropic)),
    "LAMINA": (6, Source.ply),
    "ENGINEERINGCONSTANTS": (9, _of_engineers),
    **dict.fromkeys(("ORTHO", "ORTHOTROPIC"), (9, _of_stiffness)),
}
