"""
Several bodies
==============

A scene is any number of bodies and contacts along one direction of travel, with gravity, applied forces, walls and
gaps. `simulate` is the scene of two.
"""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

# %%
# A ball, a plate and a floor
# ---------------------------
# ``add`` takes any model and returns a handle; ``connect`` lets two bodies touch, the first of which presses on the
# second along the direction of travel; ``apply`` is a force, constant or with straight lines between times.

law = ao.Hertz(k=1e9)
scene = ao.Scene(gravity=9.81)
ball = scene.add(ao.rigid(mass=0.05, name="ball"), velocity=0.5)
plate = scene.add(ao.rigid(mass=0.2, name="plate"))
floor = scene.add(ao.rigid(mass=float("inf"), name="floor"))
scene.connect(ball, plate, law, gap=1e-3)
scene.connect(plate, floor, law)
scene.apply(plate, force=([0.0, 1e-3], [0.0, 20.0]))
run = scene.simulate(duration=5e-3)
print(run)

# %%

for contact in run.contacts:
    spans = ", ".join(f"{1e3 * start:.3f} to {1e3 * end:.3f}" for start, end in contact.intervals)
    print(f"{contact.name}: {contact.peak_force:.0f} N, in contact from {spans} ms")
print("energy lost or gained by the solver, relative:", run.error.energy)

# %%
# ``run.plot_force()`` draws all contacts; ``run[ball]`` is one body.

ax = run.plot_force()

# %%
# A wave through a row of balls
# -----------------------------
# Newton's cradle, but steel spheres that deform: the impact passes as a wave that is some five balls long (V. F.
# Nesterenko, 1983). Only what touches, or is about to, is stepped, so that a contact in a row of a thousand balls costs
# no more than one of ten.

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
sphere = ao.ball(0.01, steel)
row = ao.Scene()
balls = [row.add(sphere, velocity=1.0 if i == 0 else 0.0, name=f"ball {i}") for i in range(40)]
for left, right in pairwise(balls):
    row.connect(left, right)
run = row.simulate(duration=1.2e-3)

fig, ax = plt.subplots(layout="constrained")
for i in (5, 15, 25, 35):
    ax.plot(1e6 * run.t, run.contacts[i].force)
    ax.annotate(f"{i} on {i + 1}", (1e6 * run.contacts[i].peak_time, 870), ha="center")
labels = ax.set(
    xlabel="time (µs)",
    ylabel="force (N)",
    ylim=(0, 950),
    title="contact forces of ball i on ball i + 1",
)

# %%
# Nesterenko's theory, of waves that are long beside a ball, has the speed of a single wave from its largest force:
# V = a √(4k/5m) (F/k)^(1/6), with F = k δ^(3/2), the mass m and the diameter a of a ball.

law = ao.Hertz.between(steel, 0.01, steel, 0.01)
mass, diameter = 4 / 3 * np.pi * 0.01**3 * 7800, 0.02
first, last = run.contacts[15], run.contacts[35]
speed = 20 * diameter / (last.peak_time - first.peak_time)
theory = diameter * np.sqrt(4 * law.k / (5 * mass)) * (last.peak_force / law.k) ** (1 / 6)
print(f"{speed:.1f} m/s; by the theory of long waves {theory:.1f} m/s")

# %%
# One body touched in several places
# ----------------------------------
# A list of contact points of one finite-element body is added as one body with *ports*. As everywhere, it is reduced as
# far as the quantity of interest allows.

aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
frame = ao.FEModel.from_mesh(
    ao.box_mesh((1.0, 0.02, 0.02), (50, 2, 2), kind="hexahedron20"),
    aluminium,
    fixed=[("xmin", "xyz"), ("xmax", "yz")],
    name="frame",
)
places = [frame.contact(point=(x, 0.01, 0.02)) for x in (0.3, 0.5, 0.6)]
scene = ao.Scene()
struck = scene.add(places)
for i in range(3):
    scene.connect(
        scene.add(ao.ball(0.01, steel), velocity=1.0), struck.port(i), gap=1e-5 * i, name=f"x{i}"
    )
run = scene.simulate(duration=250e-6, quantity="force", rtol=3e-2)
print(run)
