"""
Sensors of a rod and of a plate
===============================

*Sources*: waves in a rod; G. R. Kirchhoff's plate with the modes of C. L. Navier; the full finite-element model.
*In*: a mass on a spring strikes a rod; a mass strikes a simply supported plate, with a strain gauge 30 mm beside the
contact; a ball strikes a plate with an accelerometer there. The same comparisons are tests of the package.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

warnings.simplefilter("ignore", ao.AOImpactWarning)
table = []

# %%
# Strain of a rod
# ---------------
# A mass m at the velocity V on a spring k meets a long rod of the impedance Z = ρcA. Until waves come back the force obeys
# F'' + (k/Z) F' + (k/m) F = 0 with F'(0) = kV, and passes along the rod: ε = -F(t - x/c)/(EA).

side, length, mass, k, at, area = 0.01, 0.4, 0.1, 5e7, 0.1, 1e-4
no_contraction = ao.Material(E=70e9, nu=0.0, rho=2700)
mesh = ao.box_mesh((length, side, side), (200, 1, 1), kind="hexahedron20")
rod = ao.FEModel.from_mesh(mesh, no_contraction)
face = mesh.node_sets["xmin"]
corner = (np.abs(mesh.nodes[face][:, 1:] - 0.5 * side) > 1e-9).all(axis=1)
b = np.zeros(rod.n_dofs)  # a uniform pressure by the shape functions of a quadratic face
b[3 * face] = np.where(corner, -1 / 12, 1 / 3)
gauge = ao.StrainAt(rod, (at, 0.5 * side, 0.0), "xx")
hit = ao.simulate(
    ao.rigid(mass=mass),
    rod.contact(b=b),
    1.0,
    law=ao.Linear(k),
    duration=8e-5,
    quantity=gauge,
    rtol=2e-3,
)
c = np.sqrt(70e9 / 2700)
decay = 0.5 * k / (2700 * c * area)
omega = np.sqrt(k / mass - decay**2)
t = np.linspace(0, 8e-5, 400)
late = np.maximum(t - at / c, 0)
known = -k / omega * np.exp(-decay * late) * np.sin(omega * late) / (70e9 * area)
strain = hit.target.probe((at, 0.5 * side, 0.0), times=t).strain["xx"]
table.append(("strain of a rod, closed form", np.abs(strain - known).max() / np.abs(known).max()))
fig, axes = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
axes[0].plot(1e6 * t, 1e6 * known, "k--", label="closed form")
axes[0].plot(1e6 * t, 1e6 * strain, label="here")
axes[0].set(xlabel="time (µs)", ylabel="strain (µm/m)", title="rod")
axes[0].legend()

# %%
# An accelerometer, and the force of a support
# --------------------------------------------
# A ball on a plate of 200 × 150 × 6 mm. The full model has all modes of the elements as they are meshed, and is compared with the
# small models of the same elements, ``hit.beside``, which claim an error.

aluminium, steel = ao.Material(E=70e9, nu=0.33, rho=2700), ao.Material(E=210e9, nu=0.3, rho=7800)
mesh = ao.box_mesh((0.2, 0.15, 0.006), (10, 8, 1), kind="hexahedron20")
body = ao.FEModel.from_mesh(mesh, aluminium, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
tip = body.contact(point=(0.1, 0.075, 0.006), radius=0.001)
place, down, duration = (0.13, 0.075, 0.0), (0, 0, -1), 3.2e-3  # the filter takes the last 1 ms
ball, times = ao.ball(0.01, steel), np.arange(0, duration, 4e-6)
full = ao.simulate(ball, ao.full(tip), 1.0, duration=duration, solver=ao.Adaptive(rtol=1e-6))


def acceleration(hit):
    return hit.target.probe(place, down, times=times).filtered(cfc=1000).acceleration


def support(hit):
    return hit.target.reaction("xmin", times=times).force[:, 2]


for name, read, quantity, rtol in (
    ("acceleration behind CFC 1000", acceleration, ao.AccelerationAt(place, down, cfc=1000), 1e-2),
    ("force of a support", support, ao.ReactionAt("xmin", down), 5e-2),
):
    small = ao.simulate(ball, tip, 1.0, duration=duration, quantity=quantity, rtol=rtol)
    right = read(full)
    away = np.nanmax(np.abs(read(small.beside) - right)) / np.nanmax(np.abs(right))
    table.append((f"{name}, full model", away, small.error.model))
    if read is acceleration:
        axes[1].plot(1e3 * times, right, "k--", label="full model")
        axes[1].plot(
            1e3 * times, read(small.beside), label=f"{small.beside.models[1].n} oscillators"
        )
        axes[1].set(xlabel="time (ms)", ylabel="acceleration (m/s²)", title="behind CFC 1000")
        axes[1].legend()

# %%
# Reactions and momentum
# ----------------------
# Newmark's rule changes velocities by the mean of the accelerations at the ends of a step, exactly: so the impulse of contact and
# supports is the change of momentum to rounding.

dt = 2e-6
hit = ao.simulate(ball, ao.antioscillators(tip, 8), 1.0, duration=4e-4, solver=ao.Newmark(dt=dt))
force = hit.force - hit.target.reaction().force[:, 2]
impulse = np.concatenate([[0], np.cumsum(0.5 * dt * (force[1:] + force[:-1]))])
momentum = body.mass * hit.target.centre_velocity
table.append(("momentum by reactions", np.abs(impulse - momentum).max() / np.abs(momentum).max()))

print(f"{'':45s} difference  claimed")
for name, away, *claimed in table:
    print(f"{name:45s} {away:10.1e}  {claimed[0] if claimed else float('nan'):7.1e}")

# %%
# A gauge on a simply supported plate of 300 × 200 × 3 mm is within 1.8 % of Kirchhoff's theory with Navier's modes under the same
# force (``tests/fields/test_sensors.py``); an impact-hammer test within 0.4 % of the frequency response of the finite elements
# (:doc:`/how-to/impact_hammer`).
