"""Sections and materials in decks of Abaqus, CalculiX and Nastran."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import get_args

import numpy as np

from ..base import (
    FilePath,
    InputError,
    MeshError,
    held_warnings,
    instance,
    nearest,
    positive,
    text,
    warn,
)
from ..fem import Laminate, OneMaterial, Shell
from ..mesh import against_neighbours
from .abaqusdeck import key
from .raw import RawMesh
from .read import load
from .sections import Source


def read_sections(
    path: FilePath,
    *,
    scale: float = 1.0,
    force: float = 1.0,
    time: float = 1.0,
    given: Mapping[str, OneMaterial] | None = None,
) -> dict[str, OneMaterial]:
    """Return the sections in a deck, by the groups of elements that they belong to.

    They are what `FEModel.from_mesh` takes as material. A deck in metres is a body by
    ``FEModel.from_mesh(path, read_sections(path))``.

    Abaqus and CalculiX: \\*SOLID SECTION, \\*SHELL SECTION (also COMPOSITE), \\*SHELL GENERAL
    SECTION of a material, \\*BEAM SECTION and \\*BEAM GENERAL SECTION; \\*ELASTIC, \\*DENSITY,
    rectangular \\*ORIENTATION. Nastran: PSOLID, PSHELL, PCOMP, PCOMPG, PBAR, PBARL, PBEAM, PBEAML;
    MAT1, MAT8, MAT11; PARAM,WTMASS. Whatever else changes the answer is refused, such as mass and
    shear stiffness beside the sections. Loads, supports and steps are not read.

    Beams are of all shapes in Abaqus' library and in Nastran's PBARL but DBOX, or of numbers. They
    carry shear at the centroid. The centroid is where Abaqus has it from the nodes; the bars of
    Nastran have it at the nodes, or as WA = WB says. J is Saint-Venant's, from an integral equation
    on the outline. Shear factors are the shares of the walls along each axis. The walls of
    ARBITRARY are thin: J = Σ b t³/3, with 4 A²/∮ds/t of a closed section.

    The modulus across plies, which LAMINA and MAT8 do not have, is E3 = E2, with ν13 = ν12 and
    ν23 = E2/(2 G23) − 1: fibres in a matrix. Where G23 is too small for that, as of a fabric,
    E3 = 2 (1 + ν) G with ν = ν13 = ν23 = 0.4 and the smaller of G13 and G23. E3 matters to contact
    alone. Axis 1 of a shell without an orientation is the projection of x, as in Abaqus.

    Parameters
    ----------
    path : path
    scale, force, time : float, optional
        The deck's units of length in m, of force in N, and of time in s. The units of modulus and
        density follow, ``force/scale**2`` and ``force*time**2/scale**4``, as solvers take them.
        For mm, N, t, s: ``scale=1e-3``; mm, kN, kg, ms: ``scale=1e-3, force=1e3, time=1e-3``;
        mm, kg, s: ``scale=1e-3, force=1e-3``;
        in, lbf, s: ``scale=0.0254, force=4.44822``.
    given : mapping of str to Material, Orthotropic, Shell, Laminate or Beam, optional
        In SI units, in place of cards: sections by their groups, materials by their names; that of
        Nastran's MAT1 7 is "material 7".

    Returns
    -------
    dict of str to Material, Orthotropic, Shell, Laminate or Beam
        In SI units.

    Raises
    ------
    MeshError
        If the deck cannot be read, or a section is not understood, with file and line.
    InputError, InputTypeError

    Warns
    -----
    AOImpactWarning
        If materials have plasticity, damping and the like, which is left out, or values that are
        those of no solid, as in other units.

    Examples
    --------
    A triangle in millimetres, newtons, tonnes and seconds:

    >>> from tempfile import TemporaryDirectory
    >>> from pathlib import Path
    >>> deck = '''*NODE
    ... 1, 0, 0, 0
    ... 2, 30, 0, 0
    ... 3, 0, 30, 0
    ... *ELEMENT, TYPE=S3, ELSET=SKIN
    ... 1, 1, 2, 3
    ... *SHELL SECTION, ELSET=SKIN, MATERIAL=ALU
    ... 2.
    ... *MATERIAL, NAME=ALU
    ... *ELASTIC
    ... 70000., 0.33
    ... *DENSITY
    ... 2.7E-9'''
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "skin.inp"
    ...     _ = file.write_text(deck)
    ...     sections = ao.read_sections(file, scale=1e-3)
    ...     mesh = ao.read_mesh(file, scale=1e-3, part=list(sections))
    >>> sections["SKIN"].thickness, sections["SKIN"].material
    (0.002, Material(E=70000000000.0, nu=0.33, rho=2700.0))
    >>> ao.FEModel.from_mesh(mesh, sections)
    FEModel(18 dofs, 3 nodes, 1 triangle, 0.00243 kg, free)
    """
    named = {"scale": scale, "force": force, "time": time}
    length, newtons, seconds = (positive(name, one) for name, one in named.items())
    known = instance("given", {} if given is None else given, Mapping)
    for name, one in known.items():
        text("a name of given", name)
        instance(f"given[{name!r}]", one, *get_args(OneMaterial))
    with held_warnings():  # of the mesh: `read_mesh` has them
        raw = load(path)
    where = f"mesh file {os.fspath(path)!r}"
    stress, per_speed = newtons / length / length, seconds / length
    density = stress * per_speed * per_speed
    source = Source(raw, length, stress, density, {key(name): one for name, one in known.items()})
    with held_warnings() as of_no_solid:
        if raw.deck is None:
            raise MeshError(f"{where} is no deck of Abaqus, CalculiX or Nastran")
        found: dict[str, OneMaterial] = raw.deck.read(source)
    if of_no_solid:
        said = of_no_solid[0].partition(":")[0]
        source.left_out.append(f"{said}; give scale=, force=, time= of its units")
    if not found:
        cure = "give materials to from_mesh"
        if raw.deck.elements:
            cure = f"it has {raw.deck.elements}. Write shells as S3 or S4, or {cure}"
        elif source.left_out:
            cure = f"{'; '.join(dict.fromkeys(source.left_out))}. Write bars, or {cure}"
        raise MeshError(f"{where} has no sections of solids, shells or beams; {cure}")
    for name, one in known.items():
        if key(name) not in source.taken:
            instance(f"given[{name!r}]", one, *source.wanted.get(key(name), (object,)))
            known_as = f"; the groups are {', '.join(map(repr, found))}"
            raise InputError(f"given: {name!r} is not in use{nearest(name, found)}{known_as}")
    _refuse_turned(raw, found, where)
    if source.left_out:
        warn(f"{where}: {'; '.join(dict.fromkeys(source.left_out))}")
    return found


def _refuse_turned(raw: RawMesh, found: Mapping[str, OneMaterial], where: str) -> None:
    """Refuse shells that `read_mesh` turns over, where offset or plies are those of one side."""
    sided = []
    for name, of in found.items():
        layers = of.plies if isinstance(of, Laminate) else ()
        plies = [(one.thickness, one.material, one.angle_deg % 180.0) for one in layers]
        over = [(*of_ply, -angle % 180.0) for *of_ply, angle in plies[::-1]]
        sided += [name] * (isinstance(of, Shell | Laminate) and (of.offset != 0.0 or over != plies))
    shells = [i for i, block in enumerate(raw.blocks) if block.kind in ("quad", "triangle")]
    turned = np.zeros(raw.first[-1], dtype=bool)
    cells = [raw.blocks[i].cells for i in shells] if sided else []
    for i, own in zip(shells, against_neighbours(raw.nodes, cells), strict=False):
        turned[raw.first[i] : raw.first[i + 1]] = own
    for name in sided:
        if turned[raw.cell_sets[name]].any():
            why = f"{where}: elements of {name!r} lie against their neighbours"
            raise MeshError(f"{why}, and its plies are of one side; turn them in the mesher")
