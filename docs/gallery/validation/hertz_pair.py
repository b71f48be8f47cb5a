"""
Two rigid spheres under Hertz's law
===================================

*Source*: K. L. Johnson, *Contact Mechanics*, section 11.4: the largest indentation of two rigid bodies of the reduced mass
m at the velocity V is δ = (5mV²/4k)^(2/5), their largest force k δ^(3/2), and their contact lasts 2.94 δ/V, with
2.94 = 2 ∫₀¹ dx/√(1 - x^(5/2)).

*In*: the two steel spheres of E. Jacquelin's paper, radius 10 mm, at 1 m/s. *Published*: 1001.5 N follows from these
formulas; the paper prints 999.9 N, for the slightly smaller mass of a faceted mesh.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import beta

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
law = ao.Hertz.between(steel, 0.01, steel, 0.01)
mass = 0.5 * 4 / 3 * np.pi * 0.01**3 * 7800  # reduced


def closed_form(velocity):
    depth = (5 * mass * velocity**2 / (4 * law.k)) ** 0.4
    return law.k * depth**1.5, 0.8 * beta(0.4, 0.5) * depth / velocity


print("velocity   peak force (N)                    duration (µs)")
print("m/s        closed form  here         error   closed form  here      error    estimated")
for velocity in (1e-4, 1e-2, 1.0, 5.0):
    ball = ao.ball(0.01, steel)
    hit = ao.simulate(projectile=ball, target=ball, law=law, velocity=velocity)
    force, duration = closed_form(velocity)
    print(
        f"{velocity:<9g}  {force:<11.6g}  {hit.peak_force:<11.6g}  {hit.peak_force / force - 1:7.0e}"
        f"  {1e6 * duration:<11.6g}  {1e6 * hit.contact_duration:<9.6g} "
        f"{hit.contact_duration / duration - 1:8.0e}  {hit.error.time:.0e}"
    )
    assert abs(hit.peak_force / force - 1) < 1e-7

# %%
# The force at 1 m/s, between the lines of the closed form:

ball = ao.ball(0.01, steel)
hit = ao.simulate(projectile=ball, target=ball, law=law, velocity=1.0)
force, duration = closed_form(1.0)
_, ax = plt.subplots(layout="constrained")
ax.plot([0, 1e6 * duration], [force, force], "--", color="0.4", label="largest force, closed form")
ax.plot([1e6 * duration] * 2, [0, force], ":", color="0.4", label="duration, closed form")
ax = hit.plot_force(ax, label="here")

# %%
# The tolerance is kept down to rounding:

for rtol in (1e-3, 1e-6, 1e-9, 1e-12):
    hit = ao.simulate(
        projectile=ball, target=ball, law=law, velocity=1.0, solver=ao.Adaptive(rtol=rtol)
    )
    errors = hit.peak_force / force - 1, hit.contact_duration / duration - 1, hit.restitution - 1
    print(f"rtol {rtol:.0e}: " + ", ".join(f"{abs(error):.0e}" for error in errors))
