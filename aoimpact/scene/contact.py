"""Contacts between the bodies of a scene, loads on them, and free motion."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..base import HUGE, FloatArray, InputError
from ..fem import ContactCompliance
from ..laws import ContactLaw, CoreLaw, HertzianLaw, effective_law, own_law
from ..reduction import BodyModel
from .rows import BodyRows


def normal_gap(gap: float) -> float:
    """Return a gap, m; 0 for a subnormal one, which no time of approach can tell from 0.

    Raises
    ------
    InputError
        If its square is no number.
    """
    if abs(gap) > HUGE:
        raise InputError(
            f"gap={gap:g} m is beyond what can be computed with: give up to {HUGE:g} m"
        )
    return gap if abs(gap) >= sys.float_info.min else 0.0


def law_of_models(
    law: ContactLaw, ends: Sequence[tuple[BodyModel, int]], width: float | None = None
) -> ContactLaw:
    """Return the law that acts between models, given the law between the bodies themselves.

    The compliance that their meshes have in place of a half-space is taken out of it.

    Parameters
    ----------
    law : ContactLaw
    ends : sequence of (model, int)
        The bodies, and at which of their places they touch.
    width : float, optional
        Radius of the contact at its largest force, m, on which that of curved bodies depends.

    Raises
    ------
    InputError
        If the law is more compliant than the meshes from the first touch on.
    """
    known = (extraction_of(law, model, port) for model, port in ends)
    return effective_law(
        law, math.fsum(found.removed_for(width) for found in known if found is not None)
    )


def extraction_of(law: ContactLaw, model: BodyModel, port: int) -> ContactCompliance | None:
    """Return the compliances of a body under a law, or None if nothing is taken out of it there.

    A law that is not like Hertz's leaves out the indentation at a node, as springs and buffers do.
    """
    tip = model.touched_at(port)
    if tip is None or (tip.patch is None and not isinstance(own_law(law), HertzianLaw)):
        return None
    return model.extraction_at(port)


class Port(NamedTuple):
    """A place where a body may be touched.

    Attributes
    ----------
    body, port : int
        Number of the body in the scene, and of the place on it.
    """

    body: int
    port: int


class Contact(NamedTuple):
    """A contact of two bodies.

    Attributes
    ----------
    first, first_port, second, second_port : int
        Numbers of the bodies in the plan, and of the places where they are touched; the indentation
        is the first's coordinate minus the second's minus the gap.
    law : ContactLaw
        Law between the models: without the compliance of their meshes at the contact.
    gap : float
        Distance at the start, m.
    name : str
        As its user called it.
    """

    first: int
    first_port: int
    second: int
    second_port: int
    law: ContactLaw
    gap: float
    name: str = ""

    @property
    def ports(self) -> tuple[Port, Port]:
        """The two places that touch."""
        return Port(self.first, self.first_port), Port(self.second, self.second_port)

    def for_core(self, law: CoreLaw) -> tuple[Any, ...]:
        """Return it as the core takes it, with its law as the core takes that."""
        return *self[:4], self.gap, law

    def port_of(self, body: int) -> int:
        """Return where one of the two is touched."""
        return self.first_port if body == self.first else self.second_port

    def touches(self, body: int) -> bool:
        """Return whether a body is one of the two."""
        return body in (self.first, self.second)


class Load(NamedTuple):
    """A force on a port, linear between times and constant outside them.

    Attributes
    ----------
    body, port : int
        As in :class:`Port`.
    times, forces : ndarrays, shape (m,)
        s, ascending; N, along the direction of travel.
    """

    body: int
    port: int
    times: FloatArray
    forces: FloatArray


@dataclass(frozen=True)
class FreeMotion:
    """The motion of a mass that nothing but gravity acts on.

    Attributes
    ----------
    velocity, acceleration : float
        At t = 0, m/s, and constant, m/s².
    """

    velocity: float
    acceleration: float

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return displacement, m, and velocity, m/s, at `times`, s."""
        displacement = times * (self.velocity + 0.5 * self.acceleration * times)
        return displacement, self.velocity + self.acceleration * times


@dataclass(frozen=True)
class OmittedMass:
    """Mass that a reduced body does not contain, since no contact excites its motion.

    Attributes
    ----------
    share : float
        Share of its motion in that of the centre of mass.
    mass : float
        kg.
    motion : FreeMotion
    """

    share: float
    mass: float
    motion: FreeMotion

    def add_to(self, rows: BodyRows, times: FloatArray) -> None:
        """Add its motion and energy to what was recorded of the body at `times`, s."""
        displacement, velocity = self.motion.at(times)
        rows.displacement[:] += self.share * displacement
        rows.velocity[:] += self.share * velocity
        rows.kinetic[:] += 0.5 * self.mass * velocity**2
        rows.work[:] += self.mass * self.motion.acceleration * displacement
