"""Writer of K, M and b of a body or AO model as Matrix Market files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from ..base import FilePath, FloatArray, InputTypeError, file_path, sp, writable_folder
from ..contact import ContactPoint
from ..fem import FEModel
from ..reduction import AOModel


def write_matrices(what: FEModel | ContactPoint | AOModel, folder: FilePath) -> dict[str, Path]:
    """Write the matrices of a body, contact point or AO model as Matrix Market files.

    Parameters
    ----------
    what : FEModel, ContactPoint or AOModel
        K and M of a body; for a contact point also b, where u = bᵀX is the displacement of the
        contact. The rows of an AO model's matrices are those of λ: contact mass, then oscillators.
    folder : path
        Folder, made if it does not exist. Files of the same names in it are replaced.

    Returns
    -------
    dict
        The files written: ``"K"`` and ``"M"`` (symmetric, lower triangle, 17 digits) and ``"b"``
        (a dense column). If the dofs of a body's rows are known, also ``"dofs"`` (row, node,
        UX … ROTZ) and ``"nodes"`` (node, x, y, z, m), as `read_matrices` takes them. For an AO
        model also ``"json"``, see `AOModel.to_json`, and ``"deck"``: its masses and springs along
        x as elements MASS, SPRING1 and SPRING2 for CalculiX and Abaqus, with the contact at node 1,
        for ``*INCLUDE`` in a model.

    Raises
    ------
    InputTypeError
        If `what` is no body, contact point or AO model.
    InputError
        If `folder` cannot be written to.

    Examples
    --------
    >>> import tempfile
    >>> model = ao.AOModel(m0=0.1, k0=1e6, m=[0.5], k=[2e6])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(sorted(write_matrices(model, folder)))
    ['K', 'M', 'b', 'deck', 'json']
    """
    if isinstance(what, AOModel):
        matrices: dict[str, Any] = dict(zip("KMb", what.matrices(), strict=True))
    elif isinstance(what, (FEModel, ContactPoint)):
        body = what.body if isinstance(what, ContactPoint) else what
        matrices = {"K": body.K, "M": body.M}
        if isinstance(what, ContactPoint):
            matrices["b"] = what.b
    else:
        raise InputTypeError(f"what must be a body, contact or AOModel, got {type(what).__name__}")
    path = writable_folder(file_path("folder", folder))
    files = {name: path / f"{name}.mtx" for name in matrices}
    for name, matrix in matrices.items():
        column = matrix.ndim == 1
        written = matrix[:, None] if column else sp.coo_array(matrix)
        symmetry = "general" if column else "symmetric"
        with files[name].open("wb") as stream:
            scipy.io.mmwrite(stream, written, symmetry=symmetry)
    if isinstance(what, AOModel):
        files["json"] = path / "model.json"
        what.to_json(files["json"])
        files["deck"] = path / "star.inp"
        files["deck"].write_text(_deck(what))
    else:
        files |= _write_rows(body, path)
    return files


def _deck(star: AOModel) -> str:
    """Return a deck of an AO model's masses and springs; decks allow 20 characters per number."""
    places = range(1, star.n + 2)
    lines = ["** An AO model: the contact is node 1, and all move along x.", "*NODE, NSET=STAR"]
    lines += [f"{i}, 0., 0., 0." for i in places]
    for i, mass in zip(places, [star.m0, *star.m], strict=True):
        if mass > 0.0:
            lines += [f"*ELEMENT, TYPE=MASS, ELSET=M{i}", f"{i}, {i}"]
            lines += [f"*MASS, ELSET=M{i}", f"{mass:.13e}"]
    for i, stiffness in zip(places, [star.k0, *star.k], strict=True):
        if stiffness > 0.0:
            ends, dofs = ("1", "1") if i == 1 else (f"1, {i}", "1, 1")
            lines += [f"*ELEMENT, TYPE=SPRING{min(i, 2)}, ELSET=K{i}", f"{star.n + 1 + i}, {ends}"]
            lines += [f"*SPRING, ELSET=K{i}", dofs, f"{stiffness:.13e}"]
    return "\n".join([*lines, "*BOUNDARY", "STAR, 2, 3", ""])


def _write_rows(body: Any, path: Path) -> dict[str, Path]:
    """Write the files "dofs" and "nodes" if the body has dof labels or nodes; return the paths."""
    files = {}
    labels = body.labels
    if labels is None and body.free is not None:
        rotation, dof = np.divmod(body.free, 3 * len(body.nodes))
        labels = np.stack([dof // 3 + 1, dof % 3 + 1 + 3 * rotation], axis=1)
    if labels is not None:
        files["dofs"] = path / "dofs.txt"
        words = np.array(["NONE", "UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ"])[labels[:, 1]]
        rows = zip(range(1, len(labels) + 1), labels[:, 0], words, strict=True)
        lines = [f"{row} {node} {word}" for row, node, word in rows]
        files["dofs"].write_text("\n".join(["Equation Node Dof", *lines, ""]))
    if body.nodes is not None:
        files["nodes"] = path / "nodes.txt"
        numbers = np.arange(1, len(body.nodes) + 1)
        if body.labels is not None:  # nodes without rows are numbered last
            numbers = body.node_labels.copy()
            others = numbers < 0
            numbers[others] = numbers.max() + 1 + np.arange(others.sum())
        table: FloatArray = np.column_stack([numbers, body.nodes])
        np.savetxt(files["nodes"], table, fmt=["%d", *3 * ["%.17g"]])
    return files
