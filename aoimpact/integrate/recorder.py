"""The record that a solver leaves of a run, to be read at times."""

from __future__ import annotations

from typing import Protocol

from ..base import FloatArray
from .events import Events
from .motion import Motion


class Recorder(Protocol):
    """A run of a solver that can be read at times."""

    @property
    def solver(self) -> str:
        """How time was integrated."""
        ...

    @property
    def seconds(self) -> float:
        """How long the run took, s."""
        ...

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        ...

    @property
    def times(self) -> FloatArray:
        """Times at which to draw it, s."""
        ...

    @property
    def marks(self) -> FloatArray:
        """Times at which the run itself is most exact: the ends of its steps."""
        ...

    @property
    def events(self) -> tuple[Events, ...]:
        """Events of each contact; found between the steps where the solver does not locate them."""
        ...

    @property
    def dense(self) -> bool:
        """True if it can be read at any times."""
        ...

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        """Return the record at times, shape (rows, n), for the caller to write on.

        :class:`RecordLayout` tells its rows apart.
        """
        ...

    def forces(self, times: FloatArray) -> FloatArray:
        """Return the contact forces at times, shape (contacts, n), N: of the record, these rows."""
        ...

    def pushes(self, times: FloatArray) -> FloatArray:
        """Return the contact forces with those of friction, N; see `RecordLayout.pushes`."""
        ...

    def state(self, body: int) -> tuple[FloatArray, FloatArray]:
        """Return a body's own coordinates and their rates at the end of the record."""
        ...

    def motion(self, body: int) -> Motion:
        """Return how a body moves at any times, in the coordinates of its model."""
        ...
