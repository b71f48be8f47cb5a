"""How far the force of a user's law scatters: no run can be more exact than that."""

from __future__ import annotations

import math

import numpy as np

from ..base import ConvergenceError
from ..laws import ContactLaw
from ..scene import Contact, Scenario

# A user's law whose force scatters by a larger share is refused under any tolerance: steps grow
# with its root. A contact takes 3 steps without scatter, 60 with 1e-9, and 6 000 with this share.
_ROUGHEST = 1e-5

# Largest scatter of a user's law as a share of the tolerance: above it steps resolve the scatter
# itself. A contact under a force with a wave of 6e-12 m takes up to 800 steps with a scatter of
# 0.05 of a tolerance of 1e-5 to 1e-7, and is not over after 4 million calls of the law with 0.16.
_ROUGHEST_SHARE = 0.1

# Over this share of an indentation any smooth law is a cubic, but for rounding.
_WINDOW = 1e-4

# Points in it, at random: over even steps a wave, or the rounding of numbers of few digits, may
# repeat itself and look smooth. With 24 a wave's root mean square is found within 12 %.
_POINTS = np.sort(np.random.default_rng(4).uniform(-1.0, 1.0, 24))
_CUBIC = np.vander(_POINTS, 4)
_BESIDE = np.eye(len(_POINTS)) - _CUBIC @ np.linalg.pinv(_CUBIC)  # what is not in a cubic

# Where to look: shares of the deepest indentation that rigid bodies would have, with shares of the
# fastest approach. A kink at one of them is no roughness.
_PLACES = ((0.03, 0.9), (0.1, -0.7), (0.2, 0.5), (0.4, -0.3), (0.6, 0.1))

# The indentation to look at where rigid bodies give none, m.
_SOME = 1e-6


def refuse_rough(plan: Scenario, rtol: float) -> None:
    """Check that the user's laws of a scene are smooth enough for a tolerance.

    Raises
    ------
    ConvergenceError
        If a law is not.
    """
    for number, contact in enumerate(plan.contacts):
        if contact.law.by_caller:
            share = scatter(contact.law, _depth(plan, contact), plan.fastest)
            most = min(_ROUGHEST_SHARE * rtol, _ROUGHEST)
            if share > most:
                larger = (
                    f"take rtol={2.0 * share / _ROUGHEST_SHARE:.1g}, " if share < _ROUGHEST else ""
                )
                raise ConvergenceError(
                    f"contact {number}: the user's law is not smooth to the tolerance "
                    f"rtol={rtol:g}: at neighbouring indentations its force scatters by "
                    f"{share:.1g} of itself, and may by {most:.1g}; compute it more exactly, "
                    f"smooth it, {larger}or Newmark(dt=...)"
                )


def scatter(law: ContactLaw, depth: float, speed: float) -> float:
    """Estimate by how much of itself a law's force scatters between neighbouring indentations.

    What is left beside the best cubic through neighbouring points: the median of some places.

    Parameters
    ----------
    law : ContactLaw
    depth, speed : float
        About the largest indentation, m, and rate, m/s, that it will see.
    """
    found = []
    for place, pace in _PLACES:
        try:
            with np.errstate(all="ignore"):
                indentations = place * depth * (1.0 + 0.5 * _WINDOW * _POINTS)
                force = law.force(indentations, pace * speed)
        except Exception:  # the run reports it, should it come there
            continue
        size = float(np.abs(force).max())
        if 0.0 < size < np.inf:
            left = float(np.linalg.norm(_BESIDE @ (force / size)))
            found.append(left / math.sqrt(len(_POINTS) - 4))
    return float(np.median(found)) if found else 0.0


def _depth(plan: Scenario, contact: Contact) -> float:
    """The deepest indentation of rigid bodies; a micrometre where that is not known."""
    energy = 0.5 * plan.reduced_mass(contact) * plan.fastest**2
    try:
        with np.errstate(all="ignore"):
            return contact.law.stroke(energy) if energy > 0.0 else _SOME
    except Exception:  # the user's law raises where a run may never come
        return _SOME
