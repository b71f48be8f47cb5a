"""Parser of Nastran decks: included files, replication, continuation lines, fields of entries."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..base import BoolArray, FloatArray, IntArray, MeshError, decoded, record, require
from .raw import Line, number, numbers, read_text

# Ratio of the memory needed to the size of a deck, for its text, lines, columns and fields.
_PER_BYTE = 22

# Number of characters of a line that Nastran reads.
_COLUMNS = 80

# Largest number of characters of a field in a line with commas.
_LONG = 32

# Largest number of entries that one replication line may generate.
_MOST = 1_000_000

# Largest number of lines over which a file name in INCLUDE may extend.
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
_MARK = re.compile(rb"[+*](?![\d.])")  # mark of a continuation: "+" or "+A1", not "+1.5"
INTEGER = re.compile(rb"[-+]?\d{1,18}")

# For an entry's name, the name of the entry that has the defaults for its blank fields.
_DEFAULTS = {"GRID": "GRDSET", "CBAR": "BAROR", "CBEAM": "BEAMOR"}

# Names of entries with four fields, two of which may share a line.
_PAIRS = ["CROD", "CTUBE", "CORD1R", "CORD1C", "CORD1S"]

_NAME = re.compile(rb"[A-Z][A-Z0-9]*")

# Largest relative difference of a field from its required value, which may be printed with few
# digits: 0.833 for 5/6.
_DIGITS = 1e-3


def is_nastran(content: bytes) -> bool:
    """Return whether a file that begins with the bytes `content` is a Nastran deck."""
    return _BULK.search(decoded(content) or "") is not None


# -------------------------------------------------------------------- files and parts of a deck


def read_deck(file: Path) -> tuple[list[Line], BulkData]:
    """Return the lines of case control, and the bulk data.

    Lines are returned in capitals, without comments, tabs and blank lines, with "?" for characters
    beyond ASCII. A deck without BEGIN BULK is all bulk data.

    Raises
    ------
    MeshError
        If an included file does not exist, if the deck has several parts, such as superelements,
        or if a line neither begins nor continues an entry.
    MemoryLimitError
    """
    lines = _all_lines(file)
    marks = [(i, of[1]) for i, line in enumerate(lines) if (of := _SECTION.match(line.text))]
    begins, cends = ([i for i, of in marks if of == name] for name in (b"BEGIN", b"CEND"))
    if cends and not begins:
        raise lines[cends[0]].refused("CEND", "BEGIN BULK is missing after it")
    for i in begins:
        if i != begins[0] or _PART.match(lines[i].text):
            why = "decks of several parts or superelements are not read"
            raise lines[i].refused(lines[i].text.decode().strip(), why)
    if not begins:
        return [], read_bulk_data(lines)
    first = 1 + max((i for i in cends if i < begins[0]), default=-1)
    return lines[first : begins[0]], read_bulk_data(lines[begins[0] + 1 :])


def _all_lines(main: Path) -> list[Line]:
    """Return the lines of a deck up to ENDDATA, with included files inserted."""
    found = list[Line]()

    def add(file: Path, within: tuple[Path, ...]) -> bool:
        """Add the lines of a file; return whether it has ENDDATA."""
        require(_PER_BYTE * file.stat().st_size, f"mesh file {str(file)!r}", "take a coarser mesh")
        written = read_text(file)
        content = re.sub(rb"\$.*", b"", written.encode("ascii", "replace").upper())
        lines = (content.expandtabs(8) if b"\t" in content else content).split(b"\n")
        done = 0
        for i, text in enumerate(lines):
            name, line = text.strip()[:7], Line(text.rstrip(), file, i + 1, len(found))
            if i < done or not name:
                continue
            if name == b"ENDDATA":
                return True
            if name != b"INCLUDE":
                found.append(line)
                continue
            # A quoted file name may continue over several lines.
            ahead = re.sub(r"\$.*", "", "\n".join(written.split("\n")[i : i + _LONGEST]))
            if (given := _INCLUDE.match(ahead)) is None:
                raise line.refused("INCLUDE", "it needs the name of a file, in quotes")
            of = re.sub(r"\s*\n\s*", "", given[1].strip().strip("'\"")).replace("\\", "/")
            done = i + 1 + given[0].count("\n")
            # os.path.isfile is False for a name that is too long, unlike Path.is_file.
            folders = (file.parent, main.parent)
            places = [folder / of for folder in folders if os.path.isfile(folder / of)]
            if not places:
                # A file included before CEND matters to the solver only, so it may be missing.
                if any(after.lstrip()[:4] == b"CEND" for after in lines[i:]):
                    continue
                raise line.refused("INCLUDE", f"there is no file {of!r}")
            included = places[0].resolve()
            if included in (*within, file):
                raise line.refused("INCLUDE", f"{of!r} includes itself")
            if add(included, (*within, file)):
                return True
        return False

    add(main, ())
    return found


# ---------------------------------------------------------------------------- entries from lines


class Piece(NamedTuple):
    """A line of bulk data: its name or continuation mark, its fields, and the mark at its end.

    The mark at the end, `tail`, announces a continuation. `spoilt` is true if the line has too many
    fields, or a field that is too long.
    """

    line: Line
    head: bytes
    fields: list[bytes]
    tail: bytes
    spoilt: bool = False


def _with_commas(line: Line, words: list[bytes]) -> Piece:
    """Return the `Piece` of a line with commas or a replicated line; `words`: head and fields."""
    head, *fields = words
    most, tail, more = 4 if b"*" in head else 8, b"", list[bytes]()
    # The ninth field holds data if more fields follow, unless it is a continuation mark.
    data = most == 8 and len(fields) > 9 and fields[8][:1] not in (b"", b"+", b"*")
    if len(fields) > most and not data:
        fields, (tail, *more) = fields[:most], fields[most:]
    elif fields and not data and _MARK.match(fields[-1]):
        tail = fields.pop()
    spoilt = any(more) or tail[:1].isdigit() or max(map(len, fields), default=0) > _LONG
    fields += [b""] * (-len(fields) % most or most * (not fields))
    return Piece(line, head[:8], fields, tail[:8], spoilt)


def _pieces(lines: list[Line]) -> list[Piece]:
    """Return a `Piece` for each line of bulk data, including lines that replication makes."""
    found: list[Piece] = []
    rule: list[bytes] = []
    for line in lines:
        text = line.text
        if text.startswith(b"="):
            before = [found[-1].head.strip(), *found[-1].fields[:8]] if found else []
            copies, rule = _copies(line, before, rule)
            found += [_with_commas(line, words) for words in copies]
            continue
        rule = []
        if b"," in text[:10]:
            found.append(_with_commas(line, _words(text)))
        else:
            width = 16 if b"*" in text[:8] else 8
            fields = [text[k : k + width].strip() for k in range(8, 72, width)]
            found.append(Piece(line, text[:8], fields, text[72:_COLUMNS]))
    return found


def _words(line: bytes) -> list[bytes]:
    """Return the first word and the fields of a line, with or without commas."""
    free = b"," in line[:10] or b" " not in line
    words = line.split(b",") if free else [line[k : k + 8] for k in range(0, 72, 8)]
    return [one.strip() for one in words]


def _copies(
    line: Line, entry: list[bytes], rule: list[bytes]
) -> tuple[list[list[bytes]], list[bytes]]:
    """Return the entries that a replication line generates, and the rule it applies.

    The rule is the line's fields: "=" copies a field of the previous entry, "==" copies all further
    fields, "*2" or "*(2)" adds an increment. "=5" or "=(5)" applies the previous line's rule five
    times.
    """
    head, *fields = _words(line.text)[:9]
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
        why = f"{line.text.decode()!r} is not understood"
        raise line.refused("replication", why) from None
    return found, rule


def _next(entry: list[bytes], rule: list[bytes]) -> list[bytes]:
    """Return the fields of the entry that a replication rule makes from the previous entry."""
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


def read_bulk_data(lines: list[Line]) -> BulkData:
    """Return the entries of bulk data, joined from their lines.

    A continuation without a mark, or with the mark that ends the previous line, continues the
    previous line. Any other continues the only line that ends in its mark. Marks are compared
    without their first character.

    Raises
    ------
    MeshError
        If a line neither begins nor continues an entry.
    """
    pieces = _pieces(lines)
    parents: dict[bytes, list[int]] = {}
    for k, piece in enumerate(pieces):
        if mark := piece.tail.strip():
            parents.setdefault(mark[1:], []).append(k)
    starts, child = list[int](), dict[int, int]()
    for k, (line, head, *_) in enumerate(pieces):
        if head[:1] not in (b"+", b"*") and head.strip():
            starts.append(k)
            continue
        parent = k - 1
        if (mark := head[1:].strip()) and (not k or mark != pieces[parent].tail[1:].strip()):
            found = parents.get(head.strip()[1:], [])
            if len(found) != 1 and parent not in found:
                why = f"the mark {head.decode()!r} is at the end of {len(found)} lines, not of one"
                raise line.refused("continuation", why)
            parent = parent if parent in found else found[0]
        if parent < 0:
            raise line.refused("continuation", "there is no entry before it")
        if child.setdefault(parent, k) != k:
            raise line.refused("continuation", "the line before it has another continuation")
    names: dict[str, list[list[Piece]]] = {}
    for start in starts:
        own, half, at = [pieces[start]], b"*" in pieces[start].head, child.pop(start, None)
        while at is not None:
            own.append(pieces[at])
            if half and b"*" not in own[-1].head:
                why = "large fields before it fill only half a line; add '*'"
                raise own[-1].line.refused("continuation", why)
            half, at = half != (b"*" in own[-1].head), child.pop(at, None)
        # meshio writes CTETRA_, CHEXA_ etc. for elements with midside nodes.
        name = own[0].head.strip().removesuffix(b"*").strip().removesuffix(b"_")
        if not _NAME.fullmatch(name):
            text = own[0].line.text[:24].decode()
            raise own[0].line.refused(repr(text), "an entry must begin with its name")
        names.setdefault(name.decode(), []).append(own)
    for at in sorted(child.values())[:1]:
        raise pieces[at].line.refused("continuation", "its marks go round in a circle")
    return BulkData(names)


@record
class Card:
    """One entry of bulk data; `fields` begins with the entry's field 2, after the name."""

    name: str
    fields: list[str]
    line: Line

    def error(self, why: str) -> MeshError:
        """Return the error that names this entry and its line."""
        return self.line.refused(self.name, why)

    def text(self, at: int) -> str:
        """Return a field as text; "" beyond the last field."""
        return self.fields[at] if at < len(self.fields) else ""

    def real(self, at: int, what: str, default: float | None = None) -> float:
        """Return a field as a number, or `default` if blank; refuse a blank without a default."""
        if not self.text(at):
            if default is None:
                raise self.error(f"{what} must not be blank")
            return default
        try:
            return number(self.text(at))
        except ValueError as wrong:
            raise self.error(str(wrong)) from None

    def integer(self, at: int, what: str, default: int = 0) -> int:
        """Return a field as an integer, which may be written 4, +4 or 04; `default` if blank."""
        text = self.text(at)
        if text and not INTEGER.fullmatch(text.encode()):
            raise self.error(f"{what} must be an integer, got {text!r}")
        return int(text or default)

    def reals(self, first: int, names: str) -> list[float]:
        """Return a number for each of the `names`, from field `first` on; refuse blank fields."""
        return [self.real(first + i, name) for i, name in enumerate(names.split())]

    def must_be(self, at: int, what: str, wanted: float) -> None:
        """Refuse a field unless it is blank or has the value `wanted`, which is its default."""
        value = self.real(at, what, wanted)
        if abs(value - wanted) > _DIGITS * abs(wanted):
            raise self.error(f"{what} must be {wanted:g}, got {value:g}, which is not supported")


