"""The field under a contact: the half-space's in closed form, in place of the mesh's own.

A contact force F on a patch moves the elements about it as they can. Of that, F times
`Extraction.mesh_field` stands for the field u_B of a half-space under Hertz's pressure, which is
known in closed form for the present radius of the contact. It is put in place of the mesh's, so
that displacement and stress are right under the contact, however large the elements are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import FloatArray, IntArray
from ..contact import Extraction
from ..fem import SIX
from ..scene import Scenario, extraction_of

# Radius of a contact, over that of the patch, below which the force counts as one at a point: far
# from it, closed forms would lose digits as the square of the distance over the radius.
_NARROWEST = 1e-2

# Places and times that are worked on at once: some 100 MB.
_AT_ONCE = 50_000

# A rate is the difference over this share of the force.
_STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Indentation:
    """The half-space's field at one contact point of a body.

    Attributes
    ----------
    port : int
        Number of the contact point.
    extraction : Extraction
    inward : float
        1 where a positive force on the port pushes into the body, else -1.
    width : callable
        Radius of the contact, m, under forces, N, shape (n,).
    """

    port: int
    extraction: Extraction
    inward: float
    width: Callable[[FloatArray], FloatArray]

    def pressing(self, forces: FloatArray) -> FloatArray:
        """Return what presses into the body, N, shape (n,), of the forces on all ports, (p, n)."""
        return np.asarray(np.maximum(self.inward * forces[self.port], 0.0))

    def mesh_field(self, free: IntArray) -> FloatArray:
        """Return the mesh's own field under 1 N on some dofs, m, shape (n_dofs,)."""
        return np.asarray(self.extraction.mesh_field.reshape(-1)[free])

    def at(self, x: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return displacement, m, (n, p, 3), and stress, Pa, (n, p, 6), at places (p, 3)."""
        u, stress = np.zeros((len(force), len(x), 3)), np.zeros((len(force), len(x), 6))
        pressed = np.flatnonzero(force > 0.0)
        for i in np.array_split(pressed, 1 + len(pressed) * len(x) // _AT_ONCE):
            width = np.maximum(self.width(force[i]), _NARROWEST * self.extraction.radius)
            moved, tensor = self.extraction.splitting.half_space_field(x, width)
            u[i] = force[i, None, None] * moved
            stress[i] = force[i, None, None] * tensor[..., *SIX]
        return u, stress

    def rate(self, x: FloatArray, force: FloatArray, rate: FloatArray) -> FloatArray:
        """Return the rate of the displacement, m/s, (n, p, 3), where the force has that rate."""
        more, less = (self.at(x, (1.0 + step) * force)[0] for step in (_STEP, -_STEP))
        change = np.divide(rate, 2.0 * _STEP * force, out=np.zeros_like(rate), where=force > 0.0)
        return np.asarray((more - less) * change[:, None, None])


def indentations(plan: Scenario, body: int) -> tuple[Indentation, ...]:
    """Return the fields of a body's contacts in a plan, one for each of its contact points."""
    found: dict[int, Indentation] = {}
    model = plan.bodies[body]
    for contact in plan.contacts:
        port = contact.port_of(body)
        if not contact.touches(body) or port in found:
            continue
        known, tip = extraction_of(contact.law, model, port), model.touched_at(port)
        if tip is None or tip.direction is None or not isinstance(known, Extraction):
            continue  # of a shell the mesh's own field is all that is known
        if tip.body.mesh is None or tip.body.mesh.thin:
            continue  # shells beside the solids take the mesh's own field as well
        inward = float(np.sign(known.splitting.frame[2] @ tip.direction))
        round_contact, radius = plan.round_contact(contact), known.radius

        def constant(force: FloatArray, radius: float = radius) -> FloatArray:
            return np.full(len(force), radius)

        width = constant if round_contact is None else round_contact.width
        found[port] = Indentation(port, known, inward, width)
    return tuple(found.values())
