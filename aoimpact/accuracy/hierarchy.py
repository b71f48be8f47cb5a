"""The model hierarchy of a body: reduced models of rising order, from rigid to the whole body.

The bases are nested: every order up to the largest that was made costs no further linear solve.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property
from threading import RLock
from typing import Any

import numpy as np

from ..fem import ContactPoint, moves_rigidly, shortest_contact_time
from ..linalg import LinearSolver, Solver
from ..reduction import (
    AOModel,
    BodyModel,
    FullModel,
    InterfaceModel,
    InterfaceSpace,
    KrylovSpace,
    antioscillators,
    rigid,
)

Model = AOModel | InterfaceModel
Models = tuple[Model, ...]

# A body of at most this many dofs is its own reference where the reference would take more than
# this share of its dofs as Krylov vectors: the full body is then faster.
_SMALL_BODY = 1500
_SHARE_OF_DOFS = 0.1

# Oscillators of the model by which a body is checked for modes slower than the contact.
_FEW = 6


_sharing: ContextVar[bool] = ContextVar("sharing", default=False)


@contextmanager
def shared_models() -> Iterator[None]:
    """Let impacts that are alike share patches and models: see `alike`."""
    token = _sharing.set(True)
    try:
        yield
    finally:
        _sharing.reset(token)


def alike(scale: float, *, up: bool = False) -> float:
    """Return a time or length that models are fitted to; among many impacts one near it.

    Among these it is a power of two, whatever the other impacts are. Patches up to five times as
    wide as the contact give the same force to 0.1 %; a factor of two or three in the contact time
    does not matter (`KrylovSpace`), and this one is 1.4.

    Parameters
    ----------
    scale : float
        s, or m.
    up : bool, optional
        True for one that is not less.

    Returns
    -------
    float
        In the same unit.
    """
    if not _sharing.get() or not 0.0 < scale < math.inf:
        return scale
    octave = math.log2(scale)
    return float(2.0 ** (math.ceil(octave) if up else round(octave)))


class Hierarchy(ABC):
    """One body's models of rising order: 0 is rigid (a fixed wall, if the body is constrained)."""

    @property
    @abstractmethod
    def first(self) -> int:
        """The order of the model without oscillators: 0, of a constrained body 1."""

    @abstractmethod
    def model(self, order: int) -> Model:
        """Return the model to run; it need not give the body's own displacements."""

    def finished(self, order: int) -> Model:
        """Return the model for the caller."""
        return self.model(order)

    @abstractmethod
    def at_most(self, order: int) -> int:
        """Return the order itself, or the largest that there is, if that is less."""

    def reference_order(self, order: int) -> int:
        """Return the order of a reference no smaller than that: itself, or the whole body's."""
        return order

    def is_whole(self, order: int) -> bool:
        """True if the model of this order has the body's exact response at its contact."""
        return self.at_most(order + 1) == self.at_most(order)


@dataclass(eq=False)
class AOHierarchy(Hierarchy):
    """The truncations of an AO model given by numbers, or of a modal model."""

    whole: AOModel

    @property
    def first(self) -> int:
        return 1 if self.whole.constrained else 0

    def model(self, order: int) -> AOModel:
        kept = self.at_most(order)
        if kept == 0:
            return _rigid(self.whole.truncated(0))
        return self.whole.truncated(kept - self.first)

    def at_most(self, order: int) -> int:
        return 0 if math.isinf(self.whole.m0) else min(order, self.whole.n + self.first)

    def reference_order(self, order: int) -> int:
        return self.at_most(self.whole.n + self.first)  # it costs nothing


@dataclass(eq=False)
class FixedModel(Hierarchy):
    """A model that stays as it is."""

    given: Any
    first: int = 0

    def model(self, order: int) -> Any:
        return self.given

    def at_most(self, order: int) -> int:
        return 0

    def reference_order(self, order: int) -> int:
        return 0


@dataclass(eq=False)
class ElementHierarchy(Hierarchy):
    """A finite-element body: models that are fitted to a scene, each made once.

    Attributes
    ----------
    tips : tuple of ContactPoint
    contact_time : float
        That the models are fitted to, s.
    duration : float or None
        How long their motion must be right after that, s.
    solver : str or callable
        The linear solver.
    known : LinearSolver or None
        One that has been set up; see `KrylovSpace`.
    """

    tips: tuple[ContactPoint, ...]
    contact_time: float
    duration: float | None
    solver: Solver = "auto"
    known: LinearSolver | None = None
    _most: int = field(init=False)
    _models: dict[int, Any] = field(init=False, default_factory=dict)
    _lock: Any = field(init=False, default_factory=RLock)

    def __post_init__(self) -> None:
        self._most = self.dofs

    @property
    def dofs(self) -> int:
        """Number of degrees of freedom of the body."""
        return self.tips[0].body.n_dofs

    @property
    def resolved(self) -> float:
        """The contact time, s, or the shortest that the mesh resolves."""
        return max(self.contact_time, *map(shortest_contact_time, self.tips))

    def model(self, order: int) -> Any:
        with self._lock:  # many impacts share it, in several threads
            order = self.at_most(order)
            if order not in self._models:
                self._models[order], exhausted = self._made(order)
                if exhausted:
                    self._most = order
            return self._models[order]

    @cached_property
    @abstractmethod
    def _space(self) -> KrylovSpace | InterfaceSpace:
        """The space from which the models are made."""

    def release(self) -> None:
        """Give back memory that only larger models need."""
        with self._lock:  # another thread may be making one
            if "_space" in vars(self):
                self._space.release()

    @abstractmethod
    def _made(self, order: int) -> tuple[Model, bool]:
        """The model, and whether there is none of a higher order."""

    def at_most(self, order: int) -> int:
        return min(order, self._most)


