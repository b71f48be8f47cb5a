"""The errors of mesh and contact, carried from compliance to what was asked for."""

from __future__ import annotations

import math
import pickle
import re
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import aoimpact as ao

ALU = ao.Material(E=70e9, nu=0.33, rho=2700)
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BALL = ao.ball(0.01, STEEL)


def plate(across: int, kind: str) -> ao.FEModel:
    mesh = ao.box_mesh((0.1, 0.1, 0.006), (across, across, 1), kind=kind)
    return ao.FEModel.from_mesh(mesh, ALU)


def strike(body: ao.FEModel, **more: object) -> ao.Result:
    tip = body.contact(point=(0.05, 0.05, 0.006))
    return ao.simulate(projectile=BALL, target=tip, velocity=1.0, **more)


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_where_only_bodies_as_meshed_leave_nothing_of_a_law_the_finer_ones_answer() -> None:
    """Rubber on bricks that lock, against quadratic ones half as large."""
    rubber = ao.Material(E=5e6, nu=0.499, rho=1100)
    locked, true = (
        ao.FEModel.from_mesh(
            ao.box_mesh((0.04, 0.04, 0.01), cells, kind=of), rubber, fixed=[("zmin", "xyz")]
        )
        for cells, of in (((4, 4, 2), "hexahedron"), ((6, 6, 2), "hexahedron20"))
    )
    hits = [ao.simulate(BALL, of.contact(point=(0.02, 0.02, 0.01)), 1.0) for of in (locked, true)]
    for name in ("peak_force", "contact_duration", "impulse"):
        mine, right = (hit.value(name) for hit in hits)
        assert mine == pytest.approx(right, rel=0.03)
        assert math.isinf(hits[0].error[name].mesh)
        assert math.isfinite(hits[1].error[name].mesh)


def test_bodies_as_meshed_answer_where_memory_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    usual, short = strike(struck := plate(8, "hexahedron20")), Mock(side_effect=MemoryError)
    monkeypatch.setattr(type(struck.finer), "K", property(short), raising=False)
    hit = strike(plate(8, "hexahedron20"))
    with pytest.warns(ao.AOImpactWarning, match="error without bound"):
        assert hit.error["peak_force"].mesh == math.inf
    assert hit.peak_force == pytest.approx(usual.peak_force, rel=2.0 * usual.error.total)


@pytest.mark.filterwarnings("ignore:.*the mesh makes an error")
def test_the_sum_of_all_parts_is_the_total_and_travels() -> None:
    hit = strike(plate(8, "hexahedron20"))
    error = hit.error
    parts = (error.mesh, error.contact, error.model, error.time)
    assert error.total == pytest.approx(math.fsum(parts))
    assert f"± {error['peak_force']}" in repr(hit)
    assert pickle.loads(pickle.dumps(hit)).error.mesh == error.mesh
    assert hit.at(np.array([1e-5])).error.contact == error.contact


def test_what_a_model_given_by_numbers_and_a_rigid_one_of_a_mesh_leave_out_is_not_known() -> None:
    """Given as models, with no larger ones that say what their bodies' deformation would do."""
    tip = plate(4, "hexahedron20").contact(point=(0.05, 0.05, 0.006))
    law = ao.Hertz.between(STEEL, 0.01, ALU, math.inf)
    rigid = ao.antioscillators(tip, n=4).truncated(0)
    for model in (ao.AOModel(m0=0.01, k0=1e6, m=[0.1], k=[1e8]), rigid):
        hit = ao.simulate(projectile=BALL, target=model, law=law, velocity=1.0, duration=1e-4)
        assert hit.error.mesh is hit.error.contact is None
        assert math.isnan(hit.error.total)


@pytest.mark.slow
def test_more_stiffness_of_the_law_from_doubtful_curvatures_counts_as_contact() -> None:
    """On facets of a coarse ball the curvature is known to some percent."""
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(radius=0.01, size=0.008), STEEL)
    tip = ball.contact(point=(0, 0, 0.01))
    hit = ao.simulate(projectile=BALL, target=tip, velocity=1.0)
    exact = ao.Hertz.between(STEEL, 0.01, STEEL, 0.01)
    given = ao.simulate(projectile=BALL, target=tip, law=exact, velocity=1.0)
    assert hit.error.contact > given.error.contact
    assert hit.peak_force == pytest.approx(given.peak_force, rel=hit.error.total)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*the mesh makes an error")
