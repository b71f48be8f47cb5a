"""Keywords of Abaqus and CalculiX decks, and the data lines under each.

`*INCLUDE` puts the lines of another file in its place, wherever it stands. Names of keywords and
options are compared in capitals and without blanks.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from ...base import FloatArray, IntArray, MeshError, MissingFileError, decoded
from .textfile import number, read_lines, refused

__all__ = ["Keyword", "fields", "key", "looks_like_inp", "read_keywords"]

# Numbers of a data line that has no room for more.
_FULL = 16

# Largest number of a node or element: as a double it is exact.
_MOST = 2**53

# Files that a deck may include in all, so that files which include each other twice end as well.
_MOST_INCLUDED = 2000

_INTEGER = re.compile(r"[+-]?\d+")

# Keywords whose data may stand in another file.
_WITH_INPUT = frozenset(("NODE", "ELEMENT", "NSET", "ELSET"))

_BEGIN = re.compile(r"(?:\s*\*\*.*\n)*\s*\*\s*([A-Za-z][A-Za-z -]*)")

# Keywords that a mesh begins with.
_FIRST = frozenset(("HEADING", "NODE", "ELEMENT", "PART", "INCLUDE", "PREPRINT", "NSET", "ELSET"))


@dataclass(frozen=True, eq=False)
class _Piece:
    """Lines of a file: the numbers of the first and of the one after the last, from 0."""

    file: Path
    lines: list[str]
    start: int
    stop: int

    def data(self) -> list[str]:
        """Return the data lines, without blanks at their ends, comments and empty lines."""
        lines = self.lines[self.start : self.stop]
        return [text for line in lines if (text := line.strip()) and text[:2] != "**"]

    def numbers(self) -> list[int]:
        """Return the numbers of the lines of `data`, from 1."""
        numbered = enumerate(self.lines[self.start : self.stop], self.start + 1)
        return [i for i, line in numbered if (text := line.strip()) and text[:2] != "**"]


@dataclass(frozen=True, eq=False)
class Keyword:
    """A keyword with its options and data lines.

    Attributes
    ----------
    name : str
        In capitals, without star and blanks, as in "SOLIDSECTION".
    given : tuple of str
        What follows the name, as in "ELSET=Bar".
    file : Path
    line : int
        Counted from 1.
    """

    name: str
    given: tuple[str, ...]
    file: Path
    line: int
    _pieces: list[_Piece] = field(default_factory=list)

    @cached_property
    def options(self) -> dict[str, str]:
        """Values by the options' names in capitals; empty for an option without a value."""
        found: dict[str, str] = {}
        for each in self.given:
            name, _, value = each.partition("=")
            if each.count('"') % 2:
                raise self.error(f"a quotation mark is missing: {each}")
            if key(name) in found:
                raise self.error(f"the option {key(name)} is there twice")
            if each:
                found[key(name)] = value.strip()
        return found

    @cached_property
    def data(self) -> list[str]:
        """Its data lines, without blanks at their ends, comments and empty lines."""
        return [text for piece in self._pieces for text in piece.data()]

    def error(self, why: str, data_line: int | None = None) -> MeshError:
        """Return the error that names the file, the line and the keyword.

        Parameters
        ----------
        why : str
        data_line : int, optional
            Which of `data` is wrong, from 0; the keyword itself if left out.
        """
        file, line = self.file, self.line
        if data_line is not None:
            places = [(piece.file, i) for piece in self._pieces for i in piece.numbers()]
            file, line = places[data_line]
        return refused(file, line, f"*{self.name}", why)

    def check_options(self, known: Collection[str]) -> None:
        """Refuse an option that is not known: it may change the mesh."""
        for name in self.options:
            if name not in known:
                raise self.error(f"the option {name} is not supported")

    def rows(self) -> list[list[str]]:
        """Return the fields of each data line, without empty ones at the end."""
        return [fields(line) for line in self.data]

    def integers(self, row: int, texts: list[str]) -> list[int]:
        """Return integers of a data line; the row is the line's number, for errors."""
        for text in texts:
            if not _INTEGER.fullmatch(text):
                raise self.error(f"{text!r} is no integer", row)
        return [int(text) for text in texts]

    def span(self, row: int, texts: list[str]) -> tuple[int, int, int]:
        """Return a first number, a last one and a step that leads there; 1 if it is left out."""
        if not 2 <= len(texts) <= 3:
            raise self.error("give the first and the last number, and perhaps a step", row)
        first, last, step = [*self.integers(row, [text or "1" for text in texts]), 1][:3]
        if step == 0 or (last - first) / step < 0:
            raise self.error(f"no step of {step} leads from {first} to {last}", row)
        return first, last, step

    def reals(self, row: int, texts: list[str]) -> list[float]:
        """Return numbers of a data line; blanks are 0."""
        try:
            return [number(text) if text else 0.0 for text in texts]
        except ValueError as error:
            raise self.error(str(error), row) from None

    def first_numbers(self) -> IntArray:
        """Return the first number of each data line that is not the continuation of another."""
        found, goes_on = [], False
        for row, texts in enumerate(self.rows()):
            if not goes_on:
                found += self.integers(row, texts[:1])
            goes_on = self.data[row].endswith(",")
        return np.array(found, dtype=np.int64)

    def points(self) -> tuple[IntArray, FloatArray]:
        """Return labels and coordinates of the data lines of *NODE; the last may be left out."""
        table = _numbers([line.rstrip(", \t") for line in self.data], 4, np.float64)
        if table is None or (np.abs(table[:, 0]) > _MOST).any():
            rows = [self._point(row, texts) for row, texts in enumerate(self.rows())]
            table = np.reshape(np.array(rows), (-1, 4))
        labels = table[:, 0].astype(np.int64)
        wrong = np.flatnonzero((labels != table[:, 0]) | (labels < 1))
        if len(wrong):
            raise self.error("the number of a node must be a positive integer", int(wrong[0]))
        return labels, table[:, 1:]

    def _point(self, row: int, texts: list[str]) -> list[float]:
        if len(texts) > 7:  # with a normal
            raise self.error("a node has a number, three coordinates and a normal at most", row)
        (label,) = self.integers(row, texts[:1])
        if not 0 < label <= _MOST:
            raise self.error("the number of a node must be a positive integer", row)
        return [float(label), *self.reals(row, [*texts[1:4], "", "", ""][:3])]

    def connectivity(self, n_nodes: int) -> IntArray:
        """Return labels of elements and of their nodes, shape (n, 1 + n_nodes).

        An element begins on a line of its own. It goes on in the next one after a comma, or after
        16 numbers, with which a line is full.
        """
        lines = [line.rstrip(", \t") for line in self.data]
        counts = np.array([line.count(",") + 1 for line in lines], dtype=np.int64)
        ends = np.cumsum(counts)
        width = 1 + n_nodes
        count = -(-int(ends[-1]) // width) if lines else 0
        wanted = width * np.arange(1, count + 1)
        last = np.minimum(np.searchsorted(ends, wanted), len(lines) - 1)
        off = np.flatnonzero(ends[last] != wanted)
        if len(off):
            row = int(last[off[0] - 1]) + 1 if off[0] else 0
            raise self.error(f"the element must have {n_nodes} nodes, and end with its line", row)
        if count < len(lines):
            for row in np.setdiff1d(np.arange(len(lines)), last).tolist():
                if not self.data[row].endswith(",") and counts[row] != _FULL:
                    raise self.error("a line that goes on in the next one ends with a comma", row)
            first = [0, *(last[:-1] + 1).tolist()]
            lines = [",".join(lines[i : j + 1]) for i, j in zip(first, last.tolist(), strict=True)]
        table = _numbers(lines, width, np.int64)
        if table is None or (table < 1).any():
            for row, texts in enumerate(self.rows()):
                if not all(0 < each <= _MOST for each in self.integers(row, texts)):
                    raise self.error("numbers must be positive, and below 2^53", row)
            raise self.error("its numbers cannot be read")
        found: IntArray = table
        return found


def _numbers(lines: list[str], width: int, kind: Any) -> Any:
    """Return the numbers of lines, shape (n, width), or None if a closer look is needed."""
    if not lines:
        return np.zeros((0, width), dtype=kind)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numbers like 1.5 for integers
            table = np.loadtxt(lines, dtype=kind, delimiter=",", comments=None, ndmin=2)
    except (ValueError, OverflowError, Warning):
        return None
    return table if table.shape[1] == width and np.isfinite(table).all() else None


def fields(line: str) -> list[str]:
    """Return the fields of a line between commas, without blanks about them, nor empty last ones.

    Commas within quotation marks belong to the field.
    """
    if '"' in line:
        parts = line.split('"')
        parts[1::2] = [part.replace(",", "\0") for part in parts[1::2]]
        line = '"'.join(parts)
    found = [text.strip().replace("\0", ",") for text in line.split(",")]
    while found and not found[-1]:
        found.pop()
    return found


def key(name: str) -> str:
    """Return a name as it is compared: in capitals without blanks, or as it is within quotes."""
    text = name.strip()
    if len(text) > 1 and text[0] == text[-1] == '"':
        return text[1:-1]
    return re.sub(r"\s", "", text).upper()


def looks_like_inp(head: bytes) -> bool:
    """Return whether a file whose content begins so is a deck of Abaqus or CalculiX."""
    found = _BEGIN.match((decoded(head) or "").lstrip("\ufeff"))
    return found is not None and key(found[1]) in _FIRST


def read_keywords(file: Path) -> list[Keyword]:
    """Return the keywords of a deck and of the files that it includes, in order.

    Raises
    ------
    MissingFileError
        If a file is not there.
    MeshError
        If there are data before the first keyword, or files include each other.
    """
    return _Deck(file.parent, {}, []).read(file, ())


@dataclass(eq=False)
class _Deck:
    """Keywords of a deck as they are read."""

    folder: Path
    texts: dict[Path, list[str]]
    found: list[Keyword]
    included: int = 0

    def read(self, file: Path, outer: tuple[Path, ...]) -> list[Keyword]:
        """Add the keywords of a file, which the `outer` ones include."""
        if file not in self.texts:
            self.texts[file] = read_lines(file)
        lines = self.texts[file]
        starts = [
            i
            for i, line in enumerate(lines)
            if "*" in line and (text := line.lstrip())[:1] == "*" and text[1:2] != "*"
        ]
        self.go_on(_Piece(file, lines, 0, starts[0] if starts else len(lines)))
        for start, stop in zip(starts, [*starts, len(lines)][1:], strict=True):
            keyword, after = _keyword(file, lines, start, stop)
            if keyword.name == "INCLUDE":
                keyword.check_options(("INPUT", "FILE"))
                self.read(self.beside(keyword, (*outer, file)), (*outer, file))
            else:
                self.found.append(keyword)
                if keyword.name in _WITH_INPUT and "INPUT" in keyword.options:
                    other = self.beside(keyword, (*outer, file))
                    piece = _Piece(other, data := read_lines(other), 0, len(data))
                    if any(line.startswith("*") for line in piece.data()):
                        raise keyword.error(f"{str(other)!r} must hold data lines only")
                    keyword._pieces.append(piece)
            self.go_on(_Piece(file, lines, after, stop))
        return self.found

    def go_on(self, piece: _Piece) -> None:
        """Add data lines to the last keyword."""
        if self.found:
            self.found[-1]._pieces.append(piece)
        elif data := piece.data():
            why = "a deck of Abaqus or CalculiX begins with *"
            raise refused(piece.file, piece.numbers()[0], repr(data[0][:40]), why)

    def beside(self, keyword: Keyword, outer: tuple[Path, ...]) -> Path:
        """Return the path of the file that an option INPUT, or FILE, names."""
        options = keyword.options
        given = (options.get("INPUT") or options.get("FILE") or "").strip('"').replace("\\", "/")
        if not given:
            raise keyword.error("INPUT=file is missing")
        folders = (self.folder, keyword.file.parent)
        places = [folder / PurePosixPath(given) for folder in folders]
        place = next((place for place in places if place.is_file()), None)
        if place is None:
            raise MissingFileError(str(keyword.error(f"there is no file {str(places[0])!r}")))
        self.included += 1
        if place.resolve() in {file.resolve() for file in outer}:
            raise keyword.error(f"{str(place)!r} includes itself")
        if self.included > _MOST_INCLUDED:
            raise keyword.error(f"more than {_MOST_INCLUDED} files are included")
        return place


def _keyword(file: Path, lines: list[str], start: int, stop: int) -> tuple[Keyword, int]:
    """Return the keyword of a line, and the number of the line after it and its continuation."""
    text, after = lines[start].strip(), start + 1
    while text.endswith(",") and after < stop:
        line = lines[after].strip()
        after += 1
        if line[:2] != "**":
            text += line or " "
    name, *given = fields(text[1:]) or [""]
    return Keyword(key(name), tuple(given), file, start + 1), after
