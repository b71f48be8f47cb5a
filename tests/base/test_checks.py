"""Validators: right values pass unchanged or converted, wrong ones are named."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import aoimpact as ao
from aoimpact import InputError, InputTypeError
from aoimpact.base import (
    boolean,
    choice,
    finite_array,
    real,
    unit_vector,
)

PLAIN = np.arange(6.0).reshape(2, 3)


@pytest.mark.parametrize("value", [2, 2.0, np.float32(2), np.int8(2), Fraction(2)])
def test_every_real_number_becomes_a_float(value: object) -> None:
    assert type(real("x", value)) is float
    assert real("x", value) == 2.0


def test_choices_name_the_nearest() -> None:
    assert choice("method", "eigen", ["eigen", "krylov"]) == "eigen"
    with pytest.raises(InputError, match=r"^method"):
        choice("method", "kyrlov", ["eigen", "krylov"])
    with pytest.raises(InputTypeError, match=r"^method"):
        choice("method", 3, ["eigen", "krylov"])
    assert boolean("flag", np.True_) is True
    with pytest.raises(InputTypeError):
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
        np.ma.MaskedArray(PLAIN),
    ],
    ids=["float32", "big-endian", "uint8", "Fortran", "strided", "list", "unmasked"],
)
def test_arrays_of_any_real_form_are_converted_right(value: object) -> None:
    array = finite_array("a", value, shape=(2, None))
    assert np.array_equal(array, PLAIN)
    assert array.dtype == np.dtype("=f8")
    assert array.flags.c_contiguous


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_directions_of_any_length_become_unit_vectors(scale: float) -> None:
    assert unit_vector("d", scale * np.array([3.0, 0.0, -4.0])) == pytest.approx([0.6, 0.0, -0.8])


def test_masked_numbers_of_nodes_are_refused() -> None:
    mesh = ao.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    chosen = np.ma.MaskedArray([0, 1], [False, True])
    with pytest.raises(InputTypeError, match=r"^node_sets\['held'\]"):
        ao.Mesh(mesh.nodes, mesh.cells, mesh.kind, {"held": chosen})
