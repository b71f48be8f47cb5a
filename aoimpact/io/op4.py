"""Reader of Nastran's OUTPUT4 files: text or binary of either byte order, dense or sparse.

The format is that of the Nastran manuals. A matrix is a header and columns. Each column gives its
first row (0 if sparse) and its number of words, then one string of numbers if dense, several if
sparse. A sparse string begins with its length and row: in two words in BIGMAT files, which have a
negative number of rows, else in one word, row + 65536 (length + 1). `_matrix` parses this
structure; `_Binary` and `_Text` supply its integers and numbers.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np

from ..base import FloatArray, InputError, sp
from .raw import RawMatrix, numbers, passed_over, spoilt

# Bytes per word of a binary file, for each length of the header in bytes.
_HEADERS = {24: 4, 48: 8}

# Smallest number of rows with which a sparse matrix is written as BIGMAT.
_BIG = 65536

# Pattern of a text header: columns, rows, form and type, right-aligned in fields of 8 characters
# (or 16 for columns and rows), then the name.
_TEXT = re.compile(
    rb"([ \d]{7}\d|[ \d]{15}\d)([ \d-]{7}\d|[ \d-]{15}\d)([ \d]{7}\d)([ \d]{7}\d)(.*)"
)

# Pattern of what follows the type in OUTPUT4: a name, or 8 characters and the format of the
# numbers. Other kinds of files have a number there.
_NAMED = re.compile(rb"\s*[A-Za-z]|.{8}\s*1P,")


def is_op4(head: bytes) -> bool:
    """Return whether a file begins with an OUTPUT4 header, in text or binary."""
    text = _TEXT.match(head)
    return _binary(head) is not None or (text is not None and bool(_NAMED.match(text[5])))


def read_op4(file: Path) -> list[RawMatrix]:
    """Return all matrices of a file."""
    content = file.read_bytes()
    kind = _binary(content)
    source = _Text(file, content) if kind is None else _Binary(file, content, *kind)
    found = []
    try:
        while source.more():
            found.append(_matrix(file, source))
    except (struct.error, IndexError):
        raise spoilt(file, "it ends within a matrix: it is cut short") from None
    except InputError:
        raise
    except (ValueError, OverflowError):
        raise source.wrong("a count or row number is no integer, or too large") from None
    return found


def _binary(head: bytes) -> tuple[str, int] | None:
    """Return byte order and bytes per word of a binary file; None for other files."""
    for order in "<>":
        length = int.from_bytes(head[:4], "little" if order == "<" else "big")
        word = _HEADERS.get(length)
        if word and len(head) >= length + 8 and head[length + 4 : length + 8] == head[:4]:
            return order, word
    return None


def _matrix(file: Path, source: _Binary | _Text) -> RawMatrix:
    """Return the next matrix; each of its strings holds consecutive rows of a column."""
    n_cols, n_rows, kind, name = source.header()
    if kind not in (1, 2, 3, 4):
        raise source.wrong(f"the type of {name} must be 1 to 4, got {kind}")
    big, n_rows = n_rows < 0 or n_rows >= _BIG, abs(n_rows)
    strings: list[tuple[int, int, FloatArray]] = []  # first row, column and numbers
    while True:
        col, row, words = source.column()
        if not 1 <= col <= n_cols + 1 or words < 0:
            raise source.wrong(f"{name} has {n_cols} columns, got column {col} of {words} words")
        if col == n_cols + 1:
            break
        while row > 0 or words > 0:
            if row > 0:
                count, words = words // source.per_column, 0
            else:
                length, row = source.integers(2) if big else divmod(source.integers(1)[0], 65536)
                count, rest = divmod(length - 1, source.per_number)
                if length < 1 or row < 1 or rest:
                    raise source.wrong(f"a string at row {row} cannot have {length} words")
                words -= length + int(big)
            last = row - 1 + count // (2 if kind > 2 else 1)
            if last > n_rows:
                raise source.wrong(f"{name}: a column has row {last}, the matrix {n_rows} rows")
            strings.append((row - 1, col - 1, source.take(count)))
            row = 0
    source.end()
    if kind > 2:
        return passed_over(file, name, "complex")
    if n_rows != n_cols:
        return passed_over(file, name, f"{n_rows} by {n_cols}")
    counts = [len(numbers) for *_, numbers in strings]
    firsts, cols = (np.repeat([one[i] for one in strings], counts).astype(int) for i in (0, 1))
    values = np.concatenate([np.zeros(0), *(numbers for *_, numbers in strings)])
    within = np.arange(len(values)) - np.repeat(np.cumsum(counts) - counts, counts).astype(int)
    matrix = sp.coo_array((values, (firsts + within, cols)), shape=(n_rows, n_cols))
    matrix.eliminate_zeros()
    return RawMatrix(file, name, matrix)


class _Binary:
    """Reads a binary file by records; the length of a record is stored before and after it."""

    def __init__(self, file: Path, content: bytes, order: str, word: int) -> None:
        self._file, self._content, self._order, self._word = file, content, order, word
        self._at = self._next = 0  # positions of the next record, and of the next item to read

    def more(self) -> bool:
        return self._at < len(self._content)

    def wrong(self, why: str) -> InputError:
        return spoilt(self._file, f"at byte {self._at}: {why}")

    def _record(self) -> int:
        """Move to the start of the next record; return the position of its end."""
        (length,) = struct.unpack_from(self._order + "i", self._content, self._at)
        start = self._at + 4
        end: int = start + length
        if length < 0 or end + 4 > len(self._content):
            raise self.wrong(f"a record of {length} bytes goes beyond its end: it is cut short")
        if self._content[end : end + 4] != self._content[self._at : start]:
            raise self.wrong("a record does not end with its length")
        self._at, self._next = end + 4, start
        return end

    def header(self) -> tuple[int, int, int, str]:
        """Return columns, rows, type and name of the next matrix."""
        end = self._record()
        if end - self._next != 6 * self._word:
            raise self.wrong("a header of a matrix should stand here")
        n_cols, n_rows, _, kind = self.integers(4)
        name = self._content[self._next : end].replace(b"\0", b" ").decode("latin-1")
        self._width = 8 if self._word == 8 or kind % 2 == 0 else 4
        self.per_number = self.per_column = self._width // self._word
        return n_cols, n_rows, kind, name.replace(" ", "").upper()

    def column(self) -> tuple[int, ...]:
        """Return number, first row and count of words of the next column."""
        end = self._record()
        col, row, words = self.integers(3)
        if self._next + words * self._word > end:
            raise self.wrong(f"column {col} has {words} words, more than its record holds")
        return col, row, words

    def integers(self, count: int) -> tuple[int, ...]:
        kind = f"{self._order}{count}{'i' if self._word == 4 else 'q'}"
        found: tuple[int, ...] = struct.unpack_from(kind, self._content, self._next)
        self._next += count * self._word
        return found

    def take(self, count: int) -> FloatArray:
        """Return the next `count` numbers."""
        kind = f"{self._order}f{self._width}"
        found = np.frombuffer(self._content, kind, count, self._next).astype(float)
        self._next += count * self._width
        return found

    def end(self) -> None:
        """Do nothing: the number after the last column is part of that column's record."""


