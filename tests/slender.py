"""Matrices of rods and Euler-Bernoulli beams, independent of the package."""

import numpy as np
import scipy.sparse as sp


def assemble(element, n_elements, dofs_per_node):
    """Assemble `n_elements` equal element matrices along a line."""
    size = dofs_per_node * (n_elements + 1)
    width = len(element)
    first = dofs_per_node * np.arange(n_elements)
    rows = (first[:, None] + np.repeat(np.arange(width), width)).ravel()
    columns = (first[:, None] + np.tile(np.arange(width), width)).ravel()
    values = np.tile(np.ravel(element), n_elements)
    return sp.csr_matrix((values, (rows, columns)), shape=(size, size))


def rod(n_elements, *, fixed=()):
    """K and M of a rod with EA = L = ρA = 1, linear elements, without the nodes `fixed`."""
    h = 1.0 / n_elements
    K = assemble(np.array([[1, -1], [-1, 1]]) / h, n_elements, 1)
    M = assemble(np.array([[2, 1], [1, 2]]) * h / 6, n_elements, 1)
    return without(K, fixed), without(M, fixed)


def beam(n_elements, *, fixed=()):
    """K and M of a beam with EI = L = ρA = 1, cubic elements, dofs (w, w') per node."""
    h = 1.0 / n_elements
    stiffness = [
        [12, 6 * h, -12, 6 * h],
        [6 * h, 4 * h**2, -6 * h, 2 * h**2],
        [-12, -6 * h, 12, -6 * h],
        [6 * h, 2 * h**2, -6 * h, 4 * h**2],
    ]
    mass = [
        [156, 22 * h, 54, -13 * h],
        [22 * h, 4 * h**2, 13 * h, -3 * h**2],
        [54, 13 * h, 156, -22 * h],
        [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
    ]
    K = assemble(np.array(stiffness) / h**3, n_elements, 2)
    M = assemble(np.array(mass) * h / 420, n_elements, 2)
    return without(K, fixed), without(M, fixed)


def without(matrix, dofs):
    """The matrix without the rows and columns `dofs`."""
    kept = np.setdiff1d(np.arange(matrix.shape[0]), dofs)
    return matrix[kept][:, kept].tocsr()


def joined(K, M, dof, count):
    """K and M of `count` equal bodies that share the dof `dof`, which comes first."""
    n = K.shape[0]
    others, join = np.delete(np.arange(n), dof), sp.lil_matrix((count * n, count * (n - 1) + 1))
    for k in range(count):
        join[k * n + dof, 0] = 1.0
        join[k * n + others, 1 + k * (n - 1) + np.arange(n - 1)] = 1.0
    return tuple((join.T @ in_a_row(*[of] * count) @ join).tocsr() for of in (K, M))


def in_a_row(*matrices):
    """Block-diagonal matrix of separate bodies."""
    return sp.block_diag(matrices, format="csr")
