"""Random scenes from a seed: hard, but such as an engineer might ask for.

Masses, speeds and contact times are drawn over decades; stiffnesses follow from them, so that
contacts are neither rigid nor without effect. The fastest motion times the record is bounded,
since the oracle resolves every period.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .case import Body, Case, Contact, Frame, Law, Load

# Of the fastest frequency times the record: some 500 periods.
MOST_RADIANS = 3000.0

FAMILIES = {
    "pair": 0.16,
    "crowd": 0.42,
    "chain": 0.12,
    "pressed": 0.16,
    "ringing": 0.06,
    "rung": 0.08,
}


@dataclass(frozen=True)
class _Scales:
    """What a scene is made of: kg, m/s, s; depth and force follow."""

    mass: float
    speed: float
    time: float
    duration: float

    @property
    def depth(self) -> float:
        return self.speed * self.time / 3.0

    @property
    def force(self) -> float:
        return 2.0 * self.mass * self.speed / self.time


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def _decades(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def case_of(seed: int) -> Case:
    """Return the scene of a seed."""
    rng = np.random.default_rng(seed)
    time = _decades(rng, -5.0, -1.0)
    scales = _Scales(
        mass=_decades(rng, -3.0, 1.5),
        speed=_decades(rng, -1.5, 1.0),
        time=time,
        duration=_rounded(time * float(rng.choice([0.7, 1.5, 3.0, 6.0, 15.0], p=_HOW_LONG))),
    )
    family = str(rng.choice(list(FAMILIES), p=list(FAMILIES.values())))
    case = _MAKERS[family](rng, scales)
    tolerance = _rounded(_decades(rng, -9.0, -3.0))
    return replace(case, rtol=tolerance, family=family, duration=scales.duration)


_HOW_LONG = [0.15, 0.3, 0.3, 0.15, 0.1]


# ------------------------------------------------------------------- laws


def _law(rng: np.random.Generator, scales: _Scales) -> Law:
    """A law that has about the scene's force at its depth, give or take a decade, seldom more."""
    spread = 1.0 if rng.random() < 0.85 else 3.0
    k = _rounded(scales.force / scales.depth**1.5 * _decades(rng, -spread, spread))
    linear = _rounded(k * math.sqrt(scales.depth))
    kinds = ["Hertz", "PowerLaw", "Linear", "Thornton", "Tabulated", "UserLaw"]
    viscous = [*4 * ["HuntCrossley"], "Tsuji", "KuwabaraKono", *2 * ["KelvinVoigt"]]
    if rng.random() < 0.35:
        law = Law("Hertz", {"k": k})
        return _in_patch(rng, scales, law) if rng.random() < 0.25 else law
    kind = str(rng.choice(kinds if rng.random() < 0.5 else viscous))
    e, n = _rounded(rng.uniform(0.2, 0.95)), float(rng.choice([1.0, 1.5, 2.0, 2.5]))
    power = _rounded(k * scales.depth ** (1.5 - n))
    if kind == "Hertz":
        return Law(kind, {"k": k})
    if kind == "PowerLaw":
        return Law(kind, {"k": power, "n": n})
    if kind == "Linear":
        return Law(kind, {"k": linear})
    if kind == "Thornton":
        limit = _rounded(k * (scales.depth * _decades(rng, -2.0, 0.5)) ** 1.5)
        return Law(kind, {"k": k, "yield_force": limit})
    if kind == "Tabulated":
        depth = np.linspace(0.0, 1.0, int(rng.integers(5, 30))) ** 1.5 * 100.0 * scales.depth
        points = [_rounded(d) for d in depth[1:]]
        return Law(kind, {"indentation": points, "force": [_rounded(k * d**1.5) for d in points]})
    if kind == "UserLaw":
        damping = _rounded(rng.choice([0.0, 0.5]) / scales.speed)
        return Law(kind, {"k": power, "n": n, "c": damping})
    if kind == "HuntCrossley":
        return Law(kind, {"k": power, "damping": _rounded((1.0 - e) / scales.speed), "n": n})
    if kind == "Tsuji":
        return Law(kind, {"k": k, "alpha": _rounded(1.0 - e), "mass": _rounded(scales.mass)})
    if kind == "KuwabaraKono":
        return Law(kind, {"k": k, "A": _rounded((1.0 - e) * scales.time * 0.1)})
    c = _rounded((1.0 - e) * math.sqrt(linear * scales.mass))
    end = "force" if rng.random() < 0.6 else "indentation"
    return Law(kind, {"k": linear, "c": c, "end": end})


