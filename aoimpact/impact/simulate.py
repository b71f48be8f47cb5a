"""An impact of two bodies: the scene of a moving projectile and a target at rest."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
import numpy.typing as npt

from ..accuracy import Sensor, checked_rtol, quantity_of
from ..base import InputError, InputTypeError, boolean, plain, warn
from ..contact import ContactPoint
from ..laws import ContactLaw, own_law
from ..linalg import Solver
from ..reduction import BodyModel, body_model
from ..results import Result, TimeSolver, warn_of_exchange
from ..scene import Scenario
from .defaults import checked_numbers, turns
from .foreseen import Foreseen
from .oblique import checked_spin, vector_or_number
from .scene import Member, Scene

_NAMES = "projectile", "target"


def simulate(
    projectile: Any,
    target: Any,
    velocity: float | npt.ArrayLike,
    *,
    law: ContactLaw | None = None,
    friction: float | None = None,
    spin: npt.ArrayLike | None = None,
    duration: float | None = None,
    solver: TimeSolver | None = None,
    gap: float = 0.0,
    energies: bool = True,
    quantity: str | ContactPoint | Sensor | None = None,
    rtol: float | None = None,
    linear_solver: Solver | None = None,
) -> Result:
    """Simulate the impact of a moving projectile on a target at rest.

    Both bodies are undeformed at t = 0, the projectile moving with `velocity` towards the target.
    Arguments left out are determined from the bodies and reported in the result.

    Parameters
    ----------
    projectile, target : ContactPoint, AOModel, Body or FullModel
        A contact point (``body.contact(...)``) is reduced as far as the quantity of interest
        allows; ``full(tip)`` is the full finite-element model. A model of a given number of
        oscillators is best made by ``antioscillators(tip, n, method="krylov", contact_time=)``. A
        patch whose radius was left out is 1.4 times as wide as the contact of rigid bodies.
    velocity : float or array_like, shape (3,)
        Speed of the projectile along the direction of travel, m/s, not zero; negative only if the
        projectile is constrained, so that it swings back. Or its velocity in the axes of the
        target's mesh, to which those of the projectile are parallel. Without a mesh z is the
        target's outward normal: ``(0, 0.5, -3.0)`` comes down on it.
    law : ContactLaw, optional
        Force of the indentation δ = x_projectile - x_target - gap. If left out, Hertz's, from the
        materials of both bodies and the curvatures of their surfaces at the contact. The compliance
        that a mesh has in place of the law's half-space is taken out (`ContactPoint.extraction`).
    friction : float, optional
        Coulomb's coefficient, for laws without memory or pull. The contact sticks in its middle
        and slips at its rim (Cattaneo, Mindlin). That of spheres is exact but for Dundurs' constant
        of unlike materials, by which friction changes the normal force and which is neglected. A
        law without materials has the tangential stiffness of ν = 0.3. A vector needs it: 0 is a
        smooth surface, for any law.
        Motion is small: contact points stay where they are on each body.
    spin : array_like, shape (3,), optional
        Angular velocity of the projectile in the same axes, rad/s; with `friction`. Spin about the
        normal of the contact meets no friction.
    duration : float, optional
        Length of the record, s. If left out, until the impact is over and as long again.
    solver : Adaptive or Newmark, optional
        ``Adaptive(rtol=...)`` for a tolerance, ``Newmark(dt=...)`` for a given step. By default
        ``Adaptive()``, with friction ``Adaptive(rtol=1e-4)``; with a full finite-element model,
        whose modes would have to be computed first, and with friction of a damped law
        ``Newmark()`` with a step of its own choice.
    gap : float, optional
        Distance to go before the bodies touch, m, not negative.
    energies : bool, optional
        Whether to record energies as well.
    quantity : str, ContactPoint or sensor, optional
        The quantity of interest: "force" (over the record; the default), "peak_force", "peak_time",
        "impulse", "contact_duration" (of the first contact), "contact_count" (how often they
        touch), "rebound_velocity", "restitution", with friction "peak_friction_force",
        "tangential_restitution" or "final_spin", "projectile_displacement" or
        "target_displacement" (of the contact point, over the record); or a point of a body, for its
        displacement over the record, or a `StressAt`, `StrainAt`, `AccelerationAt` or `ReactionAt`
        over the record. Contact points are reduced as
        far as the tolerance allows, and AO models truncated if this or `rtol` is given;
        `Result.models` are those taken. Only this quantity is right to `rtol`:
        `Result.error` estimates the errors of the others by name.
    rtol : float, optional
        Its relative error by reduction and time integration. If left out, 2e-3, or up to 1e-2
        where 2e-3 takes a third more oscillators. That of a history is its largest over the record,
        relative to the largest value. A solver that does not keep it is refused;
        where no models tried meet it, so is the tolerance if it was given, and else the best of
        them are taken, with a warning. `Result.error` has the errors of mesh and contact as well.
    linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        Linear solver for the reduced models, as `solver` of `antioscillators`; the result names it.

    Returns
    -------
    Result

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense, or a law that is left out and not known.
    ConvergenceError
        If the step cannot be solved or the error estimate cannot be brought down to `rtol`.

    Warns
    -----
    AOImpactWarning
        If no models tried meet the tolerance that was left out, the record ends in contact, the
        step is too large for any digit to be right, a body's centre of mass is not known, or its
        model was fitted to another contact time.

    Examples
    --------
    >>> ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))
    >>> hit = ao.simulate(projectile=ball, target=ball, velocity=1.0)
    >>> round(hit.peak_force, 1), round(hit.law.k / 1e9, 2)  # N, GN/m^1.5
    (1001.5, 10.88)
    """
    began = perf_counter()
    impact = Impact(projectile, target, velocity, spin=spin, gap=gap, duration=duration)
    impact.refuse_smooth(friction)
    boolean("energies", energies)
    warn_of_exchange(*impact.bodies)
    # Bad input is refused before any work is done.
    if quantity is not None or rtol is not None:
        checked_rtol(rtol)
        quantity_of(quantity, impact.bodies, pair=True)
    plan = impact.touch(law, friction, energies=energies)
    result = impact._run(plan, impact.duration, quantity, rtol, solver, linear_solver, began)
    assert isinstance(result, Result)
    if duration is not None and result.in_contact_at_end:
        warn(
            f"the record of {result.duration:.4g} s ends in contact: impulse and the last "
            "contact's end are those so far, and there is no rebound (NaN); take a longer duration"
        )
    return result


class Impact(Scene):
    """The scene of a projectile that moves towards a target at rest.

    Parameters
    ----------
    projectile, target, velocity, spin, gap, duration
        As of `simulate`.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """

    def __init__(
        self,
        projectile: Any,
        target: Any,
        velocity: float | npt.ArrayLike,
        *,
        spin: npt.ArrayLike | None = None,
        gap: float = 0.0,
        duration: float | None = None,
    ) -> None:
        self._begin(0.0, "")
        turns = checked_spin(spin)
        vector = vector_or_number("velocity", velocity, "m/s")
        size = velocity if vector is None else float(np.linalg.norm(vector))
        self.velocity, self.duration, self.gap = checked_numbers(size, duration, gap)
        for name, body in zip(_NAMES, (projectile, target), strict=True):
            model = body_model(name, body)
            if model.ports > 1 and model.places > 1:
                raise InputTypeError(
                    f"{name} is touched in several places: build a Scene, and connect its ports"
                )
            moving = (self.velocity, 0.0, "", vector, turns) if not self._members else (0.0,)
            self._members.append(Member(model, *moving))
        if self.velocity < 0.0 and not self.bodies[0].constrained:
            raise InputError(
                f"velocity={self.velocity:g} m/s: the projectile flies away from the target, and "
                "nothing turns it round; give the speed at which it comes, or build a Scene with "
                "what brings it back (gravity, a load, a body behind it)"
            )

    def refuse_smooth(self, friction: float | None) -> None:
        """Refuse a velocity in three directions, or a spin, without friction."""
        *_, vector, spin = self._members[0]
        if friction is None and vector is not None:
            raise InputError(
                f"velocity={plain(vector)} m/s is a vector, and friction is left out: "
                "give friction=0 for smooth surfaces or a coefficient, or the speed alone"
            )
        if friction is None and spin is not None:
            raise InputError(
                f"spin={plain(spin)} rad/s is felt by friction alone, which is left out: give a "
                "coefficient, or leave spin out"
            )

    def touch(
        self, law: ContactLaw | None, friction: float | None = None, *, energies: bool = True
    ) -> Scenario:
        """Return the plan under a law, or Hertz's of the surfaces if it is left out."""
        turned = (False, False) if law is not None else self.turned
        self._join((0, 0), (1, 0), law, self.gap, turned=turned, friction=friction)
        plan, vector = self._plan(energies=energies), self._members[0].vector
        if plan.oblique is not None and vector is not None and plan.velocities[0] <= 0.0:
            raise InputError(
                f"velocity={plain(vector)} m/s does not approach the target along "
                f"{plain(plan.oblique.axes[0])}, into its surface; give a velocity with a part "
                "along that"
            )
        return plan

    @property
    def bodies(self) -> tuple[BodyModel, BodyModel]:
        """Projectile and target, as they were given."""
        first, second = self._members
        return first.body, second.body

    @property
    def turned(self) -> tuple[bool, bool]:
        """True if the direction of travel of each body must be reversed; see `turns`."""
        first, second = self.bodies
        tip = first.touched_at()
        like = tip is not None and tip is second.touched_at()
        return (
            turns("projectile", first, 0, outward=True, like=like),
            turns("target", second, 0, outward=False, like=like),
        )

    @property
    def law(self) -> ContactLaw:
        """The law between the bodies themselves."""
        return own_law(self._contacts[0].law)

    def _role(self, body: int) -> str:
        return _NAMES[body]


def plan_impact(
    projectile: Any,
    target: Any,
    law: ContactLaw | None,
    *,
    velocity: float,
    duration: float,
    gap: float = 0.0,
    energies: bool = True,
) -> Scenario:
    """Check the arguments of `simulate`, and return them as the solvers take them.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """
    impact = Impact(projectile, target, velocity, gap=gap, duration=duration)
    plan = impact.touch(law, energies=boolean("energies", energies))
    plan = Foreseen(plan).fitted(_NAMES, {})
    return replace(plan.of_models(plan.bodies, energies=energies), duration=duration)
