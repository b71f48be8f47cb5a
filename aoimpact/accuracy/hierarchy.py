"""The model hierarchy of a body: reduced models of rising order, from rigid to the whole body.

The bases are nested: models of orders below the largest one made need no further linear solve.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cache
from threading import RLock
from typing import Any

import numpy as np

from ..contact import ContactPoint, moves_rigidly, shortest_contact_time
from ..linalg import Solver
from ..reduction import Body, BodyModel, FullModel, KrylovSpace, rigid

Models = tuple[Body, ...]

# Number of oscillators of the model that shows whether a body has modes slower than the contact.
_FEW = 6


_sharing: ContextVar[bool] = ContextVar("sharing", default=False)


@contextmanager
def shared_models() -> Iterator[None]:
    """Let similar impacts share patches and models in a `with` block; see `alike`."""
    token = _sharing.set(True)
    try:
        yield
    finally:
        _sharing.reset(token)


def alike(scale: float, *, up: bool = False) -> float:
    """Return the time or length to fit models to, rounded within `shared_models`.

    Values are rounded to a power of two, so that similar impacts share models and results do not
    depend on other impacts. Patches up to five times as wide as the contact give the same force to
    0.1 %. A factor of two or three in the contact time does not matter (`KrylovSpace`); the factor
    here is at most 1.4.

    Parameters
    ----------
    scale : float
        Time, s, or length, m.
    up : bool, optional
        True to round up.

    Returns
    -------
    float
        Time or length in the same unit.
    """
    if not _sharing.get() or not 0.0 < scale < math.inf:
        return scale
    octave = math.log2(scale)
    return float(2.0 ** (math.ceil(octave) if up else round(octave)))


@dataclass(eq=False)
class Hierarchy:
    """One body's models of rising order; order 0 is rigid, or a fixed wall if it is constrained.

    Attributes
    ----------
    first : int
        Order of the model without oscillators: 0, for a constrained body 1.
    most : int
        Largest order, whose model has the body's exact response at its contact.
    make : callable
        Returns the model of a given order.
    space : callable or None
        Returns the Krylov space of the models, made at the first call. When it contains all motions
        that the ports excite, `most` is lowered to the order reached.
    """

    first: int
    most: int
    make: Callable[[int], Body]
    space: Any = None
    _models: dict[int, Body] = field(init=False, default_factory=dict)
    _lock: Any = field(init=False, default_factory=RLock)

    def model(self, order: int) -> Body:
        """Return the model of an order for a run; it may share vectors with other models."""
        with self._lock:  # many impacts share the hierarchy, in several threads
            order = min(order, self.most)
            if order not in self._models:
                self._models[order] = self.make(order)
                if self._spanned and order >= self.first and self.space().exhausted:
                    self.most = order
            return self._models[order]

    def finished(self, order: int) -> Body:
        """Return the model of an order for the caller to keep; it shares no vectors with others."""
        return self.model(order).alone

    def release(self) -> None:
        """Free memory that only larger models need."""
        with self._lock:  # another thread may be making a model
            if self._spanned:
                self.space().release()

    @property
    def _spanned(self) -> bool:
        """True if the space has been made."""
        return self.space is not None and self.space.cache_info().currsize > 0


def fixed_model(given: Any) -> Hierarchy:
    """Return the hierarchy of a body that has only one model."""
    return Hierarchy(0, 0, lambda order: given)


def truncations(given: Body) -> Hierarchy:
    """Return the hierarchy of a one-port body: its models with the first few anti-oscillators."""
    star, first = given.star, 1 if given.constrained else 0

    def make(order: int) -> Body:
        if order > 0:
            return star.truncated(order - first).modal
        return _rigid(star.truncated(0).modal)

    most = 0 if given.wall else star.n + first
    return Hierarchy(first, most, make)


def _of_elements(
    tips: tuple[ContactPoint, ...],
    contact_time: float,
    duration: float | None,
    solver: Solver,
) -> Hierarchy:
    """Return the hierarchy of a finite-element body, fitted to the time scales of a scene.

    A body with one contact point has AO models. For several contact points, a model of order n has
    n vectors for each point, and at least one if the body is constrained.
    """
    tip, body, single = tips[0], tips[0].body, len(tips) == 1
    dofs = body.n_dofs

    @cache
    def space() -> KrylovSpace:
        resolved = max(contact_time, *map(shortest_contact_time, tips))
        made = KrylovSpace(tips, contact_time=resolved, sharpened=True, solver=solver)
        if duration is not None:
            natural = made.of_vectors(_FEW).omega if single else np.zeros(0)
            # Slow motion, which costs a second factorisation, is included only if modes need it.
            if not single or (natural[natural > 0.0] < made.shift).any():
                made.include(duration)
        return made

    free = moves_rigidly(tip) if single else bool(body.rigid_modes.shape[1])
    first = 0 if free else 1

    def make(order: int) -> Body:
        if not single:
            vectors = body.rigid_modes.shape[1] + max(order, first) * len(tips)
            return space().of_all(min(vectors, dofs))
        if order < first:
            return rigid(mass=math.inf, name=tip.name).modal
        return space().of_vectors(order - first)

    return Hierarchy(first, dofs, make, space)


def _rigid(model: Body) -> Body:
    """Return the body of a model without oscillators: a wall if the model is constrained."""
    gives = model.constrained and not model.wall
    return rigid(mass=math.inf, name=model.name).modal if gives else model


def model_hierarchy(
    body: BodyModel | Hierarchy,
    contact_time: float,
    duration: float | None,
    solver: Solver = "auto",
) -> Hierarchy:
    """Return the model hierarchy of a body.

    Parameters
    ----------
    body : Body, FullModel or Hierarchy
        A `Body` with several ports is its own only model.
    contact_time : float
        Duration of the contact that the models are fitted to, s.
    duration : float, optional
        Duration of slower motion that the models must represent as well, s; by default none.
    solver : str or callable, optional
        The linear solver.
    """
    if isinstance(body, Hierarchy):
        return body
    if isinstance(body, FullModel):
        return _of_elements(body.tips, contact_time, duration, solver)
    assert isinstance(body, Body)
    return truncations(body) if body.ports == 1 else fixed_model(body)


def only_models(bodies: Sequence[Any]) -> tuple[Body, ...] | None:
    """Return the models of bodies if each body has only one model, such as a rigid one; else None.

    Parameters
    ----------
    bodies : sequence of Body, FullModel or Hierarchy
    """
    every = [model_hierarchy(body, math.nan, None) for body in bodies]
    return tuple(one.finished(0) for one in every) if all(one.most <= 0 for one in every) else None
