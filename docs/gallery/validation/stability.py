"""
Stability: hard cases and how exact each is
===========================================

Each case is hard for some reason: many contacts, a light contact mass that rings, no contact mass at all, steep damping, a
law that remembers, a long row of bodies. Each is compared with a closed form, a conserved quantity or SciPy on separate
equations.
"""

import math
import warnings
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import aoimpact as ao

# %%
# A thousand bounces
# ------------------
# A ball that falls back on an elastic floor bounces for ever, with the same peak force, and with a period that is known:
# the time of free flight 2V/g and the contact's. The error must not add up.

mass, k, velocity, g = 0.1, 1e9, 0.5, 9.81
for rtol in (1e-3, 1e-6, 1e-9):
    scene = ao.Scene(gravity=g)
    scene.connect(
        scene.add(ao.rigid(mass=mass), velocity=velocity),
        scene.add(ao.rigid(mass=math.inf)),
        ao.Hertz(k=k),
    )
    run = scene.simulate(duration=102.1, solver=ao.Adaptive(rtol=rtol))
    starts = np.array([start for start, _ in run.contacts[0].intervals])
    # Energy: ½mV² + mgδ = ⅖kδ^(5/2) at the deepest point.
    depth = (1.25 * mass * velocity**2 / k) ** 0.4
    for _ in range(60):
        depth = (2.5 / k * (0.5 * mass * velocity**2 + mass * g * depth)) ** 0.4
    force = k * depth**1.5
    period = np.diff(starts)
    print(
        f"rtol {rtol:.0e}: {len(starts)} contacts, peak force {abs(run.contacts[0].peak_force / force - 1):.0e}, "
        f"periods equal to {np.ptp(period) / period.mean():.0e}, energy {run.error.energy:.0e}"
    )

# %%
# A contact mass that rings
# -------------------------
# The lighter the contact mass, the faster it rings on its spring while the contact lasts. The limit is the massless contact. The error of the impulse follows from momentum.

body = 0.02
for light in (1e-2, 1e-4, 1e-6, 1e-8, 0.0):
    model = ao.AOModel(m0=light * body, k0=0.0, m=[(1 - light) * body], k=[2e8])
    hit = ao.simulate(
        projectile=model,
        target=ao.rigid(mass=math.inf),
        law=ao.Hertz(k=1e9),
        velocity=1.0,
        duration=1e-3,
    )
    momentum = body * (1.0 - hit.rebound_velocity)
    print(
        f"m0 = {light:.0e} of the mass: peak {hit.peak_force:.4f} N, {len(hit.contacts)} contacts, "
        f"impulse {abs(hit.impulse / momentum - 1):.0e}, energy {hit.error.energy:.0e}"
    )

# %%
# Without a contact mass
# ----------------------
# The displacement of the contact then follows from the balance of forces at every moment. By SciPy, with that balance
# solved inside: k_s (x - u) = k (u)^(3/2).

spring, law_k = 2e8, 1e9


def contact_force(x):
    u = max(x, 0.0)
    for _ in range(60):  # Newton on the balance
        u -= (law_k * u**1.5 - spring * (x - u)) / (1.5 * law_k * math.sqrt(u) + spring)
        u = max(u, 0.0)
    return spring * (x - u) if x > 0 else 0.0


truth = solve_ivp(
    lambda _, y: [y[1], -contact_force(y[0]) / body],
    (0, 1.5e-4),
    [0.0, 1.0],
    method="DOP853",
    rtol=1e-12,
    atol=1e-18,
    max_step=1e-7,
)
peak = max(contact_force(x) for x in truth.y[0])
print(
    f"SciPy {peak:.4f} N, here {hit.peak_force:.4f} N, difference {abs(hit.peak_force / peak - 1):.0e}"
)

# %%
# Damped and plastic laws over six decades of velocity
# ----------------------------------------------------
# The restitution in a run against `restitution`, which has closed forms and integrals.

laws = {
    "HuntCrossley": ao.HuntCrossley(k=1e9, damping=0.5),
    "Flores": ao.HuntCrossley.from_restitution(1e9, 0.5, 1.0, formula="flores"),
    "Tsuji": ao.Tsuji(k=1e9, alpha=0.3, mass=0.1),
    "KuwabaraKono": ao.KuwabaraKono(k=1e9, A=1e-6),
    "KelvinVoigt": ao.KelvinVoigt(k=1e7, c=200.0),
    "Thornton": ao.Thornton(k=1e9, yield_force=100.0),
}
print("largest difference of the restitution at 1e-4, 1e-2, 1 and 100 m/s:")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    for name, law in laws.items():
        worst = 0.0
        for speed in (1e-4, 1e-2, 1.0, 100.0):
            run = ao.simulate(
                projectile=ao.rigid(mass=0.1),
                target=ao.rigid(mass=math.inf),
                law=law,
                velocity=speed,
                duration=40 * law.stroke(0.05 * speed**2) / speed,
            )
            worst = max(worst, abs(run.restitution - ao.restitution(law, 0.1, speed)))
        print(f"{name:13s} {worst:.0e}")

# %%
# A long row
# ----------
# A wave through some hundred balls: energy is kept, and the wave no longer changes.

row = ao.Scene()
balls = [row.add(ao.rigid(mass=0.1), velocity=0.0 if i else 1.0) for i in range(400)]
for left, right in pairwise(balls):
    row.connect(left, right, ao.Hertz(k=1e9))
run = row.simulate(duration=40e-3, solver=ao.Adaptive(rtol=1e-6))
forces = np.array([contact.peak_force for contact in run.contacts])
reached = np.flatnonzero(forces)[-1]
_, ax = plt.subplots(layout="constrained")
ax.plot(forces[: 3 * reached // 4])
labels = ax.set(xlabel="number of the contact", ylabel="peak force (N)")
middle = forces[reached // 4 : 3 * reached // 4]
print(
    f"{reached + 1} contacts, peak force over the middle half equal to {np.ptp(middle) / middle.mean():.0e}"
)
print(f"energy {run.error.energy:.0e}, estimated error {run.error.time:.0e}")

# %%
# When the tolerance cannot be met
# --------------------------------
# Chaos leaves no tolerance small enough: a ball between two that ring, touched again and again. A warning says so, and
# after how many contacts:

scene = ao.Scene(gravity=9.81)
low = scene.add(ao.AOModel(m0=0.01, k0=1e5, m=[0.05, 0.03], k=[3e5, 9e5]))
one, two = (
    scene.add(ao.rigid(mass=0.02), velocity=0.3),
    scene.add(ao.rigid(mass=0.03), velocity=0.2),
)
scene.connect(one, low, ao.Hertz(k=1e8), gap=1e-3)
scene.connect(two, one, ao.Hertz(k=1e8), gap=1e-3)
with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    run = scene.simulate(duration=1.0, solver=ao.Adaptive(rtol=1e-9))
print(next(str(each.message) for each in warned if "rtol" in str(each.message)))
touches = sum(len(contact.intervals) for contact in run.contacts)
print(f"{touches} contacts of both pairs together; error of the time integration: {run.error.time}")
