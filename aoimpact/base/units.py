"""SI prefixes: numbers and axes as an engineer reads them.

A prefix is taken so that the number lies in 1 ... 1000; thousands keep the unit without prefix up
to 10 000, because "1001.5 N" is read more easily than "1.0015 kN".
"""

from __future__ import annotations

import math

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


# Factor and unit with a prefix: a value in SI units times the factor is the number in that unit.
Scale = tuple[float, str]


def scale_for(largest: float, unit: str) -> Scale:
    """Return the scale that suits numbers up to `largest`, in SI units and of any sign.

    Zero, infinite and undefined values keep the bare unit, and so do units that begin with 1, such
    as 1/s: no prefix stands before a 1.
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
    """Return the scale that an axis label such as "force (kN)" states, or None."""
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
    if 10.0**digits <= abs(scaled) < 1e6:  # rounded already: 870, not 8.7e+02
        return f"{scaled:.0f} {unit}".rstrip()
    return f"{scaled:.{digits}g} {unit}".rstrip()
