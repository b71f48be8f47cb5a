"""Matrices of more entries than the core can count."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import aoimpact as ao
from aoimpact import matrices
from aoimpact.matrices import core_rows


def test_rows_for_the_core_are_the_matrix() -> None:
    """Also where SciPy counts in int64."""
    random = np.random.default_rng(0)
    K = sp.csr_array(random.standard_normal((9, 9)) * (random.uniform(size=(9, 9)) < 0.4))
    wide = sp.csr_array((K.data, K.indices.astype(np.int64), K.indptr.astype(np.int64)), K.shape)
    starts, columns, values = core_rows(wide)
    assert starts.dtype == columns.dtype == np.int32
    same = sp.csr_array((values, columns, starts), shape=K.shape)
    np.testing.assert_array_equal(same.toarray(), K.toarray())


def test_more_entries_than_the_core_counts_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """By every way that hands them to it: 2³¹ of them take 24 GiB, so the limit is moved here."""
    monkeypatch.setattr(matrices, "_MOST_ENTRIES", 30)
    K = sp.diags_array([-1.0, 2.5, -1.0], offsets=[-1, 0, 1], shape=(11, 11), format="csr")
    body = ao.FEModel(K=K, M=sp.eye_array(11, format="csr"))
    tip = body.contact(dof=0)
    message = "11 dofs with 31 entries: at most 30"
    with pytest.raises(ao.InputError, match=message):
        ao.antioscillators(tip, 3, method="krylov")
    with pytest.raises(ao.InputError, match=message):
        body.inverse(1.0, solver="multigrid")
    with pytest.raises(ao.InputError, match=message):
        ao.simulate(
            projectile=ao.rigid(1.0),
            target=tip,
            law=ao.Hertz(k=1.0),
            velocity=1.0,
            duration=1.0,
            solver=ao.Newmark(dt=0.1),
        )
