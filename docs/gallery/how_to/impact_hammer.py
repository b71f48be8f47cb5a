"""
What does an impact-hammer test measure?
========================================

A modal test strikes a structure with a hammer that measures its force, and measures the motion of another point. The
quotient of the two spectra is the frequency response function (FRF). Here the test is simulated, and its FRF compared
with the one that `FEModel.frf` computes from the finite elements.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
mesh = ao.box_mesh((0.3, 0.2, 0.006), (15, 10, 1), kind="hexahedron20")
plate = ao.FEModel.from_mesh(
    mesh, aluminium, fixed=[("xmin", "xyz")], damping=ao.Rayleigh(alpha=60.0, beta=1e-6)
)
struck = plate.contact(point=(0.22, 0.06, 0.006), radius=0)
measured = plate.contact(point=(0.3, 0.2, 0.006), direction=(0, 0, -1), radius=0)

# %%
# The test
# --------
# A hammer of 100 g with a tip of 2 MN/m. The record lasts until the plate is at rest again, so that no window is needed.
# The motion of the measured point is the quantity of interest: a model for the force alone would not ring as the plate does.

hit = ao.simulate(
    projectile=ao.rigid(mass=0.1),
    target=struck,
    velocity=1.0,
    law=ao.Linear(k=2e6),
    duration=0.4,
    quantity=measured,
    rtol=1e-3,
)
print(hit)

# %%
# Force and velocity at even times, and the quotient of their spectra. The accelerance is iω times the mobility: spectra of
# velocities need no filter, those of raw accelerations would.

dt = 2e-5
probe = hit.target.probe((0.3, 0.2, 0.006), (0, 0, -1), dt=dt)
force = hit.at(probe.t).force
f = np.fft.rfftfreq(len(probe.t), dt)
band = (f > 20) & (f < 1500)
mobility = np.fft.rfft(probe.velocity)[band] / np.fft.rfft(force)[band]
test = 2j * np.pi * f[band] * mobility

# %%
# The finite elements' own
# ------------------------
# By natural modes up to twice the highest frequency, and the static response of all others as a series, of which the
# rest is bounded: ``error`` is a bound, not an estimate.

frf = plate.frf(excitation=struck, response=measured, frequencies=f[band], kind="accelerance")
print(frf)
print(f"bound of its error: {frf.error.max():.1g} m/(s² N), of {np.abs(frf.values).max():.3g}")

figure, (top, bottom) = plt.subplots(2, sharex=True, height_ratios=(3, 1), layout="constrained")
top.semilogy(f[band], np.abs(test), lw=3, color="0.8", label="hammer test")
top.semilogy(f[band], np.abs(frf.values), lw=1, label="frf")
top.set(ylabel="accelerance [m/(s² N)]")
top.legend()
apart = np.abs(test - frf.values) / np.abs(frf.values).max()
bottom.semilogy(f[band], apart)
bottom.set(xlabel="frequency [Hz]", ylabel="difference")
print(f"largest difference: {100 * apart.max():.2f} % of the largest accelerance")

# %%
# What remains of the difference is the rest of the ringing at the end of the record, the sampling, and the model of the run.
