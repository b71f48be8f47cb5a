"""The finer model of a body, which leaves less out than a given one.

It is that of the finer body (fem/finer.py): Ritz's method in the vectors of the given model and
what else there is of the sequence (K + s²M)⁻¹ b, (K + s²M)⁻¹ M (K + s²M)⁻¹ b, … of each contact. A
member of the sequence is first approximated in the space; what is left of its load is solved for
roughly and becomes a vector. The members soon lie in the space, since the given model has been made
of the body's own sequence.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..base import ROUNDING
from ..contact import SHIFT_TIMES_DURATION, own_contact_time
from ..linalg import Solver, m_orthonormal
from .body import Body, of_modes
from .krylov import KrylovSpace, only_excited

# Members of the sequence, or vectors of shells and beams, beyond as many as the given model has.
_TERMS = 12


def finer_model(model: Body, *, linear: Solver = "auto") -> Body:
    """Return the model of the body with finer elements; of one without, one of more vectors.

    Parameters
    ----------
    model : Body
    linear : str or callable, optional
        The linear solver; see `FEModel.inverse`.
    """
    finer = model.body.finer or model.body
    if finer.mesh is not model.body.mesh:
        return _fitted_alike(model, linear)
    K, M, rigid = finer.K, finer.M, finer.rigid_modes
    modes = finer.appended(model.modes)
    space = np.hstack([modes, m_orthonormal(modes, rigid, M)])
    strained = K @ space
    stiffness = space.T @ strained
    tips, pressed = [], []
    time, each = model.contact_time, model.ports // model.places
    for port, own in enumerate(model.tips):
        tip = own.finer or own
        tips.append(tip)
        if port % each == 0:
            known = own.extraction
            s = known.s if known else SHIFT_TIMES_DURATION / (time or own_contact_time(own))
            solver = finer.inverse(s * s, solver=linear)
            if known is not None and tip is not own:
                pressed.append((port, s, known.radius, solver))
        load = tip.b - M @ (rigid @ (rigid.T @ tip.b))
        for _ in range(_TERMS + len(model.omega) // len(model.tips)):
            shares = np.linalg.solve(stiffness + s * s * np.eye(len(stiffness)), space.T @ load)
            member = space @ shares
            left = load - strained @ shares - s * s * (M @ member)
            if np.linalg.norm(left) <= ROUNDING * np.linalg.norm(load):
                break
            change, _, _ = solver.solve_roughly(left)
            gained = float(left @ change)
            more = m_orthonormal(space, change[:, None], M)
            if more.shape[1]:
                space, strained = np.hstack([space, more]), np.hstack([strained, K @ more])
                stiffness = space.T @ strained
                stiffness = 0.5 * (stiffness + stiffness.T)
            if gained <= ROUNDING * float(load @ member):
                break
            load = M @ (member + change)
            load /= np.linalg.norm(load)
    omega2, within = np.linalg.eigh(stiffness)
    omega2 = np.maximum(omega2, 0.0)
    omega2[: rigid.shape[1]] = 0.0
    found = of_modes(
        tuple(tips),
        omega2,
        space,
        within,
        kind=model.kind,
        contact_time=time,
        linear_solver=model.linear_solver,
    )
    for port, s, radius, solver in pressed:
        moved = np.array([found.deflection(s, port + axis) for axis in range(each)])
        tips[port] = tips[port].at_impact(radius, solver, moved)
    found = replace(found, tips=tuple(tips))
    return only_excited(found) if model.kind in ("AO", "rigid") else found


def _fitted_alike(model: Body, linear: Solver) -> Body:
    """The model of a body of shells and beams cut finer, of more vectors fitted to the same."""
    elastic = int(np.count_nonzero(model.omega))
    if not elastic:
        return model
    tips = [tip.finer for tip in model.tips if tip.finer is not None]
    solver = None
    for port in range(0, model.ports, model.ports // model.places):
        if (known := model.tips[port].extraction) is not None:
            solver = tips[port].body.inverse(known.s**2, solver=linear)
            tips[port] = tips[port].at_impact(known.radius, solver)
    time, slow = model.contact_time, model.slow if model.contact_time else math.inf
    times = {"contact_time": time, "duration": slow}
    space = KrylovSpace(tips, sharpened=True, solver=linear, **times)
    wanted = space.rigid_count + elastic + _TERMS * len(tips)
    found = space.of_all(min(wanted, space.body.n_dofs), model.kind)
    return (only_excited(found) if model.kind in ("AO", "rigid") else found).alone
