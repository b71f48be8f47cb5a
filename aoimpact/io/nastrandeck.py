"""Nastran decks as entries: lines of all files, replicated and joined, as tables of fields."""

from __future__ import annotations

import codecs
import contextlib
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray, MeshError, require
from .raw import joined, number, read_lines, refused, repeats

# Bytes of memory for each byte of a deck: its text, lines, columns and fields.
_PER_BYTE = 14

# Bytes of a file by which it is recognised as a deck.
_HEAD = 2**20

# Columns of a line that Nastran reads.
_COLUMNS = 80

# Characters that are kept of a field in a line with commas.
_FREE = 32

# Entries that one line of replication may stand for.
_MOST = 1_000_000

_INCLUDE = re.compile(r"\s*INCLUDE(?:\s*=\s*|\s+|(?=['\"]))(.*)", re.I)
_SECTION = re.compile(rb"\s*(BEGIN|CEND)\b")
_PART = re.compile(rb"\s*BEGIN[\s,]+(BULK\b.*=|(?!BULK\b)\S)")
_BULK = re.compile(
    rb"^[ \t]*(?:BEGIN[ \t,]+BULK|INCLUDE)\b"
    rb"|^(?:GRID|CHEXA|CPENTA|CPYRAM?|CTETRA|CORD[12][CRS])[ \t]*\*?[ \t,][ \t]*\d",
    re.I | re.M,
)
_TIMES = re.compile(r"=(?:(\d+)|\((\d+)\))")
_INCREMENT = re.compile(r"\*\(?([^()]+)\)?")
_INTEGER = re.compile(r"[-+]?\d{1,18}")
_SHORT = re.compile(rb"(?<=[\d.])(?=[-+]\d)")
_NAME = re.compile(rb"[A-Z][A-Z0-9]*")
_SPACES = int.from_bytes(b" " * 8, "little")