def _in_patch(rng: np.random.Generator, scales: _Scales, law: Law) -> Law:
    """Hertz's law with part of it taken out, up to an indentation that is seldom exceeded."""
    deepest = scales.depth * _decades(rng, 0.0, 2.0)
    return replace(law, removed=_rounded(0.95 / (1.5 * law.arguments["k"] * math.sqrt(deepest))))


# ------------------------------------------------------------------- bodies


def _star(
    rng: np.random.Generator, scales: _Scales, *, massless: float = 0.3, held: float = 0.4
) -> Body:
    """Contact mass, ground spring and oscillators over decades of mass and frequency."""
    top = math.log10(MOST_RADIANS / 3.0 * scales.time / scales.duration)
    count = int(rng.choice([1, 2, 3, 5, 8], p=[0.3, 0.25, 0.2, 0.15, 0.1]))
    mass = scales.mass * 10.0 ** rng.uniform(-2.0, 1.0, count)
    omega = 10.0 ** rng.uniform(-1.5, min(2.7, top), count) / scales.time
    if count > 1 and rng.random() < 0.3:
        omega[1] = omega[0]
    if rng.random() < massless:
        m0 = 0.0
    else:
        # Lighter ones ring faster on the oscillators' springs than the oracle follows.
        stiffness = float((mass * omega**2).sum())
        least = stiffness / (10.0**top / scales.time) ** 2
        m0 = _rounded(max(scales.mass * _decades(rng, -3.0, 0.5), least))
    k0 = 0.0
    if rng.random() < held:
        own = float(mass.sum()) + m0
        k0 = _rounded(own * (_decades(rng, -1.5, 0.7) / scales.time) ** 2)
        if m0 > 0.0:
            k0 = min(k0, _rounded(m0 * (10.0**top / scales.time) ** 2))
    masses = [_rounded(value) for value in mass]
    springs = [
        _rounded(m * w**2)
        if i != 1 or omega[1] != omega[0]
        else masses[1] * springs_of(masses[0], omega[0])
        for i, (m, w) in enumerate(zip(masses, omega, strict=True))
    ]
    return Body(m0, k0, tuple(masses), tuple(springs), _damping(rng, scales, top))


def springs_of(mass: float, omega: float) -> float:
    """k/m of the first oscillator as it is after rounding: for one of exactly its frequency."""
    return _rounded(mass * omega**2) / mass


def _damping(
    rng: np.random.Generator, scales: _Scales, top: float
) -> tuple[str, float] | tuple[str, float, float] | None:
    kind = rng.random()
    if kind < 0.6:
        return None
    if kind < 0.8:
        return ("ModalDamping", _rounded(_decades(rng, -3.0, -0.7)))
    alpha = _rounded(_decades(rng, -2.0, -0.5) / scales.time)
    beta = _rounded(_decades(rng, -3.0, 0.0) * scales.time / 10.0**top)
    return ("Rayleigh", alpha, beta)


def _frame(rng: np.random.Generator, scales: _Scales) -> Frame:
    """A row of masses, free or held, that is touched at any of them."""
    count = int(rng.integers(2, 5))
    top = MOST_RADIANS / 10.0 / scales.duration
    m = tuple(_rounded(v) for v in scales.mass * 10.0 ** rng.uniform(-1.5, 0.5, count))
    least = [min(m[i], m[i + 1]) for i in range(count - 1)]
    omega = np.minimum(10.0 ** rng.uniform(-0.5, 1.5, count - 1) / scales.time, top)
    k = tuple(_rounded(a * w**2) for a, w in zip(least, omega, strict=True))
    k0 = [0.0] * count
    if rng.random() < 0.5:
        at = int(rng.integers(count))
        k0[at] = _rounded(m[at] * min(_decades(rng, -1.0, 0.5) / scales.time, top) ** 2)
    return Frame(m, k, tuple(k0), damping=_damping(rng, scales, math.log10(top * scales.time)))


