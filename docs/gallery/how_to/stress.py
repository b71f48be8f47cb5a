"""
Where is the stress largest?
============================

The displacement, velocity and stress of every point of a body follow from the force, whatever model it was computed
with.

A reduced model has few shapes, which give the force but not yet the stress; what they leave out is corrected
(:doc:`/theory/reduction`).
"""

import tempfile

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)

plate = ao.FEModel.from_mesh(
    ao.box_mesh((0.12, 0.08, 0.006), (24, 16, 3), kind="hexahedron20"),
    aluminium,
    fixed=[("xmin", "xyz"), ("xmax", "xyz")],
    name="plate",
)
hit = ao.simulate(
    projectile=ao.ball(0.01, steel),
    target=plate.contact(point=(0.05, 0.04, 0.006)),
    velocity=1.0,
    duration=400e-6,
)
print(hit)

# %%
# One point over time
# -------------------
# ``probe`` takes a point, a list of points, or the nodes of a named set.

below = hit.target.probe((0.05, 0.04, 0.0))
largest = np.argmax(below.stress.von_mises)
print(f"{below.stress.von_mises[largest] / 1e6:.1f} MPa at {1e6 * below.t[largest]:.1f} µs")
print(
    f"xx {below.stress['xx'][largest] / 1e6:.1f} MPa, yy {below.stress['yy'][largest] / 1e6:.1f} MPa"
)

# %%

_, ax = plt.subplots(layout="constrained")
ax.plot(1e6 * below.t, below.stress["xx"] / 1e6, label="σ_xx")
ax.plot(1e6 * below.t, below.stress["yy"] / 1e6, "--", label="σ_yy")
ax.set(xlabel="time (µs)", ylabel="stress opposite to the contact (MPa)")
ax.legend()

# %%
# Under the contact
# -----------------
# No mesh of a structure resolves the stress under a contact. There it is that of a half-space in closed form, for the
# present force and radius of the contact, plus the rest from the mesh (:doc:`/theory/contact`). On the axis below the
# contact, at the peak force, beside the half-space alone, σ_zz = -p₀/(1 + z²/a²):

a, p0 = hit.contact_radius, hit.hertz_pressure
print(f"contact radius {1e3 * a:.3f} mm, largest pressure {p0 / 1e6:.0f} MPa")
depth = np.linspace(0.0, 3.0, 61)  # z/a
axis = hit.target.probe([(0.05, 0.04, 0.006 - a * z) for z in depth])
peak = np.argmax(hit.force)
sigma_z = axis.stress["zz"][peak] / p0
von_mises = axis.stress.von_mises[peak] / p0
deepest = np.argmax(von_mises)
print(f"von Mises at most {von_mises[deepest]:.3f} p₀, at a depth of {depth[deepest]:.2f} a")
print(f"σ_zz off the half-space's by up to {np.abs(sigma_z + 1 / (1 + depth**2)).max():.4f} p₀")

# %%

_, ax = plt.subplots(layout="constrained")
ax.plot(depth, -sigma_z, label="-σ_zz")
ax.plot(depth, von_mises, "--", label="von Mises")
ax.plot(depth, 1 / (1 + depth**2), ":", color="0.2", lw=2, label="-σ_zz of a half-space")
ax.set(xlabel="depth over the contact radius, z/a", ylabel="stress over the largest pressure")
ax.set(xlim=(0, 3), ylim=(0, 1.05))
ax.legend()

# %%
# The yield point is reached below the surface. A material with a ``yield_strength`` warns where that happens.
#
# The whole body at one time
# --------------------------
# ``field`` is the whole body, at the peak force if no times are given.

field = hit.target.field()
stress = field.stress()
away = np.linalg.norm(plate.nodes - (0.05, 0.04, 0.006), axis=1) > 0.006  # not under the contact
where = np.flatnonzero(away)[np.argmax(stress.von_mises[0, away])]
print(f"6 mm and more from the contact: {stress.von_mises[0, where] / 1e6:.1f} MPa ± {field.error}")

# %%

image = plt.figure(figsize=(9.6, 7.2)).figimage(field.plot().screenshot())

# %%
# ``stress("gauss")`` gives the stress at the Gauss points instead of averages at the nodes. The two differ most where
# the mesh is too coarse for the stress.
#
# The largest over time
# ---------------------
# The stress is often largest after the contact, when waves have come back from the supports. So look at some times.

times = np.linspace(0, hit.duration, 41)
over_time = hit.target.field(times)
highest = over_time.stress().von_mises[:, away].max(axis=1)
print(f"{highest.max() / 1e6:.1f} MPa at {1e6 * times[highest.argmax()]:.0f} µs")
print(
    f"errors of the fields: {np.nanmin(over_time.error[1:]):.3f} to {np.nanmax(over_time.error):.3f}"
)

# %%
# A model that is right for the force need not be right for what comes afterwards; ``field.error`` estimates how far it
# is off, and above 20 % a warning is given. Then give ``quantity=ao.StressAt(plate, point, "xx")``: models are chosen for the stress itself.
# That takes many more oscillators than the force does.

# %%
# For ParaView
# ------------

with tempfile.TemporaryDirectory() as folder:
    file = hit.target.to_vtu(f"{folder}/plate", times=[20e-6, 40e-6, 60e-6])
    print(sorted(path.name for path in file.parent.iterdir()))
