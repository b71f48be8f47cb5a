"""Bodies as Newmark's rule steps them, each in the coordinates in which a step costs least."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray
from ..fem import Rayleigh
from ..linalg import core_rows, factorize

__all__ = ["Equations", "SteppedBody", "SteppedFull", "SteppedModes", "SteppedStar"]


class Equations(NamedTuple):
    """M ü + C u̇ + K u = B f, from u0 and v0.

    Attributes
    ----------
    K, M, C : scipy.sparse arrays, shape (n, n)
    B : ndarray, shape (n, p)
        The ports; under gravity the weight, N, after them.
    u0, v0 : ndarrays, shape (n,)
        At t = 0, m and m/s.
    """

    K: Any
    M: Any
    C: Any
    B: FloatArray
    u0: FloatArray
    v0: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class SteppedBody(ABC):
    """What a run with fixed steps needs of a body.

    Attributes
    ----------
    gravity : ndarray, shape (n,), or None
        Constant forces on the coordinates, N.
    centre : ndarray, shape (n,)
        Functional of the centre of mass's displacement.
    u, v : ndarrays, shape (n,)
        Coordinates and rates at the start; a run overwrites them by those at its end.
    """

    _KIND: ClassVar[str]

    gravity: FloatArray | None
    centre: FloatArray
    u: FloatArray
    v: FloatArray

    @property
    def ports(self) -> int:
        """Number of places where it may be touched."""
        return 1

    def for_core(self, dt: float, beta: float, gamma: float) -> dict[str, Any]:
        """Return it as ``_core.newmark_scene`` takes it: its kind and its parts by name."""
        return {"kind": self._KIND, **vars(self)}

    @property
    def equations(self) -> Equations:
        """Its equations of motion, for any method."""
        K, M, C, ports = self._equations
        columns = ports.reshape(-1, len(self.u)).T
        loads = columns if self.gravity is None else np.column_stack([columns, self.gravity])
        return Equations(K, M, C, loads, self.u.copy(), self.v.copy())

    @property
    @abstractmethod
    def _equations(self) -> tuple[Any, Any, Any, FloatArray]:
        """K, M, C and the functionals of the ports, shape (p, n)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SteppedStar(SteppedBody):
    """An AO model with Rayleigh damping; the contact mass is the first coordinate.

    Attributes
    ----------
    m0, k0 : float
        kg, N/m.
    m, k : ndarrays, shape (n - 1,)
    damping : Rayleigh
    """

    _KIND = "star"

    m0: float
    k0: float
    m: FloatArray
    k: FloatArray
    damping: Rayleigh = field(default_factory=Rayleigh)

    def for_core(self, dt: float, beta: float, gamma: float) -> dict[str, Any]:
        return super().for_core(dt, beta, gamma) | vars(self.damping)

    @property
    def _equations(self) -> tuple[Any, Any, Any, FloatArray]:
        K = sp.diags_array(np.concatenate([[self.k0 + self.k.sum()], self.k])).tolil()
        K[0, 1:] = -self.k
        K[1:, 0] = -self.k
        M = sp.diags_array(np.concatenate([[self.m0], self.m])).tocsr()
        C = self.damping.alpha * M + self.damping.beta * K.tocsr()
        return K.tocsr(), M, C, np.eye(1, len(self.u))


@dataclass(frozen=True, eq=False, kw_only=True)
class SteppedModes(SteppedBody):
    """A body in natural modes of unit mass.

    Attributes
    ----------
    omega, decay : ndarrays, shape (n,)
        rad/s, 1/s.
    shape : ndarray, shape (p, n)
        Displacement of the ports in each mode.
    residual : ndarray, shape (p, p)
        Compliance of the ports beside the modes, m/N.
    residual_forces : ndarray, shape (2, p), or None
        Forces on the residual compliance at the start, N, and their rates, N/s.
    """

    _KIND = "modal"

    omega: FloatArray
    decay: FloatArray
    shape: FloatArray
    residual: FloatArray
    residual_forces: FloatArray | None

    @property
    def ports(self) -> int:
        return self.shape.size // len(self.v)

    @property
    def _equations(self) -> tuple[Any, Any, Any, FloatArray]:
        M = sp.eye_array(len(self.omega), format="csr")
        K, C = (sp.diags_array(of).tocsr() for of in (self.omega**2, 2.0 * self.decay))
        return K, M, C, self.shape


@dataclass(frozen=True, eq=False, kw_only=True)
class SteppedFull(SteppedBody):
    """All degrees of freedom of a finite-element body, with Rayleigh damping.

    Attributes
    ----------
    K, M : scipy.sparse arrays, shape (n, n)
    B : ndarray, shape (p, n)
        The contact functionals.
    damping : Rayleigh
    """

    _KIND = "full"

    K: Any
    M: Any
    B: FloatArray
    damping: Rayleigh

    @property
    def ports(self) -> int:
        return len(self.B)

    def for_core(self, dt: float, beta: float, gamma: float) -> dict[str, Any]:
        of_mass = 1.0 + self.damping.alpha * gamma * dt
        of_stiffness = beta * dt**2 + self.damping.beta * gamma * dt
        matrix = of_mass * self.M + of_stiffness * self.K
        factors = factorize(matrix, what="M + γ dt C + β dt² K").for_core()
        parts = {"K": core_rows(self.K), "M": core_rows(self.M), "factors": factors}
        return super().for_core(dt, beta, gamma) | vars(self.damping) | parts

    @property
    def _equations(self) -> tuple[Any, Any, Any, FloatArray]:
        C = self.damping.alpha * self.M + self.damping.beta * self.K
        return self.K, self.M, C, self.B
