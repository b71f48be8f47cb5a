"""
My own K and M
==============

Stiffness and mass may come from any program that writes them: sparse or dense, symmetric, with the supports taken out.
What the package then needs to know is where the body is touched.

The files of Abaqus, Ansys, CalculiX and Nastran, and
Matrix Market's and SciPy's, are read by :func:`aoimpact.read_matrices`, with the labels of the nodes
(:doc:`/how-to/other_programs`).
"""

import numpy as np
import scipy.sparse as sp

import aoimpact as ao

# %%
# By a degree of freedom
# ----------------------
# Without coordinates a contact is one degree of freedom, ``dof=``. Here K and M are those of a steel beam of
# Euler–Bernoulli elements, hinged at both ends: a deflection and a rotation for each node.

E, rho, length, width, height, n = 210e9, 7800.0, 1.0, 0.05, 0.02, 60
EI, line_mass, h = E * width * height**3 / 12, rho * width * height, length / n
k = (
    EI
    / h**3
    * np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    )
)
m = (
    line_mass
    * h
    / 420
    * np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    )
)
K = sp.lil_array((2 * n + 2, 2 * n + 2))
M = sp.lil_array((2 * n + 2, 2 * n + 2))
for i in range(n):
    dofs = np.arange(2 * i, 2 * i + 4)
    K[np.ix_(dofs, dofs)] += k
    M[np.ix_(dofs, dofs)] += m
free = np.setdiff1d(np.arange(2 * n + 2), [0, 2 * n])  # both ends hinged

beam = ao.FEModel(K=K.tocsr()[free][:, free], M=M.tocsr()[free][:, free], name="beam")
print(beam.frequencies(3), "Hz")
print(np.pi / 2 * np.sqrt(EI / line_mass) * np.array([1, 4, 9]), "Hz, closed form")

# %%
# The middle node's deflection is row ``n`` of all, and one row less since the first was taken out. A contact without
# coordinates has no surface, so that the contact law has to be given.

middle = beam.contact(dof=n - 1)
hit = ao.simulate(
    projectile=ao.rigid(mass=0.5, name="hammer"),
    target=middle,
    law=ao.Hertz(k=1e9),
    velocity=0.5,
    duration=5e-3,
)
print(hit)
hit.plot_force()

# %%
# With coordinates
# ----------------
# Where each node has three translations, ``nodes=`` gives their coordinates, and ``free=`` gives, for each row of K, the
# index 3·node + component. Then a contact may be given by a ``point`` and a ``direction``, and the body has a mass and
# a centre. Without elements there is no surface to spread a patch on, so that the contact is the single node there, and the
# law is taken as it is. The matrices of this example are taken from a mesh, as another program would have made them.

mesh = ao.box_mesh((0.4, 0.02, 0.02), (16, 2, 2), kind="hexahedron20")
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
made = ao.FEModel.from_mesh(mesh, aluminium, fixed=[("xmin", "xyz")])

block = ao.FEModel(K=made.K, M=made.M, nodes=made.nodes, free=made.free, name="cantilever")
tip = block.contact(point=(0.4, 0.01, 0.02), direction=(0, 0, -1))
hit = ao.simulate(
    projectile=ao.rigid(mass=0.02), target=tip, law=ao.Hertz(k=1e8), velocity=1.0, duration=4e-3
)
print(f"{hit.peak_force:.1f} N, {len(hit.contacts)} contacts, restitution {hit.restitution:.3f}")

# %%
# Any functional
# --------------
# A contact is a vector b: the force acts as b F on the degrees of freedom, and the contact moves by u = bᵀX. One
# degree of freedom is the unit vector; a rigid disc, a pressure or a sensor that averages is another vector. It is
# given by ``b=``.

b = np.zeros(beam.K.shape[0])
b[[n - 5, n - 1, n + 3]] = 0.25, 0.5, 0.25  # deflections of three nodes
pad = beam.contact(b=b)
wide = ao.simulate(
    projectile=ao.rigid(mass=0.5), target=pad, law=ao.Hertz(k=1e9), velocity=0.5, duration=5e-3
)
print(f"{wide.peak_force:.1f} N")

# %%
# Surface and stress
# ------------------
# With the mesh that the matrices are of, ``body.with_mesh(mesh, material)`` gives them a surface: patches, Hertz's law, the
# compliance that is taken out of it and stresses are then known as of a body that was made from a mesh.

meshed = block.with_mesh(mesh, aluminium)
print(meshed.contact(point=(0.4, 0.01, 0.02 / 2)))

# %%
# A wrong matrix is refused when the body is made, and ``body.audit()`` shows what wrong units look like:

print(meshed.audit(frequencies=2))

try:
    ao.FEModel(K=np.array([[2.0, -1.0], [-1.1, 1.0]]), M=np.eye(2))
except ao.InputError as error:
    print(error)
