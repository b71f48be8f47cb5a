"""Random scenes from a seed: difficult, but ones that an engineer might ask for.

Masses, speeds and contact times are drawn over decades; stiffnesses follow from them, so that
contacts are neither rigid nor without effect. The number of periods of the fastest motion in the
record is bounded, since the oracle resolves every period.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from .case import Body, Case, Contact, Frame, Law, Load

# Maximum angular frequency times the record, rad: some 500 periods.
MOST_RADIANS = 3000.0

FAMILIES = {
    "pair": 0.16,
    "crowd": 0.42,
    "chain": 0.12,
    "pressed": 0.16,
    "ringing": 0.06,
    "rung": 0.08,
}


_HOW_LONG = [0.7, 1.5, 3.0, 6.0, 15.0], None, True, [0.15, 0.3, 0.3, 0.15, 0.1]

Function = tuple[tuple[float, ...], tuple[float, ...]]
WALL = Body(math.inf)


def springs_of(mass: float, omega: float) -> float:
    """Return k/m of an oscillator after rounding, so that another can have the same frequency."""
    return _rounded(mass * omega**2) / mass


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


class _Drawn:
    """Random quantities of a scene: mass, kg, speed, m/s, time, s; depth and force follow."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.between = self.rng.uniform
        self.time = self.decades(-5.0, -1.0)
        self.mass, self.speed = self.decades(-3.0, 1.5), self.decades(-1.5, 1.0)
        self.duration = _rounded(self.time * float(self.rng.choice(*_HOW_LONG)))
        self.depth = self.speed * self.time / 3.0
        self.force = 2.0 * self.mass * self.speed / self.time

    def decades(self, low: float, high: float) -> float:
        return float(10.0 ** self.between(low, high))

    def some(self, value: float, low: float, high: float) -> float:
        """Return the value times a random power of ten with an exponent from `low` to `high`."""
        return _rounded(value * self.decades(low, high))

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def sign(self) -> float:
        return float(self.rng.choice([-1.0, 1.0]))

    def case(self) -> Case:
        family = str(self.rng.choice(list(FAMILIES), p=list(FAMILIES.values())))
        case: Case = getattr(self, f"_{family}")()
        tolerance = _rounded(self.decades(-9.0, -3.0))
        return replace(case, rtol=tolerance, family=family, duration=self.duration)

    def _law(self) -> Law:
        """Return a law of about the scene's force at its depth, within one decade or three."""
        spread = 1.0 if self.chance(0.85) else 3.0
        k = self.some(self.force / self.depth**1.5, -spread, spread)
        linear = _rounded(k * math.sqrt(self.depth))
        kinds = ["Hertz", "PowerLaw", "Linear", "Thornton", "Tabulated", "UserLaw"]
        viscous = [*4 * ["HuntCrossley"], "Tsuji", "KuwabaraKono", *2 * ["KelvinVoigt"]]
        if self.chance(0.35):
            law = Law("Hertz", {"k": k})
            return self._in_patch(law) if self.chance(0.25) else law
        kind = str(self.rng.choice(kinds if self.chance(0.5) else viscous))
        e, n = _rounded(self.between(0.2, 0.95)), float(self.rng.choice([1.0, 1.5, 2.0, 2.5]))
        power = _rounded(k * self.depth ** (1.5 - n))
        plain: dict[str, dict[str, Any]] = {
            "Hertz": {"k": k},
            "PowerLaw": {"k": power, "n": n},
            "Linear": {"k": linear},
            "HuntCrossley": {"k": power, "damping": _rounded((1.0 - e) / self.speed), "n": n},
            "Tsuji": {"k": k, "alpha": _rounded(1.0 - e), "mass": _rounded(self.mass)},
            "KuwabaraKono": {"k": k, "A": _rounded((1.0 - e) * self.time * 0.1)},
        }
        if kind in plain:
            return Law(kind, plain[kind])
        if kind == "Thornton":
            limit = _rounded(k * (self.depth * self.decades(-2.0, 0.5)) ** 1.5)
            return Law(kind, {"k": k, "yield_force": limit})
        if kind == "Tabulated":
            depth = np.linspace(0.0, 1.0, int(self.rng.integers(5, 30))) ** 1.5 * 100.0 * self.depth
            points = [_rounded(d) for d in depth[1:]]
            return Law(
                kind, {"indentation": points, "force": [_rounded(k * d**1.5) for d in points]}
            )
        if kind == "UserLaw":
            damping = _rounded(self.rng.choice([0.0, 0.5]) / self.speed)
            return Law(kind, {"k": power, "n": n, "c": damping})
        c = _rounded((1.0 - e) * math.sqrt(linear * self.mass))
        end = "force" if self.chance(0.6) else "indentation"
        return Law(kind, {"k": linear, "c": c, "end": end})

    def _in_patch(self, law: Law) -> Law:
        """Return Hertz's law with a compliance removed; its limit is seldom exceeded."""
        deepest = self.depth * self.decades(0.0, 2.0)
        return replace(
            law, removed=_rounded(0.95 / (1.5 * law.arguments["k"] * math.sqrt(deepest)))
        )

    def _star(self, *, massless: float = 0.3, held: float = 0.4) -> Body:
        """Return an AO model with oscillators over decades of mass and frequency."""
        top = math.log10(MOST_RADIANS / 3.0 * self.time / self.duration)
        count = int(self.rng.choice([1, 2, 3, 5, 8], p=[0.3, 0.25, 0.2, 0.15, 0.1]))
        mass = self.mass * 10.0 ** self.between(-2.0, 1.0, count)
        omega = 10.0 ** self.between(-1.5, min(2.7, top), count) / self.time
        if count > 1 and self.chance(0.3):
            omega[1] = omega[0]
        if self.rng.random() < massless:
            m0 = 0.0
        else:
            # A lighter m0 vibrates too fast on the oscillators' springs for the oracle.
            stiffness = float((mass * omega**2).sum())
            least = stiffness / (10.0**top / self.time) ** 2
            m0 = _rounded(max(self.mass * self.decades(-3.0, 0.5), least))
        k0 = 0.0
        if self.rng.random() < held:
            own = float(mass.sum()) + m0
            k0 = _rounded(own * (self.decades(-1.5, 0.7) / self.time) ** 2)
            if m0 > 0.0:
                k0 = min(k0, _rounded(m0 * (10.0**top / self.time) ** 2))
        masses = [_rounded(value) for value in mass]
        springs = [
            _rounded(m * w**2)
            if i != 1 or omega[1] != omega[0]
            else masses[1] * springs_of(masses[0], omega[0])
            for i, (m, w) in enumerate(zip(masses, omega, strict=True))
        ]
        return Body(m0, k0, tuple(masses), tuple(springs), self._damping(top))

    def _damping(self, top: float) -> tuple[str, float] | tuple[str, float, float] | None:
        kind = self.rng.random()
        if kind < 0.6:
            return None
        if kind < 0.8:
            return ("ModalDamping", _rounded(self.decades(-3.0, -0.7)))
        alpha = _rounded(self.decades(-2.0, -0.5) / self.time)
        beta = _rounded(self.decades(-3.0, 0.0) * self.time / 10.0**top)
        return ("Rayleigh", alpha, beta)

    def _frame(self) -> Frame:
        """Return a row of masses, free or held, that can be touched at any mass."""
        count = int(self.rng.integers(2, 5))
        top = MOST_RADIANS / 10.0 / self.duration
        m = tuple(_rounded(v) for v in self.mass * 10.0 ** self.between(-1.5, 0.5, count))
        least = [min(m[i], m[i + 1]) for i in range(count - 1)]
        omega = np.minimum(10.0 ** self.between(-0.5, 1.5, count - 1) / self.time, top)
        k = tuple(_rounded(a * w**2) for a, w in zip(least, omega, strict=True))
        k0 = [0.0] * count
        if self.chance(0.5):
            at = int(self.rng.integers(count))
            k0[at] = _rounded(m[at] * min(self.decades(-1.0, 0.5) / self.time, top) ** 2)
        return Frame(m, k, tuple(k0), damping=self._damping(math.log10(top * self.time)))

    def _rigid(self) -> Body:
        return Body(self.some(self.mass, -1.0, 1.0))

    def _any_body(self) -> Body:
        return self._star() if self.chance(0.35) else self._rigid()

    def _gap(self) -> float:
        kind = self.rng.random()
        if kind < 0.35:
            return 0.0
        if kind < 0.55:
            return self.some(self.depth, -3.0, -1.0)
        return _rounded(self.depth * self.between(0.05, 4.0))

    def _speed(self) -> float:
        return _rounded(self.speed * self.between(0.3, 1.5))

    def _pair(self) -> Case:
        first, second = self._any_body(), self._any_body()
        if self.chance(0.5):
            second = self._star()
        if self.chance(0.15):
            second = WALL
        bodies = (replace(first, velocity=self._speed()), second)
        case = Case(bodies, (Contact(0, 1, self._law(), self._gap()),))
        return self._loaded(case, chance=0.3)

    def _crowd(self) -> Case:
        """Return a scene of one body among two to eight others, on either side of it."""
        kind = self.rng.random()
        centre: Body | Frame = self._star(massless=0.45)
        if kind < 0.15:
            centre = self._rigid()
        elif kind < 0.35:
            centre = self._frame()
        centre = replace(centre, velocity=0.0 if self.chance(0.8) else self._speed())
        bodies: list[Body | Frame] = [centre]
        contacts: list[Contact] = []
        law = self._law()
        for number in range(int(self.rng.choice([2, 3, 4, 8], p=[0.55, 0.25, 0.15, 0.05]))):
            law = law if self.chance(0.3) else self._law()
            behind = self.chance(0.6) or number == 0
            kind = self.rng.random()
            if kind < 0.2 and number > 0:
                other = WALL
            elif kind < 0.35:
                other = self._star()
            else:
                other = self._rigid()
            moving = number == 0 or self.chance(0.75)
            if not other.wall and moving:
                other = replace(other, velocity=self._speed() * (1.0 if behind else -1.0))
            bodies.append(other)
            port, last = int(self.rng.integers(centre.ports)), len(bodies) - 1
            gap = self._gap()
            if behind:
                contacts.append(Contact(last, 0, law, gap, (0, port)))
            else:
                contacts.append(Contact(0, last, law, gap, (port, 0)))
        return self._loaded(Case(tuple(bodies), tuple(contacts)), chance=0.25)

    def _chain(self) -> Case:
        count = int(self.rng.integers(3, 7))
        bodies = [self._any_body() for _ in range(count)]
        bodies[0] = replace(bodies[0], velocity=self._speed())
        if self.chance(0.4):
            bodies[-1] = WALL
        contacts = tuple(Contact(i, i + 1, self._law(), self._gap()) for i in range(count - 1))
        return self._loaded(Case(tuple(bodies), contacts), chance=0.25)

    def _pressed(self) -> Case:
        """Return a scene of bodies in a row, pressed on a wall or held body by a load.

        Later the load is released or increased, or another body strikes.
        """
        count = int(self.rng.integers(1, 4))
        row = [self._star(held=0.0) if self.chance(0.4) else self._rigid() for _ in range(count)]
        base = WALL if self.chance(0.5) else self._star(held=1.0)
        if base.k0 == 0.0 and not base.wall:
            base = WALL
        bodies = [*row, base]
        contacts = [Contact(i, i + 1, self._law()) for i in range(count)]
        preload = self.chance(0.75)
        gravity, loads = 0.0, []
        if self.chance(0.4):
            gravity = self.some(self.force / self.mass, -2.0, 0.0)
        if gravity == 0.0 or self.chance(0.6):
            loads.append(Load(0, *self._pressing()))
        if self.chance(0.3):
            others = [i for i, body in enumerate(bodies) if not body.wall and i > 0]
            if others:
                loads.append(Load(int(self.rng.choice(others)), *self._ramp()))
        if self.chance(0.1):
            striker = replace(self._rigid(), velocity=self._speed())
            if gravity == 0.0:
                bodies.append(striker)
                contacts.append(
                    Contact(
                        len(bodies) - 1,
                        0,
                        self._law(),
                        _rounded(self.depth * self.between(0.1, 3.0)),
                    )
                )
        return Case(tuple(bodies), tuple(contacts), tuple(loads), gravity, preload=preload)

    def _ringing(self) -> Case:
        """Return a scene of a heavy mass in a long contact between light ones that vibrate.

        Small hard bodies strike the light masses from opposite sides, so that the heavy mass stays
        at rest under their vibration. One light mass swings about as far as a wall.
        """
        heavy, light = _rounded(self.mass), self.some(self.mass, -3.0, -0.5)
        swings = 2.0 * math.pi / self.time * self.decades(0.7, 2.7)
        omega = min(swings, 0.8 * MOST_RADIANS / self.duration)
        stiffness = _rounded(light * omega**2)
        frame = Frame((light, heavy, light), (stiffness, stiffness), (0.0, 0.0, 0.0))
        soft = Law("Hertz", {"k": _rounded(self.force / self.depth**1.5)})
        tap = _rounded(light * self.between(0.1, 1.0))
        quick = self.speed * self.decades(-1.0, 0.5)
        # The tap's contact lasts a fraction of a period of the vibration that it excites.
        short = self.between(0.1, 1.0) / omega
        hard = _rounded(tap * quick / short / (quick * short) ** 1.5)
        swing = 2.0 * tap / (tap + light) * quick / omega
        wall = Law("Hertz", {"k": self.some(hard, -3.0, 0.5)})
        drift = self.speed * self.time * self.decades(-2.0, 0.0)
        bodies = (
            frame,
            Body(self.some(self.mass, -1.0, 1.0), velocity=_rounded(self.speed)),
            Body(tap, velocity=_rounded(quick)),
            Body(tap, velocity=-_rounded(quick)),
            WALL,
        )
        struck = Law("Hertz", {"k": hard})
        contacts = (
            Contact(1, 0, soft, 0.0, (0, 1)),
            Contact(2, 0, struck, 0.0, (0, 0)),
            Contact(0, 3, struck, 0.0, (2, 0)),
            Contact(0, 4, wall, _rounded(swing * self.between(0.7, 1.1) + drift), (0, 0)),
        )
        return Case(bodies, contacts)

    def _rung(self) -> Case:
        """Return a scene of a long contact at a point that vibrates with any share of the depth.

        The vibration is excited by a load that is removed suddenly, or by a small hard body that
        strikes before or during the contact.
        """
        m0 = self.some(self.mass, -2.0, 0.5)
        m = self.some(self.mass, 0.0, 1.0)
        swings = 2.0 * math.pi / self.time * self.decades(1.0, 3.5)
        omega = min(swings, MOST_RADIANS / self.duration)
        k = _rounded(omega**2 * m0 * m / (m0 + m))
        damping = ("ModalDamping", _rounded(self.decades(-4.0, -1.0))) if self.chance(0.4) else None
        star = Body(m0, 0.0, (m,), (k,), damping)
        amplitude = self.depth * self.decades(-7.0, -0.5)
        ball = replace(self._rigid(), velocity=self._speed())
        gap = _rounded(ball.velocity * self.between(1.0, 20.0) / omega)
        long = Contact(1, 0, self._law(), gap)
        if self.chance(0.5):
            force, end = _rounded(amplitude * m0 * omega**2), 1.0 / omega
            pulse = Load(0, (0.0, _rounded(end), _rounded(1.01 * end)), (force, force, 0.0))
            return Case((star, ball), (long,), (pulse,))
        tap = self.some(m0, -2.0, -0.3)
        later = self.chance(0.4)
        # A slower tap would depend on errors of the long contact's velocities within tolerance.
        least = 0.1 * self.speed if later else 0.0
        speed = _rounded(max(amplitude * omega * (m0 + tap) / (2.0 * tap), least))
        short = self.between(0.1, 1.0) / omega
        hard = Law("Hertz", {"k": _rounded(tap * speed / short / (speed * short) ** 1.5)})
        wait = _rounded(speed * self.time * self.between(0.0, 1.0)) if later else 0.0
        bodies = (star, ball, Body(tap, velocity=speed))
        return Case(bodies, (long, Contact(2, 0, hard, wait)))

    def _pressing(self) -> Function:
        """Return times and forces of a load that presses from the start: constant or changing."""
        force = self.some(self.force, -1.5, 0.3)
        kind = self.rng.random()
        if kind < 0.3:
            return (0.0,), (force,)
        start = _rounded(self.duration * self.rng.choice([0.0, 0.1]))
        end = _rounded(start + self.time * self.decades(-1.5, 0.5))
        last = 0.0 if kind < 0.8 else _rounded(force * self.between(-0.5, 2.0))
        return (start, end), (force, last)

    def _ramp(self) -> Function:
        """Return times and forces of a load that rises from 0, perhaps steeply, and may end."""
        force = self.some(self.force, -2.0, 0.0) * self.sign()
        rise = _rounded(self.duration * self.between(0.1, 0.9))
        begin, end = 0.0, rise
        steep = self.rng.spawn(1)[0]  # does not change what is drawn from rng
        if steep.random() < 0.3:
            begin = _rounded(rise * steep.uniform(0.1, 0.9))
            end = begin + self.duration * 10.0 ** float(steep.uniform(-10.0, -2.0))
        if self.chance(0.5):
            return (begin, end), (0.0, force)
        return (begin, end, _rounded(1.5 * rise)), (0.0, force, 0.0)

    def _loaded(self, case: Case, *, chance: float) -> Case:
        """Return the scene, perhaps under gravity and a load."""
        loads: tuple[Load, ...] = ()
        free = [i for i, body in enumerate(case.bodies) if not body.wall]
        if self.chance(chance):
            body = int(self.rng.choice(free))
            force = self.some(self.force, -2.0, -0.3) * self.sign()
            steady = self.chance(0.3) and not case.bodies[body].massless
            port = int(self.rng.integers(case.bodies[body].ports))
            when, what = ((0.0,), (force,)) if steady else self._ramp()
            loads = (Load(body, when, what, port),)
        gravity = 0.0
        weightless = any(b.held and isinstance(b, Body) and not b.wall for b in case.bodies)
        if self.chance(0.2) and not weightless:
            gravity = self.some(self.force / self.mass, -3.0, -0.5)
        return replace(case, loads=loads, gravity=gravity)


def case_of(seed: int) -> Case:
    """Return the scene of a seed."""
    return _Drawn(seed).case()
