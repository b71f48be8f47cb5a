"""Finite-element models: natural frequencies, rigid motions, supports, and anyone's matrices."""

from __future__ import annotations

import copy
import gc
import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from aoimpact import (
    AOImpactWarning,
    FEModel,
    InputError,
    InputTypeError,
    Material,
    box_mesh,
    sphere_mesh,
)

FloatArray = npt.NDArray[np.float64]

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
ALUMINIUM = Material(E=70e9, nu=0.3, rho=2400.0)
BEAM = box_mesh((1.0, 0.02, 0.02), (50, 2, 2))
BLOCK = box_mesh((0.05, 0.03, 0.02), (3, 2, 2))


def bottom_edge(x: float) -> Callable[[FloatArray], npt.NDArray[np.bool_]]:
    return lambda nodes: (np.abs(nodes[:, 0] - x) < 1e-9) & (np.abs(nodes[:, 2]) < 1e-9)


def chain(n: int, k: float = 4.0, m: float = 9.0) -> tuple[sp.csr_array, sp.csr_array]:
    """`n` equal masses in a row, free at both ends."""
    K = sp.diags_array([-k, 2.0 * k, -k], offsets=[-1, 0, 1], shape=(n, n)).tolil()
    K[0, 0] = K[n - 1, n - 1] = k
    return sp.csr_array(K), sp.csr_array(m * sp.eye_array(n))


# --- The paper's bodies ---


def test_beam_of_quadratic_elements_does_not_lock() -> None:
    # Euler-Bernoulli, simply supported: 48.98 Hz, less shear and rotary inertia, which are < 0.1 %.
    # Here the supports are on the bottom edges, which holds the axis a little.
    mesh = box_mesh((1.0, 0.02, 0.02), (20, 1, 1), kind="hexahedron20")
    middle = [
        (lambda p: (np.abs(p[:, 0]) < 1e-9) & (np.abs(p[:, 2] - 0.01) < 1e-9), "xyz"),
        (lambda p: (np.abs(p[:, 0] - 1.0) < 1e-9) & (np.abs(p[:, 2] - 0.01) < 1e-9), "yz"),
    ]
    beam = FEModel.from_mesh(mesh, ALUMINIUM, fixed=middle)
    exact = math.pi / 2.0 * math.sqrt(70e9 / 2400.0) * 0.02 / math.sqrt(12.0)
    assert exact == pytest.approx(48.98, abs=0.01)
    assert beam.frequencies(1)[0] == pytest.approx(exact, rel=3e-3)


def sphere_ratios(model: FEModel, radius: float) -> FloatArray:
    """ωR/c_t of the first torsional and the first spheroidal multiplets, each of five modes."""
    omega = 2.0 * math.pi * model.frequencies(16)[6:]
    return (omega * radius / STEEL.shear_speed).reshape(2, 5)


# tan x = 3x/(3 − x²) for n = 2 torsion, and Lamb's equation at ν = .3 (Love 1944, sec. 194-196).
SPHERE = np.array([2.50113, 2.64622])


@pytest.mark.slow
def test_fine_sphere_converges_to_the_closed_form() -> None:
    model = FEModel.from_mesh(sphere_mesh(0.01, 0.0022), STEEL)
    assert sphere_ratios(model, 0.01) == pytest.approx(np.outer(SPHERE, np.ones(5)), rel=1e-4)


# --- Frequencies ---


# --- Rigid motions ---


@pytest.mark.parametrize(
    ("fixed", "free_motions"),
    [
        (None, 6),
        ([], 6),
        ([([0], "x")], 5),
        ([([0], "xyz")], 3),
        ([("zmin", "z")], 3),
        ([("zmin", "z"), ("xmin", "x")], 1),
        ([(bottom_edge(0.0), "xyz")], 1),  # a hinge
        ([(bottom_edge(0.05), "xyz"), ([0], "z")], 0),
        ([("xmin", "xyz")], 0),
        ([("xmin", "x"), ("ymin", "y"), ("zmin", "z")], 0),
    ],
)
def test_supports_leave_the_rigid_motions_that_statics_says(fixed: Any, free_motions: int) -> None:
    body = FEModel.from_mesh(BLOCK, STEEL, fixed=fixed)
    modes = body.rigid_modes
    assert modes.shape == (body.n_dofs, free_motions)
    assert modes.T @ (body.M @ modes) == pytest.approx(np.eye(free_motions), abs=1e-13)
    assert np.abs(body.K @ modes).max(initial=0.0) < 1e-13 * (abs(body.K) @ abs(modes)).max(
        initial=1.0
    )
    frequencies = body.frequencies(7)
    assert (frequencies[:free_motions] == 0.0).all()
    assert (frequencies[free_motions:] > 1e3).all()


