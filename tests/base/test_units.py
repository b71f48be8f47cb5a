"""SI prefixes as an engineer reads them."""

from __future__ import annotations

import pytest

from aoimpact.base import scale_for, scale_of, with_unit


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (814.369, "N", "814.4 N"),
        (7.0743e-5, "s", "70.74 µs"),
        (12346.0, "N", "12.35 kN"),
        (9.9999e-4, "s", "1 ms"),
        (-2.5e-3, "J", "-2.5 mJ"),
        (0.0, "s", "0 s"),
        (1e-20, "m", "1e-05 fm"),
        (0.0327, "kg", "32.7 g"),
        (2.0, "kg", "2 kg"),
        (float("inf"), "kg", "inf kg"),
        (1e4, "1/m", "10000 1/m"),
        (2.5e12, "1/s", "2.5e+12 1/s"),
    ],
)
def test_quantities_carry_fitting_prefixes(value: float, unit: str, text: str) -> None:
    assert with_unit(value, unit) == text


def test_few_digits_of_hundreds_are_told_without_an_exponent() -> None:
    assert [with_unit(value, "s", 2) for value in (0.87, 0.0087, 1234.0)] == [
        "870 ms",
        "8.7 ms",
        "1200 s",
    ]


def test_scale_is_read_back_from_a_label() -> None:
    for largest in (1e-14, 3e-6, 0.5, 70.0, 5e4, 3e7):
        scale = scale_for(largest, "m")
        assert scale_of(f"depth ({scale[1]})", "m") == scale
    assert scale_of("speed (m/s)", "m") is None
    assert scale_of("", "N") is None
