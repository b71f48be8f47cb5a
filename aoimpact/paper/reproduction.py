"""The paper, end to end: every table and figure recomputed beside the printed numbers.

``python -m aoimpact paper`` runs :func:`reproduce`; notebooks/paper.ipynb goes the same way step by
step.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..base import writable_folder
from . import beam as paper_beam
from . import sphere as paper_sphere
from .beam import BeamStudy
from .figures import BEAM_FIGURES, SPHERE_FIGURES, figure_mesh
from .sphere import MESH_SIZES, MeshCase, SphereStudy, mesh_case
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
    meshes: dict[float, MeshCase] = {}
    _run(_jobs(spheres, beam, meshes), progress)
    tables = paper_tables(spheres, beam, meshes)
    files = [folder / "results.csv", folder / "results.md"]
    write_comparison(tables, files[0])
    files[1].write_text("# The paper, recomputed\n\n" + markdown(tables), encoding="utf-8")
    for name, figure in paper_figures(spheres, beam, meshes):
        files.append(folder / f"{name}.png")
        figure.savefig(files[-1])
    return Reproduction(tables, tuple(files))


def paper_tables(
    spheres: SphereStudy, beam: BeamStudy, meshes: dict[float, MeshCase]
) -> tuple[Table, ...]:
    """Return all comparisons, in the order of the paper, then what it does not say."""
    of = paper_sphere
    of_spheres = (of.table_1, of.table_2, of.table_3, of.impact_table, of.method_table)
    of_energies = (of.modal_table, of.energy_table)
    of_beam = (
        *(paper_beam.table_4, paper_beam.table_5, paper_beam.oscillator_table),
        *(paper_beam.force_table, paper_beam.displacement_table),
    )
    return (
        *(table(spheres) for table in (*of_spheres, *of_energies)),
        *(table(beam) for table in of_beam),
        of.resolved_table(spheres),
        of.mesh_table(meshes),
    )


def paper_figures(
    spheres: SphereStudy, beam: BeamStudy, meshes: dict[float, MeshCase]
) -> Iterator[tuple[str, Figure]]:
    """Yield all figures with their names."""
    for number, of_spheres in enumerate(SPHERE_FIGURES, start=3):
        yield f"figure_{number:02d}", of_spheres(spheres)
    for number, of_beam in enumerate(BEAM_FIGURES, start=8):
        yield f"figure_{number:02d}", of_beam(beam)
    yield "figure_mesh", figure_mesh(spheres, meshes)


def _jobs(
    spheres: SphereStudy, beam: BeamStudy, meshes: dict[float, MeshCase]
) -> list[tuple[str, Callable[[], object]]]:
    """Computations that take long, each with its name; the studies keep their results."""

    def mesh(size: float) -> Callable[[], object]:
        return lambda: meshes.setdefault(size, mesh_case(spheres, size))

    return [
        ("sphere: frequencies", lambda: spheres.frequencies),
        ("sphere: anti-oscillator", lambda: spheres.oscillator),
        ("two spheres: full model", lambda: spheres.full),
        ("sphere: 1000 modes", lambda: spheres.modes),
        ("two spheres: modal series", lambda: spheres.modal),
        ("two spheres: velocities", lambda: spheres.by_speed),
        ("beam: frequencies", lambda: beam.locking_free),
        ("beam: anti-oscillators", lambda: beam.star),
        ("sphere on beam: full model, 200 µs", lambda: beam.full_short),
        ("sphere on beam: full model, 20 ms", lambda: beam.full_long),
        *((f"sphere: elements of {1e3 * size:g} mm", mesh(size)) for size in MESH_SIZES),
    ]


def _run(jobs: list[tuple[str, Callable[[], object]]], progress: bool) -> None:
    from tqdm import tqdm

    with tqdm(jobs, disable=None if progress else True, unit="run", leave=False) as bar:
        for name, compute in bar:
            bar.set_description(f"{name:<34}")
            compute()
