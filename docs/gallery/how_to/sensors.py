"""
What do my sensors read?
========================

An accelerometer, a strain gauge and load cells under the supports see the same impact, each in its own way. This page reads
them of a simulated one, each with its error, and lets the models grow until a sensor is right.

The example is a ball on an aluminium plate that is held at two edges.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
mesh = ao.box_mesh((0.2, 0.15, 0.006), (16, 12, 1), kind="hexahedron20")
plate = ao.FEModel.from_mesh(
    mesh, aluminium, fixed=[("xmin", "xyz"), ("xmax", "xyz")], damping=ao.Rayleigh(beta=2e-6)
)
point = plate.contact(point=(0.1, 0.075, 0.006))
below = (0.13, 0.075, 0.0)  # 30 mm beside the contact, on the other side

# %%
# An accelerometer
# ----------------
# An acceleration after an impact has no finite bandwidth: each further mode of a model adds as much as the one before. Behind the
# filter of a measuring channel it converges, and as a quantity of interest it is defined there: the channel frequency class
# of SAE J211 (``cfc=``), or the frequency where it is 3 dB down (``corner=``). The filter runs backward as well, so that over its
# settling time before the end of the record, 1 ms for CFC 1000, the acceleration is not known: it is NaN there. A record whose length
# is left out is long enough.

wanted = ao.AccelerationAt(below, (0, 0, -1), cfc=1000)
hit = ao.simulate(ao.ball(0.01, steel), point, 1.0, quantity=wanted, rtol=1e-2)
print(hit)

probe = hit.target.probe(below, (0, 0, -1), dt=5e-6)
channel = probe.filtered(cfc=1000)
print(
    f"largest {np.nanmax(np.abs(channel.acceleration)):.0f} m/s², error {np.nanmax(channel.error):.2%}"
)

# %%
# ``dt=`` gives even times, as spectra take them. ``probe.acceleration`` is the acceleration without a filter, with a warning.
#
# A strain gauge
# --------------
# Its strain is the mean along its length on the surface. ``probe.strain`` is the strain at a point.

strain = ao.StrainAt(plate, below, (1, 0, 0), length=3e-3)
gauged = ao.simulate(ao.ball(0.01, steel), point, 1.0, quantity=strain, rtol=3e-2, duration=1e-3)
gauge = gauged.target.gauge(below, (1, 0, 0), length=3e-3, dt=1e-6)
print(
    f"largest strain {1e6 * np.abs(gauge.strain).max():.1f} µm/m, error {np.max(gauge.error):.2%}"
)

# %%
# Load cells under the supports
# -----------------------------
# ``reaction`` takes the name of the node set that ``fixed`` or ``springs`` named, and has force, moment about the middle of the
# nodes, and the force on each of them. Of all supports together it is what changes the momentum. Of several quantities in a list each is
# right to the tolerance.

wanted = ["peak_force", ao.ReactionAt("xmin", (0, 0, 1))]
held = ao.simulate(ao.ball(0.01, steel), point, 1.0, quantity=wanted, rtol=5e-2, duration=1e-3)
reaction = held.target.reaction("xmin", dt=1e-6)
both = held.target.reaction(dt=1e-6).force
print(f"largest force on one edge {held.value('reaction'):.0f} N ± {held.error['reaction']}")

fig, axes = plt.subplots(3, figsize=(7, 6.5), layout="constrained")
axes[0].plot(1e3 * channel.t, channel.acceleration)
axes[0].set(ylabel="acceleration (m/s²)")
axes[1].plot(1e3 * gauge.t, 1e6 * gauge.strain)
axes[1].set(ylabel="strain (µm/m)")
axes[2].plot(1e3 * reaction.t, held.at(reaction.t).force, color="0.6", label="contact force")
axes[2].plot(1e3 * reaction.t, both[:, 2], label="both supports")
axes[2].set(xlabel="time (ms)", ylabel="force (N)")
axes[2].legend()

# %%
# Supports feel the impact only when its waves arrive. The model that is right for the force of the contact is not right for
# them: without ``quantity`` a warning says so when a reaction is read.
