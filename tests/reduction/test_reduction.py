"""Anti-oscillators against the closed forms of rods and beams, and against the full receptance."""

import math

import numpy as np
import pytest
import scipy.linalg as la
import scipy.optimize
import scipy.sparse as sp

import aoimpact as ao

from slender import beam, in_a_row, joined, rod


def model(K, M, dof, n=None, *, method="eigen", **options):
    tip = ao.FEModel(K=K, M=M).contact(dof=dof)
    return ao.antioscillators(tip, n, method=method, **options)


def full_receptance(K, M, b, omega):
    dense = K.toarray(), M.toarray()
    return np.array([b @ la.solve(dense[0] - w**2 * dense[1], b) for w in omega])


def convergence_order(errors, refinement=2):
    return np.log(errors[:-1] / errors[1:]) / np.log(refinement)


# ------------------------------------------------------------------------- closed forms: rods


@pytest.mark.parametrize("sparse", [False, True], ids=["dense", "iterative"])
def test_clamped_rod_struck_at_its_end(sparse):
    """φ_st = x/L, so m_st = M/3; φ_i = sin iπx/L, so m_i = 2M/(iπ)², k_i = 2EA/L, k0 = EA/L."""
    errors = []
    # Beyond 1500 dofs the constraint modes come from shift-and-invert iterations.
    sizes = (1600, 3200) if sparse else (50, 100, 200)
    for elements in sizes:
        K, M = rod(elements, fixed=[0])
        star = model(K, M, elements - 1, 4, order="frequency")
        i = np.arange(1, 5)
        rounding = np.finfo(float).eps * (2 * elements / np.pi) ** 2  # times the condition of K
        assert star.k0 == pytest.approx(1.0, rel=rounding)
        assert star.static_mass == pytest.approx(1 / 3, rel=rounding)
        ratios = star.m * (i * np.pi) ** 2 / 2, star.frequencies * 2 / i, star.k / 2
        errors.append(np.abs(np.array(ratios) - 1))
    orders = convergence_order(np.array(errors)[:, 1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.02)
    assert np.max(errors[-1][0]) < 1e-6  # the masses converge twice as fast
    assert np.max(errors[-1]) < 2e-3


def test_clamped_rods_oscillators_hold_all_its_static_mass_in_the_limit():
    """Σ 2M/(iπ)² = M/3: a rod has no residual mass; what a mesh leaves is its end node's share."""
    residual = [model(*rod(n, fixed=[0]), n - 1).m0 for n in (50, 100, 200)]
    np.testing.assert_allclose(convergence_order(np.array(residual)), 1.0, atol=0.02)


def test_free_rod_struck_at_its_end():
    """φ_st = 1, so m_st = M; φ_i = sin (i-½)πx/L from the struck end: m_i = 2M/((i-½)π)²."""
    star = model(*rod(400), 400, 3, order="frequency")
    turns = np.array([0.5, 1.5, 2.5])
    assert star.k0 == 0.0
    assert star.static_mass == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(star.m, 2 / (turns * np.pi) ** 2, rtol=1e-4)
    np.testing.assert_allclose(star.frequencies, turns / 2, rtol=1e-4)


# ------------------------------------------------------------------------ closed forms: beams


def roots_of_tan_x_is_tanh_x(count):
    def f(x):
        return math.sin(x) - math.cos(x) * math.tanh(x)

    spans = [(i * math.pi + 1e-9, (i + 0.5) * math.pi) for i in range(1, count + 1)]
    return np.array([scipy.optimize.brentq(f, *span, xtol=1e-14) for span in spans])


def test_simply_supported_beam_struck_at_midspan():
    """m_st = 17/35 M, k0 = 48 EI/L³; m_i = 4M coth²x/x² with tan x = tanh x, ω_i = (2x/L)²."""
    x = roots_of_tan_x_is_tanh_x(5)
    errors = []
    for elements in (20, 40):
        K, M = beam(elements, fixed=[0, 2 * elements])
        star = model(K, M, elements - 1, 5)  # w at midspan; one dof before it is taken out
        assert star.k0 == pytest.approx(48.0, rel=1e-9)
        assert star.static_mass == pytest.approx(17 / 35, rel=1e-9)
        errors.append(np.abs(star.frequencies / ((2 * x) ** 2 / (2 * np.pi)) - 1))
        np.testing.assert_allclose(star.m, 4 / np.tanh(x) ** 2 / x**2, rtol=2e-3)
    np.testing.assert_allclose(convergence_order(np.array(errors)), 4.0, atol=0.25)
    assert star.m[0] == pytest.approx(0.259837, rel=2e-5)
    assert star.mass_fractions[0] == pytest.approx(0.259837 * 35 / 17, rel=2e-5)


def test_only_symmetric_constraint_modes_of_a_beam_carry_mass():
    """Struck at midspan, half of the constraint modes are antisymmetric: they are left out."""
    K, M = beam(20, fixed=[0, 40])
    symmetric = 9 + 10  # deflections and slopes of one half, but for the struck node
    assert model(K, M, 19).n == symmetric
    with pytest.warns(ao.AOImpactWarning, match=r"^n"):
        assert model(K, M, 19, 30).n == symmetric


# --------------------------------------------------------- any matrices: the receptance is kept

rng = np.random.default_rng(5)


def random_body(n, rigid=0):
    """Dense symmetric K with `rigid` zero eigenvalues, and an M that is not diagonal."""
    vectors = la.qr(rng.standard_normal((n, n)))[0]
    values = np.concatenate([np.zeros(rigid), rng.uniform(1, 1e4, n - rigid)])
    M = sp.csr_matrix(la.toeplitz([4.0, 1.0] + [0.0] * (n - 2)) / 6)
    root = la.cholesky(M.toarray(), lower=True)
    K = root @ (vectors * values) @ vectors.T @ root.T
    return sp.csr_matrix((K + K.T) / 2), M


@pytest.mark.parametrize("rigid", [0, 1, 3])
def test_all_antioscillators_are_the_body_exactly(rigid):
    K, M = random_body(30, rigid)
    body = ao.FEModel(K=K, M=M)
    star = ao.antioscillators(body.contact(dof=7))
    omega = np.linspace(0.3, 150, 40)
    b = np.eye(30)[7]
    np.testing.assert_allclose(star.receptance(omega), full_receptance(K, M, b, omega), rtol=1e-7)
    assert (star.k0 == 0.0) == (rigid > 0)


@pytest.mark.parametrize("rigid", [0, 1])
def test_residual_mass_of_the_whole_star_is_that_of_the_bare_contact(rigid):
    """At infinite frequency only m0 answers: 1/m0 = bᵀ M⁻¹ b."""
    K, M = random_body(25, rigid)
    star = model(K, M, 3)
    assert 1 / star.m0 == pytest.approx(la.inv(M.toarray())[3, 3], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("n", [5, 40])
@pytest.mark.parametrize("fixed", [[("xmin", "xyz")], []], ids=["constrained", "free"])
def test_the_heaviest_oscillators_of_all_are_found_without_all(n, fixed):
    """On a plate, where masses do not fall with the frequency; LAPACK has all oscillators."""
    mesh = ao.box_mesh((0.2, 0.1, 0.01), (10, 5, 1), kind="hexahedron20")
    plate = ao.FEModel.from_mesh(mesh, ao.Material(E=210e9, nu=0.3, rho=7800), fixed=fixed)
    tip = plate.contact(point=(0.14, 0.04, 0.01), direction=(0, 0, -1), radius=0)
    every, some = ao.antioscillators(tip), ao.antioscillators(tip, n, method="eigen")
    assert (np.diff(every.m) <= 0).all()
    assert (np.diff(every.k[:n] / every.m[:n]) < 0).any()
    np.testing.assert_allclose(some.m, every.m[:n], rtol=1e-7)
    np.testing.assert_allclose(some.k, every.k[:n], rtol=1e-7)


def test_members_of_a_multiple_eigenvalue_are_joined_and_none_is_missed():
    """Five equal rods hung on one struck mass: every constraint mode is fivefold."""
    for elements in (30, 320):  # small enough for LAPACK, large enough for the iteration
        K, M = rod(elements)
        star = model(*joined(K, M, 0, 5), 0, 3, order="frequency")
        single = model(K, M, 0, 3, order="frequency")
        np.testing.assert_allclose(star.m, 5 * single.m, rtol=1e-8)
        np.testing.assert_allclose(star.k, 5 * single.k, rtol=1e-8)


@pytest.mark.parametrize("ratio", [1e3, 1e10, 1e12])
def test_a_light_mass_behind_a_heavy_contact_keeps_its_digits(ratio):
    """Two masses and a spring, the heavier held: m and k are those of the lighter one."""
    k, m = 3.1e6, 1.3
    light = model(np.array([[k, -k], [-k, k]]), np.diag([m, m * ratio]), 1, 1)
    np.testing.assert_allclose([light.m[0], light.k[0]], [m, k], rtol=1e-14)


def test_a_mass_lost_in_the_rounding_of_the_contact_s_makes_no_oscillator():
    K, M = np.array([[1e6, -1e6], [-1e6, 1e6]]), np.diag([1.0, 1e17])
    with pytest.warns(ao.AOImpactWarning, match=r"^n"):
        heavy = model(K, M, 1, 1)
    assert heavy.m0 == pytest.approx(1e17, rel=1e-14)


def test_a_motion_without_mass_bounds_no_oscillators():
    """M⁻¹b does not exist where b moves a motion without mass: LAPACK finds the oscillators."""
    n = 600
    M = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)).tolil()
    M[0, 0] = M[-1, -1] = 1.0
    K = sp.diags_array(np.arange(1.0, n + 1.0))
    some, every = model(K, M.tocsr(), 4, 3), model(K, M.tocsr(), 4)
    np.testing.assert_allclose(some.m, every.m[:3], rtol=1e-12)


