"""Lowest eigenpairs: of known spectra, multiple ones, with and without rigid motions."""

import warnings

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from thinmeshes import grid

import aoimpact as ao
from aoimpact.linalg import lowest, null_space

from slender import beam, in_a_row, rod


def test_frequencies_of_a_free_beam():
    """ω = (βL)² with cos βL cosh βL = 1; two rigid motions first."""
    K, M = beam(300)
    rigid = null_space(K, M)
    assert rigid.shape == (602, 2)
    omega2, modes = lowest(K, M, 5, known=rigid)
    assert omega2[:2].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(
        np.sqrt(omega2[2:]), np.array([4.73004074, 7.85320462, 10.99560784]) ** 2, rtol=1e-7
    )
    np.testing.assert_allclose(modes.T @ (M @ modes), np.eye(5), atol=1e-9)


@pytest.mark.parametrize("copies", [2, 5])
def test_no_member_of_a_multiple_eigenvalue_is_missed(copies):
    K, M = rod(300, fixed=[0])
    omega2, modes = lowest(in_a_row(*[K] * copies), in_a_row(*[M] * copies), 3 * copies)
    exact = np.repeat((np.arange(3) + 0.5) * np.pi, copies)
    np.testing.assert_allclose(np.sqrt(omega2), exact, rtol=1e-4)
    np.testing.assert_allclose(
        modes.T @ (in_a_row(*[M] * copies) @ modes), np.eye(3 * copies), atol=1e-8
    )


@pytest.mark.parametrize("copies", [1, 3, 12])
def test_every_free_piece_has_its_rigid_motion(copies):
    K, M = rod(60)
    K, M = in_a_row(*[K] * copies), in_a_row(*[M] * copies)
    rigid = null_space(K, M)
    assert rigid.shape == (61 * copies, copies)
    assert np.abs(K @ rigid).max() < 1e-9 * abs(K).max()


def test_elements_of_very_different_size_do_not_look_like_rigid_motion():
    """Springs over nine decades: soft is not free."""
    k = np.geomspace(1.0, 1e9, 50)
    K = sp.diags([k + np.append(k[1:], 0.0), -k[1:], -k[1:]], [0, 1, -1]).tocsr()
    assert null_space(K, sp.identity(50, format="csr")).shape == (50, 0)


@pytest.mark.parametrize("thickness", [5e-4, pytest.param(1e-3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("held", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_strip_a_thousand_times_as_long_as_thick_vibrates_as_a_beam(thickness, held):
    """Its lowest ω² is 1e-13 of the highest one, and K has as many digits less for it."""
    length = 1.0
    mesh = ao.box_mesh((length, 0.03, thickness), (120, 2, 1), kind="hexahedron20")
    fixed = [("xmin", "xyz")] if held else None
    strip = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.0, rho=2700.0), fixed=fixed)
    first = 1.8751040687 if held else 4.7300407449
    exact = first**2 / (2.0 * np.pi * length**2) * np.sqrt(70e9 / 2700.0 / 12.0) * thickness
    found = strip.frequencies(9)
    assert found[0 if held else 6] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(("thickness", "lost"), [(1e-3, False), (1e-4, True)])
@pytest.mark.parametrize(
    "made",
    ["frequencies", *(pytest.param(how, marks=pytest.mark.slow) for how in ("modal", "eigen"))],
)
def test_stiffness_that_rounding_drowns_is_said(thickness, lost, made):
    """Rounding of K is 1e-16 of the highest ω²; of a bar 10 000 times as long as thick the lowest
    is less."""
    mesh = ao.box_mesh((1.0, thickness, thickness), (20, 1, 1), kind="hexahedron20")
    bar = ao.FEModel.from_mesh(mesh, ao.Material(E=210e9, nu=0.0, rho=7800.0))
    end = (1.0, 0.5 * thickness, thickness)
    tip = bar.contact(point=end, direction=(0, 0, -1), radius=0)
    make = {
        "frequencies": lambda: bar.frequencies(8),
        "modal": lambda: ao.modal(tip, 8),
        "eigen": lambda: ao.antioscillators(tip, 2),
    }[made]
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        make()
    assert any("rounding of K is as large" in str(one.message) for one in said) == lost


@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("n", [20, pytest.param(140, marks=pytest.mark.slow)])
def test_rotations_without_mass_leave_the_frequencies_of_a_shell_right(turn, n):
    """Against LAPACK on K and M with the massless motions statically condensed."""
    c, s = np.cos(turn), np.sin(turn)
    nodes, cells, x, y = grid(12, 12, lambda x, y: (0.3 * x, 0.3 * c * y, 0.3 * s * y))
    rim = np.flatnonzero((x == 0.0) | (x == 1.0) | (y == 0.0) | (y == 1.0))
    mesh = ao.Mesh(nodes, cells, "quad", node_sets={"rim": rim})
    layers = ao.Shell(8e-3, ao.Material(E=210e9, nu=0.3, rho=7800.0))
    body = ao.FEModel.from_mesh(mesh, layers, fixed=[("rim", "xyz", "xyz")])
    K, M = body.K.toarray(), body.M.toarray()
    mass, motions = np.linalg.eigh(M)
    light = mass < 1e-12 * mass[-1]
    assert light.sum() == 121  # the normal's rotation at each free node
    N, R = motions[:, light], motions[:, ~light]
    condensed = R.T @ (K - K @ N @ np.linalg.solve(N.T @ K @ N, N.T @ K)) @ R
    exact = scipy.linalg.eigh(condensed, R.T @ M @ R, eigvals_only=True)[:n]
    np.testing.assert_allclose(body.frequencies(n), np.sqrt(exact) / (2.0 * np.pi), rtol=1e-9)


@pytest.mark.parametrize("n", [5, 11, 20])
def test_there_are_as_many_modes_as_masses(n):
    """Eleven point masses on 1000 springs, against LAPACK on the compliances between them."""
    K, _ = rod(1000, fixed=[0])
    masses = np.zeros(1000)
    masses[::100], masses[3] = 1.0, 1e-3
    heavy = np.flatnonzero(masses)
    omega2, modes = lowest(K, sp.diags(masses).tocsr(), n)
    compliance = np.linalg.inv(K.toarray())[np.ix_(heavy, heavy)]
    root = np.sqrt(masses[heavy])
    exact = 1.0 / np.linalg.eigvalsh(root[:, None] * compliance * root)[::-1]
    np.testing.assert_allclose(omega2, exact[:n], rtol=1e-9)
    np.testing.assert_allclose(modes.T @ (masses[:, None] * modes), np.eye(min(n, 11)), atol=1e-9)
