"""Sweeps: one case for each combination of named parameters, and a table of their results."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..accuracy import Named, keeper
from ..base import InputError, InputTypeError, require, sequence
from ..impact import SceneCase, simulate
from ..results import COLUMNS
from ..scenefile import SceneFile, read_scene
from .many import check_keywords, run_cases
from .sweep_table import SweepTable, sweep_table

# Each number stands in a column of its own and in the structured array.
_BYTES_PER_NUMBER = 16.0


def sweep(
    base: Any,
    grid: Mapping[str, Iterable[Any]],
    *,
    keep: Any = COLUMNS,
    workers: Any = 1,
    checkpoint: str | os.PathLike[str] | None = None,
    key: str | None = None,
    progress: bool = True,
) -> SweepTable:
    """Simulate every combination of named parameters, and return a table of numbers.

    Parameters
    ----------
    base : function, dict, scene file or scene
        A function, called with the parameters as keywords, that returns a case of `simulate_many`;
        a dict of `simulate`'s keywords, of which the grid sets some; a scene file or its path, with
        parameters by their dotted place in it, such as "velocity" (of its impact) or
        "bodies.beam.contact.point"; or a scene, of whose ``simulate`` the parameters are keywords.
    grid : mapping of str to sequence
        Values of each parameter; the last one varies fastest.
    keep : names or function, optional
        Quantities for the columns, as of `simulate_many`, with columns such as "restitution_error"
        and "restitution_controlled" beside them where models are chosen: 1 where that error is
        within the tolerance, 0 where nobody controlled it. A function returns a number, or a
        dict of numbers with the same names for each result.
    workers, checkpoint, key, progress : optional
        As of `simulate_many`. Cases are made in this process, one after the other.

    Returns
    -------
    SweepTable
        One row a combination; NaN where a case failed, with its exception in ``.errors``, and
        where there is no such number.

    Raises
    ------
    InputError, InputTypeError
        If a parameter has no values, or the base has no such parameter.
    MemoryLimitError
        If the table of so many cases would not fit into memory; nothing is simulated then.

    Examples
    --------
    >>> import aoimpact as ao
    >>> base = dict(projectile=ao.rigid(mass=0.03), target=ao.rigid(mass=float("inf")),
    ...             law=ao.Hertz(k=1e10), duration=1e-3)
    >>> table = ao.sweep(base, {"velocity": [0.5, 1.0, 2.0]}, keep="restitution")
    >>> [round(float(e), 6) for e in table["restitution"]]
    [1.0, 1.0, 1.0]
    """
    checked = _checked_grid(grid)
    kept = keeper(keep)
    if kept is None:
        raise InputTypeError(
            "keep=None: a table holds numbers; name some, or take simulate_many for whole results"
        )
    cases: Iterable[Any] = _cases(_maker(base, checked), checked)
    names = kept.names if isinstance(kept, Named) else ()
    sizes = [len(values) for values in checked.values()]
    count, columns = math.prod(sizes), len(checked) + max(len(names), 1)
    require(
        _BYTES_PER_NUMBER * columns * float(count),
        f"a table of {' x '.join(map(str, sizes))} = {count:.4g} cases and {columns} columns",
        "give fewer values, or sweep over parts of the grid, each with its own to_csv",
    )
    values = run_cases(cases, count, workers, kept, checkpoint, key, progress)
    return sweep_table(checked, values, names)


def sweep_file(
    scene: SceneFile, *, workers: Any = None, checkpoint: str | os.PathLike[str] | None = None
) -> SweepTable:
    """Run the sweep that a scene file describes.

    Parameters
    ----------
    scene : SceneFile
        With a [sweep].
    workers, checkpoint : optional
        As of `sweep`; by default those of the file. A path in the file starts in its folder.

    Raises
    ------
    InputError
        If the file has no sweep, or every case of it fails.
    """
    settings = scene.data.get("sweep", {})
    if checkpoint is None and "checkpoint" in settings:
        checkpoint = scene.path.parent / settings["checkpoint"]
    table = sweep(
        scene,
        scene.grid,
        keep=scene.swept,
        workers=settings.get("workers", 1) if workers is None else workers,
        checkpoint=checkpoint,
    )
    if len(table.errors) == len(table):
        raise InputError(f"{scene.path}: every case of the sweep failed: {table.errors[0]}")
    return table


def _checked_grid(grid: Any) -> dict[str, list[Any]]:
    if not isinstance(grid, Mapping):
        raise InputTypeError(
            f'grid must be a dict such as {{"velocity": [0.5, 1.0]}}, got {type(grid).__name__}'
        )
    for name in grid:
        if not isinstance(name, str) or not name:
            raise InputTypeError(f"grid: names of parameters must be text, got {name!r}")
    checked = {name: sequence(f"grid[{name!r}]", values) for name, values in grid.items()}
    empty = next((f"[{name!r}]" for name, values in checked.items() if not values), "")
    if empty or not checked:
        raise InputError(f"grid{empty} has no values: there is nothing to sweep over")
    return checked


def _cases(make: Any, grid: Mapping[str, Sequence[Any]]) -> Iterator[Any]:
    """Make each case when it is needed; yield the exception of one that cannot be made."""
    for values in itertools.product(*grid.values()):
        try:
            yield make(**dict(zip(grid, values, strict=True)))
        except Exception as error:
            yield error


def _maker(base: Any, grid: Mapping[str, Sequence[Any]]) -> Any:
    """Return what makes a case of named parameters; refuse unknown names."""
    if isinstance(base, (str, os.PathLike)):
        base = read_scene(base)
    if isinstance(base, SceneFile):
        first = {name: values[0] for name, values in grid.items()}
        base.replaced(first)  # raises if there is no such place
        return lambda **parameters: base.replaced(parameters).case()
    if isinstance(base, Mapping):
        check_keywords("base and grid", simulate, [*grid, *base])
        return lambda **parameters: {**base, **parameters}
    if hasattr(base, "simulate"):
        check_keywords("grid", base.simulate, grid)
        return lambda duration=None, **rest: (SceneCase(base, rest), duration)
    if callable(base):
        return base
    raise InputTypeError(
        "base: sweep needs a function, a dict of simulate's keywords, a scene file or a scene, "
        f"got {base!r}"
    )
