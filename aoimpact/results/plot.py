"""Plots of a result, and the shapes of both bodies of an impact for a movie.

A plot is drawn on the given axes, or on those of a new figure, and returns them; keywords go to
``Axes.plot``. Units get the prefix that suits the numbers, and a second curve on the same axes
keeps the prefix of the first. `during` is the time span that is drawn: "contact" (from shortly
before the first contact to shortly after the last), "record", or (start, end), s. An ``ax`` that is
no Axes raises InputTypeError.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import cycle
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from ..base import (
    COLOURS,
    DASHES,
    Curve,
    FloatArray,
    InputError,
    choice,
    draw_curves,
    finite_array,
    new_axes,
)
from ..fields import Shown
from ..laws import own_law
from ..mesh import sphere_mesh
from .quantities import read
from .table import ROLES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .run import BodyEnergy, Energy, Handle, Result, Run

During = Literal["contact", "record"] | tuple[float, float]

AnyRun = TypeVar("AnyRun", bound="Run")

# Time shown before and after the contact, relative to the contact's duration.
_MARGIN = 0.1

# Element size in the picture of a rigid ball, relative to its radius.
_SIZE = 0.35


def shown(run: AnyRun, during: During) -> AnyRun:
    """Return a run at enough times within a time span for smooth curves.

    Runs with fixed steps, or read at chosen times, keep their times. Any other run is evaluated as
    finely as its fastest natural mode requires.

    Raises
    ------
    InputError
        If `during` is neither a word nor a span within the record.
    """
    start, end = span_of(run, during)
    if run.recorder.dense and run.asked is None:
        own = run.t[(run.t >= start) & (run.t <= end)]
        return run.at(np.union1d(run.even_times(start, end), own))
    first = max(0, int(np.searchsorted(run.t, start, side="right")) - 1)
    return replace(run, asked=run.t[first : int(np.searchsorted(run.t, end)) + 1])


def span_of(run: Run, during: During) -> tuple[float, float]:
    """Return the start and end of the time span that is drawn, s."""
    if isinstance(during, str):
        word = choice("during", during, ("contact", "record"))
        if word == "record" or run.touching is None:
            return 0.0, run.duration
        first, last = run.touching
        margin = _MARGIN * (last - first)
        return max(0.0, first - margin), min(run.duration, last + margin)
    start, end = finite_array("during", during, shape=(2,), unit="s")
    if not 0.0 <= start < end <= run.duration:
        raise InputError(
            f"during must be a span (start, end) within the record, 0 to {run.duration:g} s, got "
            f"({start:g}, {end:g})"
        )
    return float(start), float(end)


def plot(result: Result, *, during: During = "contact") -> Any:
    """Draw force, indentation, displacements and energies in four panels.

    Parameters
    ----------
    during : {"contact", "record"} or (float, float), optional
        Time span to draw: the contacts with a margin on both sides, the whole record, or
        (start, end), s.

    Returns
    -------
    ndarray of Axes, shape (2, 2)
        ``axes[0, 0].figure`` is the figure, to be saved or changed.

    Examples
    --------
    >>> import aoimpact as ao
    >>> ball = ao.rigid(mass=0.0327)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
    >>> axes = hit.plot()
    >>> axes[0, 0].figure.savefig("impact.png")  # doctest: +SKIP
    """
    axes = new_axes(2, 2, figsize=(10.0, 6.6), sharex=True)
    plot_force(result, axes[0, 0], during=during)
    plot_indentation(result, axes[0, 1], during=during)
    plot_displacement(result, axes[1, 0], during=during)
    if result.plan.energies:
        plot_energy(result, axes[1, 1], during=during)
    else:
        axes[1, 1].set_axis_off()
    for ax in axes[0]:
        ax.set_xlabel("")
    bodies = " on ".join(f"{of.name} ({of.label})" for of in result.bodies)
    title = f"{bodies}, {result.velocity:g} m/s; {result.law}"
    axes[0, 0].figure.suptitle(title, fontsize="medium")
    return axes


def plot_indentation(
    result: Result, ax: Axes | None = None, *, during: During = "contact", **kwargs: Any
) -> Axes:
    """Draw the indentation over time; `during` is as for `plot`. Returns the axes.

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
    >>> ax = hit.plot_indentation()
    """
    run = shown(result, during)
    depth = run.indentation
    apart = (depth < 0.0) & (run.force == 0.0)
    drawn = depth if apart.all() else np.where(apart, np.nan, depth)
    return draw_curves(ax, (run.t, "time", "s"), "indentation", "m", [(drawn, {})], kwargs)


def plot_energy(
    run: Run,
    ax: Axes | None = None,
    *,
    body: Handle | int | str | None = None,
    during: During = "contact",
    **kwargs: Any,
) -> Axes:
    """Draw the energies over time, of all bodies or of one (paper, Fig. 5).

    `body` is a body's handle or number or, in an impact, "projectile" or "target".

    Examples
    --------
    >>> scene = ao.Scene()
    >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    >>> wall = scene.add(ao.rigid(mass=float("inf")))
    >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
    >>> run = scene.simulate(duration=1e-3)
    >>> ax = run.plot_energy()
    """
    run = shown(run, during)
    energy = run.energy
    share: Energy | BodyEnergy = energy
    if body is not None:
        if isinstance(body, str) or not run.plan.scene:
            body = ROLES.index(choice("body", body, ROLES))
        share = run[body].energy or energy
    known = {
        "kinetic": share.kinetic,
        "elastic (nonlocal)": share.elastic,
        "contact (local)": energy.contact,
        "dissipated": energy.dissipated,
    }
    curves: list[Curve] = [
        (values, {"label": name, "linestyle": dashes, "color": colour})
        for (name, values), dashes, colour in zip(known.items(), DASHES, COLOURS, strict=False)
        if name != "dissipated" or np.any(values)
    ]
    if body is None:
        curves.append((energy.total, {"label": "total", "linestyle": "-", "color": "0.5"}))
    return draw_curves(ax, (run.t, "time", "s"), "energy", "J", curves, kwargs)


def plot_displacement(
    run: Run,
    ax: Axes | None = None,
    *,
    during: During = "contact",
    **kwargs: Any,
) -> Axes:
    """Draw the displacement of each body's contact coordinate over time.

    An impact also shows the centres of mass, dashed (paper, Fig. 10).

    Examples
    --------
    >>> scene = ao.Scene()
    >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    >>> wall = scene.add(ao.rigid(mass=float("inf")))
    >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
    >>> run = scene.simulate(duration=1e-3)
    >>> ax = run.plot_displacement()
    """
    run = shown(run, during)
    curves: list[Curve] = []
    for body, colour in zip(run.bodies, cycle(COLOURS), strict=False):
        name, place, centre = body.name, body.displacement, body.centre_displacement
        style = {} if run.plan.scene else {"color": colour, "linestyle": "-"}
        bends = bool(style) and not np.array_equal(place, centre)
        curves.append((place, style | {"label": f"{name}, contact point" if bends else name}))
        if bends and np.isfinite(centre).all():
            dashed = {"label": f"{name}, centre of mass", "linestyle": "--"}
            curves.append((centre, style | dashed))
    return draw_curves(ax, (run.t, "time", "s"), "displacement", "m", curves, kwargs)


def plot_interaction(result: Result, ax: Axes | None = None, **kwargs: Any) -> Axes:
    """Draw the force against the approach of the centres of mass (paper, Fig. 7).

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
    >>> ax = hit.plot_interaction()
    """
    at = shown(result, "contact")
    touching = np.flatnonzero(at.force > 0.0)
    which = slice(0, int(touching[-1]) + 2 if touching.size else None)
    across = (at.approach[which], "approach of the centres of mass", "m")
    name, known = ("contact force", "N"), {"label": "modified law"}
    ax = draw_curves(ax, across, *name, [(at.force[which], known)], kwargs)
    law = getattr(own_law(result.law), "force", None)
    if touching.size and callable(law):
        depth = np.linspace(0.0, float(result.indentation.max()), 200)
        style = {"color": "0.4", "linestyle": "--", "label": "contact law", "zorder": 1}
        ax = draw_curves(ax, (depth, *across[1:]), *name, [(law(depth), style)])
    return ax


def plot_force(
    run: Run, ax: Axes | None = None, *, during: During = "contact", **kwargs: Any
) -> Axes:
    """Draw the force of each contact over time; keywords go to ``Axes.plot``.

    `during` is "contact", from the first contact to the last with a margin on both sides,
    "record", or (start, end), s.

    Examples
    --------
    >>> scene = ao.Scene()
    >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    >>> wall = scene.add(ao.rigid(mass=float("inf")))
    >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
    >>> run = scene.simulate(duration=1e-3)
    >>> ax = run.plot_force()
    """
    run = shown(run, during)
    curves: list[Curve] = []
    for contact, of in zip(run.plan.contacts, run.each_contact, strict=True):
        first, second = (run.plan.body_names[body] for body in (contact.first, contact.second))
        # The label of a contact without a name includes the names of its bodies.
        alone = contact.name or not (first and second)
        label = of.name if alone else f"{of.name}: {first} on {second}"
        curves.append((of.force, {"label": label} if len(run.each_contact) > 1 else {}))
    return draw_curves(ax, (run.t, "time", "s"), "contact force", "N", curves, kwargs)


def shown_bodies(hit: Result, times: FloatArray) -> tuple[list[Shown], FloatArray]:
    """Return the bodies that can be drawn, and the direction of travel.

    The target is drawn in the coordinates of its mesh; the projectile is turned and moved to touch
    it. A round projectile without a mesh is drawn as a ball.
    """
    from scipy.spatial.transform import Rotation

    tips: list[Any] = [model.touched_at() for model in hit.plan.bodies]
    meshed = [tip if tip and tip.point is not None and tip.body.mesh else None for tip in tips]
    main = meshed[1] or meshed[0]
    if main is None:
        raise InputError(
            "movie needs a body of finite elements: make it with FEModel.from_mesh(...), and its "
            "model with antioscillators(tip, n) or leave that to simulate"
        )
    down, place = main.direction, main.point
    bodies = []
    for body, tip in ((hit.target, meshed[1]), (hit.projectile, meshed[0])):
        if tip is None:
            continue
        field = body.field(times)
        mesh: Any = field.body.mesh
        points, moved = mesh.nodes, field.displacement
        if tip is not main:
            turn = Rotation.align_vectors(down, tip.direction)[0].as_matrix()
            points = (points - tip.point) @ turn.T + place - hit.gap * down
            moved = moved @ turn.T
        bodies.append(Shown(mesh, points, moved, field.stress().von_mises))
    surface = hit.plan.bodies[0].surface_at()
    if meshed[0] is None and surface is not None and 0.0 < surface.radii[0] < np.inf:
        radius = surface.radii[0]
        mesh = sphere_mesh(radius, _SIZE * radius)
        way = read(lambda run: run.bodies[0].centre_displacement, hit, times)
        moved = np.repeat((way[:, None] * down)[:, None], mesh.n_nodes, axis=1)
        middle = place - (radius + hit.gap) * down
        bodies.append(Shown(mesh, mesh.nodes + middle, moved, np.full(moved.shape[:2], np.nan)))
    return bodies, down