class _Text:
    """Reads a text file line by line; numbers are in fields of fixed width."""

    per_column = 1

    def __init__(self, file: Path, content: bytes) -> None:
        self._file, self._lines, self._at = file, content.split(b"\n"), 0

    def more(self) -> bool:
        return self._at < len(self._lines) and bool(self._lines[self._at].strip())

    def wrong(self, why: str) -> InputError:
        return spoilt(self._file, why, self._at)

    def header(self) -> tuple[int, int, int, str]:
        """Return columns, rows, type and name of the next matrix; set the format of its numbers."""
        line = self._next()
        found = _TEXT.match(line)
        if found is None:
            raise self.wrong("a header of a matrix should stand here")
        n_cols, n_rows, _, kind = map(int, found.groups()[:4])
        shape = re.search(rb"(\d+)[ED](\d+)\.\d+", line[found.start(5) + 8 :].upper())
        self._per_line, self._width = (int(shape[1]), int(shape[2])) if shape else (5, 16)
        if not 1 <= self._per_line * self._width <= 1000:
            raise self.wrong("its numbers are printed in no known form")
        self.per_number = 1 if kind % 2 else 2
        return n_cols, n_rows, kind, found[5][:8].decode().replace(" ", "").upper()

    def column(self) -> tuple[int, ...]:
        """Return number, first row and count of words of the next column."""
        return self.integers(3)

    def integers(self, count: int) -> tuple[int, ...]:
        words = self._next().split()
        if len(words) != count:
            raise self.wrong(f"{count} integers should stand here: is it cut short?")
        return tuple(map(int, words))

    def take(self, count: int) -> FloatArray:
        """Return the next `count` numbers."""
        n_lines, full = -(-count // self._per_line), self._per_line * self._width
        if n_lines > len(self._lines) - self._at:
            raise self.wrong(f"{count} numbers should follow: it is cut short")
        block = self._lines[self._at : self._at + n_lines]
        self._at += n_lines
        lines = [one.rstrip(b"\r").ljust(full)[:full] for one in block]
        printed = b"".join(lines)[: count * self._width]
        found = numbers(np.frombuffer(printed, dtype=f"S{self._width}"))
        if np.isnan(found).any():
            shown = printed[: self._per_line * self._width].decode("latin-1")
            raise self.wrong(f"{count} numbers should end here, got {shown!r}: is it cut short?")
        return found

    def end(self) -> None:
        """Skip the number after the last column."""
        self.take(1)

    def _next(self) -> bytes:
        if self._at >= len(self._lines):
            raise self.wrong("it ends within a matrix: it is cut short")
        self._at += 1
        return self._lines[self._at - 1]
