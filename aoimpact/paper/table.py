"""Recomputed numbers beside those that the paper prints: rows, verdicts, tables in Markdown.

A verdict is computed, never given: a number *agrees* if it rounds to the digits that the paper
prints, is *close* within 1 % of it (one point, for percentages), and *differs* beyond.
"""

from __future__ import annotations

import textwrap
import tomllib
from collections.abc import Iterable
from functools import cache
from importlib import resources
from itertools import chain, groupby
from typing import Any, NamedTuple

from ..base import aligned

# Largest difference, in % or points, of two numbers that are "close".
_CLOSE = 1.0

# Maximum characters of a line of notes, about the length of the tables' rows.
_WIDTH = 96


class Row(NamedTuple):
    """One number of the paper and the same number recomputed.

    Attributes
    ----------
    table : str
        Title of the table.
    against : str
        Source of the printed number.
    quantity, unit : str
        Name of the quantity, and its unit.
    printed : str
        Number as the source prints it; empty if it gives none.
    computed : float
        Recomputed number.
    difference : float or None
        Computed minus printed: see `compared`.
    verdict : str
        "agrees", "close", "differs", or empty without a printed number.
    why : str
        Reason of a difference, or a note on the number.
    """

    table: str
    against: str
    quantity: str
    unit: str
    printed: str
    computed: float
    difference: float | None
    verdict: str
    why: str


def compared(computed: float, printed: str, unit: str) -> tuple[float | None, str]:
    """Return the difference from a printed number, and the verdict.

    The difference is in percent of the printed number, or in points of a percentage; None without a
    number, or for a zero that is no percentage.
    """
    if not printed:
        return None, ""
    change, whole = computed - float(printed), 100.0 if unit == "%" else abs(float(printed))
    difference = 100.0 * change / whole if whole else None
    # Slightly more than 0.5: a computed number midway between two printed ones agrees in spite of
    # rounding errors.
    if abs(change) <= 0.5000001 * 10.0 ** -len(printed.partition(".")[2]):
        return difference, "agrees"
    near = difference is not None and abs(difference) <= _CLOSE
    return difference, "close" if near else "differs"


@cache
def texts() -> dict[str, Any]:
    """Return data/paper.toml: the paper's numbers, and titles and notes of tables and figures."""
    file = resources.files("aoimpact") / "data" / "paper.toml"
    return tomllib.loads(file.read_text("utf-8"))


def beside(name: str, *values: float, **notes: Any) -> list[Row]:
    """Return the rows of a table of data/paper.toml with computed values.

    Parameters
    ----------
    name : str
    values : float
        Computed values, in the order of the table's rows.
    notes : optional
        Values for the braces in the table's texts.
    """
    table, rows = texts()[name], []
    for (quantity, printed, unit, *why), value in zip(table["rows"], values, strict=True):
        named = table["title"], table.get("against", "paper"), quantity.format(**notes), unit
        told = compared(float(value), printed, unit)
        rows.append(Row(*named, printed, float(value), *told, "".join(why).format(**notes)))
    return rows


def markdown(rows: Iterable[Row]) -> str:
    """Return tables in Markdown, aligned for reading as plain text, with the reasons as notes."""
    lines = ["# The paper, recomputed", ""]
    for (title, against), group in groupby(rows, key=lambda row: row[:2]):
        cells = [("quantity", str(against), "computed", "difference", "verdict")]
        cells.append(("---", "---:", "---:", "---:", "---"))
        notes: list[str] = []
        for row in group:
            name, printed, change = row.quantity, "", ""
            if row.why:
                notes += [row.why] * (row.why not in notes)
                name += f" [{notes.index(row.why) + 1}]"
            if row.printed:
                printed = f"{row.printed} {row.unit}".rstrip()
            if row.difference is not None:
                change = f"{row.difference:+z.2f} {'points' if row.unit == '%' else '%'}"
            computed = f"{round(row.computed, 12):.5g} {row.unit}".rstrip()
            cells.append((name, printed, computed, change, row.verdict))
        barred = (["|", *chain.from_iterable((cell, "|") for cell in line)] for line in cells)
        lines += [f"## {title}", "", *aligned(barred, left={1, 9}), ""]
        for number, note in enumerate(notes, start=1):
            lines.append(textwrap.fill(f"{number}. {note}", _WIDTH, subsequent_indent="   "))
        lines += [""] * bool(notes)
    return "\n".join(lines)
