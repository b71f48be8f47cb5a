"""Arguments of odd types and values: each is taken, or refused by name."""

from __future__ import annotations

import contextlib
import inspect
import math
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import fields
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import scipy.sparse
from every_law import LAWS as EVERY_LAW
from every_law import law_of
from rows import each

import aoimpact as ao
from aoimpact import testrig
from aoimpact.reduction import KrylovSpace
from aoimpact.results import Handle
from aoimpact.scenefile import SceneFile


class Index:
    """An integer to `operator.index`, and to nothing else."""

    def __index__(self) -> int:
        return 8


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
    "table": {},
    "set": set(),
    "object": object(),
    "function": len,
    "ragged": [[1.0], [1.0, 2.0]],
    "words": ["a", "b"],
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
    "half a character": "\ud800",
    "null character": "a\0b",
    "folder": ".",
    "index": Index(),
    "sparse": scipy.sparse.eye(3),
}

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
TWO = {"material_1": STEEL, "radius_1": 0.01, "material_2": STEEL, "radius_2": 0.01}
HERTZ = ao.Hertz(1e9)
BALL = ao.rigid(0.03)
STAR = ao.AOModel(m0=0.1, k0=1e4, m=[0.2], k=[1e6])
PLY = ao.Orthotropic(E=(135e9, 9e9, 9e9), G=(5e9, 5e9, 3.2e9), nu=(0.3, 0.3, 0.4), rho=1550)
BOX = ao.box_mesh((0.1, 0.02, 0.02), (2, 1, 1))
BAR = ao.FEModel.from_mesh(BOX, STEEL)
TIP = BAR.contact(point=(0.1, 0.0, 0.0), direction=(-1.0, 0.0, 0.0), radius=0)
SHEET, SHELL = ao.sheet_mesh((0.3, 0.3), (2, 2)), ao.Shell(2e-3, STEEL)
CHAIN = np.array([[4.0, -4.0, 0.0], [-4.0, 8.0, -4.0], [0.0, -4.0, 4.0]])
HELD = ao.FEModel.from_mesh(BOX, STEEL, fixed=[("xmin", "xyz")])
STRIKE: dict[str, Any] = {
    "projectile": BALL,
    "target": STAR,
    "law": HERTZ,
    "velocity": 1.0,
    "duration": 1e-3,
}
HIT = ao.simulate(**STRIKE)
FIELDS = ao.simulate(**STRIKE | {"target": ao.antioscillators(TIP, 2)})
CLAMPED = ao.simulate(**STRIKE | {"target": ao.antioscillators(HELD.contact(dof=2), 2)})


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


MODAL = ao.modal(TIP, 7)
PORTS = ao.interface([TIP], 8)
SWEEP = ao.sweep(STRIKE, {"velocity": [1.0]}, keep=["peak_force"], progress=False)
COMPARED = ao.compare(**STRIKE, oscillators=(0,), modes=(), full=False)
FILE = ao.read_scene(Path(__file__).parents[2] / "examples" / "sphere_on_beam.toml")


def _again(made: Any) -> tuple[Callable[..., Any], dict[str, Any]]:
    """The constructor of a dataclass, and what makes the same again."""
    return type(made), {f.name: getattr(made, f.name) for f in fields(made) if f.init}


def _space(**given: Any) -> Any:
    return KrylovSpace(TIP, contact_time=1e-4, **given)


# Keywords of these go to matplotlib.
DRAWN = "plot"


def public() -> Iterator[tuple[str, set[str]]]:
    """Every public function, constructor and method, and the names of its arguments."""
    of_rigs = {name: getattr(testrig, name) for name in testrig.__all__}
    for name, thing in ({name: getattr(ao, name) for name in dir(ao)} | of_rigs).items():
        if name.startswith("_") or not callable(thing):
            continue
        if not inspect.isclass(thing):
            yield name, _arguments(thing)
        elif not issubclass(thing, Exception):
            yield name, _arguments(thing)
            for method in vars(thing):
                of = getattr(thing, method)
                called = inspect.isfunction(of) or inspect.ismethod(of)
                shown = ":meta private:" not in (of.__doc__ or "")
                if called and shown and not method.startswith(("_", DRAWN)):
                    yield f"{name}.{method}", _arguments(of) - {"self"}


def _arguments(function: Callable[..., Any]) -> set[str]:
    given = inspect.signature(function).parameters.values()
    variable = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD
    return {one.name for one in given if one.kind not in variable and one.name[0] != "_"}


