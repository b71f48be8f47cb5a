"""A result's histories as one table, and the CSV file of it."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..base import FloatArray, InputError, texts, written_file

if TYPE_CHECKING:
    from .motion import BodyResult
    from .result import Result
    from .run import Run


# What the bodies of an impact are called without names of their own.
ROLES = ("projectile", "target")


def columns(result: Result) -> dict[str, FloatArray]:
    """Return every history by its heading, "name [unit]", in the order of the CSV file."""
    first = {"t [s]": result.t, "force [N]": result.force, "indentation [m]": result.indentation}
    return first | _of_bodies(result.run, result.run.names)


def run_columns(run: Run, names: Sequence[str] | None = None) -> dict[str, FloatArray]:
    """Return every history of a scene: contacts and bodies by name, or by number."""
    table = {"t [s]": run.t}
    for contact in run.contacts:
        table[f"{contact.name} force [N]"] = contact.force
        table[f"{contact.name} indentation [m]"] = contact.indentation
    return table | _of_bodies(run, body_names(run, names))


def different(names: Sequence[str], others: Sequence[str]) -> tuple[str, ...]:
    """Return names, each another: `others` where there is none, and after a shared one."""
    called = [name or other for name, other in zip(names, others, strict=True)]
    times = Counter(called)
    return tuple(
        f"{name} ({other})" if times[name] > 1 else name
        for name, other in zip(called, others, strict=True)
    )


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


def body_names(run: Run, names: Sequence[str] | None) -> Sequence[str]:
    """Return what the bodies of a scene are called: by their own names if no others are given.

    Raises
    ------
    InputError
        If there are not as many different names as bodies.
    """
    if names is None:
        return run.names
    given, count = texts("names", names), len(run.bodies)
    if len(given) != count or len(set(given)) != count:
        raise InputError(f"names must be {count} different ones, one a body, got {list(given)}")
    return given


def write_csv(table: Mapping[str, FloatArray], path: str | os.PathLike[str]) -> None:
    """Write columns with 17 digits, so that they read back bit for bit."""
    with written_file("path", path) as file:
        np.savetxt(
            file,
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
