"""Parser of Abaqus and CalculiX decks: keywords, and the data lines under each.

`*INCLUDE` is replaced by the lines of another file, even within data lines. Names of keywords and
options are compared in capitals and without blanks.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..base import FloatArray, IntArray, MeshError, MissingFileError, decoded
from .raw import Line, columns, number, numbers, read_text

# Count of numbers in a full data line of *ELEMENT.
_FULL = 16

# Largest number of a node or element: doubles represent all integers up to this one exactly.
MOST = 2**53

# Largest number of included files: nested inclusions could otherwise multiply without end.
_MOST_INCLUDED = 2000

# Keywords whose data lines may be in another file (INPUT=).
_WITH_INPUT = frozenset(("NODE", "ELEMENT", "NSET", "ELSET"))

# A file that begins with one of these keywords is taken for a deck of Abaqus or CalculiX.
_FIRST = frozenset(("HEADING", "NODE", "ELEMENT", "PART", "INCLUDE", "PREPRINT", "NSET", "ELSET"))
_KEYWORD = re.compile(r"\s*\*(?!\*)")
_BEGIN = re.compile(r"(?:\s*\*\*.*\n)*\s*\*\s*([A-Za-z][A-Za-z -]*)")


@dataclass(eq=False)
class Keyword:
    """A keyword with its options and data lines.

    Attributes
    ----------
    name : str
        Name in capitals, without star and blanks, as in "SOLIDSECTION".
    given : list of str
        Options as written after the name, as in "ELSET=Bar".
    line : Line
        Line of the keyword. Its `order` is the number of the keyword in the deck.
    data : list of Line
        Data lines under the keyword, stripped of blanks, without comments and empty lines.
    part : str
        Name, in capitals, of the part that the keyword is in; "" outside of parts.
    labels : ndarray of int, shape (n,)
        Numbers of the nodes or elements that the keyword defines.
    """

    name: str
    given: list[str]
    line: Line
    data: list[Line] = field(default_factory=list)
    part: str = ""
    labels: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))

    @cached_property
    def options(self) -> dict[str, str]:
        """Values of the options by names in capitals; "" for an option without a value."""
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
    def rows(self) -> list[list[str]]:
        """Fields of each data line, without empty fields at the end."""
        return [fields(line.text) for line in self.data]

    def error(self, why: str, row: int = -1) -> MeshError:
        """Return the error that names the file, the line and the keyword.

        Parameters
        ----------
        why : str
        row : int, optional
            Number, from 0, of the wrong data line; by default the error is in the keyword's line.
        """
        return (self.data[row] if row >= 0 else self.line).refused(f"*{self.name}", why)

    def check_options(self, *known: str) -> None:
        """Refuse options that are not in `known`, as they may change the mesh."""
        for name in self.options:
            if name not in known:
                raise self.error(f"the option {name} is not supported (or drop a comma before it)")

    def integers(self, row: int, texts: Collection[str]) -> list[int]:
        """Return the fields `texts` as integers; errors name their data line `row`."""
        for text in texts:
            if not re.fullmatch(r"[+-]?\d+", text):
                raise self.error(f"an integer is expected, got {text!r}", row)
        return [int(text) for text in texts]

    def reals(self, row: int, texts: Iterable[str], least: int = 0) -> list[float]:
        """Return fields as numbers, 0 for a blank; zeros are appended up to a count of `least`."""
        try:
            return padded([number(text) if text else 0.0 for text in texts], least * [0.0])
        except ValueError as error:
            raise self.error(str(error), row) from None

    def lines_of(self, *most: int, what: str) -> list[FloatArray]:
        """Return the numbers of each data line, `most[i]` in line i, with 0 for missing ones.

        Lines with more numbers are refused; `what` describes the wanted data in the message.
        """
        rows = padded(self.rows, [[]] * len(most))
        if [len(row) > n for row, n in zip(rows, [*most, -1], strict=False)].count(True):
            raise self.error(f"give {what}")
        return [np.array(self.reals(i, rows[i], n)) for i, n in enumerate(most)]

    def points(self) -> tuple[IntArray, FloatArray]:
        """Return labels and coordinates from data lines of *NODE; missing coordinates are 0."""
        table = columns([line.text.rstrip(", \t") for line in self.data], 4, ",")
        if table is None:
            table = np.zeros((len(self.rows), 4))
            for row, texts in enumerate(self.rows):
                if len(texts) > 7:  # number, coordinates, normal
                    raise self.error("give a number, three coordinates and at most a normal", row)
                (label,) = self.integers(row, texts[:1] or [""])
                table[row] = [min(label, 2 * MOST), *self.reals(row, texts[1:4], 3)]
        labels = table[:, 0].clip(0, 2 * MOST).astype(np.int64)
        for row in np.flatnonzero((labels != table[:, 0]) | (labels < 1) | (labels > MOST))[:1]:
            raise self.error("the number of a node must be a positive integer", int(row))
        return labels, table[:, 1:]

    def connectivity(self, n_nodes: int) -> IntArray:
        """Return labels of elements and of their nodes, shape (n, 1 + n_nodes).

        Each element begins a new line. It continues on the next line if a line ends with a comma or
        is full, with 16 numbers.
        """
        lines, width = [line.text.rstrip(", \t") for line in self.data], 1 + n_nodes
        own = np.array([line.count(",") + 1 for line in lines], dtype=int)
        end = np.cumsum(own)
        goes_on = (own == _FULL) | np.array([of.text[-1] == "," for of in self.data], dtype=bool)
        goes_on[-1:] = False
        split = ((end - own) // width < (end - 1) // width) | ((end % width > 0) & ~goes_on)
        for row in np.flatnonzero(split)[:1]:
            first = np.searchsorted(end - own, (end - own)[row] // width * width)
            why = f"the element must have {n_nodes} nodes; a line goes on after a comma"
            raise self.error(why, int(first))
        written = ",".join(lines)  # checked as text, since 3.0 is not allowed for an integer
        words = written.encode("latin-1", "replace").split(b",") if lines else []
        table = numbers(np.array(words, "S"))
        if re.search(r"[^\d\s,+]", written) or (table != table.clip(1, MOST)).any():
            for row, texts in enumerate(self.rows):
                if not all(0 < each <= MOST for each in self.integers(row, texts)):
                    raise self.error("numbers must be positive, and below 2^53", row)
            raise self.error("its numbers cannot be read")
        return table.astype(np.int64).reshape(-1, width)


def padded(row: list[Any], fill: list[Any]) -> list[Any]:
    """Return a row extended to the length of `fill` by the last items of `fill`."""
    return row + fill[len(row) :]


def fields(line: str) -> list[str]:
    """Return the comma-separated fields of a line, stripped, without empty fields at the end.

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
    """Return the form of a name for comparison: capitals without blanks; unchanged if quoted."""
    text = name.strip()
    if len(text) > 1 and text[0] == text[-1] == '"':
        return text[1:-1]
    return re.sub(r"\s", "", text).upper()


