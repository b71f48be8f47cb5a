"""
Bodies of several materials, masses and springs
===============================================

A body may consist of several materials, isotropic or orthotropic as the plies of a laminate; carry added masses; and
stand on springs. All of these are arguments of :meth:`aoimpact.FEModel.from_mesh`.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)

# %%
# Several materials
# -----------------
# The mesh names groups of elements, and ``material`` is a mapping from these names to materials. In gmsh a group is a
# *physical group* of volumes, in Abaqus an element set; ``ao.read_mesh`` takes both over. Every element belongs to exactly
# one of the groups that are named. Here the groups of a sandwich, a steel core with aluminium skins, are made from the
# elements' centres:

length, width, thickness = 0.3, 0.02, 0.012
box = ao.box_mesh((length, width, thickness), (30, 2, 6), kind="hexahedron20")
height = box.nodes[box.cells, 2].mean(axis=1)
inside = np.abs(height - thickness / 2) < thickness / 6
groups = {"core": np.flatnonzero(inside), "skin": np.flatnonzero(~inside)}
mesh = ao.Mesh(box.nodes, box.cells, box.kind, box.node_sets, groups)

sandwich = ao.FEModel.from_mesh(
    mesh, {"core": steel, "skin": aluminium}, fixed=[("xmin", "xyz")], name="sandwich"
)
print(sandwich)

# %%
# The first frequency of bending in the plane of the thickness, in closed form: the bending stiffnesses of the layers add
# up (Euler–Bernoulli).

core = width * (thickness / 3) ** 3 / 12
skins = width * thickness**3 / 12 - core
bending = steel.E * core + aluminium.E * skins
line_mass = width * thickness * (steel.rho + 2 * aluminium.rho) / 3
closed_form = 1.8751**2 / (2 * np.pi * length**2) * np.sqrt(bending / line_mass)
print(f"first frequency {sandwich.frequencies(1)[0]:.1f} Hz, closed form {closed_form:.1f} Hz")
assert abs(sandwich.frequencies(1)[0] / closed_form - 1) < 0.01

# %%
# Stress, and its error, is averaged at the nodes of each material separately, never across an interface.
#
# A laminate
# ----------
# A ply is an :class:`aoimpact.Orthotropic` material: three moduli, three shear moduli and three Poisson's ratios in Abaqus'
# order, and the directions of its axes. ``turned`` gives the same ply at another angle about its third axis.

ply = ao.Orthotropic(
    E=(135e9, 9e9, 9e9), G=(5e9, 5e9, 3.2e9), nu=(0.3, 0.3, 0.4), rho=1550
)  # carbon fibres along x in epoxy
angles = (0, 90, 90, 0)  # degrees, from below
box = ao.box_mesh((0.1, 0.08, 0.004), (20, 16, len(angles)), kind="hexahedron20")
layer = np.floor(box.nodes[box.cells, 2].mean(axis=1) / 0.004 * len(angles)).astype(int)
plies = {f"ply {i}": np.flatnonzero(layer == i) for i in range(len(angles))}
laminate = ao.FEModel.from_mesh(
    ao.Mesh(box.nodes, box.cells, box.kind, box.node_sets, plies),
    {f"ply {i}": ply.turned(np.radians(angle)) for i, angle in enumerate(angles)},
    fixed=[("xmin", "xyz"), ("xmax", "xyz")],
    name="laminate",
)
hit = ao.simulate(
    projectile=ao.ball(0.008, steel),
    target=laminate.contact(point=(0.05, 0.04, 0.004)),
    velocity=1.0,
)
print(hit)
image = plt.figure(figsize=(9.6, 7.2)).figimage(hit.target.field().plot().screenshot())

# %%
# Hertz's law takes for E* what the deflection of an orthotropic half-space gives under a round contact. There is no
# delamination and no other damage: a stress tells where either would begin.
#
# Added masses and springs
# ------------------------
# ``masses`` are pairs of nodes and kilograms: the mass is shared by the nodes. ``springs`` to the ground are nodes,
# directions and the stiffness of all of these nodes together. Nodes are given as for ``fixed``. A plate of 0.97 kg with a
# device of 1.5 kg on its edge, on four rubber mounts of 50 kN/m each:

mesh = ao.box_mesh((0.3, 0.2, 0.006), (15, 10, 1), kind="hexahedron20")


def corners(nodes):
    x, y, z = nodes.T
    return np.isin(x, (0, x.max())) & np.isin(y, (0, y.max())) & (z == 0)


mounted = ao.FEModel.from_mesh(
    mesh, aluminium, masses=[("ymax", 1.5)], springs=[(corners, "xyz", 4 * 50e3)], name="plate"
)
print(mounted)

# %%
# On its soft mounts the plate moves nearly as a rigid body. Without rotation, its frequency would be:

print(mounted.frequencies(6), "Hz")
print(
    f"{np.sqrt(4 * 50e3 / mounted.mass) / (2 * np.pi):.1f} Hz for a rigid body that does not rotate"
)

# %%
# An impact of a tenth of a millisecond is over long before the mounts or the device respond: the force is that on the
# free plate.

free = ao.FEModel.from_mesh(mesh, aluminium, name="free plate")
for plate in (mounted, free):
    hit = ao.simulate(
        projectile=ao.ball(0.01, steel),
        target=plate.contact(point=(0.15, 0.1, 0.006)),
        velocity=1.0,
    )
    print(f"{plate.name:11s} {hit.peak_force:.1f} N, {1e6 * hit.contact_duration:.1f} µs")

# %%
# A rigid part
# ------------
# A :class:`aoimpact.RigidMass` also has a centre and moments of inertia. It moves with its nodes on average and does not
# stiffen them. Here it is the carriage of a drop tower, 5 kg, behind a steel nose of which 40 mm are meshed:

mesh = ao.box_mesh((0.02, 0.02, 0.04), (4, 4, 8), kind="hexahedron20")
carriage = ao.RigidMass("zmax", 5.0, centre=(0.01, 0.01, 0.1), inertia=(4e-3, 4e-3, 2e-3))
tup = ao.FEModel.from_mesh(mesh, steel, masses=[carriage], name="tup")

# %%
# On a spring that is far softer than the nose, the contact lasts π √(m/k). (The nose is flat, so that the law has to be
# given; a meshed round nose has Hertz's from its curvature.)

k = 1e6
hit = ao.simulate(
    projectile=tup.contact(point=(0.01, 0.01, 0.0), radius=0),
    target=ao.rigid(mass=float("inf")),
    law=ao.Linear(k=k),
    velocity=2.0,
)
closed_form = np.pi * np.sqrt(tup.mass / k)
print(f"{1e3 * hit.contact_duration:.3f} ms, closed form {1e3 * closed_form:.3f} ms")
assert abs(hit.contact_duration / closed_form - 1) < 0.01

# %%
# What is not there: a spring or a dashpot between two bodies, and a dashpot at one place. Bodies that stay joined, by a
# weld, an adhesive or a bolt that does not open, are one body: mesh them together, or give K and M
# (:doc:`/how-to/own_matrices`).
