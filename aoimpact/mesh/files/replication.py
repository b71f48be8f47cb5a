"""Lines of Nastran decks that stand for several: replication, and more than eight free fields."""

from __future__ import annotations

import re
from itertools import zip_longest

import numpy as np

from .nastrantext import Lines
from .textfile import number

__all__ = ["written_out"]

_TIMES = re.compile(r"=(?:(\d+)|\((\d+)\))")
_INCREMENT = re.compile(r"\*\(?([^()]+)\)?")

# Entries that one line may stand for.
_MOST = 1_000_000


def written_out(lines: Lines) -> Lines:
    """Return the lines with replications written out, and long lines of free fields cut.

    Raises
    ------
    MeshError
        If a replication is not understood.
    """
    joined = b"\n".join(lines.text)
    if b"\n=" in joined:
        lines = _replicated(lines)
    return _cut(lines) if b"," in joined else lines


def _cut(lines: Lines) -> Lines:
    """Cut lines with more than eight free fields into continuations.

    Nastran takes the ninth field for data if there are more behind it; a blank one, or one that
    begins with "+" or "*", is the mark of a continuation.
    """
    text: list[bytes] = []
    sources: list[int] = []
    for i, line in enumerate(lines.text):
        head, *fields = line.split(b",") if b"," in line[:10] else [line]
        parts = [line]
        if len(fields) > 9 and b"*" not in head and fields[8].strip()[:1] not in (b"", b"+", b"*"):
            parts = [b",".join(fields[k : k + 8]) for k in range(0, len(fields), 8)]
            parts = [head + b"," + parts[0], *(b"," + part for part in parts[1:])]
        text += parts
        sources += [i] * len(parts)
    return Lines(text, lines.sources[np.array(sources)], lines.files)


def _replicated(lines: Lines) -> Lines:
    """Write out the lines that begin with "=".

    In such a line "=" is the field of the entry before, "==" all of its further fields, and "*2"
    or "*(2)" the field with an increment. "=5" and "=(5)" repeat the line above five times.
    """
    text: list[bytes] = []
    sources: list[int] = []
    entry: list[str] = []
    rule: list[str] = []
    for i, line in enumerate(lines.text):
        if not line.startswith(b"="):
            entry, rule = _fields(line), []
            text.append(line)
            sources.append(i)
            continue
        head, *fields = _fields(line)
        times = _TIMES.fullmatch(head)
        if times is None:
            rule = fields
        try:
            if (head != "=" and times is None) or not rule or not entry[0].isalnum():
                raise ValueError
            for _ in range(_count(times[1] or times[2]) if times else 1):
                entry = [entry[0], *_next(entry[1:], rule)]
                text.append(",".join(entry).encode())
                sources.append(i)
        except ValueError:
            raise lines.refused(i, "replication", f"{line.decode()!r} is not understood") from None
    return Lines(text, lines.sources[np.array(sources)], lines.files)


def _fields(line: bytes) -> list[str]:
    """Return the name and up to eight fields of a line of small or free fields."""
    text = line.decode()
    if "," not in text[:10] and " " in text:
        text = ",".join(text[i : i + 8] for i in range(0, 72, 8))
    return [one.strip() for one in text.split(",")][:9]


def _count(text: str) -> int:
    if int(text) > _MOST:
        raise ValueError
    return int(text)


def _next(entry: list[str], rule: list[str]) -> list[str]:
    found: list[str] = []
    for old, new in zip_longest(entry, rule, fillvalue=""):
        if new == "==":
            return found + entry[len(found) :]
        step = _INCREMENT.fullmatch(new)
        if step is not None:
            is_whole = step[1].lstrip("+-").isdigit()
            old = old or "0"
            new = str(int(old) + int(step[1])) if is_whole else repr(number(old) + number(step[1]))
        found.append(old if new == "=" else new)
    return found
