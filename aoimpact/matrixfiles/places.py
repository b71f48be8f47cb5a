"""Coordinates of the nodes by label from a deck, a mesh file, or an array."""

from __future__ import annotations

import re
import warnings
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
)
from ..mesh import is_nastran, load, looks_like_inp, nastran_nodes, read_mesh
from .found import existing, spoilt

# Labels, or None where nodes have none but their order; and coordinates in the file's unit.
Places = tuple[IntArray | None, FloatArray]


# A number of Nastran's: 1.5-3 is 1.5E-3.
_SHORT_EXPONENT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def read_places(nodes: Any) -> Places:
    """Return labels and coordinates of nodes, from a file or an array.

    Parameters
    ----------
    nodes : path or array_like
        A deck of Abaqus or CalculiX, or Nastran (GRID), lines of label, x, y, z, a mesh that
        meshio reads (labels 1, 2, …); an array (n, 4) of labels and coordinates, or (n, 3).

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
    if looks_like_inp(head) or (file.suffix.lower() == ".inp" and head.lstrip()[:1] == b"*"):
        with held_warnings():  # of elements, which do not matter here
            raw = load(file)
        if not len(raw.nodes):
            raise spoilt(file, "it has no nodes")
        return _labelled(file, np.column_stack([np.asarray(raw.node_labels), raw.nodes]))
    if b"\0" not in head:
        text = file.read_text(encoding="latin-1")
        if is_nastran(file):
            return nastran_nodes(file)
        table = _table(file, text)
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
            f"{where}: node {labels[order][twice[0]]} is there twice; give those of one part"
        )
    return labels[order], table[order, 1:]


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
