r"""
What does an impact-hammer test measure?
========================================

A modal test strikes a structure with a hammer that measures its force, and measures the motion of another point. The
quotient of the two spectra is the frequency response function (FRF). Here the test is simulated on a free beam, and
:func:`aoimpact.testrig.frf` evaluates it as it would measured signals. `FEModel.frf` computes the same function from the
finite elements.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
mesh = ao.box_mesh((0.6, 0.03, 0.01), (40, 2, 2), kind="hexahedron20")
beam = ao.FEModel.from_mesh(mesh, aluminium, damping=ao.ModalDamping(0.01))
struck = beam.contact(point=(0, 0.015, 0.01), direction=(0, 0, -1), radius=0)
measured = beam.contact(point=(0.6, 0.015, 0.01), direction=(0, 0, -1), radius=0)

# %%
# The test
# --------
# A hammer of 20 g with a tip of 3 MN/m strikes one end, and the other end is measured. The test is compared with the elements
# themselves, so that a model of these is given, of 30 natural modes. Without a model finer elements would be run: their fourth
# resonance is 0.05 % lower, by which its peak changes by a tenth.

hit = ao.simulate(
    projectile=ao.rigid(mass=0.02),
    target=ao.modal(struck, 30),
    velocity=0.5,
    law=ao.Linear(k=3e6),
    duration=0.6,
)
probe = hit.target.probe((0.6, 0.015, 0.01), (0, 0, -1), dt=1e-5)
test = ao.testrig.frf(hit, probe)
print(test)

# %%
# Signals of a real test are given as ``ao.testrig.Signal(t, force)`` and ``ao.testrig.Signal(t, motion, unit="m/s²")``, or
# are read by :func:`~aoimpact.testrig.read_signal`. Lists of signals are several hits: ``coherence`` then tells where they
# agree, and ``error`` has what their scatter leaves unknown.
#
# The finite elements' own
# ------------------------
# `FEModel.frf` takes natural modes up to twice the highest frequency, and the static response of all others as a series
# whose rest is bounded. Its ``error`` is a bound.

band = (test.frequencies > 20) & (test.frequencies < 2000)
f = test.frequencies[band]
frf = beam.frf(excitation=struck, response=measured, frequencies=f, kind="accelerance")
top = np.abs(frf.values).max()
apart = np.abs(test.values[band] - frf.values)
print(f"largest difference: {apart.max() / top:.2%} of the largest accelerance")
print(f"largest error claimed by the test: {test.error[band].max() / top:.2%}")

figure, (upper, lower) = plt.subplots(2, sharex=True, height_ratios=(3, 2), layout="constrained")
upper.semilogy(f, np.abs(test.values[band]), lw=3, color="0.8", label="hammer test")
upper.semilogy(f, np.abs(frf.values), lw=1, label="finite elements")
upper.set(ylabel="accelerance [m/(s² N)]")
upper.legend()
lower.semilogy(f, apart / top, label="difference")
lower.semilogy(f, test.error[band] / top, "--", label="error of the test")
lower.set(xlabel="frequency [Hz]", ylabel="over the largest value")
lower.legend()

# %%
# The end of the record
# ---------------------
# A struck free body moves on. Its velocity at the end T of the record belongs to the spectrum of the acceleration,
#
# .. math:: A(\omega) = i\omega \int_0^T v\, e^{-i\omega t}\, dt + v(T)\, e^{-i\omega T},
#
# and without that term the quotient is wrong, the more the faster the body moves on:

count = 2 * len(test.frequencies)  # samples, filled up by a zero to an even number
velocity, force = np.fft.rfft([probe.velocity, hit.at(probe.t).force], count)[:, 1:][:, band]
wrong = np.abs(2j * np.pi * f * velocity / force - frf.values).max() / top
print(f"without the motion at the end: {wrong:.1%} of the largest accelerance")

# %%
# The vibration after the record is missed. It is largest at the lowest resonance, which rings longest. A window that
# fades the record out would hide it, and add damping.
#
# Two touches
# -----------
# The end of a free beam comes back, and a hammer that is too heavy is struck again. The force of two touches has gaps in
# its spectrum, where the quotient is noise:

heavy = ao.simulate(
    projectile=ao.rigid(mass=0.16), target=struck, velocity=0.5, law=ao.Linear(k=3e6), duration=0.6
)
again = ao.testrig.frf(heavy, heavy.target.probe((0.6, 0.015, 0.01), (0, 0, -1), dt=1e-5))
