"""SI prefixes for numbers and axes.

A prefix is chosen for which the number lies in 1 ... 1000. Numbers from 1 to 10 000 get no prefix,
because "1001.5 N" is read more easily than "1.0015 kN".
"""

from __future__ import annotations

import math

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


# Factor that converts a value from SI units to a unit with prefix, and that unit.
Scale = tuple[float, str]


def scale_for(largest: float, unit: str) -> Scale:
    """Return the scale that suits numbers up to `largest`, in SI units and of any sign.

    Zero, infinite and undefined values get no prefix, nor do units that begin with 1, such as 1/s.
    """
    size = abs(largest)
    if not math.isfinite(size) or size == 0.0 or not unit or unit.startswith("1/"):
        return 1.0, unit
    exponent = 3 * math.floor(math.log10(size) / 3.0 + 1e-9)
    if 1.0 <= size < 9999.5:
        exponent = 0
    exponent = min(max(exponent, min(_PREFIXES)), max(_PREFIXES))
    return 10.0**-exponent, _PREFIXES[exponent] + unit


def scale_of(label: str, unit: str) -> Scale | None:
    """Return the scale in an axis label such as "force (kN)"; None for another unit than `unit`."""
    for exponent, prefix in _PREFIXES.items():
        if label.endswith(f"({prefix}{unit})"):
            return 10.0**-exponent, prefix + unit
    return None


def with_unit(value: float, unit: str, digits: int = 4) -> str:
    """Return e.g. "814.4 N" for 814.369 and "70.74 µs" for 7.0743e-5 s; below 1 kg in grams."""
    if unit == "kg" and 0.0 < abs(value) < 1.0:
        value, unit = 1e3 * value, "g"
    rounded = float(f"{value:.{digits}g}")
    factor, unit = scale_for(rounded, unit)
    scaled = rounded * factor
    if 10.0**digits <= abs(scaled) < 1e6:  # already rounded: "870", not "8.7e+02"
        return f"{scaled:.0f} {unit}".rstrip()
    return f"{scaled:.{digits}g} {unit}".rstrip()
