"""A result's histories as one table, and the CSV file of it."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from .events import FloatArray

if TYPE_CHECKING:
    from .motion import BodyResult
    from .seen import Seen


def columns(result: Seen) -> dict[str, FloatArray]:
    """Return every history by its heading, "name [unit]", in the order of the CSV file."""
    table = {
        "t [s]": result.t,
        "force [N]": result.force,
        "indentation [m]": result.indentation,
        **_body_columns("projectile", result.projectile),
        **_body_columns("target", result.target),
    }
    if result.projectile.energy is not None:
        energy = result.energy
        table |= {
            "contact energy [J]": energy.contact,
            "dissipated energy [J]": energy.dissipated,
            "total energy [J]": energy.total,
        }
    return table


def write_csv(result: Seen, path: str | os.PathLike[str]) -> None:
    """Write the table with 17 digits, so that it reads back bit for bit."""
    table = columns(result)
    np.savetxt(
        path,
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
