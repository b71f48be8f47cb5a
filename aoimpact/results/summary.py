"""The few lines that a result prints of itself, as text and as a table of a notebook."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING

import numpy as np

from ..base import quantity
from ..fem import ContactPoint
from ..reduction import AOModel, touched
from .motion import LEAST_REBOUND, in_words, percent

if TYPE_CHECKING:
    from ..scene import SceneBody
    from .motion import BodyResult
    from .result import Result


_RIGID = "rigid", "wall"

# Coordinates that are rounding, m.
_NOTHING = 1e-12


def summary_rows(result: Result) -> list[tuple[str, str]]:
    """Return (name, value with unit) for everything that a user asks first."""
    rows = [
        ("projectile", _body(result, "projectile")),
        ("target", _body(result, "target")),
        ("law", str(result.law)),
        ("velocity", f"{result.velocity:.6g} m/s" + _gap(result)),
    ]
    if not result.contacts:
        rows.append(("contact", f"none in {quantity(result.duration, 's')}"))
    else:
        rows += [
            ("peak force", _force(result)),
            ("contact", _contact(result)),
            ("impulse", quantity(result.impulse, "N s") + result.error.told("impulse")),
        ]
    rows += [
        ("rebound velocity", _rebound(result, "rebound_velocity", " m/s")),
        ("restitution", _rebound(result, "restitution")),
        (_of_what(result), _error(result)),
        ("solver", result.solver),
    ]
    chosen = [model for model in result.models or () if isinstance(model, AOModel)]
    made_by = [model.origin.solver for model in chosen if model.origin is not None]
    if any(made_by):
        rows.append(("linear solver", ", ".join(dict.fromkeys(filter(None, made_by)))))
    rows.append(("cost", str(result.cost)))
    return rows


def summary_text(result: Result) -> str:
    """Return the summary as lines of text."""
    lines = [f"  {name:<18} {value}" for name, value in summary_rows(result)]
    return "\n".join(["Impact", *lines])


def summary_html(result: Result) -> str:
    """Return the summary as an HTML table."""
    cells = "".join(
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(value)}</td></tr>'
        for name, value in summary_rows(result)
    )
    return f"<table><caption>Impact</caption><tbody>{cells}</tbody></table>"


def _body(result: Result, which: str) -> str:
    body = result.projectile if which == "projectile" else result.target
    mass = ", mass not known" if body.mass is None else f", {quantity(body.mass, 'kg')}"
    if body.mass == math.inf:
        mass = ""
    name = "" if body.name == which else f"{body.name}: "
    model = result.run.plan.bodies[0 if which == "projectile" else 1].model
    place = place_words(touched(model), rigid=body.label in _RIGID)
    return f"{name}{body.label}{mass}{support_words(body)}{place}"


def support_words(body: BodyResult | SceneBody) -> str:
    """Return whether something holds a body, for those that could be held."""
    if body.label in _RIGID:
        return ""
    return ", constrained" if body.constrained else ", free"


def place_words(tip: ContactPoint | None, *, rigid: bool = False) -> str:
    """Return where and over what a body is touched, along which direction."""
    if tip is None or tip.point is None or tip.direction is None:
        return ""
    what = "point" if tip.node is None else f"node {tip.node}"
    if tip.patch is not None:
        what = f"patch of {quantity(tip.patch.radius, 'm', 3)}"
    if rigid:
        what = "touched"
    point, along = (
        ", ".join(f"{x:.4g}" for x in np.where(np.abs(of) < _NOTHING, 0.0, of))
        for of in (tip.point, tip.direction)
    )
    return f", {what} at ({point}) m along ({along})"


def _rebound(result: Result, name: str, unit: str = "") -> str:
    value = getattr(result, name)
    if not math.isnan(value):
        least = LEAST_REBOUND * (abs(result.velocity) if unit else 1.0)
        error = result.error.of(name)
        if abs(value) < least and error is not None and math.isfinite(error):
            return f"{value:.5g}{unit} ± {error * least:.2g}{unit}"  # what `error` is relative to
        return f"{value:.5g}{unit}{result.error.told(name)}"
    return "none" if result.in_contact_at_end or not result.contacts else "not known"


def _gap(result: Result) -> str:
    return f", gap {quantity(result.gap, 'm')}" if result.gap else ""


def _force(result: Result) -> str:
    told = result.error.told
    force = f"{quantity(result.peak_force, 'N', 5)}{told('peak_force', listed=True)}"
    return f"{force} at {quantity(result.peak_time, 's')}{told('peak_time')}"


def _contact(result: Result) -> str:
    start = result.contacts[0][0]
    told = result.error.told
    text = f"{quantity(result.contact_duration, 's')}{told('contact_duration')}"
    text += f" from {quantity(start, 's')}"
    uncertain = result.error.of("contacts") == math.inf
    if len(result.contacts) > 1 or uncertain:
        number = f"{len(result.contacts)}, more or less" if uncertain else len(result.contacts)
        text += f", the first of {number}"
    if result.in_contact_at_end:
        text += " (the record ends in contact)"
    return text


def _of_what(result: Result) -> str:
    known = result.error.quantity is not None or result.error.mesh is not None
    return "error" if known else "error of the peak"


def _error(result: Result) -> str:
    """Of the quantity of interest: of a history, at its worst over the record."""
    error = result.error
    parts = {
        "mesh": error.mesh,
        "contact": error.contact,
        "model": error.reduction,
        "time": error.time,
    }
    if error.mesh is None and not any(body.model.contact_points for body in result.run.plan.bodies):
        del parts["mesh"], parts["contact"]  # there is none
    known = [part for part in parts.values() if part is not None]
    listed = in_words(parts)
    if error.quantity is None and error.mesh is None:
        return f"{listed} %"
    total = math.fsum(known)
    within = f"± {percent(total)} %" if math.isfinite(total) else "not bounded"
    interest = error.quantity or "force"
    if interest == "contact_count":  # a share of a number of contacts is none
        sure = not any(part for cause, part in parts.items() if cause != "time")
        return f"contact count {'certain' if sure else 'more or less'} ({listed})"
    name = interest.replace("_", " ")
    if interest not in {*error.numbers, *error.left_out.mesh_numbers}:  # a history
        name += f", at its worst over the record{_when(result)},"
    if error.quantity is None:
        return f"{name} {within} ({listed})"
    aim = f"{100.0 * (error.rtol or 0.0):.2g} %"
    missed = (error.reduction or 0.0) > (error.rtol or 0.0)
    chosen = f"no models tried meet {aim}" if missed else f"models and steps chosen for {aim}"
    return f"{name} {within} ({listed}); {chosen}"


def _when(result: Result) -> str:
    """In which contact the force is off most, where there are several: mostly by when it begins."""
    when = result.error.left_out.worst_time
    if when is None or len(result.contacts) < 2 or (result.error.quantity or "force") != "force":
        return ""
    away = [max(start - when, when - end) for start, end in result.contacts]
    return f" (in contact {away.index(min(away)) + 1} of {len(away)})"
