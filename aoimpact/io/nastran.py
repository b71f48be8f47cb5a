"""Meshes, groups, sections and matrices from the bulk data of Nastran decks.

To read a new kind of entry, add an element to `_ELEMENTS`, a property to `_DIMENSIONS` and
`_PROPERTIES`, a material to `_MATERIALS`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..base import PRINTED, ArrayPair, FloatArray, IntArray, MeshError, record, warn
from ..fem import Material, OneMaterial, Orthotropic, Ply, Solid
from ..mesh import jacobian_range, reference_element
from .nastrandeck import INTEGER, BulkData, Card, Table, read_deck
from .profiles import NASTRAN, Profile, named
from .raw import (
    UPRIGHT_FIRST,
    Line,
    RawBlock,
    RawMatrix,
    RawMesh,
    cells_of,
    joined,
    labelled,
    listed,
    nodes_in,
    number,
    once,
    passed_over,
    repeats,
    rows_of,
)
from .sections import Axes, Source, across, common, layered, refusing, triad

# meshio's kinds of elements, without and with midside nodes, for the names of Nastran's entries.
_ELEMENTS = {
    ("CTETRA",): ("tetra", "tetra10"),
    ("CHEXA",): ("hexahedron", "hexahedron20"),
    ("CPENTA",): ("wedge", "wedge15"),
    ("CPYRAM", "CPYRA"): ("pyramid", "pyramid13"),
    ("CTRIA3", "CTRIAR"): ("triangle",),
    ("CTRIA6",): ("triangle", "triangle6"),
    ("CQUAD4", "CQUADR", "CSHEAR"): ("quad",),
    ("CQUAD8",): ("quad", "quad8"),
    ("CBAR", "CBEAM", "CBEND", "CROD", "CTUBE"): ("line",),
    ("CONROD",): ("line",),
    ("CBEAM3",): ("line", "line3"),
}

# Largest number of data fields of an element's entry. Solids, which are not listed, have a number,
# a property and nodes.
_FIELDS = {
    **dict.fromkeys(("CTRIA3", "CTRIAR"), 13),
    **dict.fromkeys(("CQUAD4", "CQUADR", "CTRIA6"), 14),
    **{"CQUAD8": 17, "CSHEAR": 6, "CBAR": 16, "CBEAM": 18, "CBEAM3": 23},
    **dict.fromkeys(("CBEND", "CROD", "CTUBE", "CONROD"), 8),
}
_READ = {name for names in _ELEMENTS for name in names} | {
    *("GRID", "SET", "SET1", "SET3"),
    *(f"CORD{i}{kind}" for i in "12" for kind in "RCS"),
}

# Patterns of the names of property entries, by the dimension of their elements.
_DIMENSIONS = {
    1: re.compile("P(BAR|BARL|BEAM|BEAML|BEAM3|BCOMP|B[MR]SECT|BEND|ROD|TUBE)"),
    2: re.compile("P(SHELL|COMPG?|SHEAR|L?PLANE|SHLN[12])"),
    3: re.compile("P(SOLID|LSOLID|COMPL?S)"),
}

# Pattern of the names of constraints between nodes, which a mesh cannot represent.
_CONNECTIONS = re.compile(
    "MPC|MPCY|RBAR|RBAR1|RBE1|RBE2|RBE2GS|RBE3|RBODY|RJOINT|RROD|RSPLINE|RSSCON|RTRPLT|RTRPLT1"
    "|RBAX3D|RBJOINT|RSPINR|RSPINT|RWELD|RCROSS|CONNECT"
)

# Pattern of the names of elements other than solids, surfaces and lines in space.
_OTHERS = re.compile(
    "CAABSF|CACINF[34]|CAXIF[234]|CAXISYM|CBARG|CBEAR|CBELT|CBUSH|CBUSH1D|CBUSH2D|CBUTT|CCONEAX"
    "|CCRSFIL|CDAMP[1-5]D?|CDUM[1-9]|CELAS[1-4]D?|CFAST|CFILLET|CFLUID[234]|CFTUBE|CGAP|CGAPG"
    "|CHACAB|CHACBR|CHBDY[EGP]?|CHEXCZ|CIF(HEX|PENT|QDX|QUAD)|CMASS[1-4]|CMBUSH|CMREB[AE]|CMSPRNG"
    "|CONM[12]|CPENTCZ|CPLST[NS][3468]|CQDX[49]|CQUAD|CQUADX[48]?|CRAC[23]D|CSEAM|CSLOT[34]|CSPOT"
    "|CSPR|CSSHL[HLMP]?|CTRAX[36]|CTRIAX|CTRIAX6|CTRIX[36]|CVISC|CWELD|CWSEAM|GENEL"
)

# Pattern of entries without influence on the mesh: materials, loads, tables and so on. It has the
# beginnings of names, or whole names (with $) if they are similar to GRID, CORD or elements C….
_SKIPPED = re.compile(
    "(AB|AC|ADAPT|AE|AIRBAG|AL|AMLREG|ASET|ASSIG|ATB|ATTACH|ATV|AX|BAR|BC|BD|BEAD|BEAMOR|BEDGE|BFRIC|BG|BIAS"
    "|BJOIN|BLD|BLSEG|BMFACE|BN|BOLT|BOUTPUT|BRKSQL|BS|CO(NCTL|HESIV|HFRIC|HSEIV|MBINE|MBWLD"
    "|MPUDS|NTPRM|NTRLT|NV|NVM|NV3|NTACT|NTSET|UCOHF|UOPT|UP1FL|UP1INT|UPINT|UPLE1?)$"
    "|C(AERO|AMPBL|BARAO$|CELL|ELLBOX|ELLWNG|FASTG|INTC|LOAD|NGRNT|REEP|SET|SSCHD|SUP|YAX|YC|YJ|YL"
    "|YS)|D2R|DAMP|DAREA|DAVDIS|DC|DDVAL|DEACTEL|DEBUG$|DEFORM|DEFUSET|DELAY|DELETE|DEQATN|DES|DETSPH"
    "|DGLOBAL|DISTORT|DIVERG|DLINK|DLOAD|DM|DO|DPHASE|DR|DSCONS|DSCREEN|DSHAPE|DT|DV|DY|EBDSET"
    "|ECHO|EIG|ELAR|ELEMUDS|ELIST|ENDDYNA|ENTUDS|EOS|EPOINT|EPSD|ERP|EUL|EVENT|EXPLSV|EXT|FAIL"
    "|FATDEF|FATEVNT|FATLOAD|FATPARM|FATSEQ|FBA|FBODY|FFCONTR|FL|FORC|FR[EFSS]|FSI|FSLIST|FTG"
    "|GAP|GASKET|GBAG|GENGAF|GENUDS|GMBC|GMLOAD|GMSPC|GRAV|GRDSET$|GRID[BFS]$|GROUP|GUST|HADA"
    "|HEATLOS|HGSUPPR|HTR|HY[BD]|IN[FI]|INPCFD|IPSTRAIN|ISTR|ITER|LAMLOSS|LEAKAGE|LIST|LOAD|LSEQ"
    "|M2|MARC|MASSSET|MAT|MBOLT|MCHSTAT|MCOHE|MDL|MDMIOUT|MESH|METADATA|MFLUID|MFUN|MHEATSHL"
    "|MICPNT|MINSTAT|MK|MLOAD|MODTRAK|MOMAX|MOMENT|MON|MPCADD|MPHEAT|MPOINT|MPROCS|MSTACK|MTAB"
    "|MTHERM|NHRMPRM|NL|NOL|NSM|NTHICK|OMIT|OUTPUT|OUTRCV|OVERLAP|P[A-Z]|Q|RAD|RAND|RBODY|RCONN"
    "|RCROSSC|RELAX|RELEASE|RELEX|RESTART|RESVEC|RFORCE|RGYRO|RING|RLOAD|ROT|RVDOF|SEB|SEC|SED"
    "|SEEL|SELA|SELO|SEMP|SENQSET|SEQ|SESET|SESUP|SET[23]$|SETREE|SEU|SHREL|SHRPOL|SHRUDS|SLBDY"
    "|SLOAD|SNORM|SP[BCHLR]|SPOINT$|STFLOW|STOCHAS|SU|SW|TA|TCNTPRM|TEMP|TERMIN|TF|THPAD|TIC|TIM"
    "|TLOAD|TMCPARA|TMPSET|TO|TR[IM]|TST|TTEMP|UD|UNBALNC|UNGLUE|UPDATE|USET|UXVEC|VA|VC|VE"
    "|VIEW|WALL|WET|WINDOW|YLD|YPARAM$|YZONE)"
)

# Pattern of case-control commands that add matrices to the elements' matrices.
_ADDED = re.compile(rb"\s*([ABKM]4?2(?:GG|PP))\b")

_SET = re.compile(r"SET\s+(\d+)\s*=(.*)")

# Pattern of a number in a set, or of a range with the numbers that follow it, such as
# 1 THRU 20 BY 2 EXCEPT 7 9.
_MEMBER = re.compile(
    r"(\d+)(?: THRU (\d+)(?: BY 0*([1-9]\d*))?((?: EXCEPT| \d+(?!\d| THRU))*))?(?: |$)"
)

# Kinds of the numbers in a SET or SET3 of bulk data, by its type. Other types are left out.
_BOTH = ("nodes", "elements")
_MEMBERS = {"GRID": _BOTH[:1], "NODE": _BOTH[:1], "ELEM": _BOTH[1:], "ELEMENT": _BOTH[1:]}


def read(file: Path) -> RawMesh:
    """Return the mesh of a Nastran deck.

    Elements with the same property make a group such as "property 3". If a property of shells and
    one of bars have the same number, the bars make the group "property 3 lines". A set (SET of the
    case control; SET1, SET3, SET of bulk data) becomes "SET 5 nodes" if all its numbers are numbers
    of nodes, and "SET 5 elements" if all are numbers of elements; often it becomes both.

    Raises
    ------
    MeshError
        If a line is not understood; file and line are named.
    MemoryLimitError

    Warns
    -----
    AOImpactWarning
        If elements or connections are left out.
    """
    control, bulk = read_deck(file)
    grids = Grids.of(bulk)
    nodes = grids.coordinates()
    parts = [part for names in _ELEMENTS for part in _elements(bulk, names, grids)]
    for part in parts:
        if part.block.dim == 3:  # Nastran accepts left-handed solids, too
            element, cells = reference_element(part.block.kind), part.block.cells
            left = jacobian_range(nodes, cells, element)[1] < 0.0
            cells[left] = cells[left][:, element.mirror]
    raw = RawMesh(nodes, tuple(part.block for part in parts))
    labels = joined([] if raw.cell_labels is None else [raw.cell_labels])
    for row in repeats(labels)[:1].tolist():
        at = int(raw.block_of(row))
        raise parts[at].table.refused(row - raw.first[at], f"element {labels[row]} is there twice")
    cell_sets = _by_property(bulk, parts, raw.dims)
    node_sets = {}
    for name, (kinds, text) in _sets(control, bulk).items():
        if "nodes" in kinds:
            node_sets[f"{name} nodes"] = _among(text, grids.labels)
        if "elements" in kinds:
            cell_sets[f"{name} elements"] = _among(text, labels)
    connected = "connect nodes and were left out; the body is computed without them"
    added = {match[1].decode() for line in control if (match := _ADDED.match(line.text))}
    for what, said in (
        ("add matrices to those of the elements and were left out", ", ".join(sorted(added))),
        ("are no part of the mesh and were left out", _counted(bulk, _OTHERS)),
        (connected, _counted(bulk, _CONNECTIONS)),
    ):
        if said:
            warn(f"mesh file {str(file)!r}: {said} {what}")
    own = NastranDeck(control, bulk, grids, parts)
    return RawMesh(nodes, raw.blocks, node_sets, cell_sets, grids.labels, deck=own)


def _counted(bulk: BulkData, *patterns: re.Pattern[str]) -> str:
    """Return the count of entries for each name that fits a pattern, as in "2 PSHELL"."""
    fits = (name for name in bulk.names if any(of.fullmatch(name) for of in patterns))
    return listed((name, len(bulk.names[name])) for name in fits)


# ----------------------------------------------------------------------------------- elements


class Entries(NamedTuple):
    """Elements of one kind: their entries, the mesh block, and their property numbers (0: none).

    `layout` is the kind that fills all node fields of the entries: "quad8" for CQUAD8, even if
    midside nodes are blank.
    """

    table: Table
    block: RawBlock
    properties: IntArray
    layout: str


def _elements(bulk: BulkData, names: tuple[str, ...], grids: Grids) -> Iterator[Entries]:
    """Yield the elements of the named entries: first without midside nodes, then with them."""
    kinds = _ELEMENTS[names]
    corners, most = nodes_in(kinds[0]), nodes_in(kinds[-1])
    table = bulk.table(**{name: _FIELDS.get(name, 2 + most) for name in names})
    first = 1 if names == ("CONROD",) else 2  # CONROD has no property field
    quadratic = np.any(~table.blank[:, first + corners : first + most], axis=1)
    for kind, own in zip(kinds, (~quadratic, quadratic), strict=False):
        if not own.any():
            continue
        part = table.select(own)
        labels = part.integers(0, 1)[:, 0]
        part.refuse_first(labels < 1, "an element needs a number greater than 0")
        properties = part.integers(1, 1)[:, 0] * (first > 1)
        properties = np.where(part.blank[:, 1], labels, properties)
        numbers = part.integers(first, nodes_in(kind))
        missing = (numbers == 0).any(axis=1)
        part.refuse_first(missing, "nodes are missing; give all midside nodes or none")
        cells = cells_of(grids.labels, labels, numbers, part.refused)
        cells = cells[:, UPRIGHT_FIRST.get(kind, slice(None))]
        yield Entries(part, RawBlock(kind, cells, labels), properties, kinds[-1])


def _by_property(bulk: BulkData, parts: list[Entries], dims: IntArray) -> dict[str, IntArray]:
    """Return the groups of elements by property.

    Elements of several dimensions may share a property number. Elements of the lower dimension make
    a separate group if the deck has a property of this number for their dimension. Otherwise they
    are sides and edges to which a mesher gave the number.
    """
    properties, found = joined(part.properties for part in parts), {}
    known = {dim: {card.text(0).lstrip("+0") for card in _properties(bulk, dim)} for dim in (1, 2)}
    for label in np.unique(properties[properties > 0]).tolist():
        own = properties == label
        for dim, what in ((1, "lines"), (2, "surfaces")):
            lower = own & (dims == dim)
            if dim < dims[own].max() and lower.any() and str(label) in known[dim]:
                found[f"property {label} {what}"] = np.flatnonzero(lower)
                own &= ~lower
        found[f"property {label}"] = np.flatnonzero(own)
    return found


def _properties(bulk: BulkData, dim: int) -> Iterator[Card]:
    """Return all property entries for elements of a dimension, including unsupported ones."""
    return bulk.cards(*filter(_DIMENSIONS[dim].fullmatch, bulk.names))


# --------------------------------------------------------------- nodes and coordinate systems


# Definition of a coordinate system: its kind; three nodes (CORD1x), or the system of its points
# (CORD2x); the nine coordinates of the three points (CORD2x); and the function that makes errors of
# the entry.
_Definition = tuple[tuple[str, tuple[int, ...], tuple[float, ...]], Callable[[str], MeshError]]


@record
class Grids:
    """Nodes by ascending labels, and coordinate systems, whose axes are computed on demand.

    Attributes
    ----------
    table : Table
        GRID entries of the nodes.
    labels : ndarray of int, shape (n,)
        Numbers of the nodes.
    systems, output_systems : ndarray of int, shape (n,)
        Labels of the coordinate systems of coordinates (CP) and displacements (CD).
    x : ndarray, shape (n, 3)
        Coordinates in the systems CP.
    definitions : mapping of int to _Definition
        Coordinate systems whose axes are not computed yet, by label.
    """

    table: Table
    labels: IntArray
    systems: IntArray
    output_systems: IntArray
    x: FloatArray
    definitions: dict[int, _Definition]
    _known: dict[int, Axes] = field(default_factory=lambda: {0: Axes()})

    @classmethod
    def of(cls, bulk: BulkData) -> Grids:
        """Return the nodes of a deck; a node that is repeated identically counts once."""
        for name, entries in bulk.names.items():  # unknown entries might belong to the mesh
            known = (_CONNECTIONS.fullmatch, _OTHERS.fullmatch, _SKIPPED.match)
            if name not in _READ and not any(match(name) for match in known):
                raise entries[0][0].line.refused(name, "no entry of this name is known")
        table = bulk.table(GRID=8)
        systems = [table.integers(column, 1)[:, 0] for column in (1, 5)]
        labels, x = table.integers(0, 1)[:, 0], table.reals(2, 3)
        table.refuse_first(labels < 1, "a node needs a number greater than 0")
        why = "node {} is there twice, at different places"
        whole = np.column_stack([x, *systems])
        kept = once(labels, whole, lambda row: table.refused(row, why.format(labels[row])))
        own = (labels[kept], systems[0][kept], systems[1][kept], x[kept])
        return cls(table.select(kept), *own, _definitions(bulk))

    def by_system(self, systems: IntArray, of: Table) -> Iterator[tuple[Axes, IntArray]]:
        """Yield each coordinate system named in `systems`, and the rows that name it."""
        for label in np.unique(systems).tolist():
            own = np.flatnonzero(systems == label)
            yield self.axes(label, partial(of.refused, int(own[0]))), own

    def check_output(self, nodes: FloatArray) -> None:
        """Refuse nodes whose displacements (CD) are not along the basic x, y and z."""
        for system, own in self.by_system(np.maximum(self.output_systems, 0), self.table):
            turned = np.abs(system.directions(nodes[own]) - np.eye(3)).max(axis=(1, 2)) > PRINTED
            for row in own[turned][:1].tolist():
                why = f"node {self.labels[row]} has displacements in another system (CD)"
                raise self.table.refused(row, f"{why}; write K with CD = 0")

    def coordinates(self) -> FloatArray:
        """Return basic coordinates of all nodes, shape (n, 3)."""
        x = self.x.copy()
        for system, own in self.by_system(self.systems, self.table):
            x[own] = system.basic(self.x[own])
        return x

    def axes(self, label: int, error: Callable[[str], MeshError]) -> Axes:
        """Return the coordinate system `label`; `error` makes errors that name the referring entry.

        Raises
        ------
        MeshError
            If the system is not defined, refers to itself, or has its points on one line.
        """
        if label in self._known:
            return self._known[label]
        if label not in self.definitions:
            raise error(f"coordinate system {label} has no CORD1x or CORD2x, or refers to itself")
        (kind, of, given), own_error = self.definitions.pop(label)
        if given:
            points = self.axes(of[0], own_error).basic(np.reshape(given, (3, 3)))
        else:
            rows = rows_of(self.labels, np.array(of))
            if (rows < 0).any():
                raise own_error(f"node {of[int(np.argmin(rows))]} is not there")
            own = [self.axes(int(system), own_error) for system in self.systems[rows]]
            points = np.concatenate(
                [a.basic(x[None]) for a, x in zip(own, self.x[rows], strict=True)]
            )
        ends = points[1] - points[0], points[2] - points[0]
        axes = triad(*ends, own_error)[[1, 2, 0]]  # points given: on z, and in the x-z plane
        return self._known.setdefault(label, Axes(kind, points[0], axes))


def _definitions(bulk: BulkData) -> dict[int, _Definition]:
    """Return the coordinate systems of a deck: CORD1x by three nodes, CORD2x by three points."""
    found: dict[int, _Definition] = {}
    for kind, (entry, most) in product("RCS", (("CORD1", 8), ("CORD2", 11))):
        table = bulk.table(**{entry + kind: most})
        numbers = table.integers(0, 4 if most == 8 else 2).tolist()
        points = table.reals(2, 9 if most == 11 else 0).tolist()
        for row, (label, *of) in enumerate(numbers):
            one, error = (kind, tuple(of), tuple(points[row])), partial(table.refused, row)
            if label < 1 or found.setdefault(label, (one, error))[0] != one:
                raise error(f"coordinate system {label} must be > 0, and defined once")
    return found


# ---------------------------------------------------------------------------------------- sets


def _among(text: str, labels: IntArray) -> IntArray:
    """Return the rows of `labels` that are in a set; none if a number outside ranges is no label.

    A number after EXCEPT is excluded if it lies in the range before EXCEPT; otherwise it is a
    number outside ranges.
    """
    chosen, alone = np.zeros(len(labels), dtype=bool), list[int]()
    for first, last, step, behind in _MEMBER.findall(text):
        of = range(int(first), int(last or first) + 1, int(step or 1))
        more, _, without = behind.partition("EXCEPT")
        others = [int(number) for number in without.split() if number.isdigit()]
        alone += [int(number) for number in more.split()]
        alone += [number for number in others if not of.start <= number < of.stop]
        if last:
            within = (labels >= of.start) & (labels < of.stop)
            chosen |= within & ((labels - of.start) % of.step == 0) & ~np.isin(labels, others)
        else:
            alone.append(of.start)
    if not np.isin(alone, labels).all():
        return joined([])
    return np.flatnonzero(chosen | np.isin(labels, alone))


def _sets(control: list[Line], bulk: BulkData) -> dict[str, tuple[tuple[str, ...], str]]:
    """Return, by name such as "SET 5" or "SET1 5", what each set holds, and its numbers.

    A set holds nodes, elements, or both.

    Raises
    ------
    MeshError
        If a set of bulk data is not understood.

    Warns
    -----
    AOImpactWarning
        If the case control defines a set twice, with different members.
    """
    found: dict[str, tuple[tuple[str, ...], str]] = {}
    twice = set()
    lines = iter(line.text.decode().strip() for line in control)
    for line in lines:
        if line.startswith("OUTPUT("):  # sets of plots follow
            break
        while line.endswith(",") and line.startswith("SET"):
            line += " " + next(lines, "")
        if match := _SET.match(line):
            name, text = f"SET {int(match[1])}", " ".join(match[2].replace(",", " ").split())
            valid = text and not _MEMBER.sub("", text)
            if valid and found.setdefault(name, (_BOTH, text))[1] != text:
                twice.add(name)
    if twice:
        listed = ", ".join(sorted(twice))
        warn(f"{listed}: the case control defines it twice, with other members; it was left out")
    found = {name: one for name, one in found.items() if name not in twice}
    for entry, first in (("SET1", 1), ("SET3", 2), ("SET", 8)):
        for card in bulk.cards(entry):
            kinds = _BOTH if entry == "SET1" else _MEMBERS.get(card.text(1), ())
            label = card.integer(0, "SID")
            card = replace(card, name=f"{entry} {label}")
            text = " ".join(word.lstrip("+") for word in card.fields[first:] if word)
            if kinds and (not text or _MEMBER.sub("", text) or label < 0):
                raise card.error("it must be a list of numbers and THRU")
            if kinds and found.setdefault(card.name, (kinds, text)) != (kinds, text):
                raise card.error("it is defined twice, with other members")
    return found


# ----- sections

# Index of the field with a surface element's material angle or system, by `Entries.layout`. The
# next field is the offset; fields 10 to 12 or 13 are thicknesses at the nodes.
_THETA = {"quad": 6, "triangle": 5, "triangle6": 8, "quad8": 14}

_WTMASS = re.compile(rb"\s*PARAM[\s,*]+WTMASS[\s,]+([^\s,]+)")

# Supported first letters of a bar's OFFT, or older flags in this field. The orientation vector is
# in basic axes with B, else in the displacement axes of the first node.
_FRAMES = [b"", b"G", b"1", b"2", b"B"]

# Rows: axes y and z of a `Beam`. Columns: their components along h and v of a section's figure,
# which are Nastran's z and y.
_AXES = np.array([[-1.0, 0.0], [0.0, 1.0]])

# Relative difference between G and E/(2 (1 + NU)) up to which G is ignored without a message.
_ISOTROPIC = 0.01


@dataclass(eq=False)
class NastranDeck:
    """The contents of a deck beyond its mesh, with the entries of each mesh block.

    `source` is the argument of the last `read`.
    """

    control: list[Line]
    bulk: BulkData
    grids: Grids
    parts: list[Entries]
    source: Source = field(init=False)

    @property
    def sections(self) -> str:
        """Counts of the property entries of shells and beams, as in "2 PSHELL"."""
        return _counted(self.bulk, _DIMENSIONS[1], _DIMENSIONS[2])

    def cards(self, cards: Iterable[Card]) -> dict[int, Card]:
        """Return entries by number; refuse different entries with the same number."""
        found: dict[int, Card] = {}
        for card in cards:
            label = card.integer(0, "its number")
            if label < 0 or found.setdefault(label, card).fields != card.fields:
                raise card.error(f"its number must not be negative, or another's, got {label}")
        return found

    @cached_property
    def properties(self) -> dict[int, dict[int, Card]]:
        """All property entries, supported or not, by dimension of their elements and number."""
        return {dim: self.cards(_properties(self.bulk, dim)) for dim in _DIMENSIONS}

    @cached_property
    def materials(self) -> dict[int, Card]:
        """All material entries, supported or not, by number."""
        return self.cards(self.bulk.cards(*filter(_SOLIDS.fullmatch, self.bulk.names)))

    @cached_property
    def weight(self) -> float:
        """Factor by which densities are multiplied: PARAM,WTMASS, or 1 without it."""
        found = [card for card in self.bulk.cards("PARAM") if card.text(0) == "WTMASS"]
        for line in self.control:
            if of := _WTMASS.match(line.text):
                found.append(Card("PARAM", ["WTMASS", of[1].decode()], line))
        values = [card.real(1, "V1") for card in found]
        for card, value in zip(found, values, strict=True):
            if value != values[0]:
                raise card.error(f"another WTMASS is {values[0]:g}; keep one")
        return values[0] if found else 1.0

    def entries(self, members: IntArray) -> list[tuple[Table, str]]:
        """Return entries and layout of the elements `members` for each block that has any."""
        found = zip(self.parts, self.source.raw.rows(members), strict=True)
        return [(part.table.select(rows), part.layout) for part, (_, rows) in found if len(rows)]

    def read(self, source: Source) -> dict[str, OneMaterial]:
        """Return the sections in SI units by group, such as "property 3"."""
        self.source = source
        dims = self.source.raw.dims
        found: dict[str, OneMaterial] = {}
        for name, members in self.source.raw.cell_sets.items():
            if not name.startswith("property "):
                continue
            dim = int(dims[members].max())
            own = members[dims[members] == dim]  # a mesher may give edges the number, too
            if (of := self.source.instead(name, dim)) is not None:
                found[name] = of
                continue
            card = self.properties[dim].get(int(name.split()[1]))
            if card is None:
                if dim == dims.max():
                    why = f"its {name} is not there, or is of elements of another kind"
                    raise self.entries(own)[0][0].refused(0, why)
                continue  # sides and edges written by a mesher
            if card.name not in _PROPERTIES:
                raise card.error(f"it is not read; give read_sections(given={{{name!r}: ...}})")
            if (read := _PROPERTIES[card.name]) is None:
                self.source.left_out.append(f"{card.name}, which carries no bending, is left out")
                continue
            with refusing(card.error):
                found[name] = read(self, card, own)
        for entry in self.bulk.names.keys() & {"NSM", "NSM1", "NSML", "NSML1", "NSMADD"}:
            why = "its mass is not supported; delete it, and include it in densities (given=)"
            raise self.bulk.names[entry][0][0].line.refused(entry, why)
        return found

    # ------------------------------------------------------------------- materials

    def material(self, label: int, card: Card) -> Solid:
        """Return the material numbered `label`; `card` is the property that refers to it."""
        given: Solid | None = self.source.instead(f"material {label}")
        if given is not None:
            return given
        own = self.materials.get(label)
        if own is None or own.name not in _MATERIALS:
            why = f"material {label} is none of {', '.join(_MATERIALS)}"
            raise card.error(f"{why}; give it by read_sections(given=)")
        bar = _DIMENSIONS[1].fullmatch(card.name) is not None
        if label in self.cards(self.bulk.cards("MATT1", "MATT8", "MATT11")):
            raise own.error("it depends on temperature by its MATT, which is not supported")
        if label in self.cards(self.bulk.cards("MATS1")):
            self.source.left_out.append(f"material {label} is elastic, without its MATS1")
        make, density, damping = _MATERIALS[own.name]
        if own.real(damping, "GE", 0.0):
            self.source.left_out.append(f"material {label} has no damping, GE is left out")
        if not (rho := own.real(density, "RHO", 0.0) * self.weight):
            cure = f"give read_sections(given={{'material {label}': Material(...)}})"
            raise own.error(f"RHO is 0 or blank; write it, or {cure}")
        if bar and own.name == "MAT1" and own.text(1) and own.real(2, "G", 0.0):
            own = replace(own, fields=[*own.fields[:3], "", *own.fields[4:]])  # bars use E and G
        with refusing(own.error):
            return make(self.source, own, rho)

    # ---------------------------------------------------- data in fields of elements

    def offset(self, own: IntArray, card: Card) -> float:
        """Return the offset ZOFFS, m, if all elements have the same; refuse nodal thicknesses."""
        found = []
        for table, layout in self.entries(own):
            last = 14 if layout.startswith("quad") else 13
            nodal = np.any(~table.blank[:, 10:last], axis=1)
            table.refuse_first(nodal, "thickness at the nodes is not read; give it in the property")
            found.append(table.reals(_THETA[layout] + 1, 1)[:, 0])
        offsets = np.concatenate(found)
        if np.any(offsets != offsets[0]):
            raise card.error("ZOFFS of its elements differs; give properties of their own")
        return float(offsets[0]) * self.source.length

    def axes(self, label: int, own: IntArray, card: Card) -> FloatArray:
        """Return the unit axes, in rows, of a rectangular coordinate system."""
        found = self.grids.axes(label, partial(self.entries(own)[0][0].refused, 0))
        if found.kind != "R":
            raise card.error(f"system {label} must be rectangular")
        return found.axes

    def fibres(self, own: IntArray, card: Card) -> tuple[float, ...]:
        """Return a direction whose projection on every element is axis 1 of its material."""
        normals = self.source.directions(own)
        x = across(self.source.directions(own, edges=True), normals)
        columns = [table.fields[:, _THETA[layout]] for table, layout in self.entries(own)]
        words, of = np.unique(np.concatenate(columns), return_inverse=True)
        # An integer is MCID, the label of a coordinate system; a real number is the angle THETA.
        systems = [INTEGER.fullmatch(word) is not None for word in words.tolist()]
        texts = [b"0" if s or not w else w for s, w in zip(systems, words.tolist(), strict=True)]
        angles = np.radians([number(text.decode()) for text in texts])
        along = np.cos(angles)[of, None] * x + np.sin(angles)[of, None] * np.cross(normals, x)
        for i in np.flatnonzero(systems).tolist():
            along[of == i] = self.axes(int(words[i]), own, card)[0]
        return common(along, normals)

    def towards(self, own: IntArray) -> ArrayPair:
        """Return, for each bar, a vector in plane 1, and the offset, m; refuse hinges."""
        nodes, grids = self.source.raw.nodes, self.grids
        for table, layout in self.entries(own):
            if layout == "line3":
                raise table.refused(0, "PBEAM3, its property, is not read")
        offt, ends = table.fields[:, 7], table.reals(10, 6)
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
        basic = by_node | (frames == b"B") | (grids.output_systems[rows] < 0)
        systems = np.where(basic, 0, grids.output_systems[rows])
        for system, own in grids.by_system(systems, table):  # X1 to X3: in system CD of node GA
            axes = system.directions(nodes[rows[own]])
            vectors[own] = np.einsum("ni,nij->nj", vectors[own], axes)
        return vectors, ends[:, :3] * self.source.length


# -------------------------------------------------------------------------------- properties


def _solid(deck: NastranDeck, card: Card, own: IntArray) -> OneMaterial:
    found = deck.material(card.integer(1, "MID"), card)
    if card.text(6) not in ("", "SMECH"):
        raise card.error(f"FCTN must be SMECH or blank, got {card.text(6)}")
    if isinstance(found, Orthotropic) and (system := card.integer(2, "CORDM")):
        return replace(found, axes=deck.axes(system, own, card))  # type: ignore[arg-type]
    return found


def _shell(deck: NastranDeck, card: Card, own: IntArray) -> OneMaterial:
    label, bending, shear, coupling = (card.integer(at, "MID") for at in (1, 3, 5, 10))
    material = deck.material(label, card)
    if bending != label:
        raise card.error(f"MID2={card.text(3)!r} of bending must be MID1={label}")
    if shear not in (0, label) or coupling:
        raise card.error(f"MID3={shear}, MID4={coupling} is not supported; leave both blank")
    card.must_be(4, "12I/T**3", 1.0)
    card.must_be(6, "TS/T", 5.0 / 6.0)
    card.must_be(7, "NSM", 0.0)
    plies = [Ply(card.real(2, "T") * deck.source.length, material)]
    return layered(plies, lambda: deck.fibres(own, card), deck.offset(own, card))


def _laminate(deck: NastranDeck, card: Card, own: IntArray) -> OneMaterial:
    """Return the laminate of PCOMP (four fields per ply) or PCOMPG (a ply number first)."""
    card.must_be(2, "NSM", 0.0)
    if card.text(7) not in ("", "SYM"):
        raise card.error(f"LAM={card.text(7)} is not supported")
    if card.real(6, "GE", 0.0):
        deck.source.left_out.append(f"{card.name} {card.text(0)} has no damping, GE is left out")
    step, first = (8, 9) if card.name == "PCOMPG" else (4, 8)
    plies: list[Ply] = []
    label, thickness = 0, None
    for at in range(first, len(card.fields), step):
        if not any(card.fields[at : at + 4]):
            continue
        label = card.integer(at, "MID", label)
        thickness = card.real(at + 1, f"T{len(plies) + 1}", thickness)
        angle = card.real(at + 2, "THETA", 0.0)
        plies.append(Ply(thickness * deck.source.length, deck.material(label, card), angle))
    offset = deck.offset(own, card) + card.real(1, "Z0", 0.0) * deck.source.length
    share, symmetric = 0.5 * bool(card.text(1)), card.text(7) == "SYM"
    return layered(plies, lambda: deck.fibres(own, card), offset, share, symmetric=symmetric)


def _bar(deck: NastranDeck, card: Card, own: IntArray, shear: float = math.inf) -> OneMaterial:
    """Return the beam of PBAR: y of the deck is z of `Beam`, z of the deck is -y of `Beam`.

    The beam is rigid in shear if K1 and K2 are 0, or blank with `shear` = inf (PBAR's default).
    """
    card.must_be(6, "NSM", 0.0)
    area, I1, I2, J = card.reals(2, "A I1 I2 J")
    points = [[card.real(at + i, "C to F", 0.0) for i in (1, 0)] for at in (8, 10, 12, 14)]
    inverse = [1.0 / (card.real(at, "K1, K2", shear) or math.inf) for at in (17, 16)]
    second, more = (I2, card.real(18, "I12", 0.0), I1), (np.diag(inverse), np.array(points))
    return _beam(deck, card, own, deck.source.numbers(area, second, J, *more))


def _constant(deck: NastranDeck, card: Card, own: IntArray) -> OneMaterial:
    """Return the beam of a PBEAM of constant cross-section, by conversion to PBAR."""
    of = [*card.fields, *[""] * 16]
    if of[8] in _STATIONS:  # the fields of the stress points C to F are missing
        of[8:8] = [""] * 8
    card, at = replace(card, fields=of), 16
    while of[at] in _STATIONS:
        for i in range(2, 8):
            card.must_be(at + i, "A to NSM along the beam", card.real(i, "A to NSM", 0.0))
        at += 16 if of[at] == "YES" else 8
    for i in range(at + 2, len(of)):
        card.must_be(i, "a field after K1 and K2", 0.0)
    bar = [*of[:5], *of[6:8], "", *of[8:16], *of[at : at + 2], of[5]]
    return _bar(deck, replace(card, fields=bar), own, 1.0)


def _shaped(deck: NastranDeck, card: Card, own: IntArray) -> OneMaterial:
    """Return the beam of PBARL or PBEAML from its section's dimensions; NSM must be 0."""
    count, make = named(NASTRAN, card.text(3))
    if any(card.fields[9 + count :]):
        raise card.error("it has fields after its first cross-section, which is not supported")
    card.must_be(8 + count, "NSM", 0.0)
    lengths = np.array([card.real(8 + i, f"DIM{i + 1}") for i in range(count)])
    section = make(*(lengths * deck.source.length).tolist())
    if isinstance(section, Profile):  # nodes are at the centroid
        section = section.at(*section.centre)
    return _beam(deck, card, own, section)


def _beam(deck: NastranDeck, card: Card, own: IntArray, section: Any) -> OneMaterial:
    material: Any = deck.material(card.integer(1, "MID"), card)
    z, moved = deck.towards(own)
    return deck.source.beam(section, material, z, own, _AXES, moved)


# Values of the first field in a line of PBEAM that begins another cross-section.
_STATIONS = ("YES", "YESA", "NO")

# Functions that read properties, by name; None for bars without bending stiffness, which are left
# out.
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


def _isotropic(source: Source, card: Card, rho: float) -> Material:
    """Return the material of a MAT1, where at most one of E, G and NU may be blank."""
    E, G, nu = (card.real(at, "", 0.0) for at in (1, 2, 3))
    if sum(bool(card.text(at)) for at in (1, 2, 3)) < 2 or (G == 0.0 and not card.text(3)):
        raise card.error("write two of E, G and NU")
    if not card.text(3):
        nu = 0.5 * E / G - 1.0
    elif not card.text(1):
        E = 2.0 * G * (1.0 + nu)
    elif G and abs(G - (isotropic := 0.5 * E / (1.0 + nu))) > _ISOTROPIC * G:
        if float(f"{isotropic:.1e}") != G:  # not just rounded to two digits
            raise card.error(f"G={G:g} is not E/(2 (1 + NU)) = {isotropic:g}; leave G blank")
        left = f"material {card.text(0)} has G={isotropic:g} by E and NU, not {G:g}"
        source.left_out.append(left)
    return source.isotropic(E, nu, rho)


_MAT8 = "E1 E2 NU12 G12 G1Z G2Z"
_MAT11 = "E1 E2 E3 NU12 NU13 NU23 G12 G13 G23"

# `_SOLIDS`: names of material entries, which share their numbers. `_MATERIALS`: for each material
# entry that is read, its function, and the indices of the fields with density and damping.
_SOLIDS = re.compile("MAT([12389]|1[01])")
_MATERIALS: dict[str, tuple[Callable[..., Solid], int, int]] = {
    "MAT1": (_isotropic, 4, 7),
    "MAT8": (lambda source, card, rho: source.ply(*card.reals(1, _MAT8), rho), 7, 16),
    "MAT11": (lambda source, card, rho: source.orthotropic(*card.reals(1, _MAT11), rho), 10, 15),
}


# Codes of a matrix's form (IFO): square, or symmetric with one triangle in the file.
_SQUARE, _SYMMETRIC = 1, 6

# Codes of the type of a matrix's numbers (TIN) up to this one mean real numbers.
_REAL = 2


def read_dmig(file: Path) -> list[RawMatrix]:
    """Return all DMIG matrices of a file.

    An entry is a header (name, 0, IFO, TIN), or a column: matrix name, node and component of the
    column, then node, component and value of each row.
    """
    quads, entry = read_deck(file)[1].quads("DMIG")
    starts = np.diff(entry, prepend=-1) > 0
    heads = quads.select(starts)
    names, labels = heads.fields[:, 0], heads.integers(1, 2)
    is_header = labels[:, 0] == 0
    heads.refuse_first(~np.isin(names, names[is_header]), "its matrix has no header")
    of_rows = ~(starts | is_header[entry] | quads.blank[:, 0])
    found = []
    kinds = heads.select(is_header).integers(2, 2).tolist()
    for own, (form, kind) in zip(names[is_header], kinds, strict=True):
        name, rows = own.decode(), of_rows & (names == own)[entry]
        if kind > _REAL or form not in (_SQUARE, _SYMMETRIC) or not rows.any():
            why = "complex" if kind > _REAL else "not square, or empty"
            found.append(passed_over(file, name, why))
            continue
        table = quads.select(rows)
        table.refuse_first(table.blank[:, 2], "a row has no value: is the file cut short?")
        values, pairs = table.reals(2, 1)[:, 0], table.integers(0, 2).T
        columns, symmetric = labels[entry[rows]].T, form == _SYMMETRIC
        found.append(labelled(file, name, pairs, columns, values, triangle=symmetric))
    return found
