"""The estimated errors of compliances against true ones, over bodies and meshes.

The truth are quadratic bricks, graded to a fifteenth of the size at the contact, with a patch as
wide as the contact itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from aoimpact.accuracy import best_radius, compliance_error
from aoimpact.fem.material import Material
from aoimpact.fem.model import FEModel
from aoimpact.mesh.generate import box_mesh, sphere_mesh
from aoimpact.mesh.mesh import Mesh

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:radius="),
    pytest.mark.filterwarnings("ignore:solver 'pardiso' takes over"),  # of the graded meshes
]

FloatArray = npt.NDArray[np.float64]
Map = Callable[[FloatArray], FloatArray]

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
ALU = Material(E=70e9, nu=0.33, rho=2700.0)
SOFT = Material(E=10e6, nu=0.49, rho=1100.0)


def round_about(centre: FloatArray) -> Map:
    """Squares become circles: the elliptical map of the square to the disc."""

    def of(nodes: FloatArray) -> FloatArray:
        x, y = ((nodes - centre) / centre)[:, :2].T
        on_disc = [x * np.sqrt(1.0 - 0.5 * y * y), y * np.sqrt(1.0 - 0.5 * x * x)]
        return np.column_stack([centre[:2] * (1.0 + np.stack(on_disc, axis=1)), nodes[:, 2]])

    return of


@dataclass(frozen=True, eq=False)
class Box:
    """A box, or what a map makes of it, hit on its top."""

    name: str
    material: Material
    lengths: tuple[float, float, float]
    place: tuple[float, float]
    time: float
    contact: float
    fixed: Any = None
    curved: bool = False
    finest: tuple[int, int, int] = (20, 20, 8)

    @property
    def point(self) -> tuple[float, float, float]:
        return (*self.place, self.lengths[2])

    def model(self, kind: str, divisions: tuple[int, int, int], graded: bool = False) -> FEModel:
        mesh = box_mesh(self.lengths, divisions, kind=kind)
        nodes = self.towards_the_contact(mesh.nodes) if graded else mesh.nodes
        if self.curved:
            nodes = round_about(0.5 * np.array(self.lengths))(nodes)
        return FEModel.from_mesh(
            Mesh(nodes, mesh.cells, kind, mesh.node_sets), self.material, self.fixed
        )

    def towards_the_contact(self, nodes: FloatArray) -> FloatArray:
        graded = np.empty_like(nodes)
        for axis, (at, length) in enumerate(zip(self.point, self.lengths, strict=True)):
            middle = length if axis == 2 else 0.5 * length
            share = np.abs(nodes[:, axis] - middle) / middle
            way = np.where(nodes[:, axis] < middle, at, at - length)
            graded[:, axis] = at - way * (0.15 * share + 0.85 * share**2.5)
        return graded

    @cache  # noqa: B019
    def remaining(self) -> float:
        """R of a patch as wide as the contact, m/N."""
        return remaining(self.model("hexahedron20", self.finest, graded=True), self)


@dataclass(frozen=True, eq=False)
class Ball:
    name: str = "ball"
    material: Material = STEEL
    point: tuple[float, float, float] = (0.01, 0.0, 0.0)
    time: float = 60e-6
    contact: float = 0.003

    def model(self, kind: str, divisions: tuple[int, int, int]) -> FEModel:
        return FEModel.from_mesh(sphere_mesh(0.01, 1e-4 * divisions[0]), STEEL)

    @cache  # noqa: B019
    def remaining(self) -> float:
        return remaining(self.model("", (16, 0, 0)), self)


def remaining(body: FEModel, of: Box | Ball) -> float:
    tip = body.contact(point=of.point, radius=of.contact)
    assert tip.patch is not None
    return float(tip.b @ body.inverse((10.0 / of.time) ** 2).solve(tip.b)) - tip.patch.compliance


def rim(nodes: FloatArray) -> npt.NDArray[np.bool_]:
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    return ((nodes == low) | (nodes == high))[:, :2].any(axis=1)


def lower_rim(nodes: FloatArray) -> npt.NDArray[np.bool_]:
    return rim(nodes) & (nodes[:, 2] == 0.0)


PLATE = Box("plate", ALU, (0.06, 0.06, 0.006), (0.03, 0.03), 1e-4, 1e-3, [(lower_rim, "xyz")])
OFF = Box("free plate", ALU, (0.06, 0.06, 0.006), (0.012, 0.018), 1e-4, 1e-3)
THIN = Box("thin", STEEL, (0.1, 0.1, 0.003), (0.05, 0.05), 1.5e-4, 1e-3, [(rim, "xyz")])
BLOCK = Box("block", STEEL, (0.03,) * 3, (0.015, 0.015), 4e-5, 8e-4, [("zmin", "xyz")])
RUBBER = Box("rubber", SOFT, (0.03,) * 3, (0.015, 0.015), 3e-3, 1.5e-3, [("zmin", "xyz")])
BEAM = Box(
    *("beam", ALU, (0.2, 0.02, 0.02), (0.1, 0.01), 2e-4, 9e-4, [("xmin", "xyz")]),
    finest=(32, 12, 8),
)
ROUND = Box("cylinder", STEEL, (0.024, 0.024, 0.02), (0.012, 0.012), 4e-5, 8e-4, curved=True)
BALL = Ball()

HEX8, HEX20, TET4, TET10 = "hexahedron", "hexahedron20", "tetra", "tetra10"
CASES: list[tuple[Any, str, tuple[int, int, int], tuple[float, ...]]] = [
    (PLATE, HEX8, (20, 20, 1), (3e-3, 5e-3)),
    (PLATE, HEX8, (24, 24, 3), (2e-3, 4e-3)),
    (PLATE, HEX20, (12, 12, 1), (3e-3, 5e-3)),
    (PLATE, TET10, (16, 16, 2), (2e-3, 4e-3)),
    (PLATE, TET4, (24, 24, 2), (2e-3, 4e-3)),
    (OFF, HEX20, (12, 12, 2), (3e-3, 5e-3)),
    (OFF, TET4, (24, 24, 2), (3e-3, 5e-3)),
    (THIN, HEX8, (40, 40, 1), (2e-3, 3e-3)),
    (THIN, HEX20, (20, 20, 1), (2e-3, 3e-3)),
    (BLOCK, HEX8, (12, 12, 12), (1.5e-3, 3e-3)),
    (BLOCK, HEX20, (6, 6, 6), (2e-3, 4e-3)),
    (BLOCK, TET10, (6, 6, 6), (2.5e-3, 5e-3)),
    (BLOCK, TET4, (14, 14, 14), (2e-3, 4e-3)),
    (RUBBER, HEX8, (12, 12, 12), (2.5e-3, 5e-3)),
    (RUBBER, TET10, (6, 6, 6), (2.5e-3, 5e-3)),
    (BEAM, HEX8, (60, 6, 6), (2e-3, 4e-3)),
    (BEAM, HEX20, (20, 2, 2), (4e-3, 6e-3)),
    (ROUND, HEX20, (6, 6, 5), (2e-3, 4e-3)),
    (ROUND, TET4, (12, 12, 10), (2e-3, 4e-3)),
    (BALL, TET10, (45, 0, 0), (3.5e-3, 4e-3)),
]


@cache
def ratios() -> FloatArray:
    """Estimated over true errors of all patches, shape (40,)."""
    found = []
    for of, kind, divisions, radii in CASES:
        body = of.model(kind, divisions)
        solver = body.inverse((10.0 / of.time) ** 2)
        given = {"contact_time": of.time, "contact_radius": of.contact}
        for radius in radii:
            tip = body.contact(point=of.point, radius=radius)
            error = compliance_error(tip, invert=lambda _, known=solver: known, **given)
            assert error is not None
            assert tip.patch is not None
            true = error.compliance - tip.patch.compliance - of.remaining()
            found.append(error.total / abs(true))
    return np.array(found)


def test_true_errors_are_below_the_estimates_and_not_far_below() -> None:
    found = ratios()
    assert (found > 1.0).mean() >= 0.95
    assert np.median(found) < 2.5
    assert np.quantile(found, 0.9) < 6.0


@pytest.mark.parametrize("case", range(0, len(CASES), 3))
def test_what_a_node_adds_is_known(case: int) -> None:
    of, kind, divisions, _ = CASES[case]
    body = of.model(kind, divisions)
    tip = body.contact(point=of.point, radius=0)
    error = compliance_error(tip, contact_time=of.time, contact_radius=of.contact)
    assert error is not None
    assert error.compliance - of.remaining() < 1.1 * error.total


@pytest.mark.parametrize("case", range(1, len(CASES), 3))
def test_no_other_radius_is_much_better_than_the_best(case: int) -> None:
    of, kind, divisions, radii = CASES[case]
    body = of.model(kind, divisions)
    solver = body.inverse((10.0 / of.time) ** 2)

    def total(radius: float) -> float:
        error = compliance_error(
            body.contact(point=of.point, radius=radius),
            contact_time=of.time,
            contact_radius=of.contact,
            invert=lambda _: solver,
        )
        assert error is not None
        return error.total

    best = best_radius(
        body.contact(point=of.point, radius=0),
        contact_time=of.time,
        contact_radius=of.contact,
        invert=lambda _: solver,
    )
    assert best >= 1.25 * of.contact
    assert total(best) < 1.5 * min(map(total, radii))
