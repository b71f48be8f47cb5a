"""Arguments of odd types and values: each is taken, or refused by name."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

ODD: dict[str, Any] = {
    "none": None,
    "text": "1",
    "bytes": b"1",
    "true": True,
    "numpy true": np.True_,
    "complex": 1.0 + 1.0j,
    "nan": math.nan,
    "inf": math.inf,
    "-inf": -math.inf,
    "zero": 0,
    "minus zero": -0.0,
    "minus one": -1,
    "huge": 10**400,
    "long": 2**63,
    "subnormal": 5e-324,
    "large": 1e308,
    "half": 0.5,
    "fraction": Fraction(1, 3),
    "empty": [],
    "tuple": (),
    "table": {},
    "set": set(),
    "object": object(),
    "function": len,
    "class": int,
    "module": math,
    "ragged": [[1.0], [1.0, 2.0]],
    "words": ["a", "b"],
    "nones": [None, None],
    "bools": [True, False],
    "range": range(3),
    "generator": (x for x in ()),
    "0-d": np.array(1.0),
    "3-d": np.zeros((2, 2, 2)),
    "no rows": np.zeros((0, 3)),
    "nans": np.full(3, np.nan),
    "objects": np.array([object(), object()]),
    "strings": np.array(["a", "b"]),
    "dates": np.array(["2026-01-01"], dtype="M8[D]"),
    "structured": np.zeros(2, dtype=[("x", float)]),
    "complexes": np.ones(3, complex),
    "big-endian": np.ones(3, ">f8"),
    "masked": np.ma.masked_array([1.0, 2.0, 3.0], [True, False, False]),
    "matrix": np.asmatrix(np.eye(3)),
    "long doubles": np.ones(3, np.longdouble) * np.longdouble("1e4000"),
    "recursive": (lambda one: (one.append(one), one)[1])([]),
    "array of one": np.ones(1),
    "path": Path("no such file"),
}

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
HERTZ = ao.Hertz(1e9)
BALL = ao.rigid(0.03)
STAR = ao.AOModel(m0=0.1, k0=1e4, m=[0.2], k=[1e6])
BOX = ao.box_mesh((0.1, 0.02, 0.02), (2, 1, 1))
BAR = ao.FEModel.from_mesh(BOX, STEEL)
TIP = BAR.contact(point=(0.1, 0.0, 0.0), direction=(-1.0, 0.0, 0.0))
STRIKE: dict[str, Any] = {
    "projectile": BALL,
    "target": STAR,
    "law": HERTZ,
    "velocity": 1.0,
    "duration": 1e-3,
}
HIT = ao.simulate(**STRIKE)
FIELDS = ao.simulate(**STRIKE | {"target": ao.antioscillators(TIP, 2)})


def _scene() -> tuple[ao.Scene, Any, Any]:
    scene = ao.Scene()
    a, b = scene.add(BALL, velocity=1.0), scene.add(STAR)
    scene.connect(a, b, HERTZ)
    return scene, a, b


def _added(**given: Any) -> Any:
    return ao.Scene().add(**{"body": BALL} | given)


# What each call makes for itself.
OWN = object()


def _connected(**given: Any) -> Any:
    scene = ao.Scene()
    own = {"a": scene.add(BALL, velocity=1.0), "b": scene.add(STAR)}
    return scene.connect(**{k: own[k] if v is OWN else v for k, v in given.items()})


def _applied(**given: Any) -> Any:
    scene, a, _ = _scene()
    return scene.apply(**{k: a if v is OWN else v for k, v in given.items()})


def _run(**given: Any) -> Any:
    return _scene()[0].simulate(**{"duration": 1e-3} | given)


# What is called, with what, and which of its arguments are made odd.
CALLS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "AOModel": (ao.AOModel, {"m0": 0.1, "k0": 1.0, "m": [1.0], "k": [1.0], "damping": None}),
    "rigid": (ao.rigid, {"mass": 1.0}),
    "Adaptive": (ao.Adaptive, {"rtol": 1e-6}),
    "Newmark": (
        ao.Newmark,
        {"dt": 1e-6, "beta": 0.25, "gamma": 0.5, "rtol": 1e-3, "estimate": True},
    ),
    "Material": (ao.Material, {"E": 1e9, "nu": 0.3, "rho": 1e3}),
    "Rayleigh": (ao.Rayleigh, {"alpha": 1.0, "beta": 1e-6}),
    "ModalDamping": (ao.ModalDamping, {"ratio": 0.1}),
    "Hertz": (ao.Hertz, {"k": 1e9}),
    "Hertz.between": (
        ao.Hertz.between,
        {
            "material_1": STEEL,
            "radius_1": 0.01,
            "material_2": STEEL,
            "radius_2": 0.01,
            "angle": 0.0,
        },
    ),
    "Thornton.between": (
        ao.Thornton.between,
        {
            "material_1": STEEL,
            "radius_1": 0.01,
            "material_2": STEEL,
            "radius_2": 0.01,
            "yield_pressure": 1e9,
        },
    ),
    "PowerLaw": (ao.PowerLaw, {"k": 1e9, "n": 1.5}),
    "Linear": (ao.Linear, {"k": 1e9}),
    "HuntCrossley": (ao.HuntCrossley, {"k": 1e9, "damping": 0.1, "n": 1.5}),
    "HuntCrossley.from_restitution": (
        ao.HuntCrossley.from_restitution,
        {"k": 1e9, "restitution": 0.5, "velocity": 1.0, "n": 1.5},
    ),
    "LankaraniNikravesh": (
        ao.LankaraniNikravesh,
        {"k": 1e9, "restitution": 0.5, "velocity": 1.0, "n": 1.5},
    ),
    "Flores": (ao.Flores, {"k": 1e9, "restitution": 0.5, "velocity": 1.0, "n": 1.5}),
    "Tsuji": (ao.Tsuji, {"k": 1e9, "alpha": 0.1, "mass": 1.0}),
    "KuwabaraKono": (ao.KuwabaraKono, {"k": 1e9, "A": 1e-6}),
    "KelvinVoigt": (ao.KelvinVoigt, {"k": 1e6, "c": 1.0, "end": "force"}),
    "Thornton": (ao.Thornton, {"k": 1e9, "yield_force": 10.0}),
    "Tabulated": (ao.Tabulated, {"indentation": [0.0, 1e-3], "force": [0.0, 1.0]}),
    "UserLaw": (
        ao.UserLaw,
        {
            "function": lambda d, r: d,
            "stiffness": None,
            "damping": None,
            "energy": None,
            "depends_on_rate": True,
            "pulls": False,
        },
    ),
    "force": (HERTZ.force, {"indentation": 1e-6, "rate": 0.0}),
    "potential": (HERTZ.potential, {"indentation": 1e-6}),
    "stroke": (HERTZ.stroke, {"energy": 1.0}),
    "within_patch": (
        HERTZ.within_patch,
        {"compliance": 1e-12, "radius": 1e-3, "relative_radius": 1e-2},
    ),
    "restitution": (
        ao.restitution,
        {"law": ao.HuntCrossley(1e9, 0.1), "mass": 1.0, "velocity": 1.0},
    ),
    "box_mesh": (
        ao.box_mesh,
        {"lengths": (1.0, 1.0, 1.0), "divisions": (1, 1, 1), "kind": "tetra"},
    ),
    "sphere_mesh": (ao.sphere_mesh, {"radius": 1.0, "size": 1.0}),
    "Mesh": (
        ao.Mesh,
        {"nodes": BOX.nodes, "cells": BOX.cells, "kind": BOX.kind, "node_sets": BOX.node_sets},
    ),
    "read_mesh": (ao.read_mesh, {"source": BOX, "scale": 1.0}),
    "read_scene": (ao.read_scene, {"path": "no.toml"}),
    "FEModel": (
        ao.FEModel,
        {"K": BAR.K, "M": BAR.M, "nodes": BAR.nodes, "free": BAR.free, "damping": None},
    ),
    "FEModel.from_mesh": (
        ao.FEModel.from_mesh,
        {"mesh": BOX, "material": STEEL, "fixed": None, "damping": None},
    ),
    "contact": (
        BAR.contact,
        {"point": (0.1, 0, 0), "direction": (-1, 0, 0), "radius": 0.0, "expected": None},
    ),
    "contact of a dof": (BAR.contact, {"dof": 0}),
    "translation": (BAR.translation, {"direction": (1, 0, 0)}),
    "com_functional": (BAR.com_functional, {"direction": (1, 0, 0)}),
    "inverse": (BAR.inverse, {"s2": 1e8, "solver": "auto", "solutions": 1}),
    "frequencies": (BAR.frequencies, {"n": 3}),
    "antioscillators": (
        ao.antioscillators,
        {
            "tip": TIP,
            "n": 2,
            "method": "krylov",
            "order": None,
            "contact_time": 1e-4,
            "duration": None,
            "solver": "auto",
        },
    ),
    "modal": (ao.modal, {"tip": TIP, "n": 3, "solver": "auto"}),
    "interface": (
        ao.interface,
        {"tips": [TIP], "n": 8, "contact_time": None, "duration": None, "solver": "auto"},
    ),
    "KrylovSpace": (
        ao.KrylovSpace,
        {"tip": TIP, "contact_time": 1e-4, "duration": None, "solver": "auto"},
    ),
    "check_patch": (ao.check_patch, {"tip": TIP}),
    "receptance": (STAR.receptance, {"omega": 1.0}),
    "truncated": (STAR.truncated, {"n": 1}),
    "expand": (ao.antioscillators(TIP, 2).expand, {"coordinates": np.zeros(3)}),
    "simulate": (
        ao.simulate,
        STRIKE
        | {
            "solver": None,
            "gap": 0.0,
            "energies": True,
            "quantity": None,
            "rtol": None,
            "linear_solver": None,
        },
    ),
    "compare": (
        ao.compare,
        STRIKE
        | {"gap": 0.0, "oscillators": (0,), "modes": (2,), "full": False, "linear_solver": "auto"},
    ),
    "Scene": (ao.Scene, {"gravity": 0.0}),
    "Scene.add": (_added, {"body": BALL, "velocity": 1.0, "position": 0.0, "name": "a"}),
    "Scene.connect": (_connected, {"a": OWN, "b": OWN, "law": HERTZ, "gap": 0.0}),
    "Scene.apply": (_applied, {"body": OWN, "force": 1.0}),
    "Scene.simulate": (
        _run,
        {
            "duration": 1e-3,
            "solver": None,
            "energies": True,
            "preload": False,
            "quantity": None,
            "rtol": None,
            "linear_solver": None,
        },
    ),
    "Result.at": (HIT.at, {"times": [1e-4]}),
    "Result.to_csv": (HIT.to_csv, {"path": None}),
    "probe": (
        FIELDS.target.probe,
        {"point": (0.05, 0.0, 0.0), "direction": (1, 0, 0), "times": None},
    ),
    "probe of nodes": (FIELDS.target.probe, {"nodes": "xmin"}),
    "field": (FIELDS.target.field, {"times": [1e-5]}),
    "to_vtu": (FIELDS.target.to_vtu, {"path": "fields", "times": [1e-5]}),
    "simulate_many": (
        ao.simulate_many,
        {"cases": [STRIKE], "workers": 1, "keep": None, "checkpoint": None, "progress": False},
    ),
    "a case": (lambda **case: ao.simulate_many([case]), dict(STRIKE)),
    "a case in numbers": (
        lambda **case: ao.simulate_many([case], keep=("peak_force",)),
        dict(STRIKE),
    ),
    "iterate_many": (
        lambda **given: list(ao.iterate_many(**given)),
        {"cases": [STRIKE], "workers": 1},
    ),
    "sweep": (
        ao.sweep,
        {
            "base": STRIKE,
            "grid": {"velocity": [1.0]},
            "keep": ["peak_force"],
            "workers": 1,
            "checkpoint": None,
            "progress": False,
        },
    ),
    "values of a sweep": (
        lambda **grid: ao.sweep(STRIKE, grid, progress=False),
        {"velocity": [1.0], "gap": [0.0]},
    ),
    "work_precision": (
        ao.work_precision,
        STRIKE
        | {
            "gap": 0.0,
            "newmark": [1e-5],
            "adaptive": [1e-3],
            "scipy": (),
            "reference": None,
            "repeats": 1,
        },
    ),
    "rigid_restitution": (
        ao.HuntCrossley(1e9, 0.1).rigid_restitution,
        {"mass": 1.0, "velocity": 1.0},
    ),
}

# What else an argument may be called in messages.
ALSO = {
    "material_1": ("material",),
    "material_2": ("material",),
    "source": ("mesh",),
    "path": ("1", "no such file"),
    "base": ("1:", "no such file:"),
    "a": ("handle",),
    "b": ("handle",),
    # The law's own parameters, as they come out of these.
    "radius_1": ("k must be positive",),
    "radius_2": ("k must be positive",),
    "yield_pressure": ("yield_force",),
    "velocity": ("damping must be finite",),
    "indentation": ("force must have shape",),
    # What is right by itself, and too extreme beside the rest.
    "s2": ("singular to rounding",),
    "contact_time": ("give the durations",),
    "duration": ("adaptive run at t", "give the durations"),
    "adaptive": ("rtol",),
}

# A function of the user's has errors of its own, and may be slow; a value of a sweep may be a list.
NOT = {
    "solver": ("function", "class"),
    "linear_solver": ("function", "class"),
    "repeats": ("long",),
    "velocity": ("recursive",),
    "gap": ("recursive",),
}


def tried(name: str, argument: str, value: Any) -> str:
    """What is wrong with how a call takes an odd value; empty if nothing is."""
    function, given = CALLS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ao.AOImpactWarning)
        try:
            function(**given | {argument: value})
        except ao.AOImpactError as error:
            words = (argument, *ALSO.get(argument, ()))
            return "" if any(word in str(error) for word in words) else f"unnamed: {error}"
        except Exception as error:
            return f"{type(error).__name__}: {error}"
    return ""


@pytest.mark.parametrize("name", CALLS)
def test_every_argument_takes_odd_values_or_names_them(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    wrong = []
    for argument in CALLS[name][1]:
        for kind, value in ODD.items():
            if kind in NOT.get(argument, ()):
                continue
            said = tried(name, argument, value)
            if said:
                wrong.append(f"{argument} = {kind}: {said}")
    assert not wrong, "\n".join(wrong)
