"""Drop-weight tests: velocity, deflection and absorbed energy of the impactor from its force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base import (
    FilePath,
    FloatArray,
    Frozen,
    InputError,
    choice,
    draw_curves,
    nonnegative,
    positive,
    real,
    warn,
    with_unit,
    write_csv,
)
from ..fields import Channel
from ..results import Result
from .signal import RISEN, STANDARD_GRAVITY, UNFILTERED, Signal, contacts

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Share of the impact energy that is larger than the error due to a force channel, and smaller than
# the energy that a specimen absorbs.
_TAKEN = 0.02


class Point(NamedTuple):
    """A point on the curves of a drop-weight test.

    Attributes
    ----------
    time, force, deflection, energy : float
        Time, s; force, N; deflection, m; energy that the specimen has taken up until this time, J.
    """

    time: float
    force: float
    deflection: float
    energy: float


@dataclass(frozen=True, eq=False, repr=False)
class DropWeight(Frozen):
    """A drop-weight test as ASTM D7136 and ISO 6603-2 report it; see `drop_weight`.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, s.
    force : ndarray, shape (n,)
        Force on the impactor, N; filtered if a class was given.
    velocity, deflection, energy : ndarrays, shape (n,)
        Velocity of the impactor, m/s; its displacement since the first touch, m; and the energy
        that the specimen has taken up, J.
    signal : Signal
        Signal of the force; ``signal.raw`` is the unfiltered one.
    mass, impact_velocity, gravity : float
        Mass of the impactor, kg, velocity at the first touch, m/s, and gravity, m/s².
    start, end : float
        Times of the first and last touch, s.
    simulated : bool
        True for simulated bodies, which cannot break.

    Examples
    --------
    >>> tup, plate = ao.rigid(mass=5.0), ao.AOModel(m0=0.1, k0=5e6, m=[0.2], k=[4e7])
    >>> hit = ao.simulate(projectile=tup, target=plate, law=ao.Hertz(k=1e9), velocity=2.0)
    >>> round(drop_weight(hit).impact_energy, 6)  # J
    10.0
    """

    t: FloatArray
    force: FloatArray
    velocity: FloatArray
    deflection: FloatArray
    energy: FloatArray
    signal: Signal
    mass: float
    impact_velocity: float
    gravity: float
    start: float
    end: float
    simulated: bool

    @property
    def impact_energy(self) -> float:
        """Impact energy E_i = m v_i²/2, J (D7136, measured impact energy)."""
        return 0.5 * self.mass * self.impact_velocity * self.impact_velocity

    @property
    def peak(self) -> Point:
        """Point of the largest force, F_M, with deflection l_M and energy W_M (ISO 6603-2)."""
        return self._point(int(np.argmax(self.force)))

    @property
    def turn(self) -> Point | None:
        """Point of largest deflection, where the impactor turns back; None if it does not turn."""
        at = int(np.argmax(self.deflection[: self._end + 1]))
        return None if at == self._end and self.velocity[at] > 0.0 else self._point(at)

    @property
    def puncture(self) -> Point | None:
        """Point of puncture, where the force has fallen to half its peak (ISO 6603-2).

        None if the impactor has turned back before. Also None for every simulated impact: its
        bodies do not break, and its force falls only due to vibration.
        """
        fallen = self.force <= 0.5 * self.force.max()
        fallen[: np.argmax(self.force)] = False
        at = int(np.argmax(fallen))
        goes_on = fallen[at] and self.velocity[at] > 0.0
        return self._point(at) if goes_on and not self.simulated else None

    @property
    def last(self) -> Point:
        """Point at the end of the contact: its energy is the absorbed energy of D7136."""
        return self._point(self._end)

    @property
    def absorbed_energy(self) -> float:
        """Energy that the specimen retains at the end of the contact, E_a(t_T), J (D7136).

        For elastic bodies, this is the energy of their vibration.
        """
        return self.last.energy

    @property
    def rebound_velocity(self) -> float:
        """Velocity of the impactor at the end of the contact, m/s; negative if it rebounds."""
        return float(np.interp(self.end, self.t, self.velocity))

    @property
    def _end(self) -> int:
        """Index of the first sample at or after the last touch; the last index if there is none."""
        return min(int(np.searchsorted(self.t, self.end)), len(self.t) - 1)

    def _point(self, i: int) -> Point:
        columns = self.t, self.force, self.deflection, self.energy
        return Point(*(column[i].item() for column in columns))

    # ---------------------------------------------------------------------- output

    def plot_deflection(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the force against the deflection during the contact; returns the axes.

        Keywords go to ``Axes.plot``.

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> test = drop_weight(hit)
        >>> ax = test.plot_deflection()
        """
        return self._draw(ax, "force", "deflection", kwargs)

    def plot_energy(self, ax: Axes | None = None, *, over: str = "time", **kwargs: Any) -> Axes:
        """Draw the energy that the specimen has taken up; keywords go to ``Axes.plot``.

        Parameters
        ----------
        ax : Axes, optional
        over : {"time", "deflection"}, optional
            Time since the first touch, or deflection during the contact.

        Returns
        -------
        Axes

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> test = drop_weight(hit)
        >>> ax = test.plot_energy(over="deflection")
        """
        return self._draw(ax, "energy", choice("over", over, ("time", "deflection")), kwargs)

    def plot_force(self, ax: Axes | None = None, *, raw: bool = True, **kwargs: Any) -> Axes:
        """Draw the force against time since first touch; `raw` adds the unfiltered force in grey.

        Keywords go to ``Axes.plot``.

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> test = drop_weight(hit)
        >>> ax = test.plot_force()
        """
        return self._draw(ax, "force", "time", kwargs, self.signal.raw if raw else None)

    def _draw(
        self, ax: Any, name: str, over: str, kwargs: dict[str, Any], raw: Signal | None = None
    ) -> Axes:
        """Draw force or energy against `over`: time since first touch, or deflection in contact."""
        margin = 0.1 * (self.end - self.start) if over == "time" else 0.0
        shown = slice(*np.searchsorted(self.t, [self.start - margin, self.end + margin]))
        across, unit = (self.t - self.start, "s") if over == "time" else (self.deflection, "m")
        curves = [(getattr(self, name)[shown], kwargs)]
        if raw is not None:
            curves.insert(0, (raw.values[shown], UNFILTERED))
        of = {"force": "N", "energy": "J"}[name]
        return draw_curves(ax, (across[shown], over, unit), name, of, curves)

    def to_csv(self, path: FilePath) -> None:
        """Write a CSV file with t, force, velocity, deflection and energy, one row per time.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> test = drop_weight(hit)
        >>> test.to_csv(folder / "drop.csv")
        """
        rows = np.column_stack([self.t, self.force, self.velocity, self.deflection, self.energy])
        heading = ("t [s]", "force [N]", "velocity [m/s]", "deflection [m]", "energy [J]")
        write_csv(path, heading, rows.tolist())

    def __repr__(self) -> str:
        def described(point: Point) -> str:
            return (
                f"{with_unit(point.force, 'N')}, {with_unit(point.deflection, 'm')}, "
                f"{with_unit(point.energy, 'J')} at {with_unit(point.time - self.start, 's')}"
            )

        impactor = f"{with_unit(self.mass, 'kg')} at {self.impact_velocity:.4g} m/s"
        rows = [
            ("impactor", f"{impactor}, {with_unit(self.impact_energy, 'J')}"),
            ("peak", described(self.peak)),
            ("turn", described(self.turn) if self.turn else "none"),
            ("puncture", described(self.puncture) if self.puncture else "none"),
            ("contact", with_unit(self.end - self.start, "s")),
            ("rebound velocity", f"{self.rebound_velocity:.4g} m/s"),
            ("absorbed energy", with_unit(self.absorbed_energy, "J")),
        ]
        return "\n".join(["Drop weight", *(f"  {name:<18} {value}" for name, value in rows)])


