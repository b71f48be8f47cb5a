"""Conjugate gradients: exact in as many steps as there are eigenvalues."""

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.linalg.cg import conjugate_gradients

WORDS = {"what": "A", "label": "a test"}


def identity(r):
    return r


def test_it_takes_as_many_iterations_as_the_matrix_has_eigenvalues():
    diagonal = np.repeat([1.0, 3.0, 10.0], 20)
    load = np.random.default_rng(0).standard_normal(60)
    found = conjugate_gradients(
        lambda x: diagonal * x, identity, load, tolerance=1e-12, most=10, **WORDS
    )
    assert found.iterations == 3
    np.testing.assert_allclose(found.x, load / diagonal, rtol=1e-11)


def test_no_load_moves_nothing():
    found = conjugate_gradients(identity, identity, np.zeros(4), tolerance=1e-9, most=9, **WORDS)
    np.testing.assert_array_equal(found.x, 0.0)
    assert found.iterations == 0


def test_what_is_left_after_too_few_iterations_is_told():
    diagonal, load = np.geomspace(1.0, 1e6, 50), np.ones(50)
    found = conjugate_gradients(
        lambda x: diagonal * x, identity, load, tolerance=1e-9, most=5, **WORDS
    )
    assert found.iterations == 5
    left = np.linalg.norm(load - diagonal * found.x) / np.linalg.norm(load)
    assert found.left == pytest.approx(left, rel=1e-9)
    assert found.left > 1e-9


def test_a_motion_of_negative_stiffness_is_refused():
    with pytest.raises(ao.SingularError, match=r"^A"):
        conjugate_gradients(lambda x: -x, identity, np.ones(3), tolerance=1e-9, most=9, **WORDS)


def test_a_preconditioner_that_is_not_positive_is_told_from_a_singular_matrix():
    with pytest.raises(ao.ConvergenceError, match=r"^iterations"):
        conjugate_gradients(identity, lambda r: -r, np.ones(3), tolerance=1e-9, most=9, **WORDS)
