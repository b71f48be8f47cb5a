"""Builds the objects that a scene file describes: bodies, laws, and the impact or the scene."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..accuracy import Sensor
from ..base import InputError, nearest
from ..fem import (
    Beam,
    BeamSection,
    CircularSection,
    ContactPoint,
    FEModel,
    Laminate,
    Material,
    ModalDamping,
    OneMaterial,
    Orthotropic,
    Ply,
    Rayleigh,
    RectangularSection,
    RigidMass,
    Shell,
    TubularSection,
    contact_point,
    materials_of,
    thin_groups,
)
from ..impact import Scene, SceneCase
from ..io import paper_sphere_mesh, read_for, read_matrices, read_sections
from ..laws import ContactLaw, ElasticPlastic, Hertz, Thornton
from ..mesh import Mesh, box_mesh, sheet_mesh, sphere_mesh
from ..reduction import (
    AOModel,
    FullModel,
    antioscillators,
    ball,
    body_model,
    full,
    interface,
    modal,
    rigid,
    wall,
)
from ..results import SCENE_CHOICES, Handle
from .names import LAWS, SENSORS, SOLVERS

# The power of the indentation in Hertz's law.
_HERTZ_POWER = 1.5

# A node lies on a plane of a support if it is closer than this fraction of the body's size.
_ON_PLANE = 1e-6

# Bodies that a sweep over a file keeps: those that it needs again, not every mesh of a long sweep.
_MOST_KEPT = 8

_PAPER_SPHERE = "paper-sphere"


# Keywords of `simulate` and of `Scene.simulate` that a file gives as they are.
_OF_IMPACT = (
    "velocity",
    "friction",
    "spin",
    "duration",
    "gap",
    "quantity",
    "rtol",
    "linear_solver",
)
_OF_SCENE = ("preload", "rtol", "linear_solver")


@dataclass
class Kept:
    """Bodies that have been made, by their text in the file; the oldest is dropped first."""

    made: dict[str, Any] = field(default_factory=dict)

    def once(self, what: Any, make: Callable[[], Any]) -> Any:
        """Return what was made of the same text before, or make it."""
        key = json.dumps(what, sort_keys=True)
        if key not in self.made:
            if len(self.made) >= _MOST_KEPT:
                del self.made[next(iter(self.made))]
            self.made[key] = make()
        return self.made[key]


def member_name(member: Mapping[str, Any]) -> str:
    """Return the name of a body in its scene."""
    return str(member.get("name", member["body"]))


@dataclass(frozen=True)
class Builder:
    """Builds bodies, laws and cases of the tables of a file.

    Attributes
    ----------
    data : mapping
        The file, checked.
    folder : Path
        That its paths start from.
    kept : Kept
    located : callable
        Context for a place of the file, which adds the line to errors of bad input.
    """

    data: Mapping[str, Any]
    folder: Path
    kept: Kept
    located: Callable[..., AbstractContextManager[None]]

    def impact(self) -> dict[str, Any]:
        """Return the keywords of `simulate`."""
        table = self.data["impact"]
        bodies = {role: self._body(table[role]) for role in ("projectile", "target")}
        keywords = {
            **bodies,
            "law": self._law("impact"),
            **self._keywords("impact", _OF_IMPACT),
        }
        wanted = table.get("quantity")
        roles = {table[role]: body for role, body in bodies.items()}
        if isinstance(wanted, Mapping):
            with self.located("impact", "quantity"):
                keywords["quantity"] = _point(roles, wanted)
        self._check_probes("impact", roles)
        return keywords

    def scene(self) -> tuple[SceneCase, float | None]:
        """Return a scene with what its run is given, and its duration, if that is given."""
        table = self.data["scene"]
        with self.located("scene"):
            scene = Scene(gravity=table.get("gravity", 0.0))
        handles: dict[str, Handle] = {}
        bodies: dict[str, Any] = {}
        for i, member in enumerate(table["bodies"]):
            body, name = self._body(member["body"]), member_name(member)
            with self.located("scene", "bodies", i):
                if name in handles:
                    raise InputError(
                        f"name: two bodies of the scene are called {name!r}; give one another name"
                    )
                given = ("velocity", "spin", "position")
                motion = {key: member[key] for key in given if key in member}
                handles[name], bodies[name] = scene.add(body, **motion, name=name), body
        for i, contact in enumerate(table.get("contacts", ())):
            law = self._law("scene", "contacts", i)
            with self.located("scene", "contacts", i):
                first, second = (_handle(handles, end) for end in contact["between"])
                about = {key: contact[key] for key in ("friction", "gap", "name") if key in contact}
                scene.connect(first, second, law, **about)
        for i, load in enumerate(table.get("loads", ())):
            with self.located("scene", "loads", i):
                force = (load["times"], load["forces"]) if "times" in load else load["force"]
                scene.apply(_handle(handles, load["body"]), force=force)
        keywords = self._keywords("scene", _OF_SCENE)
        if "quantity" in table:
            with self.located("scene", "quantity"):
                keywords["quantity"] = _scene_quantity(handles, bodies, table["quantity"])
        self._check_probes("scene", bodies)
        return SceneCase(scene, keywords), table.get("duration")

    def _check_probes(self, kind: str, bodies: Mapping[str, Any]) -> None:
        """Refuse probes that make no sense before anything is run."""
        for name, wanted in self.data[kind].get("probes", {}).items():
            with self.located(kind, "probes", name):
                called = wanted["body"]
                if called not in bodies:
                    raise InputError(f"body: {called!r} takes no part{nearest(called, bodies)}")
                if not bodies[called].contact_points:
                    raise InputError(f"body: {called!r} has no finite elements, so no places")
                _sensor(bodies[called].contact_points[0].body, wanted)

    def _keywords(self, kind: str, names: Sequence[str]) -> dict[str, Any]:
        """The keywords of a run that its table gives."""
        table = self.data[kind]
        given = {name: table[name] for name in names if name in table}
        if "solver" in table:
            with self.located(kind, "solver"):
                given["solver"] = _made(SOLVERS, table["solver"])
        return given

    # --------------------------------------------------------------------------- bodies

    def _body(self, name: str) -> Any:
        table, place = self.data["bodies"][name], ("bodies", name)
        if "mass" in table:
            with self.located(*place):
                return rigid(**table, name=name)
        if "wall" in table:
            with self.located(*place):
                return wall(self._isotropic(table["wall"]), name=name)
        if "ball" in table:
            with self.located(*place):
                return ball(table["ball"], self._isotropic(table["material"]), name=name)
        if "m0" in table:
            with self.located(*place):
                return AOModel(**table | self._damping(name), name=name)
        return self.kept.once(
            ["model", table, self._given_material(name)], lambda: self._model(name)
        )

    def _given_material(self, name: str) -> Any:
        """The tables of a body's materials; None of matrices without one."""
        table = self.data["bodies"][name]
        material = table.get("matrices", table).get("material")
        if material is None:
            return None
        names = [material] if isinstance(material, str) else list(material.values())
        tables = [self.data["materials"][each] for each in names]
        within = {each for table in tables for each in _solids_in(table)}
        return [*tables, *(self.data["materials"][each] for each in sorted(within))]

    def _model(self, name: str) -> Any:
        table, place = self.data["bodies"][name], ("bodies", name)
        solid = {
            key: value
            for key, value in table.items()
            if key not in ("contact", "contacts", "model")
        }
        make = self._solid if "mesh" in table else self._of_matrices
        body = self.kept.once(["solid", solid, self._given_material(name)], lambda: make(name))
        model = dict(table.get("model", {"type": None}))
        kind = model.pop("type")
        touched, several = table["contact"], isinstance(table["contact"], list)
        with self.located(*place, "model"):
            if kind not in (None, "full") and several != (kind == "interface"):
                raise InputError(
                    "type: a list of contacts needs 'interface' or 'full', 'interface' a list"
                )
        tips = []
        for i, contact in enumerate(touched if several else [touched]):
            with self.located(*place, "contact", *([i] if several else [])):
                tips.append(body.contact(**contact))
        with self.located(*place, "model"):
            if kind is None:
                return body_model(name, tips)
            if kind == "full":
                return full(tips)
            return interface(tips, **model) if several else _REDUCTIONS[kind](tips[0], **model)

    def _damping(self, name: str) -> dict[str, Any]:
        """The keyword `damping`, where a body has any."""
        table = self.data["bodies"][name].get("damping")
        if table is None:
            return {}
        with self.located("bodies", name, "damping"):
            if ("ratio" in table) == ("alpha" in table or "beta" in table):
                raise InputError("give either ratio, of all modes, or alpha and beta of Rayleigh's")
            return {"damping": (ModalDamping if "ratio" in table else Rayleigh)(**table)}

    def _solid(self, name: str) -> FEModel:
        table, place = self.data["bodies"][name], ("bodies", name)
        with self.located(*place, "mesh"):
            parts = {key: table[key] for key in ("part", "order") if key in table}
            of = table.get("material")  # of a body, or by group of elements
            if of is None:
                made: Any = self._sections(table["mesh"])
            elif isinstance(of, str):
                made = self._material(of)
            else:
                made = {key: self._material(of[key]) for key in of}
            mesh = self._mesh(table["mesh"], thin_groups(made), **parts)
        with self.located(*place, "material"):
            material = materials_of(mesh, made)
        entries: dict[str, Any] = {
            key: self._entries(name, key, mesh)
            for key in ("fixed", "masses", "springs")
            if table.get(key)
        }
        # With several lists the message itself names the one that is wrong.
        with self.located(*place, *(entries if len(entries) == 1 else ())):
            return FEModel.from_mesh(mesh, material, **entries, name=name, **self._damping(name))

    def _entries(self, name: str, key: str, mesh: Mesh) -> list[Any]:
        """Supports, masses or springs of a body, as `from_mesh` takes them."""
        made = []
        for i, entry in enumerate(self.data["bodies"][name][key]):
            with self.located("bodies", name, key, i):
                made.append(_FASTENED[key](_nodes_of(entry, mesh), entry))
        return made

    def _of_matrices(self, name: str) -> FEModel:
        given = dict(self.data["bodies"][name]["matrices"])
        for key in ("K", "M"):
            if key in given:
                file, *matrix = [given[key]] if isinstance(given[key], str) else given[key]
                given[key] = (self.folder / file, *matrix) if matrix else self.folder / file
        files = [key for key in ("dofs", "nodes", "mesh") if key in given]
        given |= {key: self.folder / given[key] for key in files}
        if "material" in given:
            given["material"] = self._material(given["material"])
        with self.located("bodies", name, "matrices"):
            return read_matrices(**given, **self._damping(name))

    def _sections(self, mesh: str | Mapping[str, Any]) -> dict[str, OneMaterial]:
        """The sections of a body whose material is left out."""
        table = dict(mesh) if isinstance(mesh, Mapping) else {"file": mesh}
        if table.get("file", _PAPER_SPHERE) == _PAPER_SPHERE:
            raise InputError("material is missing; only a deck of Abaqus or Nastran has its own")
        return read_sections(self.folder / table.pop("file"), **table)

    def _mesh(self, mesh: str | Mapping[str, Any], thin: Sequence[str], **parts: Any) -> Mesh:
        source: Any
        if isinstance(mesh, str):
            source = paper_sphere_mesh() if mesh == _PAPER_SPHERE else self.folder / mesh
        elif "file" in mesh:
            source, parts = self.folder / mesh["file"], {"scale": mesh.get("scale", 1.0)} | parts
        elif "sphere" in mesh:
            source = sphere_mesh(mesh["sphere"], mesh["size"])
        elif "sheet" in mesh:
            source = sheet_mesh(mesh["sheet"], mesh["divisions"], kind=mesh.get("kind", "quad"))
        else:
            source = box_mesh(mesh["box"], mesh["divisions"], kind=mesh.get("kind", "hexahedron"))
        return read_for(source, thin, **parts)

    # ---------------------------------------------------------------- materials and laws

    def _material(self, name: str) -> OneMaterial:
        table = dict(self.data["materials"][name])
        with self.located("materials", name):
            if "shell" in table:
                return Shell(material=self._of_solid(name, table.pop("shell")), **table)
            if "laminate" in table:
                plies = [
                    Ply(**ply | {"material": self._of_solid(name, ply["material"])})
                    for ply in table.pop("laminate")
                ]
                return Laminate(plies, **table)
            if "beam" in table:
                section = _section(table.pop("section"))
                return Beam(section, self._isotropic(table.pop("beam")), **table)
            if "orthotropic" not in table:
                return Material(**table)
            axes = {"axes": table["axes"]} if "axes" in table else {}
            made = Orthotropic(**table["orthotropic"], rho=table["rho"], **axes)
            return made.turned(table["turned"], made.axes[2]) if "turned" in table else made

    def _of_solid(self, within: str, name: str) -> Material | Orthotropic:
        """The material of which a shell or a ply is made."""
        if "E" not in (table := self.data["materials"][name]) and "orthotropic" not in table:
            raise InputError(
                f"{within!r} is made of {name!r}, which is no material but a shell or beam"
            )
        material = self._material(name)
        assert isinstance(material, (Material, Orthotropic))
        return material

    def _isotropic(self, name: str) -> Material:
        """A material that a ball or a law's surface needs."""
        if "E" not in self.data["materials"][name]:
            raise InputError(
                f"material: {name!r} is not isotropic; balls, beams and surfaces need such a one"
            )
        material = self._material(name)
        assert isinstance(material, Material)
        return material

    def _law(self, *place: str | int) -> ContactLaw | None:
        """The law of an impact or a contact; None where it is left out."""
        table: Any = self.data
        for part in place:
            table = table[part]
        if "law" not in table:
            return None
        table = dict(table["law"])
        with self.located(*place, "law"):
            if isinstance(table.get("k"), Mapping):
                surfaces: list[Any] = []
                for surface in table["k"]["between"]:
                    surfaces += [self._isotropic(surface["material"]), surface["radius"]]
                if "yield_pressure" in table or table["type"] == "ElasticPlastic":
                    return _yielding(table, surfaces)
                if table.get("n", _HERTZ_POWER) != _HERTZ_POWER:
                    raise InputError("k of two surfaces belongs to n = 1.5; give a number for k")
                if "relative_radius" in table:
                    raise InputError("relative_radius: it follows from the two surfaces of k")
                hertz = Hertz.between(*surfaces, angle=table["k"].get("angle", 0.0))
                table |= {"k": hertz.k, "relative_radius": hertz.relative_radius}
                if table["type"] == "Hertz":
                    table["eccentricity"] = hertz.eccentricity
            law: ContactLaw = _made(LAWS, table)
            return law


