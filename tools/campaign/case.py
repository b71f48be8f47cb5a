"""A scene as plain data in SI units, which can be printed as a script and built.

The script has the expressions that `build` evaluates, so that it runs the same scene.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import aoimpact as ao


@dataclass(frozen=True)
class Law:
    """A contact law by its public name and its arguments.

    `removed`: compliance removed from it, m/N, or None.
    """

    kind: str
    arguments: dict[str, Any]
    removed: float | None = None

    @property
    def deepest(self) -> float:
        """Indentation of Hertz's law at c dF/dδ = 0.95, m: up to there c can be removed."""
        if self.removed is None:
            return math.inf
        return float((0.95 / (1.5 * self.arguments["k"] * self.removed)) ** 2)

    @property
    def expression(self) -> str:
        if self.removed is not None:
            return f"{replace(self, removed=None).expression}.within_patch({self.removed!r})"
        if self.kind == "UserLaw":
            k, n, c = (self.arguments[key] for key in ("k", "n", "c"))
            return f"ao.UserLaw(lambda d, rate: {k!r} * d**{n!r} * (1.0 + {c!r} * rate))"
        given = ", ".join(f"{name}={value!r}" for name, value in self.arguments.items())
        return f"ao.{self.kind}({given})"


@dataclass(frozen=True)
class Body:
    """An AO model, a rigid mass (no oscillators, no k0) or a wall (m0 infinite).

    `damping`: None, ("Rayleigh", alpha, beta) or ("ModalDamping", ratio).
    """

    ports = 1

    m0: float
    k0: float = 0.0
    m: tuple[float, ...] = ()
    k: tuple[float, ...] = ()
    damping: tuple[Any, ...] | None = None
    velocity: float = 0.0

    @property
    def wall(self) -> bool:
        return math.isinf(self.m0)

    @property
    def massless(self) -> bool:
        return self.m0 == 0.0

    @property
    def held(self) -> bool:
        return self.k0 > 0.0 or self.wall

    @property
    def mass(self) -> float:
        return self.m0 + math.fsum(self.m)

    @property
    def masses(self) -> tuple[float, ...]:
        """Masses of its coordinates, the contact's first."""
        return self.m0, *self.m

    @property
    def springs(self) -> list[tuple[int, int, float]]:
        """Coordinates at both ends and stiffness of each spring; equal ends mean the ground."""
        return [(0, 0, self.k0), *((0, j, k) for j, k in enumerate(self.k, start=1))]

    @property
    def expression(self) -> str:
        if not self.m and self.k0 == 0.0:
            return f"ao.rigid(mass={'math.inf' if self.wall else repr(self.m0)})"
        parts = [f"m0={self.m0!r}"]
        if self.k0:
            parts.append(f"k0={self.k0!r}")
        if self.m:
            parts += [f"m={list(self.m)!r}", f"k={list(self.k)!r}"]
        if self.damping:
            parts.append(f"damping={_damping_text(self.damping)}")
        return f"ao.AOModel({', '.join(parts)})"


def _damping_text(damping: tuple[Any, ...]) -> str:
    if damping[0] == "Rayleigh":
        return f"ao.Rayleigh(alpha={damping[1]!r}, beta={damping[2]!r})"
    return f"ao.ModalDamping({damping[1]!r})"


@dataclass(frozen=True)
class Frame:
    """Masses in a row with springs k between them and k0 to the ground, touched at any mass.

    It is a finite-element body given by matrices and nodes, which moves only along the row.
    """

    m: tuple[float, ...]
    k: tuple[float, ...]
    k0: tuple[float, ...]
    velocity: float = 0.0
    damping: tuple[Any, ...] | None = None

    wall = False
    massless = False

    @property
    def ports(self) -> int:
        return len(self.m)

    @property
    def held(self) -> bool:
        return any(self.k0)

    @property
    def mass(self) -> float:
        return math.fsum(self.m)

    @property
    def masses(self) -> tuple[float, ...]:
        return self.m

    @property
    def springs(self) -> list[tuple[int, int, float]]:
        between = [(i, i + 1, k) for i, k in enumerate(self.k)]
        return [*((i, i, k) for i, k in enumerate(self.k0)), *between]

    @property
    def expression(self) -> str:
        damped = f", {_damping_text(self.damping)}" if self.damping else ""
        return f"frame({list(self.m)!r}, {list(self.k)!r}, {list(self.k0)!r}{damped})"


