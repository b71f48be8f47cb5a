"""Where the nodes are: coordinates by label from a deck, a mesh file, or an array."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ..base import HUGE, FloatArray, InputError, IntArray, file_path, finite_array
from ..mesh import is_nastran, nastran_nodes, read_mesh
from .found import existing, spoilt

__all__ = ["Places", "read_places"]

# Labels, or None where nodes have none but their order; and coordinates in the file's unit.
Places = tuple[IntArray | None, FloatArray]

_NODE_BLOCK = re.compile(
    r"^\*NODE\b(?!\s*(?:PRINT|FILE|OUTPUT))[^\n]*\n((?:(?!\*[^*])[^\n]*\n?)*)", re.I | re.M
)

# A number of Nastran's: 1.5-3 is 1.5E-3.
_SHORT_EXPONENT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def read_places(nodes: Any) -> Places:
    """Return labels and coordinates of nodes, from a file or an array.

    Parameters
    ----------
    nodes : path or array_like
        A deck of Abaqus or CalculiX (*NODE), or Nastran (GRID), lines of label, x, y, z, a mesh
        that meshio reads (labels 1, 2, …); an array (n, 4) of labels and coordinates, or (n, 3).

    Raises
    ------
    InputError, InputTypeError, MeshError
    """
    if not isinstance(nodes, str) and not hasattr(nodes, "__fspath__"):
        array = finite_array("nodes", nodes, ndim=2, most=HUGE)
        if array.shape[1] == 3:
            return None, array
        if array.shape[1] != 4:
            raise InputError(f"nodes must have 3 or 4 columns, got shape {array.shape}")
        return _labelled(None, array)
    file = file_path("nodes", nodes)
    existing(file)
    with file.open("rb") as stream:
        head = stream.read(4096)
    if b"\0" not in head:
        text = file.read_text(encoding="latin-1")
        if is_nastran(file):
            return nastran_nodes(file)
        for read in (_abaqus, _table):
            table = read(file, text)
            if table is not None:
                return _labelled(file, table)
    mesh = read_mesh(file)
    return np.arange(1, mesh.n_nodes + 1), mesh.nodes


def _labelled(file: Path | None, table: FloatArray) -> Places:
    labels, order = table[:, 0].astype(np.int64), np.argsort(table[:, 0], kind="stable")
    if (labels != table[:, 0]).any():
        raise InputError("nodes: the first of four columns must be labels, integers")
    twice = np.flatnonzero(np.diff(labels[order]) == 0)
    if len(twice):
        where = "nodes" if file is None else f"nodes {str(file)!r}"
        raise InputError(
            f"{where}: node {labels[order][twice[0]]} is there twice; labels must be unique, as "
            "those of one part"
        )
    return labels[order], table[order, 1:]


def _abaqus(file: Path, text: str) -> FloatArray | None:
    blocks = _NODE_BLOCK.findall(text)
    if not blocks:
        return None
    lines = [
        line
        for block in blocks
        for line in block.splitlines()
        if line.strip() and not line.startswith("**")
    ]
    if not lines:
        raise spoilt(file, "its *NODE has no nodes")
    rows = [[one.strip() for one in line.split(",")][:4] for line in lines]
    return _numbers(file, [row + ["0"] * (4 - len(row)) for row in rows])


def _table(file: Path, text: str) -> FloatArray | None:
    """Lines of label, x, y, z and perhaps more, as Ansys' NWRITE has them."""
    rows = [line.replace(",", " ").split()[:4] for line in text.splitlines() if line.strip()]
    if not rows or any(len(row) < 4 or not row[0].isdigit() for row in rows):
        return None
    return _numbers(file, rows)


def _numbers(file: Path, rows: list[list[str]]) -> FloatArray:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table = np.array(
                [[row[0], *(_plain(one) for one in row[1:])] for row in rows], dtype=float
            )
    except (ValueError, OverflowError) as error:
        raise spoilt(file, f"label, x, y and z of nodes cannot be read: {error}") from None
    if not (np.abs(table) <= min(HUGE, 2.0**53)).all():
        raise spoilt(file, "a node has a label or coordinate that is not finite, or too large")
    return table


def _plain(number: str) -> str:
    text = number.upper().replace("D", "E")
    return text if "E" in text else _SHORT_EXPONENT.sub(r"E\1", text) or "0"
