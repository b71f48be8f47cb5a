"""A run's histories for pandas and xarray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import FloatArray, optional_package

if TYPE_CHECKING:
    from .result import Result
    from .run import Run

__all__ = ["as_dataframe", "as_dataset", "result_dataset"]

# Of each kind of history: its unit, and what it is.
_UNITS = {
    "force": ("N", "contact force, positive in compression"),
    "indentation": ("m", "first body's minus second body's contact coordinate minus the gap"),
    "displacement": ("m", "of the contact coordinate"),
    "velocity": ("m/s", "of the contact coordinate"),
    "centre_displacement": ("m", "of the centre of mass"),
    "centre_velocity": ("m/s", "of the centre of mass"),
    "kinetic_energy": ("J", "of each body"),
    "elastic_energy": ("J", "strain energy of each body"),
    "contact_energy": ("J", "stored in the contact laws"),
    "dissipated_energy": ("J", "lost in contact laws and damping since t = 0"),
    "total_energy": ("J", "constant in an exact run"),
}


def as_dataframe(table: Mapping[str, FloatArray]) -> Any:
    """Return columns "name [unit]", times first, as a pandas DataFrame with times for its index."""
    pandas = optional_package("pandas", "to_dataframe", "take .to_csv(path)")
    times, *others = table
    index = pandas.Index(table[times], name=times)
    return pandas.DataFrame({name: table[name] for name in others}, index=index)


def as_dataset(run: Run, names: Sequence[str]) -> Any:
    """Return a run as an xarray Dataset with dimensions time, contact and body."""
    xarray = optional_package("xarray", "to_xarray", "take .to_csv(path) or the arrays themselves")
    data: dict[str, Any] = {}

    def add(name: str, dims: tuple[str, ...], values: Any) -> None:
        unit, meaning = _UNITS[name]
        data[name] = (dims, np.array(values), {"units": unit, "long_name": meaning})

    for name in ("force", "indentation"):
        rows = [getattr(contact, name) for contact in run.contacts]
        add(name, ("contact", "time"), np.reshape(rows, (len(rows), len(run.t))))
    for name in ("displacement", "velocity", "centre_displacement", "centre_velocity"):
        add(name, ("body", "time"), [getattr(body, name) for body in run.bodies])
    if run.energies:
        for name in ("kinetic", "elastic"):
            rows = [getattr(share, name) for share in run.energy.bodies]
            add(f"{name}_energy", ("body", "time"), rows)
        for name in ("contact", "dissipated", "total"):
            add(f"{name}_energy", ("time",), getattr(run.energy, name))
    coordinates = {
        "time": ("time", run.t, {"units": "s", "long_name": "time"}),
        "contact": list(run.contact_names),
        "body": list(names),
    }
    return xarray.Dataset(data, coordinates, {"solver": run.solver})


def result_dataset(result: Result) -> Any:
    """Return an impact of two bodies as an xarray Dataset; its one contact is no dimension."""
    run = result.run
    dataset = as_dataset(run, run.names).squeeze("contact", drop=True)
    known = {"velocity": result.velocity, "gap": result.gap, "law": str(result.law)}
    return dataset.assign_attrs(known)
