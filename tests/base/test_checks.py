"""Validators: right values pass unchanged or converted, wrong ones are named."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from aoimpact import InputError, InputTypeError
from aoimpact.base import (
    boolean,
    choice,
    finite_array,
    integer,
    node_ids,
    nonnegative,
    positive,
    real,
    unit_vector,
)

PLAIN = np.arange(6.0).reshape(2, 3)


@pytest.mark.parametrize("value", [2, 2.0, np.float32(2), np.int8(2), Fraction(2), np.array(2.0)])
def test_every_real_number_becomes_a_float(value: object) -> None:
    assert type(real("x", value)) is float
    assert real("x", value) == 2.0


@pytest.mark.parametrize("value", [True, np.True_, "2", None, 2j, [2.0], np.array([2.0])])
def test_what_is_no_real_number_is_refused(value: object) -> None:
    with pytest.raises(InputTypeError, match=r"^x"):
        real("x", value)


def test_infinity_passes_only_where_it_has_a_meaning() -> None:
    assert positive("mass", float("inf"), infinite=True) == float("inf")
    with pytest.raises(InputError, match="mass must be finite, got inf kg"):
        positive("mass", float("inf"), unit="kg")
    with pytest.raises(InputError, match="must be finite"):
        real("x", 10**400)
    with pytest.raises(InputError, match=r"^x"):
        real("x", np.nan, infinite=True)


def test_signs() -> None:
    assert nonnegative("r", 0) == 0.0
    with pytest.raises(InputError, match=r"^r"):
        nonnegative("r", -1, unit="m")
    with pytest.raises(InputError, match=r"^m"):
        positive("m", 0)


@pytest.mark.parametrize("value", [2.0, True, "2", None, np.float64(2), np.array([2])])
def test_only_integers_count(value: object) -> None:
    with pytest.raises(InputTypeError, match=r"^n"):
        integer("n", value)


def test_integer_bounds() -> None:
    assert integer("n", np.int32(3), low=1, high=3) == 3
    assert integer("n", np.array(3)) == 3
    for value in (0, 4):
        with pytest.raises(InputError, match=f"n must be from 1 to 3, got {value}"):
            integer("n", value, low=1, high=3)
    with pytest.raises(InputError, match=r"^n"):
        integer("n", -5, low=1)
    with pytest.raises(InputError, match=r"^n"):
        integer("n", 10**30, high=3)


def test_choices_name_the_nearest() -> None:
    assert choice("method", "eigen", ["eigen", "krylov"]) == "eigen"
    with pytest.raises(InputError, match=r"^method"):
        choice("method", "kyrlov", ["eigen", "krylov"])
    with pytest.raises(InputTypeError, match=r"^method"):
        choice("method", 3, ["eigen", "krylov"])
    assert boolean("flag", np.True_) is True
    with pytest.raises(InputTypeError, match="flag must be True or False"):
        boolean("flag", 1)


@pytest.mark.parametrize(
    "value",
    [
        PLAIN.astype(np.float32),
        PLAIN.astype(">f8"),
        PLAIN.astype(np.uint8),
        np.asfortranarray(PLAIN),
        np.repeat(PLAIN, 2, axis=1)[:, ::2],
        PLAIN.tolist(),
        PLAIN.astype(object),
        np.ma.MaskedArray(PLAIN),
    ],
    ids=["float32", "big-endian", "uint8", "Fortran", "strided", "list", "object", "unmasked"],
)
def test_arrays_of_any_real_form_are_converted_right(value: object) -> None:
    array = finite_array("a", value, shape=(2, None))
    assert np.array_equal(array, PLAIN)
    assert array.dtype == np.dtype("=f8")
    assert array.flags.c_contiguous


def test_what_is_right_already_is_not_copied_and_may_be_read_only() -> None:
    plain = PLAIN.copy()
    plain.flags.writeable = False
    assert finite_array("a", plain) is plain


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        ([1.0, np.nan, np.inf], InputError, r"a\[1\] is nan; 2 of 3 entries are not finite"),
        ([[1.0, 2.0]], InputError, r"a must have shape \(3,\), got \(1, 2\)"),
        (1.0, InputError, "a must have shape"),
        ([1j, 2, 3], InputTypeError, "dtype complex128"),
        ([True, False, True], InputTypeError, "dtype bool"),
        (["x", "y", "z"], InputTypeError, "real numbers"),
        ([1, None, 2], InputTypeError, "real numbers"),
        ([[1], [2, 3], [4]], InputTypeError, "array of numbers"),
        (np.ma.MaskedArray([1.0, 2.0, 3.0], mask=[0, 1, 0]), InputTypeError, "masked"),
        (np.array([1, "2", 3], dtype=object), InputTypeError, "real numbers"),
        ([1.0, 2.0, 10**400], InputError, "must be finite"),
    ],
)
def test_arrays_that_cannot_be_used_are_refused(
    value: object, kind: type[Exception], words: str
) -> None:
    with pytest.raises(kind, match=words):
        finite_array("a", value, shape=(3,))


def test_number_of_axes() -> None:
    with pytest.raises(InputError, match="a must have 1 axes, got shape"):
        finite_array("a", PLAIN, ndim=1)


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_directions_of_any_length_become_unit_vectors(scale: float) -> None:
    assert unit_vector("d", scale * np.array([3.0, 0.0, -4.0])) == pytest.approx([0.6, 0.0, -0.8])


def test_the_zero_vector_has_no_direction() -> None:
    with pytest.raises(InputError, match=r"^d"):
        unit_vector("d", [0, 0, 0])


def test_node_numbers() -> None:
    assert node_ids("nodes", [5, 2, 2], 6).tolist() == [2, 5]
    assert node_ids("nodes", 3, 6).tolist() == [3]
    for wrong in ([6], [-1, 2]):
        with pytest.raises(InputError, match=r"^nodes"):
            node_ids("nodes", wrong, 6)
    with pytest.raises(InputError, match=r"^nodes"):
        node_ids("nodes", [], 6)
    for wrong_type in ([1.0], [True], ["1"], [[1], [2, 3]]):
        with pytest.raises(InputTypeError):
            node_ids("nodes", wrong_type, 6)
    with pytest.raises(InputError, match=r"^nodes"):
        node_ids("nodes", [[1, 2]], 6)
