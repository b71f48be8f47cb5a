"""Bodies from stiffness and mass matrices written by other programs."""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..base import (
    HUGE,
    FilePath,
    FloatArray,
    InputError,
    InputTypeError,
    IntArray,
    SingularError,
    file_path,
    finite_array,
    held_warnings,
    integers,
    require,
    sp,
    warn,
    within,
)
from ..fem import AnyMaterial, Damping, FEModel, OneMaterial, audited, checked_labels
from ..linalg import factorize, sound_matrix
from .entries import is_nodal, is_triples, read_market, read_nodal, read_triples
from .nastran import NastranDeck, read_dmig
from .op4 import is_op4, read_op4
from .raw import RawMatrix, at, codes, columns, naming, repeats, rows_of, spoilt
from .read import existing, load, read_mesh

# Bounds of the units of length, m, and of mass, kg: wide enough for nanometres and nanograms.
_UNITS = 1e-12, 1e12

# Patterns of the names of stiffness matrices (K, KAA, KAAX, KGG, STIFFNESS) and mass matrices (M,
# MAA, MASS).
_NAMES = {
    role: re.compile(rf"(?:{role}(?:([A-Z])\1)?X?|{word}.*)$")
    for role, word in (("K", "STIF"), ("M", "MASS"))
}

# Largest ratio of memory to file size, reached by text with three numbers per entry: both triangles
# and their sum are in memory at once.
_PER_BYTE = 12

# Diagonal stiffness at and above which a dof counts as constrained: Abaqus writes 1e36.
_HOLDING = 1e30

# Dofs without mass are condensed if there are at most this many dofs with mass, since condensation
# makes K a full matrix.
_CONDENSED = 6000

# Numbers of Ansys' components; dofs of other names, such as TEMP, get 0.
_COMPONENTS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}

# Pattern of a line of a mapping file: equation, node, and the component's name or number. Lines of
# .dof files, and of node and component alone, have no equation.
_ROW = re.compile(r"\s*(?:(\d{1,15})\s+)?(-?\d{1,15})(?:\.|[\s,]+)([A-Z]+|\d{1,2})\s*")

# Node labels, and node coordinates in the file's unit; None for labels if the file has only the
# order of the nodes.
Places = tuple[IntArray | None, FloatArray]

File = FilePath | tuple[FilePath, str]