def _yielding(table: Mapping[str, Any], surfaces: list[Any]) -> ContactLaw:
    """The law of two surfaces that yield."""
    if "angle" in table["k"]:
        raise InputError("angle: surfaces that yield are spheres, flats or cups")
    if table["type"] == "ElasticPlastic":
        return ElasticPlastic.between(*surfaces, hardness=table.get("hardness"))
    return Thornton.between(*surfaces, yield_pressure=table["yield_pressure"])


_REDUCTIONS: dict[str, Callable[..., Any]] = {"antioscillators": antioscillators, "modal": modal}


def _made(classes: Mapping[str, Any], table: Mapping[str, Any]) -> Any:
    """An object of the class that the table names, of the table's other values."""
    cls = classes[table["type"]]
    given = {key: value for key, value in table.items() if key != "type"}
    by_restitution = "restitution" in given and hasattr(cls, "from_restitution")
    return (cls.from_restitution if by_restitution else cls)(**given)


def _mounted(nodes: Any, entry: Mapping[str, Any]) -> Any:
    """An added mass: shared by its nodes, or, with a centre or inertia, a rigid one."""
    more = {key: entry[key] for key in ("centre", "inertia") if key in entry}
    return RigidMass(nodes, entry["mass"], **more) if more else (nodes, entry["mass"])


