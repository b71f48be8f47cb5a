"""Dofs of the rows of a matrix: CalculiX' .dof, Ansys' mapping file, or an array."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..base import IntArray, file_path, integers
from .found import existing, spoilt

# Ansys' words for components; what is none of these has no direction.
_COMPONENTS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}

# A row of a mapping file: the equation, the node, and the component's word or number.
_MAPPED = re.compile(r"^\s*(\d+)\s+(-?\d+)\s+([A-Z]+|\d+)\s*$", re.MULTILINE)

# A line of a .dof file, or of one of pairs.
_PAIR = re.compile(r"^\s*(-?\d+)(?:\.|[\s,]+)(\d+)\s*$")


def read_dofs(dofs: Any) -> IntArray:
    """Return node and component of each row, shape (n, 2), from a file or an array.

    Raises
    ------
    InputTypeError, InputError, MissingFileError
    """
    if not isinstance(dofs, str) and not hasattr(dofs, "__fspath__"):
        what = "a file, or pairs of integers, node and component"
        return integers("dofs", dofs, what, shape=(None, 2))
    file = file_path("dofs", dofs)
    existing(file)
    text = file.read_text(encoding="latin-1")
    mapped = _MAPPED.findall(text)
    if mapped:
        return _mapping(file, mapped)
    try:
        return _pairs(file, text)
    except OverflowError:
        raise spoilt(file, "its numbers are too large for nodes and components") from None


def _mapping(file: Path, found: list[tuple[str, str, str]]) -> IntArray:
    """The labels of a mapping file, in the order of its equations."""
    try:
        equations = np.array([one[0] for one in found]).astype(np.int64)
        nodes = np.array([one[1] for one in found]).astype(np.int64)
    except (ValueError, OverflowError):
        raise spoilt(file, "its numbers are too large for equations and nodes") from None
    wrong = np.flatnonzero(np.sort(equations) != np.arange(1, len(equations) + 1))
    if len(wrong):
        raise spoilt(
            file,
            f"equation {wrong[0] + 1} of {len(equations)} is not there once: is it cut short?",
        )
    words = [int(word) if word.isdigit() else _COMPONENTS.get(word, 0) for _, _, word in found]
    labels = np.stack([nodes, np.array(words, dtype=np.int64)], axis=1)
    return labels[np.argsort(equations)]


def _pairs(file: Path, text: str) -> IntArray:
    labels = []
    for number, line in enumerate(text.splitlines(), 1):
        pair = _PAIR.match(line)
        if pair is not None:
            labels.append((int(pair[1]), int(pair[2])))
        elif line.strip() and labels:
            raise spoilt(
                file,
                f"a dof such as 123.1 should stand here, got {line[:60]!r}: is it cut short?",
                number,
            )
    if not labels:
        raise spoilt(file, "it has no lines such as 123.1, nor such as 1 123 UX")
    return np.array(labels, dtype=np.int64)
