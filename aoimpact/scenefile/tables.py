"""Tables of a scene file, the functions that each table calls, and the values of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from .. import accuracy, fem, impact, integrate, io, laws, reduction
from ..accuracy import Sensor, keeper
from ..base import FloatArray, InputError, choice, integer, nearest, positive, real
from ..contact import ContactPoint, contact_point
from ..fem import Damping, Layers, OneMaterial, thin_groups
from ..impact import Scene
from ..laws import LAWS
from ..mesh import AT_NODE, Mesh, box_mesh, sheet_mesh, sphere_mesh
from ..reduction import BodyModel, body_model
from ..results import QUANTITIES, BodyResult, ContactResult, ErrorEstimate, Handle
from .binding import PATH, READERS, Binder, Call, Numbers, Reader, Table, passes_on, table, typed
from .lines import Place

Triple = tuple[float, float, float]

# ------------------------------------------------------------------------------ materials


def _constants(E: Triple, G: Triple, nu: Triple) -> dict[str, Triple]:
    return {"E": E, "G": G, "nu": nu}


def _orthotropic(
    orthotropic: Annotated[Any, table(_constants)],
    rho: float,
    axes: Numbers | None = None,
    turned: float = 0.0,
) -> fem.Orthotropic:
    given = {} if axes is None else {"axes": axes}
    made = fem.Orthotropic(**orthotropic, rho=rho, **given)  # type: ignore[arg-type]
    return made.turned(turned, made.axes[2]) if turned else made


_MATERIALS = (
    Table(fem.Material),
    Table(_orthotropic),
    Table(fem.Shell, {"shell": "material"}),
    Table(fem.Laminate, {"laminate": "plies"}),
    Table(fem.Beam, {"beam": "material"}),
)


def _named(which: str) -> Reader:
    """Return the `Reader` that takes a name from [`which`] and returns that material or body."""
    return Reader(f"a name from [{which}]", (str,), lambda binder, *at: binder.entry(which, *at))


_MATERIAL = _named("materials")
READERS.update(dict.fromkeys((fem.Material, fem.Orthotropic, Layers, fem.Beam), _MATERIAL))

# ------------------------------------------------------------------------ meshes and bodies


@dataclass(frozen=True)
class _MeshFile:
    """A mesh file and its units: `scale` of length, m, `force`, N, and `time`, s."""

    file: Annotated[Any, PATH]
    scale: float = 1.0
    force: float = 1.0
    time: float = 1.0


_MESHES = (
    Table(_MeshFile),
    Table(sphere_mesh, {"sphere": "radius"}),
    Table(box_mesh, {"box": "lengths"}),
    Table(sheet_mesh, {"sheet": "lengths"}),
)


def _read_mesh(binder: Binder, value: Any, place: Place) -> Call:
    if isinstance(value, dict):
        return binder.bind(_MESHES, value, place)
    if value == "paper-sphere":
        return Call(io.paper_sphere_mesh, {}, place)
    return binder.bind(_MESHES[0], {"file": value}, place)


def _where(
    nodes: str | Sequence[int] | None = None,
    x: float | None = None,
    y: float | None = None,
    z: float | None = None,
) -> Any:
    """Return `nodes` or, if None, the function that selects the nodes on all given planes."""
    planes = np.array([x, y, z], dtype=float)
    free = np.isnan(planes)
    if (nodes is None) == free.all():
        raise InputError("give either nodes, or planes x, y, z on all of which they lie")

    def on_planes(places: FloatArray) -> Any:
        near = np.abs(places - planes) <= AT_NODE * np.ptp(places, axis=0).max()
        return (free | near).all(axis=1)

    return on_planes if nodes is None else nodes


@passes_on(_where)
def _support(hold: str, hold_rotations: str | None = None, **where: Any) -> Any:
    return (_where(**where), hold, *([] if hold_rotations is None else [hold_rotations]))


@passes_on(_where)
def _mass(
    mass: float, centre: Numbers | None = None, inertia: Numbers | None = None, **where: Any
) -> Any:
    if centre is None and inertia is None:
        return _where(**where), mass
    return fem.RigidMass(_where(**where), mass, centre, inertia)  # type: ignore[arg-type]


@passes_on(_where)
def _spring(along: str, stiffness: float, **where: Any) -> Any:
    return _where(**where), along, stiffness


@passes_on(fem.FEModel.from_mesh)
def _meshed(
    mesh: Annotated[Any, Reader("a path or a table", (str, dict), _read_mesh)],
    material: OneMaterial | Mapping[str, OneMaterial] | None = None,
    fixed: Sequence[Annotated[Any, table(_support)]] = (),
    masses: Sequence[Annotated[Any, table(_mass)]] = (),
    springs: Sequence[Annotated[Any, table(_spring)]] = (),
    part: str | Sequence[str] | None = None,
    order: int | None = None,
    **more: Any,
) -> fem.FEModel:
    file = mesh if isinstance(mesh, _MeshFile) else _MeshFile(mesh)
    if material is None and isinstance(mesh, Mesh):
        raise InputError("material is missing; only a deck of Abaqus or Nastran has its own")
    if material is None:
        material = io.read_sections(file.file, scale=file.scale, force=file.force, time=file.time)
    solid = io.read_for(file.file, thin_groups(material), scale=file.scale, part=part, order=order)
    return fem.FEModel.from_mesh(
        solid, material, fixed=fixed, masses=masses, springs=springs, **more
    )


@passes_on(io.read_matrices, "damping", "name")
def _files(**given: Any) -> dict[str, Any]:
    return given


def _of_matrices(
    matrices: Annotated[Any, table(_files)], damping: Damping | None = None, name: str = ""
) -> fem.FEModel:
    return io.read_matrices(**matrices, damping=damping, name=name)


_MODELS = reduction.antioscillators, reduction.modal, reduction.interface, reduction.full
_MODEL = typed(*(Table(one, keep=True) for one in _MODELS), tip="contact", tips="contact")
_CONTACT = Annotated[Any, table(fem.FEModel.contact)]


def _touched(
    name: str,
    contact: _CONTACT | Sequence[_CONTACT],
    model: Annotated[Any, _MODEL] = None,
) -> BodyModel:
    return body_model(name, contact) if model is None else model


_BODIES = (
    Table(reduction.rigid),
    Table(reduction.wall, {"wall": "material"}),
    Table(reduction.ball, {"ball": "radius"}),
    Table(reduction.AOModel),
    Table(_touched, owner=_meshed, keep=True),
    Table(_touched, owner=_of_matrices, keep=True),
)

# ---------------------------------------------------------------------------- laws and solvers


def _surface(material: OneMaterial, radius: float | Sequence[float]) -> Any:
    return material, radius


_SIDE = Annotated[Any, table(_surface)]


@cache
def _of_surfaces(law: Callable[..., laws.ContactLaw]) -> Table:
    """Return the table that makes a law from the materials and radii of two surfaces."""

    @passes_on(law, "material_1", "radius_1", "material_2", "radius_2")
    def made(between: tuple[_SIDE, _SIDE], **more: Any) -> laws.ContactLaw:
        return law(*between[0], *between[1], **more)

    return Table(made)


def _read_law(binder: Binder, value: Any, place: Place) -> Any:
    """Return the `Call` that makes a law from its parameters, or from a coefficient of restitution.

    The stiffness k may be given by two surfaces.
    """
    law, given = binder.tagged(value, place, _LAWS)
    if law is None:
        return None
    makers = [Table(law), Table(getattr(law, "from_restitution", law))]
    k, at, follows = given.get("k"), (*place, "k"), dict[str, Any]()
    if isinstance(k, dict):
        if not issubclass(law, laws.HertzianLaw) or given.pop("n", law.power) != law.power:
            return binder.say(at, "of two surfaces is only for laws F = k δ^1.5; give a number")
        hertz = binder.bind(_of_surfaces(laws.Hertz.between), given.pop("k"), at)
        for name in ("k", "relative_radius"):
            part = partial(lambda name, law: getattr(law, name), name)
            follows[name] = Call(part, {"law": hertz}, place)
        if hasattr(law, "between"):
            makers.insert(0, _of_surfaces(law.between))
            follows["between"] = hertz.arguments.get("between")
            given |= {"angle": k["angle"]} if "angle" in k else {}
    return binder.bind(makers, given, place, **follows)


_LAWS = {name: law for name, law in LAWS.items() if law is not laws.UserLaw}

# ------------------------------------------------------------------------------------- sensors


def _finite(name: str, body: Any) -> fem.FEModel:
    """Return the finite-element model of a body."""
    if not body.tips:
        raise InputError(f"body must have finite elements, which {name!r} has not")
    model: fem.FEModel = body.tips[0].body
    return model


def _read_finite(binder: SceneBinder, name: str, place: Place) -> Any:
    body = binder.find(dict(binder.taking), "the scene", name, place)
    return body and Call(_finite, {"name": name, "body": body}, place)


_FINITE = Annotated[Any, Reader("the name of a body", (str,), _read_finite)]
_SENSORS = accuracy.StressAt, accuracy.StrainAt, accuracy.AccelerationAt, accuracy.ReactionAt
_TYPED = typed(*(Table(one, hints={"body": _FINITE}) for one in _SENSORS))


def _place(body: _FINITE, point: Numbers, direction: Numbers) -> ContactPoint:
    return contact_point(body, point=point, direction=direction, radius=0.0)  # type: ignore[arg-type]


def _read_sensor(binder: Binder, value: Any, place: Place) -> Any:
    """Return the `Call` that makes a sensor; without `type`, a point that measures displacement."""
    if "type" not in value:
        return binder.bind(Table(_place), value, place)
    if "body" not in value:
        binder.say(place, "'body' is missing, the name of a body")
    return _TYPED(binder, value, place)


_SENSOR = Reader("a table of a sensor", (dict,), _read_sensor)
_PROBES = Mapping[str, Annotated[Any, _SENSOR]]

# ------------------------------------------------------------------------- impacts and scenes

# Class of each part of a result, by the first word in the names of the part's numbers.
_PARTS: dict[str, type] = dict.fromkeys(("bodies", "projectile", "target"), BodyResult)
_PARTS |= {"contacts": ContactResult, "error": ErrorEstimate}


def _read_number(binder: SceneBinder, name: str, place: Place) -> Any:
    """Return the name of a number of the results; record a problem if results do not have it."""
    try:
        keeper((name,))
    except InputError as error:
        return binder.say(place, str(error).removeprefix("keep: "))
    first, *rest = name.split(".")
    if first not in _PARTS or (first == "contacts" and "impact" in binder.data):
        return name
    if first in ("bodies", "contacts"):
        listed = binder.taking if first == "bodies" else binder.data["scene"].get("contacts")
        numbers = {str(i): of for i, of in enumerate(listed if isinstance(listed, list) else ())}
        if binder.find(numbers, first, rest.pop(0) if rest else "", place) is None:
            return None
    part, last = _PARTS[first], rest[0] if rest else ""
    known = {*dir(part), *vars(part)["__dataclass_fields__"]}
    known |= {name for name, of in QUANTITIES.items() if of.each == first and not of.is_history}
    if last not in known:
        binder.say(place, f"{name!r}: {part.__name__} has no {last!r}{nearest(last, known)}")
    return name


_NAMES = Sequence[Annotated[Any, Reader("the name of a number", (str,), _read_number)]]


def _read_role(binder: SceneBinder, name: str, place: Place) -> Any:
    body = binder.entry("bodies", name, place)
    binder.taking.append((name, body))
    return body


_ROLE = Annotated[Any, Reader("a name from [bodies]", (str,), _read_role)]


@passes_on(impact.simulate)
def _impact(
    projectile: _ROLE,
    target: _ROLE,
    report: _NAMES | None = None,
    probes: _PROBES | None = None,
    **more: Any,
) -> dict[str, Any]:
    return {"projectile": projectile, "target": target, **more}


_MEMBER = Table(Scene.add, hints={"body": Annotated[Any, _named("bodies")]})


def _read_member(binder: SceneBinder, value: Any, place: Place) -> Any:
    name = value.get("name", value.get("body", ""))
    found = binder.bind(_MEMBER, {"name": name, **value}, place)
    if isinstance(name, str):  # else a problem is recorded already
        if name in binder.handles:
            binder.say((*place, "name"), f"{name!r} is another body of the scene; give a new name")
        binder.handles[name] = found
        binder.taking.append((name, found.arguments.get("body")))
    return found


def _port(body: Handle, port: int = 0) -> Handle:
    return body.port(port)


def _read_handle(binder: SceneBinder, value: Any, place: Place) -> Any:
    """Return the `Call` for a body of the scene, or for one contact point of the body."""
    if isinstance(value, dict):
        return binder.bind(Table(_port), value, place)
    return binder.find(binder.handles, "the scene", value, place)


@passes_on(Scene.connect, "a", "b")
def _contact(self: Scene, between: tuple[Handle, Handle], **more: Any) -> int:
    return self.connect(*between, **more)


def _history(self: Scene, body: Handle, times: Numbers, forces: Numbers) -> None:
    self.apply(body, force=(times, forces))


def _read_wanted(binder: SceneBinder, value: Any, place: Place) -> Any:
    """Return a scene's quantity: its name, a body, a contact point of a body, or a sensor."""
    if isinstance(value, str):
        return binder.handles.get(value, value)
    return (_read_handle if "port" in value else _read_sensor)(binder, value, place)


