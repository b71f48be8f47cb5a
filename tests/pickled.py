"""A body as another process gets it, which has no other of its mark."""

from __future__ import annotations

import pickle
import uuid

import aoimpact as ao


def elsewhere(body: ao.FEModel) -> ao.FEModel:
    """Return the body that another process makes of its pickle."""
    remade, (kind, _, state) = body.__reduce__()
    made: ao.FEModel = remade(kind, uuid.uuid4().hex, pickle.loads(pickle.dumps(state)))
    return made
