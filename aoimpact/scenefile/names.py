"""What a scene file may contain: the one place that lists its names."""

from __future__ import annotations

import inspect
from dataclasses import MISSING, fields
from typing import Any, get_type_hints

from .. import laws
from ..integrate import Adaptive, Newmark
from ..linalg import SOLVERS as LINEAR_SOLVERS
from ..mesh import KINDS
from .schema import (
    Anything,
    Choice,
    Either,
    Entries,
    Field,
    Flag,
    Integer,
    Kind,
    Listed,
    Number,
    Reference,
    Table,
    Tagged,
    Text,
    Tree,
    Variants,
    needed,
    optional,
)

__all__ = ["LAWS", "SCENE_FILE", "SOLVERS"]

# By the name that a file gives, the class that it stands for; a file has no functions.
LAWS = {name: law for name, law in laws.LAWS.items() if law is not laws.UserLaw}

SOLVERS = {solver.__name__: solver for solver in (Adaptive, Newmark)}

_VECTOR = Listed(Number(), 3)


_MATERIAL = Variants(
    {
        "E": Table(
            {
                "E": needed(Number("Pa")),
                "nu": needed(Number()),
                "rho": needed(Number("kg/m³")),
                "yield_strength": optional(Number("Pa")),
                "hardness": optional(Number("Pa")),
            }
        ),
        "orthotropic": Table(
            {
                "orthotropic": needed(
                    Table(
                        {
                            "E": needed(Listed(Number("Pa"), 3)),
                            "G": needed(Listed(Number("Pa"), 3)),
                            "nu": needed(_VECTOR),
                        }
                    )
                ),
                "rho": needed(Number("kg/m³")),
                "axes": optional(Listed(_VECTOR)),
                "turned": optional(Number("rad")),
            }
        ),
    }
)

_MESH = Variants(
    {
        "file": Table({"file": needed(Text()), "scale": optional(Number())}),
        "sphere": Table({"sphere": needed(Number("m, the radius")), "size": needed(Number("m"))}),
        "box": Table(
            {
                "box": needed(_VECTOR),
                "divisions": needed(Listed(Integer(), 3)),
                "kind": optional(Choice(KINDS)),
            }
        ),
    }
)

# Nodes: a set, numbers, or all on some planes.
_NODES = {
    "nodes": optional(Either((Text(), Listed(Integer())))),
    "x": optional(Number("m")),
    "y": optional(Number("m")),
    "z": optional(Number("m")),
}

_SUPPORT = Table({"hold": needed(Text())} | _NODES)

_ADDED = Table(
    {
        "mass": needed(Number("kg")),
        "centre": optional(_VECTOR),
        "inertia": optional(Either((_VECTOR, Listed(_VECTOR, 3)))),
    }
    | _NODES
)

_SPRING = Table({"along": needed(Text()), "stiffness": needed(Number("N/m"))} | _NODES)

# How a place is pressed on.
_PRESSED = {
    "direction": optional(_VECTOR),
    "radius": optional(Either((Number("m"), Choice(("auto",))))),
    "expected": optional(Number("m")),
}

_CONTACT = Variants(
    {
        "point": Table({"point": needed(_VECTOR)} | _PRESSED),
        "node": Table({"node": needed(Integer())} | _PRESSED),
        "dof": Table({"dof": needed(Integer())}),
    }
)

_MATRIX = Either((Text(), Listed(Text(), 2)))

_MATRICES = Table(
    {
        "K": needed(_MATRIX),
        "M": optional(_MATRIX),
        "dofs": optional(Text()),
        "nodes": optional(Text()),
        "length": optional(Number("m")),
        "mass": optional(Number("kg")),
        "mesh": optional(Text()),
        "material": optional(Reference("materials")),
    }
)

_LINEAR_SOLVER = optional(Choice(LINEAR_SOLVERS))

# What a model is fitted to.
_FITTED = {"contact_time": optional(Number("s")), "duration": optional(Number("s"))}

