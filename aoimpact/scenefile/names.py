"""Contents of a scene file: the one place that lists its names, as schema.py writes kinds."""

from __future__ import annotations

import inspect
from dataclasses import MISSING, fields
from typing import Any, get_type_hints

from .. import laws
from ..accuracy import AccelerationAt, ReactionAt, StrainAt, StressAt
from ..integrate import Adaptive, Newmark
from ..linalg import SOLVERS as LINEAR_SOLVERS
from ..mesh import KINDS
from .schema import (
    ANYTHING,
    FLAG,
    INTEGER,
    NUMBER,
    TEXT,
    Choice,
    Entries,
    Reference,
    Table,
    Tagged,
    Tree,
    Variants,
)

# By the name that a file gives, the class that it stands for; a file has no functions.
LAWS = {name: law for name, law in laws.LAWS.items() if law is not laws.UserLaw}

SOLVERS = {solver.__name__: solver for solver in (Adaptive, Newmark)}

_VECTOR = [NUMBER, 3]
_MATERIAL, _BODY = Reference("materials"), Reference("bodies")

# ------------------------------------------------------------------- materials and bodies

_SECTION = Variants(
    {
        "width": {"width": "m", "height": "m"},
        "radius": {"radius": "m", "thickness?": "m"},
        "area": {
            **{"area": "m²", "Iy": "m⁴", "Iz": "m⁴", "J": "m⁴"},
            **{"shear_factors?": [NUMBER, 2], "points?": [["m", 2]]},
        },
    }
)

_MATERIALS = Variants(
    {
        "E": {
            "E": "Pa",
            "nu": NUMBER,
            "rho": "kg/m³",
            "yield_strength?": "Pa",
            "hardness?": "Pa",
        },
        "orthotropic": {
            "orthotropic": {"E": ["Pa", 3], "G": ["Pa", 3], "nu": _VECTOR},
            "rho": "kg/m³",
            "axes?": [_VECTOR],
            "turned?": "rad",
        },
        "shell": {"shell": _MATERIAL, "thickness": "m", "offset?": "m"},
        "laminate": {
            "laminate": [{"thickness": "m", "material": _MATERIAL, "angle_deg?": NUMBER}],
            "fibre_axis?": _VECTOR,
            "offset?": "m",
        },
        "beam": {
            "beam": _MATERIAL,
            "section": _SECTION,
            "orientation?": _VECTOR,
            "offset?": ["m", 2],
        },
    }
)

_MESH = Variants(
    {
        "file": {"file": TEXT, "scale?": NUMBER, "force?": "N", "time?": "s"},
        "sphere": {"sphere": "m, the radius", "size": "m"},
        "box": {"box": _VECTOR, "divisions": [INTEGER, 3], "kind?": Choice(KINDS)},
        "sheet": {
            "sheet": [NUMBER, 2],
            "divisions": [INTEGER, 2],
            "kind?": Choice(("quad", "triangle")),
        },
    }
)

# Nodes: a set, numbers, or all on some planes.
_NODES = {"nodes?": (TEXT, [INTEGER]), "x?": "m", "y?": "m", "z?": "m"}

# Options of a contact point.
_PRESSED = {"direction?": _VECTOR, "radius?": ("m", Choice(("auto",))), "expected?": "m"}

_CONTACT = Variants(
    {
        "point": {"point": _VECTOR} | _PRESSED,
        "node": {"node": INTEGER} | _PRESSED,
        "dof": {"dof": INTEGER},
    }
)

_MATRIX = (TEXT, [TEXT, 2])

_MATRICES = {
    "K": _MATRIX,
    "M?": _MATRIX,
    "dofs?": TEXT,
    "nodes?": TEXT,
    "length?": "m",
    "mass?": "kg",
    "mesh?": TEXT,
    "material?": _MATERIAL,
}

_LINEAR_SOLVER = Choice(LINEAR_SOLVERS)

# Times that a model is fitted to.
_FITTED = {"contact_time?": "s", "duration?": "s"}

_MODEL = Tagged(
    "type",
    {
        "antioscillators": {"n?": INTEGER, "method?": TEXT, "order?": TEXT}
        | {"solver?": _LINEAR_SOLVER}
        | _FITTED,
        "modal": {"n": INTEGER, "solver?": _LINEAR_SOLVER},
        "interface": {"n": INTEGER, "solver?": _LINEAR_SOLVER} | _FITTED,
        "full": {},
    },
)

_DAMPING = {"alpha?": "1/s", "beta?": "s", "ratio?": NUMBER}

# Contact points, model and damping of a body of finite elements.
_TOUCHED = {"contact": (_CONTACT, [_CONTACT]), "model?": _MODEL, "damping?": _DAMPING}

_BODIES = Variants(
    {
        "mass": {"mass": "kg", "inertia?": (NUMBER, _VECTOR, [_VECTOR, 3]), "arm?": _VECTOR},
        "wall": {"wall": _MATERIAL},
        "ball": {"ball": "m", "material": _MATERIAL},
        "m0": {"m0": "kg", "k0?": "N/m", "m?": ["kg"], "k?": ["N/m"], "damping?": _DAMPING},
        "mesh": {
            "mesh": (TEXT, _MESH),
            "material?": (_MATERIAL, Entries(_MATERIAL)),
            "part?": (TEXT, [TEXT]),
            "order?": INTEGER,
            "fixed?": [{"hold": TEXT, "hold_rotations?": TEXT} | _NODES],
            "masses?": [
                {"mass": "kg", "centre?": _VECTOR, "inertia?": (_VECTOR, [_VECTOR, 3])} | _NODES
            ],
            "springs?": [{"along": TEXT, "stiffness": "N/m"} | _NODES],
        }
        | _TOUCHED,
        "matrices": {"matrices": _MATRICES} | _TOUCHED,
    }
)