_LOADS = table(Table(Scene.apply, hints={"force": float}), _history)


@passes_on(Scene.simulate)
def _scene(
    self: Scene,
    bodies: Sequence[Annotated[Any, Reader("a table", (dict,), _read_member)]],
    contacts: Sequence[Annotated[Any, table(_contact)]] = (),
    loads: Sequence[Annotated[Any, _LOADS]] = (),
    report: _NAMES | None = None,
    probes: _PROBES | None = None,
    **keywords: Any,
) -> tuple[Scene, dict[str, Any]]:
    return self, keywords


_WANTED = Annotated[Any, Reader("a name or a table", (str, dict), _read_wanted)]
_SCENE = Table(_scene, hints={"quantity": _WANTED | Sequence[_WANTED]}, owner=Scene)

# ------------------------------------------------------------------------------------- sweeps

# Largest number of values for one parameter of a sweep; more values are taken for a mistake.
_MOST_VALUES = 1_000_000


def _range(start: float, to: float, count: int, spacing: str = "linear") -> list[Any]:
    """Return `count` values from `start` to `to`; integers if ends and linear steps are whole."""
    integer("count", count, low=1, high=_MOST_VALUES)
    log = choice("spacing", spacing, ("linear", "log")) == "log"
    for name, end in (("from", start), ("to", to)):
        (positive if log else real)(name, end)
    found = (np.geomspace if log else np.linspace)(start, to, count)
    whole = isinstance(start, int) and isinstance(to, int) and (found == np.rint(found)).all()
    return list((found.astype(int) if whole and not log else found).tolist())


