"""The summary that a result prints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..base import PRINTED, ROUNDING, plain, with_unit
from ..contact import ContactPoint
from .errors import ErrorParts, percent
from .quantities import QUANTITIES, Quantity
from .table import ROLES

if TYPE_CHECKING:
    from .run import ContactResult, Result, Run


_RIGID = "rigid", "wall"

# Largest number of bodies, contacts and slip intervals that a summary lists.
SHOWN = 12

# Largest number of contact points that are listed for a body.
_PLACES = 2


def impact_rows(result: Result) -> list[tuple[str, str]]:
    """Return the rows of an impact's summary: (name, value with unit)."""
    oblique, contact = result.plan.oblique, result.plan.contacts[0]
    velocity, along = f"{result.velocity:.6g} m/s", ""
    if oblique is not None:
        along = f" along {plain(oblique.axes[0])}"
        way, spin = np.split(oblique.velocities[0], 2)
        velocity = f"{plain(way)} m/s" + (f", spin {plain(spin)} rad/s" if spin.any() else "")
    gap = f", gap {with_unit(result.gap, 'm')}" if result.gap else ""
    rows = [
        ("projectile", _body(result, 0)),
        ("target", _body(result, 1)),
        ("law", str(contact.law)),
        ("velocity", velocity + gap),
    ]
    if oblique is not None:
        known = "none: smooth surfaces"
        if of := contact.friction:
            known = f"coefficient {of.mu:g}, tangential over normal stiffness {of.ratio:.3g}"
        rows.append(("friction", known))
    if not result.contacts:
        rows.append(("contact", f"none in {with_unit(result.duration, 's')}"))
    else:
        count, start = len(result.contacts), with_unit(result.contacts[0][0], "s")
        sure = _is_certain(result.error["contact_count"], count)
        several = f", the first of {count}{'' if sure else ' (uncertain)'}"
        cut = " (the record ends in contact)" if result.in_contact_at_end else ""
        duration = _told(result, "contact_duration")
        rows += [
            ("peak force", _peak(result, "")),
            ("contact", f"{duration} from {start}{several if count > 1 or not sure else ''}{cut}"),
            ("impulse", _told(result, "impulse")),
        ]
    rows += [
        ("rebound velocity", _rebound(result, "rebound_velocity", along)),
        ("restitution", _rebound(result, "restitution")),
    ]
    if "tangential_restitution" in result.numbers:
        rows.append(("tangential restit.", _rebound(result, "tangential_restitution")))
    if oblique is not None:
        moving, error = result.projectile, _within(result, "final_spin", math.inf)
        friction = _told(result, "peak_friction_force", 5) + _slips(result.each_contact[0])
        rows += [
            ("final velocity", f"{plain(moving.final_velocity)} m/s"),
            ("final spin", f"{plain(moving.final_spin)} rad/s{error}"),
            ("peak friction", friction),
        ]
    if (dent := result.dent).depth > 0.0:
        wide = "" if math.isnan(dent.diameter) else f", {with_unit(dent.diameter, 'm', 3)} wide"
        rows.append(("residual dent", f"{with_unit(dent.depth, 'm', 3)} deep{wide}"))
    rows += [(of.name, str(of)) for of in result.advice]
    rows += [*error_rows(result), ("solver", result.solver)]
    made_by = [model.linear_solver for model in result.models]
    if any(made_by):
        rows.append(("linear solver", ", ".join(dict.fromkeys(filter(None, made_by)))))
    rows.append(("cost", str(result.cost)))
    return rows


