"""Forces of supports and springs on a body over time; see `fem.grounding` for the principle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import FloatArray, IntArray
from ..fem import Damping, Grounding, Rayleigh, VirtualMotion, displacement
from ..integrate import Motion
from ..reduction import Recovery


@dataclass(frozen=True, eq=False)
class Held:
    """A held body in a run, and the forces of the ground on it.

    Attributes
    ----------
    grounding : Grounding
    motion : Motion
        Of the reduced model's coordinates, or of the body's own dofs.
    recovery : Recovery or None
        None where `motion` has the dofs.
    damping : Damping or None
        That of modes acts on the free dofs alone.
    gravity : ndarray, shape (3,)
        m/s².
    """

    grounding: Grounding
    motion: Motion
    recovery: Recovery | None
    damping: Damping | None
    gravity: FloatArray

    def work(self, of: VirtualMotion, times: FloatArray) -> FloatArray:
        """Return what the ground's forces do along m motions of it, N or N m, shape (m, times)."""
        own = (of.weight @ self.gravity)[:, None]
        if self.recovery is None:
            return self._by_rows(of.ground.T, of.springs.T, times) - own
        found: FloatArray = (of.inertia.T @ self.recovery.model.modes) @ self._accelerations(times)
        return found - (of.phi.T @ self.recovery.loads) @ self.motion.force(times) - own

    def at_nodes(self, nodes: IntArray, times: FloatArray) -> FloatArray:
        """Return the forces of the ground on nodes, N, shape (times, nodes, 3)."""
        body, held = self.grounding.body, self.grounding.held
        assert body.nodes is not None
        assert body.free is not None
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        fixed, free = np.isin(held, dofs), np.flatnonzero(np.isin(body.free, dofs))
        count = np.count_nonzero(fixed)
        ground, springs = (np.zeros((count + len(free), len(of))) for of in (held, body.free))
        ground[:count] = np.eye(len(held))[fixed]
        if body.springs is not None:
            springs[count + np.arange(len(free)), free] = body.springs[free]
        if self.recovery is None:
            forces = self._by_rows(ground, springs, times)
        else:
            # K⁻¹ of the forces less the inertia, each without its part that moves the body as one.
            r, M, modes = body.rigid_modes, body.M, self.recovery.model.modes
            columns = np.hstack([self.recovery.loads, -(M @ modes)])
            columns = columns - M @ (r @ (r.T @ columns))
            moved = [displacement(body, one.copy(), body.inverse) for one in columns.T]
            a = self._accelerations(times)
            forces = self._stiffness(ground, springs) @ np.stack(moved, axis=1)
            forces = forces @ np.vstack([self.motion.force(times), a])
            forces += (self._mass(ground) @ modes) @ a
        forces[:count] -= (self.grounding.inertia[fixed] @ self.gravity)[:, None]
        found = np.zeros((self.grounding.M.shape[1], len(times)))
        found[np.concatenate([held[fixed], body.free[free]])] = forces
        return np.asarray(found[dofs].T.reshape(len(times), len(nodes), 3))

    def _stiffness(self, ground: FloatArray, springs: FloatArray) -> FloatArray:
        return np.asarray(ground @ self.grounding.K - springs)

    def _mass(self, ground: FloatArray) -> FloatArray:
        return np.asarray(ground @ self.grounding.M[:, self.grounding.body.free])

    def _accelerations(self, times: FloatArray) -> FloatArray:
        """q̈ + α q̇ of the reduced model, from the forces on it, shape (n, times).

        Modal damping acts on the free dofs, and so is left out: M Ẍ + C Ẋ is what is wanted.
        """
        assert self.recovery is not None
        model = self.recovery.model
        q, rates = self.motion.observed(None, times)
        if isinstance(self.damping, Rayleigh):
            q = q + self.damping.beta * rates
        pushed = (model.modes.T @ self.recovery.loads) @ self.motion.force(times)
        found: FloatArray = pushed - model.omega[:, None] ** 2 * q
        return found

    def _by_rows(self, ground: FloatArray, springs: FloatArray, times: FloatArray) -> FloatArray:
        """The forces from K X + C Ẋ + M Ẍ of the constrained dofs, and from the springs' own."""
        stiffness, mass = self._stiffness(ground, springs), self._mass(ground)
        u, v = self.motion.observed(stiffness, times)
        found: FloatArray = u + self.motion.acceleration(mass, times)
        if isinstance(self.damping, Rayleigh):
            found = found + self.damping.beta * v
            found = found + self.damping.alpha * self.motion.observed(mass, times)[1]
        return found