def is_nastran(file: Path) -> bool:
    """Return whether a file is a Nastran deck by its content."""
    with file.open("rb") as stream:
        content = stream.read(_HEAD)
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        content = content.replace(b"\0", b"")
    content = content.lstrip(b"\xef\xbb\xbf\xff\xfe")  # byte order marks
    return b"\0" not in content and _BULK.search(content) is not None


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines in capitals, without comments, tabs and blank lines.

    Attributes
    ----------
    text : list of bytes
        ASCII; "?" is for any other character.
    sources : ndarray of int, shape (n_lines, 2)
        Number of the file, and number of the line in it from 1.
    files : list of Path
    """

    text: list[bytes]
    sources: IntArray
    files: list[Path]

    def part(self, first: int, end: int | None = None) -> Lines:
        """Return some of the lines."""
        return Lines(self.text[first:end], self.sources[first:end], self.files)

    def refused(self, line: int, what: str, why: str) -> MeshError:
        """Return the error for a line."""
        file, number = self.sources[line]
        return refused(self.files[file], int(number), what, why)


# --------------------------------------------------------------------------- files and sections


def read_sections(file: Path) -> tuple[Lines, Lines]:
    """Return the lines of case control and those of bulk data.

    A deck without BEGIN BULK is bulk data throughout.

    Raises
    ------
    MeshError
        If a file that it includes is not there, or if it has several parts, such as superelements.
    MemoryLimitError
    """
    lines = _all_lines(file)
    content = b"\n".join(lines.text)
    found = [match.start() for match in re.finditer(b"BEGIN|CEND", content)]
    candidates = sorted({content.count(b"\n", 0, start) for start in found})
    sections = {i: match[1] for i in candidates if (match := _SECTION.match(lines.text[i]))}
    begins = [i for i, name in sections.items() if name == b"BEGIN"]
    if not begins:
        if sections:
            raise lines.refused(min(sections), "CEND", "BEGIN BULK is missing after it")
        return lines.part(0, 0), lines
    for i in begins:
        if i != begins[0] or _PART.match(lines.text[i]):
            name = lines.text[i].decode().strip()
            raise lines.refused(i, name, "decks of several parts or superelements are not read")
    ends = [i for i, name in sections.items() if name == b"CEND" and i < begins[0]]
    return lines.part(max(ends, default=-1) + 1, begins[0]), lines.part(begins[0] + 1)


def _all_lines(main: Path) -> Lines:
    """Return the lines of a deck up to ENDDATA, those of included files in their places."""
    files: list[Path] = []
    texts: list[str] = []
    sources: list[IntArray] = []

    def add(file: Path, within: tuple[Path, ...]) -> bool:
        """Add the lines of a file, and return True if ENDDATA was met."""
        files.append(file)
        own = len(files) - 1
        require(_PER_BYTE * file.stat().st_size, f"mesh file {str(file)!r}", "take a coarser mesh")
        lines = [line.partition("$")[0] if "$" in line else line for line in read_lines(file)]
        stops = [
            (i, name)
            for i, line in enumerate(lines)
            if line[:1] in "IiEe \t"
            and (name := line.lstrip()[:7].upper()) in ("INCLUDE", "ENDDATA")
        ]
        end = next((i for i, name in stops if name == "ENDDATA"), len(lines))
        done = 0
        for i in [*(i for i, _ in stops if i < end), end]:
            part = lines[done:i]
            texts.extend(part)
            number = done + 1 + np.arange(len(part))
            sources.append(np.stack([np.full(len(part), own), number], axis=1))
            if i == end:
                break
            name, done = _file_name(file, lines, i)
            # os.path.isfile is False for a name that is too long, unlike Path.is_file.
            folders = (file.parent, main.parent)
            places = [folder / name for folder in folders if os.path.isfile(folder / name)]
            if not places:
                # Before CEND there are statements for the solver alone.
                if any(line.lstrip()[:4].upper() == "CEND" for line in lines[i:]):
                    continue
                raise refused(file, i + 1, "INCLUDE", f"there is no file {name!r}")
            included = places[0].resolve()
            if included in (*within, file):
                raise refused(file, i + 1, "INCLUDE", f"{name!r} includes itself")
            if add(included, (*within, file)):
                return True
        return end < len(lines)

    add(main, ())
    content = "\n".join(texts).encode("ascii", "replace").upper()
    text = [line.rstrip() for line in content.split(b"\n")]
    if b"\t" in content:
        text = [line.expandtabs(8) for line in text]
    kept = [i for i, line in enumerate(text) if line]
    return Lines([text[i] for i in kept], np.concatenate(sources)[kept], files)


def _file_name(file: Path, lines: list[str], i: int) -> tuple[str, int]:
    """Return the name in an INCLUDE, and the number of the line after it.

    A name in quotes may go on over several lines.
    """
    found = _INCLUDE.match(lines[i])
    name = "" if found is None else found[1].strip()
    end = i + 1
    while not name or (name[0] in "'\"" and name.count(name[0]) < 2):
        if end == len(lines) or found is None:
            raise refused(file, i + 1, "INCLUDE", "it needs the name of a file, in quotes")
        name += lines[end].strip()
        end += 1
    if name[0] in "'\"":
        name = name[1 : name.index(name[0], 1)]
    return name.replace("\\", "/"), end


# ------------------------------------------------------------------------------- lines in columns


def _replicated(lines: Lines) -> Lines:
    """Write out the lines that begin with "=", with commas.

    In such a line "=" is the field of the entry before, "==" all of its further fields, and "*2"
    or "*(2)" the field with an increment. "=5" and "=(5)" repeat the line above five times.
    """
    text: list[bytes] = []
    sources: list[int] = []
    entry: list[str] = []
    rule: list[str] = []
    for i, line in enumerate(lines.text):
        small = line.decode()
        if b"," not in line[:10] and b" " in line:
            small = ",".join(small[k : k + 8] for k in range(0, 72, 8))
        head, *fields = [one.strip() for one in small.split(",")][:9]
        if not line.startswith(b"="):
            entry, rule = [head, *fields], []
            text.append(line)
            sources.append(i)
            continue
        times = _TIMES.fullmatch(head)
        rule = rule if times else fields
        try:
            count = int(times[1] or times[2]) if times else 1
            if not (times or head == "=") or not rule or not entry[0].isalnum() or count > _MOST:
                raise ValueError
            for _ in range(count):
                entry = [entry[0], *_next(entry[1:], rule)]
                text.append(",".join(entry).encode())
                sources.append(i)
        except ValueError:
            raise lines.refused(i, "replication", f"{line.decode()!r} is not understood") from None
    return Lines(text, lines.sources[np.array(sources)], lines.files)


def _next(entry: list[str], rule: list[str]) -> list[str]:
    """Return the fields after those of an entry, by a line of replication."""
    found: list[str] = []
    for old, new in zip_longest(entry, rule, fillvalue=""):
        if new == "==":
            return found + entry[len(found) :]
        if step := _INCREMENT.fullmatch(new):
            is_whole = step[1].lstrip("+-").isdigit()
            old = old or "0"
            new = str(int(old) + int(step[1])) if is_whole else repr(number(old) + number(step[1]))
        found.append(old if new == "=" else new)
    return found


def _in_columns(lines: Lines) -> tuple[Lines, IntArray, IntArray]:
    """Write lines with commas in columns.

    Returns
    -------
    Lines
        With fields of 8, 16 or 32 characters after the head, as the longest one needs.
    counts : ndarray of int, shape (n_lines,)
        Number of fields in each line: 8, 4 or 2.
    odd : ndarray of int
        Lines with more fields than eight and a mark, or with fields too long to be kept.
    """
    text: list[bytes] = []
    counts: list[int] = []
    sources: list[int] = []
    odd: list[int] = []
    for i, line in enumerate(lines.text):
        if b"," not in line[:10]:
            text.append(line)
            counts.append(4 if b"*" in line[:8] else 8)
            sources.append(i)
            continue
        head, *fields = [one.strip() for one in line.split(b",")]
        most, tail = 4 if b"*" in head else 8, b""
        # Nastran takes the ninth field for data if there are more behind it, unless it is a mark.
        if most == 4 or len(fields) < 10 or fields[8][:1] in (b"", b"+", b"*"):
            is_odd = any(fields[most + 1 :])
            if len(fields) > most:
                tail = fields[most]
                is_odd = is_odd or tail[:1].isdigit()  # a mark, or one field more
            elif fields and _is_mark(fields[-1]):
                tail = fields.pop()
            fields = fields[:most]
        else:
            is_odd = False
        longest = max(map(len, fields), default=0)
        if is_odd or longest > _FREE:
            odd.append(len(text))
        width = next(w for w in (64 // most, 16, _FREE) if longest <= w or w == _FREE)
        count = 64 // width
        fields += [b""] * (-len(fields) % most or most * (not fields))
        rows = [fields[k : k + count] for k in range(0, len(fields), count)]
        rest = b"".join(one[:width].ljust(width) for one in rows[0])
        text.append(head[:8].ljust(8) + rest)
        text += [b" " * 8 + b"".join(one[:width].ljust(width) for one in row) for row in rows[1:]]
        text[-1] += tail
        counts += [count] * len(rows)
        sources += [i] * len(rows)
    columns = Lines(text, lines.sources[np.array(sources, dtype=np.int64)], lines.files)
    return columns, np.array(counts), np.array(odd, dtype=np.int64)


def _is_mark(text: bytes) -> bool:
    """Return whether the last field of a line marks a continuation: "+" or "+A1", not "+1.5"."""
    return text[:1] in (b"+", b"*") and not text[1:2].isdigit() and text[1:2] != b"."


# ---------------------------------------------------------------------------- lines to entries


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
    _counts: IntArray  # fields in each line
    _odd: IntArray
    _order: IntArray  # lines entry by entry
    _begins: IntArray  # place in `_order` of each line's entry
    _offset: IntArray  # of each line's first field in its entry

    def table(self, *names: str, width: int) -> Table:
        """Return the entries of some names, with their first `width` data fields."""
        first = np.sort(joined(self.names[name] for name in names if name in self.names))
        row = np.full(len(self._counts), -1)
        row[first] = np.arange(len(first))
        row = row[self._order[self._begins]]  # of each line
        used = self._order[row[self._order] >= 0]
        used = used[self._offset[used] < width]
        data, offset, counts = self._fields(used), self._offset[used], self._counts[used]
        fields = np.zeros((len(first), int(offset.max(initial=0)) + 8), data.dtype)
        for count in (2, 4, 8):
            some = np.flatnonzero(counts == count)
            place = offset[some][:, None] + np.arange(count)
            fields[row[used[some]][:, None], place] = data[some, :count]
        return Table(self.lines, first, fields[:, :width], width)

    def long_entries(self, name: str) -> Iterator[tuple[int, list[str]]]:
        """Yield line and fields of entries of any length, such as sets."""
        starts = np.flatnonzero(np.diff(self._begins[self._order], prepend=-1))
        begins = np.append(starts, len(self._order))
        for line in self.names.get(name, ()):
            first = self._begins[line]
            own = self._order[first : begins[np.searchsorted(begins, first) + 1]]
            pairs = zip(self._fields(own), self._counts[own], strict=True)
            yield int(line), [one.decode().strip() for data, n in pairs for one in data[:n]]

    def quads(self, name: str) -> tuple[Table, IntArray]:
        """Return the data fields of entries of any length by fours, and the entry of each four."""
        order = self._order
        starts = np.isin(order[self._begins[order]], self.names.get(name, ()))
        lines = order[starts]
        data, counts = self._fields(lines), self._counts[lines]
        entry = np.repeat(np.cumsum(self._offset[lines] == 0) - 1, counts)[::4]
        fields = data[np.arange(8) < counts[:, None]].reshape(-1, 4)
        return Table(self.lines, np.repeat(lines, counts)[::4], fields, 4), entry

    def _fields(self, lines: IntArray) -> npt.NDArray[Any]:
        """Fields 2 to 9 of some lines, shape (n, 8); in lines of fewer fields the first ones."""
        for line in lines[np.isin(lines, self._odd)][:1].tolist():
            why = "the line has too many fields, or one of more than 32 characters"
            raise self.lines.refused(line, self.lines.text[line][:8].decode().strip(), why)
        counts = self._counts[lines]
        fields = np.zeros((len(lines), 8), f"S{64 // int(counts.min(initial=8))}")
        for count in (2, 4, 8):
            data = np.ascontiguousarray(self._columns[lines[counts == count], 8:72])
            fields[counts == count, :count] = data.view(f"S{64 // count}")
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

    def select(self, rows: IntArray | npt.NDArray[np.bool_]) -> Table:
        """Return some of the entries."""
        return Table(self.lines, self.first[rows], self.fields[rows], self.width)

    def refused(self, row: int, why: str) -> MeshError:
        """Return the error for an entry."""
        line = int(self.first[row])
        name = re.split(rb"[ ,*]", self.lines.text[line][:8].strip())[0].decode()
        return self.lines.refused(line, name, why)

    def refuse_first(self, wrong: npt.NDArray[np.bool_], why: str) -> None:
        """Raise the error for the first entry that is wrong, if there is one."""
        for row in np.flatnonzero(wrong)[:1].tolist():
            raise self.refused(row, why)

    def integers(self, first: int, count: int) -> IntArray:
        """Return fields from `first` on as integers, shape (n, count); blank is 0."""
        numbers: IntArray = self._numbers(first, count, np.int64)
        return numbers

    def reals(self, first: int, count: int) -> FloatArray:
        """Return fields from `first` on as real numbers, shape (n, count); blank is 0."""
        numbers: FloatArray = self._numbers(first, count, np.float64)
        return numbers

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
        with contextlib.suppress(ValueError):
            if kind is np.float64:
                return number(text)
            if _INTEGER.fullmatch(text):
                return int(text)
        what = "an integer" if kind is np.int64 else "a real number"
        raise self.refused(row, f"field {column + 2} must be {what}, got {text!r}")


def _converted(text: npt.NDArray[Any], kind: Any) -> Any:
    """Return fields as numbers; None if one is none, or is for Python alone, as 1_0 and nan."""
    whole = text.tobytes()
    if b"_" in whole or b"N" in whole:
        return None
    with contextlib.suppress(ValueError, OverflowError):
        found = text.astype(kind)
        return found if np.isfinite(found).all() else None
    if kind is np.float64:  # 1.5-3 and 1.5D-3 are 1.5E-3
        content = b"\n".join(text.tolist()).replace(b"D", b"E")
        with contextlib.suppress(ValueError):
            found = np.array(_SHORT.sub(b"E", content).split(b"\n")).astype(kind)
            return found if np.isfinite(found).all() else None
    return None


def read_bulk_data(lines: Lines) -> BulkData:
    """Join lines to entries.

    Raises
    ------
    MeshError
        If a line is neither the beginning of an entry nor the continuation of one.
    """
    content = b"\n".join(lines.text)
    if b"\n=" in content:
        lines = _replicated(lines)
    odd = joined([])
    if b"," in content:
        lines, counts, odd = _in_columns(lines)
    columns = np.array(lines.text, dtype=f"S{_COLUMNS}").view(np.uint8).reshape(-1, _COLUMNS)
    heads, tails = _column_field(columns, 0), _column_field(columns, 72)
    marks = heads.view(np.uint8).reshape(-1, 8)
    continues = (marks[:, 0] == ord("+")) | (marks[:, 0] == ord("*")) | (marks <= 32).all(axis=1)
    if b"," not in content:
        counts = np.where((marks == ord("*")).any(axis=1), 4, 8)
    order = _in_order(lines, continues, heads, tails)
    begins = np.empty(len(order), dtype=np.int64)
    begins[order] = np.maximum.accumulate(np.where(continues[order], 0, np.arange(len(order))))
    before = np.empty(len(order), dtype=np.int64)
    before[order] = np.cumsum(counts[order]) - counts[order]
    offset = before - before[order[begins]]
    for half in np.flatnonzero((counts == 8) & (offset % 8 != 0))[:1].tolist():
        why = "large fields before it fill only half a line; add '*'"
        raise lines.refused(half, "continuation", why)
    names = _names(lines, np.flatnonzero(~continues), heads[~continues])
    return BulkData(lines, names, columns, counts, odd, order, begins, offset)


def _column_field(columns: npt.NDArray[np.uint8], first: int) -> npt.NDArray[np.bytes_]:
    part = columns[:, first : first + 8]
    return np.where(part == 0, np.uint8(ord(" ")), part).view("S8").ravel()


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
    """Return the lines such that each continuation follows the line that it continues.

    A continuation without a mark, or with the mark of the line before it, continues that line; any
    other is looked for by its mark. Both ends of a mark may differ in the first character.
    """
    which = np.flatnonzero(continues)
    marks = heads[which].view(np.uint8).reshape(-1, 8)[:, 1:]
    before = tails[which - 1].view(np.uint8).reshape(-1, 8)[:, 1:]
    unmarked = np.all(marks <= ord(" "), axis=1)
    if len(which) and which[0] == 0 and unmarked[0]:
        raise lines.refused(0, "continuation", "there is no entry before it")
    follows = (unmarked | np.all(marks == before, axis=1)) & (which > 0)
    if follows.all():
        return np.arange(len(heads))
    parents: dict[bytes, list[int]] = {}
    for row in np.flatnonzero(tails.view(np.uint8).reshape(-1, 8).max(axis=1) > 32).tolist():
        parents.setdefault(tails[row].strip()[1:], []).append(row)
    parent = which - 1
    for k in np.flatnonzero(~follows).tolist():
        mark, line = heads[which[k]].strip(), int(which[k])
        found = parents.get(mark[1:], [])
        if line - 1 not in found:
            if len(found) != 1:
                why = f"the mark {mark.decode()!r} is at the end of {len(found)} lines, not of one"
                raise lines.refused(line, "continuation", why)
            parent[k] = found[0]
    for k in repeats(parent)[:1].tolist():
        why = "the line that it continues has another continuation"
        raise lines.refused(int(which[k]), "continuation", why)
    child = dict(zip(parent.tolist(), which.tolist(), strict=True))
    chained: list[int] = []
    for start in np.flatnonzero(~continues).tolist():
        chained.append(start)
        while chained[-1] in child:
            chained.append(child[chained[-1]])
    if len(chained) < len(heads):
        left = min(set(range(len(heads))).difference(chained))
        raise lines.refused(left, "continuation", "the marks of continuations go round in a circle")
    return np.array(chained)