# By the list they are in: what the keyword of `FEModel.from_mesh` takes.
_FASTENED: dict[str, Callable[[Any, Mapping[str, Any]], Any]] = {
    "fixed": lambda nodes, entry: (
        nodes,
        *(entry[key] for key in ("hold", "hold_rotations") if key in entry),
    ),
    "masses": _mounted,
    "springs": lambda nodes, entry: (nodes, entry["along"], entry["stiffness"]),
}


def _solids_in(table: Mapping[str, Any]) -> list[str]:
    """The names of the materials of a shell, laminate or beam."""
    plies = [ply["material"] for ply in table.get("laminate", ())]
    return plies + [table[key] for key in ("shell", "beam") if key in table]


def _section(table: Mapping[str, Any]) -> Any:
    """A beam's cross-section."""
    if "area" in table:
        return BeamSection(**table)
    if "width" in table:
        return RectangularSection(**table)
    return (TubularSection if "thickness" in table else CircularSection)(**table)


def _nodes_of(entry: Mapping[str, Any], mesh: Mesh) -> Any:
    """Nodes of an entry: as written, or those on all of the planes that it names."""
    planes = {axis: entry[axis] for axis in "xyz" if axis in entry}
    if ("nodes" in entry) == bool(planes):
        raise InputError("give either nodes, or planes x, y, z on all of which they lie")
    if not planes:
        return entry["nodes"]
    on = np.ones(mesh.n_nodes, dtype=bool)
    for axis, value in planes.items():
        on &= np.abs(mesh.nodes[:, "xyz".index(axis)] - value) <= _ON_PLANE * mesh.size
    if not on.any():
        where = ", ".join(f"{axis} = {value:g} m" for axis, value in planes.items())
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        box = ", ".join(f"{c} {a:g} to {b:g}" for c, a, b in zip("xyz", low, high, strict=True))
        raise InputError(f"no node lies on {where}; the mesh spans {box} m")
    return on


