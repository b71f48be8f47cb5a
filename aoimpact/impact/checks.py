"""Checks that an impact and a scene share: durations, speeds, gravity."""

from __future__ import annotations

from typing import Any

from ..base import HUGE, InputError, nonnegative, positive, real

__all__ = [
    "checked_duration",
    "checked_gravity",
    "checked_numbers",
    "checked_speed",
]

# m/s; squares and energies of speeds beyond these overflow, or vanish.
_SLOWEST, _FASTEST = 1e-60, 1e60

# s; their cubes are numbers, and so is the distance that the fastest body covers.
_SHORTEST, _LONGEST = 1.0 / HUGE, HUGE

# m/s², the most on a neutron star. Above ten times as much, depths of contacts are no more than the
# rounding of the ways that bodies fall, and drawn scenes were wrong by 1e-7 to 1e-4.
_HEAVIEST = 1e12


def checked_duration(duration: Any) -> float:
    """Return the length of a record, s, over which displacements do not overflow."""
    length = positive("duration", duration, unit="s")
    if not _SHORTEST <= length <= _LONGEST:
        raise InputError(
            f"duration={length:g} s is beyond what can be computed: {_SHORTEST:g} to {_LONGEST:g} s"
        )
    return length


def checked_speed(name: str, value: Any) -> float:
    """Return a speed, m/s, whose square neither overflows nor vanishes.

    Raises
    ------
    InputError
    """
    speed = real(name, value, unit="m/s")
    if speed != 0.0 and not _SLOWEST <= abs(speed) <= _FASTEST:
        raise InputError(
            f"{name}={speed:g} m/s: its square is beyond the range of numbers; give a speed from "
            f"{_SLOWEST:g} to {_FASTEST:g} m/s"
        )
    return speed


def checked_gravity(value: Any) -> float:
    """Return an acceleration, m/s², beside which contacts are still resolved.

    Raises
    ------
    InputError
    """
    pull = real("gravity", value, unit="m/s²")
    if abs(pull) > _HEAVIEST:
        raise InputError(
            f"gravity={pull:g} m/s² is beyond what contacts can be resolved beside: give up to "
            f"{_HEAVIEST:g} m/s²"
        )
    return pull


def checked_numbers(velocity: Any, duration: Any, gap: Any) -> tuple[float, float | None, float]:
    """Return velocity, m/s, duration, s, if given, and gap, m, of an impact.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """
    speed = checked_speed("velocity", velocity)
    if speed == 0.0:
        raise InputError("velocity is 0 m/s: nothing would move; give the projectile a velocity")
    length = None if duration is None else checked_duration(duration)
    return speed, length, nonnegative("gap", gap, unit="m")
