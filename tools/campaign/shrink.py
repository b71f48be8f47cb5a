"""A smaller scene that still fails: parts are left out, laws made plain and numbers round,
greedily.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Iterator
from dataclasses import replace

from .case import Body, Case, Contact, Frame, Law

# Share of its record that is left of a scene.
_LEAST_DURATION = 0.05


def shrink(case: Case, fails: Callable[[Case], bool], *, longest: float = 120.0) -> Case:
    """Return the smallest scene found that fails.

    Parameters
    ----------
    case : Case
        It fails.
    fails : callable
        Whether a scene does, in the same way.
    longest : float
        s to look for.
    """
    end, least = clock.monotonic() + longest, _LEAST_DURATION * case.duration
    changed = True
    while changed:
        changed = False
        for smaller in _smaller(case):
            if clock.monotonic() > end:
                return case
            if smaller != case and smaller.duration >= least and fails(smaller):
                case, changed = smaller, True
                break
    return case


def _smaller(case: Case) -> Iterator[Case]:
    yield from _without_contacts(case)
    yield from _without_bodies(case)
    for i in range(len(case.loads)):
        yield replace(case, loads=case.loads[:i] + case.loads[i + 1 :])
    if case.gravity:
        yield replace(case, gravity=0.0)
    if case.preload:
        yield replace(case, preload=False)
    for i, body in enumerate(case.bodies):
        if isinstance(body, Frame):
            if body.damping:
                yield replace(case, bodies=_put(case.bodies, i, replace(body, damping=None)))
            continue
        for plainer in _plainer(body):
            yield replace(case, bodies=_put(case.bodies, i, plainer))
    for i, contact in enumerate(case.contacts):
        for simpler in _simpler(contact):
            yield replace(case, contacts=_put(case.contacts, i, simpler))
    yield replace(case, duration=_short(0.6 * case.duration, 2))
    yield from _rounder(case)


def _put(parts: tuple, i: int, part: object) -> tuple:
    return (*parts[:i], part, *parts[i + 1 :])


def _without_contacts(case: Case) -> Iterator[Case]:
    for i in range(len(case.contacts)):
        if len(case.contacts) > 1:
            yield replace(case, contacts=case.contacts[:i] + case.contacts[i + 1 :])


def _without_bodies(case: Case) -> Iterator[Case]:
    for i in range(len(case.bodies)):
        if case.contacts_of(i):
            continue
        new = [j - (j > i) for j in range(len(case.bodies))]
        yield replace(
            case,
            bodies=case.bodies[:i] + case.bodies[i + 1 :],
            contacts=tuple(replace(c, a=new[c.a], b=new[c.b]) for c in case.contacts),
            loads=tuple(replace(o, body=new[o.body]) for o in case.loads if o.body != i),
        )


def _plainer(body: Body) -> Iterator[Body]:
    if body.wall:
        return
    if body.m and (body.m0 or body.k0 or len(body.m) > 1):
        for j in range(len(body.m)):
            m, k = body.m[:j] + body.m[j + 1 :], body.k[:j] + body.k[j + 1 :]
            if m or body.m0:
                yield replace(body, m=m, k=k, damping=body.damping if m else None)
    if body.damping:
        yield replace(body, damping=None)
    if body.k0 and (body.m or body.m0):
        yield replace(body, k0=0.0)
    if not body.velocity and not body.massless:
        yield Body(math.inf)


def _simpler(contact: Contact) -> Iterator[Contact]:
    given = contact.law.arguments
    k = given.get("k")
    if contact.law.kind == "Tabulated":
        d, f = given["indentation"], given["force"]
        k = f[len(f) // 2] / d[len(d) // 2] ** 1.5
    if contact.law.kind not in ("Hertz", "Linear"):
        if contact.law.kind in ("KelvinVoigt",) or given.get("n") == 1.0:
            yield replace(contact, law=Law("Linear", {"k": k}))
            if contact.law.kind == "KelvinVoigt" and given["end"] != "force":
                yield replace(contact, law=Law("KelvinVoigt", {**given, "end": "force"}))
        else:
            yield replace(contact, law=Law("Hertz", {"k": k}))
            if given.get("n", 1.5) != 1.5 and contact.law.kind != "PowerLaw":
                yield replace(contact, law=Law(contact.law.kind, {**given, "n": 1.5}))
    if contact.law.removed:
        yield replace(contact, law=replace(contact.law, removed=None))
    if contact.gap:
        yield replace(contact, gap=0.0)


def _short(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _rounder(case: Case) -> Iterator[Case]:
    for digits in (1, 2):
        for i, body in enumerate(case.bodies):
            if isinstance(body, Frame):
                continue
            new = replace(
                body,
                m0=_short(body.m0, digits),
                k0=_short(body.k0, digits),
                m=tuple(_short(m, digits) for m in body.m),
                k=tuple(_short(k, digits) for k in body.k),
                velocity=_short(body.velocity, digits),
            )
            if body.damping:
                numbers = [_short(v, digits) for v in body.damping[1:]]
                new = replace(new, damping=(body.damping[0], *numbers))
            yield replace(case, bodies=_put(case.bodies, i, new))
        for i, contact in enumerate(case.contacts):
            given = {
                name: _short(v, digits) if isinstance(v, float) else v
                for name, v in contact.law.arguments.items()
            }
            law = replace(contact.law, arguments=given)
            yield replace(
                case,
                contacts=_put(
                    case.contacts, i, replace(contact, law=law, gap=_short(contact.gap, digits))
                ),
            )
        for i, load in enumerate(case.loads):
            new_load = replace(
                load,
                times=tuple(_short(t, digits) for t in load.times),
                forces=tuple(_short(f, digits) for f in load.forces),
            )
            if len(set(new_load.times)) == len(load.times):
                yield replace(case, loads=_put(case.loads, i, new_load))
        yield replace(case, duration=_short(case.duration, digits), rtol=_short(case.rtol, 1))
        yield replace(case, gravity=_short(case.gravity, digits))