def looks_like_inp(head: bytes) -> bool:
    """Return whether a file with the first bytes `head` is a deck of Abaqus or CalculiX."""
    found = _BEGIN.match((decoded(head) or "").lstrip("\ufeff"))
    return found is not None and key(found[1]) in _FIRST


def read_keywords(main: Path) -> list[Keyword]:
    """Return the keywords of a deck and of the files that it includes, in order.

    Raises
    ------
    MissingFileError
        If an included file does not exist.
    MeshError
        If there are data before the first keyword, or files include each other.
    """
    found: list[Keyword] = []
    included: list[Path] = []

    def include(keyword: Keyword, outer: tuple[Path, ...]) -> None:
        """Add the contents of the file named by the option INPUT or FILE."""
        options = keyword.options
        given = (options.get("INPUT") or options.get("FILE") or "").strip('"').replace("\\", "/")
        if not given:
            raise keyword.error("INPUT=file is missing")
        folders = main.parent, keyword.line.file.parent
        place = next((folder / given for folder in folders if (folder / given).is_file()), None)
        if place is None:
            raise MissingFileError(str(keyword.error(f"there is no file {given!r}")))
        included.append(place)
        if place.resolve() in {file.resolve() for file in outer}:
            raise keyword.error(f"{str(place)!r} includes itself")
        if len(included) > _MOST_INCLUDED:
            raise keyword.error(f"more than {_MOST_INCLUDED} files are included")
        before = len(found), len(included)
        add(place, (*outer, place))
        if keyword.name != "INCLUDE" and (len(found), len(included)) != before:
            raise keyword.error(f"{str(place)!r} must hold data lines only")

    def add(file: Path, outer: tuple[Path, ...]) -> None:
        """Add the keywords of a file; `outer`: the chain of including files, this file last."""
        lines = read_text(file).split("\n")
        starts = [i for i, line in enumerate(lines) if "*" in line and _KEYWORD.match(line)]
        for start, stop in pairwise([-1, *starts, len(lines)]):
            after = 0
            if start >= 0:
                text, after = lines[start].strip(), start + 1
                while text.endswith(",") and after < stop:  # continued on the next line
                    more, after = lines[after].strip(), after + 1
                    text += "" if more[:2] == "**" else more or " "
                name, *given = fields(text[1:]) or [""]
                keyword = Keyword(key(name), given, Line("", file, start + 1, len(found)))
                if keyword.name == "INCLUDE":
                    keyword.check_options("INPUT", "FILE")
                    include(keyword, outer)
                else:
                    found.append(keyword)
                    if keyword.name in _WITH_INPUT and "INPUT" in keyword.options:
                        include(keyword, outer)
            for i in range(after, stop):
                line = Line(lines[i].strip(), file, i + 1, len(found))
                if not line.text or line.text[:2] == "**":
                    continue
                if not found:
                    why = "a deck of Abaqus or CalculiX begins with *"
                    raise line.refused(repr(line.text[:40]), why)
                found[-1].data.append(line)

    add(main, (main,))
    return found
