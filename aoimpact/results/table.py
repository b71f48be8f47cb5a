"""A run's histories as one table, for CSV files, pandas and xarray."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import FilePath, FloatArray, optional_package, write_csv
from ..laws import own_law

if TYPE_CHECKING:
    from .run import Run


# Default names of the bodies of an impact.
ROLES = ("projectile", "target")

# Name, unit and description of every history of a contact, of a body and of the run, in the order
# of the CSV file. "kinetic_energy" is the attribute ``energy.kinetic``; other energies are named
# alike.
_HISTORIES = {
    "contact": (
        ("force", "N", "contact force, positive in compression"),
        ("indentation", "m", "indentation of the contact law; negative while the bodies are apart"),
        ("friction_force", "N", "friction force on the second body, in three directions"),
        ("stuck", "1", "ratio of the radius of the stick zone to the radius of the contact"),
    ),
    "body": (
        ("displacement", "m", "displacement of the contact coordinate"),
        ("velocity", "m/s", "velocity of the contact coordinate"),
        ("centre_displacement", "m", "displacement of the centre of mass"),
        ("centre_velocity", "m/s", "velocity of the centre of mass"),
        ("kinetic_energy", "J", "kinetic energy of each body"),
        ("elastic_energy", "J", "strain energy of each body"),
        ("spin", "rad/s", "angular velocity of each body, in three directions"),
    ),
    "run": (
        ("contact_energy", "J", "energy stored in the contact laws"),
        ("dissipated_energy", "J", "energy lost in contact laws, friction and damping since t = 0"),
        ("total_energy", "J", "total energy, constant in an exact run"),
        ("friction_energy", "J", "part of the dissipated energy lost by friction"),
    ),
}


def _history(run: Run, kind: str, number: int, name: str) -> FloatArray | None:
    """Return a history by its name, shape (n,) or (n, 3); None if the run does not have it."""
    of: Any = {"contact": run.each_contact, "body": run.bodies, "run": (run,)}[kind][number]
    absent = run.plan.oblique is None or (name == "spin" and of.constrained)
    if absent and name in ("spin", "friction_energy"):
        return None
    if not name.endswith("_energy"):
        found: FloatArray | None = getattr(of, name)
        return found
    return getattr(of.energy, name.removesuffix("_energy")) if run.plan.energies else None


def columns(run: Run) -> dict[str, FloatArray]:
    """Return every history by its heading, "name [unit]", in the order of the CSV file."""
    table = {"t [s]": run.t}
    contacts = run.contact_names if run.plan.scene else ("",)
    owners = {"contact": contacts, "body": run.names, "run": ("",)}
    for kind, called in owners.items():
        for number, owner in enumerate(called):
            for name, unit, _ in _HISTORIES[kind]:
                heading = f"{owner} {name.replace('_', ' ')}".lstrip()
                values = _history(run, kind, number, name)
                if values is None:
                    continue
                axes = ("",) if values.ndim == 1 else (" x", " y", " z")
                for axis, component in zip(axes, np.atleast_2d(values.T), strict=True):
                    table[f"{heading}{axis} [{unit}]"] = component
    return table


def different(names: Sequence[str], others: Sequence[str]) -> tuple[str, ...]:
    """Return distinct names: `others` replace empty names and are appended to names that repeat."""
    called = [name or other for name, other in zip(names, others, strict=True)]
    times = Counter(called)
    return tuple(
        f"{name} ({other})" if times[name] > 1 else name
        for name, other in zip(called, others, strict=True)
    )


def to_csv(run: Run, path: FilePath) -> None:
    """Write all histories to a CSV file, one row per time, with names and units in the header.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> scene = ao.Scene()
    >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    >>> wall = scene.add(ao.rigid(mass=float("inf")))
    >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
    >>> run = scene.simulate(duration=1e-3)
    >>> run.to_csv(folder / "scene.csv")
    """
    table = columns(run)
    write_csv(path, table, np.column_stack(list(table.values())).tolist())


def to_dataframe(run: Run) -> Any:
    """Return all histories as a pandas DataFrame, one row per time.

    The columns are those of `to_csv`, "name [unit]"; the index is "t [s]".

    Raises
    ------
    MissingPackageError
        If pandas is not installed.

    Examples
    --------
    >>> import aoimpact as ao
    >>> ball = ao.rigid(mass=0.0327)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
    >>> table = hit.to_dataframe()
    >>> float(table["force [N]"].max()) == hit.peak_force
    True
    """
    pandas = optional_package("pandas", "to_dataframe", "take .to_csv(path)")
    return pandas.DataFrame(columns(run)).set_index("t [s]")


def to_xarray(run: Run) -> Any:
    """Return all histories as an xarray Dataset, with units.

    Dimensions are time, contact and body, and the axis of vectors:
    ``data.sel(body="body 1").velocity`` is one history.

    Raises
    ------
    MissingPackageError
        If xarray is not installed.

    Examples
    --------
    >>> import aoimpact as ao
    >>> ball = ao.rigid(mass=0.0327)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
    >>> data = hit.to_xarray()
    >>> data.force.attrs["units"], float(data.force.max()) == hit.peak_force
    ('N', True)
    """
    xarray = optional_package("xarray", "to_xarray", "take .to_csv(path) or the arrays themselves")
    called = {"contact": run.contact_names, "body": run.names, "run": ("",)}
    data: dict[str, Any] = {}
    for kind, owners in called.items():
        for name, unit, meaning in _HISTORIES[kind]:
            rows = [_history(run, kind, number, name) for number in range(len(owners))]
            known = [row for row in rows if row is not None]
            if known:
                unknown = np.full_like(known[0], np.nan)
                values = np.array([unknown if row is None else row for row in rows])
                dims = (kind, "time", "axis")[: values.ndim]
                data[name] = (dims, values, {"units": unit, "long_name": meaning})
    time = "time", run.t, {"units": "s", "long_name": "time"}
    names = {kind: list(owners) for kind, owners in called.items()}
    dataset = xarray.Dataset(data, {"time": time, **names}, {"solver": run.solver})
    dataset = dataset.squeeze("run", drop=True)
    if run.plan.scene:
        return dataset
    contact = run.plan.contacts[0]
    dataset = dataset.squeeze("contact", drop=True)  # an impact has one contact
    given = {"velocity": run.plan.velocities[0], "gap": contact.gap}
    return dataset.assign_attrs(given, law=str(own_law(contact.law)))
