"""The layout of a record: the quantity in each row, as both integrators of the core write it.

The rows of all contacts come first, then those of each body, followed by those of its ports.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base import BoolArray, FloatArray, IntArray


class ContactRows(NamedTuple):
    """Record of a contact over time, of shape (times,) unless stated otherwise.

    Attributes
    ----------
    force, indentation : ndarrays
        Normal force, N, and indentation between the models, m.
    elastic, dissipated : ndarrays
        Energy stored in the law and by tangential stretching, and energy lost in the law, J.
    tangential : ndarray, shape (2, times), or None
        Friction force along the two tangents, N; None for a contact without friction.
    friction : ndarray or None
        Energy dissipated by friction, J.
    stuck : ndarray or None
        Square of the ratio of the stick zone's radius to the contact radius.
    """

    force: FloatArray
    indentation: FloatArray
    elastic: FloatArray
    dissipated: FloatArray
    tangential: FloatArray | None = None
    friction: FloatArray | None = None
    stuck: FloatArray | None = None


class BodyRows(NamedTuple):
    """Record of a body over time, of shape (times,) unless stated otherwise.

    Attributes
    ----------
    displacement, velocity : ndarrays
        Motion of the centre of mass, m and m/s.
    kinetic, elastic : ndarrays
        Kinetic and strain energy, J.
    dissipated, work : ndarrays
        Energy lost in damping, and work of gravity and applied forces, J.
    port_displacements, port_velocities : ndarrays, shape (p, times)
        Motion of the contact coordinates, m and m/s.
    """

    displacement: FloatArray
    velocity: FloatArray
    kinetic: FloatArray
    elastic: FloatArray
    dissipated: FloatArray
    work: FloatArray
    port_displacements: FloatArray
    port_velocities: FloatArray


# Numbers of rows of a contact, body, port and friction, as in the core: AOI_CONTACT_ROWS,
# AOI_BODY_ROWS, AOI_PORT_ROWS, AOI_FRICTION_ROWS.
_CONTACT, _BODY, _PORT, _SLIDING = 4, len(BodyRows._fields) - 2, 2, 8


@dataclass
class RecordLayout:
    """Index of each row of a record, the matrix of a run's histories with one column per time.

    Attributes
    ----------
    ports : tuple of int
        Number of ports of each body.
    sliding : tuple of bool
        True for each contact with friction.
    slides : bool
        True if a contact has friction.
    rows : int
        Number of rows.
    """

    ports: tuple[int, ...]
    sliding: tuple[bool, ...]

    def __post_init__(self) -> None:
        # _starts: first row of each contact, then of the bodies. _first: first row of each body,
        # then the number of rows.
        sliding = np.array(self.sliding, dtype=bool)
        sizes = np.where(sliding, _SLIDING, _CONTACT)
        self._starts: IntArray = np.append(0, np.cumsum(sizes))
        bodies = _BODY + _PORT * np.array(self.ports, dtype=np.intp)
        self._first: IntArray = np.cumsum([self._starts[-1], *bodies])
        self.rows, self.slides = int(self._first[-1]), bool(sliding.any())
        first = self._starts[:-1]
        self._pushes: IntArray = np.sort(
            np.concatenate([first, first[sliding] + 4, first[sliding] + 5])
        )

    def contact(self, record: FloatArray, contact: int) -> ContactRows:
        """Return the rows of one contact of a record, shape (rows, times)."""
        first, end = self._starts[contact : contact + 2]
        rows = record[first:end]
        rubbed = [rows[4:6], rows[6], rows[7]] if len(rows) > _CONTACT else [None] * 3
        return ContactRows._make([*rows[:_CONTACT], *rubbed])

    def body(self, record: FloatArray, body: int) -> BodyRows:
        """Return the rows of one body of a record, shape (rows, times)."""
        first, end = self._first[body : body + 2]
        ports = record[first + _BODY : end]
        return BodyRows._make([*record[first : first + _BODY], ports[::_PORT], ports[1::_PORT]])

    def forces(self, record: FloatArray) -> FloatArray:
        """Return all contact forces, N, shape (contacts, times)."""
        return record[self._starts[:-1]]

    def indentations(self, record: FloatArray) -> FloatArray:
        """Return all indentations, m, shape (contacts, times)."""
        return record[self._starts[:-1] + 1]

    def pushes(self, record: FloatArray) -> FloatArray:
        """Return all forces of the contacts, N, shape (pushes, times).

        Each contact has one row for the normal force and, with friction, two for the forces along
        its tangents.
        """
        return record[self._pushes]

    @property
    def normal(self) -> BoolArray:
        """True for the rows of `pushes` that are normal forces, shape (pushes,)."""
        return np.isin(self._pushes, self._starts)

    def of_contacts(self, record: FloatArray) -> FloatArray:
        """Return the rows of all contacts, as a view."""
        return record[: self._starts[-1]]

    def centre_velocities(self, record: FloatArray) -> FloatArray:
        """Return the velocities of all centres of mass, m/s, shape (bodies, times), as a copy."""
        at = BodyRows._fields.index("velocity")
        return record[self._first[:-1] + at]