_RANGE = Table(_range, {"from": "start"})


def _read_over(binder: Any, value: Any, place: Place) -> dict[str, Any]:
    """Return a sweep's values by dotted place: a list, or the call that makes a range."""
    found: dict[str, Any] = {}
    for key, entry in value.items():
        at = (*place, key)
        name = ".".join(map(str, at[2:]))
        if isinstance(entry, dict) and "from" not in entry:
            found |= _read_over(binder, entry, at)
        elif isinstance(entry, dict):
            found[name], binder.swept[name] = binder.bind(_RANGE, entry, at), at
        elif isinstance(entry, list) and entry:
            found[name], binder.swept[name] = entry, at
        else:
            binder.say(at, "must be a list of values, or { from = 0.0, to = 1.0, count = 5 }")
    if not value:
        binder.say(place, "must name what to sweep over, such as velocity = [0.5, 1.0]")
    return found


OVER = Reader("a table", (dict,), _read_over)


def place_of(data: Mapping[str, Any], kind: str, name: str) -> Place:
    """Return the place that a dotted name denotes, by default within the impact or scene.

    Raises
    ------
    InputError
        If the file has no table of such a name.
    """
    parts = name.split(".")
    if parts[0] not in (kind, "title", "materials", "bodies"):
        parts.insert(0, kind)
    inside: Any = data
    place: list[str | int] = []
    for i, part in enumerate(parts):
        table = isinstance(inside, dict)
        known = {key: key for key in inside} if table else dict(_numbered(inside))
        if part not in known and not (table and i == len(parts) - 1):  # else it may be a new key
            there = f"; there are {', '.join(known)}" if known else ""
            raise InputError(f"the file has no {part!r} there{nearest(part, known) or there}")
        place.append(known.get(part, part))
        inside = inside[place[-1]] if part in known else None
    return tuple(place)


