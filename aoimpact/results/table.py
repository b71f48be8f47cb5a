"""A run's histories as one table: for a CSV file, pandas and xarray."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import FloatArray, InputError, optional_package, texts
from ..laws import own_law

if TYPE_CHECKING:
    from .motion import BodyResult
    from .run import Run


# Names of the bodies of an impact that have none of their own.
ROLES = ("projectile", "target")

# Unit and description of each kind of history.
_UNITS = {
    "force": ("N", "contact force, positive in compression"),
    "friction_force": ("N", "on the second body, in three directions"),
    "stuck": ("1", "share of the contact's radius within which it sticks"),
    "indentation": ("m", "of the contact law; negative while the bodies are apart"),
    "displacement": ("m", "of the contact coordinate"),
    "velocity": ("m/s", "of the contact coordinate"),
    "centre_displacement": ("m", "of the centre of mass"),
    "centre_velocity": ("m/s", "of the centre of mass"),
    "spin": ("rad/s", "of each body, in three directions"),
    "kinetic_energy": ("J", "of each body"),
    "elastic_energy": ("J", "strain energy of each body"),
    "contact_energy": ("J", "stored in the contact laws"),
    "dissipated_energy": ("J", "lost in contact laws and damping since t = 0"),
    "friction_energy": ("J", "the part of it lost by friction"),
    "total_energy": ("J", "constant in an exact run"),
}


def columns(run: Run, names: Sequence[str] | None = None) -> dict[str, FloatArray]:
    """Return every history by its heading, "name [unit]", in the order of the CSV file."""
    table = {"t [s]": run.t}
    for contact in run.each_contact:
        called = f"{contact.name} " if run.plan.scene else ""
        table[f"{called}force [N]"] = contact.force
        table[f"{called}indentation [m]"] = contact.indentation
        if contact.friction_force is not None:
            for axis, force in zip("xyz", contact.friction_force.T, strict=True):
                table[f"{called}friction force {axis} [N]"] = force
        if contact.stuck is not None:
            table[f"{called}stuck [1]"] = contact.stuck
    for number, name in enumerate(body_names(run, names)):
        table |= _body_columns(name, run.bodies[number])
        if turns(run, number):
            for axis, spin in zip("xyz", run.bodies[number].spin.T, strict=True):
                table[f"{name} spin {axis} [rad/s]"] = spin
    if run.energies:
        table |= {
            "contact energy [J]": run.energy.contact,
            "dissipated energy [J]": run.energy.dissipated,
            "total energy [J]": run.energy.total,
        }
        if run.plan.oblique is not None:
            table["friction energy [J]"] = run.energy.friction
    return table


def turns(run: Run, body: int) -> bool:
    """True of a body that has a spin: in three directions, and not held."""
    return run.plan.oblique is not None and not run.plan.bodies[body].fixed


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


def different(names: Sequence[str], others: Sequence[str]) -> tuple[str, ...]:
    """Return distinct names: `others` in place of an empty one, and after a shared one."""
    called = [name or other for name, other in zip(names, others, strict=True)]
    times = Counter(called)
    return tuple(
        f"{name} ({other})" if times[name] > 1 else name
        for name, other in zip(called, others, strict=True)
    )


def body_names(run: Run, names: Sequence[str] | None) -> Sequence[str]:
    """Return the names of a run's bodies: their own if no others are given.

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
        rows = [getattr(contact, name) for contact in run.each_contact]
        add(name, ("contact", "time"), np.reshape(rows, (len(rows), len(run.t))))
    if run.each_contact and all(of.friction_force is not None for of in run.each_contact):
        rows = [of.friction_force for of in run.each_contact]
        add("friction_force", ("contact", "time", "axis"), rows)
        add("stuck", ("contact", "time"), [of.stuck for of in run.each_contact])
    for name in ("displacement", "velocity", "centre_displacement", "centre_velocity"):
        add(name, ("body", "time"), [getattr(body, name) for body in run.bodies])
    if run.plan.oblique is not None:
        unknown = np.full((len(run.t), 3), np.nan)
        spins = [of.spin if turns(run, i) else unknown for i, of in enumerate(run.bodies)]
        add("spin", ("body", "time", "axis"), spins)
    if run.energies:
        for name in ("kinetic", "elastic"):
            rows = [getattr(share, name) for share in run.energy.bodies]
            add(f"{name}_energy", ("body", "time"), rows)
        for name in ("contact", "dissipated", "total"):
            add(f"{name}_energy", ("time",), getattr(run.energy, name))
        if run.plan.oblique is not None:
            add("friction_energy", ("time",), run.energy.friction)
    coordinates = {
        "time": ("time", run.t, {"units": "s", "long_name": "time"}),
        "contact": list(run.contact_names),
        "body": list(names),
    }
    dataset = xarray.Dataset(data, coordinates, {"solver": run.solver})
    if run.plan.scene:
        return dataset
    known = {"velocity": run.plan.velocities[0], "gap": run.plan.contacts[0].gap}
    dataset = dataset.squeeze("contact", drop=True)  # of the one contact of an impact
    return dataset.assign_attrs(known | {"law": str(own_law(run.plan.contacts[0].law))})
