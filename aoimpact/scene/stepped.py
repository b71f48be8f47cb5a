"""Bodies for Newmark's rule: in natural modes, or in all degrees of freedom."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from ..base import FloatArray, record, sp
from ..fem import Rayleigh
from ..linalg import core_rows, factorize

PARTS = _core.MODES.split()  # fields of a body in the core's order


class Equations(NamedTuple):
    """Equations of motion M ü + C u̇ + K u = B f, with initial values.

    Attributes
    ----------
    K, M, C : scipy.sparse arrays, shape (n, n)
    B : ndarray, shape (n, p)
        Functionals of the ports; under gravity the weight, N, is one more column.
    u0, v0 : ndarrays, shape (n,)
        Displacements and velocities at t = 0, m and m/s.
    """

    K: Any
    M: Any
    C: Any
    B: FloatArray
    u0: FloatArray
    v0: FloatArray


@record
class SteppedBody:
    """A body in natural modes, and its initial state.

    Attributes
    ----------
    parts : mapping
        Fields of the core's aoi_modes by name; missing fields are None.
    x, v : ndarrays, shape (n,)
        Coordinates at t = 0, and their rates.
    """

    parts: Mapping[str, Any]
    x: FloatArray
    v: FloatArray

    @property
    def ports(self) -> int:
        """Number of contact coordinates."""
        return len(self.parts["shape"])

    def for_core(self, dt: float, beta: float, gamma: float) -> tuple[Any, ...]:
        """Return the core's tuple for steps of `dt`, s, by Newmark's rule with `beta`, `gamma`."""
        return tuple(map(self.parts.get, PARTS))

    @property
    def equations(self) -> Equations:
        """Equations of motion in the body's coordinates."""
        K, M, C = self._matrices
        columns = np.transpose(self.parts["push"])
        gravity = self.parts.get("gravity")
        loads = columns if gravity is None else np.column_stack([columns, gravity])
        return Equations(K, M, C, loads, self.x, self.v)

    @property
    def _matrices(self) -> tuple[Any, Any, Any]:
        """Stiffness, mass and damping matrices K, M and C."""
        omega, decay = self.parts["omega"], self.parts.get("decay")
        damping = np.zeros_like(omega) if decay is None else 2.0 * decay
        K, C = (sp.diags_array(of).tocsr() for of in (omega**2, damping))
        return K, sp.eye_array(len(omega), format="csr"), C


@record
class SteppedFull(SteppedBody):
    """A finite-element body in all its degrees of freedom.

    Attributes
    ----------
    K, M : scipy.sparse arrays, shape (n, n)
    damping : Rayleigh
    """

    K: Any
    M: Any
    damping: Rayleigh

    def for_core(self, dt: float, beta: float, gamma: float) -> tuple[Any, ...]:
        of_mass = 1.0 + self.damping.alpha * gamma * dt
        of_stiffness = beta * dt**2 + self.damping.beta * gamma * dt
        matrix = of_mass * self.M + of_stiffness * self.K
        factors = factorize(matrix, what="M + γ dt C + β dt² K")
        damping = self.damping.alpha, self.damping.beta
        matrices = core_rows(self.K), core_rows(self.M), *damping, factors.of_bytes
        return tuple({**self.parts, "full": matrices}.get(name) for name in PARTS)

    @property
    def _matrices(self) -> tuple[Any, Any, Any]:
        return self.K, self.M, self.damping.alpha * self.M + self.damping.beta * self.K
