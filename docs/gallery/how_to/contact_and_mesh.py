"""
Contact that does not depend on the mesh
========================================

Hertz's law contains the indentation of both bodies, and finite elements indent as well. So the common recipe, finite elements
and Hertz's spring at one node, counts it twice: the force is too small, and smaller on finer meshes. The package takes the
compliance that the mesh has in place of a half-space out of the law (:doc:`/theory/contact`). The force then hardly depends
on the mesh, nor on how the contact force is spread.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
law = ao.Hertz.between(steel, 0.01, steel, 0.01)
meshes = [ao.sphere_mesh(0.01, 0.008), ao.paper_sphere_mesh(), ao.sphere_mesh(0.01, 0.005)]
balls = [ao.FEModel.from_mesh(mesh, steel) for mesh in meshes]

# %%
# The common recipe
# -----------------
# A model that is given by its masses and springs alone knows nothing of a mesh, so that nothing is taken out of the law. The
# finer the mesh, the lower the force; nothing converges:

common = []
for ball in balls:
    model = ao.antioscillators(ball.contact(point=(0.01, 0, 0), radius=0), n=1)
    numbers = ao.AOModel(m0=model.m0, k0=model.k0, m=model.m, k=model.k)
    common.append(ao.simulate(numbers, numbers, 1.0, law=law, duration=100e-6))
    print(f"{len(ball.nodes):5d} nodes: {common[-1].peak_force:7.1f} N")

# %%
# What is right
# -------------
# Fine axisymmetric finite elements with unilateral contact and no law at all give 1014.7 N and 59.41 µs for these spheres
# (:doc:`/validation/two_spheres`). On the same meshes, with the patch that is chosen, of 0.45 mm, and with one of 1.5 mm:

right = []
for ball in balls:
    tips = [ball.contact(point=(0.01, 0, 0), radius=radius) for radius in ("auto", 1.5e-3)]
    hits = [ao.simulate(tip, tip, 1.0) for tip in tips]
    right.append(hits[0])
    print(
        f"{len(ball.nodes):5d} nodes:",
        ", ".join(
            f"{hit.peak_force:7.1f} N ± {100 * hit.error['peak_force'].total:.2f} %" for hit in hits
        ),
    )

# %%
# The compliance that was taken out belongs to the contact point. The summary of a result shows the sum of both bodies:

tip = balls[1].contact(point=(0.01, 0, 0), radius=0.003)
print(f"removed {tip.extraction.removed:.4g} m/N, left {tip.extraction.beyond:.4g} m/N")

# %%

rigid = ao.simulate(
    projectile=ao.ball(0.01, steel), target=ao.ball(0.01, steel), velocity=1.0, duration=100e-6
)
times = np.linspace(0, 90e-6, 500)
_, ax = plt.subplots(layout="constrained")
for hit, label, style in (
    (right[1], "half-space taken out", "-"),
    (common[1], "one node, nothing taken out", "--"),
    (rigid, "rigid masses", ":"),
):
    ax.plot(1e6 * times, hit.at(times).force, style, label=label)
    print(f"{label:28s} {hit.peak_force:7.1f} N  {100 * (hit.peak_force / 1014.7 - 1):+6.1f} %")
ax.axhline(1014.7, color="0.4", lw=0.8)
ax.annotate("resolved", (79, 1014.7), ha="right", va="bottom")
ax.set(xlabel="time (µs)", ylabel="force (N)", xlim=(0, 80), ylim=(0, 1150))
ax.legend()

# %%
# Compared with contact of finite elements
# ----------------------------------------
# A finite-element program needs no law where its elements are smaller than the contact, here 0.31 mm in radius. CalculiX'
# penalty contact, on tetrahedra graded towards the contact, is given one sphere against a rigid plane at half the speed:
# half the work, and the same force. The numbers were measured by ``benchmarks/calculix.py``: processor time from mesh to
# answer, and the error of the peak. The resolved value is itself known to 0.05 %.

measured = {  # s, %
    "default call, even meshes": ((0.75, 0.83, 1.85), (0.16, 0.02, 0.02), "o"),
    "default call, graded meshes": ((1.00, 1.08, 1.74), (0.01, 0.01, 0.04), "s"),
    "CalculiX, the same graded meshes": ((54, 104, 215), (0.09, 0.76, 0.60), "^"),
}
_, ax = plt.subplots(layout="constrained")
ax.axhspan(0, 0.05, color="0.9")
ax.annotate("the resolved value's own uncertainty", (300, 0.047), ha="right", va="top")
for label, (seconds, error, marker) in measured.items():
    ax.plot(seconds, error, marker, label=label)
ax.set(
    xlabel="processor time (s)", ylabel="error of the peak force (%)", xscale="log", yscale="log"
)
ax.set(xlim=(0.5, 400), ylim=(0.005, 2))
ax.legend(loc="upper left")

# %%
# Where it ends
# -------------
# The mesh must resolve what is not a half-space: bending of a plate, waves, an edge nearby. Where it does not, the error says
# so. Linear elements in thin bodies are far too stiff; ``order=2`` mends that:

alu = ao.Material(E=70e9, nu=0.33, rho=2700)
sheet = ao.box_mesh((0.1, 0.1, 0.004), (20, 20, 1))
for order in (None, 2):
    plate = ao.FEModel.from_mesh(sheet, alu, fixed=[("xmin", "xyz"), ("xmax", "xyz")], order=order)
    hit = ao.simulate(ao.ball(0.01, steel), plate.contact(point=(0.05, 0.05, 0.004)), 1.0)
    print(f"order {order}: {hit.peak_force:.0f} N ± {100 * hit.error['peak_force'].total:.1f} %")

# %%
# A patch that is given must be wider than the contact, by a fifth between two like bodies. A contact that grows too wide is
# an error that names the radius to take. It takes a velocity far above those that this package is for:

sphere = ao.antioscillators(balls[1].contact(point=(0.01, 0, 0), radius=0.003), n=1)
try:
    ao.simulate(projectile=sphere, target=sphere, law=law, velocity=200.0, duration=50e-6)
except ao.AOImpactError as error:
    print(error)