def drop_weight(
    source: Any,
    *,
    mass: float | None = None,
    velocity: float | None = None,
    gravity: float | None = None,
    cfc: float | None = None,
    start: float | None = None,
) -> DropWeight:
    """Evaluate a drop-weight test, measured or simulated, from the force on the impactor.

    Following ASTM D7136, with F linear between samples and v_i the velocity at the first touch t_i:

        v(t) = v_i + g (t - t_i) - ∫F/m dt,  δ(t) = ∫v dt,  E(t) = m (v_i² - v²)/2 + m g δ.

    Parameters
    ----------
    source : Signal, (t, force) or Result
        Force on the impactor, N, measured or simulated. For a scene with gravity, give
        ``Signal.of(run, contact=0)``, mass and velocity.
    mass : float, optional
        Mass of the impactor, kg; by default that of a result's projectile.
    velocity : float, optional
        Impact velocity v_i, m/s; by default that of a result.
    gravity : float, optional
        Gravity g, m/s²; by default 9.80665, or 0 for a result, since `simulate` has none.
    cfc : float, optional
        Channel frequency class by which the force is filtered; see `Signal.filtered`. The
        unfiltered force is integrated, since a filter smears the start and end of the contact.
    start : float, optional
        First touch t_i, s; by default the start of a result's first contact, or the last time that
        a measured force is below 1 % of its peak before it first exceeds 10 %. The last touch is
        found in the same way.

    Returns
    -------
    DropWeight

    Raises
    ------
    InputError
        If mass or velocity of a measurement are missing, there is no contact, or the filter cannot
        be applied.

    Warns
    -----
    AOImpactWarning
        If the absorbed energy is negative, the impactor is hardly decelerated, the record ends
        within the contact, or the filter suppresses the force of the contact.

    Examples
    --------
    A measurement and a computation, both through the same filter:

    >>> import aoimpact as ao
    >>> tup, plate = ao.rigid(mass=5.4), ao.AOModel(m0=0.1, k0=5e6, m=[0.2], k=[4e7])
    >>> hit = ao.simulate(projectile=tup, target=plate, law=ao.Hertz(k=1e9), velocity=2.0)
    >>> measured = (hit.t, hit.force)  # or read_signal("drop.csv", time_unit="ms", unit="kN")
    >>> signal = Signal.of(measured).resampled(1e6)
    >>> test = drop_weight(signal, mass=5.4, velocity=2.0, gravity=0.0, cfc=1000)
    >>> same = drop_weight(hit, cfc=1000)
    >>> ax = test.plot_energy(label="measured")
    >>> ax = same.plot_energy(ax, label="computed")
    >>> f"{test.peak.force:.0f} N, {same.peak.force:.0f} N"
    '11869 N, 11870 N'
    """
    from scipy.interpolate import make_interp_spline  # slow to import

    signal = Signal.of(source)
    if isinstance(source, Result):
        mass = source.projectile.mass if mass is None else mass
        velocity = source.velocity if velocity is None else velocity
        gravity = source.plan.gravity if gravity is None else gravity
        if cfc is not None:
            room = Channel(cfc=cfc).settling_time  # of zero force before and after
            signal = Signal.of(source, rate=max(signal.rate, 20.0 * cfc), margin=room)
    for name, given in (("mass", mass), ("velocity", velocity)):
        if given is None:
            raise InputError(f"{name} of the impactor is not known: give {name}=")
    m, v_i = positive("mass", mass, unit="kg"), positive("velocity", velocity, unit="m/s")
    g = nonnegative("gravity", STANDARD_GRAVITY if gravity is None else gravity, unit="m/s²")
    if cfc is not None:
        signal = signal.filtered(cfc)
    raw = signal.raw or signal
    begin, end = _touches(source, signal, start)
    with np.errstate(all="ignore"):
        fall = make_interp_spline(raw.t, g - raw.values / m, k=1, check_finite=False)
        gained, way = fall.antiderivative(1), fall.antiderivative(2)
        first = v_i - g * (begin - raw.t[0])  # free fall before the first touch
        v = first + gained(raw.t)
        deflection = first * (raw.t - begin) + way(raw.t) - way(begin)
        energy = 0.5 * m * (v_i - v) * (v_i + v) + m * g * deflection
    if not np.isfinite(energy).all():
        raise InputError(
            f"mass = {m:g} kg, velocity = {v_i:g} m/s, gravity = {g:g} m/s²: energies "
            "overflow; are they in these units?"
        )
    simulated = isinstance(source, Result)
    test = DropWeight(
        signal.t, signal.values, v, deflection, energy, signal, m, v_i, g, begin, end, simulated
    )
    _warn_of_doubts(test, cfc)
    return test


