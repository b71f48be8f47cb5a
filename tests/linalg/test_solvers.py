"""Linear solvers: one answer from all of them, and a clear word where there is none."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import aoimpact as ao
from aoimpact import box_mesh
from aoimpact.linalg import (
    METHODS,
    SOLVERS,
    Pencil,
    linear_solver,
)

ROOT = Path(__file__).parents[2]
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)

needs_pardiso = pytest.mark.skipif(
    not METHODS["pardiso"].is_installed(), reason="py-mkl-pardiso is not there"
)


def named(methods):
    """The methods as parameters, skipped where their package is not there."""
    return [
        pytest.param(of.name, marks=() if of.is_installed() else pytest.mark.skip("not installed"))
        for of in methods
    ]


DIRECT = named(of for of in METHODS.values() if of is not METHODS["multigrid"])
EVERY = [*named(METHODS.values()), pytest.param(spla.factorized, id="a function")]


def test_every_solver_is_named_where_solvers_are_listed():
    listed = "{" + ", ".join(f'"{name}"' for name in SOLVERS) + "} or callable"
    package = ROOT / "aoimpact"
    for file in package.rglob("*.py"):
        for found in re.findall(r'\{"auto", .*?\} or callable', file.read_text(encoding="utf-8")):
            assert found == listed, f"{file.relative_to(ROOT)}: of METHODS it is {listed}"
    page = (ROOT / "docs" / "scene-files.md").read_text(encoding="utf-8")
    assert all(page.count(f'"{name}"') >= 2 for name in SOLVERS), "`solver` and `linear_solver`"


@pytest.fixture(scope="module")
def block():
    mesh = box_mesh((0.04, 0.02, 0.02), (5, 3, 3), kind="tetra10")
    return ao.FEModel.from_mesh(mesh, STEEL)


@pytest.fixture(scope="module")
def bar():
    mesh = box_mesh((0.3, 0.02, 0.02), (30, 1, 1), kind="tetra10")
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])


def dense(body, s2):
    return body.K.toarray() + s2 * body.M.toarray()


# --------------------------------------------------------------------------------- one answer


@pytest.fixture(scope="module")
def solved(block, bar):
    """Bodies, shifts, forces, and the displacements by dense elimination."""
    found = []
    for body, s2 in ((block, 1e12), (bar, 1e10), (bar, 0.0)):
        f = np.random.default_rng(0).standard_normal((body.n_dofs, 2))
        found.append((body, s2, f, np.linalg.solve(dense(body, s2), f)))
    return found


@pytest.mark.parametrize("solver", EVERY)
def test_every_solver_solves_the_same_systems(solved, solver):
    for body, s2, f, exact in solved:
        found = body.inverse(s2, solver=solver)
        x = found.solve(f)
        np.testing.assert_allclose(x, exact, rtol=1e-6, atol=1e-20)
        np.testing.assert_allclose(found.solve(f[:, 1]), x[:, 1], rtol=1e-9)


def test_a_solution_is_refined_until_its_residual_passes(bar):
    """A solver in single precision is no worse than one in double, a few steps later."""
    calls = []

    def single(matrix):
        factors = spla.splu(matrix.astype(np.float32))

        def solve(f):
            calls.append(f)
            return factors.solve(f.astype(np.float32)).astype(float)

        return solve

    f = np.random.default_rng(1).standard_normal(bar.n_dofs)
    x = bar.inverse(1e10, solver=single).solve(f)
    assert len(calls) > 1
    residual = f - (bar.K + 1e10 * bar.M) @ x
    assert np.linalg.norm(residual) <= 1e-10 * np.linalg.norm(f)


@pytest.mark.parametrize("returned", ["right-hand side", "one array"])
def test_a_users_solver_may_overwrite_what_it_got_or_gave(bar, returned):
    def overwriting(matrix):
        factors, kept = spla.splu(matrix), np.empty(bar.n_dofs)

        def solve(f):
            x = f if returned == "right-hand side" else kept
            x[:] = factors.solve(f)
            return x

        return solve

    loads = np.random.default_rng(1).standard_normal((bar.n_dofs, 3))
    expected = bar.inverse(1e10, solver="superlu").solve(loads)
    own = bar.inverse(1e10, solver=overwriting)
    one_by_one = np.transpose([own.solve(load) for load in loads.T])
    for found in one_by_one, own.solve(loads):
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-20)


# --------------------------------------------------------------------------- the choice of one


@pytest.mark.parametrize(
    ("lengths", "divisions", "direct"),
    [
        ((0.5, 0.02, 0.02), (40, 2, 2), True),  # slender
        ((0.02, 0.02, 0.02), (5, 5, 5), True),  # small
        ((0.3, 0.3, 0.3), (10, 10, 10), False),  # compact
        ((0.3, 0.3, 0.003), (7, 7, 7), True),  # flat elements
    ],
)
def test_the_quickest_is_taken(lengths, divisions, direct, monkeypatch):
    """By estimates from the graph and the shapes of elements, without its factors or levels."""
    for name, method in list(METHODS.items()):
        monkeypatch.setitem(METHODS, name, method._replace(set_up=lambda pencil: None))
    body = ao.FEModel.from_mesh(box_mesh(lengths, divisions, kind="hexahedron20"), STEEL)
    assert (body.inverse(1e10, solutions=10).name != "multigrid") == direct


# ---------------------------------------------------------------------------------- dissection


@pytest.mark.parametrize("known", [True, False])
def test_factors_of_a_cube_grow_as_the_fourth_power_of_its_side(known):
    """George 1973; with coordinates or from the graph alone."""
    entries = []
    for n in (10, 20):
        line = sp.diags([1.0, 2.0, 1.0], [-1, 0, 1], shape=(n, n))
        K = sp.csr_array(sp.kron(sp.kronsum(sp.kronsum(line, line), line), np.eye(3)))
        pencil = Pencil(K, sp.eye_array(3 * n**3, format="csr"))
        if known:
            nodes = np.indices((n, n, n)).reshape(3, -1).T.astype(float)
            pencil = replace(pencil, nodes=nodes, free=np.arange(3 * n**3))
        entries.append(pencil.fill.entries)
    assert entries[1] / entries[0] == pytest.approx(2**4, rel=0.15)


# ---------------------------------------------------------------------------------- refusals


def test_an_absent_package_is_named_with_the_way_to_get_it(block, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pymklpardiso", None)
    with pytest.raises(ao.InputError, match=r"^solver"):
        block.inverse(1e12, solver="pardiso")


@pytest.mark.parametrize("solver", DIRECT)
def test_singular_and_indefinite_matrices_are_refused(block, solver):
    with pytest.raises(ao.SingularError, match="stiffness"):
        block.inverse(0.0, solver=solver)
    K = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], shape=(1000, 1000)).tolil()
    K[500, 500] = 0.5
    with pytest.raises(ao.SingularError, match="stiffness"):
        linear_solver(Pencil(sp.csr_array(K), sp.eye_array(1000, format="csr")), solver)


@pytest.mark.parametrize(
    ("answer", "error", "match"),
    [
        (lambda f: f * np.nan, ao.ConvergenceError, r"^solver"),
        (lambda f: f[:-1], ao.InputTypeError, r"^solver"),
        (lambda f: f + 0j, ao.InputTypeError, "complex128"),
        (lambda f: None, ao.InputTypeError, r"^solver"),
        (lambda f: 0.0 * f, ao.ConvergenceError, r"^solver"),
        (lambda f: -f, ao.ConvergenceError, r"^solver"),
    ],
)
def test_a_users_solver_that_fails_is_told_so(bar, answer, error, match):
    def wrong(matrix):
        return answer

    with pytest.raises(error, match=match):
        bar.inverse(1e10, solver=wrong).solve(np.ones(bar.n_dofs))


@needs_pardiso
def test_pardiso_goes_to_another_shift_and_back(bar):
    """One set of factors after the other: whichever solver is asked, its own matrix is solved."""
    dynamic = bar.inverse(1e10, solver="pardiso")
    other = dynamic.at(1e6)
    f = np.random.default_rng(4).standard_normal(bar.n_dofs)
    first = dynamic.solve(f)
    for solver in (other, dynamic, other, other):
        residual = f - (bar.K + solver.s2 * bar.M) @ solver.solve(f)
        assert np.linalg.norm(residual) <= 1e-10 * np.linalg.norm(f)
    np.testing.assert_allclose(dynamic.solve(f), first, rtol=1e-9)


@needs_pardiso
def test_pardiso_takes_rigid_masses_which_couple_hundreds_of_rows():
    """Without supports no translation strains the body: (K + s²M) u = s² M u."""
    mesh = box_mesh((0.04, 0.04, 0.01), (8, 8, 2), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, STEEL, masses=[ao.RigidMass("xmin", 0.5)])
    moved = np.tile([1.0, -2.0, 3.0], mesh.n_nodes)
    found = body.inverse(1e10, solver="pardiso").solve(1e10 * (body.M @ moved))
    assert found == pytest.approx(moved, rel=1e-6)


@needs_pardiso
def test_pardiso_names_a_row_without_a_diagonal():
    """Nothing is stored in such a row, and PARDISO looks there all the same."""
    K = sp.csr_array(np.diag([1.0, 0.0, 2.0]))
    M = sp.csr_array(np.eye(3))
    with pytest.raises(ao.SingularError, match="diagonal"):
        ao.FEModel(K=K, M=M).inverse(0.0, solver="pardiso")


@pytest.mark.parametrize(("name", "least"), [("multigrid", 1e-6), ("superlu", 0.0)])
def test_vectors_of_a_subspace_are_solved_to_a_thousandth_where_that_is_quicker(name, least):
    body = ao.FEModel.from_mesh(box_mesh((0.05, 0.05, 0.02), (5, 5, 2), kind="hexahedron20"), STEEL)
    load = np.random.default_rng(3).standard_normal(body.n_dofs)
    solver = body.inverse(1e10, solver=name)
    x, kx, mx = solver.solve_roughly(load)
    np.testing.assert_array_equal(kx, body.K @ x)
    np.testing.assert_array_equal(mx, body.M @ x)
    left = np.linalg.norm(load - kx - 1e10 * mx) / np.linalg.norm(load)
    assert least <= left <= (1e-3 if least else 1e-10)
    exact = solver.solve(load)
    residual = load - body.K @ exact - 1e10 * (body.M @ exact)
    assert np.linalg.norm(residual) <= 1e-10 * np.linalg.norm(load)


# ------------------------------------------------------------------ where iterations do not arrive


def slow_plate():
    """A plate of 20:20:1 elements, for which iterations are slow."""
    mesh = box_mesh((0.1, 0.1, 0.0005), (10, 10, 1), kind="hexahedron20")
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])


def test_iterations_end_once_they_have_taken_as_long_as_factors():
    plate = slow_plate()
    load = np.random.default_rng(0).standard_normal(plate.n_dofs)
    expected = plate.inverse(1e6, solver="superlu").solve(load)
    usual = plate.inverse(1e6, solver="multigrid")
    usual.most = 20.0
    x = usual.solve(load)
    assert usual.name in METHODS
    assert usual.name != "multigrid"
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    assert np.isfinite(usual.solve(np.stack([load, load], axis=1))).all()
