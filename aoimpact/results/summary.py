"""The few lines that a result prints of itself, as text and as a table of a notebook."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING

from ..base import quantity

if TYPE_CHECKING:
    from ..scene import SceneBody
    from .motion import BodyResult
    from .result import Result


# Errors below this share are rounding.
_ROUNDING = 1e-9


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
        ("error of the peak" if result.error.quantity is None else "asked for", _error(result)),
        ("solver", result.solver),
    ]
    made_by = [model.origin.solver for model in result.models or () if model.origin is not None]
    if any(made_by):
        rows.append(("linear solver", ", ".join(dict.fromkeys(filter(None, made_by)))))
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
    mass = "mass not known" if body.mass is None else quantity(body.mass, "kg")
    name = "" if body.name == which else f"{body.name}: "
    return f"{name}{body.label}, {mass}{support_words(body)}"


def support_words(body: BodyResult | SceneBody) -> str:
    """Return whether something holds a body, for those that could be held."""
    if body.label in ("rigid", "wall"):
        return ""
    return ", constrained" if body.constrained else ", free"


def _rebound(result: Result, name: str, unit: str = "") -> str:
    value = getattr(result, name)
    if not math.isnan(value):
        return f"{value:.5g}{unit}{result.error.told(name)}"
    return "none" if result.in_contact_at_end or not result.contacts else "not known"


def _gap(result: Result) -> str:
    return f", gap {quantity(result.gap, 'm')}" if result.gap else ""


def _force(result: Result) -> str:
    told = result.error.told
    within = told("peak_force") if result.error.mesh is None else _within(result, "peak_force")
    force = f"{quantity(result.peak_force, 'N', 5)}{within}"
    return f"{force} at {quantity(result.peak_time, 's')}{told('peak_time')}"


def _within(result: Result, name: str) -> str:
    """How wrong a number may be, and by what."""
    parts = result.error.parts(name)
    total = sum(part for part in parts.values() if part is not None)
    listed = ", ".join(
        f"{cause} {'not known' if part is None else _percent(part)}"
        for cause, part in parts.items()
    )
    return f" ± {100.0 * total:.2g} % ({listed})"


def _contact(result: Result) -> str:
    start = result.contacts[0][0]
    told = result.error.told
    text = f"{quantity(result.contact_duration, 's')}{told('contact_duration')}"
    text += f" from {quantity(start, 's')}"
    if len(result.contacts) > 1 or told("contacts"):
        text += f", the first of {len(result.contacts)}{told('contacts')}"
    if result.in_contact_at_end:
        text += " (the record ends in contact)"
    return text


def _error(result: Result) -> str:
    parts = [
        f"{name} {'not known' if value is None else f'{_percent(value)} %'}"
        for name, value in (
            ("mesh", result.error.mesh),
            ("contact", result.error.contact),
            ("reduction", result.error.reduction),
            ("time", result.error.time),
        )
        if value is not None or name in ("reduction", "time")
    ]
    if result.error.quantity is None:
        return ", ".join(parts)
    asked = f"{result.error.quantity} to {100.0 * (result.error.rtol or 0.0):.2g} %; error: "
    return asked.replace("_", " ") + ", ".join(parts)


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g}" if share >= _ROUNDING else "0"
