"""An impact of two bodies: the scene of a moving projectile and a target at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

from numpy.typing import ArrayLike

from ..accuracy import Interest
from ..base import InputError, InputTypeError, boolean, nonnegative, plain, warn
from ..laws import ContactLaw
from ..linalg import Solver
from ..results import ROLES, Result, TimeSolver, warn_of_exchange
from ..scene import Scenario
from .foreseen import Foreseen
from .scene import Mark, Scene


def simulate(
    projectile: Any,
    target: Any,
    velocity: float | ArrayLike,
    *,
    law: ContactLaw | None = None,
    friction: float | None = None,
    spin: ArrayLike | None = None,
    duration: float | None = None,
    solver: TimeSolver | None = None,
    gap: float = 0.0,
    energies: bool = True,
    quantity: Interest | Sequence[Interest] | None = None,
    rtol: float | None = None,
    linear_solver: Solver | None = None,
) -> Result:
    """Simulate the impact of a moving projectile on a target at rest.

    Both bodies are undeformed at t = 0, the projectile moving with `velocity` towards the target.
    Arguments left out are determined from the bodies and reported in the result.

    Parameters
    ----------
    projectile, target : ContactPoint, AOModel, Body or FullModel
        Body given by its contact point (``body.contact(...)``), which is reduced as far as the
        quantity of interest allows, or by a model; ``full(tip)`` is the full finite-element model.
        The best model of a given number of oscillators is
        ``antioscillators(tip, n, method="krylov", contact_time=)``. If the radius of a patch was
        left out, the radius is 1.4 times the contact radius of rigid bodies.
    velocity : float or array_like, shape (3,)
        Speed of the projectile along the direction of travel, m/s, not zero; negative only if the
        projectile is constrained, so that it swings back. A vector is the projectile's velocity in
        the axes of the target's mesh; the axes of the projectile's mesh are parallel to these.
        Without a mesh z is the target's outward normal: ``(0, 0.5, -3.0)`` is a velocity towards
        the target.
    law : ContactLaw, optional
        Contact force as a function of the indentation δ = x_projectile - x_target - gap; by default
        Hertz's law of the materials of both bodies and the curvatures of their surfaces at the
        contact. The local compliance of a mesh, which replaces that of the law's half-space, is
        taken out of the law (`ContactPoint.extraction`).
    friction : float, optional
        Coulomb's coefficient, for laws without memory or tension. The contact sticks in its middle
        and slips at its rim (Cattaneo, Mindlin). This model of friction is exact for spheres,
        except that for unlike materials the effect of friction on the normal force (Dundurs'
        constant) is neglected. A law without materials has the tangential stiffness of ν = 0.3.
        Required if `velocity` is a vector; 0 is a smooth surface, for any law. Motion is assumed
        small: contact points are fixed to each body.
    spin : array_like, shape (3,), optional
        Angular velocity of the projectile in the same axes, rad/s; requires `friction`. Friction
        does not resist spin about the normal of the contact.
    duration : float, optional
        Length of the record, s; by default until the impact is over and as long again.
    solver : Adaptive or Newmark, optional
        Time integration: ``Adaptive(rtol=...)`` to a tolerance, ``Newmark(dt=...)`` with fixed
        steps. The default is ``Adaptive()``, with friction ``Adaptive(rtol=1e-4)``. For a full
        finite-element model, whose modes ``Adaptive`` would have to compute first, and for friction
        with a damped law it is ``Newmark()``, which chooses its step.
    gap : float, optional
        Initial gap between the bodies, m, not negative.
    energies : bool, optional
        True to record energies as well.
    quantity : str, ContactPoint or sensor, or list of these, optional
        Quantity of interest. Histories over the record are "force" (the default),
        "projectile_displacement" or "target_displacement" (of the contact point), the displacement
        of a body's point, given by that point, and `StressAt`, `StrainAt`, `AccelerationAt` or
        `ReactionAt`. Numbers are "peak_force", "peak_time", "impulse", "contact_duration" (of the
        first contact), "contact_count", "rebound_velocity", "restitution" (ratio of the velocities
        at which the bodies last part and first meet) and, with friction, "peak_friction_force",
        "tangential_restitution" or "final_spin". Bodies given by contact points are reduced as far
        as `rtol` allows; AO models are truncated if `quantity` or `rtol` is given. `Result.models`
        has the resulting models. Only this quantity, or each of a list, meets `rtol`;
        `Result.error` estimates the errors of all others by name. A second quantity of the same
        name gets a number: ``error["strain_2"]``.
    rtol : float, optional
        Relative tolerance of `quantity`, for reduction and time integration; by default 2e-3, or up
        to 1e-2 if the largest models tried do not meet 2e-3. The error of a history is its largest
        over the record, relative to the largest value. A solver that does not meet `rtol` is
        refused. If no models tried meet a given `rtol`, ConvergenceError is raised; if the default
        is not met, the best models are used with a warning. Errors of mesh and contact come in
        addition; see `Result.error`.
    linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        Linear solver for the reduced models, as `solver` of `antioscillators`; the result names it.

    Returns
    -------
    Result

    Raises
    ------
    InputError, InputTypeError
        For an invalid argument, or if `law` is left out and the surfaces or materials are not
        known.
    ConvergenceError
        If a time step cannot be solved, or no models tried meet `rtol`.

    Warns
    -----
    AOImpactWarning
        If no models tried meet the default tolerance, the record ends in contact, the step is too
        large for any accurate digit, a body's centre of mass is not known, or its model was fitted
        to another contact time.

    Examples
    --------
    >>> ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))
    >>> hit = ao.simulate(projectile=ball, target=ball, velocity=1.0)
    >>> round(hit.peak_force, 1), round(hit.law.k / 1e9, 2)  # N, GN/m^1.5
    (1001.5, 10.88)
    """
    began = perf_counter()
    scene, plan = pair(
        *(projectile, target, velocity, law),
        friction=friction,
        spin=spin,
        gap=gap,
        energies=energies,
    )
    if plan.meshed:
        warn_of_exchange(*plan.bodies)
    result = scene._run(plan, duration, quantity, rtol, solver, linear_solver, began)
    assert isinstance(result, Result)
    if duration is not None and result.in_contact_at_end:
        warn(
            f"the record of {result.duration:.4g} s ends in contact, which cuts off the impulse "
            "and the last contact, and there is no rebound (NaN); take a longer duration"
        )
    return result


def pair(
    projectile: Any,
    target: Any,
    velocity: Any,
    law: ContactLaw | None,
    *,
    friction: float | None = None,
    spin: Any = None,
    gap: float = 0.0,
    energies: bool = True,
) -> tuple[Scene, Scenario]:
    """Return the scene of a projectile that moves towards a target at rest, and its plan.

    Parameters
    ----------
    projectile, target, velocity, law, friction, spin, gap, energies
        As of `simulate`.

    Raises
    ------
    InputError, InputTypeError
        For an invalid argument, or if `law` is left out and cannot be found from the surfaces.
    """
    scene = Scene()
    scene._mark = Mark("")
    moving = scene._take("projectile", projectile, velocity, spin)
    held = scene._take("target", target)
    for name, member in zip(ROLES, (moving, held), strict=True):
        if member.body.places > 1:
            raise InputTypeError(
                f"{name} is touched in several places: build a Scene, and connect its ports"
            )
    speed = moving.velocity
    if speed == 0.0:
        raise InputError("velocity is 0 m/s: nothing would move; give the projectile a velocity")
    if speed < 0.0 and not moving.body.constrained:
        raise InputError(
            f"velocity={speed:g} m/s: the projectile flies away from the target; give the speed at "
            "which it comes, or build a Scene with what brings it back"
        )
    scene._join((0, 0), (1, 0), law, nonnegative("gap", gap, unit="m"), friction=friction)
    plan = scene._plan(energies=boolean("energies", energies))
    if plan.oblique is not None and moving.vector is not None and plan.velocities[0] <= 0.0:
        raise InputError(
            f"velocity={plain(moving.vector)} m/s does not approach the target; give one with a "
            f"part along {plain(plan.oblique.axes[0])}, into its surface"
        )
    return scene, plan


def plan_impact(
    projectile: Any, target: Any, law: ContactLaw | None, *, duration: float, **more: Any
) -> Scenario:
    """Check the arguments of `pair`, and return the plan for the solvers."""
    _, plan = pair(projectile, target, law=law, **more)
    plan = Foreseen(plan).fitted(ROLES, {})
    return replace(plan.of_models(plan.bodies, energies=plan.energies), duration=duration)
