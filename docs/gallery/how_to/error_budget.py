"""
What makes my test and my model differ?
=======================================

A simulated impact says how wrong its numerics may be, and mostly they are right to a percent or two. Between a test and its model
there are larger differences: how the edge is held, what yields, what stretches, which mass was left out. This page varies one at
a time, and sorts them.

The example is a tup of 2 kg with a round steel nose at 2 m/s on a clamped aluminium plate of 150 × 150 × 4 mm.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

warnings.simplefilter("ignore", ao.AOImpactWarning)
size, thickness, radius = 0.15, 0.004, 0.019
steel = ao.Material(E=200e9, nu=0.3, rho=7970)
edges = ("xmin", "xmax", "ymin", "ymax")


def clamped(nodes):
    return np.isclose(np.abs(nodes[:, :2] - 0.5 * size).max(axis=1), 0.5 * size)


def below(nodes):
    return clamped(nodes) & (nodes[:, 2] < 1e-9)


def plate(*, E=70e9, rho=2700, h=thickness, fixed=((clamped, "xyz"),), across=12):
    aluminium = ao.Material(E=E, nu=0.33, rho=rho, yield_strength=275e6)
    mesh = ao.box_mesh((size, size, h), (across, across, 1), kind="hexahedron20")
    return ao.FEModel.from_mesh(mesh, aluminium, fixed=list(fixed))


def impact(body, velocity=2.0, tup=None, law=None, **options):
    h = body.nodes[:, 2].max()
    tip = body.contact(point=(0.5 * size, 0.5 * size, h))
    law = law or ao.Hertz.between(steel, radius, body.material, np.inf)
    return ao.simulate(
        tup or ao.rigid(mass=2.0), tip, velocity, law=law, quantity="peak_force", **options
    )


base = impact(plate())
print(base)
first = base.law

# %%
# One change at a time
# --------------------
# Each is of the size that is usual between a drawing and a test.

heavy = ao.rigid(mass=2.1)
softer = ao.Material(E=70e9, nu=0.33, rho=2700, yield_strength=275e6)
changes = {
    "edge hinged, not clamped": lambda: impact(plate(fixed=[(below, "z")])),
    "plate yields under the nose": lambda: impact(
        plate(), law=ao.ElasticPlastic.between(steel, radius, softer, np.inf)
    ),
    "thickness + 5 %": lambda: impact(plate(h=1.05 * thickness)),
    "modulus of the plate + 5 %": lambda: impact(plate(E=1.05 * 70e9)),
    "mass of the tup + 5 %": lambda: impact(plate(), tup=heavy),
    "velocity + 5 %": lambda: impact(plate(), velocity=2.1),
    "mesh finer by half": lambda: impact(plate(across=18)),
}
found = {name: change() for name, change in changes.items()}

# %%
# Two more are by formula. Without the plate's inertia it is a spring, the static stiffness of the contact point. And what linear
# elasticity leaves out: a clamped plate stretches as it deflects, by which it is stiffer by 0.47 (w/h)² for small deflections w
# (S. Timoshenko, *Theory of Plates and Shells*, section 100).

static = ao.antioscillators(plate().contact(point=(0.5 * size, 0.5 * size, thickness)), 1)
spring = ao.AOModel(m0=1e-3 * base.target.mass, k0=static.k0, m=[], k=[])
found["plate without inertia"] = ao.simulate(
    ao.rigid(mass=2.0), spring, 2.0, law=first, duration=base.duration
)
deepest = np.abs(base.target.displacement).max()
share = deepest / thickness
stretched = np.sqrt(1 + 0.47 * share**2) - 1  # of a force that goes as the root of the stiffness


def seen(hit):
    """Largest force, N, largest deflection, m, and when the last contact ends, s."""
    return hit.peak_force, np.abs(hit.target.displacement).max(), hit.contacts[-1][1]


changed = {name: np.divide(seen(hit), seen(base)) - 1 for name, hit in found.items()}
changed["plate stretches (formula)"] = np.array([stretched, -stretched, -stretched])
changed["numerics, as estimated"] = np.full(3, base.error["peak_force"].total)
changed = dict(sorted(changed.items(), key=lambda row: -np.abs(row[1]).max()))
print(f"{'':30s}   force  deflection  duration   (%)")
for name, row in changed.items():
    print(f"{name:30s} {100 * row[0]:+7.1f} {100 * row[1]:+11.1f} {100 * row[2]:+9.1f}")

fig, ax = plt.subplots(figsize=(7, 4.2), layout="constrained")
place = np.arange(len(changed))[::-1]
for i, what in enumerate(("force", "deflection", "duration")):
    ax.barh(place + 0.27 * (1 - i), [100 * row[i] for row in changed.values()], 0.27, label=what)
ax.set(xlabel="change (%)", yticks=place, yticklabels=list(changed))
ax.legend()

# %%
# What the summary says of itself
# -------------------------------
# ``hit.advice`` has how far the impact is from yield, from small deflections, and which kind of impact it is by its masses:

for of in base.advice:
    print(f"{of.name:12s} {of}{'' if of.within else '   <- beyond'}")

# %%
# Here the edge matters most, then thickness and velocity, which are easily measured. The estimate of the
# numerics is on the safe side: a mesh that is finer by half changes the force by 1.5 %.
