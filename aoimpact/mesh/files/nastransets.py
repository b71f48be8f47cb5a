"""Sets of numbers in Nastran decks: SET of the case control; SET1, SET3, SET of bulk data."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ...base import IntArray, warn
from .bulkdata import BulkData
from .nastrantext import Lines

__all__ = ["NumberSet", "read_sets"]

_SET = re.compile(r"SET\s+(\d+)\s*=(.*)")

# What the numbers of a set of bulk data are, by its type; of other types they are neither.
_KINDS: dict[str, tuple[str, ...]] = {
    "GRID": ("nodes",),
    "NODE": ("nodes",),
    "ELEM": ("elements",),
    "ELEMENT": ("elements",),
}
_EITHER: tuple[str, ...] = ("nodes", "elements")


@dataclass(frozen=True)
class _Range:
    """Numbers from `first` to `last`, those in `without` left out."""

    first: int
    last: int
    step: int = 1
    without: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class NumberSet:
    """Numbers of nodes or elements.

    Attributes
    ----------
    kinds : tuple of str
        "nodes" or "elements" or both: what the numbers may be.
    single : list of int
    ranges : list of _Range
    """

    kinds: tuple[str, ...]
    single: list[int] = field(default_factory=list)
    ranges: list[_Range] = field(default_factory=list)

    def among(self, labels: IntArray) -> IntArray:
        """Return which of `labels` are in the set; none if a number given by itself is missing."""
        if not np.isin(self.single, labels).all():
            return np.zeros(0, dtype=np.int64)
        chosen: npt.NDArray[np.bool_] = np.isin(labels, self.single)
        for one in self.ranges:
            within = (labels >= one.first) & (labels <= one.last)
            within &= (labels - one.first) % one.step == 0
            chosen |= within & ~np.isin(labels, one.without)
        return np.flatnonzero(chosen)


def read_sets(control: Lines, deck: BulkData) -> dict[str, NumberSet]:
    """Return the sets by name, such as "SET 5" and "SET1 5".

    Raises
    ------
    MeshError
        If a set of bulk data is not understood.

    Warns
    -----
    AOImpactWarning
        If the case control defines a set twice, with other members.
    """
    found: dict[str, NumberSet] = {}
    twice = set()
    for name, words in _control_sets(control):
        one = _parsed(words, _EITHER)
        if one is not None and found.setdefault(name, one) != one:
            twice.add(name)
    if twice:
        listed = ", ".join(sorted(twice))
        warn(f"{listed}: the case control defines it twice, with other members; it was left out")
    return {name: one for name, one in found.items() if name not in twice} | _bulk_sets(deck)


def _control_sets(control: Lines) -> list[tuple[str, list[str]]]:
    """Return names and members of the sets of the case control, before those of plots."""
    found = []
    lines = iter(line.decode().strip() for line in control.text)
    for line in lines:
        if line.startswith("OUTPUT("):
            break
        while line.endswith(",") and line.startswith("SET"):
            line += " " + next(lines, "")
        if match := _SET.match(line):
            found.append((f"SET {int(match[1])}", re.split(r"[,\s]+", match[2].strip())))
    return found


def _bulk_sets(deck: BulkData) -> dict[str, NumberSet]:
    found: dict[str, NumberSet] = {}
    for name in ("SET1", "SET3", "SET"):
        for line, fields in deck.long_entries(name):
            first = {"SET1": 1, "SET3": 2, "SET": 8}[name]
            kinds = _EITHER if name == "SET1" else _KINDS.get(fields[1], ())
            label = f"{name} {fields[0]}"
            one = _parsed(fields[first:], kinds)
            if kinds and (one is None or not fields[0].isdigit()):
                raise deck.lines.refused(line, label, "it is no list of numbers and THRU")
            if one is not None and kinds and found.setdefault(label, one) != one:
                raise deck.lines.refused(line, label, "it is defined twice, with other members")
    return found


def _parsed(words: list[str], kinds: tuple[str, ...]) -> NumberSet | None:
    """Return the set of words such as 1 THRU 20 EXCEPT 7 30; None if they are something else.

    A number after EXCEPT is left out of the range before it, if it lies there; else it is in.
    """
    one = NumberSet(kinds)
    words = [word for word in words if word]
    except_of: _Range | None = None
    i = 0
    while i < len(words):
        following = [*words[i + 1 : i + 5], "", "", "", ""]
        if words[i] == "EXCEPT" and one.ranges:
            except_of = one.ranges[-1]
            i += 1
        elif not words[i].isdigit():
            return None
        elif following[0] == "THRU":
            by = following[2] == "BY"
            numbers = [words[i], following[1], following[3] if by else "1"]
            if not all(word.isdigit() for word in numbers) or numbers[2] == "0":
                return None
            first, last, step = (int(word) for word in numbers)
            one.ranges.append(_Range(first, last, step))
            except_of = None
            i += 5 if by else 3
        else:
            number = int(words[i])
            if except_of is not None and except_of.first <= number <= except_of.last:
                except_of.without.append(number)
            else:
                one.single.append(number)
            i += 1
    return one if words else None
