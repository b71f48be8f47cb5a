"""
Speed against error
===================

How long does a result take, and how wrong is it? The two belong together: a time without its error means nothing.
``benchmarks/work_precision.py`` measures both for any impact of two AO models, against a reference whose own uncertainty
it states. The times are those of the machine that built this site.
"""

import numpy as np
from work_precision import work_precision  # benchmarks/work_precision.py

import aoimpact as ao

# %%
# Two spheres, one anti-oscillator each
# -------------------------------------
# The spheres of E. Jacquelin's paper, by its own numbers: 0.1 % of the mass sits at the contact, so that it rings fast
# while the contact lasts. `Newmark` needs a step that follows the ringing; `Adaptive` propagates it exactly and only
# resolves the force. SciPy's DOP853 integrates equations of motion that are written out separately: it shares nothing with
# the other two, and so checks the reference as well.

mass = 4 / 3 * np.pi * 0.01**3 * 7800
steel = ao.Material(E=210e9, nu=0.3, rho=7800)
sphere = ao.AOModel(m0=0.001 * mass, k0=0.0, m=[0.999 * mass], k=[275.7e6])
spheres = work_precision(
    projectile=sphere,
    target=sphere,
    law=ao.Hertz.between(steel, 0.01, steel, 0.01),
    velocity=1.0,
    duration=200e-6,
    newmark=[1e-6, 1e-7, 3e-8, 1e-8],
    scipy=["DOP853"],
    repeats=3,
)
print(spheres)

# %%

ax = spheres.plot()

# %%
# Ten digits of force cost `Adaptive` about twice as much as three. A rule of second order costs ten times more for every
# two digits.

for error in (1e-4, 1e-6):
    ours, theirs = (spheres.fastest(name, error) for name in ("Adaptive", "SciPy DOP853"))
    print(f"{error:.0e}: Adaptive {1e3 * ours.seconds:.2f} ms, SciPy {1e3 * theirs.seconds:.1f} ms")

# %%
# A ball on a beam, twenty milliseconds
# -------------------------------------
# 78 µs of contact, and then a beam that rings. Between contacts the motion has a closed form, and a new touch is found by
# bounds on the gap, not by stepping, so that the rest of the 20 ms costs next to nothing. The beam's anti-oscillators are
# those of Euler and Bernoulli's theory: half a beam, clamped at midspan and hinged at its end, tan x = tanh x.

turns = np.pi * np.arange(1, 29)
x = turns + np.pi / 4
for _ in range(20):
    x = turns + np.arctan(np.tanh(x))
beam_mass, bending = 2400 * 0.02**2, 70e9 * 0.02**4 / 12
m = 4 * beam_mass / np.tanh(x) ** 2 / x**2
beam = ao.AOModel(
    m0=17 / 35 * beam_mass - m.sum(), k0=48 * bending, m=m, k=m * (2 * x) ** 4 * bending / beam_mass
)
case = {"projectile": ao.rigid(mass=mass), "target": beam, "law": ao.Hertz(k=1e10), "velocity": 1.0}
study = work_precision(duration=20e-3, newmark=[2e-6, 1e-6, 3e-7], repeats=3, **case)
print(study)

# %%

ax = study.plot()

# %%
# Other programs
# --------------
# Measured before by ``benchmarks/adaptive.py --scene beam`` on the same beam, whole call, on two shared cores: SciPy's best
# (DOP853) 1 s for an error of 4e-7, CVODE from C (Adams) 240 ms for 1e-7, Exudyn (velocity Verlet) 200 ms for 7e-7;
# `Adaptive` with ``rtol=1e-6`` 0.12 ms for 3e-10 in peak force and rebound.
#
# Is the tolerance kept?
# ----------------------
# A hard case: a heavy ball that bounces on the ringing beam, several contacts, each with many oscillations of the force. The errors
# are those against its own tightest run.

chatter = work_precision(
    projectile=ao.rigid(mass=2.0),
    target=beam.truncated(12),
    law=ao.Hertz(k=1e9),
    velocity=0.1,
    duration=20e-3,
    newmark=[],
    repeats=1,
)
for row in chatter.rows:
    print(f"{row.setting:>12}  worst error {row.error:.1e}")
