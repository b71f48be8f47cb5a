"""The contact law between bodies that touch over patches: without the patches' own deflection.

Here it is decided which law acts; `PatchLaw` stands in law.py, beside `ContactLaw.within_patch`.

Each body's finite elements contain the indentation of its patch, and the law contains all of the
contact's. The deflection of an elastic half-space under the patch, c per force, is in both; it is
taken out of the law, F = law(δ + c F). What then remains is the law's own contact, narrower than
the patch, on the real body, whose mesh matters no more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..base import FloatArray, InputError, LawLimitError
from ..fem import ContactPoint, Patch
from .law import ContactLaw, PatchLaw

__all__ = ["check_width", "effective_law", "own_law", "wide_enough"]


# The share c dF/dδ of the patch that an error message proposes where the present one is too small.
# For Hertz's contact of radius a within patches of radius r on two like bodies the share is
# 1.2 a/r, so 0.6 makes a half of r.
_COMFORTABLE = 0.6

# The same for a patch on one body alone: the contact's radius as a share of the patch's.
_COMFORTABLE_WIDTH = 0.8

# Indentations, as shares of a patch's radius, among which the deepest of an impact is searched.
_DEPTHS = np.geomspace(1e-12, 1.0, 300)


def effective_law(law: ContactLaw, ends: Sequence[ContactPoint | None]) -> ContactLaw:
    """Return the law between two bodies: as it is, if neither is touched over a patch.

    The law returned is valid as long as the contact is not wider than the patches, and as long as
    c dF/dδ is below the share allowed. The width is known of laws with surfaces, as those of
    `Hertz.between` and `Thornton.between`. Between two like bodies with patches the share is the
    narrower limit: it is reached at a contact radius of 0.8 r.

    Parameters
    ----------
    law : ContactLaw
    ends : sequence of ContactPoint or None
        Where the bodies touch; None of one given by numbers.

    Raises
    ------
    InputError
        If the law is stiffer than the patches from the first touch on.
    """
    patches = _patches(ends)
    if not patches or isinstance(law, PatchLaw):
        return law
    compliance = math.fsum(patch.compliance for patch in patches)
    try:
        return law.within_patch(compliance, radius=min(patch.radius for patch in patches))
    except InputError:
        raise InputError(
            f"law={law!r} between patches of radius {_listed([p.radius for p in patches])}, which "
            f"deflect by {compliance:.3g} m/N: even the lightest contact is stiffer; give the "
            "contact points a larger radius, or none if the law leaves out the bodies' own "
            "indentation"
        ) from None


def own_law(law: ContactLaw) -> ContactLaw:
    """Return the law that the caller gave."""
    return law.law if isinstance(law, PatchLaw) else law


def check_width(law: ContactLaw, indentation: FloatArray, contact: int) -> None:
    """Refuse a record in which the contact of that number has grown wider than its patches."""
    if isinstance(law, PatchLaw) and float(indentation.max(initial=0.0)) > law.limit:
        raise LawLimitError("the contact has grown wider than its patches", contact)


def wide_enough(
    error: LawLimitError,
    law: ContactLaw,
    ends: Sequence[ContactPoint | None],
    mass: float,
    velocity: float,
) -> LawLimitError:
    """Return the error of a contact wider than its patches with the radius that would do.

    Rigid bodies at that velocity go deeper than elastic ones.

    Parameters
    ----------
    mass : float
        Effective mass of the two bodies, kg.
    velocity : float
        At which they meet, m/s.
    """
    radii = [patch.radius for patch in _patches(ends)]
    if not isinstance(law, PatchLaw) or not radii:
        return error
    depths = min(radii) * _DEPTHS
    try:
        deep = law.law.potential(depths) >= 0.5 * mass * velocity**2
        depth = depths[int(np.argmax(deep))] if deep.any() else depths[-1]
        # A damped law is steepest at the rate at which the bodies meet.
        step = law.law.force(depth, velocity) - law.law.force(0.99 * depth, velocity)
        slope = step / (0.01 * depth)
    except LawLimitError:  # it is the law's own table that ends
        return error
    factor, of_surface = max(law.compliance * float(slope) / _COMFORTABLE, 1.1), ""
    if law.law.relative_radius is not None:
        of_surface = f" of relative_radius={law.law.relative_radius:.3g} m"
        wide = math.sqrt(law.law.relative_radius * float(depth))
        factor = max(factor, wide / (_COMFORTABLE_WIDTH * min(radii)))
    wanted = factor * min(radii)
    small = [end for end in ends if end and end.patch and end.patch.radius < wanted]
    if all(end.automatic for end in small):
        cure = (
            "and the bodies have no room for larger ones there: check that radii and meshes are in "
            "metres, take a lower velocity, or a point farther from edges and supports"
        )
    else:
        listed = _listed([max(radius, wanted) for radius in radii])
        cure = (
            f"for this impact make the contact points with radius={listed} or more, where the "
            "bodies have room"
        )
    return LawLimitError(
        f"{error.args[0].partition(': ')[0]}: with patches of radius {_listed(radii)} the law"
        f"{of_surface} is valid up to an indentation of {law.limit:.3g} m beyond their own "
        f"deflection, less for a damped law at this velocity; {cure}",
        error.contact,
    )


def _patches(ends: Sequence[ContactPoint | None]) -> list[Patch]:
    return [end.patch for end in ends if end is not None and end.patch is not None]


def _listed(radii: Sequence[float]) -> str:
    return " and ".join(f"{radius:.2g} m" for radius in dict.fromkeys(radii))
