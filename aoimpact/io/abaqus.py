"""Meshes, groups and sections from decks of Abaqus and CalculiX.

A keyword that is not read is refused unless it is known to have no influence on mesh and groups.
To read a new keyword, add it to `_READ` if it makes nodes, elements or sets, and to `_SECTIONS` if
it is a section; `_KINDS` classifies all other keywords.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import takewhile
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from ..base import FloatArray, IntArray, MeshError, nearest, record, warn
from ..fem import SAME, Beam, OneMaterial, Orthotropic, Ply, Solid, TubularSection
from ..mesh import SOLIDS, SURFACES, dot
from . import raw
from .abaqusdeck import MOST, Keyword, key, padded, read_keywords
from .profiles import ABAQUS, named
from .sections import Axes, Source, across, layered, refusing, triad

# Kind of a set: "NSET" (of nodes) or "ELSET" (of elements).
Which = Literal["NSET", "ELSET"]

# Beginnings of the names of keywords without influence on nodes, elements and sets: materials,
# sections, interactions, loads, steps, output. Surfaces are not read as groups.
_BEGINNINGS = """
    ACOUSTIC ACTIVATE ADAPTIVEMESH AMPLITUDE ANISOTROPIC ANNEAL AQUA BASE BIAXIAL BLOCKAGE BOND
    BOUNDARY BRITTLE BUCKL BULKVISC C-ADDED CALIBRATION CAP CASTIRON CAVITY CECHARGE CECURRENT
    CFD CFILM CFLOW CFLUX CHANGE CLAY CLEARANCE CLOAD COHESIVE COMBINEDTEST COMPLEXFREQ
    COMPOSITE CONCENTRATION CONCRETE CONDUCTIVITY CONFLUENCE CONNECTOR CONSTITUENT CONSTRAINT
    CONTACT CONTROLS CORRELATION CORRESPONDENCE COUPL CRACK CREEP CRUSH CYCL D-ADDED DAMPING
    DASHPOT DEBOND DECHARGE DECURRENT DEFORMATION DEPVAR DESIGN DETONATION DFLOW DFLUX
    DIAGNOSTICS DIELECTRIC DIFFUSIVITY DIRECTCYCLIC DISCRETE DISTRIBUT DLOAD DRAG DRUCKER DSA
    DSECHARGE DSECURRENT DSFLOW DSFLUX DSLOAD DYNAMIC ELCURRENT ELECTR ELEMENTMATRIX
    ELEMENTOPERATOR ELEMENTOUTPUT ELEMENTPRO ELEMENTRE ELEMENTSOLUTION ELFILE ELPRINT EMISSIVITY
    ENDLOADCASE ENDSTEP ENERGY ENRICHMENT EOS EPJOINT EULERIAN EVENTSERIES EXPANSION EXPLICIT
    EXTERNALFIELD EXTREME FABRIC FACEPRINT FASTENER FEASIBLE FIELD FILEFORMAT FILEOUTPUT FILM
    FILTER FIXEDMASS FLEXIBLE FLOW FLUID FRACTURE FREQUENCY FRICTION GAP GAS GEL GEOMETRIC
    GEOSTATIC GLOBALDAMPING GREEN HCF HEADING HEAT HOURGLASS HYDROSTATIC IMPEDANCE IMPERMEABLE
    IMPORTCONTROLS INCIDENTWAVE INCREMENTATION INELASTIC INERTIARELIEF INITIAL INTEGRATEDOUTPUT
    INTERFACE ITSDAMPING JOINT JOULE KAPPA KINEMATIC LATENT LEADTIME LOAD LOWDENSITY M1 M2
    MAGNETIC MAPSOLUTION MASS MATRI MEANFIELD MEDIA MEMBRANE MODAL MODELCHANGE MOHR MOISTURE
    MOLECULAR MONITOR MOTION MULLINS NETWORK NOANALYSIS NODAL NODEFILE NODEOUTPUT NODEPRINT
    NODERESPONSE NONLINEAR NORMAL OBJECTIVE ORIENTATION ORNL OUTPUT PARAMETER PARTICLE PERIODIC
    PERMANENT PERMEABILITY PHYSICAL PIEZO PIPE-SOIL PLANARTEST PLASTIC POREFLUID POROUS
    POSTOUTPUT POTENTIAL PRE-TENSION PREPRINT PRESSURE PRESTRESS PRINT PROBABILITY PROPERTY PSD
    RADIAT RANDOM RATIOS REFLECTION RELEASE RESPONSE RESTART RETAINED RIGID ROBUST ROTARY SELECT
    SENSITIVITY SFILM SFLOW SHEAR SIMPEDANCE SIMPLESHEAR SLIDELINE SLOADING SOILS SOLUBILITY
    SOLUTION SOLVER SORPTION SPECIFIC SPECTRUM SPRING SRADIATE STATIC STEADYSTATE STEP
    SUBCYCLING SUBMODEL SUBSTRUCTURE SURFACE SWELLING TABLE TEMPERATURE TENSILE TENSION THERMAL
    THICKNESS TIMEPOINTS TORQUE TRACER TRANSFORM TRANSPORT TRANSVERSE TRIAXIAL TRS UEL UNCOUPLED
    UNDEX UNIAXIAL UNLOADING USER VALUES VARIABLEMASS VIEWFACTOR VOID VOLUMETRIC WAVE WIND XFEM
