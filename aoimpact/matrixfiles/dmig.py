"""Nastran's DMIG entries as they are punched: large fields, a column with the entries of its rows.

DMIG    KAAX           0       6       2       0
DMIG*   KAAX                         101               1
*                    101               1 1.234567890D+06
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..base import FloatArray, IntArray
from .found import Found, spoilt, unfit
from .nodal import label_codes

_ENTRY = re.compile(rb"^DMIG", re.MULTILINE)

# A number whose exponent has no letter.
_NO_E = re.compile(rb"^([-+]?\d*\.?\d*)([-+]\d+)$")

# The form of a symmetric matrix, of which one triangle is punched, and of a square one.
_SYMMETRIC, _SQUARE = 6, 1

# In its place, of what is passed over.
_COMPLEX = -1

# A line of an entry: the mark, node, component and value.
_ROW = np.dtype([("mark", "S8"), ("node", "S16"), ("component", "S16"), ("value", "S16")])


def is_dmig(head: bytes) -> bool:
    """True if a file has DMIG entries near its beginning."""
    return _ENTRY.search(head) is not None


def read_dmig(file: Path, size: int) -> list[Found]:
    """Read all square matrices of a file."""
    lines = file.read_bytes().replace(b"\r", b"").split(b"\n")
    heads = [i for i, line in enumerate(lines) if line.startswith(b"DMIG")]
    matrices: dict[str, int] = {}
    columns: dict[str, list[tuple[int, int, int, int]]] = {}
    for i, end in zip(heads, [*heads[1:], len(lines)], strict=True):
        line = lines[i].expandtabs(8)
        name = line[8 : 24 if line[4:5] == b"*" else 16].decode("latin-1").strip().upper()
        if line[4:5] != b"*":
            matrices[name] = _form(file, line, i)
            continue
        if name not in matrices:
            raise spoilt(file, f"a column of {name}, of which there is no header", i + 1)
        node, component = (_integer(file, line[a : a + 16], i) for a in (24, 40))
        stop = i + 1
        while stop < end and lines[stop].startswith(b"*"):
            stop += 1
        columns.setdefault(name, []).append((i + 1, stop, node, component))
    return [
        _matrix(file, name, form, lines, columns[name])
        if form in (_SYMMETRIC, _SQUARE) and name in columns
        else unfit(file, name, "complex" if form == _COMPLEX else "not square, or empty")
        for name, form in matrices.items()
    ]


def _form(file: Path, line: bytes, i: int) -> int:
    if b"," in line:
        raise spoilt(file, "DMIG in free fields; punch it (EXTSEOUT(DMIGPCH) or MATPCH)", i + 1)
    if line[16:24].strip() not in (b"0", b""):  # a node, where a header has 0
        raise spoilt(
            file,
            "DMIG in small fields; punch it (EXTSEOUT(DMIGPCH) or MATPCH), or write DMIG*",
            i + 1,
        )
    form, kind = (_integer(file, line[a : a + 8], i) for a in (24, 32))
    return _COMPLEX if kind > 2 else form


def _matrix(
    file: Path, name: str, form: int, lines: list[bytes], columns: list[tuple[int, int, int, int]]
) -> Found:
    """The matrix of columns, each with the range of its lines, and its label."""
    which = [i for first, stop, _, _ in columns for i in range(first, stop)]
    padded = b"".join(lines[i].ljust(_ROW.itemsize)[: _ROW.itemsize] for i in which)
    table = np.frombuffer(padded.replace(b"D", b"E"), dtype=_ROW)
    try:
        node, component = (table[key].astype(np.int64) for key in ("node", "component"))
        values = _values(table["value"])
    except ValueError:
        raise _first_wrong(file, lines, which) from None
    lengths = [stop - first for first, stop, _, _ in columns]
    of_rows = label_codes(np.stack([node, component], axis=1))
    of_cols = label_codes(np.array([column[2:] for column in columns], dtype=np.int64))
    codes, places = np.unique(np.concatenate([of_rows, of_cols]), return_inverse=True)
    rows, cols = places[: len(of_rows)], np.repeat(places[len(of_rows) :], lengths)
    labels: IntArray = np.stack([codes // 64, codes % 64], axis=1)
    return Found(file, name, len(codes), rows, cols, values, labels, triangle=form == _SYMMETRIC)


def _values(texts: Any) -> FloatArray:
    """Numbers as Nastran writes them, also 2.0+6 without the E."""
    try:
        return np.asarray(texts.astype(float))
    except ValueError:
        return np.array([float(_NO_E.sub(rb"\1E\2", text.strip())) for text in texts])


def _first_wrong(file: Path, lines: list[bytes], which: list[int]) -> Exception:
    for i in which:
        try:
            int(lines[i][8:24]), int(lines[i][24:40])
            float(_NO_E.sub(rb"\1E\2", lines[i][40:56].replace(b"D", b"E").strip()))
        except ValueError:
            shown = lines[i].decode("latin-1")[:60]
            return spoilt(
                file,
                f"*, node, component and value should stand here, got {shown!r}: is it cut short?",
                i + 1,
            )
    return spoilt(file, "its numbers cannot be read")


def _integer(file: Path, text: Any, i: int) -> int:
    try:
        return int(text)
    except ValueError:
        shown = text.decode("latin-1")
        raise spoilt(file, f"an integer should stand here, got {shown!r}", i + 1) from None