def _numbered(entries: Any) -> Iterator[tuple[str, int]]:
    """Yield pairs of name and index for a list's entries: index as text, and the body's name."""
    entries = entries if isinstance(entries, list) else []
    for i, entry in enumerate(entries):
        yield str(i), i
        if isinstance(entry, dict) and isinstance(entry.get("body"), str):
            yield str(entry.get("name", entry["body"])), i


# ------------------------------------------------------------------------------ the whole file


def _sweep(
    over: Annotated[Any, OVER],
    keep: _NAMES | None = None,
    workers: int = 1,
    checkpoint: str | None = None,
) -> Any:
    """Return the grid of a sweep; `batch` reads the other settings."""
    integer("workers", workers, low=1)
    keeper(keep)
    return over


def _read_each(binder: SceneBinder, value: Any, place: Place) -> None:
    """Bind all materials or bodies in the file, whether a run uses them or not."""
    for name in value:
        binder.entry(str(place[0]), name, place)


_EACH = Annotated[Any, Reader("a table", (dict,), _read_each)]


def _file(
    *,
    materials: _EACH = None,
    bodies: _EACH,
    impact: Annotated[Any, table(_impact)] = None,
    scene: Annotated[Any, table(_SCENE)] = None,
    sweep: Annotated[Any, table(_sweep)] = None,
    title: str = "",
) -> None:
    """Declare the top-level tables of a file as parameters."""