"""

# Regular expressions for the names of keywords that are in neither `_READ` nor `_SECTIONS`, by kind
# of keyword; the first match decides.
_KINDS = {
    # Keywords that change nodes, elements or sets in ways that are not implemented.
    "unsupported": (
        "ADAPTIVEMESHREFINEMENT|ADJUST|DISPLAYBODY|(EL|N)(COPY|GEN)|IMPERFECTION|IMPORT((EL|N)SET)?"
        "|NFILL|NMAP|REFINEMESH|SYMMETRICMODELGENERATION"
    ),
    # Keywords that connect nodes or remove elements during an analysis, which no mesh can
    # represent.
    "connection": (
        "COUPLING|DISTRIBUTINGCOUPLING|EMBEDDEDELEMENT|EQUATION|FASTENER|KINEMATICCOUPLING"
        "|MODELCHANGE|MPC|RIGIDBODY|SHELLTOSOLIDCOUPLING|TIE"
    ),
    "material": "MATERIAL|ELASTIC|DENSITY",
    # Material behaviour that affects results but is left out, with a warning.
    "inelastic": (
        "(CYCLIC|RATEDEPENDENT|)PLASTIC|CYCLICHARDENING|RATEDEPENDENT|CREEP|DAMPING|VISCO.*"
        "|HYSTERESIS|DAMAGE.*|(BRITTLE|CONNECTOR|SHEAR|TENSILE|)FAIL.*|SUPERELASTIC.*|HYPER.*"
        "|(CAP|CASTIRON|CLAY|CONCRETEDAMAGED|CONNECTOR|POROUSMETAL)PLASTICITY|BRITTLECRACKING"
        "|NOCOMPRESSION|NOTENSION|USERMATERIAL"
    ),
    # Keywords that add to the section of the ELSET that they name, or else to the section before.
    "addition": (
        "NONSTRUCTURALMASS|TRANSVERSESHEAR(STIFFNESS)?|SECTIONSTIFFNESS|REBAR(LAYER)?|CENTROID"
        "|SHEARCENTER|BEAM(ADDED|FLUID)INERTIA|BEAMSECTIONOFFSET"
    ),
    # Keywords for mass or stiffness outside of sections.
    "beside": "FOUNDATION|MASSADJUST",
    # Sections of elements that are no part of a body, other names with SECTION, and names with
    # harmless beginnings. Any other name with SECT is refused, as it may be a misspelt section.
    "harmless": (
        "(COHESIVE|CONNECTOR|DISCRETE|EULERIAN|FLUID(PIPE)?|FRAME|GASKET|MEMBRANE|SURFACE"
        "|USER|INTEGRATEDOUTPUT|PRE-TENSION|CHANGESOLID)SECTIONS?|BEAMSECTIONGENERATE"
        "|SECTION(CONTROLS|FILE|ORIGIN|POINTS|PRINT)"
        f"|(?!.*SECT)({'|'.join(_BEGINNINGS.split())}).*"
    ),
}

# For each node in meshio's order, its number in Abaqus' order, where the middle node of C3D27
# precedes the nodes of faces 1 to 6, and the middle node of B32 the second end node.
_ORDERS = {"hexahedron27": (*range(20), 26, 24, 23, 25, 21, 22, 20), "line3": (0, 2, 1)}

# Entries: pattern of element types; meshio's kind for the digits that the pattern captures;
# dimension: 3 solids, 2 shells, 1 beams, 0 others (membranes, rigid and plane elements, trusses).
# B33 has the nodes of B31.
_TYPES: tuple[tuple[str, dict[int, str], int], ...] = (
    (r"C3D(4|5|6|8|10|13|15|20|27)(?!.*V)[A-Z]{0,4}", SOLIDS, 3),
    (r"(?:U?S|STRI)(65|3|4|6|8|9)(?!\d)[A-Z0-9]*", SURFACES | {65: "triangle6"}, 2),
    (r"(?:DS|[MR]3D|SFM3D|CP[SE]|[DA]?CAX|[DA]C2D)(3|4|6|8|9)(?!\d)[A-Z0-9]*", SURFACES, 0),
    (r"T[23]D([23])[A-Z]{0,2}", raw.LINES, 0),
    (r"B3([123])R?H?(?:OS)?H?", {1: "line", 2: "line3", 3: "line"}, 1),
)

# Pattern of element types whose nodes are not read: types with a variable number of nodes, or with
# shapes that no mesh of solids has.
_LISTED = (
    r"(?:B2\d|PIPE|ELBOW|FRAME|MASS$|ROTARYI$|HEATCAP$|SPRING|DASHPOT|JOINT|CONN|GAP|DGAP|DCOUP"
    r"|ITS|ITT|ISL|IRS|LS\d|COH|GK|SC[68]R|CSS8|SFM|MAX|MCL|CCL|CIN|CPEG|CGAX|CAXA|CGPE|SAX|SAXA"
    r"|DSAX|RAX2|RB[23]D|R2D2|AC1D|AC3D|ACIN|ASI|DC1D|DCC|DC3D|Q3D|EMC|EC3D|FC3D|F3D|PC3D|PD3D|PSI"
    r"|DRAG|KSP|WARP|D$|V?U\d|Z\d)[A-Z0-9-]*"
)

# Sine of 0.1°. Axis 1 of a shell is the projection of global x unless x is closer to the normal.
_NORMAL = 1.745e-3

# Rows: axes y and z of a `Beam`. Columns: their components along axes 1 and 2 of Abaqus' section.
_AXES = np.array([[0.0, -1.0], [1.0, 0.0]])

# Advice for an orientation that Abaqus and CalculiX interpret differently.
_CURE = "write the fibres as axis 1, and 3 in the second line"


def read(file: Path) -> raw.RawMesh:
    """Return the mesh of a deck of Abaqus or CalculiX.

    A set of an instance is called "instance.set", and also "set" if no other instance has a set of
    that name. Each instance is a group of its elements. Nodes of the assembly itself, which are
    reference points, are left out.

    Raises
    ------
    MeshError
        If a line that may concern nodes, elements or sets is not understood; file, line and keyword
        are named.
    MissingFileError
        If an included file does not exist.

    Warns
    -----
    AOImpactWarning
        If parts have no instance, sets have undefined members, or nodes are connected by other
        means than elements.
    """
    with np.errstate(all="ignore"):  # coordinates that overflow are refused later
        return _joined(file, read_keywords(file))


@cache
def _kind(name: str) -> str:
    """Return the kind of a keyword, "section" or a key of `_KINDS`; "" if it is unknown."""
    if name in _SECTIONS:
        return "section"
    return next((kind for kind, names in _KINDS.items() if re.fullmatch(names, name)), "")


# ----- parts, instances and the assembly


@record
class AbaqusDeck:
    """The contents of a deck beyond its mesh.

    Attributes
    ----------
    cards : list of Keyword
        All keywords of the deck.
    whole : Scope
        The assembly, or the whole deck if it has no parts.
    blocks : list of _Elements
        Elements of each block of the mesh.
    """

    cards: list[Keyword]
    whole: Scope
    blocks: list[_Elements]

    @property
    def sections(self) -> str:
        """Count of each keyword of shell and beam sections, as in "2 *SHELLSECTION"."""
        thin = [card.name for card in self.cards if _SECTIONS.get(card.name, (None, 3))[1] < 3]
        return raw.listed((f"*{name}", 1) for name in thin)

    @cached_property
    def normals(self) -> Keyword | None:
        """First keyword with normals at nodes, which would rotate beam sections; None without."""
        for card in self.cards:
            nodes = card.data if card.name == "NODE" else ()
            if card.name == "NORMAL" or any(of.text.rstrip(", ").count(",") > 3 for of in nodes):
                return card
        return None

    @cached_property
    def materials(self) -> dict[str, dict[str, Keyword]]:
        """Keywords of each material, by the names of material and keyword, such as ELASTIC."""
        found: dict[str, dict[str, Keyword]] = {}
        own: dict[str, Keyword] = {}
        for card in takewhile(lambda card: card.name != "STEP", self.cards):
            if card.name == "MATERIAL":
                own = found.setdefault(key(card.options.get("NAME", "")), {})
            kind = _kind(card.name)
            if kind == "material" and card.name in own:
                raise card.error("the material must have this keyword only once")
            if kind in ("material", "inelastic"):  # only inelastic keywords may repeat
                own[card.name] = card
        return found

    def read(self, source: Source) -> dict[str, OneMaterial]:
        """Return the sections by group, except sections of elements that no body can have."""
        groups = {key(name): name for name in source.raw.cell_sets}
        dims = np.repeat([block.dim for block in self.blocks], np.diff(source.raw.first))
        bare = dims.copy()  # dimension of each element without a section; 0 for others
        found: dict[str, OneMaterial] = {}
        elset = ""
        for card in self.cards:
            addition = _kind(card.name) == "addition"
            if not addition and card.name not in _SECTIONS:
                continue
            elset = card.options.get("ELSET", elset if addition else "").replace('"', "")
            placed = [one for one in self.whole.inner.values() if one.part == card.part]
            for scope in placed if card.part else [self.whole]:
                of = f"{scope.name}.{elset}" if scope.name else elset
                name = groups.get(key(of), "")
                if name not in source.raw.cell_sets:
                    raise card.error(f"there is no ELSET {of!r}")
                members = source.raw.cell_sets[name]
                of_set = None, dims[members].max(initial=0), ""
                read, dim, options = _SECTIONS.get(card.name, of_set)
                own = members[dims[members] == dim]
                if not addition and not len(own):
                    continue  # a section of trusses, membranes etc., which are no part of a body
                given = source.instead(name, dim)
                if read is None and given is None:
                    raise card.error(f"it is not read; include it in {of} by read_sections(given=)")
                if read is None:
                    continue
                if name in found:
                    raise card.error(f"{name} must have one section, this is another one")
                bare[own] = 0
                if given is None:
                    card.check_options("ELSET", "MATERIAL", "CONTROLS", *options.split())
                    with refusing(card.error):
                        given = read(_Section(source, self, card, scope.turn, own))
                found[name] = given
        for dim in np.unique(bare[bare > 0]).tolist():
            first, count = int(np.argmax(bare == dim)), np.count_nonzero(bare == dim)
            label = int(np.concatenate([block.labels for block in self.blocks])[first])
            why = f"{count} elements have no section, the first is {label}"
            if dim == dims.max():
                keyword = self.blocks[int(source.raw.block_of(first))].keyword
                raise keyword.error(f"{why}; write sections, or give from_mesh materials")
            source.left_out.append(why)
        beams = any(isinstance(each, Beam) for each in found.values())
        if self.normals and not all(isinstance(each, Solid | Beam) for each in found.values()):
            source.left_out.append("normals at nodes are left out: shells use elements' normals")
        for card in self.cards:
            if card.name == "RELEASE" and beams:
                raise card.error("hinges are not supported; delete it if the joints are rigid")
            if _kind(card.name) == "beside":
                source.left_out.append(f"*{card.name} is left out")
        return found


def _sorted(keywords: list[Keyword]) -> Scope:
    """Return the assembly with parts and instances, or the whole of a deck without parts.

    Each keyword is assigned to its part, instance or the assembly; unknown keywords are refused.
    """
    whole = Scope()
    parts = whole.parts
    within = [("", whole)]
    loose: Keyword | None = None
    for keyword in keywords:
        name = keyword.name
        keyword.part = within[-1][1].part if within[-1][0] == "PART" else ""
        if name in _READ:
            within[-1][1].keywords.append(keyword)
            if len(within) == 1 and name in ("NODE", "ELEMENT"):
                loose = keyword
        elif name == "ASSEMBLY":
            within.append((name, whole))
        elif name in ("PART", "INSTANCE"):
            if within[-1][0] in ("PART", "INSTANCE"):
                raise keyword.error(f"it must not stand within *{within[-1][0]}")
            among = parts if name == "PART" else whole.inner
            keyword.check_options("NAME", *(["PART"] if name == "INSTANCE" else []))
            called, of = (keyword.options.get(option, "") for option in ("NAME", "PART"))
            if not key(called) or key(called) in among:
                raise keyword.error("it needs a NAME of its own")
            if name == "INSTANCE" and key(of) not in parts:
                raise keyword.error(f"there is no part {of}")
            among[key(called)] = Scope(called.strip('"'), key(of or called), keyword)
            within.append((name, among[key(called)]))
        elif name in ("ENDPART", "ENDASSEMBLY", "ENDINSTANCE"):
            if (len(within) > 1 or name != "ENDASSEMBLY") and within.pop()[0] != name[3:]:
                raise keyword.error(f"there is no open *{name[3:]} that it could end")
        elif _kind(name) == "unsupported":
            raise keyword.error("it is not supported; write the mesh out without it")
        elif not _kind(name) and (name not in ("", "END") or keyword.data):
            like = nearest(name, [*_READ, *_SECTIONS])
            raise keyword.error(f"it is not known, and may change the body{like}; leave it out")
    if len(within) > 1:
        raise keywords[-1].error(f"*END {within[-1][0]} is missing")
    if parts and loose is not None:
        raise loose.error("in a deck with parts, it must belong to one of them")
    if not whole.inner:  # without instances, each part is its own instance
        whole.inner = {name: Scope(part.name, name) for name, part in parts.items()}
    return whole


def _joined(file: Path, cards: list[Keyword]) -> raw.RawMesh:
    """Return the mesh of all instances, moved to their places, with all sets."""
    whole = _sorted(cards)
    for name, instance in whole.inner.items():
        scope = whole.parts[instance.part]
        if instance.keywords:
            scope = Scope(keywords=[*scope.keywords, *instance.keywords])
        whole.inner[name] = scope.read().placed(instance, whole.first)
        whole.first = whole.inner[name].behind()
    whole.read()
    every, bodies = list(whole.blocks()), [*whole.inner.values()] or [whole]
    deck = AbaqusDeck(cards, whole, [block for block, *_ in every])
    # In a deck without solids, all elements but shells and beams get the kind "other".
    solid = any(block.dim == 3 for block in deck.blocks)
    kinds = [block.kind if block.dim or solid else "" for block in deck.blocks]
    of = np.repeat(np.arange(len(kinds)), [len(block.labels) for block in deck.blocks])
    dims = np.array([block.dim for block in deck.blocks], dtype=int)[of]
    unread = np.array([not kind for kind in kinds], dtype=bool)[of]
    node_sets, cell_sets = _named(whole)
    left_out = {}
    for name, own in cell_sets.items():
        others = own[dims[own] != 3 if (dims[own] == 3).any() else unread[own]]
        if len(others) and name not in {body.name for body in bodies}:
            left_out[name] = raw.listed((deck.blocks[i].type, 1) for i in of[others].tolist())
    _warn(file, deck)
    places = np.concatenate([body.places for body in bodies])
    blocks = tuple(
        raw.RawBlock(
            kind or "other", nodes[:, _ORDERS.get(kind, slice(None))], block.labels, block.type
        )
        for kind, (block, _, nodes) in zip(kinds, every, strict=True)
    )
    node_sets = {name: own[own < len(places)] for name, own in node_sets.items()}
    labels = raw.joined(body.known["NSET"][0] for body in bodies)
    return raw.RawMesh(places, blocks, node_sets, cell_sets, labels, left_out, deck)


def _named(whole: Scope) -> tuple[dict[str, IntArray], dict[str, IntArray]]:
    """Return all node sets and element sets by name; members are numbered through the deck."""
    sets: dict[tuple[Which, str], list[tuple[str, IntArray]]] = {}
    for name, scope in {"": whole, **whole.inner}.items():
        for (which, inner), pieces in scope.sets.items():
            called = pieces[0].options[which].strip('"')
            members = scope.members(which, inner)
            if name:
                full = f"{scope.name}.{called}"
                sets.setdefault((which, key(full)), []).append((full, members))
            if not name or (which, inner) not in whole.sets:
                sets.setdefault((which, inner), []).append((called, members))
        if name:
            every = np.arange(scope.first["ELSET"], scope.behind()["ELSET"])
            sets.setdefault(("ELSET", name), []).append((scope.name, every))
    found: dict[Which, dict[str, IntArray]] = {"NSET": {}, "ELSET": {}}
    for (which, _), own in sets.items():
        called, members = own[0]
        if all(np.array_equal(members, other) for _, other in own):  # else the name is ambiguous
            found[which][called] = members
    return found["NSET"], found["ELSET"]


def _warn(file: Path, deck: AbaqusDeck) -> None:
    """Give one warning that lists the contents of the deck that are not in the mesh."""
    said, whole = list[str](), deck.whole
    names = ((f"*{card.name}", 1) for card in deck.cards if _kind(card.name) == "connection")
    if connections := raw.listed(names):
        without = "changes of the model were left out, and the body is computed without them"
        said.append(f"connections between nodes and {without}: {connections}")
    used = {scope.part for scope in whole.inner.values()}
    if unused := [part.name for at, part in whole.parts.items() if at not in used]:
        said.append(f"parts without an instance are left out: {', '.join(unused)}")
    for scope in (whole, *whole.inner.values()):
        for name, label in [*scope.missing.items()][:1]:
            more = f"of {len(scope.missing)} sets, not all members are defined"
            said.append(f"{more}; {name} names {label}")
    if said:
        warn(f"mesh file {str(file)!r}: {'; '.join(said)}")


# ----- nodes, elements and sets


@record
class _Elements:
    """Elements of one type.

    Attributes
    ----------
    type : str
        Abaqus' name of the element type.
    kind : str
        meshio's name; "" if nodes are not read.
    dim : int
        Dimension: 3 solids, 2 shells, 1 beams, 0 others.
    labels : ndarray of int, shape (n,)
        Numbers of the elements in the deck.
    nodes : ndarray of int, shape (n, nodes per element)
        Labels of each element's nodes; `Scope._number` replaces them by rows of the scope's nodes.
    keyword : Keyword
        The *ELEMENT keyword.
    towards : bool
        True for beams with an extra node that gives the direction of axis 1 of their section.
    """

    type: str
    kind: str
    dim: int
    labels: IntArray
    nodes: IntArray
    keyword: Keyword
    towards: bool = False


@dataclass(eq=False)
class Scope:
    """A namespace of a deck, in which numbers of nodes and elements and names of sets are unique.

    A deck without parts is one scope. Otherwise each instance of a part is a scope, and so is the
    assembly, whose sets may have members in the instances.

    Attributes
    ----------
    name : str
        Name of the part or instance as written in the deck.
    part : str
        Name, in capitals, of this part, or of the part that this scope is an instance of.
    keyword : Keyword or None
        The *PART or *INSTANCE keyword.
    keywords : list of Keyword
        Keywords of the scope that are in `_READ`.
    parts, inner : mapping of str to Scope
        Parts and instances of an assembly, by their names in capitals.
    first : mapping of Which to int
        Numbers of the scope's first node and first element, counted through the whole deck.
    places : ndarray, shape (n, 3)
        Coordinates of the nodes, in ascending order of their labels.
    turn : ndarray, shape (3, 3)
        Rotation matrix of the instance.
    elements : list of _Elements
        Elements in the order of the deck.
    sets : mapping of (Which, str) to list of Keyword
        Keywords that add members to each set; names are in the form that `key` returns.
    missing : mapping of str to int
        For each set with undefined members, the label of the first undefined member.
    known : mapping of Which to (ndarray of int, ndarray of int)
        Labels of the nodes and of the elements, ascending, and the row of each label.
    """

    name: str = ""
    part: str = ""
    keyword: Keyword | None = None
    keywords: list[Keyword] = field(default_factory=list)
    parts: dict[str, Scope] = field(default_factory=dict)
    inner: dict[str, Scope] = field(default_factory=dict)
    first: dict[Which, int] = field(default_factory=lambda: {"NSET": 0, "ELSET": 0})
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    turn: FloatArray = field(default_factory=lambda: np.eye(3))
    elements: list[_Elements] = field(default_factory=list)
    sets: dict[tuple[Which, str], list[Keyword]] = field(default_factory=dict)
    missing: dict[str, int] = field(default_factory=dict)
    known: dict[Which, tuple[IntArray, IntArray]] = field(default_factory=dict)
    _points: list[tuple[Keyword, IntArray, FloatArray]] = field(default_factory=list)
    _frame: Axes = field(default_factory=Axes)  # axes set by the last *SYSTEM
    _found: dict[tuple[Which, str], IntArray | None] = field(default_factory=dict)

    def read(self) -> Scope:
        """Read the keywords of the scope, unless it has been read, and return the scope."""
        if not self.known:
            for keyword in self.keywords:
                add, options = _READ[keyword.name]
                keyword.check_options(*options.split())
                add(self, keyword)
            self._number()
        return self

    def placed(self, of: Scope, first: dict[Which, int]) -> Scope:
        """Return a copy of the part as the instance `of`, at the position that *INSTANCE gives.

        The first data line is a translation. The second, two points of an axis and an angle,
        rotates the translated part. Both lines are optional.
        """
        places = np.vstack([self.places, np.zeros(3), np.eye(3)])
        if of.keyword is not None and of.keyword.rows:
            what = "a translation, and a rotation by two points and an angle"
            shift, points = of.keyword.lines_of(3, 7, what=what)
            places = places + shift
            if len(of.keyword.rows) > 1:
                start, axis = points[:3], points[3:6] - points[:3]
                if not axis.any():
                    raise of.keyword.error("the two points of the axis of rotation must differ")
                turn = points[6] * axis / np.linalg.norm(axis)
                rotation = Rotation.from_rotvec(turn, degrees=True)
                places = rotation.apply(places - start) + start
        new = copy(self)
        new.name, new.part, new.first, new._found = of.name, of.part, first, {}
        new.places, new.turn = places[:-4], (places[-3:] - places[-4]).T
        return new

    def behind(self) -> dict[Which, int]:
        """Return `first` of the next scope: the numbers after the last node and element here."""
        return {which: self.first[which] + len(self.known[which][0]) for which in self.first}

    def blocks(self) -> Iterator[tuple[_Elements, int, IntArray]]:
        """Yield each block, its first element and its nodes, as numbers through the whole deck."""
        for scope in (*self.inner.values(), self):
            start = scope.first["ELSET"]
            for block in scope.elements:
                yield block, start, block.nodes + scope.first["NSET"]
                start += len(block.labels)

    def _system(self, keyword: Keyword) -> None:
        """Set the rectangular axes for the nodes that follow (*SYSTEM).

        Data: the origin, a point on the x axis and a point in the x-y plane. Without the third
        point, z is the global z, and x is projected. With the origin alone, axes are global.
        """
        what = "the points a and b in one line, and c in the next"
        points, third = keyword.lines_of(6, 3, what=what)
        origin, axes = points[:3], np.eye(3)
        if len(keyword.rows) and len(keyword.rows[0]) > 3:
            x, beside = points[3:] - origin, third - origin
            if len(keyword.rows) == 1:
                x[2] = 0.0
                beside = np.array([-x[1], x[0], 0.0])
            axes = triad(x, beside, keyword.error)
        self._frame = Axes("R", origin, axes)

    def _node(self, keyword: Keyword) -> None:
        labels, places = keyword.points()
        keyword.labels = labels
        system = key(keyword.options.get("SYSTEM", "R"))
        if system not in ("R", "C", "S", "RECTANGULAR", "CYLINDRICAL", "SPHERICAL"):
            raise keyword.error(f"SYSTEM must be R, C or S, got {system}")
        if system[0] == "S":  # given: r, angle about z, angle from x-y plane
            places = np.stack([places[:, 0], 90.0 - places[:, 2], places[:, 1]], axis=1)
        places = replace(self._frame, kind=system[0]).basic(places)
        self._points.append((keyword, labels, places))
        self._define(keyword, "NSET")

    def _element(self, keyword: Keyword) -> None:
        name = key(keyword.options.get("TYPE", ""))
        # Kind "": only numbers and type of the elements are known, not their nodes.
        kind, dim, towards = ("" if re.fullmatch(_LISTED, name) else None), 0, False
        for pattern, kinds, of in _TYPES:
            if found := re.fullmatch(pattern, name):
                kind, dim = kinds[int(found[1])], of
                break
        if kind is None:
            raise keyword.error(f"elements of type {name!r} are not known")
        if self.inner and name.startswith("C3D"):
            raise keyword.error("solids must be in a part")
        if kind and not self.inner:
            n = raw.nodes_in(kind)
            towards = name[0] == "B" and [len(row) for row in keyword.rows[:1]] == [n + 2]
            table = keyword.connectivity(n + towards)[:, : n + 1]
        else:  # nodes of an assembly's elements may be written instance.label
            ends = ["", *(line.text[-1] for line in keyword.data)]  # end of each previous line
            rows = zip(ends, enumerate(keyword.rows), strict=False)
            numbers = [keyword.integers(i, row[:1]) for end, (i, row) in rows if end != ","]
            kind, table = "", np.reshape(np.array(numbers, dtype=np.int64), (-1, 1))
        keyword.labels = table[:, 0]
        new = _Elements(name, kind, dim, table[:, 0], table[:, 1:], keyword, towards)
        self.elements.append(new)
        self._define(keyword, "ELSET")

    def _set(self, keyword: Keyword) -> None:
        which: Which = "NSET" if keyword.name == "NSET" else "ELSET"
        options = keyword.options
        if which not in options:
            raise keyword.error(f"{which}=name is missing")
        if key(options.get("INSTANCE", "")) not in ["", *self.inner]:
            raise keyword.error(f"there is no instance {options['INSTANCE']}")
        self._define(keyword, which)

    def _define(self, keyword: Keyword, which: Which) -> None:
        """Record that a keyword adds members to the set that its option NSET or ELSET names."""
        if which in keyword.options:
            at = which, key(keyword.options[which])
            if not at[1]:
                raise keyword.error(f"{which}= has no name")
            self.sets.setdefault(at, []).append(keyword)

    def _number(self) -> None:
        """Sort the nodes by label; replace the elements' node labels by row numbers of nodes."""
        labels = raw.joined(labels for _, labels, _ in self._points)
        places = np.concatenate([np.zeros((0, 3)), *(places for _, _, places in self._points)])

        def refuse(row: int) -> MeshError:
            keywords = [one for one, own, _ in self._points if (own == labels[row]).any()]
            why = f"node {labels[row]} is defined twice, at different places"
            return keywords[-1].error(why)

        kept = raw.once(labels, places, refuse)
        nodes, self.places = labels[kept], places[kept]
        self.known["NSET"] = nodes, np.arange(len(nodes))
        for i, block in enumerate(self.elements):
            rows = raw.cells_of(
                nodes, block.labels, block.nodes, lambda _, why, of=block: of.keyword.error(why)
            )
            self.elements[i] = replace(block, nodes=rows)
        labels = raw.joined(block.labels for block in self.elements)
        for label in labels[raw.repeats(labels)[:1]].tolist():
            keyword = [one.keyword for one in self.elements if (one.labels == label).any()][-1]
            raise keyword.error(f"element {label} is defined twice")
        order = np.argsort(labels, kind="stable")
        self.known["ELSET"] = labels[order], order

    def members(self, which: Which, name: str) -> IntArray:
        """Return the sorted members of a set, as numbers through the whole deck."""
        at = which, name
        if at not in self._found:
            self._found[at] = None
            self._found[at] = np.unique(
                raw.joined(self._resolved(which, of) for of in self.sets[at])
            )
        found = self._found[at]
        if found is None:
            raise self.sets[at][0].error(f"the set {name} must not contain itself")
        return found

    def _resolved(self, which: Which, card: Keyword) -> IntArray:
        """Return the members that a keyword adds to a set as numbers, ranges or other sets."""
        options, names = card.options, list[str]()
        scope = self.inner.get(key(options.get("INSTANCE", "")), self)
        if card.name in ("NODE", "ELEMENT"):
            return scope._numbered(which, card.labels)
        labels = []
        if "GENERATE" in options:
            known = scope.known[which][0]
            for row, texts in enumerate(card.rows):
                start, stop, step = padded(
                    card.integers(row, [one or "1" for one in texts]), 3 * [1]
                )[:3]
                if not (2 <= len(texts) <= 3 and step > 0 and start <= stop):
                    raise card.error("give the first number, the last and a positive step", row)
                inside = known[slice(*np.searchsorted(known, [start, stop + 1]).tolist())]
                chosen = inside[(inside - start) % step == 0]
                labels.append(chosen if len(chosen) else np.array([min(start, MOST)]))
        else:
            texts = [text for texts in card.rows for text in texts if text]
            numbers = [int(text) for text in texts if text.isdecimal()]
            if max(numbers, default=0) >= MOST:
                raise card.error(f"numbers must be below 2^53, got {max(numbers)}")
            labels.append(np.array(numbers, dtype=np.int64))
            names = [text for text in texts if not text.isdecimal()]
        wanted = raw.joined(labels)
        found = scope._numbered(which, wanted)
        for label in wanted[found < 0][:1].tolist():
            self.missing[f"{which} {options[which]}"] = label
        parts = [found[found >= 0], *(scope._named(which, name, card) for name in names)]
        if card.name == "NSET" and options.get("ELSET"):
            elements = scope._named("ELSET", options["ELSET"], card)
            for block, start, nodes in scope.blocks():
                own = elements[(elements >= start) & (elements < start + len(nodes))] - start
                if len(own) and not block.kind:
                    raise card.error(f"nodes of elements of type {block.type} are not read")
                parts.append(nodes[own].ravel())
        return raw.joined(parts)

    def _numbered(self, which: Which, labels: IntArray) -> IntArray:
        """Return numbers, through the whole deck, of nodes or elements by label; -1: undefined."""
        known, order = self.known[which]
        rows = raw.rows_of(known, labels)
        return np.where(rows < 0, -1, order[rows] + self.first[which]) if len(known) else rows

    def _named(self, which: Which, name: str, card: Keyword) -> IntArray:
        """Return the members that a name denotes: "set", "instance.set", or "instance.number"."""
        at = which, key(name)
        if at in self.sets:
            orders = [one.line.order for one in self.sets[at]]
            if min(orders) < card.line.order < max(orders):
                raise card.error(f"the set {name} gets more members below; define it before")
            return self.members(*at)
        outer, _, rest = name.partition(".")
        scope = self.inner.get(key(outer))
        if rest and scope is not None:
            if not rest.strip().isdecimal():
                return scope._named(which, rest, card)
            found = scope._numbered(which, np.array([int(rest)]))
            if found[0] >= 0:
                return found
        why = ""
        if rest and scope is None:
            why = f", and no instance {outer}; in a deck without parts give the numbers alone"
        raise card.error(f"there is no {which} {name}{why}")


