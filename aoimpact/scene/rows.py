"""The layout of a record: which of its rows holds what, as both integrators of the core write it.

All contacts come first, then the bodies, each followed by its ports.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from ..base import FloatArray


class ContactRows(NamedTuple):
    """Record of a contact over time, each of shape (times,).

    Attributes
    ----------
    force, indentation : ndarrays
        N and m.
    elastic, dissipated : ndarrays
        Energy stored in the law, and lost in it, J.
    """

    force: FloatArray
    indentation: FloatArray
    elastic: FloatArray
    dissipated: FloatArray


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
        m and m/s.
    """

    displacement: FloatArray
    velocity: FloatArray
    kinetic: FloatArray
    elastic: FloatArray
    dissipated: FloatArray
    work: FloatArray
    port_displacements: FloatArray
    port_velocities: FloatArray


# AOI_CONTACT_ROWS, AOI_BODY_ROWS and AOI_PORT_ROWS of the core.
_CONTACT, _BODY, _PORT = len(ContactRows._fields), len(BodyRows._fields) - 2, 2


@dataclass(frozen=True)
class RecordLayout:
    """Where the rows of a record stand; what it returns are views of the record.

    Attributes
    ----------
    contacts : int
        Number of contacts.
    ports : tuple of int
        Number of ports of each body.
    """

    contacts: int
    ports: tuple[int, ...]

    @cached_property
    def _first(self) -> tuple[int, ...]:
        """The first row of each body, and the number of rows."""
        sizes = (_BODY + _PORT * ports for ports in self.ports)
        return tuple(itertools.accumulate(sizes, initial=_CONTACT * self.contacts))

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self._first[-1]

    def contact(self, record: FloatArray, contact: int) -> ContactRows:
        """Return the rows of one contact of a record, shape (rows, times)."""
        return ContactRows(*record[_CONTACT * contact : _CONTACT * (contact + 1)])

    def body(self, record: FloatArray, body: int) -> BodyRows:
        """Return the rows of one body."""
        first, end = self._first[body : body + 2]
        ports = record[first + _BODY : end]
        return BodyRows._make([*record[first : first + _BODY], ports[::_PORT], ports[1::_PORT]])

    def forces(self, record: FloatArray) -> FloatArray:
        """Return all contact forces, N, shape (contacts, times)."""
        return record[: _CONTACT * self.contacts : _CONTACT]

    def indentations(self, record: FloatArray) -> FloatArray:
        """Return all indentations, m, shape (contacts, times)."""
        return record[1 : _CONTACT * self.contacts : _CONTACT]

    def of_contacts(self, record: FloatArray) -> FloatArray:
        """Return the rows of all contacts, shape (contacts, 4, times)."""
        return record[: _CONTACT * self.contacts].reshape(self.contacts, _CONTACT, record.shape[1])

    def centre_velocities(self, record: FloatArray) -> FloatArray:
        """Return the velocities of all centres of mass, m/s, shape (bodies, times): a copy."""
        at = BodyRows._fields.index("velocity")
        return record[[first + at for first in self._first[:-1]]]