def test_a_full_model_leaves_out_mesh_and_contact_but_nothing_by_reduction() -> None:
    """As much as the chosen model of the same elements, whose numbers are found otherwise."""
    chosen = strike(plate(6, "hexahedron20"))
    model = chosen.beside.models[1]
    hertz, duration = ao.Hertz.between(STEEL, 0.01, ALU, math.inf), chosen.duration
    small, whole = (
        ao.simulate(BALL, of, chosen.velocity, law=hertz, duration=duration)
        for of in (model, ao.full(model.tips[0]))
    )
    error = whole.error
    assert error.model == 0.0
    assert error.total == pytest.approx(error.mesh + error.contact + error.time)
    assert error.mesh == pytest.approx(small.error.mesh, rel=0.2)
    assert error.contact == pytest.approx(small.error.contact, rel=0.2)
    assert error["peak_force"].total is not None
    assert re.search(
        r"error  +force at any time .*± .* of its largest value.* \(mesh .*model 0", repr(whole)
    )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*the mesh makes an error")
def test_a_history_of_several_contacts_says_when_it_is_off_most() -> None:
    """A light plate comes back: what is left out shifts the later contact against the earlier."""
    mesh = ao.box_mesh((0.08, 0.08, 0.003), (12, 12, 1), kind="hexahedron20")
    tip = ao.FEModel.from_mesh(mesh, ALU).contact(point=(0.04, 0.04, 0.003))
    again = ao.simulate(projectile=ao.ball(0.008, STEEL), target=tip, velocity=1.0)
    assert len(again.contacts) > 1
    assert again.error.worst_time > again.contacts[0][1]
    assert again.error.total > 3.0 * again.error["peak_force"].total
    said = re.search(r"at any time \(most at ([\d.]+) µs\) ±", repr(again))
    assert said is not None
    assert 1e-6 * float(said.group(1)) == pytest.approx(again.error.worst_time, rel=1e-2)


@pytest.mark.slow
def test_a_patch_wider_than_a_plate_is_thick_is_refused() -> None:
    """Its mean displacement is that of a softer place than the contact's."""
    mesh = ao.box_mesh((0.2, 0.15, 0.006), (16, 12, 1), kind="hexahedron20")
    thin = ao.FEModel.from_mesh(mesh, ALU, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    with pytest.raises(ao.InputError, match=r"^radius"):
        ao.simulate(BALL, thin.contact(point=(0.12, 0.06, 0.006), radius=0.02), 1.0)
    wide = ao.simulate(BALL, thin.contact(point=(0.12, 0.06, 0.006), radius=0.006), 1.0)
    assert abs(wide.peak_force / 656.3 - 1.0) < wide.error["peak_force"].total  # of fine meshes


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*the mesh makes an error")
def test_a_contact_over_an_edge_has_a_large_error() -> None:
    """An edge cuts off a part of its disc of 0.48 mm."""
    block = ao.FEModel.from_mesh(
        ao.box_mesh((0.06, 0.06, 0.03), (6, 6, 3), kind="hexahedron20"), ALU
    )
    errors = [
        ao.simulate(BALL, block.contact(point=(x, 0.03, 0.03)), 1.0).error["peak_force"].contact
        for x in (0.0004, 0.001)
    ]
    assert errors[0] > 0.02 > 4.0 * errors[1]


def test_what_a_body_without_a_mesh_leaves_out_stays_in_its_error(tmp_path: Path) -> None:
    """An unknown part of an error makes the sum unknown wherever it is printed or kept."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    mesh = ao.box_mesh((0.05, 0.04, 0.01), (4, 4, 1), kind="hexahedron20")
    block = ao.FEModel.from_mesh(mesh, steel, fixed=[("xmin", "xyz")])
    bare = ao.FEModel(K=block.K, M=block.M)
    node = int(np.argmin(np.linalg.norm(block.nodes - (0.025, 0.02, 0.01), axis=1)))
    tip = bare.contact(dof=int(np.flatnonzero(block.free == 3 * node + 2)[0]))
    case = {"projectile": BALL, "target": tip, "velocity": 1.0}
    hertz = ao.Hertz.between(steel, 0.01, steel, math.inf)
    with pytest.warns(ao.AOImpactWarning, match="with_mesh"):
        hit = ao.simulate(**case, law=hertz)
    for error in (hit.error, hit.error["peak_force"], hit.error["impulse"]):
        assert error.mesh is error.contact is None
        assert math.isnan(error.total)
    peak = hit.error["peak_force"]
    assert peak.unknown == ("mesh", "contact")
    assert peak.least == peak.model + peak.time
    printed = [line for line in repr(hit).splitlines() if "±" in line]
    assert len(printed) >= 5
    assert all(line.count("±") == line.count("± at least") for line in printed)
    assert "(mesh and contact not known, " in printed[0]
    # A spring leaves out the half-space: the node's own indentation is in K and M as it is meant.
    table = ao.sweep(case | {"law": ao.Linear(k=1e7)}, {"velocity": [1.0]}, keep="peak_force")
    assert math.isnan(table["peak_force_error"][0])
    table.to_csv(tmp_path / "sweep.csv")
    assert "nan" in (tmp_path / "sweep.csv").read_text()