def _rigid(rng: np.random.Generator, scales: _Scales) -> Body:
    return Body(_rounded(scales.mass * _decades(rng, -1.0, 1.0)))


def _any_body(rng: np.random.Generator, scales: _Scales) -> Body:
    return _star(rng, scales) if rng.random() < 0.35 else _rigid(rng, scales)


WALL = Body(math.inf)


def _gap(rng: np.random.Generator, scales: _Scales) -> float:
    kind = rng.random()
    if kind < 0.35:
        return 0.0
    if kind < 0.55:
        return _rounded(scales.depth * _decades(rng, -3.0, -1.0))
    return _rounded(scales.depth * rng.uniform(0.05, 4.0))


def _speed(rng: np.random.Generator, scales: _Scales) -> float:
    return _rounded(scales.speed * rng.uniform(0.3, 1.5))


# ------------------------------------------------------------------- families


def _pair(rng: np.random.Generator, scales: _Scales) -> Case:
    first, second = _any_body(rng, scales), _any_body(rng, scales)
    if rng.random() < 0.5:
        second = _star(rng, scales)
    if rng.random() < 0.15:
        second = WALL
    bodies = (replace(first, velocity=_speed(rng, scales)), second)
    case = Case(bodies, (Contact(0, 1, _law(rng, scales), _gap(rng, scales)),))
    return _loaded(rng, scales, case, chance=0.3)


def _crowd(rng: np.random.Generator, scales: _Scales) -> Case:
    """One body among two to eight others, on either side of it."""
    kind = rng.random()
    centre: Body | Frame = _star(rng, scales, massless=0.45)
    if kind < 0.15:
        centre = _rigid(rng, scales)
    elif kind < 0.35:
        centre = _frame(rng, scales)
    centre = replace(centre, velocity=0.0 if rng.random() < 0.8 else _speed(rng, scales))
    bodies: list[Body | Frame] = [centre]
    contacts: list[Contact] = []
    law = _law(rng, scales)
    for number in range(int(rng.choice([2, 3, 4, 8], p=[0.55, 0.25, 0.15, 0.05]))):
        law = law if rng.random() < 0.3 else _law(rng, scales)
        behind = rng.random() < 0.6 or number == 0
        kind = rng.random()
        if kind < 0.2 and number > 0:
            other = WALL
        elif kind < 0.35:
            other = _star(rng, scales)
        else:
            other = _rigid(rng, scales)
        moving = number == 0 or rng.random() < 0.75
        if not other.wall and moving:
            other = replace(other, velocity=_speed(rng, scales) * (1.0 if behind else -1.0))
        bodies.append(other)
        port, last = int(rng.integers(centre.ports)), len(bodies) - 1
        gap = _gap(rng, scales)
        if behind:
            contacts.append(Contact(last, 0, law, gap, (0, port)))
        else:
            contacts.append(Contact(0, last, law, gap, (port, 0)))
    return _loaded(rng, scales, Case(tuple(bodies), tuple(contacts)), chance=0.25)


def _chain(rng: np.random.Generator, scales: _Scales) -> Case:
    count = int(rng.integers(3, 7))
    bodies = [_any_body(rng, scales) for _ in range(count)]
    bodies[0] = replace(bodies[0], velocity=_speed(rng, scales))
    if rng.random() < 0.4:
        bodies[-1] = WALL
    contacts = tuple(
        Contact(i, i + 1, _law(rng, scales), _gap(rng, scales)) for i in range(count - 1)
    )
    return _loaded(rng, scales, Case(tuple(bodies), contacts), chance=0.25)