# ------------------------------------------------------------------------ laws and solvers

_SURFACE = {"material": _MATERIAL, "radius": ("m", ["m", 2])}
_SURFACES = Table({"between": [_SURFACE, 2], "angle?": "rad"})

# By the annotation of a parameter.
_KIND_OF: dict[Any, Any] = {
    float: NUMBER,
    float | None: NUMBER,
    bool: FLAG,
    str: TEXT,
    str | None: TEXT,
}


def _parameters(cls: Any) -> dict[str, Any]:
    """The parameters of a frozen object of numbers, words and flags, by its own fields."""
    types = get_type_hints(cls)
    written = {}
    for entry in fields(cls):
        kind = _KIND_OF[types[entry.name]]
        if entry.name == "k" and issubclass(cls, laws.HertzianLaw):  # may be that of Hertz's theory
            kind = (NUMBER, _SURFACES)
        written[entry.name + ("" if entry.default is MISSING else "?")] = kind
    return written


def _law(cls: Any) -> Any:
    """A law by its own parameters, or by its restitution or yield pressure."""
    if cls is laws.Tabulated:
        return {"indentation": ["m"], "force": ["N"]}
    own = _parameters(cls)
    if hasattr(cls, "from_restitution"):
        given = inspect.signature(cls.from_restitution).parameters
        types = get_type_hints(cls.from_restitution)
        other = {}
        for name, entry in given.items():
            mark = "" if entry.default is inspect.Parameter.empty else "?"
            other[name + mark] = own.get(name, own.get(name + "?", _KIND_OF[types[name]]))
        follows = next(name for name in own if name.rstrip("?") not in given)
        return Variants({follows.rstrip("?"): own, "restitution": other})
    if cls is laws.Thornton:
        yielding = {"k": _SURFACES, "yield_pressure": "Pa"}
        return Variants({"yield_force": own, "yield_pressure": yielding})
    if cls is laws.ElasticPlastic:
        plain = own | {"k": NUMBER}
        return Variants({"yield_force": plain}, {"k": _SURFACES, "hardness?": "Pa"})
    return own


_LAW = Tagged("type", {name: _law(cls) for name, cls in LAWS.items()})
_SOLVER = Tagged("type", {name: _parameters(solver) for name, solver in SOLVERS.items()})

# ---------------------------------------------------------------- impacts, scenes and sweeps

# Options of a run.
_RUN = {
    "duration?": "s",
    "solver?": _SOLVER,
    "report?": [TEXT],
    "rtol?": NUMBER,
    "linear_solver?": _LINEAR_SOLVER,
}


# Sensors that may be the quantity of interest.
SENSORS = {one.__name__: one for one in (StressAt, StrainAt, AccelerationAt, ReactionAt)}


def _sensor(body: Any, **more: Any) -> Tagged:
    """Return the table of a sensor on a body; without a type the displacement of a place."""
    of_point = {"body": body, "point": _VECTOR}
    along = {"direction": _VECTOR}
    where = {"layer?": (TEXT, [ANYTHING, 2]), "part?": TEXT}
    displacement = Variants({"point": of_point | along, **more})
    tables = {
        "StressAt": of_point | where | {"component?": TEXT},
        "StrainAt": of_point | where | {"component?": (TEXT, _VECTOR), "length?": "m"},
        "AccelerationAt": of_point | along | {"cfc?": "Hz", "corner?": "Hz"},
        "ReactionAt": {"body": body, "nodes": (TEXT, [INTEGER])} | along,
    }
    return Tagged("type", tables, displacement)


_IMPACT = {
    "projectile": _BODY,
    "target": _BODY,
    "velocity": ("m/s", ["m/s", 3]),
    "friction?": NUMBER,
    "spin?": ["rad/s", 3],
    "gap?": "m",
    "law?": _LAW,
    "quantity?": (TEXT, _sensor(_BODY)),
    "probes?": Entries(_sensor(_BODY)),
} | _RUN

_END = (TEXT, {"body": TEXT, "port?": INTEGER})

_SCENE = {
    "quantity?": (TEXT, _sensor(TEXT, port={"body": TEXT, "port": INTEGER})),
    "probes?": Entries(_sensor(TEXT)),
    "gravity?": ("m/s²", ["m/s²", 3]),
    "preload?": FLAG,
    "bodies": [
        {
            "body": _BODY,
            "name?": TEXT,
            "velocity?": ("m/s", ["m/s", 3]),
            "spin?": ["rad/s", 3],
            "position?": "m",
        }
    ],
    "contacts?": [
        {"between": [_END, 2], "law?": _LAW, "friction?": NUMBER, "gap?": "m", "name?": TEXT}
    ],
    "loads?": [
        Variants(
            {
                "force": {"body": _END, "force": "N"},
                "times": {"body": _END, "times": ["s"], "forces": ["N"]},
            }
        )
    ],
} | _RUN

_RANGE = Table(
    {"from": NUMBER, "to": NUMBER, "count": INTEGER, "spacing?": Choice(("linear", "log"))},
    called="a range such as { from = 0.0, to = 1.0, count = 5 }",
)

_SHARED = {
    "title?": TEXT,
    "materials?": Entries(_MATERIALS),
    "bodies": Entries(_BODIES),
    "sweep?": {
        "over": Tree(([ANYTHING], _RANGE), mark="from"),
        "keep?": [TEXT],
        "workers?": INTEGER,
        "checkpoint?": TEXT,
    },
}

SCENE_FILE = Variants(
    {"impact": _SHARED | {"impact": _IMPACT}, "scene": _SHARED | {"scene": _SCENE}}
)
