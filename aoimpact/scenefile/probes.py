"""Sensors that a scene file names, read of its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base import FloatArray, unit_vector
from ..results import BodyResult

_AXES = {"xx": (1.0, 0.0, 0.0), "yy": (0.0, 1.0, 0.0), "zz": (0.0, 0.0, 1.0)}


def read_probe(body: BodyResult, wanted: Mapping[str, Any], times: FloatArray) -> FloatArray:
    """Return the history of a sensor on a body, shape (times,), in SI units.

    Parameters
    ----------
    body : BodyResult
    wanted : mapping
        The sensor's table; without a type the displacement of a place.
    times : ndarray, shape (times,)
        s.
    """
    given = {key: of for key, of in wanted.items() if key in ("layer", "part")}
    match wanted.get("type"):
        case "ReactionAt":
            direction = unit_vector("direction", wanted["direction"])
            return np.asarray(body.reaction(wanted["nodes"], times=times).force @ direction)
        case "AccelerationAt":
            probe = body.probe(wanted["point"], wanted["direction"], times=times)
            channel = probe.filtered(cfc=wanted.get("cfc"), corner=wanted.get("corner"))
            return channel.acceleration
        case "StressAt":
            stress = body.probe(wanted["point"], times=times, **given).stress
            component = wanted.get("component", "von_mises")
            return stress.von_mises if component == "von_mises" else stress[component]
        case "StrainAt":
            component = wanted.get("component", "xx")
            if "length" in wanted:
                along = _AXES.get(component, component) if isinstance(component, str) else component
                length = wanted["length"]
                return body.gauge(wanted["point"], along, length, times=times, **given).strain
            strain = body.probe(wanted["point"], times=times, **given).strain
            return strain[component] if isinstance(component, str) else strain.along(component)
    return body.probe(wanted["point"], wanted["direction"], times=times).displacement