_MODEL = Tagged(
    "type",
    {
        "antioscillators": Table(
            {
                "n": optional(Integer()),
                "method": optional(Text()),
                "order": optional(Text()),
                "solver": _LINEAR_SOLVER,
            }
            | _FITTED
        ),
        "modal": Table({"n": needed(Integer()), "solver": _LINEAR_SOLVER}),
        "interface": Table({"n": needed(Integer()), "solver": _LINEAR_SOLVER} | _FITTED),
        "full": Table({}),
    },
)

_DAMPING = Table(
    {
        "alpha": optional(Number("1/s")),
        "beta": optional(Number("s")),
        "ratio": optional(Number()),
    }
)

# How a body of finite elements is touched, and what represents it.
_TOUCHED = {
    "contact": needed(Either((_CONTACT, Listed(_CONTACT)))),
    "model": optional(_MODEL),
}

_BODY = Variants(
    {
        "mass": Table({"mass": needed(Number("kg"))}),
        "ball": Table({"ball": needed(Number("m")), "material": needed(Reference("materials"))}),
        "m0": Table(
            {
                "m0": needed(Number("kg")),
                "k0": optional(Number("N/m")),
                "m": optional(Listed(Number("kg"))),
                "k": optional(Listed(Number("N/m"))),
                "damping": optional(_DAMPING),
            }
        ),
        "mesh": Table(
            {
                "mesh": needed(Either((Text(), _MESH))),
                "material": needed(
                    Either((Reference("materials"), Entries(Reference("materials"))))
                ),
                "part": optional(Either((Text(), Listed(Text())))),
                "order": optional(Integer()),
                "fixed": optional(Listed(_SUPPORT)),
                "masses": optional(Listed(_ADDED)),
                "springs": optional(Listed(_SPRING)),
                "damping": optional(_DAMPING),
            }
            | _TOUCHED
        ),
        "matrices": Table(
            {"matrices": needed(_MATRICES), "damping": optional(_DAMPING)} | _TOUCHED
        ),
    }
)

_RADIUS = Either((Number("m"), Listed(Number("m"), 2)))
_SURFACE = Table({"material": needed(Reference("materials")), "radius": needed(_RADIUS)})
_SURFACES = Table({"between": needed(Listed(_SURFACE, 2)), "angle": optional(Number("rad"))})


# By the annotation of a parameter.
_KIND_OF: dict[Any, Kind] = {
    **dict.fromkeys((float, float | None), Number()),
    bool: Flag(),
    str: Text(),
}


def _parameters(cls: Any) -> Table:
    """The parameters of a frozen object of numbers, words and flags, by its own fields."""
    types = get_type_hints(cls)
    names = {entry.name: _KIND_OF[types[entry.name]] for entry in fields(cls)}
    if issubclass(cls, laws.HertzianLaw):  # its k may be that of Hertz's theory
        names["k"] = Either((Number(), _SURFACES))
    left_out = {entry.name for entry in fields(cls) if entry.default is not MISSING}
    return Table({name: Field(kind, name not in left_out) for name, kind in names.items()})


def _law(cls: Any) -> Kind:
    """A law by its own parameters, or by its restitution or yield pressure."""
    if cls is laws.Tabulated:
        return _CURVE
    own = _parameters(cls)
    if hasattr(cls, "from_restitution"):
        names = inspect.signature(cls.from_restitution).parameters
        given = {
            name: own.fields.get(name, Field(Number(), entry.default is inspect.Parameter.empty))
            for name, entry in names.items()
        }
        follows = next(name for name in own.fields if name not in names)
        return Variants({follows: own, "restitution": Table(given)})
    if cls is laws.Thornton:
        yielding = {"k": needed(_SURFACES), "yield_pressure": needed(Number("Pa"))}
        return Variants({"yield_force": own, "yield_pressure": Table(yielding)})
    if cls is laws.ElasticPlastic:
        plain = Table({**own.fields, "k": needed(Number())})
        of_surfaces = {"k": needed(_SURFACES), "hardness": optional(Number("Pa"))}
        return Variants({"yield_force": plain}, Table(of_surfaces))
    return own


