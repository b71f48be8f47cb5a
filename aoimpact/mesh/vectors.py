"""Vectors in rows of arrays, and rigid-body motions of nodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import FloatArray

_TINY = float(np.finfo(float).tiny)


def dot(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the scalar products, shape (n,), of vectors in rows, shape (n, 3)."""
    return np.asarray(np.einsum("ni,ni->n", one, other))


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors, shape (..., k), scaled to unit length; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, _TINY))


def parted(values: Any, like: Sequence[Any]) -> list[Any]:
    """Split `values`, shape (n, ...), into consecutive parts with the shapes of arrays `like`."""
    parts = np.split(values, np.cumsum([of.size for of in like])[:-1])
    return [own.reshape(of.shape + own.shape[1:]) for own, of in zip(parts, like, strict=True)]


def rigid_motions(nodes: FloatArray, *, rotations: bool = False) -> FloatArray:
    """Return three rigid translations and three rotations about the middle, shape (3 n_nodes, 6).

    Rotations are divided by the body's size, so that all columns have the same magnitude. With
    `rotations`, rotational dofs follow the displacements of all nodes: shape (6 n_nodes, 6).
    """
    middle = 0.5 * (nodes.min(axis=0) + nodes.max(axis=0))
    size = float(np.ptp(nodes, axis=0).max()) or 1.0
    moved = motions_at((nodes - middle) / size, rotations=rotations).reshape(-1, 6)
    moved[nodes.size :] /= size
    return moved


def motions_at(places: FloatArray, *, rotations: bool = False) -> FloatArray:
    """Return displacements at points due to unit rigid motions, shape (n, 3, 6).

    The motions are translations along x, y, z, then rotations about these axes. With `rotations`,
    the rotations of the points follow: shape (2 n, 3, 6).
    """
    motions = np.zeros((len(places), 3, 6))
    motions[:, :, :3] = np.eye(3)
    motions[:, :, 3:] = np.cross(np.eye(3), places[:, None]).swapaxes(1, 2)
    if not rotations:
        return motions
    return np.concatenate([motions, np.broadcast_to(np.eye(3, 6, 3), motions.shape)])
