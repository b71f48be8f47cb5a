"""Numbers of nodes are those of the file that a mesh comes from; without one they count from 0."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(210e9, 0.3, 7800)
PLAIN = ao.box_mesh((0.04, 0.01, 0.01), (4, 1, 1))

# In no order, and none the node's place in the list.
LABELS = 1000 - 7 * np.arange(PLAIN.n_nodes)


def labelled(labels: Any = LABELS) -> ao.Mesh:
    sets = {"xmin": PLAIN.node_sets["xmin"]}
    return ao.Mesh(PLAIN.nodes, PLAIN.cells, PLAIN.kind, sets, {}, labels, None)


ENDS = [np.flatnonzero(PLAIN.nodes[:, 0] == x) for x in (0.0, 0.04)]


@pytest.mark.parametrize("labels", [LABELS, None])
def test_supports_masses_and_springs(labels: Any) -> None:
    """The body is that whose nodes are selected by functions of their coordinates."""
    first, last = (end if labels is None else labels[end] for end in ENDS)
    by_number = ao.FEModel.from_mesh(
        labelled(labels),
        STEEL,
        fixed=[(first, "xyz")],
        masses=[(last, 0.1), ao.RigidMass(last, 0.2, inertia=(1e-5, 1e-5, 1e-5))],
        springs=[(last.tolist(), "z", 1e6)],
    )

    def start(x: Any) -> Any:
        return x[:, 0] == 0.0

    def end(x: Any) -> Any:
        return x[:, 0] == 0.04

    by_place = ao.FEModel.from_mesh(
        PLAIN,
        STEEL,
        fixed=[(start, "xyz")],
        masses=[(end, 0.1), ao.RigidMass(end, 0.2, inertia=(1e-5, 1e-5, 1e-5))],
        springs=[(end, "z", 1e6)],
    )
    assert (by_number.K != by_place.K).nnz == 0
    assert (by_number.M != by_place.M).nnz == 0


@pytest.mark.filterwarnings("ignore:.*may be off by")  # by elements of first order
def test_contact_and_probe() -> None:
    body = ao.FEModel.from_mesh(labelled(), STEEL, fixed=[("xmin", "xyz")])
    corner = int(np.flatnonzero((PLAIN.nodes == [0.04, 0.01, 0.01]).all(axis=1))[0])
    tip = body.contact(node=int(LABELS[corner]), direction=(0, 0, -1), radius=0)
    np.testing.assert_array_equal(tip.point, PLAIN.nodes[corner])
    assert tip.node == corner
    assert tip.node_label == LABELS[corner]
    assert f"node {LABELS[corner]} at" in repr(tip)
    hit = ao.simulate(ao.rigid(mass=0.01), tip, 0.1, law=ao.Linear(k=1e5), duration=3e-3)
    assert f"node {LABELS[corner]} at" in str(hit)
    by_number = hit.target.probe(nodes=[int(LABELS[corner])])
    by_place = hit.target.probe(tip.point).displacement
    np.testing.assert_allclose(by_number.displacement[:, 0], by_place, rtol=1e-9, atol=1e-20)


def test_labels_of_matrices() -> None:
    """Labels of the rows of K name the nodes of probes, too."""
    whole = ao.FEModel.from_mesh(PLAIN, STEEL)
    dofs = np.arange(whole.n_dofs)
    labels = np.stack([LABELS[dofs // 3], 1 + dofs % 3], axis=1)
    body = ao.FEModel(whole.K, whole.M, nodes=PLAIN.nodes, labels=labels)
    tip = body.contact(node=int(LABELS[3]), direction=(0, 0, -1))
    assert tip.node == 3
    hit = ao.simulate(ao.rigid(mass=0.01), tip, 0.1, law=ao.Linear(k=1e5), duration=1e-3)
    probe = hit.target.probe(nodes=[int(LABELS[3])], direction=(0, 0, -1))
    one = hit.target.probe(PLAIN.nodes[3], direction=(0, 0, -1))
    np.testing.assert_array_equal(probe.displacement[:, 0], one.displacement)


def test_a_part_keeps_its_numbers() -> None:
    groups = {"half": [2, 3]}
    mesh = ao.Mesh(PLAIN.nodes, PLAIN.cells, PLAIN.kind, {}, groups, LABELS, None)
    body = ao.FEModel.from_mesh(mesh, STEEL, part="half")
    tip = body.contact(node=int(LABELS[ENDS[1][0]]), direction=(0, 0, -1), radius=0)
    np.testing.assert_array_equal(tip.point, PLAIN.nodes[ENDS[1][0]])
