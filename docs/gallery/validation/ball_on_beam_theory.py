"""
A ball on a slender beam: Timoshenko's problem
==============================================

*Source*: S. P. Timoshenko, *Zeitschrift für Mathematik und Physik* 62 (1913) 198: Hertz's law between a ball and the bending
modes of a simply supported Euler–Bernoulli beam. *In*: steel beam 153.5 mm × 10 mm × 10 mm, steel ball of 10 mm radius,
10 mm/s; E = 216 GPa, ρ = 7960 kg/m³, ν = 0.3.

The independent solution integrates the modal equations by SciPy to a tight tolerance. The package meets the same beam as
an AO model whose numbers are closed forms, and as three-dimensional finite elements.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import aoimpact as ao

E, rho, nu, length, side, radius, velocity = 216e9, 7960.0, 0.3, 0.1535, 0.01, 0.01, 0.01
steel = ao.Material(E=E, nu=nu, rho=rho)
law = ao.Hertz.between(steel, radius, steel, float("inf"))
ball_mass = 4 / 3 * np.pi * radius**3 * rho
duration = 1.2e-3

# %%
# By SciPy
# --------
# Modes j = 1, 3, 5, …: ω = (jπ/L)² √(EI/ρA), q̈ + ω²q = ±√(2/ρAL) F.

modes = np.arange(1, 60, 2)
omega = (modes * np.pi / length) ** 2 * np.sqrt(E * side**2 / 12 / rho)
shape = np.sqrt(2 / (rho * side**2 * length)) * (-1.0) ** ((modes - 1) // 2)


def motion(_, y):
    n = modes.size
    q, p, z, v = y[:n], y[n : 2 * n], y[-2], y[-1]
    depth = max(z - shape @ q, 0.0)
    force = law.k * depth**1.5
    return np.concatenate([p, shape * force - omega**2 * q, [v, -force / ball_mass]])


start = np.zeros(2 * modes.size + 2)
start[-1] = velocity
truth = solve_ivp(
    motion, (0, duration), start, method="DOP853", rtol=1e-10, atol=1e-16, max_step=2e-6
)
force = law.k * np.maximum(truth.y[-2] - shape @ truth.y[: modes.size], 0) ** 1.5
print(f"{force.max():.5f} N, ball leaves with {truth.y[-1, -1] * 1e3:.5f} mm/s")

# %%
# As an AO model
# --------------
# The same modes, as the springs and masses of their receptance: all anti-oscillators of the diagonal matrices.

beam = ao.FEModel(K=np.diag(omega**2), M=np.eye(modes.size), name="modes").contact(b=shape)
oscillators = ao.antioscillators(beam, n=modes.size - 1)  # all
hit = ao.simulate(
    projectile=ao.rigid(mass=ball_mass),
    target=oscillators,
    law=law,
    velocity=velocity,
    duration=duration,
)
print(
    f"{hit.peak_force:.5f} N, {hit.projectile.velocity[-1] * 1e3:.5f} mm/s, {len(hit.contacts)} contacts"
)
print(f"error of the force {hit.peak_force / force.max() - 1:.1e}")
assert abs(hit.peak_force / force.max() - 1) < 1e-5  # the sampling of SciPy's force

# %%
# As finite elements
# ------------------
# A real beam of these proportions also deforms in shear, and its surface around the contact as no half-space does. Both
# hardly change the force.

mesh = ao.box_mesh((length, side, side), (30, 2, 2), kind="hexahedron20")
axis = np.flatnonzero(np.isclose(mesh.nodes[:, 2], side / 2))
ends = [np.intersect1d(mesh.node_sets[end], axis) for end in ("xmin", "xmax")]
solid = ao.FEModel.from_mesh(mesh, steel, fixed=[(ends[0], "xyz"), (ends[1], "yz")], name="beam")
real = ao.simulate(
    projectile=ao.ball(radius, steel),
    target=solid.contact(point=(length / 2, side / 2, side)),
    velocity=velocity,
    duration=duration,
)
print(
    f"{real.peak_force:.3f} N ± {100 * real.error['peak_force'].total:.1f} %, {100 * (real.peak_force / force.max() - 1):+.2f} %"
)

times = np.linspace(0, duration, 1200)
_, ax = plt.subplots(layout="constrained")
ax.plot(1e6 * truth.t, force, color="0.2", lw=2.5, alpha=0.5, label="modes of bending, SciPy")
ax.plot(1e6 * times, hit.at(times).force, "--", label="the same as an AO model")
ax.plot(1e6 * times, real.at(times).force, ":", lw=2, label="finite elements")
ax.set(xlabel="time (µs)", ylabel="force (N)", xlim=(0, 180))
ax.legend()
