"""Text of one entry a line by labels: Abaqus' MATRIX INPUT and LABELS of *MATRIX GENERATE.

Each line has node and component of the row, those of the column, and the value, with commas or
without. Internal nodes, of Abaqus' own, have negative numbers.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .found import Found, spoilt
from .table import NUMBER, columns

_ENTRY = re.compile(rb"\s*" + rb"[\s,]+".join([*4 * [rb"[-+]?\d+"], NUMBER]) + rb"\s*,?\s*$")

_WHAT = "node, component, node, component and value"

# Nodes are counted beyond this by no program; with components they make one number.
_LARGEST_NODE, _COMPONENTS = 2**40, 64


def is_nodal(head: bytes) -> bool:
    """True if a file begins with entries by labels, after comments and a keyword."""
    for line in head.split(b"\n"):
        if line.startswith(b"*") or not line.strip():
            continue
        return _ENTRY.match(line) is not None
    return False


def read_nodal(file: Path, size: int) -> list[Found]:
    """Read entries by labels."""
    with file.open("rb") as stream:
        first = next(line for line in stream if line.strip() and not line.startswith(b"*"))
        stream.seek(0)
        node, c, other, d, values = columns(
            file, stream, 4, _WHAT, comma=b"," in first, comments="*"
        )
    wrong = min(c.min(), d.min()) < 0 or max(c.max(), d.max()) >= _COMPONENTS
    if wrong or max(np.abs(node).max(), np.abs(other).max()) >= _LARGEST_NODE:
        raise spoilt(
            file,
            f"a component is beyond {_COMPONENTS - 1}, or a node too large: are columns mixed up?",
        )
    rows, cols = node * _COMPONENTS + c, other * _COMPONENTS + d
    codes, places = np.unique(np.concatenate([rows, cols]), return_inverse=True)
    labels = np.stack([codes // _COMPONENTS, codes % _COMPONENTS], axis=1)
    rows, cols = places[: len(rows)], places[len(rows) :]
    return [Found(file, "", len(codes), rows, cols, values, labels)]


def label_codes(labels: np.ndarray) -> np.ndarray:
    """Return one number for each pair of node and component, ordered as they are."""
    codes: np.ndarray = labels[:, 0] * _COMPONENTS + labels[:, 1]
    return codes