def _pressed(rng: np.random.Generator, scales: _Scales) -> Case:
    """Bodies in a row on something that holds them, at rest under load; then that is let go, or
    more is put on, or something strikes.
    """
    count = int(rng.integers(1, 4))
    row = [
        _star(rng, scales, held=0.0) if rng.random() < 0.4 else _rigid(rng, scales)
        for _ in range(count)
    ]
    base = WALL if rng.random() < 0.5 else _star(rng, scales, held=1.0)
    if base.k0 == 0.0 and not base.wall:
        base = WALL
    bodies = [*row, base]
    contacts = [Contact(i, i + 1, _law(rng, scales)) for i in range(count)]
    preload = rng.random() < 0.75
    gravity, loads = 0.0, []
    if rng.random() < 0.4:
        gravity = _rounded(scales.force / scales.mass * _decades(rng, -2.0, 0.0))
    if gravity == 0.0 or rng.random() < 0.6:
        loads.append(Load(0, *_pressing(rng, scales)))
    if rng.random() < 0.3:
        others = [i for i, body in enumerate(bodies) if not body.wall and i > 0]
        if others:
            loads.append(Load(int(rng.choice(others)), *_ramp(rng, scales)))
    if rng.random() < 0.1:
        striker = replace(_rigid(rng, scales), velocity=_speed(rng, scales))
        if gravity == 0.0:
            bodies.append(striker)
            contacts.append(
                Contact(
                    len(bodies) - 1,
                    0,
                    _law(rng, scales),
                    _rounded(scales.depth * rng.uniform(0.1, 3.0)),
                )
            )
    return Case(tuple(bodies), tuple(contacts), tuple(loads), gravity, preload=preload)


def _ringing(rng: np.random.Generator, scales: _Scales) -> Case:
    """Light ends that ring, one beside a wall, while the heavy middle is in a long contact.

    Something small and hard has struck them, from opposite sides: so the middle stays at rest in
    what they do, and the contact there does not feel it. The wall is about as far as they swing.
    """
    heavy, light = _rounded(scales.mass), _rounded(scales.mass * _decades(rng, -3.0, -0.5))
    swings = 2.0 * math.pi / scales.time * _decades(rng, 0.7, 2.7)
    omega = min(swings, 0.8 * MOST_RADIANS / scales.duration)
    stiffness = _rounded(light * omega**2)
    frame = Frame((light, heavy, light), (stiffness, stiffness), (0.0, 0.0, 0.0))
    soft = Law("Hertz", {"k": _rounded(scales.force / scales.depth**1.5)})
    tap = _rounded(light * rng.uniform(0.1, 1.0))
    quick = scales.speed * _decades(rng, -1.0, 0.5)
    # A contact of the tap as long as a part of a period of what it makes ring.
    short = rng.uniform(0.1, 1.0) / omega
    hard = _rounded(tap * quick / short / (quick * short) ** 1.5)
    swing = 2.0 * tap / (tap + light) * quick / omega
    wall = Law("Hertz", {"k": _rounded(hard * _decades(rng, -3.0, 0.5))})
    drift = scales.speed * scales.time * _decades(rng, -2.0, 0.0)
    bodies = (
        frame,
        Body(_rounded(scales.mass * _decades(rng, -1.0, 1.0)), velocity=_rounded(scales.speed)),
        Body(tap, velocity=_rounded(quick)),
        Body(tap, velocity=-_rounded(quick)),
        WALL,
    )
    struck = Law("Hertz", {"k": hard})
    contacts = (
        Contact(1, 0, soft, 0.0, (0, 1)),
        Contact(2, 0, struck, 0.0, (0, 0)),
        Contact(0, 3, struck, 0.0, (2, 0)),
        Contact(0, 4, wall, _rounded(swing * rng.uniform(0.7, 1.1) + drift), (0, 0)),
    )
    return Case(bodies, contacts)


