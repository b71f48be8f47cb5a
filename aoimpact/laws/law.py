"""Interface of all contact laws, and laws with the compliance of the bodies' meshes removed.

The bodies' meshes have a local compliance c at the contact (`contact/extraction.py`). The law of
half-spaces already contains the local indentation, so that c is removed from the law:
F = law(δ + c F).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import Field, dataclass, field, fields, replace
from functools import cached_property, lru_cache, partial
from typing import Any, ClassVar, NamedTuple, Self, cast

import numpy as np
import numpy.typing as npt
import scipy

from .. import _core
from ..base import (
    HUGE,
    PRINTED,
    ROUNDING,
    FloatArray,
    InputError,
    LawLimitError,
    boolean,
    finite_array,
    instance,
    positive,
    real,
    with_unit,
    within,
)
from .rebound import damping_for, integrated_restitution


class CoreLaw(NamedTuple):
    """A law in the form that the core's binding reads.

    Attributes
    ----------
    kind : str
        Name of the law's row in csrc/law.
    parameters : tuple of float
        Parameters of `aoi_law_create`.
    compliance, limit : float
        Compliance removed from the law, m/N, and largest indentation of the resulting law, m.
    note : ndarray, shape (3,)
        Output of the core: indentation and rate at which the law's force was NaN or jumped, and
        the error code.
    data : object
        Table or functions of a law given by the caller, else None.
    """

    kind: str
    parameters: tuple[float, ...]
    compliance: float
    limit: float
    note: FloatArray
    data: Any


class Dent(NamedTuple):
    """The dent that a contact leaves in the surfaces.

    Attributes
    ----------
    depth : float
        Residual indentation, m.
    diameter : float
        Diameter of the contact when it was deepest, m; NaN if the law has no contact radius.
    """

    depth: float
    diameter: float


# Largest c dF/dδ at which the compliance c is removed from a law, as in csrc/law/law.c. At this
# value the remaining law is twenty times as stiff as the given one and, between equal bodies, the
# contact radius is 0.8 of the patch's radius.
MOST_SHARE = 0.95

# Eccentricity e up to which summaries omit it: √(a b) then differs from a circle's radius by about
# e⁴.
_ROUND = 0.1

# Symbols of some parameters in summaries.
_SYMBOLS = {"relative_radius": "R", "yield_force": "F_y"}

# Indentations, m, _DECADE per decade, among which c dF/dδ = MOST_SHARE is searched. Searches begin
# at small values, as a user's law may not be defined far beyond the indentations of its use.
_DECADE = 40
_INDENTATIONS = np.geomspace(1e-15, 1e5, 20 * _DECADE + 1)


def parameter(check: Callable[..., Any], unit: str = "", **options: Any) -> dict[str, Any]:
    """Return the metadata of a law's field: the check of its value, and its unit.

    Parameters
    ----------
    check : callable
        Takes the name, the value, the unit if there is one, and `options` by keyword; returns the
        value that is kept.
    unit : str, optional
        Unit in messages and summaries.
    """
    return {"check": partial(check, **options, **({"unit": unit} if unit else {})), "unit": unit}


class ContactLaw:
    """The force between two bodies as a function of indentation, its rate, and its history.

    Every law is a frozen dataclass; its formulas are in the core (csrc/law). The field `k` is
    positive; other fields have `parameter` metadata. Numerical fields that are not keyword-only are
    the parameters of the law's row in csrc/law. Keywords of the class statement set the name of
    that row, `kind`, and other class attributes.

    Attributes
    ----------
    depends_on_rate : bool
        True if the force depends on the rate of the indentation.
    has_memory : bool
        True if the force depends on the history of the contact.

    Examples
    --------
    >>> laws = ao.Hertz(k=1e9), ao.Linear(k=1e7)
    >>> [isinstance(law, ao.ContactLaw) for law in laws]
    [True, True]
    >>> [round(float(law.force(1e-4)), 1) for law in laws]  # N at 0.1 mm
    [1000.0, 1000.0]
    """

    # Name of the law's row in csrc/law.
    kind: str = ""

    depends_on_rate: bool = False
    has_memory: bool = False

    # True if functions of the caller, which may be slow, noisy or wrong, give the force.
    by_caller: bool = False

    # True if the force may be negative: the contact then ends where the indentation reaches 0.
    pulls: bool = False

    # `power`: exponent of the indentation on loading, for laws without a parameter n.
    # `unloading_power`: exponent on unloading, for laws with memory.
    power: ClassVar[float] = 1.5
    unloading_power: ClassVar[float] = 1.5

    # Name of the parameter that the damping is proportional to, for laws with `_closed_form`.
    damped_by: ClassVar[str] = ""

    # Relative radius of curvature R, m, for laws with a contact radius √(R δ).
    relative_radius: float | None = None

    def __init_subclass__(cls, **traits: Any) -> None:
        super().__init_subclass__()
        for name, value in traits.items():
            setattr(cls, name, value)

    def __post_init__(self) -> None:
        for entry in self._fields():
            name, value = entry.name, getattr(self, entry.name)
            if "check" in entry.metadata and not (value is entry.default is None):
                object.__setattr__(self, name, entry.metadata["check"](name, value))
        if hasattr(self, "k"):
            object.__setattr__(self, "k", positive("k", self.k, unit=self.units["k"]))
        try:
            self._evaluate(np.zeros(()), np.zeros(()))
        except InputError:
            raise InputError(self._refused()) from None

    def _refused(self) -> str:
        """Return the message of the error raised if the core cannot make the law."""
        return f"{self!r} has powers of parameters beyond the range of numbers"

    def _fields(self) -> tuple[Field[Any], ...]:
        return fields(cast(Any, self))

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name.

        :meta private:
        """
        power = getattr(self, "n", self.power)
        units = {e.name: e.metadata["unit"] for e in self._fields() if "unit" in e.metadata}
        return units | {"k": "N/m" if power == 1.0 else f"N/m^{power:g}"}

    def _given(self) -> dict[str, Any]:
        """Return the fields by name, keyword-only fields last and only if they are set."""
        entries = {e.name: getattr(self, e.name) for e in self._fields() if not e.kw_only}
        options = {e.name: getattr(self, e.name) for e in self._fields() if e.kw_only}
        return entries | {name: value for name, value in options.items() if value}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self._given().items())})"

    def __str__(self) -> str:
        """Return the law and its parameters with units, for summaries."""
        units, given = self.units, self._given()
        if not given.keys() <= units.keys():
            return repr(self)
        if given.get("eccentricity", 0.0) <= _ROUND:
            given.pop("eccentricity", None)
        parts = [
            f"{_SYMBOLS.get(name, name)} = "
            + (value if isinstance(value, str) else with_unit(value, units[name], 3))
            for name, value in given.items()
            if value is not None
        ]
        return ", ".join([type(self).__name__, *parts])

    @cached_property
    def _parameters(self) -> tuple[float, ...]:
        """Parameters that the core makes the law from, in the order of its row in csrc/law."""
        values = [getattr(self, entry.name) for entry in self._fields() if not entry.kw_only]
        return tuple([value for value in values if isinstance(value, float)])

    @property
    def limit(self) -> float:
        """Largest indentation for which the law holds, m."""
        return math.inf

    def for_core(self) -> CoreLaw:
        """Return the form that the core's ``take_law`` reads; a new one for each call of the core.

        :meta private:
        """
        return CoreLaw(self.kind, self._parameters, 0.0, math.inf, np.full(3, math.nan), None)

    def force(
        self, indentation: npt.ArrayLike, rate: npt.ArrayLike = 0.0, *, along: bool = False
    ) -> Any:
        """Return the contact force; for a law with memory, that of loading.

        Parameters
        ----------
        indentation : array_like
            Indentation δ, m; the force is zero where δ ≤ 0.
        rate : array_like, optional
            Rate dδ/dt, m/s; broadcast against `indentation`.
        along : bool, optional
            True for indentations that are a history in time, in which a law with memory unloads.

        Returns
        -------
        float or ndarray
            Force, N, in the broadcast shape.

        Examples
        --------
        >>> law = ao.Hertz(k=1e9)
        >>> round(float(law.force(1e-4)), 6)  # N
        1000.0
        """
        delta, delta_rate = np.broadcast_arrays(
            finite_array("indentation", indentation, unit="m"),
            finite_array("rate", rate, unit="m/s"),
        )
        force = self._evaluate(delta, delta_rate, boolean("along", along))[0]
        return force if force.ndim else float(force)

    def _evaluate(
        self, indentation: FloatArray, rate: FloatArray, along: bool = False
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return force, N, dF/dδ, N/m, and dF/d(dδ/dt), N s/m, of arrays of one shape."""
        force, stiffness, damping = (np.empty(indentation.shape) for _ in range(3))
        _core.law_force(
            self.for_core(),
            np.ascontiguousarray(indentation),
            np.ascontiguousarray(rate),
            force,
            stiffness,
            damping,
            along,
        )
        return force, stiffness, damping

    def potential(self, indentation: npt.ArrayLike) -> Any:
        """Return the elastic energy that unloading from an indentation gives back, J.

        Examples
        --------
        >>> law = ao.Linear(k=1e7)
        >>> round(float(law.potential(1e-4)), 9)  # J, k δ²/2
        0.05
        """
        depth = finite_array("indentation", indentation, unit="m")
        energy = np.empty(depth.shape)
        _core.law_potential(self.for_core(), depth, energy)
        return energy if energy.ndim else float(energy)

    def within_patch(self, compliance: float) -> PatchLaw:
        """Return the law without a compliance that the bodies' models already contain.

        With c removed, F = law(δ + c F).

        Parameters
        ----------
        compliance : float
            Compliance c, m/N, the sum over both bodies, in addition to compliances removed before.
            c is negative if a shell's model is stiffer than the shell: -c is then in series with
            the law.

        Raises
        ------
        InputError
            If nothing is left of the law: c dF/dδ is near 1 at every indentation.

        Examples
        --------
        >>> law = ao.Linear(k=1e7)
        >>> round(float(law.within_patch(1e-8).force(1e-4)), 6)  # 1/(1/k - c) is the stiffness left
        1111.111111
        """
        c = real("compliance", compliance, unit="m/N")
        deepest = min(self._steepest(c) if c > 0.0 else math.inf, self.limit)
        limit = deepest - c * self.force(deepest) if math.isfinite(deepest) else math.inf
        if not limit > 0.0:
            raise InputError(f"compliance={c:g} m/N leaves nothing of {self!r}")
        return PatchLaw(self, c, limit)

    def _stiffest(self, indentation: FloatArray) -> FloatArray:
        """Return the larger slope dF/dδ, N/m, of loading and unloading at indentations, m."""
        force, steepest, _ = self._evaluate(indentation, np.zeros(indentation.shape))
        if self.has_memory:  # unloading by F* x^n begins with the slope n F*/(δ* - δ_p)
            n = self.unloading_power
            unloading = n / (n + 1.0) * force**2 / self.potential(indentation)
            steepest = np.maximum(steepest, unloading)
        return steepest

    def _steepest(self, compliance: float) -> float:
        """Return the indentation δ + c F of the law, m, up to which c dF/dδ is below MOST_SHARE."""

        def excess(delta: FloatArray | float) -> Any:
            return compliance * self._stiffest(np.asarray(delta)) - MOST_SHARE

        within = _INDENTATIONS[self.limit >= _INDENTATIONS]
        for start in range(0, len(within), _DECADE):  # from shallow to deep
            try:
                with np.errstate(all="ignore"):
                    beyond = excess(within[start : start + _DECADE]) >= 0.0
            except Exception:  # a user's law may fail at depths that no run reaches
                if start == 0:
                    raise
                break
            if beyond[0] and start == 0:
                raise InputError(f"compliance={compliance:g} m/N exceeds that of {self!r}")
            if beyond.any():
                high = start + int(beyond.argmax())
                ends = within[high - 1], within[high]
                try:
                    return float(scipy.optimize.brentq(excess, *ends, xtol=np.finfo(float).tiny))
                except ValueError:  # excess has no change of sign: a noisy law
                    return float(ends[0])
        return math.inf

    def _work(self, indentation: float) -> float:
        """Return the work ∫ F dδ of loading up to an indentation at zero rate, J."""
        return float(self.potential(indentation))

    def stroke(self, energy: float) -> float:
        """Return the indentation at which loading at zero rate has absorbed an energy.

        Parameters
        ----------
        energy : float
            Absorbed energy, J.

        Returns
        -------
        float
            Indentation, m; the law's limit if this is smaller.

        Raises
        ------
        InputError
            If the indentation lies beyond the range of numbers.

        Examples
        --------
        >>> law = ao.Linear(k=1e7)
        >>> round(law.stroke(0.05), 9)  # m, √(2E/k)
        0.0001
        """
        energy = positive("energy", energy, unit="J")
        if not self.has_memory and (k := getattr(self, "k", None)):  # the work is k δ^(n+1)/(n+1)
            n = getattr(self, "n", self.power)
            found = (math.log(energy) + math.log(n + 1.0) - math.log(k)) / (n + 1.0)
        else:

            def excess(depth: float) -> float:
                return self._work(depth) - energy

            end = self.limit * (1.0 - ROUNDING)
            low, high = 0.0, min(float(_INDENTATIONS[0]), end)
            while (short := self._work(high) < energy) and high < min(end, _INDENTATIONS[-1]):
                low, high = high, min(2.0 * high, end)
            depth = high if high == end else math.inf
            if not short:
                depth = scipy.optimize.brentq(excess, low, high, xtol=1e-300, maxiter=1000)
            found = math.log(depth)
        if not abs(found) < math.log(HUGE):
            raise InputError(
                f"energy={energy:g} J is taken by {self!r} at no indentation within its range"
            )
        return math.exp(found)

    def dent(self, indentation: float) -> Dent:
        """Return the dent that remains after a deepest indentation.

        Parameters
        ----------
        indentation : float
            Deepest indentation, m.

        Returns
        -------
        Dent
            ``depth`` and ``diameter``, m; both 0 if the law unloads along its loading curve.

        Examples
        --------
        >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800, yield_strength=600e6)
        >>> law = ao.ElasticPlastic.between(steel, 0.005, steel, float("inf"))
        >>> depth, diameter = law.dent(50e-6)
        >>> pressure = law.force(50e-6) / (0.25 * np.pi * diameter**2)
        >>> round(pressure / law.hardness, 6)  # fully plastic
        1.0
        """
        deepest = positive("indentation", indentation, unit="m")
        force = self.force(deepest) if self.has_memory else 0.0
        if force == 0.0:
            return Dent(0.0, 0.0)
        # The energy of unloading is F* (δ* - δ_p)/(n + 1).
        depth = deepest - (self.unloading_power + 1.0) * self.potential(deepest) / force
        if depth < ROUNDING * deepest:
            return Dent(0.0, 0.0)
        return Dent(depth, 2.0 * self._contact_radius(deepest))

    def _contact_radius(self, indentation: float) -> float:
        """Return the contact radius on loading, m; NaN if the law has none."""
        if self.relative_radius is None:
            return math.nan
        return math.sqrt(self.relative_radius * indentation)

    def rigid_restitution(self, mass: float, velocity: float) -> float:
        """Return the restitution of a rigid pair of reduced mass `mass`, kg, at a velocity, m/s.

        See `restitution`.

        Examples
        --------
        >>> law = ao.Tsuji.from_restitution(1e9, 0.5, mass=0.1)
        >>> round(law.rigid_restitution(0.1, 1.0), 6)
        0.5
        """
        m, v = positive("mass", mass, unit="kg"), positive("velocity", velocity, unit="m/s")
        energy, delivered = 0.5 * m * v * v, math.nan
        if 1.0 / HUGE < energy < HUGE:  # else powers of mass or velocity may underflow
            with suppress(ArithmeticError):
                if self.damped_by:
                    closed_form, scale = self._closed_form(m, v)
                    delivered = closed_form(scale * getattr(self, self.damped_by))
                elif self.depends_on_rate:
                    delivered = integrated_restitution(self.force, m, v, self.stroke(energy))
                elif self.has_memory:
                    deepest = self.stroke(energy)
                    delivered = math.sqrt(self.potential(deepest) / self._work(deepest))
                else:
                    delivered = 1.0
        if 1.0 + PRINTED < delivered < math.inf:
            raise InputError(
                f"law={self!r} gives more energy than it takes: at mass={m:g} kg and velocity="
                f"{v:g} m/s rigid bodies would part {delivered:g} times as fast as they meet; let "
                "its force be no larger on the way out than on the way in"
            )
        if not 0.0 <= delivered < math.inf:
            raise InputError(
                f"mass={m:g} kg and velocity={v:g} m/s on {self!r}: some power of them is beyond "
                "the range of numbers; give values nearer to 1 (kg, m/s, N/m^n)"
            )
        return min(delivered, 1.0)

    def _closed_form(self, mass: float, velocity: float) -> tuple[Callable[[float], float], float]:
        """Return the restitution as a function of a damping number, and the number per `damped_by`.

        `damped_by` names the parameter of the law that the damping number is proportional to.
        """
        raise NotImplementedError

    def _delivering(
        self,
        restitution: float,
        mass: float,
        velocity: float,
        number: Callable[[float], float] | None = None,
    ) -> Self:
        """Return the law with restitution e; `number`: published formula for its damping number."""
        e = within("restitution", restitution, ROUNDING, 1.0)
        m, v = positive("mass", mass, unit="kg"), positive("velocity", velocity, unit="m/s")
        closed_form, scale = self._closed_form(m, v)
        reached = damping_for(closed_form, e) if number is None else number(e)
        law: Self = replace(cast(Any, self), **{self.damped_by: reached / scale})
        return law


def restitution(law: ContactLaw, mass: Any, velocity: Any) -> float:
    """Return the restitution of a rigid pair: the ratio of separation speed to approach speed.

    The restitution is computed in closed form if there is one, by energy for laws with plastic
    loss, else by integration to ten digits, and never by formulas fitted to a nominal restitution.

    Parameters
    ----------
    law : ContactLaw
    mass : float
        Reduced mass of the pair, m1 m2 / (m1 + m2), kg; against a wall the mass of the body.
    velocity : float
        Approach velocity, m/s.

    Returns
    -------
    float
        e, from 0 to 1.

    Raises
    ------
    InputError, InputTypeError
        If `law` is no contact law, `mass` or `velocity` is not positive, a number overflows or
        underflows, or a user's law gives more energy than it takes.

    Examples
    --------
    >>> published = ao.HuntCrossley.from_restitution(1e9, 0.5, velocity=1.0, formula="flores")
    >>> round(ao.restitution(published, mass=0.01, velocity=1.0), 4)
    0.4704
    >>> law = ao.HuntCrossley.from_restitution(k=1e9, restitution=0.5, velocity=1.0)
    >>> round(ao.restitution(law, mass=0.01, velocity=1.0), 12)
    0.5
    """
    return float(instance("law", law, ContactLaw).rigid_restitution(mass, velocity))


def removable(law: ContactLaw, indentation: float) -> float:
    """Return the largest compliance, m/N, removable from a law used up to an indentation, m."""
    return MOST_SHARE / float(law._stiffest(np.array(indentation)))


@dataclass(frozen=True, repr=False)
class HertzianLaw(ContactLaw):
    """A law that begins with Hertz's k δ^(3/2), and may have a contact radius.

    Parameters
    ----------
    relative_radius : float, optional
        Relative radius of curvature R, m: the contact radius is √(R δ).
    """

    relative_radius: float | None = field(
        default=None, kw_only=True, metadata=parameter(positive, "m")
    )


@dataclass(frozen=True)
class PatchLaw(ContactLaw):
    """A law with the compliance of the bodies' models at the contact removed: F = law(δ + c F).

    Made by :meth:`ContactLaw.within_patch`.

    Parameters
    ----------
    law : ContactLaw
    compliance : float
        Removed compliance c, m/N.
    limit : float, optional
        Largest indentation δ for which the law holds, m.
    """

    law: ContactLaw
    compliance: float
    limit: float = math.inf

    def __post_init__(self) -> None:
        for trait in ("depends_on_rate", "has_memory", "by_caller", "pulls"):
            object.__setattr__(self, trait, getattr(self.law, trait))

    def __str__(self) -> str:
        done = "removed" if self.compliance > 0.0 else "added"
        return (
            f"{self.law} (compliance of the mesh {done}: "
            f"{with_unit(abs(self.compliance), 'm/N', 3)})"
        )

    def for_core(self) -> CoreLaw:
        return self.law.for_core()._replace(compliance=self.compliance, limit=self.limit)

    def within_patch(self, compliance: float) -> PatchLaw:
        more = real("compliance", compliance, unit="m/N")
        return self.law.within_patch(self.compliance + more)

    def dent(self, indentation: float) -> Dent:
        own = indentation + self.compliance * self.force(indentation)
        return self.law.dent(own)

    def _work(self, indentation: float) -> float:
        force = self.force(indentation)
        own = self.law._work(indentation + self.compliance * force)
        return float(own - 0.5 * self.compliance * force**2)


@lru_cache(maxsize=256)  # many models of the same bodies have the same law
def effective_law(law: ContactLaw, compliance: float) -> ContactLaw:
    """Return a law with a compliance, m/N, removed; a `PatchLaw` is returned unchanged.

    Raises
    ------
    InputError
        If the law is stiffer than the bodies' meshes from the first touch on.
    """
    if compliance == 0.0 or isinstance(law, PatchLaw):
        return law
    try:
        return law.within_patch(compliance)
    except InputError:
        raise InputError(
            f"law={law!r} is stiffer than the meshes at the contact ({compliance:.3g} m/N) from "
            "the first touch on. Give the contact points a larger radius, or none."
        ) from None


def own_law(law: ContactLaw) -> ContactLaw:
    """Return the law that the caller gave, without the removal of a compliance."""
    return law.law if isinstance(law, PatchLaw) else law


def check_width(law: ContactLaw, indentation: FloatArray, contact: int) -> None:
    """Refuse indentations at which the contact of number `contact` is stiffer than the meshes."""
    if isinstance(law, PatchLaw) and float(indentation.max(initial=0.0)) > law.limit:
        raise LawLimitError("the contact is stiffer than the meshes there", contact)
