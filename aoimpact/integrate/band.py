"""Order in which contacts are solved: those that share a body close to each other.

The core eliminates within a band as wide as contacts that share a body are apart, at a cost that
grows with its square.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ..base import IntArray


def narrow_order(ends: Sequence[tuple[int, int]], couples: Sequence[bool]) -> IntArray | None:
    """Return an order of contacts with a narrower band (Cuthill and McKee's, reversed).

    Parameters
    ----------
    ends : sequence of (int, int)
        The bodies of each contact.
    couples : sequence of bool
        Of each body: whether a force on it moves its other contacts; a wall does not.

    Returns
    -------
    ndarray, shape (contacts,), or None
        None where the order that they have is as good.
    """
    pairs = np.array(ends, dtype=np.intp).reshape(-1, 2)
    contact, side = np.nonzero(np.asarray(couples)[pairs])
    bodies = pairs[contact, side]
    band = _band(contact, bodies, len(couples))
    if band < 2:
        return None
    incidence = sp.csr_array(
        (np.ones(len(bodies)), (contact, bodies)), shape=(len(pairs), len(couples))
    )
    # Through the bodies as vertices of their own: all pairs of contacts of one body may be many.
    graph = sp.block_array([[None, incidence], [incidence.T, None]], format="csr")
    found = sp.csgraph.reverse_cuthill_mckee(graph, symmetric_mode=True)
    order = found[found < len(pairs)].astype(np.intp)
    place = np.empty(len(pairs), dtype=np.intp)
    place[order] = np.arange(len(pairs))
    return order if _band(place[contact], bodies, len(couples)) < band else None


def _band(place: IntArray, bodies: IntArray, count: int) -> int:
    """How far apart contacts of one body stand at most."""
    first, last = np.full(count, np.iinfo(np.intp).max), np.full(count, -1)
    np.minimum.at(first, bodies, place)
    np.maximum.at(last, bodies, place)
    return int(max((last - first)[last >= 0], default=0))