_FILE = Table(_file)
_UNFINISHED = object()


class SceneBinder(Binder):
    """Binds all tables of a scene file to functions.

    Attributes
    ----------
    data : mapping
        Content of the file as tomllib gives it.
    taking : list of (str, Call)
        Name of each body that takes part, and the call that makes it, in the order of the run.
    handles : dict of str to Call
        Calls that add the bodies to the scene, by their names in the scene.
    swept : dict of str to tuple
        For each dotted name of a swept parameter, the place of its values in the file.
    """

    def __init__(self, data: Mapping[str, Any], folder: Path) -> None:
        super().__init__(folder)
        self.data = data
        self.taking: list[tuple[str, Any]] = []
        self.handles: dict[str, Any] = {}
        self.swept: dict[str, Place] = {}
        self._found: dict[Place, Any] = {}
        self.bound = self.bind(_FILE, data, ()).arguments
        if ("impact" in data) == ("scene" in data):
            self.say((), "the file needs either an [impact] or a [scene]")

    def entry(self, which: str, name: str, place: Place) -> Any:
        """Return the file's material or body called `name`, which is bound only once."""
        entries = self.data.get(which)
        given = self.find(entries if isinstance(entries, dict) else {}, f"[{which}]", name, place)
        at = which, name
        if at not in self._found and given is not None:
            self._found[at] = _UNFINISHED
            self._found[at] = _ENTRIES[which](self, given, at)
        if self._found.get(at) is _UNFINISHED:
            return self.say(place, f"{name!r} must not refer to itself")
        return self._found.get(at)


_ENTRIES = {
    "materials": table(*_MATERIALS),
    "bodies": Reader(
        "a table",
        (dict,),
        lambda binder, value, place: binder.bind(_BODIES, value, place, name=place[-1]),
    ),
}

_SECTIONS = fem.BeamSection, fem.RectangularSection, fem.CircularSection, fem.TubularSection
_SOLVERS = integrate.Adaptive, integrate.Newmark
READERS.update(
    {
        **dict.fromkeys(_SECTIONS, table(*_SECTIONS)),
        **dict.fromkeys((fem.Rayleigh, fem.ModalDamping), table(fem.Rayleigh, fem.ModalDamping)),
        **dict.fromkeys(_SOLVERS, typed(*_SOLVERS)),
        **dict.fromkeys((Sensor, ContactPoint), _SENSOR),
        fem.Ply: table(fem.Ply),
        laws.ContactLaw: Reader("a table", (dict,), _read_law),
        Handle: Reader("the name of a body of the scene", (str, dict), _read_handle),
    }
)
