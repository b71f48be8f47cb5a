"""Static modes by the factors of K + s²M: K⁻¹ b, and nothing of K factorised at full size."""

from functools import cache

import meshio
import numpy as np
import pytest
import scipy.sparse.linalg

import aoimpact as ao
from aoimpact.fem import fromdynamic
from aoimpact.fem.fromdynamic import static_by_dynamic
from aoimpact.linalg import pardiso
from aoimpact.linalg.solvers import solutions_worth
from aoimpact.mesh.generate import box_mesh

from slender import rod

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
needs_pardiso = pytest.mark.skipif(not pardiso.is_installed(), reason="py-mkl-pardiso is not there")

ENDS = [("xmin", "xyz"), ("xmax", "xyz")]


@cache
def struck(size, divisions, kind):
    body = ao.FEModel.from_mesh(box_mesh(size, divisions, kind=kind), STEEL, fixed=ENDS)
    middle = (size[0] / 2, size[1] / 2, size[2])
    return body.contact(point=middle, direction=(0, 0, -1))


def by_dynamic(tip, contact_time):
    return static_by_dynamic(tip.body, tip.b, tip.body.inverse((10 / contact_time) ** 2))


def energy(tip, x):
    return x @ (tip.body.K @ x)


SCENES = {
    "block": ((0.02, 0.02, 0.02), (4, 4, 4), "hexahedron20", 1e-5),
    "bar": ((0.5, 0.02, 0.02), (40, 2, 2), "hexahedron20", 9e-5),
    "bar of tetrahedra": ((0.3, 0.02, 0.02), (30, 2, 2), "tetra10", 9e-5),
    "plate": ((0.2, 0.2, 0.01), (12, 12, 2), "hexahedron20", 9e-5),
}


@pytest.mark.parametrize("name", SCENES)
def test_it_is_the_displacement_under_a_steady_force(name):
    *mesh, contact_time = SCENES[name]
    tip = struck(*mesh)
    x = by_dynamic(tip, contact_time)
    exact = scipy.sparse.linalg.spsolve(tip.body.K.tocsc(), tip.b)
    assert x is not None
    assert energy(tip, x - exact) <= 1e-9 * energy(tip, exact)
    np.testing.assert_allclose(x, exact, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("name", SCENES)
def test_fitted_oscillators_take_one_factorisation_of_full_size(name, own_solver):
    """However slender the body: k0 is right, and the solutions are worth less than another one."""
    *mesh, contact_time = SCENES[name]
    tip = struck(*mesh)
    settings = {"method": "krylov", "contact_time": contact_time}
    star = ao.antioscillators(tip, 4, **settings, solver=own_solver)
    assert own_solver.calls == [tip.body.n_dofs]
    assert own_solver.solutions <= 4 + 0.5 * solutions_worth(tip.body.inverse(1.0))
    assert star.k0 == pytest.approx(ao.antioscillators(tip, 0).k0, rel=1e-8)


@needs_pardiso
@pytest.mark.parametrize(("name", "again"), [("bar", False), ("thin plate", True)])
def test_pardiso_factorises_k_only_where_elements_are_long_for_the_thickness(
    name, again, monkeypatch
):
    """Linear elements much longer than a plate is thick do not bend as it does."""
    thin_plate = (0.3, 0.3, 0.005), (12, 12, 1), "hexahedron20", 9e-5
    *mesh, contact_time = SCENES.get(name, thin_plate)
    tip = struck(*mesh)
    others = []
    replace = pardiso.Factors.replace
    monkeypatch.setattr(
        pardiso.Factors, "replace", lambda *a, **k: others.append(a) or replace(*a, **k)
    )
    settings = {"method": "krylov", "contact_time": contact_time, "solver": "pardiso"}
    star = ao.antioscillators(tip, 4, **settings)
    assert bool(others) == again
    assert star.k0 == pytest.approx(ao.antioscillators(tip, 0).k0, rel=1e-8)


def joined_along_an_edge(bar, piece, at):
    """Two meshes as one, the second moved to `at`: it may swing about the edge that they share."""
    nodes = np.vstack([bar.nodes, piece.nodes + at])
    _, first, number = np.unique(nodes.round(9), axis=0, return_index=True, return_inverse=True)
    cells = np.vstack([bar.cells, piece.cells + len(bar.nodes)])
    return meshio.Mesh(nodes[first], [("hexahedron20", number.ravel()[cells])])


@pytest.mark.parametrize("solver", ["superlu", pytest.param("pardiso", marks=needs_pardiso)])
def test_a_mechanism_that_the_force_does_not_move_is_named(solver):
    """The static mode could be had; what the factors of K would say is said of the corners'."""
    bar = box_mesh((0.5, 0.02, 0.02), (40, 2, 2), kind="hexahedron20")
    piece = box_mesh((0.025, 0.02, 0.02), (2, 2, 2), kind="hexahedron20")
    mesh = joined_along_an_edge(bar, piece, (0.25, 0.02, 0.02))
    held = [(lambda x: x[:, 0] < 1e-6, "xyz"), (lambda x: x[:, 0] > 0.5 - 1e-6, "xyz")]
    tip = ao.FEModel.from_mesh(mesh, STEEL, fixed=held).contact(
        point=(0.125, 0.01, 0.02), direction=(0, 0, -1)
    )
    with pytest.raises(ao.SingularError, match="mechanism"):
        ao.antioscillators(tip, 6, method="krylov", contact_time=9e-5, solver=solver)


def test_a_long_rod_without_a_mesh_is_left_to_a_factorisation_of_k():
    """A blow passes over a hundredth of it: too many motions are slower for the steps allowed."""
    K, M = rod(2000, fixed=[0])
    tip = ao.FEModel(K=K, M=M).contact(dof=1999)
    assert by_dynamic(tip, 0.01) is None
    star = ao.antioscillators(tip, 3, method="krylov", contact_time=0.01)
    assert star.k0 == pytest.approx(1.0, rel=1e-9)  # EA/L


def test_the_more_a_factorisation_costs_the_more_steps_it_is_worth():
    """A cube's factors grow with its dofs, a bar's only with its cross-section."""

    def worth(*mesh):
        return solutions_worth(struck(*mesh, "tetra10").body.inverse(1e10, solver="superlu"))

    cubes = [worth((0.02, 0.02, 0.02), (n, n, n)) for n in (2, 4, 6)]
    assert cubes == sorted(cubes)
    bars = [worth((0.02 * n, 0.02, 0.02), (2 * n, 2, 2)) for n in (10, 20)]
    assert bars[1] == pytest.approx(bars[0], rel=0.1)


def test_a_search_that_meets_no_stiffness_gives_up():
    """K with a motion of no stiffness that b excites: nothing is returned, nothing loops."""
    K, _ = rod(20, fixed=[0])
    soft = K.tolil()
    soft[:, 19] = 0.0
    soft[19, :] = 0.0
    search = fromdynamic._Search(soft.tocsr(), np.eye(20)[19], lambda r: r)
    search.run(5)
    assert not search.done
