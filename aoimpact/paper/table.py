"""Numbers beside those that the paper prints: rows, tables, and how they are shown.

A verdict is computed, never given: a number *agrees* if it rounds to the digits that the paper
prints, is *close* within 1 % of it (one point, for percentages), and *differs* beyond.
"""

from __future__ import annotations

import os
import textwrap
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources
from typing import Any

from ..base import aligned, html_table, write_csv

# The relative difference up to which numbers of other printed digits are "close".
_CLOSE = 0.01

_HEADINGS = ("quantity", "paper", "computed", "difference", "verdict")
_COLUMNS = (
    *("table", "against", "quantity", "unit", "printed", "computed", "difference", "verdict"),
    "why",
)

# Characters of a line of notes: about as long as the tables' rows.
_WIDTH = 96


@dataclass(frozen=True)
class Row:
    """One number of the paper and the same number recomputed.

    Attributes
    ----------
    quantity : str
        Name of the quantity.
    computed : float
        Recomputed, in `unit`.
    paper : str
        As it is printed, in `unit`; empty where the paper gives none.
    unit : str
        Unit of both.
    why : str
        Reason of a difference, or a note on the number.
    """

    quantity: str
    computed: float
    paper: str = ""
    unit: str = ""
    why: str = ""

    @property
    def difference(self) -> float | None:
        """Computed minus printed: in percent of the printed number, or in points of a percentage.

        None where the paper gives no number, or a zero that is no percentage.
        """
        if not self.paper:
            return None
        change = self.computed - float(self.paper)
        if self.unit == "%":
            return change
        return 100.0 * change / abs(float(self.paper)) if float(self.paper) else None

    @property
    def verdict(self) -> str:
        """ "agrees", "close", "differs", or "" where the paper gives no number."""
        if not self.paper:
            return ""
        decimals = len(self.paper.partition(".")[2])
        # The little extra is for numbers that end on a five.
        if abs(self.computed - float(self.paper)) <= 0.5000001 * 10.0**-decimals:
            return "agrees"
        if self.difference is None:
            return "differs"
        return "close" if abs(self.difference) <= 100.0 * _CLOSE else "differs"

    def cells(self) -> tuple[str, str, str, str, str]:
        """The row as text, in the order of the headings."""
        sign = "points" if self.unit == "%" else "%"
        change = ""
        if self.difference is not None:
            decimals = 2 if abs(self.difference) < 0.995 else 1
            # Adding zero turns -0.0 into 0.0.
            change = f"{round(self.difference, decimals) + 0.0:+.{decimals}f} {sign}"
        paper = f"{self.paper} {self.unit}".strip() if self.paper else ""
        computed = f"{_digits(self.computed)} {self.unit}".strip()
        return self.quantity, paper, computed, change, self.verdict


@dataclass(frozen=True)
class Table:
    """Rows under a title; `against` names what they are compared with, if not the paper."""

    title: str
    rows: tuple[Row, ...]
    against: str = "paper"

    def __getitem__(self, quantity: str) -> Row:
        """Return the row of that quantity."""
        for row in self.rows:
            if row.quantity == quantity:
                return row
        raise KeyError(quantity)

    def __str__(self) -> str:
        return "\n".join(_text_lines(self))

    def _repr_html_(self) -> str:
        rows = [(*row.cells(), row.why) for row in self.rows]
        return html_table((*_headings(self), ""), rows, caption=[self.title])


def printed(name: str, *values: float, **notes: Any) -> Table:
    """Return a table of data/paper.toml with computed values beside the paper's numbers.

    Parameters
    ----------
    name : str
    values : float
        In the order of its rows.
    notes : optional
        Fill the braces in its texts.
    """
    written = tomllib.loads(
        (resources.files("aoimpact") / "data" / "paper.toml").read_text("utf-8")
    )
    rows = []
    for (quantity, *row), value in zip(written[name]["rows"], values, strict=True):
        paper, unit, why = (*row, "")[:3]
        rows.append(Row(quantity.format(**notes), value, paper, unit, why.format(**notes)))
    return Table(written[name]["title"], tuple(rows), written[name].get("against", "paper"))


def _headings(table: Table) -> tuple[str, ...]:
    return tuple(table.against if name == "paper" else name for name in _HEADINGS)


def _digits(value: float) -> str:
    """Five significant digits, and zero for rounding errors."""
    return "0" if abs(value) < 1e-12 else f"{value:.5g}"


def _text_lines(table: Table) -> list[str]:
    """The table for a terminal, its reasons as notes below; columns that are empty are left out."""
    notes = list(dict.fromkeys(row.why for row in table.rows if row.why))
    lines = [_headings(table)]
    for row in table.rows:
        name, *rest = row.cells()
        mark = f" [{notes.index(row.why) + 1}]" if row.why else ""
        lines.append((name + mark, *rest))
    if not any(row.paper for row in table.rows):
        lines = [(line[0], line[2]) for line in lines]
    shown = aligned(lines, left={0, _HEADINGS.index("verdict")})
    rule = "-" * max(map(len, shown))
    text = [table.title, rule, shown[0], rule, *shown[1:], rule]
    for number, note in enumerate(notes, start=1):
        text += textwrap.wrap(
            note, _WIDTH, initial_indent=f"  [{number}] ", subsequent_indent="      "
        )
    return text


def markdown(tables: Iterable[Table]) -> str:
    """Return tables as Markdown, each under its title, with the reasons in a last column."""
    lines = []
    for table in tables:
        lines += [f"## {table.title}", "", f"| {' | '.join(_headings(table))} | why |"]
        lines.append("|---|---:|---:|---:|---|---|")
        for row in table.rows:
            cells = (cell.replace("|", r"\|") for cell in (*row.cells(), row.why))
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def write_comparison(tables: Iterable[Table], path: str | os.PathLike[str]) -> None:
    """Write the rows of all tables to one CSV file, numbers in full."""
    rows = []
    for table in tables:
        for row in table.rows:
            change = "" if row.difference is None else repr(float(row.difference))
            numbers = [row.paper, repr(float(row.computed)), change, row.verdict]
            rows.append([table.title, table.against, row.quantity, row.unit, *numbers, row.why])
    write_csv(path, _COLUMNS, rows)
