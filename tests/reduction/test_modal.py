"""Natural modes of a body that is touched in one place or several."""

from __future__ import annotations

import numpy as np

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BAR = ao.FEModel.from_mesh(
    ao.box_mesh((0.1, 0.012, 0.01), (10, 1, 1), kind="hexahedron20"), STEEL, fixed=[("xmin", "xyz")]
)
ENDS = [BAR.contact(point=(x, 0.004, 0.01)) for x in (0.05, 0.09)]


def test_several_places_have_the_modes_of_each() -> None:
    model = ao.modal(ENDS, 12)
    np.testing.assert_allclose(model.frequencies, BAR.frequencies(12), rtol=1e-9)
    for row, tip in zip(model.participation, ENDS, strict=True):
        np.testing.assert_allclose(
            np.abs(row), np.abs(ao.modal(tip, 12).participation[0]), rtol=1e-6
        )


def test_a_list_of_one_place_is_that_place() -> None:
    np.testing.assert_array_equal(ao.modal([ENDS[1]], 20).omega, ao.modal(ENDS[1], 20).omega)
    assert ao.full([ENDS[1]]) == ao.full(ENDS[1])


def test_a_support_across_the_contact_holds_it_to_rounding() -> None:
    """Free to slide and to turn, and held against the blow: no rigid motion takes part."""
    mesh = ao.box_mesh((0.1, 0.02, 0.01), (6, 2, 1))
    tip = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("zmax", "z")]).contact(point=(0.08, 0.01, 0.0))
    assert all(model.constrained for model in (ao.modal(tip, 40), ao.full(tip)))