# Arguments of laws' methods that are not arguments of the laws themselves.
OF_METHODS = {"restitution": 0.5, "velocity": 1.0, "mass": 1.0, "formula": "flores"}


def _laws() -> Iterator[tuple[str, tuple[Callable[..., Any], dict[str, Any]]]]:
    """Constructors of laws that take numbers, and what these laws do of their own."""
    examples = {type(law).__name__: law for law in map(law_of, EVERY_LAW)}
    for name, arguments in public():
        of, _, method = name.partition(".")
        if of not in examples or not arguments:
            continue
        law = examples[of]
        own = {one.name: getattr(law, one.name) for one in fields(cast(Any, law))}
        numbers = OF_METHODS | own
        if arguments <= set(numbers) and not any(map(callable, own.values())):
            given = {one: numbers[one] for one in sorted(arguments)}
            yield name, (getattr(law, method) if method else type(law), given)


# What is called, with what, and which of its arguments are made odd.
SIGNAL = testrig.Signal(np.arange(500) / 1e5, np.sin(np.arange(500) / 50.0))
HALF_SINE = np.sin(np.pi * np.arange(60) / 60.0)
TAP = testrig.Signal(np.arange(60) / 3e4, 180.0 * HALF_SINE)  # Hertz's k of 1e7, 0.1 kg at 1 m/s
SPEED = testrig.Signal(TAP.t, np.cumsum(TAP.values) / 3e4, unit="m/s", name="velocity")
DROP = testrig.Signal(np.arange(500) / 1e5, 500.0 * np.sin(np.pi * np.arange(500) / 500.0))
CHANNEL = Path(tempfile.mkdtemp()) / "drop.csv"
CHANNEL.write_text("t,F\n0,0\n1,1\n2,0\n")
LABELS = np.stack([BAR.free // 3 + 1, BAR.free % 3 + 1], axis=1)
BARE = ao.FEModel(K=BAR.K, M=BAR.M, nodes=BAR.nodes, free=BAR.free)
MATRICES = ao.write_matrices(BAR, tempfile.mkdtemp())
DECK = Path(tempfile.mkdtemp()) / "deck.bdf"
DECK.write_text(
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nCTRIA3,1,1,1,2,3\nPSHELL,1,1,.01,1\n"
    "MAT1,1,2.1E11,,.3,7800.\n"
)


def call(
    function: Callable[..., Any], /, **sound: Any
) -> tuple[Callable[..., Any], dict[str, Any]]:
    return function, sound


def whole(
    function: Callable[..., Any], /, **sound: Any
) -> tuple[Callable[..., Any], dict[str, Any]]:
    """A call whose other arguments have their defaults."""
    known = inspect.signature(function).parameters.values()
    return function, {one.name: sound.get(one.name, one.default) for one in known}


CALLS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    **dict(_laws()),
    "AOModel": whole(ao.AOModel, m0=0.1, k0=1.0, m=[1.0], k=[1.0]),
    "ball": whole(ao.ball, radius=0.01, material=STEEL, mass=1.0),
    "rigid": whole(ao.rigid, mass=1.0, inertia=1.0, arm=(0, 0, 1.0)),
    "wall": whole(ao.wall, material=STEEL),
    "Adaptive": call(ao.Adaptive, rtol=1e-6),
    "Newmark": whole(ao.Newmark, dt=1e-6),
    "Material": call(ao.Material, E=1e9, nu=0.3, rho=1e3, yield_strength=1e7, hardness=3e7),
    "StressAt": whole(ao.StressAt, body=BAR, point=(0.1, 0.0, 0.0), component="xx", layer="top"),
    "StrainAt": _again(ao.StrainAt(BAR, (0.05, 0.01, 0.0), (1, 0, 0), 1e-3, layer="top")),
    "AccelerationAt": call(
        ao.AccelerationAt, point=(0.1, 0.0, 0.0), direction=(0, 0, 1), cfc=1000.0, body=BAR
    ),
    "AccelerationAt with a corner": call(
        ao.AccelerationAt, point=(0.1, 0.0, 0.0), direction=(0, 0, 1), corner=1000.0
    ),
    "ReactionAt": call(ao.ReactionAt, nodes="xmin", direction=(0, 0, 1), body=HELD),
    "Rayleigh": call(ao.Rayleigh, alpha=1.0, beta=1e-6),
    "ModalDamping": call(ao.ModalDamping, ratio=0.1),
    "Hertz.between": whole(ao.Hertz.between, **TWO),
    "Thornton.between": call(ao.Thornton.between, **TWO, yield_pressure=1e9),
    "ElasticPlastic.between": call(ao.ElasticPlastic.between, **TWO, hardness=3e9),
    "ContactLaw.dent": call(HERTZ.dent, indentation=1e-6),
    "Tabulated": call(ao.Tabulated, indentation=[0.0, 1e-3], force=[0.0, 1.0]),
    "UserLaw": whole(ao.UserLaw, function=lambda d, r: d),
    "ContactLaw.force": whole(HERTZ.force, indentation=1e-6, along=True),
    "ContactLaw.potential": call(HERTZ.potential, indentation=1e-6),
    "ContactLaw.stroke": call(HERTZ.stroke, energy=1.0),
    "ContactLaw.within_patch": call(HERTZ.within_patch, compliance=1e-9),
    "restitution": call(ao.restitution, law=ao.HuntCrossley(1e9, 0.1), mass=1.0, velocity=1.0),
    "box_mesh": call(ao.box_mesh, lengths=(1.0, 1.0, 1.0), divisions=(1, 1, 1), kind="tetra"),
    "sheet_mesh": call(ao.sheet_mesh, lengths=(1.0, 1.0), divisions=(1, 1), kind="triangle"),
    "Shell": whole(ao.Shell, thickness=1e-3, material=STEEL),
    "Ply": call(ao.Ply, thickness=1e-3, material=PLY, angle_deg=45.0),
    "Laminate": whole(ao.Laminate, plies=[ao.Ply(1e-3, PLY)], fibre_axis=(1, 0, 0)),
    "Beam": _again(ao.Beam(ao.CircularSection(0.01), STEEL, (0, 0, 1), (0.0, 0.0))),
    "RectangularSection": call(ao.RectangularSection, width=0.02, height=0.01),
    "CircularSection": call(ao.CircularSection, radius=0.01),
    "TubularSection": call(ao.TubularSection, radius=0.01, thickness=1e-3),
    "BeamSection": _again(ao.BeamSection(1e-3, 1e-6, 1e-7, 1e-8, (0.8, 0.8), ((0.0, 0.0),))),
    "sphere_mesh": call(ao.sphere_mesh, radius=1.0, size=1.0),
    "Mesh": call(
        ao.Mesh,
        nodes=BOX.nodes,
        cells=BOX.cells,
        kind=BOX.kind,
        node_sets=BOX.node_sets,
        cell_sets={"all": [0]},
        node_labels=np.arange(1, BOX.n_nodes + 1),
        cell_labels=np.arange(1, BOX.n_cells + 1),
        left_out={"springs": "3 SPRINGA"},
    ),
    "Mesh of elements": call(ao.Mesh, nodes=BOX.nodes, cells=BOX.cells, kind=BOX.kind),
    "Mesh.part": call(ao.Mesh(BOX.nodes, BOX.cells, BOX.kind, {}, {"all": [0]}).part, names="all"),
    "read_mesh": whole(ao.read_mesh, source=BOX),
    "read_sections": whole(
        ao.read_sections, path=DECK, given={"property 1": ao.Shell(1e-3, STEEL)}
    ),
    "Material.half_space": call(STEEL.half_space, normal=(0, 0, 1)),
    "Orthotropic": _again(PLY),
    "Orthotropic.turned": call(PLY.turned, angle=0.1, about=(0, 0, 1)),
    "Orthotropic.half_space": call(PLY.half_space, normal=(0, 0, 1)),
    "RigidMass": call(
        ao.RigidMass, nodes="xmax", mass=1.0, centre=(0, 0, 0), inertia=(1.0, 1.0, 1.0)
    ),
    "read_scene": call(ao.read_scene, path="no.toml"),
    "FEModel": call(
        ao.FEModel, K=BAR.K, M=BAR.M, nodes=BAR.nodes, free=BAR.free, damping=None, name=""
    ),
    "FEModel.from_mesh": whole(
        ao.FEModel.from_mesh,
        mesh=BOX,
        material=STEEL,
        masses=[("xmax", 1.0)],
        springs=[("xmax", "x", 1e6)],
    ),
    "FEModel.contact": call(
        BAR.contact, point=(0.1, 0, 0), direction=(-1, 0, 0), radius=0.0, expected=None
    ),
    "FEModel.contact of a dof": call(BAR.contact, dof=0),
    "FEModel.contact of a node": call(BAR.contact, node=3, direction=(-1, 0, 0), radius=0.0),
    "FEModel.contact of a functional": call(BAR.contact, b=np.eye(BAR.n_dofs)[0]),
    "FEModel of matrices": call(ao.FEModel, K=CHAIN, M=np.eye(3)),
    "FEModel.from_mesh of a sheet": call(ao.FEModel.from_mesh, mesh=SHEET, material=SHELL),
    "FEModel of labels": call(ao.FEModel, K=BAR.K, M=BAR.M, labels=LABELS),
    "FEModel.translation": call(BAR.translation, direction=(1, 0, 0)),
    "FEModel.com_functional": call(BAR.com_functional, direction=(1, 0, 0)),
    "FEModel.inverse": whole(BAR.inverse, s2=1e8, solutions=1),
    "FEModel.frequencies": call(BAR.frequencies, n=3),
    "antioscillators": whole(ao.antioscillators, tip=TIP, n=2, method="krylov", contact_time=1e-4),
    "full": call(ao.full, tips=TIP),
    "modal": whole(ao.modal, tips=TIP, n=3),
    "interface": whole(ao.interface, tips=[TIP], n=8, duration=None),
    "KrylovSpace": call(KrylovSpace, tips=TIP, contact_time=1e-4, duration=None, solver="auto"),
    "AOModel.to_json": call(STAR.to_json, path="model.json"),
    "FEModel.with_mesh": call(BARE.with_mesh, mesh=BAR.mesh, material=STEEL),
    "FEModel.audit": call(BAR.audit, frequencies=2),
    "write_matrices": call(ao.write_matrices, what=STAR, folder="matrices"),
    "read_matrices": whole(
        ao.read_matrices,
        K=MATRICES["K"],
        M=MATRICES["M"],
        dofs=LABELS,
        nodes=BAR.nodes,
        mesh=BAR.mesh,
        material=STEEL,
    ),
    "AOModel.receptance": call(STAR.receptance, omega=1.0),
    "AOModel.truncated": call(STAR.truncated, n=1),
    "AOModel.expand": call(ao.antioscillators(TIP, 2).expand, coordinates=np.zeros(3)),
    "simulate": whole(ao.simulate, **STRIKE),
    "compare": whole(
        ao.compare,
        **STRIKE,
        oscillators=(0,),
        modes=(2,),
        full=False,
        other_targets={"ball": ao.rigid(mass=1.0)},
    ),
    "fit_law": whole(ao.fit_law, law=ao.Hertz(1e7), signal=TAP, mass=0.1, velocity=1.0, free="k"),
    "fit_law of a curve": call(
        ao.fit_law, law=ao.Hertz(1e7), indentation=[0.0, 1e-4, 2e-4], force=[0.0, 10.0, 28.0]
    ),
    "Scene": whole(ao.Scene),
    "Scene.add": call(_added, body=BALL, velocity=1.0, spin=None, position=0.0, name="a"),
    "Scene.connect": call(_connected, a=OWN, b=OWN, law=HERTZ, gap=0.0, friction=0.1, name=""),
    "Scene.apply": call(_applied, body=OWN, force=1.0),
    "Scene.simulate": call(
        _run,
        duration=1e-3,
        solver=None,
        energies=True,
        preload=False,
        quantity=None,
        rtol=None,
        linear_solver=None,
    ),
    "FEModel.frf": call(
        HELD.frf,
        excitation=HELD.contact(dof=2),
        response=HELD.contact(dof=5),
        frequencies=[100.0, 200.0],
        kind="mobility",
    ),
    "Run.value": call(HIT.value, name="restitution"),
    "probe": call(FIELDS.target.probe, point=(0.05, 0.0, 0.0), direction=(1, 0, 0), times=None),
    "probe of nodes": call(FIELDS.target.probe, nodes="xmin"),
    "probe at even times": call(FIELDS.target.probe, point=(0.05, 0.0, 0.0), dt=1e-5),
    "filtered": call(FIELDS.target.probe((0.05, 0.0, 0.0)).filtered, cfc=2000.0),
    "gauge": whole(FIELDS.target.gauge, point=(0.05, 0.01, 0.0), direction=(1, 0, 0), length=1e-3),
    "reaction": whole(CLAMPED.target.reaction, nodes="xmin"),
    "field": call(FIELDS.target.field, times=[1e-5]),
    "to_vtu": call(FIELDS.target.to_vtu, path="fields", times=[1e-5]),
    "simulate_many": whole(ao.simulate_many, cases=[STRIKE], progress=False),
    "a case": call(lambda **case: ao.simulate_many([case]), **STRIKE),
    "a case in numbers": call(
        lambda **case: ao.simulate_many([case], keep=("peak_force",)), **STRIKE
    ),
    "sweep": whole(
        ao.sweep, base=STRIKE, grid={"velocity": [1.0]}, keep=["peak_force"], progress=False
    ),
    "values of a sweep": call(
        lambda **grid: ao.sweep(STRIKE, grid, progress=False), velocity=[1.0], gap=[0.0]
    ),
    "a value of a sweep": call(
        lambda **given: ao.sweep(STRIKE, {k: [v] for k, v in given.items()}, progress=False),
        velocity=1.0,
        law=HERTZ,
    ),
    "ContactLaw.rigid_restitution": call(
        ao.HuntCrossley(1e9, 0.1).rigid_restitution, mass=1.0, velocity=1.0
    ),
    "FullModel": _again(ao.full(TIP)),
    "Body.truncated": call(MODAL.truncated, n=1),
    "Body.receptance": call(PORTS.receptance, omega=1.0),
    "Body.expand": call(PORTS.expand, coordinates=np.zeros(PORTS.n)),
    "Handle.port": call(Handle(0).port, at=0),
    "Run.at": call(HIT.at, times=[1e-4]),
    "Run.to_csv": call(HIT.to_csv, path="run.csv"),
    "Result.movie": whole(FIELDS.movie, path="movie.avi", frames=3),
    "Signal": whole(testrig.Signal, t=[0.0, 1.0], values=[0.0, 1.0]),
    "Signal.of": whole(testrig.Signal.of, source=HIT, rate=1e6),
    "Signal.resampled": call(SIGNAL.resampled, rate=2e5),
    "Signal.filtered": whole(SIGNAL.filtered, cfc=600),
    "read_signal": whole(testrig.read_signal, path=CHANNEL),
    "drop_weight": call(
        testrig.drop_weight, source=DROP, mass=1.0, velocity=1.0, gravity=0.0, cfc=600, start=0.0
    ),
    "DropWeight.to_csv": call(
        testrig.drop_weight(DROP, mass=1.0, velocity=1.0).to_csv, path="test.csv"
    ),
    "frf": call(testrig.frf, force=TAP, response=SPEED, kind="mobility", estimator="H2"),
    "shock_spectrum": whole(
        testrig.shock_spectrum, source=SIGNAL, frequencies=[100.0, 200.0], damping_ratio=0.1
    ),
    "SweepTable.to_csv": call(SWEEP.to_csv, path=None),
    "Comparison.to_csv": call(COMPARED.to_csv, path=None),
    "SceneFile": (SceneFile, {name: getattr(FILE, name) for name in ("path", "data", "text")}),
    "SceneFile.probes": call(FILE.probes, result=HIT),
    "SceneFile.replaced": call(FILE.replaced, values={"velocity": 2.0}),
    "values of SceneFile.replaced": call(lambda **values: FILE.replaced(values), velocity=1.0),
    "KrylovSpace sharpened": call(_space, sharpened=False),
    "KrylovSpace.antioscillators": call(lambda **n: _space().antioscillators(**n), n=2),
    "KrylovSpace.of_vectors": call(lambda **n: _space().of_vectors(**n), n=2),
    "KrylovSpace.include": call(lambda **given: _space().include(**given), duration=1e-3),
    "Rayleigh.decay": call(ao.Rayleigh(alpha=1.0).decay, omega=1.0),
    "ModalDamping.decay": call(ao.ModalDamping(0.1).decay, omega=1.0),
}

# What else an argument may be called in messages.
ALSO = {
    "material_1": ("material",),
    "material_2": ("material",),
    "source": ("mesh",),
    "signal": ("source must",),
    "path": ("1", "no such file", ".: cannot be read", "cannot read '.'", "mesh file '.' is"),
    "base": ("1:", "no such file:", ".: cannot be read", "path must"),
    "a": ("handle",),
    "b": ("handle",),
    # The law's own parameters, as they come out of these.
    "radius_1": ("k must be positive",),
    "radius_2": ("k must be positive",),
    "yield_pressure": ("yield_force",),
    "hardness": ("yield_force", "yield_strength"),
    "velocity": ("damping must be finite",),
    "indentation": ("force must have shape",),
    # What is right by itself, and too extreme beside the rest.
    "s2": ("singular to rounding", "singular or not positive definite"),
    "contact_time": ("give the durations",),
    "duration": ("adaptive run at t", "give the durations"),
    "expected": ("share",),
    "scale": ("elements are flat", "path must end in .gif"),
    "cells": (
        *("refer to nodes", "elements are there twice", "belong to no element"),
        "cell_labels must have shape",
    ),
    "omega2": ("modes must have shape",),
    "omega": ("participation must have shape",),
    "data": ("is missing",),
    "names": ("which is not installed",),
    # What is sound goes on to a path that is none: to draw would take long.
    **dict.fromkeys(("times", "frames", "fps"), ("path must end in .gif",)),
}

# A function of the user's has errors of its own, and may be slow; a value of a sweep may be a list.
NOT = {
    "solver": ("function",),
    "linear_solver": ("function",),
    "velocity": ("recursive",),
    "gap": ("recursive",),
}


# The calls and arguments that are a number, and take infinity, zero, a negative one or None:
# nothing else does, and none takes NaN, text, a complex number or True.
TAKEN = {
    "inf": """Hertz.between: radius_1, radius_2; Thornton.between: radius_1, radius_2;
        ElasticPlastic.between: radius_1, radius_2; rigid: mass; KrylovSpace.include: duration""",
    "zero": """KuwabaraKono: A; Tsuji: alpha; KelvinVoigt: c; HuntCrossley: damping; Hertz:
        eccentricity; Rayleigh: alpha, beta; ModalDamping: ratio; Rayleigh.decay: omega;
        ModalDamping.decay: omega; Material: nu; Orthotropic.turned: angle; Ply: angle_deg; Shell:
        offset; Laminate: offset; AOModel: m0, k0; AOModel.receptance: omega;
        Body.receptance: omega; AOModel.truncated: n; antioscillators: n;
        KrylovSpace.antioscillators: n; KrylovSpace.of_vectors: n;
        simulate: gap; compare: gap; Scene: gravity; Scene.add: position, velocity; Scene.connect:
        gap, friction; Scene.apply: force; ContactLaw.force: indentation, rate;
        ContactLaw.potential: indentation; ContactLaw.within_patch: compliance; FEModel.contact:
        radius; FEModel.contact of a node: radius, node; FEModel.contact of a dof: dof;
        FEModel.audit: frequencies; FEModel.inverse: solutions; Handle.port: at;
        StrainAt: length; shock_spectrum: damping_ratio;
        drop_weight: gravity, start; Signal.of: contact, margin; read_signal: time, values""",
    "minus one": """Orthotropic.turned: angle; Ply: angle_deg; ContactLaw.within_patch:
        compliance; ContactLaw.force: indentation, rate; ContactLaw.potential: indentation;
        Hertz.between: radius_1, radius_2; Thornton.between: radius_1, radius_2;
        ElasticPlastic.between: radius_1, radius_2; AOModel.receptance: omega;
        Body.receptance: omega; Rayleigh.decay: omega; ModalDamping.decay: omega; Scene:
        gravity; Scene.add: position, velocity; Scene.connect: gap; Scene.apply: force""",
    "none": """ball: mass; Material: yield_strength, hardness; YangSun: beta; Newmark: dt;
        AccelerationAt: cfc; AccelerationAt with a corner: corner; probe at even times: dt;
        antioscillators: contact_time; KrylovSpace: contact_time;
        simulate: duration; compare: duration; Scene.simulate: duration;
        Scene.connect: friction; Signal.of: rate; drop_weight: gravity, cfc, start""",
    **dict.fromkeys(("nan", "text", "complex", "true"), ""),
}

# A case is looked at where it is run; and these laws and materials have no use for their argument.
UNSEEN = """a case: velocity, duration; a case in numbers: velocity, duration; a value of a sweep:
    velocity; values of SceneFile.replaced: velocity; Hertz.between: angle"""


def listed(text: str) -> set[tuple[str, str]]:
    """Calls and arguments of "call: argument, argument; call: argument"."""
    calls = [call.split(":") for call in " ".join(text.split()).split(";") if call]
    return {(name.strip(), one.strip()) for name, rest in calls for one in rest.split(",")}


ARE_TAKEN = {kind: listed(text) for kind, text in TAKEN.items()}
ARE_UNSEEN = listed(UNSEEN)


def is_number_taken(name: str, argument: str, kind: str) -> bool | None:
    """Whether a number, or True or False, must be taken; None of what may be."""
    sound = CALLS[name][1][argument]
    if kind not in TAKEN or not isinstance(sound, int | float) or (name, argument) in ARE_UNSEEN:
        return None
    if isinstance(sound, bool):
        return kind == "true"
    return (name, argument) in ARE_TAKEN[kind]


def nearly(sound: Any) -> dict[str, Any]:
    """Odd values that are nearly the sound one, of arrays and lists of numbers."""
    if not isinstance(sound, (np.ndarray, list, tuple)) or not len(sound):
        return {}
    array = np.asarray(sound)
    if array.dtype.kind not in "iuf":
        return {}
    one_nan = array.astype(float)
    one_nan.flat[0] = math.nan
    return {
        "shorter": array[:-1],
        "longer": np.concatenate([array, array]),
        "a column": array[:, None],
        "as a list": array.tolist(),
        "in single precision": array.astype(np.float32),
        "in integers": array.astype(int),
        "as complex": array.astype(complex),
        "one nan": one_nan,
        "zeros": 0 * array,
        "negative": -array,
        "vast": 1e200 * array,
        "tiny": 1e-200 * array,
        "every other": np.repeat(array, 2, axis=0)[::2],
    }


def used(made: Any) -> None:
    """Do with something public whatever takes no arguments; refusals by name are right."""
    repr(made), str(made)
    for name in dir(type(made)):
        if not name.startswith("_"):
            with contextlib.suppress(ao.AOImpactError):
                getattr(made, name)
    if isinstance(made, ao.ContactPoint):
        with contextlib.suppress(ao.AOImpactError):
            ao.antioscillators(made, 2)
        ao.modal(made, 7)
    if isinstance(made, ao.Body | ao.FullModel):
        with contextlib.suppress(ao.AOImpactError):
            ao.simulate(**STRIKE | {"target": made})


def tried(name: str, argument: str, kind: str, value: Any) -> str:
    """What is wrong with how a call takes an odd value; empty if nothing is."""
    function, given = CALLS[name]
    taken = is_number_taken(name, argument, kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ao.AOImpactWarning)
        try:
            made = function(**given | {argument: value})
        except ao.AOImpactError as error:
            words = (argument, *ALSO.get(argument, ()))
            if taken:
                return f"refused: {error}"
            return "" if any(word in str(error) for word in words) else f"unnamed: {error}"
        except Exception as error:
            return f"{type(error).__name__}: {error}"
        if taken is False:
            return "taken"
        if inspect.isclass(function):
            try:
                used(made)
            except Exception as error:
                return f"taken, then {type(error).__name__}: {error}"
    return ""


@each("name", CALLS)
def test_every_argument_takes_odd_values_or_names_them(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    wrong = []
    for argument, sound in CALLS[name][1].items():
        for kind, value in (ODD | nearly(sound)).items():
            if kind in NOT.get(argument, ()):
                continue
            said = tried(name, argument, kind, value)
            if said:
                wrong.append(f"{argument} = {kind}: {said}")
    assert not wrong, "\n".join(wrong)


# How messages read. Elsewhere a refusal is its class and the name of the argument.
WORDS = Path(__file__).with_name("refusals.txt")


# What a row may name besides literals.
NAMES: dict[str, Any] = {
    "inf": math.inf,
    "nan": math.nan,
    "BALL": BALL,
    "ROUND": ao.ball(0.01, STEEL),
    "FLOOR": ao.wall(STEEL),
    "WALL": ao.rigid(math.inf),
    "BLOCK": BAR.contact(point=(0.1, 0.01, 0.01)),
    "SIDE": BAR.contact(point=(0.05, 0.02, 0.01)),
    "ASLANT": BAR.contact(point=(0.1, 0.01, 0.01), direction=(-1.0, 0.5, 0.0)),
    "PLATE": ao.FEModel.from_mesh(SHEET, SHELL).contact(point=(0.1, 0.1, 0.0)),
    "STEPS": ao.Newmark(dt=1e-6),
    "EVENTS": ao.Adaptive(),
    "LAWS": ao,
    "MADE": {
        "much": lambda hit: "much",
        "twice": lambda hit: {"velocity": 1.0},
        "other": lambda hit: {f"above 600 N: {hit.peak_force > 600}": 1.0},
    },
    "STRIKE": STRIKE,
    "RIG": testrig,
    "TAP": TAP,
    "SPEED": SPEED,
    "STEEL": STEEL,
    "PLY": PLY,
    "STAR": STAR,
    "TURNED": PLY.turned(0.1),
    "TIP": TIP,
    "SHEET": SHEET,
    "LINE": ao.Mesh([[0, 0, 0], [1, 0, 0]], [[0, 1]], "line"),
    "HALVES": ao.Mesh(
        BOX.nodes, BOX.cells, BOX.kind, {}, {"one": [0], "other": [1], "all": [0, 1]}
    ),
    "LABELLED": ao.Mesh(BOX.nodes, BOX.cells, BOX.kind, node_labels=[1, 1, *range(2, 12)]),
    "SHELL": SHELL,
    "BEAM": ao.Beam(ao.CircularSection(0.01), STEEL),
    "THICK": ao.Shell(2.0, STEEL),
    "THICK_BEAM": ao.Beam(ao.CircularSection(3.0), STEEL),
    "ON_A_NODE": ao.RigidMass([0], 1.0, inertia=(1.0, 1.0, 1.0)),
    "OTHER_TIP": ao.FEModel.from_mesh(BOX, STEEL).contact(dof=2),
    "POINTLESS": ao.FEModel(K=np.eye(3), M=np.eye(3), nodes=np.zeros((1, 3))),
    "OFF_ITS_LINE": ao.RigidMass([0, 1], 1.0, centre=(9.0, 0.0, 0.0)),
}


def refused(name: str, odd: dict[str, Any]) -> str:
    """How a call refuses these values: class and message; empty where it takes them."""
    function, given = CALLS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)
        try:
            function(**given | odd)
        except ao.AOImpactError as error:
            said = " ".join(str(error).split())
            said = re.sub(r"/\S+/(?=examples/)|/tmp/[^\s']+| at 0x\w+", "…", said)
            return f"{type(error).__name__}: {said}"
        except Exception:  # which the test above judges
            pass
    return ""


def refusals() -> str:
    """A line for each argument: how a negative number is refused, or where it is none, a text.

    After an empty line the file has rows of one's own, "call: argument=value, …: class: message",
    for arguments that are wrong beside the others, or by their values: literals and `NAMES`.
    """
    lines = []
    for name, (_, sound) in CALLS.items():
        for argument in sound:
            found = ((kind, refused(name, {argument: ODD[kind]})) for kind in TRIED)
            said = next((f"{kind}: {words}" for kind, words in found if words), "")
            lines += [f"{name}: {argument}={said}"] if said else []
    lines.append("")
    rows = WORDS.read_text("utf-8").partition("\n\n")[2]
    for name, odd in re.findall(r"^(.+?): (.+?)(?:: \w+Error: .*)?$", rows, re.M):
        lines.append(f"{name}: {odd}: {refused(name, eval(f'dict({odd})', NAMES))}")
    return "\n".join([*lines, ""])


TRIED = "minus one", "text", "object"


def test_refusals_read_as_they_did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read what changed, then `PYTHONPATH=tests python tests/package/test_odd_arguments.py`."""
    monkeypatch.chdir(tmp_path)
    assert refusals() == WORDS.read_text("utf-8")


# Made by every run and by nobody else: to check what the package itself has made would cost a plain
# impact a tenth of its time.
ONLY_RETURNED = {"Audit", "Body", "Comparison", "DropWeight", "Handle", "LawFit", "Point", "Result"}
ONLY_RETURNED |= {"ContactPoint", "MeasuredResponse", "Patch", "Run", "ShockSpectrum", "SweepTable"}


def test_everything_public_is_tried_with_each_argument() -> None:
    tried: dict[str, set[str]] = {}
    for name, (_, given) in CALLS.items():
        tried.setdefault(name.partition(" ")[0], set()).update(given)
    untried = {
        name: left
        for name, given in public()
        if name not in ONLY_RETURNED and (left := given - tried.get(name, set()))
    }
    assert not untried, "add a call of it, with sound arguments, to CALLS of this file"


if __name__ == "__main__":
    os.chdir(tempfile.mkdtemp())
    WORDS.write_text(refusals(), "utf-8")
