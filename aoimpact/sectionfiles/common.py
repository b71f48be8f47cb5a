"""What the readers share: units, plies, and directions that elements have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, IntArray, MeshError
from ..fem import Laminate, Material, OneMaterial, Orthotropic, Ply, Shell
from ..mesh import RawMesh, key

# Largest difference between directions that are the same: what printed digits leave.
_SAME = 1e-4

_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Source:
    """A deck, its units in SI, and what its user says of it.

    Attributes
    ----------
    raw : RawMesh
    length, force, time : float
        m, N and s.
    given : mapping of str to Material, Orthotropic, Shell, Laminate or Beam
        By names in capitals without blanks.
    left_out : list of str
        Is said in one warning.
    taken : set of str
        Names of `given` that the deck has.
    """

    raw: RawMesh
    length: float
    force: float
    time: float
    given: Mapping[str, OneMaterial]
    left_out: list[str] = field(default_factory=list)
    taken: set[str] = field(default_factory=set)

    def instead(self, name: str) -> OneMaterial | None:
        """Return what is given in place of a card; `taken` holds such names."""
        if (at := key(name)) in self.given:
            self.taken.add(at)
        return self.given.get(at)

    @property
    def stress(self) -> float:
        """The deck's unit of stress, Pa."""
        return self.force / self.length**2

    @property
    def density(self) -> float:
        """The deck's unit of density, kg/m³."""
        return self.force * self.time**2 / self.length**4

    def isotropic(self, E: float, nu: float, rho: float) -> Material:
        """Return the material of constants in the deck's units."""
        return Material(E * self.stress, nu, rho * self.density)

    def orthotropic(
        self, E: Sequence[float], nu: Sequence[float], G: Sequence[float], rho: float
    ) -> Orthotropic:
        """Return the material of E1, E2, E3, ν12, ν13, ν23, G12, G13, G23 in the deck's units."""
        moduli = ([one * self.stress for one in three] for three in (E, G))
        own: dict[str, Any] = dict(zip(("E", "G", "nu"), map(tuple, (*moduli, nu)), strict=True))
        return Orthotropic(**own, rho=rho * self.density)

    def ply(
        self, E1: float, E2: float, nu12: float, G12: float, G13: float, G23: float, rho: float
    ) -> Orthotropic:
        """Return a ply that is isotropic across its fibres: E3 = E2, ν23 = E2/(2 G23) - 1."""
        nu23 = 0.5 * E2 / G23 - 1.0
        try:
            return self.orthotropic((E1, E2, E2), (nu12, nu12, nu23), (G12, G13, G23), rho)
        except InputError:
            raise InputError(
                f"E3 is not known: E2={E2:g} and G23={G23:g} are not those of fibres in a matrix, "
                "nu23=E2/(2 G23)-1 being out of reach. Give it as an Orthotropic by "
                "read_sections(given=)"
            ) from None

    def directions(self, members: IntArray, *, edges: bool = False) -> FloatArray:
        """Return unit normals of surface cells and tangents of lines, in order, shape (n, 3).

        With `edges` the directions from the first node to the second.
        """
        found = [np.zeros((0, 3))]
        for block, first in zip(self.raw.blocks, self.raw.first[:-1], strict=True):
            own = members[(members >= first) & (members < first + len(block.cells))] - first
            ends = self.raw.nodes[block.cells[own]]
            if block.dim == 2 and not edges:
                last = 3 if block.kind.startswith("quad") else 2
                found.append(np.cross(ends[:, 2] - ends[:, 0], ends[:, last] - ends[:, 1]))
            elif block.dim:
                found.append(ends[:, 1] - ends[:, 0])
        return unit(np.concatenate(found))


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors, shape (n, 3), of length one."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    found: FloatArray = vectors / np.maximum(length, _TINY)
    return found


def across(vectors: FloatArray, directions: FloatArray) -> FloatArray:
    """Return unit vectors along the parts of vectors across unit directions, shape (n, 3).

    They are zero where there is no such part.
    """
    along = np.einsum("ni,ni->n", np.broadcast_to(vectors, directions.shape), directions)
    part = vectors - along[:, None] * directions
    length = np.linalg.norm(part, axis=1, keepdims=True)
    return unit(
        np.where(length > _SAME * np.linalg.norm(vectors, axis=-1, keepdims=True), part, 0.0)
    )


def common(vectors: FloatArray, directions: FloatArray) -> tuple[float, ...] | None:
    """Return a vector whose part across each direction is along that of each vector, if there is.

    Normals and tangents are such directions, of which `Laminate` and `Beam` take the part across.
    """
    wanted = across(vectors, directions)
    if not wanted.any(axis=1).all():
        return None
    for one in (vectors[0], wanted.mean(axis=0)):
        if np.abs(across(one, directions) - wanted).max() < _SAME:
            return tuple(np.round(one, 12).tolist())
    return None


def layered(
    plies: list[Ply], axis: Callable[[], tuple[float, ...]], offset: float
) -> Shell | Laminate:
    """Return the shell of some plies; the axis is asked for if one of them has fibres."""
    if any(isinstance(ply.material, Orthotropic) for ply in plies):
        return Laminate(plies, axis(), offset)
    if len(plies) == 1:
        return Shell(plies[0].thickness, plies[0].material, offset)
    return Laminate(plies, None, offset)


@contextmanager
def refusing(error: Callable[[str], MeshError]) -> Iterator[None]:
    """Say of bad values to which card they belong."""
    try:
        yield
    except MeshError:  # names its own card
        raise
    except (ValueError, ZeroDivisionError) as wrong:  # InputError and LinAlgError among them
        raise error(str(wrong)) from None
