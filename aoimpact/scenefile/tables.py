"""Tables of a scene file, and the functions that each of them calls."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from .. import accuracy, fem, impact, integrate, io, laws, reduction
from ..accuracy import Sensor
from ..base import FloatArray, InputError, nearest
from ..fem import ContactPoint, Damping, Layers, OneMaterial, contact_point, thin_groups
from ..impact import Scene, SceneCase
from ..laws import LAWS
from ..mesh import Mesh, box_mesh, sheet_mesh, sphere_mesh
from ..reduction import body_model
from ..results import Handle
from .binding import PATH, Binder, Call, Numbers, Reader, Table, passes_on, table
from .lines import Place
from .sweeping import OVER

# A node lies on a plane of a support if it is closer than this fraction of the body's size.
_ON_PLANE = 1e-6

# The power of the indentation in Hertz's law.
_HERTZ_POWER = 1.5

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
_MADE_OF = (fem.Material, fem.Orthotropic, Layers, fem.Beam)


def _material(*allowed: Any) -> Reader:
    """The name of a material of some classes."""

    def read(binder: SceneBinder, name: str, place: Place) -> Any:
        known = binder.named("materials")
        if name not in known:
            listed = ", ".join(known) or "nothing"
            return binder.say(
                place, f"[materials] has no {name!r}{nearest(name, known)}; it has {listed}"
            )
        if not isinstance(known[name], dict):  # which is said there
            return None
        made = min(_MATERIALS, key=lambda one: one.faults(known[name], ())).makes
        if not issubclass(made, allowed):
            wanted = " or ".join(one.__name__ for one in allowed)
            return binder.say(place, f"{name!r} is a {made.__name__}, and a {wanted} is needed")
        return binder.material(name)

    return Reader("a name from [materials]", (str,), read)


# ------------------------------------------------------------------------ meshes and bodies


@dataclass(frozen=True)
class _MeshFile:
    """A mesh file; `force` and `time` are the units of its sections."""

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


@dataclass(frozen=True)
class _Planes:
    """Nodes on all of some planes, as a selector of `FEModel.from_mesh`."""

    x: float | None = None
    y: float | None = None
    z: float | None = None

    def __call__(self, nodes: FloatArray) -> Any:
        on = np.ones(len(nodes), dtype=bool)
        size = np.ptp(nodes, axis=0).max()
        for axis, value in enumerate((self.x, self.y, self.z)):
            if value is not None:
                on &= np.abs(nodes[:, axis] - value) <= _ON_PLANE * size
        return on


def _where(
    nodes: str | Sequence[int] | None = None,
    x: float | None = None,
    y: float | None = None,
    z: float | None = None,
) -> Any:
    """Nodes by name, by number, or by planes."""
    if (nodes is None) == (x is None and y is None and z is None):
        raise InputError("give either nodes, or planes x, y, z on all of which they lie")
    return _Planes(x, y, z) if nodes is None else nodes


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


_PATHS = dict.fromkeys(("dofs", "nodes", "mesh"), Annotated[Any, PATH])


def _read_files(binder: Binder, value: Any, place: Place) -> Call:
    return binder.bind(Table(_files, hints=_PATHS), value, place)


def _of_matrices(
    matrices: Annotated[Any, Reader("a table", (dict,), _read_files)],
    damping: Damping | None = None,
    name: str = "",
) -> fem.FEModel:
    return io.read_matrices(**matrices, damping=damping, name=name)


_TOUCHED = ("contact", "model")
_BODIES = (
    Table(reduction.rigid),
    Table(reduction.wall, {"wall": "material"}),
    Table(reduction.ball, {"ball": "radius"}),
    Table(reduction.AOModel),
    Table(_meshed, beside=_TOUCHED),
    Table(_of_matrices, beside=_TOUCHED),
)
_MODELS = {
    one.__name__: Table(one)
    for one in (reduction.antioscillators, reduction.modal, reduction.interface, reduction.full)
}


def _read_body(binder: SceneBinder, name: str, place: Place) -> Call | None:
    """The body of [bodies] that takes part in an impact or a scene."""
    known = binder.named("bodies")
    if name not in known:
        binder.say(
            place, f"[bodies] has no {name!r}{nearest(name, known)}; it has {', '.join(known)}"
        )
        return None
    found: Call | None = binder.taking.setdefault(name, binder.body(name))
    return found


_BODY = Annotated[Any, Reader("a name from [bodies]", (str,), _read_body)]

# ---------------------------------------------------------------------------- laws and solvers

_LAWS = {name: law for name, law in LAWS.items() if law is not laws.UserLaw}


def _surface(material: OneMaterial, radius: float | Sequence[float]) -> Any:
    return material, radius


_SIDE = Annotated[Any, table(_surface)]


def _surfaces(between: tuple[_SIDE, _SIDE]) -> Any:
    return between


def _stiffness(law: laws.Hertz) -> float:
    return law.k


def _radius(law: laws.Hertz) -> float | None:
    return law.relative_radius


def _read_law(binder: Binder, value: Any, place: Place) -> Any:
    """A law by its parameters or its restitution; k may be that of two surfaces."""
    cls, given = binder.tagged(value, place, _LAWS)
    if cls is None:
        return None
    makers = [cls, getattr(cls, "from_restitution", cls)]
    k = given.get("k")
    if not isinstance(k, dict):
        return binder.bind([Table(make) for make in makers], given, place)
    if not hasattr(cls, "relative_radius"):
        return binder.say((*place, "k"), f"must be a number for {cls.__name__}, got a table")
    if given.pop("n", _HERTZ_POWER) != _HERTZ_POWER:
        binder.say((*place, "n"), "k of two surfaces belongs to n = 1.5; give a number for k")
    of, angle = dict(given.pop("k")), {}
    if "angle" in of:
        angle["angle"] = of.pop("angle")
    sides = binder.bind(Table(_surfaces), of, (*place, "k")).arguments.get("between") or ()
    if len(sides) != 2 or None in sides:  # which is said
        return None
    surfaces = {
        f"{name}_{i}": side.arguments.get(name)
        for i, side in enumerate(sides, 1)
        for name in ("material", "radius")
    }
    hertz = binder.bind(Table(laws.Hertz.between), angle, (*place, "k"), surfaces)
    follows = {
        name: Call(get, {"law": hertz}, place)
        for name, get in (("k", _stiffness), ("relative_radius", _radius))
    }
    tables = [Table(make) for make in makers]
    if hasattr(cls, "between"):
        tables.insert(0, Table(cls.between))
    given |= angle if hasattr(cls, "between") else {}
    return binder.bind(tables, given, place, surfaces | follows)


_SOLVERS = {one.__name__: Table(one) for one in (integrate.Adaptive, integrate.Newmark)}

# ------------------------------------------------------------------------------------- sensors


def _finite(name: str, body: Any) -> fem.FEModel:
    """The finite-element model of a body."""
    if not body.contact_points:
        raise InputError(f"body: {name!r} has no finite elements, so no places")
    model: fem.FEModel = body.contact_points[0].body
    return model


def _read_finite(binder: SceneBinder, name: str, place: Place) -> Any:
    known = binder.taking
    if name in known:
        return Call(_finite, {"name": name, "body": known[name]}, place)
    return binder.say(place, f"the scene has no {name!r}{nearest(name, known)}")


_FINITE = Annotated[Any, Reader("the name of a body", (str,), _read_finite)]
_SENSORS = {
    one.__name__: Table(one, hints={"body": _FINITE})
    for one in (accuracy.StressAt, accuracy.StrainAt, accuracy.AccelerationAt, accuracy.ReactionAt)
}


def _place(body: _FINITE, point: Numbers, direction: Numbers) -> ContactPoint:
    return contact_point(body, point=point, direction=direction, radius=0.0)  # type: ignore[arg-type]


def _read_sensor(binder: Binder, value: Any, place: Place) -> Any:
    """A sensor, or, without a type, a place whose displacement is meant."""
    if "body" not in value:
        binder.say(place, "'body' is missing, the name of a body")
    if "type" not in value:
        return binder.bind(Table(_place), value, place)
    return binder.bind_typed(_SENSORS, value, place)


_SENSOR = Reader("a table of a sensor", (dict,), _read_sensor)
_PROBES = Mapping[str, Annotated[Any, _SENSOR]]

# ------------------------------------------------------------------------- impacts and scenes


@passes_on(impact.simulate)
def _impact(
    projectile: _BODY,
    target: _BODY,
    report: Sequence[str] | None = None,
    probes: _PROBES | None = None,
    **more: Any,
) -> dict[str, Any]:
    return {"projectile": projectile, "target": target, **more}


@passes_on(Scene.add)
def _member(self: Scene, body: _BODY, **more: Any) -> Handle:
    return self.add(body, **more)


def _read_member(binder: SceneBinder, value: Any, place: Place) -> Any:
    name = value.get("name", value.get("body", ""))
    given = value if "name" in value else {"name": name, **value}
    found = binder.bind(Table(_member), given, place, {"self": binder.scene})
    if isinstance(name, str):  # or it has been refused
        if name in binder.handles:
            binder.say((*place, "name"), f"{name!r} is another body of the scene; give a new name")
        binder.handles[name] = found
        binder.taking[name] = found.arguments.get("body")
    return found


def _read_handle(binder: SceneBinder, value: Any, place: Place) -> Any:
    """A body of the scene, or one of its places."""
    if isinstance(value, dict):
        return binder.bind(Table(_port), value, place)
    known = binder.handles
    if value in known:
        return known[value]
    return binder.say(
        place, f"the scene has no body {value!r}{nearest(value, known)}; it has {', '.join(known)}"
    )


_HANDLE = Reader("the name of a body of the scene", (str, dict), _read_handle)


def _port(body: Handle, port: int = 0) -> Handle:
    return body.port(port)


@passes_on(Scene.connect, "a", "b")
def _contact(self: Scene, between: tuple[Handle, Handle], **more: Any) -> int:
    return self.connect(*between, **more)


def _push(self: Scene, body: Handle, force: float) -> None:
    self.apply(body, force=force)


def _history(self: Scene, body: Handle, times: Numbers, forces: Numbers) -> None:
    self.apply(body, force=(times, forces))


def _of_scene(*functions: Callable[..., Any]) -> Reader:
    """A table of what is added to a scene."""
    tables = tuple(map(Table, functions))
    return Reader(
        "a table",
        (dict,),
        lambda binder, value, place: binder.bind(tables, value, place, {"self": binder.scene}),
    )


def _read_wanted(binder: SceneBinder, value: Any, place: Place) -> Any:
    """The quantity of a scene: a name, a body, one of its places, or a sensor."""
    if isinstance(value, list):
        return [_read_wanted(binder, one, (*place, i)) for i, one in enumerate(value)]
    if isinstance(value, str):
        return binder.handles.get(value, value)
    return (_read_handle if "port" in value else _read_sensor)(binder, value, place)


@passes_on(Scene.simulate, "self")
def _scene(
    scene: Scene,
    bodies: Sequence[Annotated[Any, Reader("a table", (dict,), _read_member)]],
    contacts: Sequence[Annotated[Any, _of_scene(_contact)]] = (),
    loads: Sequence[Annotated[Any, _of_scene(_push, _history)]] = (),
    gravity: float | Numbers = 0.0,
    report: Sequence[str] | None = None,
    probes: _PROBES | None = None,
    quantity: Annotated[Any, Reader("a name or a table", (str, dict, list), _read_wanted)] = None,
    duration: float | None = None,
    **more: Any,
) -> tuple[SceneCase, float | None]:
    return SceneCase(scene, more | ({} if quantity is None else {"quantity": quantity})), duration


def _read_scene(binder: SceneBinder, value: Any, place: Place) -> Call:
    gravity = {"gravity": value["gravity"]} if "gravity" in value else {}
    binder.scene = Call(Scene, gravity, place)
    return binder.bind(Table(_scene), value, place, {"scene": binder.scene})


# ------------------------------------------------------------------------------------ the file


def _sweep(
    over: Annotated[Any, OVER],
    keep: Sequence[str] | None = None,
    workers: int = 1,
    checkpoint: str | None = None,
) -> None:
    """Read by `batch`."""


def _read_each(binder: SceneBinder, value: Any, place: Place) -> Any:
    """All materials or bodies, whether they take part or not."""
    for name, one in value.items():
        if isinstance(one, dict):
            (binder.material if place == ("materials",) else binder.body)(name)
        else:
            binder.say((*place, name), f"must be a table, got {one!r}")


_EACH = Annotated[Any, Reader("a table", (dict,), _read_each)]


def _file(
    *,
    materials: _EACH = None,
    bodies: _EACH,
    impact: Annotated[Any, table(_impact)] = None,
    scene: Annotated[Any, Reader("a table", (dict,), _read_scene)] = None,
    sweep: Annotated[Any, table(_sweep)] = None,
    title: str = "",
) -> None:
    """The tables at the top."""


class SceneBinder(Binder):
    """Binds the tables of a file.

    Attributes
    ----------
    data : mapping
        As tomllib gives it.
    taking : dict of str to Call
        Bodies that take part, by name.
    scene : Call
    handles : dict of str to Call
        Bodies in the scene, by their names there.
    """

    scene: Call

    def __init__(self, data: Mapping[str, Any], folder: Path) -> None:
        super().__init__(folder)
        self.data = data
        self.taking: dict[str, Any] = {}
        self.handles: dict[str, Any] = {}
        self._found: dict[Place, Any] = {}
        self.bound = self.bind(Table(_file), data, ()).arguments
        if ("impact" in data) == ("scene" in data):
            self.say((), "the file needs either an [impact] or a [scene]")

    @property
    def members(self) -> list[str]:
        """Names of the bodies in the order of the run."""
        if self.handles:
            return list(self.handles)
        return [self.data["impact"][role] for role in ("projectile", "target")]

    def named(self, which: str) -> Mapping[str, Any]:
        """Return the entries of a table at the top; none if it is no table."""
        found = self.data.get(which)
        return found if isinstance(found, dict) else {}

    def material(self, name: str) -> Any:
        """Return a material of the file, bound once."""
        place = ("materials", name)
        if place not in self._found:
            self._found[place] = self.bind(_MATERIALS, self.data["materials"][name], place)
        return self._found[place]

    def body(self, name: str) -> Any:
        """Return a body of the file, bound once."""
        place = ("bodies", name)
        if place not in self._found:
            self._found[place] = self._body(self.data["bodies"][name], name, place)
        return self._found[place]

    def _body(self, value: Any, name: str, place: Place) -> Any:
        if not isinstance(value, dict):  # which is said
            return None
        body = self.bind(_BODIES, value, place, {"name": name}, keep=True)
        if body.function not in (_meshed, _of_matrices):
            return body
        if "contact" not in value:
            return self.say(place, "'contact' is missing, a table or a list of tables")
        touched, several = value["contact"], isinstance(value["contact"], list)
        tips = []
        for i, one in enumerate(touched if several else [touched]):
            at = (*place, "contact", i) if several else (*place, "contact")
            if isinstance(one, dict):
                tips.append(self.bind(Table(fem.FEModel.contact), one, at, {"self": body}))
            else:
                self.say(at, f"must be a table, got {one!r}")
        model, at = value.get("model"), (*place, "model")
        if model is None:
            return Call(body_model, {"name": name, "body": tips}, at, keep=True)
        if not isinstance(model, dict):
            return self.say(at, f"must be a table, got {model!r}")
        one = tips[0] if tips and not several and model.get("type") != "interface" else tips
        return self.bind_typed(_MODELS, model, at, given={"tip": one, "tips": one}, keep=True)

    def _either(self, hints: Iterable[Any]) -> Reader | None:
        """Materials of several classes are one kind of name."""
        solid = [hint for hint in hints if hint in _MADE_OF]
        rest = [hint for hint in hints if hint not in solid]
        return super()._either([Annotated[Any, _material(*solid)], *rest] if solid else rest)


_SECTIONS = fem.BeamSection, fem.RectangularSection, fem.CircularSection, fem.TubularSection
_SOLVER = Reader(
    "a table", (dict,), lambda binder, value, place: binder.bind_typed(_SOLVERS, value, place)
)

# Readers of values by the class of the argument.
SceneBinder.readers = {
    **{one: _material(one) for one in _MADE_OF},
    **dict.fromkeys(_SECTIONS, table(*_SECTIONS)),
    **dict.fromkeys((fem.Rayleigh, fem.ModalDamping), table(fem.Rayleigh, fem.ModalDamping)),
    **dict.fromkeys((integrate.Adaptive, integrate.Newmark), _SOLVER),
    **dict.fromkeys((Sensor, ContactPoint), _SENSOR),
    fem.Ply: table(fem.Ply),
    laws.ContactLaw: Reader("a table", (dict,), _read_law),
    Handle: _HANDLE,
}
