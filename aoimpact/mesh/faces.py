"""The sides of the solid elements: which nodes lie on each, and its own two coordinates.

A side is the volume element on a plane of its reference cell, so the shape functions of every
kind of face, curved ones too, are those of the volume.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ..base import FloatArray, IntArray
from .elements import ReferenceElement, reference_element

__all__ = ["ReferenceFace", "reference_faces"]


@dataclass(frozen=True, eq=False)
class ReferenceFace:
    """One side of a reference element: ξ = origin + u axes[0] + v axes[1].

    Attributes
    ----------
    nodes : ndarray of int
        The nodes on it, by their numbers within the element; the corners first, counter-clockwise
        as seen from outside.
    n_corners : int
        3: u, v ≥ 0 and u + v ≤ 1. 4: both from 0 to 1.
    origin : ndarray, shape (3,)
    axes : ndarray, shape (2, 3)
        Their cross product points outward.
    """

    nodes: IntArray
    n_corners: int
    origin: FloatArray
    axes: FloatArray


@cache
def reference_faces(kind: str) -> tuple[ReferenceFace, ...]:
    """Return the sides of the element of meshio's name `kind`."""
    element = reference_element(kind)
    return tuple(_side(element, normal) for normal in element.cell.normals)


def _side(element: ReferenceElement, normal: FloatArray) -> ReferenceFace:
    height = element.nodes @ normal
    on = np.flatnonzero(np.abs(height - height.max()) < 1e-12)
    corners, others = on[on < element.n_corners], on[on >= element.n_corners]
    arms = element.nodes[corners] - element.nodes[corners].mean(axis=0)
    across = np.cross(normal, arms[0])
    corners = corners[
        np.argsort(np.arctan2(arms @ across, arms @ arms[0] * np.linalg.norm(normal)))
    ]
    places = element.nodes[corners]
    axes = np.stack([places[1] - places[0], places[-1] - places[0]])
    return ReferenceFace(np.concatenate([corners, others]), len(corners), places[0], axes)
