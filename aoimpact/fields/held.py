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
        found = np.zeros((self.grounding.M.shape[1], len(times)))
        own = self.grounding.inertia[fixed] @ self.gravity
        stiff = np.zeros((len(free), len(body.free)))
        if body.springs is not None:
            stiff[np.arange(len(free)), free] = body.springs[free]
        ground = np.eye(len(held))[fixed]
        if self.recovery is None:
            supports = self._by_rows(ground, np.zeros((len(ground), len(body.free))), times)
            springs = self._by_rows(np.zeros((len(free), len(held))), stiff, times)
        else:
            # K⁻¹ of the forces less the inertia, each without its part that moves the body as one.
            r, M = body.rigid_modes, body.M
            inertia = M @ self.recovery.model.modes
            columns = np.hstack([self.recovery.loads, -inertia])
            columns = columns - M @ (r @ (r.T @ columns))
            moved = np.stack(
                [displacement(body, one.copy(), body.inverse) for one in columns.T], axis=1
            )
            a = self._accelerations(times)
            causes = np.vstack([self.motion.force(times), a])
            rows = self.grounding.M[fixed][:, body.free]
            supports = (self.grounding.K[fixed] @ moved) @ causes + (
                rows @ self.recovery.model.modes
            ) @ a
            springs = -(stiff @ moved) @ causes
        found[held[fixed]] = supports - own[:, None]
        found[body.free[free]] = springs
        return np.asarray(found[dofs].T.reshape(len(times), len(nodes), 3))

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
        free = self.grounding.body.free
        stiffness = ground @ self.grounding.K - springs
        mass = ground @ self.grounding.M[:, free]
        u, v = self.motion.observed(stiffness, times)
        found: FloatArray = u + self.motion.acceleration(mass, times)
        if isinstance(self.damping, Rayleigh):
            found = found + self.damping.beta * v
            found = found + self.damping.alpha * self.motion.observed(mass, times)[1]
        return found
