"""Dofs of the rows of matrices, and places of their nodes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..base import (
    HUGE,
    FloatArray,
    InputError,
    IntArray,
    file_path,
    finite_array,
    held_warnings,
    integers,
)
from .abaqusdeck import looks_like_inp
from .load import existing, load
from .matrix import spoilt
from .nastran import NastranDeck
from .nastrandeck import is_nastran
from .raw import columns
from .read import read_mesh

# Ansys' words for components; others have no direction.
_COMPONENTS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}

# A row of a mapping file: the equation, the node, and the component's word or number.
_MAPPED = re.compile(r"^\s*(\d{1,15})\s+(-?\d{1,15})\s+([A-Z]+|\d{1,2})\s*$", re.MULTILINE)

# A line of a .dof file, or of one of pairs.
_PAIR = re.compile(r"^\s*(-?\d{1,15})(?:\.|[\s,]+)(\d{1,2})\s*$")

# Labels, or None where nodes have none but their order; and coordinates in the file's unit.
Places = tuple[IntArray | None, FloatArray]


def read_dofs(dofs: Any) -> IntArray:
    """Return node and component of each row, shape (n, 2), from a file or an array.

    A file is CalculiX' ``.dof``, the mapping file of Ansys, or lines of node and component.

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
    if mapped := _MAPPED.findall(text):
        words = [int(word) if word.isdigit() else _COMPONENTS.get(word, 0) for *_, word in mapped]
        equations = np.array([int(equation) for equation, *_ in mapped])
        for wrong in np.flatnonzero(np.sort(equations) != np.arange(1, len(mapped) + 1))[:1]:
            raise spoilt(file, f"equation {wrong + 1} is not there once: is it cut short?")
        nodes = [int(node) for _, node, _ in mapped]
        return np.stack([nodes, words], axis=1)[np.argsort(equations)]
    pairs: list[tuple[str, ...]] = []
    for line, content in enumerate(text.splitlines(), 1):
        if pair := _PAIR.match(content):
            pairs.append(pair.groups())
        elif content.strip() and pairs:
            raise spoilt(file, f"a dof such as 123.1 is expected, got {content[:60]!r}", line)
    if not pairs:
        raise spoilt(file, "it has no lines such as 123.1, nor such as 1 123 UX")
    return np.array(pairs).astype(np.int64)


def read_places(nodes: Any) -> Places:
    """Return labels and coordinates of nodes, from a file or an array.

    Parameters
    ----------
    nodes : path or array_like
        A deck of Abaqus or CalculiX, or Nastran (GRID), lines of label, x, y, z, or any mesh file
        (labels 1, 2, …); an array (n, 4) of labels and coordinates, or (n, 3).

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
    content = existing("mesh file", file)
    head = content[:4096]
    inp = looks_like_inp(head) or (file.suffix.lower() == ".inp" and head.lstrip()[:1] == b"*")
    if inp or (b"\0" not in head and is_nastran(content)):
        with held_warnings():  # of elements, which do not matter here
            raw = load(file)
        if isinstance(raw.deck, NastranDeck):
            raw.deck.grids.check_output(raw.nodes)
        if raw.node_labels is None or not len(raw.nodes):
            raise spoilt(file, "it has no nodes")
        return _labelled(f"nodes {str(file)!r}", np.column_stack([raw.node_labels, raw.nodes]))
    if b"\0" not in head and (table := _lines(file)) is not None:
        return _labelled(f"nodes {str(file)!r}", table)
    mesh = read_mesh(file)
    return np.arange(1, mesh.n_nodes + 1), mesh.nodes


def _labelled(where: str, table: FloatArray) -> Places:
    labels, order = table[:, 0].astype(np.int64), np.argsort(table[:, 0], kind="stable")
    if (labels != table[:, 0]).any():
        raise InputError("nodes: the first of four columns must be labels, integers")
    for twice in np.flatnonzero(np.diff(labels[order]) == 0)[:1]:
        raise InputError(f"{where}: node {labels[order][twice]} is there twice; give one part")
    return labels[order], table[order, 1:]


def _lines(file: Path) -> FloatArray | None:
    """Return lines of label, x, y, z and perhaps more, as Ansys' NWRITE has them."""
    text = file.read_text(encoding="latin-1")
    rows = [line.replace(",", " ").split()[:4] for line in text.splitlines() if line.strip()]
    if not rows or any(len(row) < 4 or not row[0].isdigit() for row in rows):
        return None
    table = columns([" ".join(row) for row in rows], 4)
    if table is None:
        raise spoilt(file, "label, x, y and z of nodes cannot be read, or are too large")
    return table