def test_motion_that_never_feels_the_contact_is_left_out():
    """A second body beside the first, never touched, adds nothing (and has a rigid motion)."""
    K, M = rod(40)
    alone = model(K, M, 40)
    beside = model(in_a_row(K, K), in_a_row(M, M), 40)
    assert beside.static_mass == pytest.approx(alone.static_mass, rel=1e-9)
    np.testing.assert_allclose(beside.m, alone.m, rtol=1e-7)


def test_a_held_body_with_an_idle_free_part_is_held():
    K, M = rod(40, fixed=[0])
    free_K, free_M = rod(10)
    star = model(in_a_row(K, free_K), in_a_row(M, free_M), 39)
    assert star.k0 == pytest.approx(1.0, rel=1e-9)
    assert star.static_mass == pytest.approx(1 / 3, rel=1e-9)


# ----------------------------------------------------------------------------- shapes and order


def test_expand_gives_back_the_displacement():
    K, M = random_body(20)
    body = ao.FEModel(K=K, M=M)
    tip = body.contact(dof=4)
    star = ao.antioscillators(tip)
    # The contact coordinate is λ0 whatever the others are.
    coordinates = rng.standard_normal((star.n + 1, 3))
    np.testing.assert_allclose(tip.b @ star.expand(coordinates), coordinates[0], atol=1e-12)
    # Energies are the same in both descriptions.
    x = coordinates[:, 0]
    full = star.expand(x)
    elastic = star.k0 * x[0] ** 2 + star.k @ (x[1:] - x[0]) ** 2
    assert full @ (K @ full) == pytest.approx(elastic, rel=1e-9)
    kinetic = star.m0 * x[0] ** 2 + star.m @ x[1:] ** 2
    assert full @ (M @ full) == pytest.approx(kinetic, rel=1e-9)
    # All coordinates alike is the static mode: the shape under a force there.
    static = la.solve(K.toarray(), tip.b)
    np.testing.assert_allclose(star.expand(np.ones(star.n + 1)), static / static[4], rtol=1e-8)


def test_no_oscillator_leaves_the_static_mass_on_the_static_spring():
    star = model(*rod(30, fixed=[0]), 29, 0)
    assert (star.n, star.k0) == (0, pytest.approx(1.0))
    assert star.m0 == pytest.approx(1 / 3)
