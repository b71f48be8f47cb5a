"""Nastran's bulk data: the lines of all files, replicated and joined to entries with fields."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import compress, zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import BoolArray, FloatArray, IntArray, MeshError, decoded, require
from .raw import joined, number, numbers, read_text, refused, repeats

# Bytes of memory for each byte of a deck: its text, lines, columns and fields.
_PER_BYTE = 14

# Columns of a line that Nastran reads.
_COLUMNS = 80

# Characters that are kept of a field in a line with commas.
_FREE = 32

# Entries that one line of replication may stand for.
_MOST = 1_000_000

# Lines that a name of INCLUDE may go over.
_LONGEST = 50

_INCLUDE = re.compile(r"\s*INCLUDE(?=[\s='\"])\s*=?\s*('[^']*'|\"[^\"]*\"|[^'\"\s].*)", re.I)
_SECTION = re.compile(rb"\s*(BEGIN|CEND)\b")
_PART = re.compile(rb"\s*BEGIN[\s,]+(BULK\b.*=|(?!BULK\b)\S)")
_BULK = re.compile(
    r"^[ \t]*(?:BEGIN[ \t,]+BULK|INCLUDE)\b"
    r"|^(?:GRID|CHEXA|CPENTA|CPYRAM?|CTETRA|CORD[12][CRS])[ \t]*\*?[ \t,][ \t]*\d",
    re.I | re.M,
)
_TIMES = re.compile(rb"=(?:(\d+)|\((\d+)\))")
_INCREMENT = re.compile(rb"\*\(?([^()]+)\)?")
_MARK = re.compile(rb"[+*](?![\d.])")  # of a continuation: "+" or "+A1", not "+1.5"
INTEGER = re.compile(rb"[-+]?\d{1,18}")

# Entries with defaults for the blank fields of others.
_DEFAULTS = {"GRID": "GRDSET", "CBAR": "BAROR", "CBEAM": "BEAMOR"}

# Entries of four fields, of which one may have two.
_PAIRS = {"CROD", "CTUBE", "CORD1R", "CORD1C", "CORD1S"}

# First characters of INCLUDE and ENDDATA, and of BEGIN and CEND.
_STOPS, _SECTIONS = frozenset((b"I", b"E", b" ")), frozenset((b"B", b"C", b" "))

_NAME = re.compile(rb"[A-Z][A-Z0-9]*")

# Relative difference from a number with few digits, such as 0.833 for 5/6.
_DIGITS = 1e-3

_SPACES = int.from_bytes(b" " * 8, "little")


def is_nastran(content: bytes) -> bool:
    """Return whether a file is a Nastran deck, by its beginning."""
    return _BULK.search(decoded(content) or "") is not None


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


def read_deck(file: Path) -> tuple[Lines, BulkData]:
    """Return the lines of case control, and the bulk data.

    A deck without BEGIN BULK is bulk data throughout.

    Raises
    ------
    MeshError
        If a file that it includes is not there, if it has several parts, such as superelements, or
        if a line is neither the beginning of an entry nor the continuation of one.
    MemoryLimitError
    """
    lines = _all_lines(file)
    found: dict[bytes, list[int]] = {b"BEGIN": [], b"CEND": []}
    for i, line in enumerate(lines.text):
        if line[:1] in _SECTIONS and (name := _SECTION.match(line)):
            found[name[1]].append(i)
    begins, cends = found.values()
    if cends and not begins:
        raise lines.refused(cends[0], "CEND", "BEGIN BULK is missing after it")
    for i in begins:
        if i != begins[0] or _PART.match(lines.text[i]):
            begin = lines.text[i].decode().strip()
            raise lines.refused(i, begin, "decks of several parts or superelements are not read")
    if not begins:
        return lines.part(0, 0), read_bulk_data(lines)
    first = 1 + max((i for i in cends if i < begins[0]), default=-1)
    return lines.part(first, begins[0]), read_bulk_data(lines.part(begins[0] + 1))


def _all_lines(main: Path) -> Lines:
    """Return the lines of a deck up to ENDDATA, those of included files in their places."""
    files: list[Path] = []
    text: list[bytes] = []
    sources: list[IntArray] = []

    def add(file: Path, within: tuple[Path, ...]) -> bool:
        """Add the lines of a file, and return True if ENDDATA was met."""
        own, done = len(files), 0
        files.append(file)
        require(_PER_BYTE * file.stat().st_size, f"mesh file {str(file)!r}", "take a coarser mesh")
        written = read_text(file)
        content = re.sub(rb"\$.*", b"", written.encode("ascii", "replace").upper())
        lines = (content.expandtabs(8) if b"\t" in content else content).split(b"\n")

        def take(end: int) -> None:
            text.extend(lines[done:end])
            numbers = np.arange(done + 1, end + 1)
            sources.append(np.stack([np.full(len(numbers), own), numbers], axis=1))

        stops = [i for i, line in enumerate(lines) if line[:1] in _STOPS]
        for i in stops:
            name = lines[i].lstrip()[:7]
            if i < done or name not in (b"ENDDATA", b"INCLUDE"):
                continue
            take(i)
            if name == b"ENDDATA":
                return True
            # A name in quotes may go on over several lines.
            ahead = re.sub(r"\$.*", "", "\n".join(written.split("\n")[i : i + _LONGEST]))
            if (found := _INCLUDE.match(ahead)) is None:
                raise refused(file, i + 1, "INCLUDE", "it needs the name of a file, in quotes")
            of = re.sub(r"\s*\n\s*", "", found[1].strip().strip("'\"")).replace("\\", "/")
            done = i + 1 + found[0].count("\n")
            # os.path.isfile is False for a name that is too long, unlike Path.is_file.
            folders = (file.parent, main.parent)
            places = [folder / of for folder in folders if os.path.isfile(folder / of)]
            if not places:
                # Before CEND there are statements for the solver alone.
                if any(line.lstrip()[:4] == b"CEND" for line in lines[i:]):
                    continue
                raise refused(file, i + 1, "INCLUDE", f"there is no file {of!r}")
            included = places[0].resolve()
            if included in (*within, file):
                raise refused(file, i + 1, "INCLUDE", f"{of!r} includes itself")
            if add(included, (*within, file)):
                return True
        take(len(lines))
        return False

    add(main, ())
    text = list(map(bytes.rstrip, text))
    filled = np.fromiter(map(bool, text), bool, len(text))
    return Lines(list(compress(text, filled)), np.concatenate(sources)[filled], files)


# ------------------------------------------------------------------------------- lines in columns


def _in_columns(lines: Lines) -> tuple[Lines, IntArray]:
    """Write out lines with commas and copies by replication, in columns.

    Returns
    -------
    Lines
        With fields of 8, 16 or 32 characters after the head, as the longest one needs.
    counts : ndarray of int, shape (n_lines,)
        Number of fields in each line: 8, 4 or 2; negative where there are more than eight and a
        mark, or one too long to be kept.
    """
    text: list[bytes] = []
    sources: list[int] = []
    counts: list[int] = []

    def add(words: list[bytes], source: int) -> None:
        head, *fields = words
        most, tail, more = 4 if b"*" in head else 8, b"", list[bytes]()
        # Nastran takes the ninth field for data if there are more behind it, unless it is a mark.
        data = most == 8 and len(fields) > 9 and fields[8][:1] not in (b"", b"+", b"*")
        if len(fields) > most and not data:
            fields, (tail, *more) = fields[:most], fields[most:]
        elif fields and not data and _MARK.match(fields[-1]):
            tail = fields.pop()
        longest = max(map(len, fields), default=0)
        sign = -1 if any(more) or tail[:1].isdigit() or longest > _FREE else 1
        width = next(w for w in (64 // most, 16, _FREE) if longest <= w or w == _FREE)
        fields += [b""] * (-len(fields) % most or most * (not fields))
        columns = b"".join(one[:width].ljust(width) for one in fields)
        rows = [columns[k : k + 64] for k in range(0, len(columns), 64)]
        text.extend(at.ljust(8) + row for at, row in zip_longest([head[:8]], rows, fillvalue=b""))
        text[-1] += tail
        sources.extend([source] * len(rows))
        counts.extend([sign * (64 // width)] * len(rows))

    entry: list[bytes] = []
    rule: list[bytes] = []
    for i, line in enumerate(lines.text):
        if line.startswith(b"="):
            copies, rule = _copies(lines, i, entry or _words(lines.text[max(0, i - 1)])[:9], rule)
            for entry in copies:
                add(list(entry), i)
            continue
        entry, rule = [], []
        if b"," in line[:10]:
            add(_words(line), i)
        else:
            text.append(line)
            sources.append(i)
            counts.append(4 if b"*" in line[:8] else 8)
    return Lines(text, lines.sources[sources], lines.files), np.array(counts)


def _words(line: bytes) -> list[bytes]:
    """Return head and fields of a line with or without commas."""
    free = b"," in line[:10] or b" " not in line
    words = line.split(b",") if free else [line[k : k + 8] for k in range(0, 72, 8)]
    return [one.strip() for one in words]


def _copies(
    lines: Lines, i: int, entry: list[bytes], rule: list[bytes]
) -> tuple[list[list[bytes]], list[bytes]]:
    """Return the entries that a line of replication stands for, and the rule that they follow.

    "=" is the field of the entry before, "==" all of its further fields, and "*2" or "*(2)" the
    field with an increment. "=5" and "=(5)" repeat the line above five times.
    """
    head, *fields = _words(lines.text[i])[:9]
    times = _TIMES.fullmatch(head)
    rule = rule if times else fields
    found = []
    try:
        count = int(times[1] or times[2]) if times else 1
        known = (times or head == b"=") and rule and entry[0].isalnum()
        if not known or count > _MOST:
            raise ValueError
        for _ in range(count):
            entry = [entry[0], *_next(entry[1:], rule)]
            found.append(entry)
    except ValueError:
        line = lines.text[i].decode()
        raise lines.refused(i, "replication", f"{line!r} is not understood") from None
    return found, rule


def _next(entry: list[bytes], rule: list[bytes]) -> list[bytes]:
    """Return the fields after those of an entry, by a line of replication."""
    found: list[bytes] = []
    for old, new in zip_longest(entry, rule, fillvalue=b""):
        if new == b"==":
            return found + entry[len(found) :]
        if step := _INCREMENT.fullmatch(new):
            before, by = (old or b"0").decode(), step[1].decode()
            whole = by.lstrip("+-").isdigit()
            new = str(int(before) + int(by) if whole else number(before) + number(by)).encode()
        found.append(old if new == b"=" else new)
    return found


# ---------------------------------------------------------------------------- lines to entries


@dataclass(frozen=True, eq=False)
class Card:
    """An entry of bulk data by itself, with its fields from field 2 on."""

    name: str
    fields: list[str]
    lines: Lines
    line: int

    def error(self, why: str) -> MeshError:
        """Return the error for this entry."""
        return self.lines.refused(self.line, self.name, why)

    def text(self, at: int) -> str:
        """Return a field; blank beyond the last one."""
        return self.fields[at] if at < len(self.fields) else ""

    def real(self, at: int, what: str, default: float | None = None) -> float:
        """Return a field as a number; refuse a blank one without a default."""
        if not self.text(at):
            if default is None:
                raise self.error(f"{what} is blank")
            return default
        try:
            return number(self.text(at))
        except ValueError as wrong:
            raise self.error(str(wrong)) from None

    def integer(self, at: int, what: str, default: int = 0) -> int:
        """Return a field as an integer, such as 4, +4 or 04."""
        text = self.text(at)
        if text and not INTEGER.fullmatch(text.encode()):
            raise self.error(f"{what} must be an integer, got {text!r}")
        return int(text or default)

    def reals(self, first: int, names: str) -> list[float]:
        """Return numbers by their names, none of them blank."""
        return [self.real(first + i, name) for i, name in enumerate(names.split())]

    def must_be(self, at: int, what: str, wanted: float) -> None:
        """Refuse another value than the one that a blank field stands for."""
        value = self.real(at, what, wanted)
        if abs(value - wanted) > _DIGITS * abs(wanted):
            raise self.error(f"{what}={value:g} is not supported; only {wanted:g} is")


@dataclass(frozen=True, eq=False)
class BulkData:
    """Entries of bulk data, found by name.

    Attributes
    ----------
    lines : Lines
        Each continuation follows the line that it continues.
    names : dict of str to ndarray of int
        By name, the lines where entries begin, in the order of the deck.
    """

    lines: Lines
    names: dict[str, IntArray]
    _columns: npt.NDArray[np.uint8]  # shape (n_lines, 80)
    _counts: IntArray  # fields in each line, as of `_in_columns`
    _ends: IntArray  # by line, the end of the entry that begins there
    _offset: IntArray  # of each line's first field in its entry

    def table(self, **widths: int) -> Table:
        """Return the entries of some names, which have so many data fields at most.

        Blank fields have the values of GRDSET, BAROR and BEAMOR. Two rods or systems in one entry
        are two, the second ones at the end.
        """
        found = [(self.names[name], most) for name, most in widths.items() if name in self.names]
        first = joined(own for own, _ in found)
        most = joined(np.full(len(own), most) for own, most in found)[np.argsort(first)]
        first = np.sort(first)
        lines, row = self._of(first)
        kept = self._offset[lines] < most[row]
        behind = np.any(self._columns[lines[~kept], 8:72] > ord(" "), axis=1)
        surplus = np.isin(np.arange(len(first)), row[~kept][behind])
        lines, row = lines[kept], row[kept]
        longest = 8 + int(self._offset[lines].max(initial=0)) // 8 * 8
        fields = self._fields(lines, row * longest + self._offset[lines], len(first) * longest)
        width = max(longest, *widths.values())
        table = Table(self.lines, first, fields.reshape(len(first), longest), width)
        surplus |= np.any(~table.blank & (np.arange(width) >= most[:, None]), axis=1)
        table.refuse_first(surplus, "it has more fields than entries of this kind")
        for name, entry in _DEFAULTS.items():
            if name in widths and {name, entry} <= self.names.keys():
                table = self._with_defaults(table, name, self.table(**{entry: 8}))
        own = [self.names[name] for name in widths if name in _PAIRS and name in self.names]
        pairs = np.isin(first, joined(own))
        second = pairs & ~table.blank[:, 4:8].all(axis=1) if own else pairs
        fields = np.concatenate([table.fields, np.roll(table.fields[second], -4, axis=1)])
        fields[np.append(pairs, second[second]), 4:] = b""
        return Table(self.lines, np.append(first, first[second]), fields, table.width)

    def _with_defaults(self, table: Table, name: str, given: Table) -> Table:
        """Return a table with the fields of an entry where those of one name are blank."""
        given.refuse_first(np.arange(len(given)) > 0, "another one is there")
        blank = table.blank[:, :8] & np.isin(table.first, self.names[name])[:, None]
        if name != "GRID":  # an integer X1 is the node G0, without X2 and X3
            real = table.blank[:, 4] | (np.char.count(table.fields[:, 4], b".") > 0)
            blank[:, 5:7] &= real[:, None]
        fields = table.fields.astype(np.promote_types(table.fields.dtype, given.fields.dtype))
        fields[:, :8] = np.where(blank, given.fields[0, :8], fields[:, :8])
        return Table(table.lines, table.first, fields, table.width)

    def quads(self, name: str) -> tuple[Table, IntArray]:
        """Return the data fields of entries of any length by fours, and the entry of each four."""
        lines, row = self._of(self.names.get(name, joined([])))
        sizes = 8 * -(-np.bincount(row, self._counts[lines]).astype(np.int64) // 8)
        at = (np.cumsum(sizes) - sizes)[row] + self._offset[lines]
        fields = self._fields(lines, at, int(sizes.sum())).reshape(-1, 4)
        of = lines[np.searchsorted(at, 4 * np.arange(len(fields)), side="right") - 1]
        return Table(self.lines, of, fields, 4), np.repeat(np.arange(len(sizes)), sizes // 4)

    def cards(self, *names: str) -> Iterator[Card]:
        """Yield entries one by one, name by name."""
        for name in names:
            for first in self.names.get(name, joined([])).tolist():
                lines = np.arange(first, self._ends[first])
                at = self._offset[lines]
                fields = self._fields(lines, at, 8 + int(at[-1]) // 8 * 8)
                texts = [one.decode().strip() for one in fields.tolist()]
                yield Card(name, texts, self.lines, first)

    def _of(self, first: IntArray) -> tuple[IntArray, IntArray]:
        """Return the lines of the entries that begin with some lines, and their entries."""
        sizes = self._ends[first] - first
        row = np.repeat(np.arange(len(first)), sizes)
        return np.arange(len(row)) + (first - np.cumsum(sizes) + sizes)[row], row

    def _fields(self, lines: IntArray, at: IntArray, size: int) -> npt.NDArray[Any]:
        """Return `size` fields: those of some lines from given places on, all others empty."""
        counts = self._counts[lines]
        for line in lines[counts < 0][:1].tolist():
            why = "the line has too many fields, or one of more than 32 characters"
            raise self.lines.refused(line, self.lines.text[line][:8].decode().strip(), why)
        fields = np.zeros(size, f"S{64 // int(counts.min(initial=8))}")
        for count in (2, 4, 8):
            some = counts == count
            if some.any():
                data = np.ascontiguousarray(self._columns[lines[some], 8:72])
                fields.reshape(-1, count)[at[some] // count] = data.view(f"S{64 // count}")
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
    def blank(self) -> BoolArray:
        """Fields without content, shape (n, width)."""
        blank = np.ones((len(self), self.width), dtype=bool)
        shape = (*self.fields.shape, self.fields.itemsize // 8)
        words = np.ascontiguousarray(self.fields).view(np.uint64).reshape(shape)
        blank[:, : words.shape[1]] = ((words == 0) | (words == _SPACES)).all(axis=-1)
        return blank

    def select(self, rows: IntArray | BoolArray) -> Table:
        """Return some of the entries."""
        return Table(self.lines, self.first[rows], self.fields[rows], self.width)

    def refused(self, row: int, why: str) -> MeshError:
        """Return the error for an entry."""
        line = int(self.first[row])
        head = next(text for text in self.lines.text[line::-1] if text[:1].isalpha())
        return self.lines.refused(line, re.split(rb"[ ,*]", head[:8].strip())[0].decode(), why)

    def refuse_first(self, wrong: BoolArray, why: str) -> None:
        """Raise the error for the first entry that is wrong, if there is one."""
        for row in np.flatnonzero(wrong)[:1].tolist():
            raise self.refused(row, why)

    def integers(self, first: int, count: int) -> IntArray:
        """Return fields from `first` on as integers, shape (n, count); blank is 0."""
        filled, text = self._filled(first, count)
        found = np.zeros(filled.shape, dtype=np.int64)
        try:
            if b"_" in text.tobytes():  # Python's 1_0
                raise ValueError
            found[filled] = text.astype(np.int64)
        except (ValueError, OverflowError):
            wrong = [INTEGER.fullmatch(one.strip()) is None for one in text.tolist()]
            self._refuse_field(first, filled, np.array(wrong), "an integer")
        return found

    def reals(self, first: int, count: int) -> FloatArray:
        """Return fields from `first` on as real numbers, shape (n, count); blank is 0."""
        filled, text = self._filled(first, count)
        found = np.zeros(filled.shape)
        found[filled] = numbers(text)
        self._refuse_field(first, filled, np.isnan(found[filled]), "a real number")
        return found

    def _filled(self, first: int, count: int) -> tuple[BoolArray, npt.NDArray[Any]]:
        """Return which fields are not blank, shape (n, count), and these fields."""
        filled = ~self.blank[:, first : first + count]
        text = self.fields[:, first : first + count]
        return filled, text[filled[:, : text.shape[1]]]

    def _refuse_field(self, first: int, filled: Any, wrong: Any, what: str) -> None:
        for row, column in np.argwhere(filled)[wrong][:1].tolist() if wrong.any() else ():
            text = self.fields[row, first + column].decode().strip()
            why = f"field {first + column + 2} must be {what}, got {text!r}"
            raise self.refused(row, why)


def read_bulk_data(lines: Lines) -> BulkData:
    """Join lines to entries.

    Raises
    ------
    MeshError
        If a line is neither the beginning of an entry nor the continuation of one.
    """
    columns = _columns_of(lines)
    if written := bool((columns[:, :10] == ord(",")).any() or (columns[:, 0] == ord("=")).any()):
        lines, counts = _in_columns(lines)
        columns = _columns_of(lines)
    heads, tails = _column_field(columns, 0), _column_field(columns, 72)
    marks = heads.view(np.uint8).reshape(-1, 8)
    continues = (marks[:, 0] == ord("+")) | (marks[:, 0] == ord("*")) | (marks <= 32).all(axis=1)
    if not written:
        counts = np.where((marks == ord("*")).any(axis=1), 4, 8)
    order = _in_order(lines, continues, heads, tails)
    if order is not None:
        lines = Lines([lines.text[i] for i in order.tolist()], lines.sources[order], lines.files)
        heads, columns = heads[order], columns[order]
        continues, counts = continues[order], counts[order]
    starts = np.flatnonzero(~continues)
    ends = np.full(len(heads), len(heads))
    ends[starts[:-1]] = starts[1:]
    sizes = abs(counts)
    before = np.cumsum(sizes) - sizes
    offset = before - np.repeat(before[starts], ends[starts] - starts)
    for half in np.flatnonzero((sizes == 8) & (offset % 8 != 0))[:1].tolist():
        why = "large fields before it fill only half a line; add '*'"
        raise lines.refused(half, "continuation", why)
    return BulkData(lines, _names(lines, starts, heads[starts]), columns, counts, ends, offset)


def _columns_of(lines: Lines) -> npt.NDArray[np.uint8]:
    return np.array(lines.text, dtype=f"S{_COLUMNS}").view(np.uint8).reshape(-1, _COLUMNS)


def _column_field(columns: npt.NDArray[np.uint8], first: int) -> npt.NDArray[np.bytes_]:
    part = columns[:, first : first + 8]
    return np.where(part == 0, np.uint8(ord(" ")), part).view("S8").ravel()


def _names(lines: Lines, starts: IntArray, heads: npt.NDArray[Any]) -> dict[str, IntArray]:
    """Return the lines where entries begin by their names."""
    unique, inverse = np.unique(heads.view(np.uint64), return_inverse=True)
    order = np.argsort(inverse, kind="stable")
    parts = np.split(starts[order], np.cumsum(np.bincount(inverse))[:-1])[: len(unique)]
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
    continues: BoolArray,
    heads: npt.NDArray[Any],
    tails: npt.NDArray[Any],
) -> IntArray | None:
    """Return the lines such that each continuation follows its line; None if they do as they are.

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
        return None
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
    child, order = dict(zip(parent.tolist(), which.tolist(), strict=True)), []
    for start in np.flatnonzero(~continues).tolist():
        at: int | None = start
        while at is not None:
            order.append(at)
            at = child.get(at)
    for line in np.setdiff1d(which, order)[:1].tolist():
        raise lines.refused(line, "continuation", "the marks of continuations go round in a circle")
    return np.array(order)
