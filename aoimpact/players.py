"""The kinds of body that meet in an impact, each as the core steps it.

The ladder: a rigid mass, a star of anti-oscillators, a modal truncation (run as the star that it is
in other coordinates), and the finite-element model itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .contact import ContactPoint
from .errors import InputTypeError
from .modes import ModalModel
from .newmark import Newmark
from .reduction import antioscillators
from .solvers import factorize
from .star import AOModel
from .statics import moves_rigidly, static_mode, translates

__all__ = ["FullPlayer", "Player", "StarPlayer", "player"]

FloatArray = npt.NDArray[np.float64]


class Player(Protocol):
    """A body with an initial velocity, about to take part in an impact."""

    @property
    def label(self) -> str: ...
    @property
    def mass(self) -> float | None: ...
    @property
    def held(self) -> bool: ...
    @property
    def static_mass(self) -> float: ...
    @property
    def unseen(self) -> tuple[float, float]:
        """Share of the centre of mass's velocity, and mass, that the model leaves out."""
        ...

    @property
    def star(self) -> AOModel:
        """The body as a star: as it is, or with all of its anti-oscillators."""
        ...

    def for_core(self, rule: Newmark, dt: float) -> tuple[Any, ...]: ...


@dataclass(frozen=True, eq=False)
class StarPlayer:
    """A star moving with one velocity, m/s, at the start."""

    model: AOModel
    velocity: float

    @property
    def label(self) -> str:
        return self.model.label

    @property
    def mass(self) -> float:
        return self.model.mass

    @property
    def held(self) -> bool:
        return self.model.held

    @property
    def static_mass(self) -> float:
        return self.model.static_mass

    @property
    def star(self) -> AOModel:
        return self.model

    @property
    def unseen(self) -> tuple[float, float]:
        """A free body hit off its centre also moves in ways that its star does not contain."""
        if self.model.origin is None or not self.model.origin.translates:
            return 0.0, 0.0
        seen = float(self.model.centre_weights.sum())
        return 1.0 - seen, self.model.mass - self.model.static_mass

    def for_core(self, rule: Newmark, dt: float) -> tuple[Any, ...]:
        star = self.model
        return (
            "star",
            star.m0,
            star.k0,
            star.m,
            star.k,
            np.ascontiguousarray(star.centre_weights),
            np.zeros(star.n + 1),
            np.full(star.n + 1, self.velocity),
        )


@dataclass(frozen=True, eq=False)
class FullPlayer:
    """A finite-element body; at the start it translates where it may, else it moves in φ_st."""

    tip: ContactPoint
    velocity: float

    @property
    def label(self) -> str:
        return f"full({self.tip.body.n_dofs})"

    @property
    def mass(self) -> float | None:
        return self.tip.body.mass

    @cached_property
    def held(self) -> bool:
        return not moves_rigidly(self.tip)

    @cached_property
    def static_mass(self) -> float:
        return static_mode(self.tip).mass

    @cached_property
    def star(self) -> AOModel:
        return antioscillators(self.tip)

    @property
    def unseen(self) -> tuple[float, float]:
        return 0.0, 0.0

    @cached_property
    def _centre(self) -> FloatArray:
        if self.tip.direction is not None:
            return np.ascontiguousarray(self.tip.body.com_functional(self.tip.direction))
        static = static_mode(self.tip)
        return static.m_phi / static.mass

    def _start(self) -> FloatArray:
        if self.velocity == 0.0:
            return np.zeros(self.tip.body.n_dofs)
        if self.tip.direction is not None and translates(self.tip):
            return self.velocity * self.tip.body.translation(self.tip.direction)
        return self.velocity * static_mode(self.tip).phi

    @cached_property
    def _matrices(self) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        return _rows(self.tip.body.K), _rows(self.tip.body.M)

    def for_core(self, rule: Newmark, dt: float) -> tuple[Any, ...]:
        body = self.tip.body
        factors = factorize(body.M + rule.beta * dt**2 * body.K, what="M + β dt² K")
        return (
            "full",
            *self._matrices,
            np.ascontiguousarray(self.tip.b),
            factors.for_core(),
            self._centre,
            np.zeros(body.n_dofs),
            self._start(),
        )


def _rows(matrix: Any) -> tuple[Any, ...]:
    csr = matrix.tocsr()
    return csr.indptr.astype(np.int32), csr.indices.astype(np.int32), csr.data


def player(name: str, body: Any, velocity: float) -> Player:
    """Return the player for what a caller handed over as projectile or target.

    Raises
    ------
    InputTypeError
        If `body` is none of AOModel, ModalModel and ContactPoint.
    """
    if isinstance(body, AOModel):
        return StarPlayer(body, velocity)
    if isinstance(body, ModalModel):
        return StarPlayer(body.star, velocity)
    if isinstance(body, ContactPoint):
        return FullPlayer(body, velocity)
    raise InputTypeError(
        f"{name} must be an AOModel (antioscillators, rigid), a modal model, or a ContactPoint "
        f"(body.contact(...), the full model), got {body!r}"
    )
