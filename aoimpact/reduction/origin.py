"""The finite-element body of a reduced model, and the shapes of its coordinates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from ..base import FloatArray
from ..fem import ContactPoint, centre_of, translates


@dataclass(frozen=True, eq=False)
class Origin:
    """The finite-element body that a star was made from, and the shapes of its coordinates.

    Attributes
    ----------
    label : str
        The kind of model: "AO" or "modal".
    tip : ContactPoint
    static : ndarray, shape (n_dofs,) or (r,)
        φ_st, eqs. (2), (3), or its coordinates on the vectors.
    oscillators : ndarray, shape (n_dofs, n) or (r, n)
        Ψ_i = c_i φ_i, eq. (8), or their coordinates on the vectors.
    centre : ndarray, shape (n_dofs,)
        h with hᵀX the displacement of the centre of mass along the direction of travel.
    mass : float
        Mass of the whole body, kg; more than the static mass where part of it does not respond to
        the contact.
    centre_known : bool
        Whether these two are so; else the mean over the static mode and its mass stand for them.
    translates : bool
        Whether the body is free to translate along the direction of travel.
    solver : str
        The linear solver that the model was made with; empty where dense matrices served.
    contact_time : float or None
        The duration of the contact that the model was fitted to, s; None where it fits any.
    vectors : callable, optional
        Returns vectors, shape (n_dofs, r), of which the shapes are combinations that have not been
        multiplied out.
    series : AOModel, optional
        The modal model that the star is the first oscillators of, with its compliances.
    """

    label: str
    tip: Any
    static: FloatArray
    oscillators: FloatArray
    centre: FloatArray
    mass: float
    centre_known: bool
    translates: bool
    solver: str = ""
    contact_time: float | None = None
    vectors: Callable[[], FloatArray] | None = None
    series: Any = None

    @property
    def static_mode(self) -> FloatArray:
        """φ_st, eqs. (2), (3), shape (n_dofs,)."""
        return self._multiplied_out[0]

    @property
    def shapes(self) -> FloatArray:
        """Ψ_i = c_i φ_i, eq. (8), shape (n_dofs, n)."""
        return self._multiplied_out[1]

    @cached_property
    def _multiplied_out(self) -> tuple[FloatArray, FloatArray]:
        if self.vectors is None:
            return self.static, self.oscillators
        vectors = self.vectors()
        return vectors @ self.static, vectors @ self.oscillators

    def multiplied_out(self) -> Origin:
        """The same without the vectors."""
        return replace(self, static=self.static_mode, oscillators=self.shapes, vectors=None)

    def reversed(self) -> Origin:
        """The same with the direction of travel the other way round."""
        return replace(
            self,
            tip=self.tip.reversed(),
            static=-self.static,
            oscillators=-self.oscillators,
            centre=-self.centre,
        )

    def observed_by(self, functional: FloatArray) -> tuple[float, FloatArray]:
        """functionalᵀφ_st and functionalᵀΨ_i, for a functional of shape (n_dofs,)."""
        on = functional if self.vectors is None else functional @ self.vectors()
        return float(on @ self.static), on @ self.oscillators


def origin_of(
    tip: ContactPoint,
    static: FloatArray,
    shapes: FloatArray,
    label: str,
    solver: str,
    contact_time: float | None = None,
    vectors: Callable[[], FloatArray] | None = None,
) -> Origin:
    """Return the origin of a star with these shapes, whose body's centre of mass it adds."""
    centre = centre_of(tip, lambda: static if vectors is None else vectors() @ static)
    parts = label, tip, static, shapes, *centre, translates(tip)
    return Origin(*parts, solver, contact_time, vectors)
