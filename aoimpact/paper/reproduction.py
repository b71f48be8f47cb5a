"""The paper, end to end: every table and figure recomputed beside the printed numbers.

``python -m aoimpact paper`` runs :func:`reproduce`; notebooks/paper.ipynb goes the same way step by
step.
"""

from __future__ import annotations

import os
from pathlib import Path

from ..base import bar, writable_folder, write_csv
from . import beam, figures, sphere
from .table import Row, markdown

TABLES = (
    *(sphere.table_1, sphere.table_2, sphere.table_3, sphere.impact, sphere.method),
    *(sphere.modal_series, sphere.energy, beam.table_4, beam.table_5, beam.oscillators),
    *(beam.force, beam.displacement, sphere.resolved),
)


def reproduce(out: str | os.PathLike[str], *, progress: bool = True) -> list[Path]:
    """Recompute all tables and Figures 3 to 11 of the paper, and write them to a folder.

    Parameters
    ----------
    out : path
        Folder for ``results.csv``, ``results.md``, ``figure_03.png`` ... ``figure_11.png``;
        made if there is none.
    progress : bool, optional
        True to show a progress bar (only ever on a terminal).

    Returns
    -------
    list of Path
        The files, in that order.

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    folder = writable_folder(out)
    rows: list[Row] = []
    files = [folder / "results.csv", folder / "results.md"]
    total = len(TABLES) + len(figures.FIGURES)
    with bar("the paper", total, unit="part", wanted=progress) as shown:
        for table in TABLES:
            rows += table()
            shown.update()
        write_csv(files[0], Row._fields, rows)
        files[1].write_text(markdown(rows), encoding="utf-8")
        for draw in figures.FIGURES:
            files.append(folder / f"{draw.__name__}.png")
            figures.figure(draw).savefig(files[-1])
            shown.update()
    return files
