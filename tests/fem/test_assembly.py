"""Stiffness and mass of every kind of element, on elements as crooked as they come.

The patch test and the rigid motions hold exactly only if shape functions, order of nodes,
quadrature and the places in the matrix are all right.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import scipy.linalg as la
import scipy.sparse as sp
import skfem
from bodies import distorted_box, interior, no_solid, rigid_motions
from rows import each
from skfem.helpers import ddot, dot, eye, sym_grad, trace

from aoimpact import Material, Mesh, box_mesh, read_mesh
from aoimpact.fem import stiffness_mass
from aoimpact.mesh import KINDS

FloatArray = npt.NDArray[np.float64]

MATERIAL = Material(E=70e9, nu=0.33, rho=2700.0)
MESHES = Path(__file__).parents[1] / "meshes"
LENGTHS = (2.0, 1.5, 1.0)
FILES = [
    "hexahedron.inp",
    "hexahedron20_v4.msh",
    "hexahedron27_v2.msh",
    "tetra10_v4.msh",
    "wedge_v2.msh",
]


def curved_file(name: str) -> Mesh:
    """A mesh numbered by Gmsh, its inner nodes moved by a smooth map that keeps the faces."""
    mesh = read_mesh(MESHES / name)
    x, y, z = (mesh.nodes / LENGTHS).T
    bulge = np.sin(np.pi * x) * np.sin(np.pi * y) * np.sin(np.pi * z)
    moved = mesh.nodes + np.outer(bulge, [0.2, -0.15, 0.1])
    names = [f"{c}{side}" for c in "xyz" for side in ("min", "max")]
    faces = [np.flatnonzero(np.abs(c - s) < 1e-9) for c in (x, y, z) for s in (0.0, 1.0)]
    return Mesh(moved, mesh.cells, mesh.kind, dict(zip(names, faces, strict=True)))


BODIES = [*((distorted_box, kind) for kind in KINDS), *((curved_file, name) for name in FILES)]
every_body = each("mesh", [make(name) for make, name in BODIES])


def elastic_energy(gradient: FloatArray, material: Material) -> float:
    """λ/2 (tr ε)² + μ ε:ε, J/m³."""
    lam, mu = material.lame
    strain = 0.5 * (gradient + gradient.T)
    return 0.5 * lam * float(np.trace(strain)) ** 2 + mu * float((strain**2).sum())


@every_body
def test_patch_constant_strain_is_in_equilibrium_and_has_its_energy(mesh: Mesh) -> None:
    K, _ = stiffness_mass(mesh, MATERIAL)
    gradient = np.random.default_rng(1).standard_normal((3, 3))
    u = (mesh.nodes @ gradient.T + [0.1, 0.2, 0.3]).reshape(-1)
    forces = (K @ u).reshape(-1, 3)
    rounding = (abs(K) @ np.abs(u)).max()
    assert np.abs(forces[interior(mesh)]).max() < 1e-14 * rounding
    volume = math.prod(LENGTHS)
    assert 0.5 * u @ (K @ u) == pytest.approx(
        volume * elastic_energy(gradient, MATERIAL), rel=1e-12
    )


@every_body
def test_rigid_motions_cost_no_force(mesh: Mesh) -> None:
    K, _ = stiffness_mass(mesh, MATERIAL)
    motions = rigid_motions(mesh.nodes)
    assert np.abs(K @ motions).max() < 1e-14 * (abs(K) @ np.abs(motions)).max()
    omega2 = la.eigvalsh(K.toarray())
    assert (omega2[:6] < 1e-12 * omega2[-1]).all()
    assert omega2[6] > 1e-5 * omega2[-1]  # and nothing else is free: no hourglass modes


@every_body
def test_mass_and_inertia_are_those_of_the_solid_box(mesh: Mesh) -> None:
    _, M = stiffness_mass(mesh, MATERIAL)
    motions = rigid_motions(mesh.nodes)
    mass = MATERIAL.rho * math.prod(LENGTHS)
    centre = np.array(LENGTHS) / 2.0
    second = np.outer(centre, centre) + np.diag(np.square(LENGTHS)) / 12.0
    exact = np.zeros((6, 6))
    exact[:3, :3] = mass * np.eye(3)
    exact[:3, 3:] = mass * np.cross(np.eye(3), centre).T
    exact[3:, :3] = exact[:3, 3:].T
    exact[3:, 3:] = mass * (np.trace(second) * np.eye(3) - second)
    assert motions.T @ (M @ motions) == pytest.approx(exact, rel=1e-12, abs=1e-12 * mass)


@every_body
def test_matrices_are_exactly_symmetric_and_sorted(mesh: Mesh) -> None:
    for matrix in stiffness_mass(mesh, MATERIAL):
        assert (matrix != matrix.T).nnz == 0
        assert matrix.format == "csr"
        assert matrix.indices.dtype == matrix.indptr.dtype == np.int32
        row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)).astype(np.int64)
        assert (np.diff(row * matrix.shape[0] + matrix.indices) > 0).all()


def test_matrices_are_those_of_scikit_fem_s_vector_form() -> None:
    mesh = box_mesh((1.0, 0.7, 0.4), (2, 1, 2), kind="tetra10")
    corners = mesh.cells[:, :4]
    used, number = np.unique(corners, return_inverse=True)
    other = skfem.MeshTet(mesh.nodes[used].T, number.reshape(corners.shape).T)
    basis = skfem.Basis(other, skfem.ElementVector(skfem.ElementTetP2()), intorder=4)
    lam, mu = MATERIAL.lame

    @skfem.BilinearForm
    def stiffness(u, v, _):  # type: ignore[no-untyped-def]
        strain = sym_grad(u)
        stress = lam * eye(trace(strain), 3) + 2.0 * mu * strain
        return ddot(stress, sym_grad(v))

    @skfem.BilinearForm
    def mass(u, v, _):  # type: ignore[no-untyped-def]
        return MATERIAL.rho * dot(u, v)

    # The two number their dofs differently, so what is compared is each matrix's spectrum.
    for ours, form in zip(stiffness_mass(mesh, MATERIAL), (stiffness, mass), strict=True):
        theirs = form.assemble(basis).toarray()
        scale = la.norm(theirs, 2)
        assert la.eigvalsh(ours.toarray()) == pytest.approx(
            la.eigvalsh(theirs), rel=1e-10, abs=1e-13 * scale
        )


def bar_frequency(kind: str, n: int, twisted: bool = False) -> float:
    """First ω of a bar of `n` layers held at x = 0, moving along x only; L = c = 1, ν = 0."""
    mesh = box_mesh((1.0, 0.5, 0.5), (n, max(1, n // 2), max(1, n // 2)), kind=kind)
    if twisted:
        x, y, z = mesh.nodes.T
        wave = 0.06 * np.sin(np.pi * x) * np.sin(2 * np.pi * y) * np.sin(2 * np.pi * z)
        mesh = Mesh(mesh.nodes + wave[:, None], mesh.cells, kind, mesh.node_sets)
    K, M = stiffness_mass(mesh, no_solid(nu=0.0))
    free = 3 * np.setdiff1d(np.arange(mesh.n_nodes), mesh.node_sets["xmin"])
    K, M = (sp.csc_array(A[free][:, free]) for A in (K, M))
    value = sp.linalg.eigsh(K, k=1, M=M, sigma=0.0, return_eigenvectors=False)
    return float(np.sqrt(value[0]))


# Twice the order of the kind, and the divisions between which it shows.
ORDERS = {
    "tetra": (2, (4, 8)),
    "hexahedron": (2, (4, 8)),
    "wedge": (2, (4, 8)),
    "wedge15": (4, (2, 4)),
    "pyramid": (2, (4, 8)),
    "pyramid13": (4, (2, 4)),
    "tetra10": (4, (4, 8)),
    "hexahedron20": (4, (2, 4)),
    "hexahedron27": (4, (2, 4)),
}


@each("kind", KINDS)
def test_frequencies_converge_with_twice_the_order_of_the_element(kind: str) -> None:
    order, sizes = ORDERS[kind]
    errors = [bar_frequency(kind, n) - math.pi / 2.0 for n in sizes]
    assert errors[1] > 0.0  # from above, as Rayleigh says
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


@pytest.mark.slow
@each("kind", ["hexahedron27", "tetra10"])
def test_curved_elements_keep_the_order(kind: str) -> None:
    errors = [bar_frequency(kind, n, twisted=True) - math.pi / 2.0 for n in (8, 12)]
    assert errors[1] > 0.0
    assert math.log(errors[0] / errors[1], 1.5) > 3.6
