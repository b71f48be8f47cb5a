"""The text of a Nastran deck: its lines with those of the files that it includes, by section."""

from __future__ import annotations

import codecs
import os
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...base import IntArray, MeshError, require
from .textfile import read_lines, refused

__all__ = ["Lines", "is_nastran", "read_sections"]

# Bytes of memory for each byte of a deck: its text, lines, columns and fields.
_PER_BYTE = 14

# Bytes of a file by which it is known as a deck.
_HEAD = 2**20

_INCLUDE = re.compile(r"\s*INCLUDE(?:\s*=\s*|\s+|(?=['\"]))(.*)", re.I)
_SECTION = re.compile(rb"\s*(BEGIN|CEND)\b")
_PART = re.compile(rb"\s*BEGIN[\s,]+(BULK\b.*=|(?!BULK\b)\S)")
_BULK = re.compile(
    rb"^[ \t]*(?:BEGIN[ \t,]+BULK|INCLUDE)\b"
    rb"|^(?:GRID|CHEXA|CPENTA|CPYRAM?|CTETRA|CORD[12][CRS])[ \t]*\*?[ \t,][ \t]*\d",
    re.I | re.M,
)


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


def read_sections(file: Path) -> tuple[Lines, Lines]:
    """Return the lines of case control and those of bulk data.

    A deck without BEGIN BULK is bulk data throughout.

    Raises
    ------
    MeshError
        If a file that it includes is not there, or if it has several parts, such as superelements.
    MemoryLimitError
    """
    lines = _Reader(file).lines()
    joined = b"\n".join(lines.text)
    found = [match.start() for name in (b"BEGIN", b"CEND") for match in re.finditer(name, joined)]
    candidates = sorted({joined.count(b"\n", 0, start) for start in found})
    sections = {i: match[1] for i in candidates if (match := _SECTION.match(lines.text[i]))}
    begins = [i for i, name in sections.items() if name == b"BEGIN"]
    ends = [i for i, name in sections.items() if name == b"CEND" and i < min(begins, default=i)]
    if not begins:
        if sections:
            raise lines.refused(min(sections), "CEND", "BEGIN BULK is missing after it")
        return lines.part(0, 0), lines
    for i in begins:
        if i != begins[0] or _PART.match(lines.text[i]):
            name = lines.text[i].decode().strip()
            raise lines.refused(i, name, "decks of several parts or superelements are not read")
    return lines.part(max(ends, default=-1) + 1, begins[0]), lines.part(begins[0] + 1)


@dataclass
class _Reader:
    """Collects the lines of a deck with those of included files in their places."""

    main: Path
    files: list[Path] = field(default_factory=list)
    text: list[str] = field(default_factory=list)
    sources: list[tuple[int, range]] = field(default_factory=list)

    def lines(self) -> Lines:
        """Return all lines, up to ENDDATA."""
        self._read(self.main, ())
        joined = "\n".join(self.text).encode("ascii", "replace").upper()
        if b"\t" in joined:
            text = [line.expandtabs(8).rstrip() for line in joined.split(b"\n")]
        else:
            text = [line.rstrip() for line in joined.split(b"\n")]
        source = np.concatenate(
            [
                np.stack([np.full(len(own), i), np.arange(own.start, own.stop)], axis=1)
                for i, own in self.sources
            ]
        )
        kept = [i for i, line in enumerate(text) if line]
        return Lines([text[i] for i in kept], source[kept], self.files)

    def _read(self, file: Path, within: tuple[Path, ...]) -> bool:
        """Add the lines of a file; return whether it has ENDDATA."""
        number = len(self.files)
        self.files.append(file)
        require(_PER_BYTE * file.stat().st_size, f"mesh file {str(file)!r}", "take a coarser mesh")
        lines = [line.partition("$")[0] if "$" in line else line for line in read_lines(file)]
        starts = {
            i: line.lstrip()[:7].upper() for i, line in enumerate(lines) if line[:1] in "IiEe \t"
        }
        end = next((i for i, start in starts.items() if start == "ENDDATA"), len(lines))
        done = 0
        for i in [i for i, start in starts.items() if start == "INCLUDE" and i < end]:
            self._add(number, lines, done, i)
            name, done = _file_name(file, lines, i)
            included = self._found(file, name)
            if included is None:
                # Before CEND there are statements for the solver alone.
                if any(line.lstrip()[:4].upper() == "CEND" for line in lines[i:]):
                    continue
                raise refused(file, i + 1, "INCLUDE", f"there is no file {name!r}")
            if included in (*within, file):
                raise refused(file, i + 1, "INCLUDE", f"{name!r} includes itself")
            if self._read(included, (*within, file)):
                return True
        self._add(number, lines, done, end)
        return end < len(lines)

    def _add(self, number: int, lines: list[str], first: int, end: int) -> None:
        self.text += lines[first:end]
        self.sources.append((number, range(first + 1, max(first, end) + 1)))

    def _found(self, file: Path, name: str) -> Path | None:
        for folder in (file.parent, self.main.parent):
            if os.path.isfile(folder / name):  # False for a name too long, unlike Path.is_file
                return (folder / name).resolve()
        return None


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
