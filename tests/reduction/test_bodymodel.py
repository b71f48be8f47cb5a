"""Every kind of model of a body is a `BodyModel`, and the same impact whichever describes it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.reduction import BodyModel, body_model

MESH = ao.box_mesh((0.2, 0.02, 0.01), (10, 2, 1), kind="hexahedron20")
BAR = ao.FEModel.from_mesh(MESH, ao.Material(E=70e9, nu=0.33, rho=2700), fixed=[("xmin", "xyz")])
TIP = BAR.contact(point=(0.17, 0.01, 0.01))
STAR = ao.antioscillators(TIP, n=6, method="krylov", contact_time=1e-4)
PORTS = ao.interface([TIP], n=7, contact_time=1e-4)

KINDS: dict[str, Any] = {
    "AO": STAR,
    "modal": ao.modal(TIP, 5),
    "interface": PORTS,
    "full": ao.full(TIP),
    "contact point": TIP,
}


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_knows_its_body(kind: str) -> None:
    model = body_model("target", KINDS[kind])
    assert isinstance(model, BodyModel)
    assert model.tips == (TIP,)
    assert model.touched_at() is TIP
    assert model.surface_at() == TIP.contact_surface
    assert model.name == BAR.name
    assert model.most_mass == np.inf  # supports hold it
    assert model.reducible == (kind == "contact point")


def test_degrees_of_freedom_are_the_coordinates_of_the_model() -> None:
    assert STAR.modal.dofs == len(STAR.matrices()[0])
    assert PORTS.dofs == len(PORTS.omega)
    assert ao.full(TIP).dofs == BAR.K.shape[0]
    assert ao.rigid(1.0).modal.dofs == 1
