"""
Contact that does not depend on the mesh
========================================

Under a point load an elastic solid deforms without bound, and a finer mesh shows more of it. Hertz's law contains that
indentation already. So the common recipe, finite elements and Hertz's spring at one node, counts it twice, and the
computed force depends on the mesh. The cure is a *patch*, which the package takes unless ``radius=0`` is given.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
law = ao.Hertz.between(steel, 0.01, steel, 0.01)
meshes = [ao.sphere_mesh(0.01, 0.008), ao.paper_sphere_mesh(), ao.sphere_mesh(0.01, 0.005)]
balls = [ao.FEModel.from_mesh(mesh, steel) for mesh in meshes]


def meet(ball, radius):
    """Two like spheres at 1 m/s, each by one anti-oscillator."""
    tip = ball.contact(point=(0.01, 0, 0), radius=radius)
    sphere = ao.antioscillators(tip, n=1)
    return ao.simulate(projectile=sphere, target=sphere, law=law, velocity=1.0, duration=100e-6)


# %%
# One node
# --------
# Two steel spheres on three meshes. The package warns of each contact at a node under a law like Hertz's:

one_node = [meet(balls[0], radius=0.0)]

# %%
# The finer the mesh, the lower the force; nothing converges.

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    one_node += [meet(ball, radius=0.0) for ball in balls[1:]]
for mesh, hit in zip(meshes, one_node):
    print(f"{mesh.n_nodes:5d} nodes: {hit.peak_force:7.1f} N, {1e6 * hit.contact_duration:.2f} µs")

# %%
# A patch
# -------
# ``radius=`` spreads the contact over a disc of the surface with Hertz's pressure, p ∝ √(1 - ρ²/r²). The weights that
# spread the force also give the displacement that is conjugate to it. They sum to one, and their centre is the point:

tip = balls[1].contact(point=(0.01, 0, 0), radius=0.0045)
print(tip)
print("resultant", tip.resultant, " moment", tip.moment)

# %%
# The surface of an elastic half-space sinks by 0.6/(r E*) per force under such a patch. That part is in the finite
# elements and in the law; `simulate` takes it out of the law. What remains of the body's compliance hardly depends on r
# any more, nor on the mesh:

print(ao.check_patch(tip))

# %%

patches = [meet(ball, radius=0.0045) for ball in balls]
for mesh, hit in zip(meshes, patches):
    print(f"{mesh.n_nodes:5d} nodes: {hit.peak_force:7.1f} N, {1e6 * hit.contact_duration:.2f} µs")

# %%
# What is right
# -------------
# Fine axisymmetric finite elements with unilateral contact and no law at all give 1014.7 N and 59.41 µs for these spheres
# (:doc:`/validation/two_spheres`).

rigid = ao.simulate(
    projectile=ao.ball(0.01, steel), target=ao.ball(0.01, steel), velocity=1.0, duration=100e-6
)
times = np.linspace(0, 100e-6, 500)
_, ax = plt.subplots(layout="constrained")
for hit, label, style in (
    (patches[1], "patch", "-"),
    (one_node[1], "one node", "--"),
    (rigid, "rigid masses", ":"),
):
    ax.plot(1e6 * times, hit.at(times).force, style, label=label)
    print(f"{label:13s} {hit.peak_force:7.1f} N  {100 * (hit.peak_force / 1014.7 - 1):+6.1f} %")
ax.axhline(1014.7, color="0.4", lw=0.8)
ax.annotate("resolved", (79, 1014.7), ha="right", va="bottom")
ax.set(xlabel="time (µs)", ylabel="force (N)", xlim=(0, 80), ylim=(0, 1150))
ax.legend()

# %%
# How large a patch?
# ------------------
# Wider than the contact itself, small against the body, and resolved by the mesh: quadratic elements about as large as
# the radius will do, linear ones a third of it. If no radius is given, `simulate` takes the one for which the errors of
# mesh and half-space together are least; ``hit.error.mesh`` and ``hit.error.contact`` are those errors.
#
# A contact that grows too wide for its patch, between two patches beyond 0.79 of their radius, is an error that names the
# radius to take. It takes a velocity far above those that this package is for:

sphere = ao.antioscillators(balls[1].contact(point=(0.01, 0, 0), radius=0.003), n=1)
try:
    ao.simulate(projectile=sphere, target=sphere, law=law, velocity=200.0, duration=50e-6)
except ao.AOImpactError as error:
    print(error)

# %%
# Under strongly damped laws the force still depends a little on r, since the half-space's part is taken out of the
# indentation but not out of its rate. Then choose the largest patch that fits on the surface.