def read_matrices(
    K: File,
    M: File | None = None,
    *,
    dofs: FilePath | Any = None,
    nodes: FilePath | Any = None,
    length: float = 1.0,
    mass: float = 1.0,
    mesh: FilePath | Any = None,
    material: AnyMaterial | Mapping[str, OneMaterial] | None = None,
    damping: Damping | None = None,
    name: str = "",
) -> FEModel:
    """Return the body given by stiffness and mass matrices that another program has written.

    The format is recognised from the content: Matrix Market (also Ansys' ``*EXPORT, , MMF``),
    Abaqus' ``*MATRIX GENERATE`` (MATRIX INPUT or COORDINATE), CalculiX' ``.sti`` and ``.mas`` with
    the ``.dof`` beside them, Nastran's OP4 (text and binary) and punched DMIG, SciPy's ``.npz``.
    Files may hold one triangle or both. Constrained dofs (1e36 in Abaqus) and dofs with neither
    stiffness nor mass are left out. Internal dofs without mass are condensed; so are rotations
    without mass if there are no coordinates.

    Parameters
    ----------
    K, M : path, or (path, name)
        Stiffness and mass, with the matrix's name if the file has several. M is left out if the
        file of K has both. Without a name, the matrix whose name begins with K (or STIF), or with
        M, is taken.
    dofs : path or array_like of int, shape (rows of K, 2), optional
        Node and component (1 … 6) of each row, unless the matrices' files have them: CalculiX'
        ``.dof``, the mapping file of Ansys' ``HBMAT`` (equation, node, UX), or lines of node and
        component.
    nodes : path or array_like, optional
        Coordinates in the file's unit: a deck of the same model (``*NODE`` or GRID), a mesh file,
        lines of label, x, y, z; or an array, shape (n, 4) with labels or (n, 3) without, in
        ascending order of the labels. Used if every row is a displacement or rotation.
    length, mass : float, optional
        Units of the files, in m and kg: millimetres and tonnes (with N and s) are ``length=1e-3,
        mass=1e3``. The unit of time is the second.
    mesh : path, meshio.Mesh or Mesh, optional
        A mesh file in the files' unit (or a mesh in metres) with nodes at the places of the
        matrices' nodes; requires `material`. With a mesh, the contact is a patch of the surface (on
        a shell, a point), the law may be left out, and stresses are available, as with
        `FEModel.from_mesh`. The mesh also gives the coordinates if `nodes` is left out.
    material : Material, Orthotropic, Shell, Laminate, Beam, or mapping of str to these, optional
        Material of `mesh` for contact and stress, as for `FEModel.from_mesh`.
    damping : Rayleigh or ModalDamping, optional
    name : str, optional

    Returns
    -------
    FEModel
        The body, with `labels`, so that ``body.contact(node=123, direction=(0, 0, -1))`` works,
        and with `nodes` if coordinates are known. ``body.audit()`` shows mass, centre, constraints,
        and whether the units are plausible.

    Raises
    ------
    InputError
        If a file is spoilt, cut short or of an unknown format, or if the files are of different
        models; the message names file and line.
    MissingFileError, MemoryLimitError
        If a file does not exist, or is too large for the memory.

    Warns
    -----
    AOImpactWarning
        If density or speed of sound are implausible, as with wrong units; if rows of K, M and
        `nodes` are not in the same order; if K has so few digits that a free body is not free.

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
    metres, kilograms = within("length", length, *_UNITS), within("mass", mass, *_UNITS)
    if (mesh is None) != (material is None):
        raise InputTypeError("mesh and material, of the surface: give both or none")
    stiffness, inertia = _chosen(K, M)
    called = f"{stiffness.called}, {inertia.called}"
    with naming("dofs"):
        labels = _given_labels(dofs, stiffness, inertia)
    with naming(called):
        only = nodes is None and mesh is None
        pair = _free(*_joined(stiffness, inertia, labels), metres, kilograms)
        stiff, heavy, labels = _condensed(*pair, rotations=only)
    places: Places | None = None
    from_file = isinstance(mesh, (str, os.PathLike))
    with naming("nodes"):
        if nodes is not None or from_file:
            places = read_places(mesh if nodes is None else nodes)
        elif mesh is not None:
            solid = read_mesh(mesh)
            places = np.arange(1, solid.n_nodes + 1), solid.nodes / metres
    given: dict[str, Any] = {"K": stiff, "M": heavy, "labels": labels}
    try:
        if places is not None:
            given |= _coordinates(called, given, places, metres)
        body = FEModel(**given, damping=damping, name=name)
    except InputError as error:
        if called in str(error):
            raise
        cause = "is one of the files cut short, printed with few digits, or of another model?"
        raise type(error)(f"{called}: {error}; {cause}") from error
    if mesh is not None and material is not None:
        with naming("mesh"):
            solid = read_mesh(mesh, scale=metres) if from_file else read_mesh(mesh)
            try:
                body = body.with_mesh(solid, material)
            except InputError as error:
                raise InputError(f"{error} The body is at nodes times length={metres:g}") from error
    for doubt in audited(body, frequencies=0).doubts:
        warn(f"{called}: {doubt}")
    return body


# ------------------------------------------------------------------------------ matrix files


def _read_npz(file: Path) -> list[RawMatrix]:
    """Return the matrix in a file of `scipy.sparse.save_npz`."""
    try:
        with zipfile.ZipFile(file) as archive:
            whole = sum(one.file_size for one in archive.infolist())
        require(3 * whole, f"matrix file {str(file)!r}", "take a coarser mesh")
        matrix = sp.coo_array(sound_matrix("it", sp.load_npz(file)))
        matrix.sum_duplicates()
    except Exception as error:  # zipfile, NumPy and SciPy raise various errors for damaged files
        raise spoilt(file, f"it is no square matrix of SciPy, or cut short: {error}") from None
    return [RawMatrix(file, "", matrix)]


# For each format: the test of a file's first bytes, and the function that reads it.
FORMATS: dict[str, tuple[Callable[[bytes], Any], Callable[[Path], list[RawMatrix]]]] = {
    "Matrix Market": (re.compile(rb"(\xef\xbb\xbf)?%%MatrixMarket", re.I).match, read_market),
    "SciPy .npz": (re.compile(rb"PK\x03\x04").match, _read_npz),
    "Nastran OP4": (is_op4, read_op4),
    "Nastran DMIG": (re.compile(rb"^DMIG", re.M | re.I).search, read_dmig),
    "CalculiX .sti and .mas, Abaqus COORDINATE": (is_triples, read_triples),
    "Abaqus MATRIX INPUT": (is_nodal, read_nodal),
}

# For formats that are not read: a mark in a file's first bytes, and the message with advice.
_OTHERS = {
    b"MATLAB 5.0": "of MATLAB; load it with scipy.io.loadmat and make FEModel(K=, M=)",
    b"\x89HDF": "of HDF5; read it with h5py and make FEModel(K=, M=)",
    b"\x93NUMPY": "of NumPy; load it with numpy.load and make FEModel(K=, M=)",
    b"*MATRIX,TYPE=": "of *ELEMENT MATRIX OUTPUT; write *MATRIX GENERATE and *MATRIX OUTPUT",
    b"NASTRAN FORT TAPE": "of OUTPUT2; write OUTPUT4",
}


def load_matrices(file: Path) -> list[RawMatrix]:
    """Return the matrices in a file; its format is recognised from the content.

    Raises
    ------
    MissingFileError, InputError, MemoryLimitError
    """
    head, size = existing("matrix file", file), file.stat().st_size
    require(
        _PER_BYTE * size,
        f"matrix file {str(file)!r} of {size} bytes",
        "take a coarser mesh, or a reduced model of the other program",
    )
    for matches, read in FORMATS.values():
        if matches(head):
            return read(file)
    for mark, cure in _OTHERS.items():
        if mark in head[:4096]:
            raise spoilt(file, f"it is a file {cure}")
    raise spoilt(file, f"its format must be one of these: {'; '.join(FORMATS)}")


def _chosen(K: File, M: File | None) -> tuple[RawMatrix, RawMatrix]:
    """Return the stiffness and the mass matrix that the arguments K and M select from files."""
    read: dict[Path, list[RawMatrix]] = {}
    found: list[RawMatrix] = []
    for role, given in (("K", K), ("M", M)):
        if isinstance(given, tuple) and (len(given) != 2 or not isinstance(given[1], str)):
            raise InputTypeError(f"{role} must be a path, or (path, name of the matrix)")
        given, name = given if isinstance(given, tuple) else (given, "")
        file = found[0].file if given is None and found else file_path(role, given)
        if file not in read:
            with naming(role):
                read[file] = load_matrices(file)
        found.append(_named(role, file, read[file], name.strip().upper()))
    first, second = found
    if first is second:
        raise InputError(f"K and M are one matrix of file {str(first.file)!r}; give M its own")
    return first, second


def _named(role: str, file: Path, matrices: list[RawMatrix], wanted: str) -> RawMatrix:
    """Return the matrix named `wanted` or, without a name, the only one whose name fits `role`."""
    if wanted:
        fit = [one for one in matrices if one.name == wanted]
    elif len(matrices) == 1:
        fit = matrices
        if _NAMES["M" if role == "K" else "K"].match(fit[0].name):
            raise spoilt(file, f"it holds {fit[0].name}, given for {role}: are K and M exchanged?")
    else:
        real = [one for one in matrices if not one.unfit]
        fit = [one for one in real if one.name == role]
        fit = fit or [one for one in real if _NAMES[role].match(one.name)]
    if len(fit) != 1:
        names = ", ".join(one.name or "one without a name" for one in matrices) or "none"
        several = f"{len(fit)} of them may be {role}" if fit else f"none of them is {role}"
        raise spoilt(file, f"its matrices are {names}: {several}; give {role}=(file, name)")
    (found,) = fit
    if found.unfit:
        raise spoilt(file, f"{role} must be real, square; {found.name or 'it'} is {found.unfit}")
    if (rows := found.matrix.shape[0]) > (count := found.matrix.nnz):
        raise spoilt(file, f"{rows} rows have only {count} entries: is it cut short?")
    return found


def _given_labels(dofs: Any, stiffness: RawMatrix, inertia: RawMatrix) -> IntArray | None:
    """Return node and component of each row, from `dofs` or the ``.dof`` file beside a ``.sti``."""
    if dofs is None:
        dofs = stiffness.file.with_suffix(".dof")
        if stiffness.file.suffix.lower() != ".sti" or not dofs.exists():
            return None
    if stiffness.labels is not None or inertia.labels is not None:
        raise InputError(f"dofs: {stiffness.called} itself lists its rows' dofs; leave it out")
    found = read_dofs(dofs)
    if len(found) != stiffness.matrix.shape[0]:
        source = repr(str(dofs)) if isinstance(dofs, (str, os.PathLike)) else "the array"
        of = f"{stiffness.called} {stiffness.matrix.shape[0]} rows"
        raise InputError(f"dofs: {source} has {len(found)} dofs, {of}: is one cut short?")
    return checked_labels(found, len(found))


# --------------------------------------------------------------------------- matching K and M

_Pair = tuple[Any, Any, IntArray | None]  # K, M, and node and component of each row


def _joined(stiffness: RawMatrix, inertia: RawMatrix, labels: IntArray | None) -> _Pair:
    """Return K and M with the same order of rows; refuse equal or exchanged matrices."""
    K, M = stiffness.matrix, inertia.matrix
    if (stiffness.labels is None) != (inertia.labels is None):
        raise InputError("only one of K and M names the dofs of its rows; both or none must")
    if stiffness.labels is not None and inertia.labels is not None:
        labels = stiffness.labels
        rows = rows_of(codes(labels), codes(inertia.labels))
        for lost in np.flatnonzero(rows < 0)[:1].tolist():
            raise InputError(f"K lacks dofs of M, as {at(inertia.labels, lost)}: is it cut short?")
        M = sp.coo_array((M.data, tuple(rows[at] for at in M.coords)), shape=K.shape)
        inertia = replace(inertia, matrix=M, labels=labels)
    elif K.shape != M.shape:
        raise InputError(f"K has {K.shape[0]} rows and M {M.shape[0]}: is one cut short?")
    K, M = stiffness.symmetric(), inertia.symmetric()
    for name, matrix in (("K", K), ("M", M)):
        without = np.flatnonzero((matrix.diagonal() == 0.0) & (abs(matrix).sum(axis=1) > 0.0))
        if name == "K" and labels is not None:  # Abaqus' internal nodes may lack stiffness
            without = without[labels[without, 0] > 0]
        for row in without[:1].tolist():
            more = f"and of {len(without) - 1} more rows: is the file cut short?"
            raise InputError(f"{name} lacks the diagonal of {at(labels, row)} {more}")
    if K.nnz == M.nnz and not (K - M).data.any():
        raise InputError("K and M have the same entries; give M its own file")
    largest, heaviest = (float(abs(one.diagonal()).max(initial=0.0)) for one in (K, M))
    if 0.0 < largest < heaviest:  # all frequencies would be below 1 rad/s
        raise InputError(f"K is up to {largest:.3g}, M up to {heaviest:.3g}: are they exchanged?")
    return K, M, labels


def _kept(K: Any, M: Any, labels: IntArray | None, rows: Any) -> _Pair:
    return K[rows][:, rows], M[rows][:, rows], None if labels is None else labels[rows]


def _free(K: Any, M: Any, labels: IntArray | None, length: float, mass: float) -> _Pair:
    """Return K and M in SI units, without dofs that are constrained or have only zero entries."""
    # Rows with NaN are kept here; `FEModel` refuses them.
    keep = ~((K.diagonal() >= _HOLDING) | ((abs(K) + abs(M)).sum(axis=1) == 0.0))
    if not keep.any():
        raise InputError("some dof must have stiffness or mass, and be free to move")
    K, M, labels = _kept(K, M, labels, keep)
    if labels is not None:  # rows of rotations are moments, in force × length
        D = sp.diags_array(np.where(labels[:, 1] > 3, length, 1.0))
        K, M = D @ K @ D, D @ M @ D
    return sp.csr_array(mass * K), sp.csr_array(mass * M), labels


def _condensed(K: Any, M: Any, labels: IntArray | None, *, rotations: bool) -> _Pair:
    """Condense inner dofs without mass: K becomes K_aa - K_ai K_ii⁻¹ K_ia, which is exact.

    Models with more than `_CONDENSED` dofs with mass keep their inner dofs, and then have no
    coordinates. Rotations count as inner dofs only if `rotations` is true.
    """
    light = abs(M).sum(axis=1) == 0.0
    inner = np.zeros_like(light)
    if labels is not None:
        inner = (labels[:, 0] <= 0) | (labels[:, 1] > 3)
        light &= rotations | (labels[:, 1] <= 3)
    if not light.any() or (~light).sum() > _CONDENSED:
        return K, M, labels
    if (light & ~inner).any():
        first = at(labels, int(np.flatnonzero(light)[0]))
        why = f"{light.sum()} of {len(light)} dofs have no mass, the first is {first}"
        raise InputError(f"{why}: is M cut short? Write a consistent mass matrix")
    across = K[light][:, ~light].toarray()
    try:
        solved = factorize(K[light][:, light], what="K of the dofs without mass").solve(across)
    except SingularError as error:
        why = f"{light.sum()} dofs without mass cannot be condensed ({error})"
        raise InputError(f"{why}; model without Lagrange multipliers of couplings") from None
    K, M, labels = _kept(K, M, labels, ~light)
    full = K.toarray() - across.T @ solved
    return sp.csr_array(0.5 * (full + full.T)), M, labels


def _coordinates(
    called: str, given: dict[str, Any], places: Places, length: float
) -> dict[str, Any]:
    """Return `nodes` and `free` of `FEModel`; {} if a row is no displacement or rotation."""
    numbers, where = places
    labels, size = given["labels"], given["K"].shape[0]
    if labels is None:
        if size != 3 * len(where):
            raise InputError(f"nodes: {len(where)} do not fit {size} rows of {called}; give dofs")
        return {"nodes": length * where}
    if (labels[:, 1] < 1).any():
        return {}
    used = np.unique(labels[:, 0])
    if numbers is None:
        if len(where) != len(used):
            of = f"{len(used)} nodes of {called}"
            raise InputError(f"nodes has {len(where)} rows for {of}; give labels, shape (n, 4)")
        numbers = used
    missing = np.setdiff1d(used, numbers)
    if len(missing):
        cure = "Is it another model's file? Of CalculiX' C3D8I, with inner nodes, leave nodes out"
        of = f"{len(missing)} nodes of {called}, the first {missing[0]},"
        raise InputError(f"nodes: {of} are not there. {cure}")
    # Nodes without rows would count as fixed, so they are dropped if the body is free without them.
    if len(numbers) > len(used) and FEModel(**given).mass is not None:
        keep = np.isin(numbers, used)
        numbers, where = numbers[keep], where[keep]
    rotation, component = np.divmod(labels[:, 1] - 1, 3)
    node = np.searchsorted(numbers, labels[:, 0])
    return {
        "nodes": length * where,
        "free": 3 * (node + len(numbers) * rotation) + component,
    }


# -------------------------------------------------------------- dofs and coordinates of rows


def read_dofs(dofs: Any) -> IntArray:
    """Return node and component of each row, shape (n, 2), from a file or an array.

    The file is CalculiX' ``.dof``, the mapping file of Ansys, or lines of node and component.

    Raises
    ------
    InputTypeError, InputError, MissingFileError
    """
    if not isinstance(dofs, str) and not hasattr(dofs, "__fspath__"):
        what = "a file, or pairs of integers, node and component"
        return integers("dofs", dofs, what, shape=(None, 2))
    file = file_path("dofs", dofs)
    existing("matrix file", file)
    text = file.read_text(encoding="latin-1")
    rows: list[tuple[Any, ...]] = []
    for line, content in enumerate(text.splitlines(), 1):
        if row := _ROW.fullmatch(content):
            rows.append(row.groups())
        elif content.strip() and rows and not rows[0][0]:
            raise spoilt(file, f"a dof such as 123.1 is expected, got {content[:60]!r}", line)
    if not rows:
        raise spoilt(file, "it must have lines such as 123.1, or such as 1 123 UX")
    words = [int(word) if word.isdigit() else _COMPONENTS.get(word, 0) for *_, word in rows]
    found = np.stack([[int(node) for _, node, _ in rows], words], axis=1)
    equations = np.array([int(equation or 0) for equation, *_ in rows])
    if not equations.any():
        return found
    for wrong in np.flatnonzero(np.sort(equations) != np.arange(1, len(rows) + 1))[:1]:
        raise spoilt(file, f"equation {wrong + 1} must be there once: is it cut short?")
    return found[np.argsort(equations)]


def read_places(nodes: Any) -> Places:
    """Return labels and coordinates of nodes, from a file or an array.

    Parameters
    ----------
    nodes : path or array_like
        A deck of Abaqus, CalculiX or Nastran (GRID), lines of label, x, y, z, or another mesh file
        (labels 1, 2, …); or an array, shape (n, 4), of labels and coordinates, or (n, 3).

    Raises
    ------
    InputError, InputTypeError, MeshError
    """
    if not isinstance(nodes, str) and not hasattr(nodes, "__fspath__"):
        array = finite_array("nodes", nodes, shape=(None, None), most=HUGE)
        if array.shape[1] == 3:
            return None, array
        if array.shape[1] != 4:
            raise InputError(f"nodes must have 3 or 4 columns, got shape {array.shape}")
        return _labelled("nodes", array)
    file = file_path("nodes", nodes)
    table = None if b"\0" in existing("mesh file", file)[:4096] else _lines(file)
    if table is None:
        with held_warnings():  # warnings about elements, which are not used here
            raw = load(file)
        if raw.deck is None:
            mesh = read_mesh(file)
            return np.arange(1, mesh.n_nodes + 1), mesh.nodes
        if isinstance(raw.deck, NastranDeck):
            raw.deck.grids.check_output(raw.nodes)
        if raw.node_labels is None or not len(raw.nodes):
            raise spoilt(file, "it has no nodes")
        table = np.column_stack([raw.node_labels, raw.nodes])
    return _labelled(f"nodes {str(file)!r}", table)


def _labelled(where: str, table: FloatArray) -> Places:
    labels, order = table[:, 0].astype(np.int64), np.argsort(table[:, 0], kind="stable")
    if (labels != table[:, 0]).any():
        raise InputError("nodes: the first of four columns must be integer labels")
    for twice in labels[repeats(labels)][:1]:
        raise InputError(f"{where}: node {twice} is there twice; give one part")
    return labels[order], table[order, 1:]


def _lines(file: Path) -> FloatArray | None:
    """Return the node numbers and coordinates x, y, z, shape (n_nodes, 4), from a file.

    Every line begins with these four values, as Ansys' NWRITE writes it; None for other files.
    """
    text = file.read_text(encoding="latin-1")
    rows = [line.replace(",", " ").split()[:4] for line in text.splitlines() if line.strip()]
    if not rows or any(len(row) < 4 or not row[0].isdigit() for row in rows):
        return None
    table = columns([" ".join(row) for row in rows], 4)
    if table is None:
        raise spoilt(file, "label, x, y and z of nodes cannot be read, or are too large")
    return table
