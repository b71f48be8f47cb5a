"""Nastran's bulk data: lines of small, large and free fields, joined to entries."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base import FloatArray, IntArray, MeshError
from .nastrantext import Lines
from .replication import written_out
from .textfile import number

__all__ = ["BulkData", "Table", "read_bulk_data"]

# Columns of a line that Nastran reads.
_COLUMNS = 80

# Characters that are kept of a field in a line with commas.
_FREE = 32

_SPACES = int.from_bytes(b" " * 8, "little")
_INTEGER = re.compile(r"[-+]?\d{1,18}")
_SHORT = re.compile(rb"(?<=[\d.])(?=[-+]\d)")
_NAME = re.compile(rb"[A-Z][A-Z0-9]*")


@dataclass(frozen=True, eq=False)
class BulkData:
    """Entries of bulk data, found by name.

    Attributes
    ----------
    lines : Lines
    names : dict of str to ndarray of int
        By name, the lines where entries begin, in the order of the deck.
    """

    lines: Lines
    names: dict[str, IntArray]
    _columns: npt.NDArray[np.uint8]  # shape (n_lines, 80)
    _free: _FreeLines
    _large: npt.NDArray[np.bool_]  # lines of four fields, not eight
    _order: IntArray  # lines entry by entry
    _begins: IntArray  # place in `_order` of each line's entry
    _offset: IntArray  # of each line's first field in its entry

    def table(self, *names: str, width: int) -> Table:
        """Return the entries of some names, with their first `width` data fields."""
        none = np.zeros(0, np.int64)
        first = np.sort(np.concatenate([none, *(self.names.get(name, none) for name in names)]))
        row = np.full(len(self._large), -1)
        row[first] = np.arange(len(first))
        row = row[self._order[self._begins]]  # of each line
        used = self._order[row[self._order] >= 0]
        used = used[self._offset[used] < width]
        data, offset, small = self._fields(used), self._offset[used], ~self._large[used]
        fields = np.zeros((len(first), int(offset.max(initial=0)) + 8), data.dtype)
        fields[row[used][:, None], offset[:, None] + np.arange(4)] = data[:, :4]
        place = offset[small][:, None] + np.arange(4, 8)
        fields[row[used][small][:, None], place] = data[small, 4:]
        return Table(self.lines, first, fields[:, :width], width)

    def long_entries(self, name: str) -> Iterator[tuple[int, list[str]]]:
        """Yield line and fields of entries of any length, such as sets."""
        starts = np.flatnonzero(np.diff(self._begins[self._order], prepend=-1))
        begins = np.append(starts, len(self._order))
        for line in self.names.get(name, ()):
            first = self._begins[line]
            own = self._order[first : begins[np.searchsorted(begins, first) + 1]]
            found: list[str] = []
            for i, data in zip(own, self._fields(own), strict=True):
                found += [one.decode().strip() for one in data[: 4 if self._large[i] else 8]]
            yield int(line), found

    def _fields(self, lines: IntArray) -> npt.NDArray[Any]:
        """Fields 2 to 9 of some lines, shape (n, 8); the first four only where they are large."""
        free, large = self._free.row[lines] >= 0, self._large[lines]
        longest = _FREE if free.any() else 16 if large.any() else 8
        fields = np.zeros((len(lines), 8), f"S{longest}")
        for own, columns in ((~free & ~large, 8), (~free & large, 4)):
            data = np.ascontiguousarray(self._columns[lines[own], 8:72])
            fields[own, :columns] = data.view(f"S{64 // columns}")
        rows = self._free.row[lines[free]]
        if self._free.odd[rows].any():
            line = int(lines[free][self._free.odd[rows]][0])
            why = "the line has too many fields, or one of more than 32 characters"
            raise self.lines.refused(
                line, self._free.heads[self._free.row[line]].decode().strip(), why
            )
        fields[free] = self._free.fields[rows]
        return fields


@dataclass(frozen=True, eq=False)
class Table:
    """Entries of one kind in the order of the deck.

    Attributes
    ----------
    lines : Lines
    first : ndarray of int, shape (n,)
        Line where each entry begins.
    fields : ndarray of bytes, shape (n, at most width)
        Data fields, from field 2 of an entry on; those further on are blank.
    width : int
    """

    lines: Lines
    first: IntArray
    fields: npt.NDArray[Any]
    width: int

    def __len__(self) -> int:
        return len(self.first)

    @cached_property
    def blank(self) -> npt.NDArray[np.bool_]:
        """Fields without content, shape (n, width)."""
        blank = np.ones((len(self), self.width), dtype=bool)
        shape = (*self.fields.shape, self.fields.itemsize // 8)
        words = np.ascontiguousarray(self.fields).view(np.uint64).reshape(shape)
        blank[:, : words.shape[1]] = ((words == 0) | (words == _SPACES)).all(axis=-1)
        return blank

    def integers(self, first: int, count: int) -> IntArray:
        """Return fields from `first` on as integers, shape (n, count); blank is 0."""
        numbers: IntArray = self._numbers(first, count, np.int64)
        return numbers

    def reals(self, first: int, count: int) -> FloatArray:
        """Return fields from `first` on as real numbers, shape (n, count); blank is 0."""
        numbers: FloatArray = self._numbers(first, count, np.float64)
        return numbers

    def select(self, rows: IntArray | npt.NDArray[np.bool_]) -> Table:
        """Return some of the entries."""
        return Table(self.lines, self.first[rows], self.fields[rows], self.width)

    def refused(self, row: int, why: str) -> MeshError:
        """Return the error for an entry."""
        line = int(self.first[row])
        text = self.lines.text[line]
        name = re.split(rb"[ ,*]", text[:8].strip())[0].decode()
        return self.lines.refused(line, name, why)

    def refuse_first(self, wrong: npt.NDArray[np.bool_], why: str) -> None:
        """Raise the error for the first entry that is wrong, if there is one."""
        if wrong.any():
            raise self.refused(int(np.flatnonzero(wrong)[0]), why)

    def _numbers(self, first: int, count: int, kind: Any) -> Any:
        filled = ~self.blank[:, first : first + count]
        numbers = np.zeros(filled.shape, kind)
        text = self.fields[:, first : first + count]
        found = _converted(text[filled[:, : text.shape[1]]], kind)
        if found is None:
            places = np.argwhere(filled)
            found = [self._number(row, first + column, kind) for row, column in places]
        numbers[filled] = found
        return numbers

    def _number(self, row: int, column: int, kind: Any) -> float:
        text = self.fields[row, column].decode().strip()
        try:
            if kind is np.float64:
                return number(text)
            if _INTEGER.fullmatch(text):
                return int(text)
        except ValueError:
            pass
        what = "an integer" if kind is np.int64 else "a real number"
        raise self.refused(row, f"field {column + 2} must be {what}, got {text!r}")


def _converted(text: npt.NDArray[Any], kind: Any) -> Any:
    """Return fields as numbers; None if one is none, or is for Python alone, as 1_0 and nan."""
    whole = text.tobytes()
    if b"_" in whole or b"N" in whole:
        return None
    with contextlib.suppress(ValueError, OverflowError):
        return _finite(text.astype(kind))
    if kind is np.float64:  # 1.5-3 and 1.5D-3 are 1.5E-3
        joined = b"\n".join(text.tolist()).replace(b"D", b"E")
        with contextlib.suppress(ValueError):
            return _finite(np.array(_SHORT.sub(b"E", joined).split(b"\n")).astype(kind))
    return None


def _finite(numbers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if not np.isfinite(numbers).all():
        raise ValueError
    return numbers


# ---------------------------------------------------------------------------- lines to entries


@dataclass(frozen=True, eq=False)
class _FreeLines:
    """Fields of lines with commas.

    Attributes
    ----------
    row : ndarray of int, shape (n_lines,)
        Row of `fields` for each line of the deck; -1 for lines in columns.
    heads, tails : list of bytes
        First field, and mark of the continuation.
    fields : ndarray of bytes, shape (n, 8)
    odd : ndarray of bool, shape (n,)
        Lines with more fields than eight and a mark, or with fields too long to be kept.
    """

    row: IntArray
    heads: list[bytes]
    tails: list[bytes]
    fields: npt.NDArray[Any]
    odd: npt.NDArray[np.bool_]


def read_bulk_data(lines: Lines) -> BulkData:
    """Join lines to entries.

    Raises
    ------
    MeshError
        If a line is neither the beginning of an entry nor the continuation of one.
    """
    lines = written_out(lines)
    columns = np.array(lines.text, dtype=f"S{_COLUMNS}").view(np.uint8).reshape(-1, _COLUMNS)
    free = _free_lines(lines, np.flatnonzero((columns[:, :10] == ord(",")).any(axis=1)))
    heads = _column_field(columns, 0)
    tails = _column_field(columns, 72)
    is_free = free.row >= 0
    heads[is_free], tails[is_free] = free.heads, free.tails
    marks = heads.view(np.uint8).reshape(-1, 8)
    continues = (marks[:, 0] == ord("+")) | (marks[:, 0] == ord("*")) | (marks <= 32).all(axis=1)
    large = (marks == ord("*")).any(axis=1)
    order = _in_order(lines, continues, heads, tails)
    begins = np.empty(len(order), dtype=np.int64)
    begins[order] = np.maximum.accumulate(np.where(continues[order], 0, np.arange(len(order))))
    count = np.where(large, 4, 8)
    before = np.empty(len(order), dtype=np.int64)
    before[order] = np.cumsum(count[order]) - count[order]
    offset = before - before[order[begins]]
    half = np.flatnonzero(~large & (offset % 8 != 0))
    if len(half):
        raise lines.refused(
            int(half[0]), "continuation", "large fields before it fill only half a line; add '*'"
        )
    starts = np.flatnonzero(~continues)
    names = _names(lines, starts, heads[starts])
    return BulkData(lines, names, columns, free, large, order, begins, offset)


def _column_field(columns: npt.NDArray[np.uint8], first: int) -> npt.NDArray[np.bytes_]:
    part = columns[:, first : first + 8]
    return np.where(part == 0, np.uint8(ord(" ")), part).view("S8").ravel()


def _free_lines(lines: Lines, which: IntArray) -> _FreeLines:
    row = np.full(len(lines.text), -1)
    row[which] = np.arange(len(which))
    heads, tails = [], []
    table = np.zeros((len(which), 8), f"S{_FREE}")
    odd = np.zeros(len(which), dtype=bool)
    for k, i in enumerate(which):
        head, *fields = [one.strip() for one in lines.text[i].split(b",")]
        most = 4 if b"*" in head else 8
        tail = fields[most] if len(fields) > most else b""
        if 0 < len(fields) <= most and _is_mark(fields[-1]):
            tail = fields.pop()
        odd[k] = (
            any(fields[most + 1 :])
            or max(map(len, fields), default=0) > _FREE
            or (len(fields) > most and tail[:1].isdigit())  # a mark, or one field more
        )
        table[k, : min(len(fields), most)] = fields[:most]
        heads.append(head[:8].ljust(8))
        tails.append(tail.ljust(8))
    return _FreeLines(row, heads, tails, table, odd)


def _is_mark(text: bytes) -> bool:
    """Return whether the last field of a line marks a continuation: "+" or "+A1", not "+1.5"."""
    return text[:1] in (b"+", b"*") and not text[1:2].isdigit() and text[1:2] != b"."


def _names(lines: Lines, starts: IntArray, heads: npt.NDArray[Any]) -> dict[str, IntArray]:
    """Return the lines where entries begin by their names."""
    unique, inverse = np.unique(heads.view(np.uint64), return_inverse=True)
    order = np.argsort(inverse, kind="stable")
    parts = np.split(starts[order], np.cumsum(np.bincount(inverse, minlength=len(unique)))[:-1])
    found: dict[str, list[IntArray]] = {}
    for head, own in zip(unique.view("S8"), parts, strict=True):
        # meshio writes CTETRA_, CHEXA_ and so on for elements with midside nodes.
        name = head.strip().removesuffix(b"*").strip().removesuffix(b"_")
        if not _NAME.fullmatch(name):
            text = lines.text[own[0]][:24].decode()
            raise lines.refused(int(own[0]), repr(text), "it begins no entry of bulk data")
        found.setdefault(name.decode(), []).append(own)
    return {name: np.sort(np.concatenate(parts)) for name, parts in found.items()}


def _in_order(
    lines: Lines,
    continues: npt.NDArray[np.bool_],
    heads: npt.NDArray[Any],
    tails: npt.NDArray[Any],
) -> IntArray:
    """Return the lines such that each continuation follows what it continues.

    A continuation without a mark, or with the mark of the line before it, continues that line; any
    other is looked for by its mark.
    """
    order = np.arange(len(heads))
    which = np.flatnonzero(continues)
    marks = heads[which].view(np.uint8).reshape(-1, 8)[:, 1:]
    before = tails[which - 1].view(np.uint8).reshape(-1, 8)[:, 1:]
    unmarked = np.all(marks <= ord(" "), axis=1)
    if len(which) and which[0] == 0 and unmarked[0]:
        raise lines.refused(0, "continuation", "there is no entry before it")
    follows = (unmarked | np.all(marks == before, axis=1)) & (which > 0)
    if follows.all():
        return order
    parents: dict[bytes, list[int]] = {}
    for row in np.flatnonzero(tails.view(np.uint8).reshape(-1, 8).max(axis=1) > 32):
        parents.setdefault(_mark(tails[row]), []).append(int(row))
    moved: dict[int, int] = {}
    follows_at = np.zeros(len(heads), dtype=bool)
    follows_at[which[follows]] = True
    for i in (int(line) for line in which[~follows]):
        found = parents.get(_mark(heads[i]), [])
        if i - 1 in found:
            follows_at[i] = True
            continue
        if len(found) != 1 or found[0] in moved:
            mark = heads[i].decode().strip()
            why = f"the mark {mark!r} is at the end of {len(found)} lines, not of one"
            raise lines.refused(i, "continuation", why)
        moved[found[0]] = i
    for parent, i in moved.items():
        if parent + 1 < len(heads) and follows_at[parent + 1]:
            why = "the line that its mark names has another continuation"
            raise lines.refused(i, "continuation", why)
    chained: list[int] = []
    for start in np.flatnonzero(~continues).tolist():
        line = int(start)
        while line >= 0:
            chained.append(line)
            direct = line + 1 if line + 1 < len(heads) and follows_at[line + 1] else -1
            line = moved.get(line, direct)
    if len(chained) < len(heads):
        left = set(range(len(heads))).difference(chained)
        why = "the marks of continuations go round in a circle"
        raise lines.refused(min(left), "continuation", why)
    return np.array(chained)


def _mark(field: bytes) -> bytes:
    """Return a mark without its first character, by which the two ends may differ."""
    return field.strip()[1:]
