"""Contacts between the bodies of a scene, loads on them, and free motion."""

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
    """Return the compliances of a body under a law, or None if nothing is taken out of it there.

    A law that is not like Hertz's leaves out the indentation of a solid at a node, as springs and
    buffers do. Shells and beams bend there under any law.

    Raises
    ------
    InputError
        If the law is like Hertz's and strikes a tube of beams across. A spring that is given may
        contain how the wall of the tube bends; Hertz's law does not.
    """
    tip, local = model.touched_at(port), isinstance(own_law(law), HertzianLaw)
    if tip is None or not (tip.patch or tip.thin or local):
        return None
    if local:
        tip.check_wall()
    return model.extraction_at(port)


class Port(NamedTuple):
    """A place where a body may be touched.

    Attributes
    ----------
    body, port : int
        Number of the body in the scene, and of the place on it.
    """

    body: int
    port: int


# Share of the largest stretch to which the core draws the stretches of a contact with friction. The
# force errs by a tenth of it.
_PRECISION = 1e-4

# G*/E* of a pair of unknown materials is that of two like ones of this Poisson's ratio.
_USUAL = 0.3


class Friction(NamedTuple):
    """Coulomb's friction in a contact.

    Attributes
    ----------
    mu : float
        Coefficient of friction.
    ratio : float
        G*/E*, tangential over normal stiffness (Mindlin).
    compliance : ndarray, shape (3, 3), or None
        c in the direction of travel and the two tangents that meshes have in place of half-spaces,
        m/N; None where there are none.
    """

    mu: float
    ratio: float = math.nan
    compliance: FloatArray | None = None

    def between(
        self, materials: Sequence[Material | None], known: Sequence[Compliance | None]
    ) -> Friction:
        """Return the friction of two bodies; one of unknown material is rigid, two are like ones.

        1/E* = Σ (1 - ν²)/E and 1/G* = Σ (2 - ν)/(4G) (K. L. Johnson, Contact Mechanics, 7.2).
        """
        ratio, there = 2.0 * (1.0 - _USUAL) / (2.0 - _USUAL), [of for of in materials if of]
        if there:
            normal = math.fsum(1.0 / of.plane_strain_modulus for of in there)
            ratio = normal / math.fsum((2.0 - of.nu) / (4.0 * of.shear_modulus) for of in there)
        removed = [of.oblique for of in known if of and of.oblique is not None]
        return Friction(self.mu, ratio, np.asarray(sum(removed)) if removed else None)

    def for_core(self, law: ContactLaw, precision: float) -> tuple[Any, ...]:
        """Return it as the core takes it, to a precision; the normal compliance is the law's.

        A change of the normal compliance, by the contact's width or by an error, changes those of
        the tangents in the ratio of both.
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
        Numbers of the bodies in the plan, and of the places where they are touched; the indentation
        is the first's coordinate minus the second's minus the gap.
    law : ContactLaw
        Law between the models: without the compliance of their meshes at the contact.
    gap : float
        Distance at the start, m.
    name : str
        As its user called it.
    friction : Friction or None
        With it, ports are three each: along the normal and along two tangents.
    removed : (float, float)
        Compliances of the two bodies' meshes that were taken out of the law, m/N.
    width : float or None
        Radius of the contact at its largest force, m, where it is known.
    law_error : float
        Relative error of the law's stiffness, by that of the curvatures that it was found from.
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
        """Return the contact of models, given that of the bodies themselves.

        The compliance that their meshes have in place of a half-space is taken out of the law.

        Parameters
        ----------
        bodies : sequence of BodyModel
            Those of the scene.
        bounded : bool, optional
            True to leave a contact that is stiffer than its meshes its whole law. On a shell its
            force is a bound; with the compliance taken out as far as it can be it is another.

        Raises
        ------
        InputError
            If the law is more compliant than the meshes from the first touch on.
        """
        known = [extraction_of(self.law, bodies[body], port) for body, port in self.ports]
        friction = self.friction and self.friction.between(self.materials(bodies), known)
        removed = tuple(0.0 if of is None else of.removed_for(self.width) for of in known)
        left = bounded and math.fsum(removed) > 0.0
        if left or isinstance(self.law, PatchLaw):  # the caller has taken it out
            return self._replace(friction=friction)
        law = effective_law(self.law, math.fsum(removed))
        return self._replace(law=law, removed=removed, friction=friction)

    def materials(self, bodies: Sequence[BodyModel]) -> list[Material | None]:
        """Return the materials of both bodies where they touch; None of one given by numbers."""
        return [
            None if of is None else of.material
            for body, port in self.ports
            for of in (bodies[body].touched_at(port) or bodies[body].surface_at(port),)
        ]

    def own_indentation(self, rows: ContactRows) -> FloatArray:
        """Return the law's own indentation, m: δ + c F with the compliance c taken out of it.

        c couples the normal to the tangents where there is friction.
        """
        c = self.law.compliance if isinstance(self.law, PatchLaw) else 0.0
        depth = rows.indentation + c * rows.force
        if self.friction and self.friction.compliance is not None and rows.tangential is not None:
            depth += self.friction.compliance[0, 1:] @ rows.tangential
        return depth

    @property
    def size(self) -> int:
        """Number of its forces."""
        return 1 if self.friction is None else 3

    @property
    def ports(self) -> tuple[Port, Port]:
        """The two places that touch."""
        return Port(self.first, self.first_port), Port(self.second, self.second_port)

    def for_core(self, law: CoreLaw, precision: float = _PRECISION) -> tuple[Any, ...]:
        """Return it as the core takes it, with its law as the core takes that.

        precision: of friction's stretches, as a share of the largest.
        """
        if self.friction is None:
            return *self[:4], self.gap, law
        return *self[:4], self.gap, law, self.friction.for_core(self.law, precision)

    def port_of(self, body: int) -> int:
        """Return where one of the two is touched."""
        return self.first_port if body == self.first else self.second_port

    def touches(self, body: int) -> bool:
        """Return whether a body is one of the two."""
        return body in (self.first, self.second)


class Load(NamedTuple):
    """A force on a port, linear between times and constant outside them.

    Attributes
    ----------
    body, port : int
        As in :class:`Port`.
    times, forces : ndarrays, shape (m,)
        s, ascending; N, along the direction of travel.
    """

    body: int
    port: int
    times: FloatArray
    forces: FloatArray