def test_a_hinge_about_any_line_is_found() -> None:
    # Held in the two ends of a space diagonal: what is left is no rotation about an axis.
    mesh = box_mesh((0.05, 0.03, 0.02), (2, 2, 2), kind="hexahedron20")
    ends = [
        int(np.abs(mesh.nodes - p).sum(axis=1).argmin()) for p in ([0, 0, 0], [0.05, 0.03, 0.02])
    ]
    body = FEModel.from_mesh(mesh, STEEL, fixed=[(ends, "xyz")])
    motion = np.zeros(3 * mesh.n_nodes)
    motion[body.free] = body.rigid_modes[:, 0]
    turned = np.cross([0.05, 0.03, 0.02], mesh.nodes)
    along = motion @ turned.reshape(-1) / (np.linalg.norm(motion) * np.linalg.norm(turned))
    assert body.rigid_modes.shape[1] == 1
    assert abs(along) == pytest.approx(1.0, rel=1e-12)


def test_rigid_motions_without_nodes_are_the_null_space() -> None:
    body = FEModel.from_mesh(BLOCK, STEEL)
    bare = FEModel(K=body.K, M=body.M)
    assert bare.rigid_modes.shape == body.rigid_modes.shape
    overlap = body.rigid_modes.T @ (body.M @ bare.rigid_modes)
    assert overlap @ overlap.T == pytest.approx(np.eye(6), abs=1e-9)
    assert bare.mass is None
    assert bare.frequencies(9) == pytest.approx(body.frequencies(9), rel=1e-7, abs=1e-3)


# --- Mass and its centre ---


def test_translations_carry_the_whole_mass() -> None:
    body = FEModel.from_mesh(BLOCK, STEEL)
    for direction in ([1, 0, 0], [0, -2, 0], [1, 2, 3]):
        r = body.translation(direction)
        assert r @ (body.M @ r) == pytest.approx(body.mass, rel=1e-13)
        assert body.com_functional(direction) @ r == pytest.approx(1.0, rel=1e-13)


def test_centre_of_mass_counts_the_nodes_that_are_held() -> None:
    # u = x/L on a bar held at x = 0: the centre moves by 1/2, though held nodes carry mass too.
    body = FEModel.from_mesh(BLOCK, STEEL, fixed=[("xmin", "xyz")])
    assert body.nodes is not None
    assert body.free is not None
    stretched = np.zeros((BLOCK.n_nodes, 3))
    stretched[:, 0] = BLOCK.nodes[:, 0] / 0.05
    u = stretched.reshape(-1)[body.free]
    assert body.com_functional([1, 0, 0]) @ u == pytest.approx(0.5, rel=1e-13)
    assert body.com_functional([0, 1, 0]) @ u == pytest.approx(0.0, abs=1e-15)
    assert body.mass == pytest.approx(7800 * 0.05 * 0.03 * 0.02, rel=1e-13)


def test_matrices_without_the_held_dofs_do_not_know_the_mass() -> None:
    held = FEModel.from_mesh(BLOCK, STEEL, fixed=[("xmin", "xyz")])
    given_ = FEModel(K=held.K, M=held.M, nodes=held.nodes, free=held.free)
    assert given_.mass is None
    assert np.array_equal(given_.translation([0, 1, 0]), held.translation([0, 1, 0]))
    with pytest.raises(InputError, match="centre"):
        given_.com_functional([1, 0, 0])
    with pytest.raises(InputError, match="centre"):
        FEModel(K=held.K, M=held.M).com_functional([1, 0, 0])
    with pytest.raises(InputError, match="nodes"):
        FEModel(K=held.K, M=held.M).translation([1, 0, 0])


def test_dofs_ordered_by_component_are_noticed() -> None:
    body = FEModel.from_mesh(BLOCK, STEEL)
    by_component = np.arange(body.n_dofs).reshape(-1, 3).T.reshape(-1)
    K, M = (A[by_component][:, by_component] for A in (body.K, body.M))
    with pytest.warns(AOImpactWarning, match=r"^M"):
        FEModel(K=K, M=M, nodes=BLOCK.nodes)


# --- Supports ---


def test_supports_by_number_by_name_by_function_and_by_mask_are_the_same() -> None:
    on_face = BLOCK.nodes[:, 0] == 0.0
    ways: list[Any] = [
        "xmin",
        np.flatnonzero(on_face),
        np.flatnonzero(on_face).tolist(),
        on_face,
        lambda nodes: nodes[:, 0] < 1e-9,
    ]
    bodies = [FEModel.from_mesh(BLOCK, STEEL, fixed=[(way, "zx")]) for way in ways]
    for body in bodies:
        assert np.array_equal(body.free, bodies[0].free)
        assert (body.K != bodies[0].K).nnz == 0
    assert bodies[0].n_dofs == 3 * BLOCK.n_nodes - 2 * on_face.sum()


