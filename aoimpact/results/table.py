"""A result's histories as one table, and the CSV file of it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..base import FloatArray, InputError, file_path, texts

if TYPE_CHECKING:
    from .motion import BodyResult
    from .result import Result
    from .run import Run


def columns(result: Result) -> dict[str, FloatArray]:
    """Return every history by its heading, "name [unit]", in the order of the CSV file."""
    first = {"t [s]": result.t, "force [N]": result.force, "indentation [m]": result.indentation}
    return first | _of_bodies(result.run, ("projectile", "target"))


def run_columns(run: Run, names: Sequence[str] | None = None) -> dict[str, FloatArray]:
    """Return every history of a scene: contacts by number, bodies by number or by name."""
    table = {"t [s]": run.t}
    for i, contact in enumerate(run.contacts):
        table[f"contact {i} force [N]"] = contact.force
        table[f"contact {i} indentation [m]"] = contact.indentation
    return table | _of_bodies(run, body_names(len(run.bodies), names))


def _of_bodies(run: Run, names: Sequence[str]) -> dict[str, FloatArray]:
    """The histories of the bodies, and the energies where they are recorded."""
    table: dict[str, FloatArray] = {}
    for name, body in zip(names, run.bodies, strict=True):
        table |= _body_columns(name, body)
    if run.energies:
        table |= {
            "contact energy [J]": run.energy.contact,
            "dissipated energy [J]": run.energy.dissipated,
            "total energy [J]": run.energy.total,
        }
    return table


def body_names(count: int, names: Sequence[str] | None) -> list[str]:
    """Return what the bodies of a scene are called, "body 0", "body 1" if nothing else is said.

    Raises
    ------
    InputError
        If there are not as many different names as bodies.
    """
    if names is None:
        return [f"body {i}" for i in range(count)]
    given = texts("names", names)
    if len(given) != count or len(set(given)) != count:
        raise InputError(f"names must be {count} different ones, one a body, got {list(given)}")
    return list(given)


def write_csv(table: Mapping[str, FloatArray], path: str | os.PathLike[str]) -> None:
    """Write columns with 17 digits, so that they read back bit for bit."""
    np.savetxt(
        file_path("path", path),
        np.column_stack(list(table.values())),
        fmt="%.17g",
        delimiter=",",
        header=",".join(table),
        comments="",
        encoding="utf-8",
    )


def _body_columns(name: str, body: BodyResult) -> dict[str, FloatArray]:
    table = {
        f"{name} displacement [m]": body.displacement,
        f"{name} velocity [m/s]": body.velocity,
        f"{name} centre displacement [m]": body.centre_displacement,
        f"{name} centre velocity [m/s]": body.centre_velocity,
    }
    if body.energy is not None:
        table |= {
            f"{name} kinetic energy [J]": body.energy.kinetic,
            f"{name} elastic energy [J]": body.energy.elastic,
        }
    return table
