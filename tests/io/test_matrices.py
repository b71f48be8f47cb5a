"""The same model through every format is the same model."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from rows import each
from writers import LABELLED, PRINTED, written

import aoimpact as ao

# Matrices without a mesh have the indentation of the half-space twice, which is no matter here.
pytestmark = pytest.mark.filterwarnings("ignore:.*with_mesh")

ALU = ao.Material(E=70e9, nu=0.3, rho=2700.0)
BAR = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.01), (4, 2, 1)), ALU, fixed=[("xmin", "xyz")])
DOWN = (0.0, 0.0, -1.0)
NODES = np.column_stack([101 + 2 * np.arange(len(BAR.nodes)), BAR.nodes])
TIP = int(np.flatnonzero(np.all(np.isclose(BAR.nodes, (0.1, 0.01, 0.01)), axis=1))[0])

# Rows in an order of their own, as solvers have them.
ORDER = np.random.default_rng(5).permutation(BAR.n_dofs)
K, M = BAR.K[ORDER][:, ORDER].tocoo(), BAR.M[ORDER][:, ORDER].tocoo()
LABELS = np.stack([101 + 2 * (BAR.free // 3), BAR.free % 3 + 1], axis=1)[ORDER]


def force(body: ao.FEModel, **place: Any) -> Any:
    tip = ao.antioscillators(body.contact(**place, direction=DOWN, radius=0), n=4)
    law = ao.Hertz(k=1e9)
    hit = ao.simulate(projectile=ao.rigid(0.01), target=tip, law=law, velocity=1.0, duration=1e-3)
    return hit.at(np.linspace(0.0, 1e-3, 200)).force


def printed(matrix: Any, digits: int) -> Any:
    """The matrix as a format of so many digits has it."""
    values = [float(f"{value:.{digits}e}") for value in matrix.data]
    return sp.coo_array((values, (matrix.row, matrix.col)), shape=matrix.shape)


@cache
def expected(digits: int) -> Any:
    free = 3 * ((LABELS[:, 0] - 101) // 2) + LABELS[:, 1] - 1
    body = ao.FEModel(K=printed(K, digits), M=printed(M, digits), nodes=BAR.nodes, free=free)
    return force(body, node=TIP)


@each("kind", PRINTED)
def test_every_format_gives_the_same_matrices_and_the_same_force(kind: str, tmp_path: Path) -> None:
    files = written(kind, tmp_path, K, M, LABELS)
    dofs = None if kind in LABELLED else LABELS
    body = ao.read_matrices(*files, dofs=dofs, nodes=NODES)
    assert body.labels is not None
    place = {tuple(label): i for i, label in enumerate(body.labels.tolist())}
    rows = [place[tuple(label)] for label in LABELS.tolist()]
    for read, true in ((body.K, K), (body.M, M)):
        as_printed = printed(true, PRINTED[kind]).toarray()
        np.testing.assert_allclose(read[rows][:, rows].toarray(), as_printed, rtol=1e-15)
    got, true_force = force(body, node=101 + 2 * TIP), expected(PRINTED[kind])
    assert np.abs(got - true_force).max() <= 1e-9 * true_force.max()
    assert body.contact(point=(0.1, 0.01, 0.01), direction=DOWN).node == TIP
