"""What ``aoimpact run`` leaves: histories, tables, figures, and numbers for machines."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..accuracy import keeper
from ..base import writable_folder
from ..batch import SweepTable
from ..results import BodyResult, Result, Run
from ..scenefile import SceneFile

__all__ = ["as_json", "numbers", "rows", "write_files", "write_sweep"]

_FIGURES = ("force", "indentation", "displacement", "energy")

# Times of a body's fields, beside that of the peak force: enough to see it move.
_FRAMES = 20


def write_files(
    scene: SceneFile, result: Result | Run, out: str | os.PathLike[str]
) -> tuple[Path, ...]:
    """Write histories, figures, and the fields of bodies to a folder, made if there is none.

    Each body with a mesh gives a figure of it deformed at the peak force, and a .pvd with .vtu
    files for ParaView.

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    folder = writable_folder(out)
    files = [folder / "histories.csv"]
    names = [name for name, _ in scene.members]
    if isinstance(result, Run):
        result.to_csv(files[0], names=names)
        figures = {
            "force": result.plot_force(),
            "displacement": result.plot_displacement(names=names),
            "energy": result.plot_energy(),
        }
    else:
        result.to_csv(files[0])
        figures = {name: getattr(result, f"plot_{name}")() for name in _FIGURES}
    files += [_saved(axes, folder / f"{name}.png") for name, axes in figures.items()]
    for i, (name, body) in enumerate(scene.members):
        if scene.has_mesh(body):
            files += _fields(_bodies(result)[i], result.t[-1], folder / name)
    return tuple(files)


def _bodies(result: Result | Run) -> Sequence[BodyResult]:
    return result.bodies if isinstance(result, Run) else (result.projectile, result.target)


def _fields(body: BodyResult, end: float, file: Path) -> list[Path]:
    peak = body.field()
    times = np.union1d(np.linspace(0.0, end, _FRAMES), peak.times)
    return [_saved(peak.plot(), file.with_name(f"{file.name}.png")), body.to_vtu(file, times)]


def _saved(axes: Any, file: Path) -> Path:
    import matplotlib.pyplot as plt

    axes.figure.savefig(file)
    plt.close(axes.figure)
    return file


def numbers(result: Result | Run, quantities: Sequence[str]) -> dict[str, Any]:
    """Return what JSON can hold of a result; null where a number is not known."""
    kept: Any = keeper(quantities) if quantities else None
    errors = {name: getattr(result.error, name) for name in ("reduction", "time", "energy")}
    return {
        "quantities": _finite(kept(result) if quantities else {}),
        "contacts": _contacts(result),
        "in_contact_at_end": result.in_contact_at_end,
        "relative_errors": _finite(errors),
        "solver": result.solver,
    }


def write_sweep(table: SweepTable, out: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write the table of a sweep, and a figure over its first parameter of numbers, to a folder.

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    folder = writable_folder(out)
    files = [folder / "sweep.csv"]
    table.to_csv(files[0])
    if any(table.data[name].dtype.kind in "iuf" for name in table.parameters):
        files.append(_saved(table.plot(), folder / "sweep.png"))
    return tuple(files)


def rows(table: SweepTable) -> dict[str, Any]:
    """Return what JSON can hold of a sweep; null where a number is not known, "inf" of a wall."""
    found = []
    for number, values in enumerate(table.data):
        row = dict(zip(table.columns, map(_told, values.item()), strict=True))
        row |= _finite({name: float(values[name]) for name in table.quantities})
        if number in table.errors:
            row["error"] = str(table.errors[number])
        found.append(row)
    return {
        "parameters": list(table.parameters),
        "quantities": list(table.quantities),
        "rows": found,
    }


def _contacts(result: Result | Run) -> list[Any]:
    """Start and end of each touch; by contact, where there may be several."""
    if isinstance(result, Run):
        return [[list(interval) for interval in of.intervals] for of in result.contacts]
    return [list(interval) for interval in result.contacts]


def as_json(report: dict[str, Any]) -> str:
    """Return the text of a report; numbers with all their digits."""
    return json.dumps(report, indent=2, allow_nan=False, ensure_ascii=False)


def _told(value: Any) -> Any:
    """A parameter's value, with text for the numbers that JSON has not."""
    if isinstance(value, dict):
        return {name: _told(of) for name, of in value.items()}
    if isinstance(value, list):
        return [_told(of) for of in value]
    return value if not isinstance(value, float) or math.isfinite(value) else str(value)


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: value if value is not None and math.isfinite(value) else None
        for name, value in values.items()
    }
