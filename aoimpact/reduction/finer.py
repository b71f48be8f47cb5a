"""A model of the refined body, for estimates of the errors due to mesh and reduction.

The model is the Ritz model of the refined body (fem/finer.py) in three sets of vectors: those of
the given model; for each contact, the first members of the sequence (K + s²M)⁻¹ b,
(K + s²M)⁻¹ M (K + s²M)⁻¹ b, … of the body as meshed, unless the model has them; and approximate
responses of the refined body to the forces left unbalanced by each mode and by the first member.
These responses are one step of inverse iteration from all modes at once, with the shift of the
first contact.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..contact import SHIFT_TIMES_DURATION, own_contact_time
from ..linalg import ROUGH, Solver, m_orthonormal, rows_of
from .body import Body, of_modes
from .krylov import KrylovSpace, only_excited

# Number of members of the sequence; for shells and beams, number of vectors beyond those of the
# given model. The estimated error of histories is 0.6 times the true error with one member, for a
# model of 8 vectors, and 0.8 to 5 times with 12 members, for models of 3 to 16 vectors
# (tests/accuracy/test_finer.py).
_TERMS = 12


def finer_model(model: Body, *, linear: Solver = "auto") -> Body:
    """Return a model of the refined body, or one of more vectors if the body cannot be refined.

    Parameters
    ----------
    model : Body
        Model of a body of n dofs.
    linear : str or callable, optional
        The linear solver; see `FEModel.inverse`.

    Returns
    -------
    Body
        Model of the refined body, whose first n dofs are those of the given body. Its contact
        points have an `extraction` if those of the given model have one.
    """
    finer = model.body.finer
    if finer is None or finer.mesh is not model.body.mesh:
        return _fitted_alike(model, linear)
    n, rigid, modes = model.body.n_dofs, model.body.rigid_modes, model.modes
    # Columns of K and M of the dofs of the given body.
    K, M = (rows_of(of, 0, n).T for of in (finer.K, finer.M))
    own_M, elastic = M.T[:, :n], model.omega > 0.0
    tips = [own.finer or own for own in model.tips]
    pressed = []
    members = [np.zeros((n, 0))]
    changes = []
    loads = [(M @ modes * model.omega**2 - K @ modes)[:, elastic]]
    each = model.ports // model.places
    for port, (own, tip) in enumerate(zip(model.tips, tips, strict=True)):
        if port % each == 0:
            known = own.extraction
            time = model.contact_time or own_contact_time(own)
            s = known.s if known else SHIFT_TIMES_DURATION / time
            solver = finer.inverse(s * s, solver=linear)
            if known is not None:
                pressed.append((port, s, known.radius, solver))
        first = model.deflection(s, port)
        left = tip.b - K @ first - s * s * (M @ first)
        # Models that contain the sequence leave less than the residual of their solutions.
        unbalanced = np.linalg.norm(left[:n]) > ROUGH * np.linalg.norm(tip.b)
        if unbalanced or np.count_nonzero(elastic) < _TERMS * model.ports:
            moved = rigid @ (rigid.T @ tip.b[:n])
            coarse, load = finer.given.inverse(s * s, solver=linear), tip.b[:n] - own_M @ moved
            for _ in range(_TERMS):
                x, _, load = coarse.solve_roughly(load, solver.rough)
                members.append(x[:, None])
                load /= np.linalg.norm(load) or 1.0
            first = members[-_TERMS][:, 0] + moved / s**2
            left = tip.b - K @ first - s * s * (M @ first)
        loads.append(left[:, None])
        changes.append(solver.solve_roughly(np.hstack(loads))[0])
        loads = []
    space = np.hstack([rigid, m_orthonormal(rigid, modes, own_M)]) if rigid.shape[1] else modes
    space = np.hstack([space, m_orthonormal(space, np.hstack(members), own_M)])
    forces, space = K @ space, finer.appended(space)
    more = m_orthonormal(space, np.hstack(changes), finer.M)
    forces, space = np.hstack([forces, finer.K @ more]), np.hstack([space, more])
    stiffness = space.T @ forces
    stiffness[: rigid.shape[1]] = stiffness[:, : rigid.shape[1]] = 0.0  # removes rounding errors
    omega2, within = np.linalg.eigh(stiffness)
    found = of_modes(
        tuple(tips),
        np.maximum(omega2, 0.0),
        space,
        within,
        kind=model.kind,
        contact_time=model.contact_time,
        linear_solver=model.linear_solver,
    )
    for port, s, radius, solver in pressed:
        moved = np.array([found.deflection(s, port + axis) for axis in range(each)])
        tips[port] = tips[port].at_impact(radius, solver, moved)
    found = replace(found, tips=tuple(tips))
    return only_excited(found) if model.kind in ("AO", "rigid") else found


def _fitted_alike(model: Body, linear: Solver) -> Body:
    """Return a model of more vectors for the same durations; shell and beam elements are halved."""
    elastic = int(np.count_nonzero(model.omega))
    if not elastic:
        return model
    tips = [tip.finer or tip for tip in model.tips]
    solver = None
    for port in range(0, model.ports, model.ports // model.places):
        if (known := model.tips[port].extraction) is not None:
            solver = tips[port].body.inverse(known.s**2, solver=linear)
            tips[port] = tips[port].at_impact(known.radius, solver)
    slow = model.slow if model.contact_time else math.inf
    times = {"contact_time": model.contact_time, "duration": slow}
    space = KrylovSpace(tips, sharpened=True, solver=linear, **times)
    wanted = space.rigid_count + elastic + _TERMS * len(tips)
    found = space.of_all(min(wanted, space.body.n_dofs), model.kind)
    return (only_excited(found) if model.kind in ("AO", "rigid") else found).alone
