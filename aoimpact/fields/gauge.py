"""A strain gauge on the surface of a body."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..base import FloatArray, InputError, plain, with_unit
from ..fem import FEModel, to_nodes
from .historyerror import Compared, warn_if_wrong

# sin of the angle between a gauge and the surface beyond which it does not lie on it.
_OFF = 0.1

# Distance of an end from the surface, over the gauge's length, beyond which it is off the body; the
# same of its middle; and by how much of it an end may move along the gauge to its place on the
# surface, which on a curved one is (length/radius)²/16 of it.
_BEYOND, _BESIDE, _SHORTER = 0.25, 0.1, 0.01


@dataclass(frozen=True, eq=False)
class Gauge(Compared):
    """Strain of a gauge over time: the mean along its length.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    ends : ndarray, shape (2, 3)
        On the undeformed body, m; of a shell on the surface of its nodes.
    """

    t: FloatArray
    ends: FloatArray
    _strain: FloatArray = field(repr=False)

    @property
    def strain(self) -> FloatArray:
        """Strain, shape (n,), positive in tension; warns where it may be wrong, see `error`."""
        warn_if_wrong("strain of a gauge", self.t, self.error)
        return self._strain


def gauge_ends(
    body: FEModel, point: FloatArray, direction: FloatArray, length: float, name: str = "direction"
) -> tuple[FloatArray, FloatArray]:
    """Return both ends of a gauge, shape (2, 3), m, and the unit vector from one to the other.

    The ends lie on the surface: the mean strain along a chord is the change of its length. On a
    curved surface that differs from the mean along the arc by (length/radius)²/24.
    """
    if body.nodes is None:
        raise InputError(
            "this body has no nodes, between which a gauge measures: give nodes= with K and M"
        )
    if body.mesh is not None and body.surface is None:
        raise InputError(
            "a gauge sits on a surface, and beams have only an axis; take the strain of a side, "
            "probe(point, layer=).strain"
        )
    point = to_nodes(body, point)
    where = f"the gauge of length={with_unit(length, 'm')} at point {plain(point)} m"
    if length > float(np.ptp(body.nodes, axis=0).max()):
        raise InputError(f"{where} is longer than the body: give a shorter one, in metres")
    half = 0.5 * length * direction
    ends = np.stack([point - half, point + half])
    if body.surface is not None:
        surface = body.surface
        under = surface.nearest(point)
        if (off := float(under.distance[0])) > _BESIDE * length:
            raise InputError(
                f"{where} is {with_unit(off, 'm', 2)} off the surface; give a point on it"
            )
        normals = surface.normal(under.face, under.uv)
        if np.abs(normals @ direction).min() > _OFF:
            raise InputError(
                f"{name} {plain(direction)} does not lie in the surface at point {plain(point)} m, "
                f"whose normal is {plain(normals[0])}: give one along the surface"
            )
        found = [surface.nearest(end) for end in ends]
        off = max(float(place.distance[0]) for place in found)
        places = np.stack([place.x[0] for place in found])
        if off > _BEYOND * length or np.abs((places - ends) @ direction).max() > _SHORTER * length:
            raise InputError(
                f"{where} along {name} {plain(direction)} reaches {with_unit(off, 'm', 2)} beyond "
                "the surface; give a shorter one, or move it from the edge"
            )
        ends = places
    along = ends[1] - ends[0]
    size = float(np.linalg.norm(along))
    if size == 0.0:
        raise InputError(f"{where}: both ends are one point of the surface")
    return ends, along / size
