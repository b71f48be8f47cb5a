"""Linear solvers: one answer from all of them, and a clear word where there is none."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import aoimpact as ao
from aoimpact import box_mesh, sphere_mesh
from aoimpact.base import memory
from aoimpact.linalg import (
    METHODS,
    SOLVERS,
    LinearSolver,
    Pencil,
    factorize,
    linear_solver,
    pardiso,
    solvers,
)
from aoimpact.linalg.dissection import fill, nested_dissection

ROOT = Path(__file__).parents[2]
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)

needs_pardiso = pytest.mark.skipif(not pardiso.is_installed(), reason="py-mkl-pardiso is not there")


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


@pytest.fixture(scope="module")
def factorised(block, bar):
    """Points of contact, and their stars by SuperLU."""
    tips = [
        body.contact(point=point, direction=(1, 0, 0), radius=0)
        for body, point in ((block, (0, 0.01, 0.01)), (bar, (0.3, 0, 0)))
    ]
    return [(t, ao.antioscillators(t, 3, order="frequency", solver="superlu")) for t in tips]


@pytest.mark.parametrize(
    "solver", [*DIRECT, pytest.param("multigrid", marks=pytest.mark.slow), EVERY[-1]]
)
def test_anti_oscillators_do_not_depend_on_the_solver_and_name_it(factorised, solver):
    for tip, reference in factorised:
        assert reference.origin.linear_solver == "superlu"
        star = ao.antioscillators(tip, 3, order="frequency", solver=solver)
        np.testing.assert_allclose(star.m, reference.m, rtol=1e-7)
        np.testing.assert_allclose(star.k, reference.k, rtol=1e-7)
        assert star.origin.linear_solver == getattr(solver, "__name__", solver)


def test_the_matrices_are_neither_changed_nor_copied(bar):
    before = bar.K.data.copy()
    pencil = Pencil(bar.K, bar.M)
    assert pencil.matrix() is bar.K
    linear_solver(pencil).solve(np.ones(bar.n_dofs))
    np.testing.assert_array_equal(bar.K.data, before)


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
    ("mesh", "solutions", "direct"),
    [
        (((0.5, 0.02, 0.02), (40, 2, 2), "hexahedron20"), 10, True),  # slender
        (((0.02, 0.02, 0.02), (5, 5, 5), "hexahedron20"), 10, True),  # small
        pytest.param(  # one layer of flat elements
            ((0.3, 0.3, 0.001), (60, 60, 1), "hexahedron20"), 10, True, marks=pytest.mark.slow
        ),
        (((0.3, 0.3, 0.3), (12, 12, 12), "hexahedron20"), 10, False),  # compact
        (((0.3, 0.3, 0.3), (12, 12, 12), "hexahedron20"), 10_000, True),
        (((0.3, 0.3, 0.003), (12, 12, 12), "hexahedron20"), 10, True),  # flat elements
        pytest.param(
            ((0.3, 0.3, 0.3), (30, 30, 30), "hexahedron"), 10, False, marks=pytest.mark.slow
        ),
    ],
)
def test_the_quickest_is_taken(mesh, solutions, direct):
    """By estimates from the graph and the shapes of elements; nothing is factorised here."""
    lengths, divisions, kind = mesh
    body = ao.FEModel.from_mesh(box_mesh(lengths, divisions, kind=kind), STEEL)
    taken = solvers._quickest(body._pencil.at(1e10), solutions)
    assert (taken.name != "multigrid") == direct


def test_a_body_of_a_million_dofs_is_left_to_iterations():
    """Where factors take minutes."""
    line = sp.diags([1.0, 2.0, 1.0], [-1, 0, 1], shape=(60, 60))
    K = sp.csr_array(sp.kron(sp.kronsum(sp.kronsum(line, line), line), np.eye(3)))
    nodes = np.indices((60, 60, 60)).reshape(3, -1).T[:, ::-1].astype(float)
    pencil = Pencil(K, sp.eye_array(len(K.indptr) - 1, format="csr"), 0.0, nodes)
    pencil = replace(pencil, free=np.arange(pencil.n))
    assert solvers._quickest(pencil, 10).name == "multigrid"


# ---------------------------------------------------------------------------------- dissection


BOXES = [
    sphere_mesh(0.01, 4e-3),
    box_mesh((1, 1, 1), (6, 6, 6), kind="hexahedron20"),
    box_mesh((1, 0.1, 0.1), (40, 3, 3), kind="tetra10"),
    box_mesh((1, 1, 0.1), (20, 20, 2)),
    box_mesh((1, 1, 0.1), (20, 20, 1), kind="hexahedron20"),
]


@pytest.mark.parametrize(
    "mesh",
    [*(pytest.param(mesh, marks=pytest.mark.slow) for mesh in BOXES[:2]), *BOXES[2:]],
    ids=["ball", "cube", "bar", "plate", "sheet"],
)
def test_the_size_of_the_factors_is_known_before(mesh):
    body = ao.FEModel.from_mesh(mesh, STEEL)
    factors = factorize(body.K + 1e8 * body.M, order=body._pencil.order)
    assert 0.5 <= factors._lu.L.nnz / body._pencil.fill.entries <= 1.1
    by_degree = factorize(body.K + 1e8 * body.M)
    assert factors._lu.L.nnz <= 1.4 * by_degree._lu.L.nnz


def test_a_grid_is_cut_as_by_hand():
    """A square of n x n nodes, in dofs of one: separators of n, then twice n/2, and so on."""
    line = sp.diags([1.0, 2.0, 1.0], [-1, 0, 1], shape=(31, 31))
    grid = sp.csr_array(sp.kronsum(line, line))
    places = np.indices((31, 31)).reshape(2, -1).T.astype(float)
    order = nested_dissection(grid, places)
    assert sorted(order) == list(range(31**2))
    assert len({*places[order[-31:], 0]}) == 1  # the last ones are one line


def test_pieces_that_share_no_entries_are_eliminated_one_after_the_other():
    """Stretching and bending of a flat sheet, whose rows alternate."""
    line = sp.diags([1.0, 2.0, 1.0], [-1, 0, 1], shape=(31, 31))
    grid = sp.csr_array(sp.kron(sp.kronsum(line, line), sp.eye(2)))
    grid.eliminate_zeros()
    places = np.repeat(np.indices((31, 31)).reshape(2, -1).T.astype(float), 2, axis=0)
    piece = nested_dissection(grid, places) % 2
    assert np.count_nonzero(np.diff(piece)) == 1


@pytest.mark.parametrize("known", [True, False])
def test_factors_of_a_cube_grow_as_the_fourth_power_of_its_side(known):
    """George 1973; with coordinates or from the graph alone."""
    entries = []
    for n in (10, 20):
        line = sp.diags([1.0, 2.0, 1.0], [-1, 0, 1], shape=(n, n))
        K = sp.csr_array(sp.kron(sp.kronsum(sp.kronsum(line, line), line), np.eye(3)))
        places = np.repeat(np.indices((n, n, n)).reshape(3, -1).T.astype(float), 3, axis=0)
        entries.append(fill(K, places if known else None).entries)
    assert entries[1] / entries[0] == pytest.approx(2**4, rel=0.15)


# ---------------------------------------------------------------------------------- refusals


def test_what_does_not_fit_into_memory_is_refused_before_it_is_begun(block, monkeypatch):
    monkeypatch.setattr(memory, "available", lambda: 1e6)
    with pytest.raises(MemoryError, match=r"^solver"):
        block.inverse(1e12, solver="superlu")
    monkeypatch.setattr(memory, "available", lambda: 1e3)
    with pytest.raises(ao.AOImpactError, match=r"^solver"):
        block.inverse(1e12, solver="multigrid")


def test_multigrid_is_the_last_resort_where_nothing_fits(block, monkeypatch):
    monkeypatch.setattr(solvers, "available", lambda: 0.0)
    assert block.inverse(1e10).name == "multigrid"


def test_a_solver_of_single_precision_is_refined_to_double(block):
    def single(A):
        inverse = spla.factorized(A.tocsc())
        return lambda f: inverse(f).astype(np.float32)

    f = np.random.default_rng(1).standard_normal(block.n_dofs)
    x = block.inverse(1e12, solver=single).solve(f)
    residual = f - block.K @ x - 1e12 * (block.M @ x)
    assert np.linalg.norm(residual) <= 1e-10 * np.linalg.norm(f)


def test_available_memory_is_between_a_page_and_a_petabyte():
    assert 4096 < memory.available() < 1e15


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
def test_pardiso_names_a_row_without_a_diagonal():
    """Nothing is stored in such a row, and PARDISO looks there all the same."""
    K = sp.csr_array(np.diag([1.0, 0.0, 2.0]))
    M = sp.csr_array(np.eye(3))
    with pytest.raises(ao.SingularError, match="diagonal entry 1, counted from 0, is 0"):
        ao.FEModel(K=K, M=M).inverse(0.0, solver="pardiso")


@needs_pardiso
def test_pardiso_names_a_singular_matrix_in_place_of_a_regular_one(block):
    """The block is free; after the refusal what was regular still is."""
    dynamic = block.inverse(1e10, solver="pardiso")
    f = np.ones(block.n_dofs)
    with pytest.raises(ao.SingularError, match="the stiffness matrix"):
        dynamic.at(0.0).solve(f)
    assert np.isfinite(dynamic.solve(f)).all()


def test_k_plus_s2m_has_the_pattern_of_k():
    """Entries of K that are zero stay where they are: what is known of one pattern serves both."""
    mesh = box_mesh((0.03, 0.02, 0.02), (4, 3, 3), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, STEEL)
    assert (body.K.data == 0.0).any()
    both = Pencil(body.K, body.M, 1e10).matrix()
    np.testing.assert_array_equal(both.indices, body.K.indices)
    np.testing.assert_array_equal(both.indptr, body.K.indptr)
    x = np.random.default_rng(5).standard_normal(body.n_dofs)
    np.testing.assert_allclose(both @ x, body.K @ x + 1e10 * (body.M @ x), rtol=1e-9)


def test_what_is_no_solver_is_refused(bar):
    tip = bar.contact(point=(0.3, 0, 0), direction=(1, 0, 0), radius=0)
    with pytest.raises(ao.InputError, match=r"^solver"):
        ao.antioscillators(tip, 1, solver="pardisso")
    with pytest.raises(ao.InputTypeError, match=r"^solver"):
        ao.antioscillators(tip, 1, solver=3)
    with pytest.raises(ao.InputTypeError, match=r"^solver"):
        bar.inverse(solver=lambda matrix: 1.0)


def test_zero_has_the_solution_zero(bar):
    found = bar.inverse(1e10)
    assert isinstance(found, LinearSolver)
    np.testing.assert_array_equal(found.solve(np.zeros(bar.n_dofs)), np.zeros(bar.n_dofs))


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


@pytest.fixture
def iterating(monkeypatch):
    """Multigrid is chosen where nobody chose a solver."""
    monkeypatch.setattr(solvers, "_quickest", lambda pencil, count: METHODS["multigrid"])


def test_iterations_end_once_they_have_taken_as_long_as_factors(iterating):
    """All solutions count together; a solver that is named stays, and its failure is told."""
    plate = slow_plate()
    load = np.random.default_rng(0).standard_normal(plate.n_dofs)
    expected = plate.inverse(1e6, solver="superlu").solve(load)
    usual = plate.inverse(1e6)
    assert usual.name == "multigrid"
    direct = solvers._direct(usual.pencil)
    factors = direct.seconds(usual.pencil, 0)
    assert 0.0 < usual.most <= factors / METHODS["multigrid"].iteration(usual.pencil)
    usual.most = 20.0
    x = usual.solve(load)
    assert usual.name == direct.name
    assert usual.precondition is None
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    assert np.isfinite(usual.solve(np.stack([load, load], axis=1))).all()


def test_a_solver_that_is_named_stays(monkeypatch):
    plate = slow_plate()
    load = np.random.default_rng(0).standard_normal(plate.n_dofs)
    monkeypatch.setattr("aoimpact.linalg.multigrid._MOST_ITERATIONS", 2)
    with pytest.raises(ao.ConvergenceError, match=r"^solver"):
        plate.inverse(1e6, solver="multigrid").solve(load)


def test_where_factors_do_not_fit_iterations_fail_with_their_own_word(iterating, monkeypatch):
    monkeypatch.setattr(solvers, "available", lambda: 0.0)
    monkeypatch.setattr("aoimpact.linalg.multigrid._MOST_ITERATIONS", 2)
    plate = slow_plate()
    with pytest.raises(ao.ConvergenceError, match=r"^solver"):
        plate.inverse(2e6).solve(np.ones(plate.n_dofs))


def test_factors_take_over_where_iterations_cannot_be_set_up(block, monkeypatch):
    def set_up(pencil):
        raise ao.ConvergenceError("finds no coarser level")

    multigrid = replace(METHODS["multigrid"], set_up=set_up)
    monkeypatch.setattr(solvers, "_quickest", lambda pencil, count: multigrid)
    solver = block.inverse(1e10)
    assert solver.name == solvers._direct(solver.pencil).name


@pytest.mark.slow
def test_frequencies_of_a_sheet_do_not_wait_for_iterations(iterating):
    """Kirchhoff's plate, clamped on one side: 3.494 √(D / ρ h) / 2π a² (Leissa 1969, ν = .3)."""
    mesh = box_mesh((0.3, 0.3, 0.003), (16, 16, 1), kind="hexahedron20")
    sheet = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    bending = 210e9 * 0.003**3 / (12 * (1 - 0.3**2))
    published = 3.494 * np.sqrt(bending / (7800 * 0.003)) / (2 * np.pi * 0.3**2)
    assert sheet.frequencies(3)[0] == pytest.approx(published, rel=0.01)
