"""The output of ``aoimpact run``: histories, figures, fields, tables, and JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..accuracy import keeper
from ..base import FilePath, writable_folder, write_csv
from ..batch import SweepTable
from ..results import Result, Run
from ..scenefile import SceneFile

_FIGURES = ("force", "indentation", "displacement", "energy")

# Number of times of a body's field, besides the time of the peak force: enough to see the motion.
_FRAMES = 20


def write_files(scene: SceneFile, result: Run, out: FilePath) -> tuple[Path, ...]:
    """Write all histories and probes (CSV), figures (PNG), and fields of bodies with a mesh (VTU).

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    import matplotlib.pyplot as plt

    folder = writable_folder(out)
    files = [folder / "histories.csv"]
    result.to_csv(files[0])
    if found := scene.probes(result):
        files.append(folder / "probes.csv")
        rows = np.column_stack([result.t, *found.values()]).tolist()
        write_csv(files[-1], ["time [s]", *found], rows)
    for name in _FIGURES:
        if hasattr(result, f"plot_{name}"):
            axes: Any = getattr(result, f"plot_{name}")()
            files.append(folder / f"{name}.png")
            axes.figure.savefig(files[-1])
            plt.close(axes.figure)
    for name, model, body in zip(result.names, result.plan.bodies, result.bodies, strict=True):
        if any(tip.body.mesh is not None for tip in model.tips):
            times = np.linspace(0.0, result.t[-1], _FRAMES)
            files.append(body.to_vtu(folder / name, np.union1d(times, body.field().times)))
    return tuple(files)


_ERRORS = "total", "mesh", "contact", "model", "time", "energy"


def numbers(result: Run, quantities: Sequence[str]) -> dict[str, Any]:
    """Return the JSON content of the report on a result, as a dict."""
    kept: Any = keeper(quantities) if quantities else lambda _: {}

    def intervals(name: str) -> Any:
        """Return (start, end) of each touch, or slip; for a scene, one list per contact."""
        found = [getattr(of, name) for of in result.each_contact]
        return found[0] if isinstance(result, Result) else found

    vectors: dict[str, Any] = {}
    if result.plan.oblique is not None:
        for name in ("final_velocity", "final_spin"):
            vectors[name] = [list(getattr(body, name)) for body in result.bodies]
        vectors["slip_intervals"] = intervals("slip_intervals")
    return {
        "quantities": kept(result),
        "bodies": result.names,
        **vectors,
        "contact_names": result.contact_names,
        "contacts": intervals("intervals"),
        "in_contact_at_end": result.in_contact_at_end,
        "relative_errors": {name: getattr(result.error, name) for name in _ERRORS},
        "solver": result.solver,
    }


def rows(table: SweepTable) -> dict[str, Any]:
    """Return the JSON content of the report on a sweep; infinite parameters become "inf"."""
    found = []
    for number, values in enumerate(table.data):
        row = dict(zip(table.columns, values.item(), strict=True))
        row |= {name: "inf" for name in table.parameters if row[name] == math.inf}
        if number in table.errors:
            row["error"] = str(table.errors[number])
        found.append(row)
    return {"parameters": table.parameters, "quantities": table.quantities, "rows": found}


def as_json(report: dict[str, Any]) -> str:
    """Return a report as JSON, with all digits of numbers, and null for NaN or infinity."""
    known = json.loads(json.dumps(report), parse_constant=lambda _: None)
    return json.dumps(known, indent=2, ensure_ascii=False)
