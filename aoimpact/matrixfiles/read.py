"""A body from the stiffness and mass matrices that another program has written."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import (
    InputError,
    InputTypeError,
    IntArray,
    MeshError,
    SingularError,
    file_path,
    positive,
    warn,
)
from ..fem import Damping, FEModel, Material, audited, checked_labels
from ..linalg import factorize
from ..mesh import read_mesh
from .dofs import read_dofs
from .formats import read_file
from .found import Found, entry_line, spoilt, symmetric
from .places import Places, read_places

__all__ = ["read_matrices"]

# Abaqus holds a dof by a stiffness of 1e36 on its diagonal.
_HOLDING = 1e30

# A highest frequency below 1 rad/s is that of no body that is struck: K and M are exchanged.
_LEAST_OMEGA2 = 1.0

# Up to so many dofs with mass, those without are condensed: K becomes a full matrix.
_CONDENSED = 6000

# Units of length and mass, in m and kg: from nanometres and -grams to beyond any.
_UNITS = 1e-12, 1e12

# Names of matrices: K, KAA, KAAX, KGG, STIFFNESS; M, MAA, MASS.
_NAMES = {
    role: re.compile(rf"(?:{role}(?:([A-Z])\1)?X?|{word}.*)$")
    for role, word in (("K", "STIF"), ("M", "MASS"))
}

File = str | os.PathLike[str] | tuple[str | os.PathLike[str], str]


@dataclass(frozen=True, eq=False)
class _Pair:
    """Matrices of the same rows, what the rows are called, and which are constrained."""

    K: Any
    M: Any
    labels: IntArray | None
    called: str


def read_matrices(
    K: File,
    M: File | None = None,
    *,
    dofs: Any = None,
    nodes: Any = None,
    length: float = 1.0,
    mass: float = 1.0,
    mesh: Any = None,
    material: Material | None = None,
    damping: Damping | None = None,
    name: str = "",
) -> FEModel:
    """Return the body of stiffness and mass matrices that another program has written.

    The format is found from the content: Matrix Market (so Ansys' ``*EXPORT, , MMF``), Abaqus'
    ``*MATRIX GENERATE`` (MATRIX INPUT or COORDINATE), CalculiX' ``.sti`` and ``.mas`` with the
    ``.dof`` beside them, Nastran's OP4 (text and binary) and punched DMIG, SciPy's ``.npz``. One
    triangle or both may be there. Dofs that are constrained (Abaqus' 1e36), and those with neither
    stiffness nor mass, are left out; internal dofs and rotations without mass are condensed.

    Parameters
    ----------
    K, M : path, or (path, name)
        Stiffness and mass; with a name where the file has several matrices. M is left out where
        the file of K has both. Of several matrices without a name given, the one is taken that
        begins with K (or STIF), or with M.
    dofs : path or array_like of int, shape (rows of K, 2), optional
        Node and component (1 … 6) of each row, where the matrices do not have it: CalculiX'
        ``.dof``, the mapping file of Ansys' ``HBMAT`` (equation, node, UX), or lines of node and
        component.
    nodes : path or array_like, optional
        Coordinates in the file's unit: a deck of the same model (``*NODE`` or GRID), a mesh file,
        lines of label, x, y, z; or an array: (n, 4) with labels, (n, 3) without, in
        ascending order of the labels. Used where every row is a displacement x, y or z.
    length, mass : float, optional
        The files' units, in m and kg: millimetres and tonnes (with N and s) are ``length=1e-3,
        mass=1e3``. The unit of time is the second.
    mesh : path, meshio.Mesh or Mesh, optional
        A mesh file in the files' unit (or a mesh in metres) whose nodes are those of the matrices,
        by their places; with the `material` of its surface. Then the contact is a patch of the
        surface, the law may be left out, and there are stresses, as of `FEModel.from_mesh`. Where
        `nodes` is left out they are this file's.
    material : Material, optional
    damping : Rayleigh or ModalDamping, optional
    name : str, optional

    Returns
    -------
    FEModel
        With `labels`, so that ``body.contact(node=123, direction=(0, 0, -1))`` works, and, of
        known coordinates, `nodes`. ``body.audit()`` shows mass, centre, what is constrained,
        and whether the units are those of a body.

    Raises
    ------
    InputError
        If a file is spoilt, cut short, of an unknown format, or not of the same model as the
        other; the message names file and line.
    MissingFileError, MemoryLimitError
        If a file is not there, or too large for the memory.

    Warns
    -----
    AOImpactWarning
        If density or speed of sound are not those of a body: wrong units; if rows of K, M and
        `nodes` are not in one order; if K has so few digits that a free body is not free.

    Examples
    --------
    >>> import tempfile
    >>> mesh = ao.box_mesh((1, 0.1, 0.1), (8, 1, 1))
    >>> body = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     files = ao.write_matrices(body, folder)
    ...     read_matrices(files["K"], files["M"], nodes=body.nodes)
    FEModel(108 dofs, 36 nodes, 27 kg, free)
    """
    units = _unit("length", length, "m"), _unit("mass", mass, "kg")
    if (mesh is None) != (material is None):
        raise InputTypeError("mesh and material, of the surface: give both or none")
    stiffness, inertia = _chosen(K, M)
    with _naming("dofs"):
        labels = _labels(dofs, stiffness, inertia)
    pair = _without_held(_joined(stiffness, inertia, labels))
    _check_order(pair)
    pair = _condensed(_scaled(pair, *units))
    with _naming("nodes"):
        places = _places(nodes, mesh, units[0])
    body = _body(pair, places, units[0], damping, name)
    if mesh is not None and material is not None:
        with _naming("mesh"):
            scaled = isinstance(mesh, (str, os.PathLike))
            solid = read_mesh(mesh, scale=units[0]) if scaled else read_mesh(mesh)
            try:
                body = body.with_mesh(solid, material)
            except InputError as error:
                raise InputError(
                    f"{error} It lies there by nodes and length={units[0]:g}"
                ) from error
    for doubt in audited(body, frequencies=0).doubts:
        warn(f"{pair.called}: {doubt}")
    return body


def _places(nodes: Any, mesh: Any, length: float) -> Places | None:
    """Where the nodes are, in the files' unit: as given, or those of the mesh."""
    if nodes is not None or mesh is None:
        return None if nodes is None else read_places(nodes)
    if isinstance(mesh, (str, os.PathLike)):
        return read_places(mesh)
    solid = read_mesh(mesh)
    return np.arange(1, solid.n_nodes + 1), solid.nodes / length


def _unit(name: str, value: float, unit: str) -> float:
    size = positive(name, value, unit=unit)
    if not _UNITS[0] <= size <= _UNITS[1]:
        raise InputError(f"{name} must be a unit, from {_UNITS[0]:g} to {_UNITS[1]:g} {unit}")
    return size


@contextmanager
def _naming(argument: str) -> Iterator[None]:
    """Begin errors of a file with the argument that it was given for."""
    try:
        yield
    except (InputError, MeshError) as error:
        said = str(error)
        if said.startswith(argument):
            raise
        raise type(error)(f"{argument}: {said}") from error


# --------------------------------------------------------------------------------- files


def _chosen(K: File, M: File | None) -> tuple[Found, Found]:
    """The matrices that are meant, of the files' ones."""
    stiffness, wanted = _file("K", K)
    inertia, also_wanted = (stiffness, "") if M is None else _file("M", M)
    with _naming("K"):
        read = {stiffness: read_file(stiffness)}
    if inertia == stiffness and len(read[stiffness]) == 1:
        raise InputError(
            f"K and M are the same file {str(stiffness)!r}, which has one matrix; give M its own"
        )
    if inertia not in read:
        with _naming("M"):
            read[inertia] = read_file(inertia)
    found = _named("K", stiffness, read[stiffness], wanted)
    other = _named("M", inertia, read[inertia], also_wanted)
    if found is other:
        raise InputError(f"K and M are the same matrix {found.called}")
    return found, other


def _file(role: str, given: File) -> tuple[Path, str]:
    if isinstance(given, tuple):
        if len(given) != 2 or not isinstance(given[1], str):
            raise InputTypeError(f"{role} must be a path, or (path, name of the matrix)")
        return file_path(role, given[0]), given[1].strip().upper()
    return file_path(role, given), ""


def _named(role: str, file: Path, matrices: list[Found], wanted: str) -> Found:
    """The matrix of a file that is asked for, or the only one with a fitting name."""
    if wanted:
        chosen = [one for one in matrices if one.name == wanted]
    elif len(matrices) == 1:
        chosen = matrices
        other = "M" if role == "K" else "K"
        if chosen[0].name and _NAMES[other].match(chosen[0].name):
            raise spoilt(
                file, f"it holds {chosen[0].name}, given for {role}: are K and M exchanged?"
            )
    else:
        fit = [one for one in matrices if not one.unfit]
        exact = [one for one in fit if one.name == role]
        chosen = exact or [one for one in fit if _NAMES[role].match(one.name)]
    if len(chosen) != 1:
        names = ", ".join(one.name or "one without a name" for one in matrices) or "none"
        several = f"{len(chosen)} of them may be {role}" if chosen else f"none of them is {role}"
        raise spoilt(file, f"its matrices are {names}: {several}; give {role}=(file, name)")
    found = chosen[0]
    if found.unfit:
        raise spoilt(file, f"{found.name or 'its matrix'} is {found.unfit}; {role} is real, square")
    if found.size is None or found.size > len(found.values):
        raise spoilt(
            file,
            f"{found.name or 'its matrix'} has {found.size} rows, but {len(found.values)} entries, "
            "not one on each row's diagonal: is the file cut short?",
        )
    return found


def _labels(dofs: Any, stiffness: Found, inertia: Found) -> IntArray | None:
    """The labels that were given, or that stand beside CalculiX' files."""
    if dofs is None:
        beside = stiffness.file.with_suffix(".dof")
        if stiffness.file.suffix.lower() != ".sti" or not beside.exists():
            return None
        dofs = beside
    if stiffness.labels is not None or inertia.labels is not None:
        raise InputError(
            f"dofs: {stiffness.called} itself lists which dofs its rows are; leave it out"
        )
    found = read_dofs(dofs)
    if len(found) != stiffness.size:
        source = f"{str(dofs)!r}" if isinstance(dofs, (str, os.PathLike)) else "the array"
        short = source
        if stiffness.size is not None and stiffness.size < len(found):
            short = f"{str(stiffness.file)!r}"
            if stiffness.before is not None:
                end = entry_line(stiffness.file, stiffness.before, len(stiffness.values))
                short += f", which ends with line {end},"
        raise InputError(
            f"dofs: {source} has {len(found)} dofs, but {stiffness.called} {stiffness.size} rows: "
            f"is {short} cut short, or is one of them of another model?"
        )
    return checked_labels(found, len(found))


# ------------------------------------------------------------------------------ matrices


def _joined(stiffness: Found, inertia: Found, given: IntArray | None) -> _Pair:
    """Both matrices in the same rows."""
    called = f"{stiffness.called}, {inertia.called}"
    if (stiffness.labels is None) != (inertia.labels is None):
        raise InputError(f"{called}: only one of them lists which dofs its rows are")
    if stiffness.labels is None or inertia.labels is None:
        size = stiffness.size
        if size != inertia.size or size is None:
            raise InputError(
                f"{called}: K has {stiffness.size} rows and M {inertia.size}: is one of them cut "
                "short, or of another model?"
            )
        return _Pair(symmetric(stiffness, size), symmetric(inertia, size), given, called)
    both = np.concatenate([stiffness.labels, inertia.labels])
    labels, places = np.unique(both, axis=0, return_inverse=True)
    places = places.ravel()
    parts = places[: len(stiffness.labels)], places[len(stiffness.labels) :]
    without = np.setdiff1d(parts[1], parts[0])
    if len(without):
        node, component = labels[without[0]]
        raise InputError(
            f"{called}: M has {len(without)} dofs that K has not, the first is {node}.{component}: "
            "is K cut short, or of another model?"
        )
    made = [
        symmetric(
            replace(one, rows=rows[one.rows], cols=rows[one.cols], labels=labels), len(labels)
        )
        for one, rows in zip((stiffness, inertia), parts, strict=True)
    ]
    return _Pair(made[0], made[1], labels, called)


def _kept(pair: _Pair, rows: Any) -> _Pair:
    if rows.all():
        return pair
    labels = None if pair.labels is None else pair.labels[rows]
    return replace(pair, K=pair.K[rows][:, rows], M=pair.M[rows][:, rows], labels=labels)


def _without_held(pair: _Pair) -> _Pair:
    """The pair without dofs that are constrained, and those with neither stiffness nor mass."""
    diagonal = pair.K.diagonal()
    stiff = np.asarray(abs(pair.K).sum(axis=1)).ravel()
    heavy = np.asarray(abs(pair.M).sum(axis=1)).ravel()
    keep = (diagonal < _HOLDING) & ((stiff > 0.0) | (heavy > 0.0))
    if not keep.any():
        raise InputError(f"{pair.called}: no dof has stiffness or mass and is free to move")
    return _kept(pair, keep)


def _check_order(pair: _Pair) -> None:
    """Refuse a mass in the place of the stiffness, and rows that have lost their diagonal."""
    of_mass = pair.M.diagonal()
    for name, matrix in (("K", pair.K), ("M", pair.M)):
        size = np.asarray(abs(matrix).sum(axis=1)).ravel()
        without = np.flatnonzero((matrix.diagonal() == 0.0) & (size > 0.0))
        if len(without) and not (name == "K" and _multiplier(pair, int(without[0]))):
            raise InputError(
                f"{pair.called}: {name} has no entry on the diagonal of {_at(pair, without[0])}, "
                f"but others in its row ({len(without)} such rows): is the file cut short?"
            )
    if pair.K.nnz == pair.M.nnz and not (pair.K - pair.M).data.any():
        raise InputError(f"{pair.called}: K and M have the same entries; give M its own file")
    largest = float(np.abs(pair.K.diagonal()).max(initial=0.0))
    heaviest = float(np.abs(of_mass).max(initial=0.0))
    if 0.0 < largest < _LEAST_OMEGA2 * heaviest:
        raise InputError(
            f"{pair.called}: entries of K are up to {largest:.3g} and those of M up to "
            f"{heaviest:.3g}, so that no frequency reaches 1 rad/s: are K and M exchanged?"
        )


def _at(pair: _Pair, row: int) -> str:
    """A row as its program calls it."""
    if pair.labels is None:
        return f"row {row + 1}"
    node, component = pair.labels[row]
    return f"dof {node}.{component}"


def _multiplier(pair: _Pair, row: int) -> bool:
    """Whether a row without stiffness of its own is one of Abaqus' internal ones."""
    return pair.labels is not None and bool(pair.labels[row, 0] <= 0)


def _scaled(pair: _Pair, length: float, mass: float) -> _Pair:
    """The pair in SI units: what belongs to rotations is a moment, of one length more."""
    D = None
    if pair.labels is not None and (pair.labels[:, 1] > 3).any():
        D = sp.diags_array(np.where(pair.labels[:, 1] > 3, length, 1.0))
    scaled = [mass * one if D is None else mass * (D @ one @ D) for one in (pair.K, pair.M)]
    return replace(pair, K=sp.csr_array(scaled[0]), M=sp.csr_array(scaled[1]))


def _condensed(pair: _Pair) -> _Pair:
    """The pair without inner dofs that have no mass: K̂ = K_aa - K_ai K_ii⁻¹ K_ia, exact."""
    light = np.asarray(abs(pair.M).sum(axis=1)).ravel() == 0.0
    if not light.any():
        return pair
    at, inner = _at(pair, int(np.flatnonzero(light)[0])), np.zeros_like(light)
    if pair.labels is not None:
        inner = (pair.labels[:, 0] <= 0) | (pair.labels[:, 1] > 3)
    if (light & ~inner).any() or (~light).sum() > _CONDENSED:
        raise InputError(
            f"{pair.called}: {light.sum()} of {len(light)} dofs have no mass, the first is {at}: "
            "is M cut short, or lumped? Write a consistent mass matrix, or condense these dofs "
            "where the model is made (here only rotations and internal dofs are, beside up to "
            f"{_CONDENSED} others)"
        )
    K = pair.K
    across = K[light][:, ~light].toarray()
    try:
        solved = factorize(K[light][:, light], what="K of the dofs without mass").solve(across)
    except SingularError as error:
        raise InputError(
            f"{pair.called}: {light.sum()} dofs have no mass and cannot be condensed ({error}): "
            "multipliers of constraints, of hybrid elements or couplings? Model without them"
        ) from None
    kept = _kept(pair, ~light)
    full = kept.K.toarray() - across.T @ solved
    return replace(kept, K=sp.csr_array(0.5 * (full + full.T)))


# ---------------------------------------------------------------------------------- body


def _body(
    pair: _Pair, places: Places | None, length: float, damping: Damping | None, name: str
) -> FEModel:
    given: dict[str, Any] = {"K": pair.K, "M": pair.M, "damping": damping, "name": name}
    if pair.labels is not None:
        given["labels"] = pair.labels
    if places is not None:
        given |= _coordinates(pair, places, length)
    try:
        return FEModel(**given)
    except InputError as error:
        cause = "is one of the files cut short, printed with few digits, or of another model?"
        raise type(error)(f"{pair.called}: {error}; {cause}") from error


def _coordinates(pair: _Pair, places: Places, length: float) -> dict[str, Any]:
    """The keywords `nodes` and `free` of a body whose rows are displacements x, y, z."""
    numbers, where = places
    size = pair.K.shape[0]
    if pair.labels is None:
        if size != 3 * len(where):
            raise InputError(
                f"nodes: {len(where)} nodes have {3 * len(where)} dofs, but {pair.called} {size} "
                "rows; give dofs, which says what the rows are"
            )
        return {"nodes": length * where}
    if ((pair.labels[:, 1] < 1) | (pair.labels[:, 1] > 3)).any():
        return {}
    used = np.unique(pair.labels[:, 0])
    if numbers is None:
        if len(where) != len(used):
            raise InputError(
                f"nodes has {len(where)} rows, but the matrices have {len(used)} nodes; give "
                "labels and coordinates, shape (n, 4)"
            )
        numbers = used
    missing = np.setdiff1d(used, numbers)
    if len(missing):
        cause = "is it another model's file?"
        if missing[0] > numbers.max():
            cause = (
                f"are they inner ones of elements (as of CalculiX' C3D8I), numbered after the last "
                f"node, {numbers.max()}? Take elements without, or leave nodes out and give each "
                "contact its node and direction; else it is another model's file"
            )
        raise InputError(
            f"nodes: {len(missing)} nodes of {pair.called} are not there, the first is "
            f"{missing[0]}: {cause}"
        )
    if len(numbers) > len(used) and _moves_without(pair):
        keep = np.isin(numbers, used)
        numbers, where = numbers[keep], where[keep]
    free = 3 * np.searchsorted(numbers, pair.labels[:, 0]) + pair.labels[:, 1] - 1
    return {"nodes": length * where, "free": free}


def _moves_without(pair: _Pair) -> bool:
    """Whether nodes that have no rows hold nothing: a body that is free does not feel them."""
    return _body(pair, None, 1.0, None, "").mass is not None
