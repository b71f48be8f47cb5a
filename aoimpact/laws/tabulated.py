"""A contact law through measured points."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from ..base import FloatArray, InputError, finite_array
from .law import ContactLaw


@dataclass(frozen=True, repr=False)
class Tabulated(ContactLaw, kind="table"):
    """A law through points, by monotone cubic interpolation (PCHIP).

    F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238-246, with the slopes of
    F. N. Fritsch, J. Butland (SciPy's PCHIP). An impact that goes deeper than the last point is an
    error: the table has no force there.

    Parameters
    ----------
    indentation : array_like, shape (n,)
        m, increasing, not negative; (0, 0) is put before a table that does not begin with it.
    force : array_like, shape (n,)
        N, never falling, positive from the first indentation above 0 on.

    Attributes
    ----------
    indentation, force : tuple of float

    Examples
    --------
    >>> law = ao.Tabulated(indentation=[0.0, 1e-4, 2e-4], force=[0.0, 100.0, 300.0])
    >>> round(float(law.force(1.5e-4)), 6)
    185.416667
    """

    indentation: tuple[float, ...]
    force_values: tuple[float, ...]

    def __init__(self, indentation: npt.ArrayLike, force: npt.ArrayLike) -> None:
        depth = finite_array("indentation", indentation, shape=(None,), unit="m")
        push = finite_array("force", force, shape=(len(depth),), unit="N")
        if len(depth) == 0 or (len(depth) == 1 and depth[0] == 0.0):
            raise InputError("indentation and force must have a point besides (0, 0)")
        if depth[0] != 0.0:
            depth, push = np.insert(depth, 0, 0.0), np.insert(push, 0, 0.0)
        for name, unit, values in (("indentation", "m", depth), ("force", "N", push)):
            steps, least = np.diff(values), math.ulp(0.0) if values is depth else 0.0
            if (steps < least).any():
                i = int(np.argmax(steps < least))
                raise InputError(
                    f"{name} must {'increase' if least else 'never fall'} from point to point: "
                    f"after {values[i]:g} {unit} comes {values[i + 1]:g} {unit}"
                )
        if push[0] != 0.0 or push[1] == 0.0:
            raise InputError(
                f"force must be 0 N at indentation 0 and positive at {depth[1]:g} m, got "
                f"{push[0]:g} N and {push[1]:g} N; put what comes before the force into the gap"
            )
        object.__setattr__(self, "indentation", tuple(depth.tolist()))
        object.__setattr__(self, "force_values", tuple(push.tolist()))
        if not np.isfinite(self._table).all():
            raise InputError(
                f"indentation up to {depth[-1]:g} m and force up to {push[-1]:g} N have slopes or "
                "energies that are no numbers; leave points out that are far from any motion"
            )

    def __repr__(self) -> str:
        return (
            f"Tabulated({len(self.indentation)} points up to {self.indentation[-1]:g} m, "
            f"{self.force_values[-1]:g} N)"
        )

    @property
    def limit(self) -> float:
        return self.indentation[-1]

    def _data(self) -> FloatArray:
        return self._table

    @functools.cached_property
    def _table(self) -> FloatArray:
        """The core's table, shape (4, n): indentations, forces, slopes, energies."""
        depth, push = np.array(self.indentation), np.array(self.force_values)
        length = np.diff(depth)
        with np.errstate(over="ignore", invalid="ignore"):  # of a rise next to none, or next to all
            try:
                slope = scipy.interpolate.PchipInterpolator(depth, push).derivative()(depth)
                # Hermite's cubic integrates to the trapezium's area and what the slopes add to it.
                lean = length * (slope[:-1] - slope[1:]) / 12.0
                area = length * ((push[:-1] + push[1:]) / 2.0 + lean)
                energy = np.array([math.fsum(area[:i]) for i in range(len(depth))])
            except (ValueError, OverflowError):  # of slopes or energies that are no numbers
                return np.full((4, len(depth)), np.nan)
        return np.stack([depth, push, np.maximum(slope, 0.0), energy])
