"""The layout of a record: against the order in which the core's header lists its rows."""

from __future__ import annotations

import numpy as np

from aoimpact.scene import RecordLayout

# Two contacts of four rows, a body with one port (six and two) and one with two (six and four).
LAYOUT = RecordLayout(2, (1, 2))
RECORD = np.repeat(np.arange(26.0)[:, None], 3, axis=1)


def first(rows: object) -> list[float]:
    return [float(np.ravel(row)[0]) for row in rows if row is not None]


def test_every_row_has_one_name() -> None:
    assert LAYOUT.rows == 26
    assert first(LAYOUT.contact(RECORD, 1)) == [4.0, 5.0, 6.0, 7.0]
    one, two = LAYOUT.body(RECORD, 0), LAYOUT.body(RECORD, 1)
    assert first(one[:6]) == [8.0, 9.0, 10.0, 11.0, 12.0, 13.0]
    assert first(two.port_displacements) == [22.0, 24.0]
    assert first(two.port_velocities) == [23.0, 25.0]
    assert first(LAYOUT.forces(RECORD)) == [0.0, 4.0]
    assert first(LAYOUT.centre_velocities(RECORD)) == [one.velocity[0], two.velocity[0]]
    assert first(LAYOUT.of_contacts(RECORD)) == [*range(8)]


def test_contacts_with_friction_have_more_rows() -> None:
    layout = RecordLayout(3, (1,), (False, True, False))
    record = np.repeat(np.arange(24.0)[:, None], 3, axis=1)
    assert layout.rows == 24
    sliding = layout.contact(record, 1)
    assert first(sliding[:4]) == [4.0, 5.0, 6.0, 7.0]
    assert sliding.tangential is not None
    assert first(sliding.tangential) == [8.0, 9.0]
    assert first(sliding[5:]) == [10.0, 11.0]
    assert layout.contact(record, 2).tangential is None
    assert first(layout.forces(record)) == [0.0, 4.0, 12.0]
    assert first(layout.pushes(record)) == [0.0, 4.0, 8.0, 9.0, 12.0]
    assert layout.normal.tolist() == [True, True, False, False, True]
    taken = record[[*range(4, 12), *range(12, 16), *range(4), *range(16, 24)]].copy()
    layout.reordered(taken, [1, 2, 0])
    assert (taken == record).all()


def test_rows_are_views_and_scenes_without_contacts_have_some() -> None:
    record = np.zeros((8, 4))
    RecordLayout(0, (1,)).body(record, 0).velocity[:] = 2.0
    assert record[1].tolist() == [2.0] * 4
    assert RecordLayout(0, (1,)).of_contacts(record).shape == (0, 4)
