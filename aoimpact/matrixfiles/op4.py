"""Nastran's OUTPUT4 files: text or binary of either byte order, dense or sparse.

The format is that of the Nastran manuals: a header, then columns, each with its first row (0 where
it is sparse) and its number of words; a column is one string of numbers, or, sparse, several. In
BIGMAT files, of a negative number of rows, a string begins with length and row, else with both in
one word, row + 65536 (length + 1).
"""

from __future__ import annotations

import re
import struct
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

from ..base import FloatArray, InputError
from .found import Found, spoilt, unfit

__all__ = ["is_op4", "read_op4"]

# The length of a binary header, bytes, with words of 4 and of 8 bytes.
_HEADERS = {24: 4, 48: 8}

# From so many rows on a sparse matrix has the strings of BIGMAT.
_BIG = 65536

# Columns, rows, form and type, right-aligned in fields of 8 (the first two also of 16), and name.
_TEXT = re.compile(
    rb"([ \d]{7}\d|[ \d]{15}\d)([ \d-]{7}\d|[ \d-]{15}\d)([ \d]{7}\d)([ \d]{7}\d)(.*)"
)

# A name, or the form of the numbers: no number, as other formats have it at this place.
_NAMED = re.compile(rb"\s*[A-Za-z]|.{8}\s*1P,")


@dataclass
class _Strings:
    """Strings of consecutive entries of columns: where each begins, and how long it is."""

    starts: array[int] = field(default_factory=lambda: array("q"))
    rows: array[int] = field(default_factory=lambda: array("q"))
    cols: array[int] = field(default_factory=lambda: array("q"))
    counts: array[int] = field(default_factory=lambda: array("q"))

    def add(self, start: int, row: int, col: int, count: int) -> None:
        self.starts.append(start)
        self.rows.append(row)
        self.cols.append(col)
        self.counts.append(count)

    def found(
        self, file: Path, name: str, kind: int, shape: tuple[int, int], numbers: _Numbers
    ) -> Found:
        """The matrix whose numbers are these."""
        if kind > 2:
            return unfit(file, name, "complex")
        if shape[0] != shape[1]:
            return unfit(file, name, f"{shape[0]} by {shape[1]}")
        counts = np.frombuffer(self.counts, dtype=np.int64)
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        rows = np.repeat(np.frombuffer(self.rows, dtype=np.int64), counts) + within
        cols = np.repeat(np.frombuffer(self.cols, dtype=np.int64), counts)
        starts = np.repeat(np.frombuffer(self.starts, dtype=np.int64), counts)
        values = numbers.at(starts, within)
        keep = values != 0.0
        return Found(file, name, shape[0], rows[keep], cols[keep], values[keep])


class _Numbers(Protocol):
    """The numbers of a file, by the place where a string begins and their place in it."""

    def at(self, starts: np.ndarray, within: np.ndarray) -> FloatArray: ...


def is_op4(head: bytes) -> bool:
    """Whether a file begins with a header of OUTPUT4, in text or binary."""
    text = _TEXT.match(head)
    return _binary(head) is not None or (text is not None and bool(_NAMED.match(text[5])))


def read_op4(file: Path, size: int) -> list[Found]:
    """Read all matrices of a file."""
    content = file.read_bytes()
    try:
        return list(_Binary(file, content).matrices() if _binary(content) else _text(file, content))
    except (struct.error, IndexError):
        raise spoilt(file, "it ends within a matrix: it is cut short") from None
    except OverflowError:
        raise spoilt(file, "a count or row in it is beyond any") from None


# ------------------------------------------------------------------------------- binary


def _binary(head: bytes) -> tuple[str, int] | None:
    """The byte order and bytes of a word of a binary file; None if it is none."""
    for order in "<>":
        length = int.from_bytes(head[:4], "little" if order == "<" else "big")
        word = _HEADERS.get(length)
        if word and len(head) >= length + 8 and head[length + 4 : length + 8] == head[:4]:
            return order, word
    return None


