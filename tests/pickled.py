"""A body as unpickled in another process, which has no body of the same mark."""

from __future__ import annotations

import pickle
import uuid

import aoimpact as ao


def elsewhere(body: ao.FEModel) -> ao.FEModel:
    """Return the body as another process would unpickle it."""
    remade, (kind, _, state) = body.__reduce__()
    made: ao.FEModel = remade(kind, uuid.uuid4().hex, pickle.loads(pickle.dumps(state)))
    return made