class KrylovHierarchy(ElementHierarchy):
    """A body touched in one place: AO models, and the whole body where it is small."""

    @cached_property
    def _space(self) -> KrylovSpace:
        space = KrylovSpace(
            self.tips[0],
            contact_time=self.resolved,
            sharpened=True,
            solver=self.solver,
            known=self.known,
        )
        self.known = None  # the space keeps it as long as it is needed
        if self.duration is not None:
            # A second factorisation, where the body has any mode slower than the contact.
            natural = space.of_vectors(_FEW).natural_frequencies
            if (natural > 0.0).any() and 2.0 * np.pi * natural[natural > 0.0][0] < space.shift:
                space.include(self.duration)
        return space

    @cached_property
    def first(self) -> int:
        return 0 if moves_rigidly(self.tips[0]) else 1

    def finished(self, order: int) -> AOModel:
        return self.model(order).multiplied_out  # type: ignore[no-any-return]

    def _made(self, order: int) -> tuple[AOModel, bool]:
        tip = self.tips[0]
        if order < self.first:
            return rigid(mass=math.inf, name=tip.name), False
        if order == self.dofs <= _SMALL_BODY:
            return antioscillators(tip, order="frequency"), False
        model = self._space.factored(order - self.first)
        return model if order > 0 else _rigid(model), self._space.exhausted

    def reference_order(self, order: int) -> int:
        small = self.dofs <= _SMALL_BODY
        return self.dofs if small and order > _SHARE_OF_DOFS * self.dofs else order


def _rigid(model: AOModel) -> AOModel:
    """A model without oscillators as a rigid body: a wall, if it is constrained."""
    return rigid(mass=math.inf, name=model.name) if model.k0 > 0.0 else model


class InterfaceHierarchy(ElementHierarchy):
    """A body touched in several places: as many vectors for each as the order.

    A constrained one has at least one vector for each place, and is no wall.
    """

    @cached_property
    def _space(self) -> InterfaceSpace:
        return InterfaceSpace(
            self.tips,
            contact_time=self.resolved,
            duration=self.duration,
            sharpened=True,
            solver=self.solver,
        )

    @cached_property
    def first(self) -> int:
        return 0 if self._space.rigid_count else 1

    def _made(self, order: int) -> tuple[InterfaceModel, bool]:
        vectors = self._space.rigid_count + max(order, self.first) * len(self.tips)
        return self._space.of_vectors(min(vectors, self.dofs)), self._space.exhausted


def model_hierarchy(
    body: BodyModel,
    contact_time: float,
    duration: float | None,
    solver: Solver = "auto",
    known: LinearSolver | None = None,
) -> Hierarchy:
    """Return the models of what `simulate` or a scene takes for a body.

    Parameters
    ----------
    body : AOModel, FullModel, InterfaceModel or Hierarchy
        Models of other kinds stay as they are.
    contact_time : float
        That the models are fitted to, s.
    duration : float, optional
        How long their motion must be right after that, s.
    solver : str or callable, optional
        The linear solver.
    known : LinearSolver, optional
        One of a body touched in one place that has been set up; see `KrylovSpace`.
    """
    if isinstance(body, Hierarchy):
        return body
    if isinstance(body, AOModel):
        return AOHierarchy(body)
    if not isinstance(body, FullModel):
        return FixedModel(body)
    kind = KrylovHierarchy if len(body.tips) == 1 else InterfaceHierarchy
    return kind(body.tips, contact_time, duration, solver, known)


def only_models(bodies: Sequence[Any]) -> Models | None:
    """Return the models of bodies that have only one each, such as rigid ones.

    None where there is a choice, as for a contact point.

    Parameters
    ----------
    bodies : sequence
        As of `model_hierarchy`.
    """
    every = [model_hierarchy(body, math.nan, None) for body in bodies]
    return (
        tuple(one.finished(0) for one in every) if all(one.is_whole(0) for one in every) else None
    )