_CURVE = Table({"indentation": needed(Listed(Number("m"))), "force": needed(Listed(Number("N")))})

_LAW = Tagged("type", {name: _law(cls) for name, cls in LAWS.items()})

_SOLVER = Tagged("type", {name: _parameters(solver) for name, solver in SOLVERS.items()})

# How a run is made, and what it reports.
_RUN = {
    "duration": optional(Number("s")),
    "solver": optional(_SOLVER),
    "report": optional(Listed(Text())),
}


def _displacement(body: Kind, **more: Table) -> Kind:
    """A place whose displacement is the quantity of interest."""
    point = {"body": needed(body), "point": needed(_VECTOR), "direction": needed(_VECTOR)}
    return Variants({"point": Table(point), **more})


_IMPACT = Table(
    {
        "projectile": needed(Reference("bodies")),
        "target": needed(Reference("bodies")),
        "velocity": needed(Number("m/s")),
        "gap": optional(Number("m")),
        "law": optional(_LAW),
        "quantity": optional(Either((Text(), _displacement(Reference("bodies"))))),
        "rtol": optional(Number()),
        "tolerance": optional(Number()),  # the former name of rtol
        "linear_solver": _LINEAR_SOLVER,
    }
    | _RUN
)

_MEMBER = Table(
    {
        "body": needed(Reference("bodies")),
        "name": optional(Text()),
        "velocity": optional(Number("m/s")),
        "position": optional(Number("m")),
    }
)

_END = Either((Text(), Table({"body": needed(Text()), "port": optional(Integer())})))

_BETWEEN = Table(
    {
        "between": needed(Listed(_END, 2)),
        "law": optional(_LAW),
        "gap": optional(Number("m")),
        "name": optional(Text()),
    }
)

_LOAD = Variants(
    {
        "force": Table({"body": needed(_END), "force": needed(Number("N"))}),
        "times": Table(
            {
                "body": needed(_END),
                "times": needed(Listed(Number("s"))),
                "forces": needed(Listed(Number("N"))),
            }
        ),
    }
)

_PORT = Table({"body": needed(Text()), "port": needed(Integer())})

_SCENE = Table(
    {
        "quantity": optional(Either((Text(), _displacement(Text(), port=_PORT)))),
        "rtol": optional(Number()),
        "tolerance": optional(Number()),  # the former name of rtol
        "linear_solver": _LINEAR_SOLVER,
        "gravity": optional(Number("m/s²")),
        "preload": optional(Flag()),
        "bodies": needed(Listed(_MEMBER)),
        "contacts": optional(Listed(_BETWEEN)),
        "loads": optional(Listed(_LOAD)),
    }
    | _RUN
)

_RANGE = Table(
    {
        "from": needed(Number()),
        "to": needed(Number()),
        "count": needed(Integer()),
        "spacing": optional(Choice(("linear", "log"))),
    },
    called="a range such as { from = 0.0, to = 1.0, count = 5 }",
)

_SWEEP = Table(
    {
        "over": needed(Tree(Either((Listed(Anything()), _RANGE)), mark="from")),
        "keep": optional(Listed(Text())),
        "workers": optional(Integer()),
        "checkpoint": optional(Text()),
    }
)

_SHARED = {
    "title": optional(Text()),
    "materials": optional(Entries(_MATERIAL)),
    "bodies": needed(Entries(_BODY)),
    "sweep": optional(_SWEEP),
}

SCENE_FILE = Variants(
    {
        "impact": Table(_SHARED | {"impact": needed(_IMPACT)}),
        "scene": Table(_SHARED | {"scene": needed(_SCENE)}),
    }
)