def test_supports_add_up() -> None:
    one = FEModel.from_mesh(BLOCK, STEEL, fixed=[([0, 5], "xyz")])
    other = FEModel.from_mesh(
        BLOCK, STEEL, fixed=[([0], "x"), ([5], "zyx"), ([0], "yz"), (0, "xx")]
    )
    assert np.array_equal(one.free, other.free)


@pytest.mark.parametrize(
    "nodes", [lambda p: p[:, 0] == 7.0, lambda p: p[:, 0], lambda p: p == 0.0, lambda p: True]
)
def test_functions_that_select_no_nodes_are_named(nodes: Any) -> None:
    with pytest.raises((InputError, InputTypeError), match=r"^fixed"):
        FEModel.from_mesh(BLOCK, STEEL, fixed=[(nodes, "x")])


def test_what_a_function_of_supports_raised_is_kept_as_the_cause() -> None:
    with pytest.raises(InputError) as caught:
        FEModel.from_mesh(BLOCK, STEEL, fixed=[(lambda nodes: 1 // 0, "x")])
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


# --- Anyone's matrices ---


def test_asymmetry_of_rounding_is_averaged_away() -> None:
    K, M = chain(3)
    K[0, 1] += 4e-9
    body = FEModel(K=K, M=M)
    assert (body.K != body.K.T).nnz == 0
    assert body.K[0, 1] == pytest.approx(-4.0 + 2e-9, abs=1e-15)


def test_energy_that_a_motion_gives_back_is_refused() -> None:
    """Every diagonal entry and every pair of dofs is right; only all of them together are not."""
    n = 600
    K = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)).tolil()
    M = sp.diags_array([0.6, 1.0, 0.6], offsets=[-1, 0, 1], shape=(n, n))  # 1 − 1.2 cos at least
    with pytest.raises(InputError, match=r"^M"):
        FEModel(K=K, M=M)
    K[n // 2, n // 2] = 0.5
    assert np.linalg.eigvalsh(K.toarray())[0] < -0.1
    with pytest.raises(InputError, match=r"^K"):
        FEModel(K=K, M=sp.eye_array(n))


def test_matrices_of_a_mesh_pass_whether_held_or_free_and_with_ten_digits() -> None:
    bar = box_mesh((0.5, 0.02, 0.02), (60, 1, 1), kind="hexahedron20")
    for fixed in (None, [("xmin", "xyz")]):
        body = FEModel.from_mesh(bar, ALUMINIUM, fixed=fixed)
        assert body.n_dofs > 500
        FEModel(K=body.K, M=body.M)
        printed = body.K.copy()
        printed.data = np.array([float(f"{value:.9e}") for value in body.K.data])
        FEModel(K=printed, M=body.M)


@settings(deadline=None, max_examples=30, derandomize=True)
@given(st.integers(1, 9), st.integers(0, 3), st.integers(0, 10**6))
def test_null_space_of_any_matrix_is_found(n: int, rank_loss: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rank = max(0, n - rank_loss)
    root = rng.standard_normal((n, rank))
    mass = rng.standard_normal((n, n))
    body = FEModel(K=root @ root.T, M=mass @ mass.T + n * np.eye(n))
    assert body.rigid_modes.shape == (n, n - rank)


# --- From mesh to model ---


@pytest.mark.parametrize("fixed", [None, [("xmin", "xyz")]])
def test_a_pickle_carries_the_mesh_and_not_what_is_assembled_from_it(fixed: Any) -> None:
    body = FEModel.from_mesh(box_mesh((0.1, 0.1, 0.02), (6, 6, 2)), STEEL, fixed=fixed)
    tip = body.contact(point=(0.05, 0.05, 0.02))
    body.inverse(1e10).solve(tip.b)  # what is kept on the way does not travel, either
    packed = pickle.dumps(body)
    assert len(packed) < 0.1 * (body.K.data.nbytes + body.M.data.nbytes)
    assert pickle.loads(packed) is body  # which is still there
    assert copy.copy(body).K is body.K
    with pytest.raises(AttributeError, match="stiffness"):
        body.stiffness  # noqa: B018
    matrices = {name: getattr(body, name) for name in ("K", "M")}
    del body, tip
    gc.collect()
    again = pickle.loads(packed)
    assert "K" not in vars(again)
    for name, ours in matrices.items():
        theirs = getattr(again, name)
        np.testing.assert_array_equal(ours.indices, theirs.indices)
        np.testing.assert_array_equal(ours.data, theirs.data)
    assert pickle.loads(packed) is again
    assert copy.copy(again) is not again is not copy.deepcopy(again)