def scene_rows(run: Run) -> list[tuple[str, str]]:
    """Return the rows of a scene's summary: (name, values with units)."""
    bodies, contacts, oblique = len(run.names), len(run.events), run.plan.oblique
    rows = [(name, _body(run, i)) for i, name in enumerate(run.names[:SHOWN])]
    if oblique is not None:
        rows += [
            (f"{of.name}, after", f"{plain(of.final_velocity)} m/s, {plain(of.final_spin)} rad/s")
            for of in run.bodies[:SHOWN]
            if not of.constrained
        ]
    for i, contact in enumerate(run.each_contact[:SHOWN]):
        count, owner = contact.contact_count, f"contacts.{i}."
        text = _peak(run, owner)
        times = f"{count} contact{'s' if count > 1 else ''}"
        if not _is_certain(run.error[f"{owner}contact_count"], count):
            times += " (the count is uncertain)"
        if oblique is not None:
            text += f", friction {_told(run, f'{owner}peak_friction_force', 5)}"
            times += _slips(contact)
        dent = contact.dent.depth
        times += f", dent of {with_unit(dent, 'm', 3)}" if dent > 0.0 else ""
        rows.append((contact.name, f"{text}, {times}" if count else "none"))
    if max(bodies, contacts) > SHOWN:
        rows.append(("…", f"{bodies} bodies and {contacts} contacts in all"))
    if run.chosen is not None:
        rows += error_rows(run)
    return [*rows, ("solver", run.solver), ("cost", str(run.cost))]


def summary_text(head: str, rows: Sequence[tuple[str, str]], width: int) -> str:
    """Return a summary as lines of text, with names in a column of at least `width` characters."""
    width = max(width, *(len(name) for name, _ in rows))
    return "\n".join([head, *(f"  {name:<{width}} {value}" for name, value in rows)])


def _told(run: Run, name: str, digits: int = 4, *, listed: bool = False, along: str = "") -> str:
    """Return text with a number of a run, its unit and its error."""
    value = run.numbers[name]
    number = _number(QUANTITIES[name.rpartition(".")[2]], value, digits)
    return f"{number}{along}{_within(run, name, value, listed=listed)}"


def _within(run: Run, name: str, value: float, *, listed: bool = False) -> str:
    """Return text with a number's error, with its parts if `listed`; empty where none is known.

    The text is also empty if only the error of time integration is known, as for bodies given by
    numbers.
    """
    error = run.error[name]
    if error.mesh is error.contact is error.model is None or not error.least >= PRINTED:
        return ""
    if math.isinf(error.least):
        return " (error not bounded: refine the mesh at the contact, or give radius=)"
    return _bound(run, QUANTITIES[name.rpartition(".")[2]], value, error, listed=listed)


def _bound(
    run: Run, interest: Quantity, value: float, error: ErrorParts, *, listed: bool = False
) -> str:
    """Return an error as text; absolute if the number is below `interest.least`."""
    least = 0.0 if interest.least is None else interest.least(run.velocities_before)
    if math.isinf(error.least):
        return " not bounded"
    if not abs(value) < least or error.least < PRINTED:
        return f" ± {error if listed else error.bound()}"
    at_least = "at least " if error.unknown else ""
    return f" ± {at_least}{error.least * least:.2g} {interest.unit}".rstrip()


def _is_certain(error: ErrorParts, count: int) -> bool:
    """True if the error of a count is less than one half."""
    return error.least * count < 0.5


def _peak(run: Run, owner: str) -> str:
    """Return text with the largest force of a contact, and its time."""
    force = _told(run, f"{owner}peak_force", 5, listed=True)
    return f"{force} at {_told(run, f'{owner}peak_time')}"


def _slips(contact: ContactResult) -> str:
    """Return text with the intervals of full slip of a contact."""
    if not contact.intervals or not (slips := contact.slip_intervals):
        return ""
    if not contact.stick_intervals:
        return ", slips all along"
    shown = [f"{with_unit(a, 's', 3)} to {with_unit(b, 's', 3)}" for a, b in slips[:SHOWN]]
    return f", slips from {' and '.join(shown)}{' …' if len(slips) > SHOWN else ''}"


def _body(run: Run, number: int) -> str:
    """Return text with a body's model, support and contact points; in an impact also its mass."""
    body, scene = run.plan.bodies[number], run.plan.scene
    rigid, name, mass = body.label in _RIGID, run.names[number], ""
    tips = body.tips[:: 3 if run.plan.oblique else 1][: _PLACES if scene else 1]
    if not scene and body.known_mass != math.inf:
        known = "not known" if body.known_mass is None else with_unit(body.known_mass, "kg")
        mass = f", {'mass ' if body.known_mass is None else ''}{known}"
    called = "" if scene or name == ROLES[number] else f"{name}: "
    held = "" if rigid else ", constrained" if body.constrained else ", free"
    places = "".join(_place(tip, rigid=rigid) for tip in tips)
    return f"{called}{body.label}{mass}{held}{places}"


