"""
What does a test rig measure?
=============================

A drop tower delivers the force of its load cell over time, filtered, and from it velocity, deflection and absorbed
energy. Simulated impacts are evaluated by the same functions as measured files, so that the two can be compared.

The example is a tup of 2.4 kg with a load cell behind its round nose, on a clamped aluminium plate, which yields under
the nose: the mean pressure there does not exceed 2.8 times the yield strength of 250 MPa.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao
from aoimpact import testrig

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700, yield_strength=250e6)
mesh = ao.box_mesh((0.15, 0.1, 0.006), (24, 16, 2), kind="hexahedron20")
sides = [(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
plate = ao.FEModel.from_mesh(mesh, aluminium, fixed=sides, name="plate")

cell = testrig.LoadCell(nose=0.2, carriage=2.2, stiffness=6e8, damping_ratio=0.02)
tup = cell.tup(radius=0.008, material=steel)
middle = plate.contact(point=(0.075, 0.05, 0.006))
law = ao.ElasticPlastic.between(steel, 0.008, aluminium, np.inf)
hit = ao.simulate(projectile=tup, target=middle, law=law, velocity=0.6)
print(hit)

# %%
# Five lines
# ----------
# A measured channel is read from the file of the data logger. Here that file is written first, by what the load cell
# reads of the simulated impact and of 5 ms of silence before and after it, in milliseconds and kilonewtons:

contact = testrig.Signal.of(hit, rate=400e3, margin=5e-3)
reading = cell.read(contact)
folder = tempfile.TemporaryDirectory()
file = Path(folder.name) / "drop.csv"
columns = np.column_stack([1e3 * reading.t, 1e-3 * reading.values])
np.savetxt(file, columns, delimiter=";", header="time [ms];force [kN]", comments="")

measured = testrig.read_signal(file, time_unit="ms", unit="kN")
force = testrig.Signal(measured.t, measured.values / cell.share)
test = testrig.drop_weight(force, mass=cell.mass, velocity=0.6, gravity=0, start=0, cfc=1000)
same = testrig.drop_weight(hit, cfc=1000)
ax = test.plot_energy(label="load cell")
ax = same.plot_energy(ax, label="contact force")

# %%
# ``gravity=0`` since `simulate` has none; for a measured signal the default is 9.80665 m/s². ``start`` is the first touch, of a rig
# its trigger; left out, it is where the force passes 1 % of its peak. Both tests in numbers, by ASTM D7136
# and ISO 6603-2: the largest force with its deflection and energy, the largest deflection, the rebound, and what the
# plate has kept when the contact ends. Here that is the energy of the permanent dent, and of the plate's
# vibration. A simulated impact has no puncture
# and no incipient damage either: its bodies do not break. A measured one that breaks has both, and it is there that the
# two curves part.

print(test)
print(same)

# %%
# ``force`` is the reading over ``cell.share``. The nose's inertia acts ahead of the cell. For a slow force the cell reads
# only m_c/(m_n + m_c) of it, with the masses of carriage and nose; near its natural frequency it reads too much. Integrating
# the uncorrected reading gives a slower rebound, and absorbed energy that is not there:

print(f"share {cell.share:.3f}, frequency {cell.frequency:.0f} Hz")
print(f"gain at 1 kHz {cell.gain(1000.0):.3f}, at 8 kHz {cell.gain(8000.0):.3f}")
uncorrected = testrig.drop_weight(measured, mass=cell.mass, velocity=0.6, gravity=0)
print(
    f"absorbed, uncorrected: {1e3 * uncorrected.absorbed_energy:.0f} mJ of {1e3 * test.impact_energy:.0f}"
)

# %%
# The filter
# ----------
# :meth:`~aoimpact.testrig.Signal.filtered` is the filter of SAE J211-1, forward and backward, so that no phase is shifted. The signal before it
# stays in ``raw``. The ringing of the load cell goes, and some of the peak of the force with it:

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained", sharey=True)
contact.plot(left, label="contact force", color="0.6")
reading.plot(left, label="load cell", linestyle="--")
left.set(xlim=(-0.2, 2.0), ylabel="force (N)")
right.set(xlim=(-0.2, 1.8))
for cfc, dashes in ((1000, "-"), (600, "--")):
    testrig.drop_weight(hit, cfc=cfc).plot_force(
        right, raw=cfc == 1000, label=f"CFC {cfc}", linestyle=dashes
    )
label = right.set_ylabel("")

# %%
# Force and energy over deflection
# --------------------------------

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
test.plot_deflection(left)
test.plot_energy(right, over="deflection")
for name, marker, point in (("peak of the force", "^", test.peak), ("end", "o", test.last)):
    left.plot(1e6 * point.deflection, point.force, marker, label=name)
    right.plot(1e6 * point.deflection, 1e3 * point.energy, marker)
for ax in (left, right):
    ax.set_xlim(0, 400)
fig.legend(loc="outside upper center", ncols=2)

# %%
# The energy goes up as the plate takes it up, and part of the way back down as the plate gives it back. The energy that is left at the
# end is the absorbed energy, the area of the loop in the left panel. The deflection that is left is the dent's.
#
# Two things at the start and at the end belong to the measurement. The curve of the force does not start at zero, since the
# filter spreads the force over some 0.2 ms before the first touch and after the last; deflection and energy are integrals of
# the force before the filter. And the cell rings on after the contact: read as a force on the tup, that makes the energy rise
# and fall by some millijoules, in other impacts also below zero.

# %%
# Shock at a place of the body
# ----------------------------
# The shock that a device on the plate has to withstand is the shock response spectrum, ISO 18431-4, of the point where it
# is mounted. Sample the probe finely enough for the highest frequency:

times = np.linspace(0, hit.duration, 20001)
probe = hit.target.probe((0.03, 0.05, 0.006), direction=(0, 0, -1), times=times)
spectrum = testrig.shock_spectrum(probe, np.geomspace(100, 20e3, 80), damping_ratio=0.05)
ax = spectrum.plot(parts=True)
folder.cleanup()
