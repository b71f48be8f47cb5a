"""Twelve different impacts of bodies small enough for models with all oscillators."""

from __future__ import annotations

import math
from typing import Any

import aoimpact as ao
from aoimpact import box_mesh


def as_meshed(run: Any) -> Any:
    """The run with the given meshes, if the result was computed with finer elements."""
    return run.beside or run


STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2400)
RUBBER = ao.Material(E=10e6, nu=0.45, rho=1100)

BEAM, ROD, PLATE = (0.3, 0.02, 0.02), (0.02, 0.02, 0.3), (0.2, 0.2, 0.005)
ALL_EDGES = [(name, "xyz") for name in ("xmin", "xmax", "ymin", "ymax")]


def box(material: ao.Material, size: Any, cells: Any, place: Any, fixed: Any = None) -> Any:
    """A box struck from above, or striking downward, at a point relative to its size."""
    body = ao.FEModel.from_mesh(box_mesh(size, cells), material, fixed=fixed)
    point = [share * length for share, length in zip(place, size, strict=True)]
    return body.contact(point=point, direction=(0, 0, -1), radius=0)


def cube(material: ao.Material, edge: float) -> Any:
    """A free cube that strikes with the centre of its lower face."""
    return box(material, (edge,) * 3, (4, 4, 4), (0.5, 0.5, 0))


def block(material: ao.Material, edge: float, fixed: Any = None) -> Any:
    """A cube struck at the centre of its upper face."""
    return box(material, (edge,) * 3, (4, 4, 4), (0.5, 0.5, 1), fixed)


def beam(fixed: Any = None, along: float = 0.5) -> Any:
    return box(ALUMINIUM, BEAM, (20, 2, 2), (along, 0.5, 1), fixed)


def law(one: ao.Material, radius: float, other: ao.Material) -> ao.ContactLaw:
    """A power law with Hertz's stiffness, from which no compliance of the mesh is removed.

    So the reference solution is that of the given finite elements, which is known.
    """
    return ao.PowerLaw(ao.Hertz.between(one, radius, other, math.inf).k, 1.5)


ENDS = [("xmin", "xyz"), ("xmax", "xyz")]
FLOOR = [("zmin", "xyz")]

# Name: projectile, target, law, velocity in m/s, duration in s.
IMPACTS: dict[str, Any] = {
    "compact on held compact": lambda: (
        cube(STEEL, 0.02),
        block(ALUMINIUM, 0.04, FLOOR),
        law(STEEL, 0.01, ALUMINIUM),
        1.0,
        2e-4,
    ),
    "tip of a cantilever, for long": lambda: (
        ao.rigid(mass=0.03),
        beam(ENDS[:1], along=1.0),
        law(STEEL, 0.01, ALUMINIUM),
        1.0,
        2e-3,
    ),
    "free slender": lambda: (
        cube(STEEL, 0.02),
        beam(),
        law(STEEL, 0.01, ALUMINIUM),
        1.0,
        4e-4,
    ),
    "rod on rod": lambda: (
        box(STEEL, ROD, (2, 2, 20), (0.5, 0.5, 0)),
        box(STEEL, ROD, (2, 2, 20), (0.5, 0.5, 1)),
        ao.PowerLaw(ao.Hertz.between(STEEL, 0.05, STEEL, 0.05).k, 1.5),
        1.0,
        4e-4,
    ),
    "held plate": lambda: (
        ao.rigid(mass=0.02),
        box(ALUMINIUM, PLATE, (12, 12, 1), (0.5, 0.5, 1), ALL_EDGES),
        law(STEEL, 0.01, ALUMINIUM),
        1.0,
        5e-4,
    ),
    "soft on stiff": lambda: (
        cube(RUBBER, 0.03),
        block(STEEL, 0.05),
        law(RUBBER, 0.015, STEEL),
        2.0,
        2e-2,
    ),
    "stiff on soft": lambda: (
        cube(STEEL, 0.02),
        block(RUBBER, 0.06, FLOOR),
        law(STEEL, 0.01, RUBBER),
        2.0,
        2e-2,
    ),
    "light on heavy": lambda: (
        cube(ALUMINIUM, 0.005),
        block(STEEL, 0.1),
        law(ALUMINIUM, 0.0025, STEEL),
        1.0,
        1e-4,
    ),
    "heavy on light": lambda: (
        cube(STEEL, 0.06),
        block(ALUMINIUM, 0.015),
        law(STEEL, 0.03, ALUMINIUM),
        1.0,
        2e-4,
    ),
    "slow": lambda: (
        cube(STEEL, 0.02),
        beam(ENDS),
        law(STEEL, 0.01, ALUMINIUM),
        0.01,
        8e-4,
    ),
    "fast": lambda: (
        cube(STEEL, 0.02),
        beam(ENDS),
        law(STEEL, 0.01, ALUMINIUM),
        20.0,
        3e-4,
    ),
    "free plate off its centre": lambda: (
        cube(STEEL, 0.01),
        box(ALUMINIUM, PLATE, (12, 12, 1), (0.25, 1 / 3, 1)),
        law(STEEL, 0.005, ALUMINIUM),
        3.0,
        3e-4,
    ),
}
