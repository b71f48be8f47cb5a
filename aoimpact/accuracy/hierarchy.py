"""A body's models of rising order, from rigid to the whole: their bases are nested.

Every order up to the largest looked at is made of the vectors of that one, and costs no solve.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from ..fem import ContactPoint, moves_rigidly
from ..linalg import Solver
from ..reduction import (
    AOModel,
    InterfaceModel,
    InterfaceSpace,
    KrylovSpace,
    ModalModel,
    antioscillators,
    rigid,
    shortest_contact_time,
)

__all__ = [
    "GivenLadder",
    "InterfaceLadder",
    "KrylovLadder",
    "Ladder",
    "Model",
    "Models",
    "StarLadder",
    "ladder",
]

Model = AOModel | InterfaceModel
Models = tuple[Model, ...]

# Where it takes more vectors of a small body than this share of its dofs to tell the truth, the
# body itself is quicker.
_SMALL_BODY = 1500
_SHARE_OF_DOFS = 0.1

# Beyond this a larger truth costs more than a model somewhat larger than the least.
_CHEAP_ORDER = 40

# Oscillators that tell whether a body has anything slower than the blow.
_FEW = 6


class Ladder(Protocol):
    """One body's models of rising order: 0 is rigid (a fixed wall, if the body is held)."""

    @property
    def first(self) -> int:
        """The order of the model without oscillators: a held body's is a step above a wall."""
        ...

    def model(self, order: int) -> Model:
        """The model, to be run; what its body does need not be known yet."""
        ...

    def finished(self, order: int) -> Model:
        """The model, to be handed out."""
        ...

    def at_most(self, order: int) -> int:
        """The order itself, or the largest that there is, if that is less."""
        ...

    def stand_in(self, order: int) -> int:
        """The order to stand for the truth where this one might: itself, or the whole body's."""
        ...

    def is_whole(self, order: int) -> bool:
        """Whether the model of this order is the body itself, as seen from its contact."""
        ...

    def is_costly(self, order: int) -> bool:
        """Whether a larger model costs more than it may save."""
        ...


@dataclass(eq=False)
class StarLadder:
    """A star given by numbers, or a modal model: its truncations."""

    star: AOModel

    @property
    def first(self) -> int:
        return 1 if self.star.held else 0

    @property
    def _most(self) -> int:
        return self.star.n + self.first

    def model(self, order: int) -> AOModel:
        kept = self.at_most(order)
        if kept == 0:
            return _rigid(self.star.truncated(0))
        return self.star.truncated(kept - self.first)

    finished = model

    def at_most(self, order: int) -> int:
        return 0 if math.isinf(self.star.m0) else min(order, self._most)

    def stand_in(self, order: int) -> int:
        return self.at_most(order)

    def is_whole(self, order: int) -> bool:
        return self.at_most(order + 1) == self.at_most(order)

    def is_costly(self, order: int) -> bool:
        return False


@dataclass(eq=False)
class GivenLadder:
    """A model that stays as it is."""

    given: InterfaceModel
    first: int = 0

    def model(self, order: int) -> InterfaceModel:
        return self.given

    finished = model

    def at_most(self, order: int) -> int:
        return 0

    def stand_in(self, order: int) -> int:
        return 0

    def is_whole(self, order: int) -> bool:
        return True

    def is_costly(self, order: int) -> bool:
        return False