class _Words:
    """Numbers of a binary file, at offsets of bytes that are multiples of 4."""

    def __init__(self, content: bytes, order: str, width: int) -> None:
        self._words = np.frombuffer(content[: len(content) // 4 * 4], dtype=np.uint32)
        self._kind, self._width = np.dtype(f"{order}f{width}"), width

    def at(self, starts: np.ndarray, within: np.ndarray) -> FloatArray:
        per = self._width // 4
        first = starts // 4 + per * within
        words = np.stack([self._words[first + i] for i in range(per)], axis=-1)
        numbers: FloatArray = np.ascontiguousarray(words).view(self._kind).ravel().astype(float)
        return numbers


class _Binary:
    """A binary file, record by record: each has its length before and after it."""

    def __init__(self, file: Path, content: bytes) -> None:
        kind = _binary(content)
        assert kind is not None
        self._file, self._content, self._at = file, content, 0
        order, self._word = kind
        self._order = order
        self._length = struct.Struct(order + "i")
        letter = "i" if self._word == 4 else "q"
        self._one, self._two = struct.Struct(order + letter), struct.Struct(order + 2 * letter)
        self._three, self._four = (struct.Struct(order + n * letter) for n in (3, 4))

    def matrices(self) -> list[Found]:
        found = []
        while self._at < len(self._content):
            found.append(self._matrix())
        return found

    def _record(self) -> tuple[int, int]:
        """The bytes from where to where the next record goes."""
        length = self._length.unpack_from(self._content, self._at)[0]
        start = self._at + 4
        if length < 0 or start + length + 4 > len(self._content):
            raise self._wrong(f"a record of {length} bytes goes beyond its end: it is cut short")
        if self._length.unpack_from(self._content, start + length)[0] != length:
            raise self._wrong("a record does not end with its length")
        self._at = start + length + 4
        return start, start + length

    def _matrix(self) -> Found:
        start, end = self._record()
        if end - start != 6 * self._word:
            raise self._wrong("a header of a matrix should stand here")
        n_cols, n_rows, _, kind = self._four.unpack_from(self._content, start)
        raw = self._content[start + 4 * self._word : end]
        name = raw.replace(b"\0", b" ").decode("latin-1").replace(" ", "").upper()
        if kind not in (1, 2, 3, 4):
            raise self._wrong(f"{name} is of type {kind}; known are 1 to 4")
        width = 8 if self._word == 8 or kind % 2 == 0 else 4
        strings, rows = _Strings(), abs(n_rows)
        big = n_rows < 0 or n_rows >= _BIG
        while True:
            start, end = self._record()
            col, row, words = self._three.unpack_from(self._content, start)
            start += 3 * self._word
            if not 1 <= col <= n_cols + 1 or words < 0 or start + words * self._word > end:
                raise self._wrong(f"{name}: a column of number {col} of {words} words")
            if col == n_cols + 1:
                break
            stop = start + words * self._word
            if row > 0:
                strings.add(start, row - 1, col - 1, (stop - start) // width)
            while row == 0 and start < stop:
                start = self._string(strings, start, col - 1, width, big)
        _check(self._wrong, name, strings, rows, kind)
        return strings.found(
            self._file, name, kind, (rows, n_cols), _Words(self._content, self._order, width)
        )

    def _string(self, strings: _Strings, start: int, col: int, width: int, big: bool) -> int:
        """Take a string of a sparse column; return where it ends."""
        if big:
            length, row = self._two.unpack_from(self._content, start)
            start += 2 * self._word
        else:
            packed = self._one.unpack_from(self._content, start)[0]
            length, row = packed >> 16, packed & 0xFFFF
            start += self._word
        count = (length - 1) * self._word // width
        if length < 1 or row < 1:
            raise self._wrong(f"a string of {length} words at row {row}")
        strings.add(start, row - 1, col, count)
        stop: int = start + count * width
        return stop

    def _wrong(self, why: str) -> InputError:
        return spoilt(self._file, f"at byte {self._at}: {why}")


def _check(
    wrong: Callable[[str], InputError], name: str, strings: _Strings, n_rows: int, kind: int
) -> None:
    """Refuse strings that go beyond the last row."""
    if len(strings.rows):
        counts = np.frombuffer(strings.counts, np.int64) // (2 if kind > 2 else 1)
        rows = np.frombuffer(strings.rows, np.int64)
        last = np.minimum(rows, n_rows + 1) + counts  # any row, without overflow
        if last.max() > n_rows:
            raise wrong(f"{name}: a column goes to row {last.max()}, but there are {n_rows}")


# --------------------------------------------------------------------------------- text


class _Printed:
    """Numbers of fixed width, as they were found one after the other."""

    def __init__(self, parts: list[bytes], width: int) -> None:
        printed = b"".join(parts).replace(b"D", b"E")
        self._values = np.frombuffer(printed, dtype=f"S{width}").astype(float)

    def at(self, starts: np.ndarray, within: np.ndarray) -> FloatArray:
        values: FloatArray = self._values[starts + within]
        return values


def _text(file: Path, content: bytes) -> list[Found]:
    lines = content.split(b"\n")
    found, at = [], 0
    while at < len(lines) and lines[at].strip():
        reader = _Text(file, lines, at)
        found.append(reader.matrix())
        at = reader.at
    return found


class _Text:
    """A matrix in text, from a line on."""

    def __init__(self, file: Path, lines: list[bytes], at: int) -> None:
        self._file, self._lines, self.at = file, lines, at
        self._parts: list[bytes] = []
        self._ends: list[int] = []  # the line at which each ends
        self._numbers = 0

    def matrix(self) -> Found:
        line = self._next()
        header = _TEXT.match(line)
        if header is None:
            raise self._wrong("a header of a matrix should stand here")
        n_cols, n_rows, _, kind = (self._integer(one) for one in header.groups()[:4])
        name = header[5][:8].decode().replace(" ", "").upper()
        shape = re.search(rb"(\d+)[ED](\d+)\.\d+", line[header.start(5) + 8 :].upper())
        self._per_line, self._width = (int(shape[1]), int(shape[2])) if shape else (5, 16)
        if not 1 <= self._per_line * self._width <= 1000:
            raise self._wrong("its numbers are printed in no known form")
        self._per = 1 if kind % 2 else 2  # words of a number
        strings, big = _Strings(), n_rows < 0 or n_rows >= _BIG
        while True:
            col, row, words = self._integers(3)
            if not 1 <= col <= n_cols + 1 or words < 0:
                raise self._wrong(f"a column of number {col}, of {n_cols}, with {words} words")
            if col == n_cols + 1:
                self._take(1)
                break
            if row > 0:
                self._string(strings, row - 1, col - 1, words)
            while row == 0 and words > 0:
                words -= self._sparse(strings, col - 1, big)
        _check(self._wrong, name, strings, abs(n_rows), kind)
        try:
            numbers = _Printed(self._parts, self._width)
        except ValueError:
            raise self._no_number() from None
        return strings.found(self._file, name, kind, (abs(n_rows), n_cols), numbers)

    def _no_number(self) -> InputError:
        """The error at the first string of numbers that are none."""
        for part, line in zip(self._parts, self._ends, strict=True):
            try:
                _Printed([part], self._width)
            except ValueError:
                found = part[: self._per_line * self._width].decode("latin-1")
                return spoilt(self._file, f"numbers should stand here, got {found!r}", line)
        return spoilt(self._file, "its numbers cannot be read")

    def _sparse(self, strings: _Strings, col: int, big: bool) -> int:
        """Take a string of a sparse column; return its words."""
        if big:
            length, row = self._integers(2)
        else:
            packed = self._integers(1)[0]
            length, row = packed >> 16, packed & 0xFFFF
        if length < 1 or row < 1:
            raise self._wrong(f"a string of {length} words at row {row}")
        self._string(strings, row - 1, col, (length - 1) // self._per)
        return length + int(big)

    def _string(self, strings: _Strings, row: int, col: int, count: int) -> None:
        strings.add(self._numbers, row, col, count)
        self._parts.append(self._take(count))
        self._ends.append(self.at)
        self._numbers += count

    def _take(self, count: int) -> bytes:
        """The next so many numbers, as they are printed."""
        n_lines, full = -(-count // self._per_line), self._per_line * self._width
        if n_lines > len(self._lines) - self.at:
            raise self._wrong(f"{count} numbers should follow: it is cut short")
        lines = [one.rstrip(b"\r").ljust(full)[:full] for one in self._block(n_lines)]
        printed = b"".join(lines)[: count * self._width]
        if printed[-self._width :].strip() == b"" and count:
            raise self._wrong(f"{count} numbers should end here: is it cut short?")
        return printed

    def _block(self, n_lines: int) -> list[bytes]:
        block = self._lines[self.at : self.at + n_lines]
        self.at += n_lines
        return block

    def _next(self) -> bytes:
        if self.at >= len(self._lines):
            raise self._wrong("it ends within a matrix: it is cut short")
        return self._block(1)[0]

    def _integers(self, count: int) -> list[int]:
        words = self._next().split()
        if len(words) != count:
            raise self._wrong(
                f"{count} integers should stand here, got {len(words)} words: is it cut short?"
            )
        return [self._integer(word) for word in words]

    def _integer(self, word: bytes) -> int:
        try:
            return int(word)
        except ValueError:
            raise self._wrong(
                f"an integer should stand here, got {word.decode('latin-1')!r}"
            ) from None

    def _wrong(self, why: str) -> InputError:
        return spoilt(self._file, why, self.at)