# Beginning of a script with a Frame.
FRAME = """
def frame(m, k, k0, damping=None):
    n = len(m)
    K, M = np.zeros((3 * n, 3 * n)), np.diag(np.repeat(m, 3))
    across = [i for i in range(3 * n) if i % 3]
    K[across, across] = max(k) + max(k0)
    for i in range(n):
        K[3 * i, 3 * i] += k0[i]
    for i in range(n - 1):
        ends = np.ix_([3 * i, 3 * i + 3], [3 * i, 3 * i + 3])
        K[ends] += k[i] * np.array([[1.0, -1.0], [-1.0, 1.0]])
    body = ao.FEModel(K=K, M=M, nodes=[[float(i), 0.0, 0.0] for i in range(n)], damping=damping)
    along = dict(direction=(1, 0, 0), radius=0)
    return ao.full([body.contact(point=(float(i), 0.0, 0.0), **along) for i in range(n)])
"""


@dataclass(frozen=True)
class Contact:
    """Contact of bodies `a` and `b` at ports `at`: indentation = u of a - u of b - gap."""

    a: int
    b: int
    law: Law
    gap: float = 0.0
    at: tuple[int, int] = (0, 0)


@dataclass(frozen=True)
class Load:
    """Force on a body, linear between the times and constant outside them."""

    body: int
    times: tuple[float, ...]
    forces: tuple[float, ...]
    at: int = 0

    @property
    def expression(self) -> str:
        if len(self.times) == 1:
            return repr(self.forces[0])
        return f"({list(self.times)!r}, {list(self.forces)!r})"


@dataclass(frozen=True)
class Case:
    """A whole scene, the length of its record and the tolerance."""

    bodies: tuple[Body | Frame, ...]
    contacts: tuple[Contact, ...]
    loads: tuple[Load, ...] = ()
    gravity: float = 0.0
    duration: float = 1.0
    preload: bool = False
    rtol: float = 1e-6
    family: str = ""

    def with_tolerance(self, rtol: float) -> Case:
        return replace(self, rtol=rtol)

    def lines(self) -> list[str]:
        """Return the lines of the script that make the scene."""
        lines = [f"scene = ao.Scene(gravity={self.gravity!r})"]
        for i, body in enumerate(self.bodies):
            moving = f", velocity={body.velocity!r}" if body.velocity else ""
            lines.append(f"b{i} = scene.add({body.expression}{moving})")
        for contact in self.contacts:
            gap = f", gap={contact.gap!r}" if contact.gap else ""
            a, b = self._handle(contact.a, contact.at[0]), self._handle(contact.b, contact.at[1])
            lines.append(f"scene.connect({a}, {b}, {contact.law.expression}{gap})")
        for load in self.loads:
            body = self._handle(load.body, load.at)
            lines.append(f"scene.apply({body}, force={load.expression})")
        return lines

    def _handle(self, body: int, port: int) -> str:
        return f"b{body}.port({port})" if self.bodies[body].ports > 1 else f"b{body}"

    def script(self) -> str:
        """Return a script of public API that runs the scene and prints the compared results."""
        frames = any(isinstance(body, Frame) for body in self.bodies)
        head = ["import math", *(["", "import numpy as np"] * frames), "", "import aoimpact as ao"]
        head += [FRAME] if frames else [""]
        preload = ", preload=True" if self.preload else ""
        how = f"duration={self.duration!r}{preload}, solver=ao.Adaptive(rtol={self.rtol!r})"
        tail = [
            f"run = scene.simulate({how})",
            "for i, contact in enumerate(run.contacts):",
            '    print(i, "peak", contact.peak_force, "at", contact.peak_time,',
            '          "impulse", contact.impulse, "touches", contact.intervals[:4])',
            'print("velocities", [float(body.centre_velocity[-1]) for body in run.bodies])',
            'print("error", run.error)',
        ]
        return "\n".join(head + self.lines() + tail) + "\n"

    def build(self) -> ao.Scene:
        names: dict[str, Any] = {"ao": ao, "math": math, "np": np}
        exec("\n".join([FRAME, *self.lines()]), names)
        scene: ao.Scene = names["scene"]
        return scene