@dataclass(eq=False)
class KrylovLadder:
    """A finite-element body: scene-fitted models, and the whole body where it is small."""

    tip: ContactPoint
    contact_time: float
    duration: float | None
    solver: Solver = "auto"
    _most: int = field(init=False)
    _models: dict[int, AOModel] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._most = self.tip.body.n_dofs

    @cached_property
    def _space(self) -> KrylovSpace:
        resolved = max(self.contact_time, shortest_contact_time(self.tip))
        space = KrylovSpace(self.tip, contact_time=resolved, sharpened=True, solver=self.solver)
        if self.duration is not None:
            # A second factorisation, where the body has anything slower than the blow.
            natural = space.of_vectors(_FEW).natural_frequencies
            if (natural > 0.0).any() and 2.0 * np.pi * natural[natural > 0.0][0] < space.shift:
                space.include(self.duration)
        return space

    @cached_property
    def first(self) -> int:
        return 0 if moves_rigidly(self.tip) else 1

    def model(self, order: int) -> AOModel:
        order = self.at_most(order)
        if order not in self._models:
            self._models[order] = self._made(order)
        return self._models[order]

    def finished(self, order: int) -> AOModel:
        return self.model(order).multiplied_out()

    def _made(self, order: int) -> AOModel:
        if order < self.first:
            return rigid(mass=math.inf)
        if self._small and order == self.tip.body.n_dofs:
            return antioscillators(self.tip, order="frequency")
        star = self._space.seen(order - self.first)
        if self._space.exhausted:
            self._most = order
        return star if order > 0 else _rigid(star)

    def at_most(self, order: int) -> int:
        return min(order, self._most)

    def stand_in(self, order: int) -> int:
        dofs = self.tip.body.n_dofs
        return dofs if self._small and order > _SHARE_OF_DOFS * dofs else order

    @property
    def _small(self) -> bool:
        return self.tip.body.n_dofs <= _SMALL_BODY

    def is_whole(self, order: int) -> bool:
        return order >= self._most

    def is_costly(self, order: int) -> bool:
        return order > _CHEAP_ORDER and not self._small


def _rigid(star: AOModel) -> AOModel:
    """A model without oscillators as a body that does not deform, not under a patch either."""
    if star.held:
        return rigid(mass=math.inf)
    if star.origin is None or star.origin.tip.patch is None:
        return star
    tip = replace(star.origin.tip, patch=None)  # else its indentation is taken out of the law
    return replace(star, origin=replace(star.origin, tip=tip))


@dataclass(eq=False)
class InterfaceLadder:
    """A finite-element body touched in several places: as many vectors for each as the order.

    Held, it has at least one for each, and is no wall.
    """

    tips: tuple[ContactPoint, ...]
    contact_time: float
    duration: float | None
    solver: Solver = "auto"
    _most: int = field(init=False)
    _models: dict[int, InterfaceModel] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._most = self.tips[0].body.n_dofs

    @cached_property
    def _space(self) -> InterfaceSpace:
        resolved = max(self.contact_time, *map(shortest_contact_time, self.tips))
        return InterfaceSpace(
            self.tips,
            contact_time=resolved,
            duration=self.duration,
            sharpened=True,
            solver=self.solver,
        )

    @cached_property
    def first(self) -> int:
        return 0 if self._space.rigid_count else 1

    def model(self, order: int) -> InterfaceModel:
        order = self.at_most(order)
        if order not in self._models:
            vectors = self._space.rigid_count + max(order, self.first) * len(self.tips)
            self._models[order] = self._space.of_vectors(min(vectors, self.tips[0].body.n_dofs))
            if self._space.exhausted:
                self._most = order
        return self._models[order]

    finished = model

    def at_most(self, order: int) -> int:
        return min(order, self._most)

    def stand_in(self, order: int) -> int:
        return order

    def is_whole(self, order: int) -> bool:
        return order >= self._most

    def is_costly(self, order: int) -> bool:
        dofs = self.tips[0].body.n_dofs
        return order * len(self.tips) > _CHEAP_ORDER and dofs > _SMALL_BODY


def ladder(
    body: Any, contact_time: float, duration: float | None, solver: Solver = "auto"
) -> Ladder:
    """Return the models of what `simulate` or a scene takes for a body.

    An interface model is as it is.
    """
    if isinstance(body, ContactPoint):
        return KrylovLadder(body, contact_time, duration, solver)
    if isinstance(body, tuple):
        return InterfaceLadder(body, contact_time, duration, solver)
    if isinstance(body, InterfaceModel):
        return GivenLadder(body)
    return StarLadder(body.star if isinstance(body, ModalModel) else body)
