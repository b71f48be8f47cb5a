"""
What does a test rig measure?
=============================

A drop tower delivers the force on its tup over time, filtered, and from it velocity, deflection and absorbed energy.
Simulated impacts are evaluated by the same functions as measured files, so that the two can be compared.

The example is a tup of 2.4 kg with a round nose on a clamped aluminium plate, which yields under the nose: the mean pressure
there does not exceed 2.8 times the yield strength of 250 MPa.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700, yield_strength=250e6)
mesh = ao.box_mesh((0.15, 0.1, 0.006), (24, 16, 2), kind="hexahedron20")
sides = [(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
plate = ao.FEModel.from_mesh(mesh, aluminium, fixed=sides, name="plate")
middle = plate.contact(point=(0.075, 0.05, 0.006))
law = ao.ElasticPlastic.between(steel, 0.008, aluminium, np.inf)
hit = ao.simulate(projectile=ao.rigid(mass=2.4), target=middle, law=law, velocity=0.6)
print(hit)

# %%
# Four lines
# ----------
# A measured channel is read from the file of the data logger. Here that file is written first: the simulated force with noise of
# 0.4 % of its peak, and 5 ms of silence before and after it, in milliseconds and kilonewtons with decimal commas.

contact = ao.testrig.Signal.of(hit, rate=400e3, margin=5e-3)
noise = 0.004 * hit.peak_force * np.random.default_rng(1).normal(size=len(contact.t))
folder = tempfile.TemporaryDirectory()
file = Path(folder.name) / "drop.csv"
rows = [f"{1e3 * t:.4f};{1e-3 * f:.6f}" for t, f in zip(contact.t, contact.values + noise)]
file.write_text("\n".join(["time [ms];force [kN]", *rows]).replace(".", ","))

force = ao.testrig.read_signal(file, time_unit="ms", unit="kN", decimal=",")
test = ao.testrig.drop_weight(force, mass=2.4, velocity=0.6, gravity=0, start=0, cfc=1000)
same = ao.testrig.drop_weight(hit, cfc=1000)
ax = same.plot_energy(test.plot_energy(label="measured"), label="computed")

# %%
# ``gravity=0`` since `simulate` has none; for a measured signal the default is 9.80665 m/s². ``start`` is the first touch, of a rig
# its trigger; left out, it is where the force passes 1 % of its peak. Both tests in numbers, by ASTM D7136
# and ISO 6603-2: the largest force with its deflection and energy, the largest deflection, the rebound, and the energy that the
# plate has kept when the contact ends. Here that is the energy of the permanent dent, and of the plate's
# vibration. A simulated impact has no puncture, since its bodies do not break.

print(test)
print(same)

# %%
# A load cell behind the nose does not feel the nose's inertia. For a slow force it reads only the carriage's share of the mass:
# divide its signal by that share.
#
# The filter
# ----------
# :meth:`~aoimpact.testrig.Signal.filtered` is the filter of SAE J211-1, forward and backward, so that no phase is shifted. The
# signal before it stays in ``raw``. Some of the peak of the force goes with the noise:

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained", sharey=True)
test.plot_force(left, label="CFC 1000")
same.plot_force(right, label="CFC 1000")
ax = ao.testrig.drop_weight(hit, cfc=600).plot_force(right, raw=False, label="CFC 600", ls="--")

# %%
# Force and energy over deflection
# --------------------------------

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
test.plot_deflection(left)
ax = test.plot_energy(right, over="deflection")

# %%
# The energy goes up as the plate takes it up, and part of the way back down as the plate gives it back. The energy that is left at the
# end is the absorbed energy, the area of the loop in the left panel. The deflection that is left is the dent's.
#
# The curve of the force does not start at zero, since the filter spreads the force over some 0.2 ms before the first touch and
# after the last. Deflection and energy are integrals of the force before the filter.

# %%
# Shock at a place of the body
# ----------------------------
# The shock that a device on the plate has to withstand is the shock response spectrum, ISO 18431-4, of the point where it
# is mounted. Sample the probe finely enough for the highest frequency:

times = np.linspace(0, hit.duration, 20001)
probe = hit.target.probe((0.03, 0.05, 0.006), direction=(0, 0, -1), times=times)
spectrum = ao.testrig.shock_spectrum(probe, np.geomspace(100, 20e3, 80), damping_ratio=0.05)
ax = spectrum.plot(parts=True)
folder.cleanup()
