"""Contacts between the bodies of a scene, and loads on bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base import FloatArray
from ..contact import Compliance
from ..fem import Material
from ..laws import ContactLaw, CoreLaw, HertzianLaw, PatchLaw, effective_law, own_law
from ..reduction import BodyModel
from .rows import ContactRows


def extraction_of(law: ContactLaw, model: BodyModel, port: int) -> Compliance | None:
    """Return a body's compliances at a contact; None if the law keeps its compliance.

    A law that is not like Hertz's, such as that of a spring or buffer, does not contain the
    indentation of a solid at a node, so that no compliance is taken out. Shells and beams have a
    compliance to take out under any law.

    Raises
    ------
    InputError
        If the law is like Hertz's and the contact strikes a tube of beam elements laterally. A
        spring may include the bending of the tube's wall; Hertz's law does not.
    """
    tip, local = model.touched_at(port), isinstance(own_law(law), HertzianLaw)
    if tip is None or not (tip.patch or tip.thin or local):
        return None
    if local:
        tip.check_wall()
    return model.extraction_at(port)


class Port(NamedTuple):
    """A contact coordinate of a body.

    Attributes
    ----------
    body, port : int
        Number of the body in the scene, and of the contact coordinate on the body.
    """

    body: int
    port: int


# Relative tolerance of the stretches of the springs that represent friction: error of a stretch
# divided by the largest stretch. The relative error of the friction force is a tenth of this.
_PRECISION = 1e-4

# Poisson's ratio for G*/E* if both materials are unknown; both are then assumed to be equal.
_USUAL = 0.3


class Friction(NamedTuple):
    """Coulomb's friction in a contact.

    Attributes
    ----------
    mu : float
        Coefficient of friction.
    ratio : float
        Ratio G*/E* of tangential to normal stiffness (Mindlin).
    compliance : ndarray, shape (3, 3), or None
        Local compliance c of the meshes, which replaces the half-spaces' compliance, along the
        direction of travel and the two tangents, m/N; None for bodies without meshes.
    """

    mu: float
    ratio: float = math.nan
    compliance: FloatArray | None = None

    def between(
        self, materials: Sequence[Material | None], known: Sequence[Compliance | None]
    ) -> Friction:
        """Return the friction with the stiffness ratio and compliance of two bodies.

        1/E* = Σ (1 - ν²)/E and 1/G* = Σ (2 - ν)/(4G) (K. L. Johnson, Contact Mechanics, 7.2). If
        one material is unknown, that body is assumed to be rigid; if both are, they are assumed to
        be equal.
        """
        ratio, there = 2.0 * (1.0 - _USUAL) / (2.0 - _USUAL), [of for of in materials if of]
        if there:
            normal = math.fsum(1.0 / of.plane_strain_modulus for of in there)
            ratio = normal / math.fsum((2.0 - of.nu) / (4.0 * of.shear_modulus) for of in there)
        removed = [of.oblique for of in known if of and of.oblique is not None]
        return Friction(self.mu, ratio, np.asarray(sum(removed)) if removed else None)

    def for_core(self, law: ContactLaw, precision: float) -> tuple[Any, ...]:
        """Return the core's tuple, with the normal compliance of `law`.

        If the compliance of `law` differs from the normal compliance of the meshes, due to the
        contact's width or an altered law, the difference divided by `ratio` is added to the
        tangential compliances. For `precision` see `_PRECISION`.
        """
        if self.compliance is None:
            return self.mu, self.ratio, precision, None
        normal = law.compliance if isinstance(law, PatchLaw) else 0.0
        more = normal - float(self.compliance[0, 0])
        found = self.compliance + more * np.diag([1.0, 1.0 / self.ratio, 1.0 / self.ratio])
        found[0, 0] = normal
        return self.mu, self.ratio, precision, found


class Contact(NamedTuple):
    """A contact of two bodies.

    Attributes
    ----------
    first, first_port, second, second_port : int
        Numbers of the bodies in the plan, and of their contact coordinates; the indentation is the
        first's coordinate minus the second's minus the gap.
    law : ContactLaw
        Law between the models, without the local compliance of their meshes.
    gap : float
        Initial distance, m.
    name : str
        Name given by the user; may be empty.
    friction : Friction or None
        Friction; with it the contact has three coordinates per body, along the normal and two
        tangents. `first_port` and `second_port` are then the numbers of the normal coordinates.
    removed : (float, float)
        Compliances of the two bodies' meshes that were taken out of the law, m/N.
    width : float or None
        Estimated radius of the contact at its largest force, m; None if not known.
    law_error : float
        Relative error of the law's stiffness due to errors of the surfaces' curvatures.
    """

    first: int
    first_port: int
    second: int
    second_port: int
    law: ContactLaw
    gap: float
    name: str = ""
    friction: Friction | None = None
    removed: tuple[float, ...] = (0.0, 0.0)
    width: float | None = None
    law_error: float = 0.0

    def of_models(self, bodies: Sequence[BodyModel], *, bounded: bool = False) -> Contact:
        """Return the contact between models, the compliance of their meshes taken out of its law.

        Parameters
        ----------
        bodies : sequence of BodyModel
            Models of the scene.
        bounded : bool, optional
            True to take nothing out of the law of a contact that is stiffer than its meshes. On a
            shell, the resulting force is one bound of the true force; the other bound results from
            a law with as much compliance taken out as possible.

        Raises
        ------
        InputError
            If the law is stiffer than the meshes from the first touch on.
        """
        known = [extraction_of(self.law, bodies[body], port) for body, port in self.ports]
        friction = self.friction and self.friction.between(self.materials(bodies), known)
        removed = tuple(0.0 if of is None else of.removed_for(self.width) for of in known)
        left = bounded and math.fsum(removed) > 0.0
        if left or isinstance(self.law, PatchLaw):  # a PatchLaw already lacks the compliance
            return self._replace(friction=friction)
        law = effective_law(self.law, math.fsum(removed))
        return self._replace(law=law, removed=removed, friction=friction)

    def materials(self, bodies: Sequence[BodyModel]) -> list[Material | None]:
        """Return the materials of both bodies at the contact; None for a body given by numbers."""
        return [
            None if of is None else of.material
            for body, port in self.ports
            for of in (bodies[body].touched_at(port) or bodies[body].surface_at(port),)
        ]

    def own_indentation(self, rows: ContactRows) -> FloatArray:
        """Return the indentation of the law, m: δ + c F with the compliance c taken out of the law.

        With friction, c also couples the indentation to the tangential forces.
        """
        c = self.law.compliance if isinstance(self.law, PatchLaw) else 0.0
        depth = rows.indentation + c * rows.force
        if self.friction and self.friction.compliance is not None and rows.tangential is not None:
            depth += self.friction.compliance[0, 1:] @ rows.tangential
        return depth

    @property
    def size(self) -> int:
        """Number of force components of the contact."""
        return 1 if self.friction is None else 3

    @property
    def ports(self) -> tuple[Port, Port]:
        """The contact coordinates of both bodies."""
        return Port(self.first, self.first_port), Port(self.second, self.second_port)

    def for_core(self, law: CoreLaw, precision: float = _PRECISION) -> tuple[Any, ...]:
        """Return the core's tuple of the contact; for `precision` see `_PRECISION`."""
        if self.friction is None:
            return *self[:4], self.gap, law
        return *self[:4], self.gap, law, self.friction.for_core(self.law, precision)

    def port_of(self, body: int) -> int:
        """Return the port of one of the two bodies, given by its number."""
        return self.first_port if body == self.first else self.second_port

    def touches(self, body: int) -> bool:
        """Return whether a body takes part in the contact."""
        return body in (self.first, self.second)


class Load(NamedTuple):
    """A force on a port, linear between times and constant outside them.

    Attributes
    ----------
    body, port : int
        As in :class:`Port`.
    times, forces : ndarrays, shape (m,)
        Ascending times, s, and forces along the direction of travel, N.
    """

    body: int
    port: int
    times: FloatArray
    forces: FloatArray
