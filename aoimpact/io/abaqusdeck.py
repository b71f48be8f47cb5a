"""Keywords of Abaqus and CalculiX decks, and the data lines under each.

`*INCLUDE` puts the lines of another file in its place, wherever it stands. Names of keywords and
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

# Numbers of a data line that has no room for more.
_FULL = 16

# Largest number of a node or element: exact as a double.
MOST = 2**53

# Largest number of inclusions, so that files which include each other twice end as well.
_MOST_INCLUDED = 2000

# Keywords whose data may stand in another file.
_WITH_INPUT = frozenset(("NODE", "ELEMENT", "NSET", "ELSET"))

# Keywords that a mesh begins with.
_FIRST = frozenset(("HEADING", "NODE", "ELEMENT", "PART", "INCLUDE", "PREPRINT", "NSET", "ELSET"))
_KEYWORD = re.compile(r"\s*\*(?!\*)")
_BEGIN = re.compile(r"(?:\s*\*\*.*\n)*\s*\*\s*([A-Za-z][A-Za-z -]*)")


@dataclass(eq=False)
class Keyword:
    """A keyword with its options and data lines.

    Attributes
    ----------
    name : str
        In capitals, without star and blanks, as in "SOLIDSECTION".
    given : list of str
        What follows the name, as in "ELSET=Bar".
    line : Line
        Its order counts the keywords of a deck.
    data : list of Line
        Its data lines, without blanks at their ends, comments and empty lines.
    part : str
        The part to which it belongs, in capitals; "" outside of parts.
    labels : ndarray of int, shape (n,)
        Numbers of the nodes or elements that it defines.
    """

    name: str
    given: list[str]
    line: Line
    data: list[Line] = field(default_factory=list)
    part: str = ""
    labels: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))

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
    def rows(self) -> list[list[str]]:
        """The fields of each data line, without empty ones at the end."""
        return [fields(line.text) for line in self.data]

    def error(self, why: str, row: int = -1) -> MeshError:
        """Return the error that names the file, the line and the keyword.

        Parameters
        ----------
        why : str
        row : int, optional
            Data line that is wrong, from 0; the keyword itself if left out.
        """
        return (self.data[row] if row >= 0 else self.line).refused(f"*{self.name}", why)

    def check_options(self, *known: str) -> None:
        """Refuse an option that is not known: it may change the mesh."""
        for name in self.options:
            if name not in known:
                raise self.error(f"the option {name} is not supported (or a comma before it)")

    def integers(self, row: int, texts: Collection[str]) -> list[int]:
        """Return integers of a data line; the row is the line's number, for errors."""
        for text in texts:
            if not re.fullmatch(r"[+-]?\d+", text):
                raise self.error(f"{text!r} is no integer", row)
        return [int(text) for text in texts]

    def reals(self, row: int, texts: Iterable[str], least: int = 0) -> list[float]:
        """Return numbers of a data line; blanks are 0, and so are those up to the least count."""
        try:
            return padded([number(text) if text else 0.0 for text in texts], least * [0.0])
        except ValueError as error:
            raise self.error(str(error), row) from None

    def lines_of(self, *most: int, what: str) -> list[FloatArray]:
        """Return the numbers of data lines of so many each, for which a text asks.

        Those that are left out at the end of a line, and lines at the end, are 0.
        """
        rows = padded(self.rows, [[]] * len(most))
        if [len(row) > n for row, n in zip(rows, [*most, -1], strict=False)].count(True):
            raise self.error(f"give {what}")
        return [np.array(self.reals(i, rows[i], n)) for i, n in enumerate(most)]

    def points(self) -> tuple[IntArray, FloatArray]:
        """Return labels and coordinates of the data lines of *NODE; the last may be left out."""
        table = columns([line.text.rstrip(", \t") for line in self.data], 4, ",")
        if table is None:
            table = np.zeros((len(self.rows), 4))
            for row, texts in enumerate(self.rows):
                if len(texts) > 7:  # with a normal
                    raise self.error("a node has a number, three coordinates and a normal", row)
                (label,) = self.integers(row, texts[:1] or [""])
                table[row] = [min(label, 2 * MOST), *self.reals(row, texts[1:4], 3)]
        labels = table[:, 0].clip(0, 2 * MOST).astype(np.int64)
        for row in np.flatnonzero((labels != table[:, 0]) | (labels < 1) | (labels > MOST))[:1]:
            raise self.error("the number of a node must be a positive integer", int(row))
        return labels, table[:, 1:]

    def connectivity(self, n_nodes: int) -> IntArray:
        """Return labels of elements and of their nodes, shape (n, 1 + n_nodes).

        An element begins on a line of its own. It goes on in the next one after a comma, or after
        16 numbers, with which a line is full.
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
        written = ",".join(lines)  # 3.0 is no integer
        words = written.encode("latin-1", "replace").split(b",") if lines else []
        table = numbers(np.array(words, "S"))
        if re.search(r"[^\d\s,+]", written) or (table != table.clip(1, MOST)).any():
            for row, texts in enumerate(self.rows):
                if not all(0 < each <= MOST for each in self.integers(row, texts)):
                    raise self.error("numbers must be positive, and below 2^53", row)
            raise self.error("its numbers cannot be read")
        return table.astype(np.int64).reshape(-1, width)


def padded(row: list[Any], fill: list[Any]) -> list[Any]:
    """Return a row, and what `fill` has behind it."""
    return row + fill[len(row) :]


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
    """Return whether a file that begins with `head` is a deck of Abaqus or CalculiX."""
    found = _BEGIN.match((decoded(head) or "").lstrip("\ufeff"))
    return found is not None and key(found[1]) in _FIRST


def read_keywords(main: Path) -> list[Keyword]:
    """Return the keywords of a deck and of the files that it includes, in order.

    Raises
    ------
    MissingFileError
        If an included file is not there.
    MeshError
        If there are data before the first keyword, or files include each other.
    """
    found: list[Keyword] = []
    included: list[Path] = []

    def include(keyword: Keyword, outer: tuple[Path, ...]) -> None:
        """Add the file that an option INPUT, or FILE, names."""
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
        """Add the keywords of a file; the last one of `outer` is the file itself."""
        lines = read_text(file).split("\n")
        starts = [i for i, line in enumerate(lines) if "*" in line and _KEYWORD.match(line)]
        for start, stop in pairwise([-1, *starts, len(lines)]):
            after = 0
            if start >= 0:
                text, after = lines[start].strip(), start + 1
                while text.endswith(",") and after < stop:  # it goes on in the next line
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