def _warn_of_doubts(test: DropWeight, cfc: float | None) -> None:
    """Warn of implausible results of a test, and name their likely cause."""
    raw = test.signal.raw or test.signal
    touched = contacts(raw, "force")
    acts, largest = float(raw.t[touched[-1][1]] - raw.t[touched[0][0]]), float(raw.values.max())
    if cfc is not None and 0.0 < acts < 0.5 / cfc:
        warn(
            f"the force lasts {with_unit(acts, 's')}, half a period of {0.5 / acts:.3g} Hz, "
            f"which class {cfc:g} filters out: the peak is {with_unit(test.peak.force, 'N')} "
            f"instead of {with_unit(largest, 'N')}"
        )
    if test.simulated:
        return
    taken, velocity = test.absorbed_energy, test.rebound_velocity
    if raw.values[-1] > RISEN * largest:
        warn(
            f"the record ends at a force of {with_unit(float(raw.values[-1]), 'N')}: rebound and "
            "absorbed energy are those at its end, not after the contact"
        )
    elif taken < -_TAKEN * test.impact_energy:
        warn(
            f"the absorbed energy is {with_unit(taken, 'J')}: is the force too large (its unit, a "
            "zero that is off), or mass or velocity too small?"
        )
    elif velocity > 0.0 and (test.puncture is None or taken < _TAKEN * test.impact_energy):
        warn(
            f"the impactor still goes on at {velocity:.4g} of {test.impact_velocity:.4g} m/s when "
            "the force ends: is the force in N (not kN), and the mass in kg?"
        )


def _touches(source: Any, signal: Signal, start: float | None) -> tuple[float, float]:
    """Return the times of first and last touch, s: simulated, or from shares of the peak force.

    `start` replaces the first touch. A filter smears the force to earlier times, so the unfiltered
    force gives the first touch. The rig rings after the contact, so the filtered force gives the
    last touch.
    """
    raw = signal.raw or signal
    if not isinstance(source, Result):
        begin, end = raw.t[contacts(raw, "force")[0][0]], raw.t[contacts(signal, "force")[-1][1]]
    elif source.contacts:
        begin, end = source.contacts[0][0], source.contacts[-1][1]
    else:
        raise InputError("the bodies do not touch within the record: nothing to evaluate")
    begin = begin if start is None else real("start", start, unit="s")
    if not raw.t[0] <= begin < end:
        raise InputError(
            f"start must lie in the record, from {raw.t[0]:g} to {end:g} s, got {begin:g} s"
        )
    return float(begin), float(end)