def _place(tip: ContactPoint, *, rigid: bool) -> str:
    """Return text with a contact point's node or patch, position and direction."""
    if tip.point is None or tip.direction is None:
        return ""
    what = "point" if tip.node is None else f"node {tip.node_label}"
    if tip.patch is not None:
        what = f"patch of {with_unit(tip.patch.radius, 'm', 3)}"
    what = "touched" if rigid else what
    point, along = (
        ", ".join(f"{x:.4g}" for x in np.where(np.abs(of) < ROUNDING, 0.0, of))
        for of in (tip.point, tip.direction)
    )
    return f", {what} at ({point}) m along ({along})"


def _rebound(result: Result, name: str, along: str = "") -> str:
    if math.isnan(result.value(name)):
        return "none" if result.in_contact_at_end or not result.contacts else "not known"
    return _told(result, name, 5, along=along)


def error_rows(run: Run) -> list[tuple[str, str]]:
    """Return the rows of errors: each quantity of interest with its value, error and tolerance.

    The error of a history is its largest error over time, relative to the history's largest value.
    """
    chosen = run.chosen
    rows = []
    for name in ["force"] if chosen is None else chosen.quantities:
        parts = run.error[name]
        if parts.model is None and not run.plan.meshed:
            return [("error of the peak", f"time {percent(parts.time)} %")]
        text = f"{_interest(run, name, parts)} ({parts.listed()})"
        if chosen is not None:
            aim = f"{100.0 * chosen.rtol:.2g} %"
            missed = (parts.model or 0.0) > chosen.rtol
            text += (
                f"; no models tried meet {aim}"
                if missed
                else f"; models and steps chosen for {aim}"
            )
        rows.append(("error", text))
    return rows


def _interest(run: Run, name: str, parts: ErrorParts) -> str:
    """Return text with a quantity of interest, its value and its total error."""
    words, interest = name.replace("_", " "), QUANTITIES.get(name)
    if interest is None or interest.is_history:
        bound = _bound(run, QUANTITIES["force"], math.inf, parts)
        at, when = "", run.error.worst_time
        first = name == (run.error.quantity or "force") and len(run.events) == 1
        if first and when is not None and len(run.events[0].contacts) > 1:
            at = f" (most at {with_unit(when, 's', 3)})"
        unit, most = run.chosen.quantities[name] if run.chosen else ("", math.nan)
        largest = "" if math.isnan(most) else f", {with_unit(most, unit, 5)}"
        scale = f" of its largest value{largest}" if "±" in bound else ""
        return f"{words} at any time{at}{bound}{scale}"
    values = [run.numbers[of] for of in interest.names(run)]
    alone = len(values) == 1
    bound = _bound(run, interest, values[0] if alone else math.inf, parts)
    if interest.count:  # a relative error of a count has no meaning
        certain = all(_is_certain(parts, int(value)) for value in values)
        bound = f", {'certain' if certain else 'uncertain'}"
    called = run.contact_names if interest.each == "contacts" else run.names
    each = [
        _number(interest, value) + ("" if alone else f" of {of}")
        for of, value in zip(called, values, strict=False)
        if alone or not math.isnan(value)
    ]
    return f"{words} {', '.join(each[:SHOWN] + ['…'] * (len(each) > SHOWN))}{bound}"


def _number(interest: Quantity, value: float, digits: int = 5) -> str:
    """Return a number with its unit; velocities get no prefix, so that they are easy to compare."""
    if math.isnan(value):
        return "none"
    if interest.count or not interest.unit or "/" in interest.unit:
        return f"{value:.{digits}g} {interest.unit}".rstrip()
    return with_unit(value, interest.unit, digits)
