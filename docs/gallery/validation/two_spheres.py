"""
Two elastic spheres, contact resolved
=====================================

*Source*: axisymmetric finite elements with unilateral contact, without any contact law, written for this comparison
in ``tests/resolved.py``: linear triangles that are fine at the contact, a lumped mass, central differences in time. It
shares nothing with the package. *In*: two steel spheres of 10 mm radius, 1 m/s (E = 210 GPa, ν = 0.3, 7800 kg/m³): those
of E. Jacquelin's paper, which gives 811.5 N and 72 µs for its full finite-element model.
"""

import matplotlib.pyplot as plt
import numpy as np
import resolved

import aoimpact as ao

# %%
# Resolved
# --------
# Each sphere meets its mirror image, a rigid plane, at half the velocity. Refined further, to 10 and 6 µm, this gives
# 1014.7 ± 0.5 N and 59.41 µs.

solid = resolved.Solid(210e9, 0.3, 7800.0)
for finest in (28e-6, 20e-6):
    sphere = resolved.ball(0.01, solid, finest, reach=0.45e-3)
    truth = resolved.strike(sphere, None, 0.5, 64e-6)
    print(f"elements of {1e6 * finest:.0f} µm: {truth.peak:.1f} N, {1e6 * truth.duration:.2f} µs")
force, duration = 1014.7, 59.41e-6

# %%
# Ours
# ----
# The default call on three meshes: law, radius and models are chosen. The estimated error is the sum of its parts.

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
hits = []
print("nodes   peak (N)  error     estimate duration (µs)  error")
for size in (0.008, 0.005, 0.003):
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(radius=0.01, size=size), steel)
    tip = ball.contact(point=(0.01, 0, 0))
    hit = ao.simulate(projectile=tip, target=tip, velocity=1.0)
    estimate = hit.error["peak_force"].total
    error = hit.peak_force / force - 1
    print(
        f"{len(ball.nodes):5d}   {hit.peak_force:7.1f}  {100 * error:+5.2f} %   {100 * estimate:4.2f} %"
        f"  {1e6 * hit.contact_duration:7.2f}        {100 * (hit.contact_duration / duration - 1):+5.2f} %"
    )
    assert abs(error) < estimate + 5e-4
    hits.append(hit)

# %%
# Other ways
# ----------
# The common recipe, Hertz's spring at one node, on the paper's mesh and on the last one above; and rigid spheres. A model by
# its numbers alone knows nothing of a mesh, so that nothing is taken out of the law.

for body in (ao.FEModel.from_mesh(ao.paper_sphere_mesh(), steel), ball):
    node = ao.antioscillators(body.contact(point=(0.01, 0, 0), radius=0), n=1)
    numbers = ao.AOModel(m0=node.m0, k0=node.k0, m=node.m, k=node.k)
    one = ao.simulate(numbers, numbers, 1.0, law=hit.law, duration=100e-6)
    print(
        f"one node of {len(body.nodes)}: {one.peak_force:.1f} N, {100 * (one.peak_force / force - 1):+.1f} %"
    )
rigid = ao.simulate(projectile=ao.ball(0.01, steel), target=ao.ball(0.01, steel), velocity=1.0)
print(f"rigid: {rigid.peak_force:.1f} N, {100 * (rigid.peak_force / force - 1):+.1f} %")

# %%

times = np.linspace(0, 70e-6, 500)
_, ax = plt.subplots(layout="constrained")
ax.plot(1e6 * truth.t, truth.smooth(), color="0.2", lw=2.5, alpha=0.5, label="resolved, 20 µm")
ax.plot(1e6 * times, hits[0].at(times).force, "--", label="here, coarsest mesh")
ax.plot(1e6 * times, hits[-1].at(times).force, ":", lw=2, label="here, finest mesh")
ax.set(xlabel="time (µs)", ylabel="force (N)", xlim=(0, 70), ylim=(0, 1100))
ax.legend(loc="lower center")
