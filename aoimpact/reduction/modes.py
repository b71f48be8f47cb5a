"""The classical modal truncation of a body: its lowest natural modes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from ..base import InputError, integer, warn
from ..contact import ContactPoint, refuse_massless
from ..linalg import Solver, checked_solver, lowest, warn_of_rounding
from .body import Body, checked_ports, of_modes
from .star import excited


def modal(tips: ContactPoint | Sequence[ContactPoint], n: int, *, solver: Solver = "auto") -> Body:
    """Return the classical modal truncation of a body: its `n` lowest natural modes.

    Parameters
    ----------
    tips : ContactPoint or sequence of ContactPoint
        Where it is touched, from `FEModel.contact`: one place, or several of one body.
    n : int
        Number of modes, rigid ones included, 1 … n_dofs.
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        The linear solver for what is too large for dense matrices; see `FEModel.inverse`.

    Returns
    -------
    Body

    Raises
    ------
    InputError
        If `n` is out of range, or there are fewer modes, the other motions having no mass; if the
        tips are not on one body, or act on dofs without mass.

    Warns
    -----
    AOImpactWarning
        If `n` takes in some of the rigid motions only.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> end, middle = (bar.contact(point=(x, 0.005, 0.01)) for x in (0.09, 0.05))
    >>> ao.modal(end, n=8).frequencies.shape
    (8,)
    >>> ao.modal([end, middle], n=8).participation.shape
    (2, 8)
    """
    ports = checked_ports("tips", tips)
    refuse_massless(ports)
    body = ports[0].body
    wanted = integer("n", n, low=1, high=body.n_dofs)
    invert = partial(body.inverse, solver=checked_solver(solver))
    rigid = body.rigid_modes.shape[1]
    if wanted < rigid:
        warn(
            f"n={n} takes in some of {rigid} rigid motions, and the force depends on which; take "
            f"n={rigid} or more"
        )
    omega2, modes = lowest(body.K, body.M, wanted, known=body.rigid_modes, invert=invert)
    warn_of_rounding(body.K, modes[:, rigid:], f"{len(omega2) - rigid} elastic modes")
    if len(omega2) < wanted:
        raise InputError(
            f"n must be at most {len(omega2)}, got {n}: the other motions have no mass"
        )
    found = of_modes(ports, omega2, modes, kind="modal")
    if len(ports) == 1:
        excited(found)  # or it is refused
    return found


def all_modes(tips: tuple[ContactPoint, ...]) -> Body:
    """Return the model of all natural modes of a body, at the cost of finding these."""
    refuse_massless(tips)
    body = tips[0].body
    omega2, modes = lowest(body.K, body.M, body.n_dofs, known=body.rigid_modes)
    return of_modes(tips, omega2, modes, kind="modal", linear_solver="dense eigensolver")
