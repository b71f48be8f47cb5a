"""Nastran's DMIG entries: columns of matrices by node and component."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .matrix import RawMatrix, labelled, passed_over
from .nastrandeck import read_bulk_data, read_sections

# IFO, the form of a matrix: of a symmetric one a single triangle is there.
_SQUARE, _SYMMETRIC = 1, 6

# TIN, the type of its numbers, of real ones at most.
_REAL = 2


def is_dmig(head: bytes) -> bool:
    """Return whether a file has DMIG entries near its beginning."""
    return re.search(rb"^DMIG", head, re.MULTILINE) is not None


def read_dmig(file: Path, size: int) -> list[RawMatrix]:
    """Read all matrices of a file.

    An entry is a header (name, 0, IFO, TIN), or a column: its name, node and component, then node,
    component and value of each row.
    """
    quads, entry = read_bulk_data(read_sections(file)[1]).quads("DMIG")
    starts = np.diff(entry, prepend=-1) > 0
    heads = quads.select(starts)
    names = [name.decode().strip() for name in heads.fields[:, 0].tolist()]
    labels = heads.integers(1, 2)
    kinds = heads.select(labels[:, 0] == 0).integers(2, 2)
    headers = [name for name, node in zip(names, labels[:, 0], strict=True) if node == 0]
    known = np.array([name in headers for name in names], dtype=bool)
    heads.refuse_first(~known, "its matrix has no header")
    found = []
    for name, (form, kind) in zip(headers, kinds.tolist(), strict=True):
        own = np.array([each == name for each in names]) & (labels[:, 0] != 0)
        rows = own[entry] & ~starts & ~quads.blank[:, 0]
        if kind > _REAL or form not in (_SQUARE, _SYMMETRIC) or not rows.any():
            why = "complex" if kind > _REAL else "not square, or empty"
            found.append(passed_over(file, name, why))
            continue
        table = quads.select(rows)
        table.refuse_first(table.blank[:, 2], "a row has no value: is the file cut short?")
        values = table.reals(2, 1)[:, 0]
        columns = labels[entry[rows]].T
        symmetric = form == _SYMMETRIC
        found.append(
            labelled(file, name, table.integers(0, 2).T, columns, values, triangle=symmetric)
        )
    return found