# `_OF_SETS`: options of *NSET and *ELSET. `_READ`: for each keyword of the mesh, the function that
# reads it and its permitted options.
_OF_SETS = "ELSET GENERATE UNSORTED INTERNAL INSTANCE INPUT FREQUENCY"
_READ: dict[str, tuple[Callable[[Scope, Keyword], None], str]] = {
    "SYSTEM": (Scope._system, ""),
    "NODE": (Scope._node, "NSET SYSTEM INPUT"),
    "ELEMENT": (Scope._element, "TYPE ELSET INPUT"),
    "NSET": (Scope._set, f"NSET {_OF_SETS}"),
    "ELSET": (Scope._set, _OF_SETS),
}


# ----- sections and materials


_ONE_TEMPERATURE = "it depends on temperature; write its constants for one temperature"


def _constants(card: Keyword, count: int) -> list[float]:
    """Return `count` material constants of a keyword; refuse a dependence on temperature."""
    rows = [card.reals(row, texts) for row, texts in enumerate(card.rows)]
    numbers = [x for row in rows for x in row]
    if len(rows) > -(-(count + 1) // 8) or len(numbers) > count + 1:
        raise card.error(_ONE_TEMPERATURE)
    if len(numbers) < count:
        raise card.error(f"it must have {count} constants, got {len(numbers)}")
    return numbers[:count]


# For each TYPE of *ELASTIC: the number of elastic constants, and the function that makes the
# material from the constants and the density.
_ELASTIC: dict[str, tuple[int, Callable[..., Solid]]] = {
    **dict.fromkeys(("ISO", "ISOTROPIC"), (2, Source.isotropic)),
    "LAMINA": (6, Source.ply),
    "ENGINEERINGCONSTANTS": (9, Source.orthotropic),
}


@record
class _Section:
    """A section of a deck in one instance: its keyword, the instance's rotation, its elements."""

    source: Source
    deck: AbaqusDeck
    card: Keyword
    turn: FloatArray
    members: IntArray

    @property
    def blocks(self) -> list[_Elements]:
        """Blocks of the mesh that contain elements of the section."""
        return [self.deck.blocks[i] for i in np.unique(self.source.raw.block_of(self.members))]

    def material(self, name: str) -> Solid:
        """Return the material called `name`, from the user or the deck."""
        given: Solid | None = self.source.instead(name)
        if given is not None:
            return given
        own = self.deck.materials.get(key(name))
        if own is None:
            raise self.card.error(f"there is no *MATERIAL {name!r}")
        if missing := {"ELASTIC", "DENSITY"}.difference(own):
            give = f"read_sections(given={{{name!r}: Material(...)}})"
            raise own["MATERIAL"].error(f"{name} has no *{min(missing)}; write it, or give {give}")
        if left := [f"*{each}" for each in own if _kind(each) == "inelastic"]:
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
            return make(self.source, *_constants(elastic, count), rho)

    def differs(self, of: str, other: str, cure: str) -> None:
        """Warn that `of` is read as in Abaqus, not as in CalculiX, unless the deck has parts."""
        if not self.deck.whole.inner:  # CalculiX has no parts
            self.source.left_out.append(f"{of} as in Abaqus; {other} ({cure})")

    def axes(self, name: str) -> tuple[FloatArray, int]:
        """Return the unit axes of an orientation, in rows, and the number of its rotation axis.

        The second data line gives the rotation axis, and the angle by which the other axes are
        rotated about it. Without the line the rotation axis is 3; if blank, it is 1, as in Abaqus.
        """
        found: dict[str, Keyword] = {}
        for one in self.deck.cards:
            its = key(one.options.get("NAME", "")) if one.name == "ORIENTATION" else None
            if its == key(name) and found.setdefault(one.part, one) is not one:
                raise one.error(f"the orientation {name} is defined twice")
        own = found.get(self.card.part) or found.get("")
        if own is None:
            raise self.card.error(f"there is no *ORIENTATION {name!r}")
        own.check_options("NAME", "SYSTEM", "DEFINITION")
        kind = [key(own.options.get(each, "")) for each in ("SYSTEM", "DEFINITION")]
        if kind[0] not in ("", "RECTANGULAR") or kind[1] not in ("", "COORDINATES"):
            raise own.error("only rectangular axes by coordinates are supported")
        points, turn = own.lines_of(9, 2, what="points on the axes, and an axis and an angle")
        a, b, c = points.reshape(3, 3)
        axes = triad(a - c, b - c, own.error, _NORMAL)
        about, angle = turn.tolist() if len(own.rows) > 1 else (3.0, 0.0)
        if not about and angle:
            of = f"*ORIENTATION {name}: its angle is about axis 1, which is blank: taken"
            self.differs(of, "CalculiX leaves it out", _CURE)
        about = about or 1.0
        if about not in (1.0, 2.0, 3.0):
            raise own.error(f"the axis of rotation must be 1, 2 or 3, got {about:g}")
        rotation = Rotation.from_rotvec(angle * axes[int(about) - 1], degrees=True)
        return rotation.apply(axes) @ self.turn.T, int(about)

    def along(self, name: str) -> FloatArray:
        """Return the direction whose projection on a shell is axis 1 of the orientation `name`.

        This direction is the axis that follows the orientation's rotation axis (see `axes`); the
        rotation axis must not lie in an element. Without a name the direction is global x, or z if
        x is the normal.
        """
        normals = self.source.directions(self.members)
        if not name:
            level = np.linalg.norm(np.cross(normals, [1.0, 0.0, 0.0]), axis=1) < _NORMAL
            if level.any() and not level.all():
                raise self.card.error("x is the normal of some elements; give an *ORIENTATION")
            return np.array([0.0, 0.0, 1.0] if level.all() else [1.0, 0.0, 0.0])
        axes, near = self.axes(name)
        if np.abs(normals @ axes[near - 1]).min() < SAME:
            why = f"axis {near} of the orientation {name} lies in some elements"
            raise self.card.error(f"{why}; name the axis along the normal in its second line")
        if near != 3:
            of = f"*ORIENTATION {name}: axis {near} is along the normals: taken"
            self.differs(of, "CalculiX projects axis 1 on them", _CURE)
        return np.asarray(axes[near % 3])

    def angle(self, name: str, reference: FloatArray) -> float:
        """Return the angle, degrees, from `reference` to axis 1 of a ply's orientation `name`."""
        normals = self.source.directions(self.members)
        first, own = (across(v, normals) for v in (reference, self.along(name)))
        angles = np.arctan2(dot(np.cross(first, own), normals), dot(first, own))
        if np.abs(np.exp(1j * angles) - np.exp(1j * angles[0])).max() > SAME:
            raise self.card.error(f"{name} must be at one angle to the first ply in all elements")
        return float(np.degrees(angles[0]))

    def solid(self) -> OneMaterial:
        options = self.card.options
        found = self.material(options.get("MATERIAL", ""))
        if isinstance(found, Orthotropic) and (name := options.get("ORIENTATION")):
            return replace(found, axes=self.axes(name)[0])  # type: ignore[arg-type]
        return found

    def shell(self) -> OneMaterial:
        card, options = self.card, self.card.options
        rows = [padded(texts, 4 * [""])[:4] for texts in card.rows]
        if "COMPOSITE" not in options:
            if not options.get("MATERIAL") or len(rows) != 1:
                raise card.error("give MATERIAL=, and its thickness in one line")
            rows = [[rows[0][0], "", options["MATERIAL"], ""]]
        if not rows:
            raise card.error("it needs at least one ply")
        made = [self.material(row[2]) for row in rows]
        fibrous = [
            row[3] for row, of in zip(rows, made, strict=True) if isinstance(of, Orthotropic)
        ]
        # A ply has an orientation in CalculiX, an angle from the section's orientation in Abaqus.
        axis = options.get("ORIENTATION", "")
        if fibrous and all(map(_is_name, fibrous)):
            axis = axis or fibrous[0]
        plies = []
        for i, ((thickness, _, _, turned), own) in enumerate(zip(rows, made, strict=True)):
            length, angle = card.reals(i, [thickness, "" if _is_name(turned) else turned])
            if isinstance(own, Orthotropic) and _is_name(turned):
                angle = self.angle(turned, self.along(axis))
            plies.append(Ply(length * self.source.length, own, angle))
        text = key(options.get("OFFSET", "0"))
        (nodes,) = card.reals(0, [{"SPOS": "0.5", "SNEG": "-0.5"}.get(text, text)])
        symmetric = "SYMMETRIC" in options
        return layered(plies, lambda: self.along(axis), 0.0, -nodes, symmetric=symmetric)

    def beam(self) -> OneMaterial:
        """Return the `Beam`: its z axis is the section's axis 1, its y is opposite to axis 2."""
        card, source, options = self.card, self.source, self.card.options
        shape = key(options.get("SECTION", ""))
        rows = [card.reals(row, texts) for row, texts in enumerate(card.rows)]
        if shape == "CIRC":
            rows[:1] = [self.radius(row) for row in rows[:1]]
        count, make = (5, None) if shape == "GENERAL" else named(ABAQUS, shape)
        if shape == "ARBITRARY":  # has a data line for each wall
            walls = (
                int(rows[0][0]) if rows and rows[0] and rows[0][0] in range(len(rows) + 1) else 0
            )
            if not walls:
                raise card.error("its first number must be the number of walls; one line per wall")
            count, rows = 3 + 3 * walls, [[x for row in rows[:walls] for x in row], *rows[walls:]]
        if "MATERIAL" in options:
            material: Any = self.material(options["MATERIAL"])
        else:
            E, G, *_ = padded(rows.pop() if len(rows) > 1 else [], [0.0, 0.0])
            (rho,) = card.reals(-1, [options.get("DENSITY", "")])
            if not (E and G and rho):
                raise card.error("give MATERIAL=; or E and G in its third line, and DENSITY=")
            if len(rows) > 2 or [len(row) for row in rows[1:]] == [4]:
                raise card.error(_ONE_TEMPERATURE)
            material = source.isotropic(E, 0.5 * E / G - 1.0, rho)
        if [len(row) for row in rows[:2]] not in ([count], [count, 3]):
            raise card.error(f"give {count} numbers of the section, and axis 1: x, y and z")
        if make is None:
            area, I11, I12, I22, J = rows[0]
            section: Any = source.numbers(area, (I22, I12, I11), J, np.eye(2), np.zeros((1, 2)))
        else:
            section = make(*(x * source.length for x in rows[0]))
        if isinstance(section, TubularSection):
            return Beam(section, material)
        if any(block.towards for block in self.blocks):
            raise card.error("an extra node of its elements gives axis 1; write axis 1 instead")
        if normals := self.deck.normals:
            raise normals.error(
                f"it would turn the beams of {options['ELSET']}; write their axis 1"
            )
        z = (self.turn @ [*rows, [0.0, 0.0, -1.0]][1])[None, :]
        return source.beam(section, material, z, self.members, _AXES, np.zeros(3))

    def radius(self, numbers: list[float]) -> list[float]:
        """Return the radius of CIRC: Abaqus gives the radius, CalculiX one or two diameters."""
        if len(numbers) == 2 and numbers[0] != numbers[1]:
            raise self.card.error("ellipses are not supported")
        if len(numbers) == 2 or any(block.type.endswith("R") for block in self.blocks):
            return [0.5 * numbers[0]]  # only CalculiX has B31R and B32R
        of = f"{self.card.options['ELSET']}: SECTION=CIRC, {numbers[0]:g} is taken for a radius,"
        self.differs(of, "in CalculiX it is the diameter", "write it twice then")
        return numbers


def _is_name(text: str) -> bool:
    return text[:1] not in (*"+-.0123456789", "")


# For each keyword of a section: the function that reads it, the dimension of its elements, and the
# permitted options besides ELSET, MATERIAL and CONTROLS.
_SHELL = "COMPOSITE OFFSET ORIENTATION SYMMETRIC LAYUP SECTIONINTEGRATION TEMPERATURE POISSON"
_BEAM = "SECTION TEMPERATURE POISSON ROTARYINERTIA DENSITY"
_SECTIONS: dict[str, tuple[Callable[[_Section], OneMaterial], int, str]] = {
    "SOLIDSECTION": (_Section.solid, 3, "ORIENTATION"),
    "SHELLSECTION": (_Section.shell, 2, _SHELL),
    "SHELLGENERALSECTION": (_Section.shell, 2, _SHELL),
    "BEAMSECTION": (_Section.beam, 1, _BEAM),
    "BEAMGENERALSECTION": (_Section.beam, 1, _BEAM),
}
