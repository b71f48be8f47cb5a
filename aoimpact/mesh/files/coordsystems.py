"""Coordinate systems of Nastran decks: CORD1R/C/S by three nodes, CORD2R/C/S by three points."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...base import FloatArray, IntArray
from .bulkdata import BulkData, Table
from .rawmesh import rows_of

__all__ = ["Axes", "Grids", "Systems", "read_systems"]

# Points of a system closer to one line than this, relative to their distance, define no axes.
_COLLINEAR = 1e-8

# Systems that refer to each other, one after the other: more are a circle.
_DEEPEST = 200


@dataclass(frozen=True, eq=False)
class Axes:
    """A coordinate system in basic coordinates.

    Attributes
    ----------
    kind : str
        "R", "C" or "S": rectangular, cylindrical (r, θ, z) or spherical (r, θ, φ), in degrees.
    origin : ndarray, shape (3,)
    axes : ndarray, shape (3, 3)
        Unit vectors in rows.
    """

    kind: str
    origin: FloatArray
    axes: FloatArray

    def basic(self, x: FloatArray) -> FloatArray:
        """Return basic coordinates of points given in this system, shape (n, 3)."""
        return self.origin + self._rectangular(x) @ self.axes

    def directions(self, x: FloatArray) -> FloatArray:
        """Return unit vectors of the coordinates at points given in basic coordinates.

        Returns
        -------
        ndarray, shape (n, 3, 3)
            A unit vector in each row.
        """
        local = (x - self.origin) @ self.axes.T
        along = np.arctan2(local[:, 1], local[:, 0])
        down = np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2])
        turned = np.tile(np.eye(3), (len(x), 1, 1))
        c, s = np.cos(along), np.sin(along)
        if self.kind == "C":
            turned[:, 0, :2], turned[:, 1, :2] = np.stack([c, s], 1), np.stack([-s, c], 1)
        elif self.kind == "S":
            ct, st, zero = np.cos(down), np.sin(down), np.zeros(len(x))
            turned[:, 0] = np.stack([st * c, st * s, ct], axis=1)
            turned[:, 1] = np.stack([ct * c, ct * s, -st], axis=1)
            turned[:, 2] = np.stack([-s, c, zero], axis=1)
        result: FloatArray = turned @ self.axes
        return result

    def _rectangular(self, x: FloatArray) -> FloatArray:
        if self.kind == "R":
            return x
        if self.kind == "C":
            r, theta, z = x[:, 0], np.radians(x[:, 1]), x[:, 2]
            return np.stack([r * np.cos(theta), r * np.sin(theta), z], axis=1)
        r, theta, phi = x[:, 0], np.radians(x[:, 1]), np.radians(x[:, 2])
        rho = r * np.sin(theta)
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), r * np.cos(theta)], axis=1)


_BASIC = Axes("R", np.zeros(3), np.eye(3))


@dataclass(frozen=True, eq=False)
class Grids:
    """GRID entries sorted by label.

    Attributes
    ----------
    table : Table
    labels : ndarray of int, shape (n,)
    systems, output_systems : ndarray of int, shape (n,)
        Labels of the coordinate systems of coordinates (CP) and displacements (CD).
    x : ndarray, shape (n, 3)
        Coordinates in the nodes' own systems.
    """

    table: Table
    labels: IntArray
    systems: IntArray
    output_systems: IntArray
    x: FloatArray

    def rows(self, labels: IntArray) -> IntArray:
        """Return row numbers of labels, of the same shape; -1 where there is no such node."""
        return rows_of(self.labels, labels)


@dataclass(frozen=True)
class _Definition:
    """A system as its entry gives it: by labels of nodes, or by points in another system."""

    table: Table
    row: int
    kind: str
    grids: tuple[int, ...] = ()
    reference: int = 0
    points: tuple[float, ...] = ()


@dataclass(eq=False)
class Systems:
    """Coordinate systems by label; those that refer to others are resolved when they are needed."""

    grids: Grids
    definitions: dict[int, _Definition]
    _known: dict[int, Axes] = field(default_factory=lambda: {0: _BASIC})
    _open: list[int] = field(default_factory=list)

    def axes(self, label: int, table: Table, row: int) -> Axes:
        """Return a system.

        Parameters
        ----------
        label : int
        table, row
            Entry that refers to it, for messages.

        Raises
        ------
        MeshError
            If it is not defined, or defined by itself, or by points on one line.
        """
        if label in self._known:
            return self._known[label]
        if label not in self.definitions:
            raise table.refused(row, f"coordinate system {label} is not defined (CORD1x, CORD2x)")
        if label in self._open or len(self._open) > _DEEPEST:
            raise table.refused(row, f"coordinate system {label} is defined by itself")
        self._open.append(label)
        try:
            self._known[label] = self._resolved(self.definitions[label], label)
        finally:
            self._open.remove(label)
        return self._known[label]

    def coordinates(self) -> FloatArray:
        """Return basic coordinates of all nodes, shape (n, 3)."""
        grids, x = self.grids, self.grids.x.copy()
        for label in np.unique(grids.systems):
            own = np.flatnonzero(grids.systems == label)
            x[own] = self.axes(int(label), grids.table, int(own[0])).basic(grids.x[own])
        return x

    def _resolved(self, one: _Definition, label: int) -> Axes:
        if one.grids:
            points = np.concatenate([self._place(one, node) for node in one.grids])
        else:
            reference = self.axes(one.reference, one.table, one.row)
            points = reference.basic(np.reshape(one.points, (3, 3)))
        origin, on_z, on_xz = points
        z, x = on_z - origin, on_xz - origin
        y = np.cross(z, x)
        size = np.linalg.norm(z) * np.linalg.norm(x)
        if not np.linalg.norm(y) > _COLLINEAR * size:
            why = f"the three points of coordinate system {label} lie on one line"
            raise one.table.refused(one.row, why)
        axes = np.stack([np.cross(y, z), y, z])
        return Axes(one.kind, origin, axes / np.linalg.norm(axes, axis=1)[:, None])

    def _place(self, one: _Definition, node: int) -> FloatArray:
        grids = self.grids
        row = int(grids.rows(np.array([node]))[0])
        if row < 0:
            raise one.table.refused(one.row, f"node {node} is not there")
        own = self.axes(int(grids.systems[row]), one.table, one.row)
        return own.basic(grids.x[row : row + 1])


def read_systems(deck: BulkData, grids: Grids) -> Systems:
    """Return the coordinate systems of a deck.

    Raises
    ------
    MeshError
        If an entry is not understood, or if two define the same system differently.
    """
    found: dict[int, _Definition] = {}

    def add(label: int, one: _Definition) -> None:
        other = found.setdefault(label, one)
        same = (one.kind, one.grids, one.reference, one.points)
        if same != (other.kind, other.grids, other.reference, other.points) or label < 1:
            raise one.table.refused(
                one.row, f"coordinate system {label} is there twice, or not > 0"
            )

    for kind in "RCS":
        table = deck.table(f"CORD1{kind}", width=8)
        nodes = table.integers(0, 8).tolist()
        for row, (a, *of_a, b, g1, g2, g3) in enumerate(nodes):
            add(a, _Definition(table, row, kind, grids=tuple(of_a)))
            if not table.blank[row, 4:].all():
                add(b, _Definition(table, row, kind, grids=(g1, g2, g3)))
        table = deck.table(f"CORD2{kind}", width=11)
        for row, ((label, reference), points) in enumerate(
            zip(table.integers(0, 2).tolist(), table.reals(2, 9).tolist(), strict=True)
        ):
            one = _Definition(table, row, kind, reference=reference, points=tuple(points))
            add(label, one)
    return Systems(grids, found)
