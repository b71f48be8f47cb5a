"""The paper, end to end: every table and figure recomputed beside the printed numbers.

``python -m aoimpact paper`` runs :func:`reproduce`; notebooks/paper.ipynb goes the same way step by
step.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base import Progress, bar, writable_folder
from .beam import BEAM_TABLES, BeamStudy
from .figures import BEAM_FIGURES, SPHERE_FIGURES, figure_mesh
from .sphere import SPHERE_TABLES, SphereStudy, mesh_table, resolved_table
from .table import Table, markdown, write_comparison

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Reproduction:
    """All tables, and the files that were written."""

    tables: tuple[Table, ...]
    files: tuple[Path, ...]

    def __str__(self) -> str:
        return "\n\n".join(map(str, self.tables))


def reproduce(out: str | os.PathLike[str], *, progress: bool = True) -> Reproduction:
    """Recompute all tables and Figures 3 to 11 of the paper, and write them to a folder.

    Parameters
    ----------
    out : path
        Folder for ``figure_03.png`` ... ``figure_11.png``, ``figure_mesh.png``, ``results.csv`` and
        ``results.md``; made if there is none.
    progress : bool, optional
        True to show a progress bar (only ever on a terminal).

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    folder = writable_folder(out)
    spheres = SphereStudy()
    beam = BeamStudy(spheres)
    tables_of: list[tuple[Callable[[Any], Table], Any]] = [
        *((table, spheres) for table in SPHERE_TABLES),
        *((table, beam) for table in BEAM_TABLES),
        *((table, spheres) for table in (resolved_table, mesh_table)),
    ]
    figures_of: dict[str, tuple[Callable[[Any], Figure], Any]] = {
        **{f"figure_{n:02d}": (of, spheres) for n, of in enumerate(SPHERE_FIGURES, start=3)},
        **{f"figure_{n:02d}": (of, beam) for n, of in enumerate(BEAM_FIGURES, start=8)},
        "figure_mesh": (figure_mesh, spheres),
    }
    tables, files = [], [folder / "results.csv", folder / "results.md"]
    total = len(tables_of) + len(figures_of)
    with bar("the paper", total, unit="part") if progress else nullcontext(Progress()) as shown:
        for table, study in tables_of:
            tables.append(table(study))
            shown.update()
        write_comparison(tables, files[0])
        files[1].write_text("# The paper, recomputed\n\n" + markdown(tables), encoding="utf-8")
        for name, (figure, study) in figures_of.items():
            files.append(folder / f"{name}.png")
            figure(study).savefig(files[-1])
            shown.update()
    return Reproduction(tuple(tables), tuple(files))
