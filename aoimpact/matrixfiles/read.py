"""A body from the stiffness and mass matrices that another program has written."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base import InputError, InputTypeError, positive, warn
from ..fem import AnyMaterial, Damping, FEModel, OneMaterial, audited
from ..mesh import read_mesh
from .choose import File, chosen, given_labels, naming
from .pair import Pair, check_exchange, condensed, joined, scaled, without_held
from .places import Places, read_places

# Units of length and mass, in m and kg: from nanometres and -grams to beyond any.
_UNITS = 1e-12, 1e12


def read_matrices(
    K: File,
    M: File | None = None,
    *,
    dofs: Any = None,
    nodes: Any = None,
    length: float = 1.0,
    mass: float = 1.0,
    mesh: Any = None,
    material: AnyMaterial | Mapping[str, OneMaterial] | None = None,
    damping: Damping | None = None,
    name: str = "",
) -> FEModel:
    """Return the body of stiffness and mass matrices that another program has written.

    The format is found from the content: Matrix Market (so Ansys' ``*EXPORT, , MMF``), Abaqus'
    ``*MATRIX GENERATE`` (MATRIX INPUT or COORDINATE), CalculiX' ``.sti`` and ``.mas`` with the
    ``.dof`` beside them, Nastran's OP4 (text and binary) and punched DMIG, SciPy's ``.npz``. One
    triangle or both may be there. Dofs that are constrained (Abaqus' 1e36), and those with neither
    stiffness nor mass, are left out; internal dofs without mass are condensed, and rotations
    without mass where there are no coordinates.

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
        ascending order of the labels. Used where every row is a displacement or rotation.
    length, mass : float, optional
        The files' units, in m and kg: millimetres and tonnes (with N and s) are ``length=1e-3,
        mass=1e3``. The unit of time is the second.
    mesh : path, meshio.Mesh or Mesh, optional
        A mesh file in the files' unit (or a mesh in metres) whose nodes are those of the matrices,
        by their places; with its `material`. Then the contact is a patch of the surface, of a
        shell a place on it, the law may be left out, and there are stresses, as of
        `FEModel.from_mesh`. Where `nodes` is left out they are this file's.
    material : Material, Orthotropic, Shell, Laminate, Beam, or mapping of str to these, optional
        As for `FEModel.from_mesh`, for contact and stress.
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
    stiffness, inertia = chosen(K, M)
    with naming("dofs"):
        labels = given_labels(dofs, stiffness, inertia)
    pair = without_held(joined(stiffness, inertia, labels))
    check_exchange(pair)
    pair = condensed(scaled(pair, *units), rotations=nodes is None and mesh is None)
    with naming("nodes"):
        places = _places(nodes, mesh, units[0])
    body = _body(pair, places, units[0], damping, name)
    if mesh is not None and material is not None:
        with naming("mesh"):
            from_file = isinstance(mesh, (str, os.PathLike))
            solid = read_mesh(mesh, scale=units[0]) if from_file else read_mesh(mesh)
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
    """Coordinates of the nodes in the files' unit: as given, or those of the mesh."""
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


def _body(
    pair: Pair, places: Places | None, length: float, damping: Damping | None, name: str
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


def _coordinates(pair: Pair, places: Places, length: float) -> dict[str, Any]:
    """The keywords `nodes` and `free` of a body whose rows are displacements and rotations."""
    numbers, where = places
    size = pair.K.shape[0]
    if pair.labels is None:
        if size != 3 * len(where):
            raise InputError(
                f"nodes: {len(where)} nodes do not have the {size} rows of {pair.called}; give dofs"
            )
        return {"nodes": length * where}
    if (pair.labels[:, 1] < 1).any():
        return {}
    used = np.unique(pair.labels[:, 0])
    if numbers is None:
        if len(where) != len(used):
            raise InputError(
                f"nodes has {len(where)} rows for {len(used)} nodes; give labels, shape (n, 4)"
            )
        numbers = used
    missing = np.setdiff1d(used, numbers)
    if len(missing):
        cause = "is it another model's file?"
        if missing[0] > numbers.max():
            cause = (
                "are they inner nodes of elements, as of CalculiX' C3D8I? Take other elements, or "
                "leave nodes out"
            )
        raise InputError(
            f"nodes: {len(missing)} nodes of {pair.called} are not there, the first is "
            f"{missing[0]}: {cause}"
        )
    # Nodes without rows are no supports if the body is free without them.
    if len(numbers) > len(used) and _body(pair, None, 1.0, None, "").mass is not None:
        keep = np.isin(numbers, used)
        numbers, where = numbers[keep], where[keep]
    rotation, component = np.divmod(pair.labels[:, 1] - 1, 3)
    node = np.searchsorted(numbers, pair.labels[:, 0])
    free = 3 * (node + len(numbers) * rotation) + component
    return {"nodes": length * where, "free": free}
