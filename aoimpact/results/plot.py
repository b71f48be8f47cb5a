"""Figures of a result.

Each function draws on the axes given, or on those of a new figure, and returns them; keywords go to
``Axes.plot``. Units get the prefix that suits the numbers, and a second curve on the same axes
keeps the prefix of the first. An ``ax`` that is no Axes raises InputTypeError.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..base import FloatArray, Scale, choice, given_axes, scale_for, scale_of
from ..laws import own_law
from .table import body_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .motion import BodyEnergy, Energy
    from .result import Result
    from .run import Run

Curve = tuple[FloatArray, dict[str, Any]]


def plot_indentation(result: Result, ax: Axes | None = None, **kwargs: Any) -> Axes:
    """Draw the indentation over time."""
    curves: list[Curve] = [(result.indentation, {})]
    return _draw(ax, (result.t, "time", "s"), "indentation", "m", curves, kwargs)


def plot_energy(
    run: Run,
    ax: Axes | None = None,
    *,
    body: Literal["projectile", "target"] | None = None,
    **kwargs: Any,
) -> Axes:
    """Draw energies over time: of everything, or of one body beside the contact's (Fig. 5).

    Raises
    ------
    InputError
        If `body` is another name, or the run recorded no energies.
    """
    energy = run.energy
    share: Energy | BodyEnergy = energy
    if body is not None:
        name = choice("body", body, ("projectile", "target"))
        share = energy.projectile if name == "projectile" else energy.target
    curves: list[Curve] = [
        (share.kinetic, {"label": "kinetic", "linestyle": ":"}),
        (share.elastic, {"label": "elastic (nonlocal)", "linestyle": "-"}),
        (energy.contact, {"label": "contact (local)", "linestyle": "-."}),
    ]
    if np.any(energy.dissipated):
        curves.append((energy.dissipated, {"label": "dissipated", "linestyle": "--"}))
    if body is None:
        curves.append((energy.total, {"label": "total", "linestyle": "-", "color": "0.6"}))
    return _draw(ax, (run.t, "time", "s"), "energy", "J", curves, kwargs)


def plot_displacement(result: Result, ax: Axes | None = None, **kwargs: Any) -> Axes:
    """Draw displacements over time: contact points, and centres of mass dashed (Fig. 10)."""
    curves: list[Curve] = []
    for colour, body in (("C0", result.projectile), ("C1", result.target)):
        name = body.name
        curves.append((body.displacement, {"label": f"{name}, contact point", "color": colour}))
        dashed = {"label": f"{name}, centre of mass", "color": colour, "linestyle": "--"}
        curves.append((body.centre_displacement, dashed))
    return _draw(ax, (result.t, "time", "s"), "displacement", "m", curves, kwargs)


def plot_interaction(result: Result, ax: Axes | None = None, **kwargs: Any) -> Axes:
    """Draw the force over the approach of the centres of mass, and the law itself (Fig. 7).

    The first is the modified interaction law of the paper: what rigid masses would need.
    """
    touching = np.flatnonzero(result.force > 0.0)
    shown = slice(0, int(touching[-1]) + 2 if touching.size else len(result.t))
    across = (result.approach[shown], "approach of the centres of mass", "m")
    curves: list[Curve] = [(result.force[shown], {"label": "modified law"})]
    ax = _draw(ax, across, "contact force", "N", curves, kwargs)
    law = getattr(own_law(result.law), "force", None)
    if touching.size and callable(law):
        depth = np.linspace(0.0, float(result.indentation.max()), 200)
        style = {"color": "0.4", "linestyle": "--", "label": "contact law", "zorder": 1}
        _curve(ax, _axis_scales(ax, "m", "N"), depth, np.asarray(law(depth)), style)
        ax.legend()
    return ax


def plot_forces(run: Run, ax: Axes | None = None, **kwargs: Any) -> Axes:
    """Draw the force of each contact over time (paper, Figs. 3 and 9)."""
    several = len(run.contacts) > 1
    curves: list[Curve] = [
        (contact.force, {"label": contact.name} if several else {}) for contact in run.contacts
    ]
    return _draw(ax, (run.t, "time", "s"), "contact force", "N", curves, kwargs)


def plot_places(
    run: Run, ax: Axes | None = None, *, names: Sequence[str] | None = None, **kwargs: Any
) -> Axes:
    """Draw the displacements of the contact coordinates of a scene's bodies over time."""
    curves: list[Curve] = [
        (body.displacement, {"label": name})
        for name, body in zip(body_names(run, names), run.bodies, strict=True)
    ]
    return _draw(ax, (run.t, "time", "s"), "displacement", "m", curves, kwargs)


def _draw(
    ax: Axes | None,
    across: tuple[FloatArray, str, str],
    name: str,
    unit: str,
    curves: list[Curve],
    kwargs: dict[str, Any],
) -> Axes:
    """Draw curves over (values, name, unit) `across`, on axes labelled with units."""
    ax = given_axes(ax)
    x, x_name, x_unit = across
    largest = max(float(np.max(np.abs(y), initial=0.0)) for y, _ in curves)
    scales = _axis_scales(ax, x_unit, unit)
    x_scale = scales[0] or scale_for(float(np.max(np.abs(x), initial=0.0)), x_unit)
    y_scale = scales[1] or scale_for(largest, unit)
    for y, style in curves:
        _curve(ax, (x_scale, y_scale), x, y, style | kwargs)
    ax.set_xlabel(f"{x_name} [{x_scale.unit}]")
    ax.set_ylabel(f"{name} [{y_scale.unit}]")
    ax.grid(True, alpha=0.3)
    if any(not str(line.get_label()).startswith("_") for line in ax.get_lines()):
        ax.legend()
    return ax


def _axis_scales(ax: Axes, x_unit: str, y_unit: str) -> tuple[Scale | None, Scale | None]:
    return scale_of(ax.get_xlabel(), x_unit), scale_of(ax.get_ylabel(), y_unit)


def _curve(
    ax: Axes,
    scales: tuple[Scale | None, Scale | None],
    x: FloatArray,
    y: FloatArray,
    style: dict[str, Any],
) -> None:
    x_factor, y_factor = (1.0 if scale is None else scale.factor for scale in scales)
    ax.plot(x_factor * x, y_factor * y, **style)