def _point(bodies: Mapping[str, Any], wanted: Mapping[str, Any]) -> ContactPoint | Sensor:
    """The point whose displacement is the quantity of interest, or the sensor that is."""
    name = wanted["body"]
    if name not in bodies:
        raise InputError(f"body: {name!r} takes no part{nearest(name, bodies)}")
    body = bodies[name]
    if not isinstance(body, FullModel):
        raise InputError(
            f"body: {name!r} has a model already; leave the model out to have one chosen"
        )
    return _sensor(body.body, wanted)


def _sensor(body: Any, wanted: Mapping[str, Any]) -> ContactPoint | Sensor:
    """The sensor of a table; without a type a point for its displacement."""
    if "type" in wanted:
        given = {key: value for key, value in wanted.items() if key not in ("type", "body")}
        sensor: Sensor = SENSORS[wanted["type"]](body=body, **given)
        return sensor
    place, along = wanted["point"], wanted["direction"]
    return contact_point(body, point=place, direction=along, radius=0.0)


def _scene_quantity(
    handles: Mapping[str, Handle], bodies: Mapping[str, Any], wanted: str | Mapping[str, Any]
) -> str | Handle | ContactPoint | Sensor:
    """The quantity of interest of a scene: a name, a sensor, or a displacement."""
    if isinstance(wanted, Mapping):
        return _handle(handles, wanted) if "port" in wanted else _point(bodies, wanted)
    if wanted in handles and wanted not in SCENE_CHOICES:
        return handles[wanted]
    if wanted not in SCENE_CHOICES:
        known = (*SCENE_CHOICES, *handles)
        raise InputError(
            f"must be one of {', '.join(known)}, got {wanted!r}{nearest(wanted, known)}"
        )
    return wanted


def _handle(handles: Mapping[str, Handle], end: str | Mapping[str, Any]) -> Handle:
    """The body that an end of a contact names, and the place on it."""
    name, port = (end, 0) if isinstance(end, str) else (end["body"], end.get("port", 0))
    if name not in handles:
        raise InputError(
            f"the scene has no body {name!r}{nearest(name, handles)}; it has {', '.join(handles)}"
        )
    return handles[name].port(port)
