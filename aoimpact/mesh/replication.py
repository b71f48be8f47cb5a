"""Nastran's replication: entries that repeat the entry before them with increments."""

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
    """Return the lines with those that begin with "=" replaced by the entries they stand for.

    In such a line "=" is the field of the entry before, "==" all of its further fields, and "*2"
    or "*(2)" the field with an increment. "=5" and "=(5)" repeat the line above five times.

    Raises
    ------
    MeshError
    """
    if b"\n=" not in b"\n".join(lines.text):
        return lines
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
                entry = [entry[0], *_replicated(entry[1:], rule)]
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


def _replicated(entry: list[str], rule: list[str]) -> list[str]:
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