@record
class BulkData:
    """Entries of bulk data by name; each entry is the list of its lines."""

    names: dict[str, list[list[Piece]]]

    def _fields(self, name: str, entry: list[Piece]) -> list[bytes]:
        """Return all fields of an entry, from field 2 on."""
        for piece in entry:
            if piece.spoilt:
                why = f"the line has too many fields, or one of more than {_LONG} characters"
                raise piece.line.refused(name, why)
        return [field for piece in entry for field in piece.fields]

    def table(self, **widths: int) -> Table:
        """Return a table of entries; `widths`: the largest number of data fields for each name.

        Blank fields are filled from GRDSET, BAROR and BEAMOR. If an entry holds two rods or two
        coordinate systems, a row for the second is added at the end of the table.
        """
        found = [(name, of) for name in widths for of in self.names.get(name, ())]
        found.sort(key=lambda one: one[1][0].line.order)
        rows, surplus, width = [], [], max(8, *widths.values())
        for name, entry in found:
            fields = self._fields(name, entry)
            surplus.append(any(fields[widths[name] :]))
            rows.append((fields + width * [b""])[:width])
        names = np.array([name for name, _ in found], "U8")
        lines = np.fromiter((entry[0].line for _, entry in found), object)
        table = Table(names, lines, np.array(rows, "S").reshape(-1, width))
        table.refuse_first(np.array(surplus), "it has more fields than entries of this kind")
        for name, default in _DEFAULTS.items():
            if name in widths and {name, default} <= self.names.keys():
                given = self.table(**{default: 8})
                given.refuse_first(np.arange(len(given)) > 0, "only one such entry is allowed")
                blank = table.blank & (table.names == name)[:, None]
                blank[:, 8:] = False
                if name != "GRID":  # an integer instead of X1 is node G0; then X2, X3 are unused
                    real = table.blank[:, 4] | (np.char.count(table.fields[:, 4], b".") > 0)
                    blank[:, 5:7] &= real[:, None]
                filled = np.where(blank, np.resize(given.fields[0], width), table.fields)
                table = replace(table, fields=filled)
        pairs = np.isin(table.names, _PAIRS)
        second = pairs & ~table.blank[:, 4:8].all(axis=1)
        every = table.select(np.append(np.arange(len(found)), np.flatnonzero(second)))
        every.fields[len(found) :] = np.roll(table.fields[second], -4, axis=1)
        every.fields[np.append(pairs, second[second]), 4:] = b""
        return every

    def quads(self, name: str) -> tuple[Table, IntArray]:
        """Return all fields of the named entries, four per row, and each row's entry number."""
        rows, entries, lines = list[list[bytes]](), list[int](), list[Line]()
        for i, entry in enumerate(self.names.get(name, ())):
            fields = self._fields(name, entry)
            rows += [fields[k : k + 4] for k in range(0, len(fields), 4)]
            entries += [i] * (len(fields) // 4)
            lines += [of.line for of in entry for _ in of.fields[::4]]
        whole = np.array(rows, "S").reshape(-1, 4)
        table = Table(np.full(len(rows), name), np.fromiter(lines, object), whole)
        return table, np.array(entries, int)

    def cards(self, *names: str) -> Iterator[Card]:
        """Yield a `Card` for each entry of the given names, in the order of the names."""
        for name in names:
            for entry in self.names.get(name, ()):
                texts = [field.decode() for field in self._fields(name, entry)]
                yield Card(name, texts, entry[0].line)


@record
class Table:
    """Entries of similar kinds as arrays, one row per entry in the order of the deck.

    Attributes
    ----------
    names : ndarray of str, shape (n,)
        Name of each entry.
    lines : ndarray of Line, shape (n,)
        First line of each entry.
    fields : ndarray of bytes, shape (n, width)
        Data fields, from field 2 of an entry on.
    """

    names: npt.NDArray[np.str_]
    lines: npt.NDArray[np.object_]
    fields: npt.NDArray[Any]

    def __len__(self) -> int:
        return len(self.fields)

    @cached_property
    def blank(self) -> BoolArray:
        """True for fields without content, shape (n, width)."""
        return np.asarray(self.fields == b"")

    def select(self, rows: IntArray | BoolArray) -> Table:
        """Return a table of the entries in `rows`, given as numbers or as a mask."""
        return Table(self.names[rows], self.lines[rows], self.fields[rows])

    def refused(self, row: int, why: str) -> MeshError:
        """Return the error for the entry in a row."""
        found: MeshError = self.lines[row].refused(str(self.names[row]), why)
        return found

    def refuse_first(self, wrong: BoolArray, why: str) -> None:
        """Raise an error for the first entry for which `wrong` is true, if any."""
        for row in np.flatnonzero(wrong)[:1].tolist():
            raise self.refused(row, why)

    def integers(self, first: int, count: int) -> IntArray:
        """Return `count` fields from `first` on as integers, shape (n, count); blanks are 0."""
        text = self._filled(first, count)
        try:
            if b"_" in text.tobytes():  # Python would read 1_0 as a number
                raise ValueError
            found: IntArray = text.astype(np.int64)
        except (ValueError, OverflowError):
            wrong = [INTEGER.fullmatch(one) is None for one in text.ravel().tolist()]
            self._refuse(first, np.reshape(wrong, text.shape), "an integer")
        return found

    def reals(self, first: int, count: int) -> FloatArray:
        """Return `count` fields from `first` on as numbers, shape (n, count); blanks are 0."""
        text = self._filled(first, count)
        found = numbers(text.ravel()).reshape(text.shape)
        self._refuse(first, np.isnan(found), "a real number")
        return found

    def _filled(self, first: int, count: int) -> npt.NDArray[Any]:
        text = self.fields[:, first : first + count]
        return np.where(text == b"", b"0", text)

    def _refuse(self, first: int, wrong: BoolArray, what: str) -> None:
        for row, column in np.argwhere(wrong)[:1].tolist():
            text = self.fields[row, first + column].decode()
            raise self.refused(row, f"field {first + column + 2} must be {what}, got {text!r}")
