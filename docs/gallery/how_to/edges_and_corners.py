"""
Edges and corners
=================

A mesh has sharp edges. A real edge has a radius, often of some tenths of a millimetre, and the contact law needs it. The example
is a steel ball that falls on the edge of a steel block.
"""

import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
mesh = ao.box_mesh((0.04, 0.04, 0.04), (4, 4, 4), kind="hexahedron20")
block = ao.FEModel.from_mesh(mesh, steel, name="block")
ball = ao.ball(radius=0.01, material=steel)

# %%
# The law has the radius
# ----------------------
# An edge with a radius of 3 mm is a cylinder: a principal radius of 3 mm, and none along the edge. A corner is a sphere, with a
# single radius.

law = ao.Hertz.between(steel, 0.01, steel, (0.003, np.inf))

# %%
# The block as a rigid body
# -------------------------
# A compact block hardly vibrates in so short an impact. It is a rigid mass, and it does not turn here, since the ball's direction
# passes through its centre. For two rigid masses m and M the peak force is known: with 1/μ = 1/m + 1/M the energy μv²/2 is that of
# the indentation, 2kδ^(5/2)/5, and the force is kδ^(3/2).

mu = 1 / (1 / ball.mass + 1 / block.mass)
peak = law.k * (5 * mu / (4 * law.k)) ** 0.6
rigid = ao.simulate(projectile=ball, target=ao.rigid(mass=block.mass), velocity=1, law=law)
print(f"{rigid.peak_force:.1f} N, closed form {peak:.1f} N")

# %%
# The block with its elasticity
# -----------------------------
# ``direction`` is the ball's direction of travel, since an edge has no normal. ``radius=0`` is the point itself: no patch fits on
# an edge. The compliance of the mesh under the point is not taken out of the law there, and it is in the force twice. So the force
# is too small, and smaller on finer meshes; the error says "contact not known".

for n in (4, 8):
    finer = ao.box_mesh((0.04, 0.04, 0.04), (n, n, n), kind="hexahedron20")
    body, place = ao.FEModel.from_mesh(finer, steel), (0.04, 0.04, 0.02)
    edge = body.contact(point=place, direction=(-1, -1, 0), radius=0)
    sharp = ao.simulate(projectile=ball, target=edge, velocity=1, law=law)
    print(f"{n} elements on an edge: {sharp.peak_force:.1f} N, {sharp.peak_force / peak - 1:+.1%}")

# %%
# Where vibration matters, as on a thin plate or a long beam, mesh the round itself and touch it as any
# other surface: the law then finds the curvature, and the compliance of the mesh is taken out of it
# (:doc:`/how-to/contact_and_mesh`).