def _rung(rng: np.random.Generator, scales: _Scales) -> Case:
    """A body that rings, by any share of the depth, in the long contact at the very place.

    A load has let go of it at once, or something small and hard strikes it, before the contact or
    in it.
    """
    m0 = _rounded(scales.mass * _decades(rng, -2.0, 0.5))
    m = _rounded(scales.mass * _decades(rng, 0.0, 1.0))
    swings = 2.0 * math.pi / scales.time * _decades(rng, 1.0, 3.5)
    omega = min(swings, MOST_RADIANS / scales.duration)
    k = _rounded(omega**2 * m0 * m / (m0 + m))
    damping = ("ModalDamping", _rounded(_decades(rng, -4.0, -1.0))) if rng.random() < 0.4 else None
    star = Body(m0, 0.0, (m,), (k,), damping)
    amplitude = scales.depth * _decades(rng, -7.0, -0.5)
    ball = replace(_rigid(rng, scales), velocity=_speed(rng, scales))
    gap = _rounded(ball.velocity * rng.uniform(1.0, 20.0) / omega)
    long = Contact(1, 0, _law(rng, scales), gap)
    if rng.random() < 0.5:
        force, end = _rounded(amplitude * m0 * omega**2), 1.0 / omega
        pulse = Load(0, (0.0, _rounded(end), _rounded(1.01 * end)), (force, force, 0.0))
        return Case((star, ball), (long,), (pulse,))
    tap = _rounded(m0 * _decades(rng, -2.0, -0.3))
    later = rng.random() < 0.4
    # A slower one would meet what the tolerance leaves of the long contact's velocities.
    least = 0.1 * scales.speed if later else 0.0
    speed = _rounded(max(amplitude * omega * (m0 + tap) / (2.0 * tap), least))
    short = rng.uniform(0.1, 1.0) / omega
    hard = Law("Hertz", {"k": _rounded(tap * speed / short / (speed * short) ** 1.5)})
    wait = _rounded(speed * scales.time * rng.uniform(0.0, 1.0)) if later else 0.0
    bodies = (star, ball, Body(tap, velocity=speed))
    return Case(bodies, (long, Contact(2, 0, hard, wait)))


Function = tuple[tuple[float, ...], tuple[float, ...]]


def _pressing(rng: np.random.Generator, scales: _Scales) -> Function:
    """A load that presses at the start: constant, released, or rising further."""
    force = _rounded(scales.force * _decades(rng, -1.5, 0.3))
    kind = rng.random()
    if kind < 0.3:
        return (0.0,), (force,)
    start = _rounded(scales.duration * rng.choice([0.0, 0.1]))
    end = _rounded(start + scales.time * _decades(rng, -1.5, 0.5))
    last = 0.0 if kind < 0.8 else _rounded(force * rng.uniform(-0.5, 2.0))
    return (start, end), (force, last)


def _ramp(rng: np.random.Generator, scales: _Scales) -> Function:
    """A load from nothing, that pulls or pushes, at times all but suddenly, and perhaps ends."""
    force = _rounded(scales.force * _decades(rng, -2.0, 0.0) * rng.choice([-1.0, 1.0]))
    rise = _rounded(scales.duration * rng.uniform(0.1, 0.9))
    begin, end = 0.0, rise
    steep = rng.spawn(1)[0]  # which leaves all that is drawn from rng as it is
    if steep.random() < 0.3:
        begin = _rounded(rise * steep.uniform(0.1, 0.9))
        end = begin + scales.duration * _decades(steep, -10.0, -2.0)
    if rng.random() < 0.5:
        return (begin, end), (0.0, force)
    return (begin, end, _rounded(1.5 * rise)), (0.0, force, 0.0)


def _loaded(rng: np.random.Generator, scales: _Scales, case: Case, *, chance: float) -> Case:
    """The scene, perhaps under gravity and a load."""
    loads: tuple[Load, ...] = ()
    free = [i for i, body in enumerate(case.bodies) if not body.wall]
    if rng.random() < chance:
        body = int(rng.choice(free))
        force = _rounded(scales.force * _decades(rng, -2.0, -0.3) * rng.choice([-1.0, 1.0]))
        steady = rng.random() < 0.3 and not case.bodies[body].massless
        port = int(rng.integers(case.bodies[body].ports))
        when, what = ((0.0,), (force,)) if steady else _ramp(rng, scales)
        loads = (Load(body, when, what, port),)
    gravity = 0.0
    weightless = any(b.held and isinstance(b, Body) and not b.wall for b in case.bodies)
    if rng.random() < 0.2 and not weightless:
        gravity = _rounded(scales.force / scales.mass * _decades(rng, -3.0, -0.5))
    return replace(case, loads=loads, gravity=gravity)


_MAKERS: dict[str, Callable[[np.random.Generator, _Scales], Case]] = {
    "pair": _pair,
    "crowd": _crowd,
    "chain": _chain,
    "pressed": _pressed,
    "ringing": _ringing,
    "rung": _rung,
}
