"""
Damping and restitution
=======================

Energy is lost in two places: in the contact, by its law, and in the bodies, by their damping and by vibration that
remains in them. So the restitution of an impact on a structure is not the restitution of its contact law.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

k, mass, velocity = 1e10, 0.016, 1.0  # N/m^1.5; reduced mass of the pair, kg; m/s

# %%
# Nominal against delivered
# -------------------------
# Most damped contact laws are given a *nominal* restitution e, which a published formula turns into a damping. The
# restitution that two rigid bodies actually show differs. ``ao.restitution(law, mass, velocity)`` computes it for any law;
# ``from_restitution`` goes the other way and finds the damping that delivers what was asked. For F = k δⁿ (1 + χ δ̇) a
# rigid pair delivers, whatever k, n and the masses, the e with χV(1 + e) = log((1 + χV)/(1 - χVe)).


def published_by(formula):
    return lambda e: ao.HuntCrossley.from_restitution(k, e, velocity, formula=formula)


published = {
    "Hunt–Crossley, 3(1-e)/2": lambda e: ao.HuntCrossley(k, 1.5 * (1 - e) / velocity),
    "Lankarani–Nikravesh": published_by("lankarani-nikravesh"),
    "Lee–Wang": published_by("lee-wang"),
    "Herbert–McWhannell": published_by("herbert-mcwhannell"),
    "Gonthier": published_by("gonthier"),
    "Flores": published_by("flores"),
}
exact = {
    "HuntCrossley": lambda e: ao.HuntCrossley.from_restitution(k, e, velocity),
    "Tsuji": lambda e: ao.Tsuji.from_restitution(k, e, mass),
    "KelvinVoigt": lambda e: ao.KelvinVoigt.from_restitution(1e7, e, mass),
    "KuwabaraKono": lambda e: ao.KuwabaraKono.from_restitution(k, e, velocity, mass),
}


def delivered(make, values):
    return np.array([ao.restitution(make(e), mass, velocity) for e in values])


asked = (0.1, 0.3, 0.5, 0.7, 0.9)
print(f"{'asked for':>24}" + "".join(f"{e:8.2f}" for e in asked))
for name, make in (published | exact).items():
    print(f"{name:>24}" + "".join(f"{e:8.4f}" for e in delivered(make, asked)))

# %%
# The laws with a ``from_restitution`` lie on the diagonal.

nominal = np.linspace(0.01, 1.0, 100)
styles = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))
fig, ax = plt.subplots(figsize=(7, 4.5), layout="constrained")
for style, (name, make) in zip(styles, published.items()):
    ax.plot(nominal, delivered(make, nominal), linestyle=style, label=name)
few = np.linspace(0.05, 1.0, 8)
for marker, (name, make) in zip("os^v", exact.items()):
    ax.plot(few, delivered(make, few), marker, mfc="none", label=f"{name}.from_restitution")
ax.plot([0, 1], [0, 1], color="0.6", lw=0.8, zorder=0)
ax.set(xlabel="restitution asked for", ylabel="restitution delivered", aspect="equal")
fig.legend(loc="outside right upper", fontsize=8)

# %%
# Over the velocity
# -----------------
# A law is made for one velocity, and used at others. Tsuji's and Kelvin and Voigt's restitution do not depend on it;
# Kuwabara and Kono's falls as for viscoelastic bodies, 1 - e ∝ V^(1/5); Hunt and Crossley's falls faster; Thornton's,
# plastic, falls like V^(-1/4) once the contact yields.

laws = {name: make(0.7) for name, make in exact.items()}
laws["Flores, nominal 0.7"] = published["Flores"](0.7)
laws["Thornton"] = ao.Thornton(k, yield_force=100.0)
speeds = np.geomspace(1e-3, 1e2, 60)
fig, ax = plt.subplots(figsize=(7, 4), layout="constrained")
for style, (name, law) in zip(styles, laws.items()):
    ax.semilogx(speeds, [ao.restitution(law, mass, v) for v in speeds], linestyle=style, label=name)
ax.set(xlabel="velocity (m/s)", ylabel="restitution", ylim=(0, 1.02))
fig.legend(loc="outside right upper", fontsize=8)

# %%
# The force that goes with it
# ---------------------------
# The same restitution, 0.5 at 1 m/s, by four laws: the forces differ. Kelvin and Voigt's starts with a jump.

wall = ao.rigid(mass=float("inf"))
fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for style, (name, make) in zip(styles, exact.items()):
    hit = ao.simulate(
        projectile=ao.rigid(mass=mass),
        target=wall,
        law=make(0.5),
        velocity=velocity,
        duration=1.2e-4,
    ).at(np.linspace(0, 1.2e-4, 800))
    print(f"{name:13s} rebounds with {hit.restitution:.6f}")
    left.plot(1e6 * hit.t, hit.force, linestyle=style, label=name)
    right.plot(1e6 * hit.indentation, hit.force, linestyle=style)
left.set(xlabel="time (µs)", ylabel="force (N)")
right.set(xlabel="indentation (µm)", xlim=(0, None))
fig.legend(loc="outside right upper", fontsize=8)

# %%
# A plastic contact
# -----------------
# Thornton's law is elastic up to the yield force, then a straight line, and unloads on the flattened radius. Steel balls
# of 10 mm whose softer one yields at a pressure of 800 MPa yield at little more than a centimetre per second.

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
law = ao.Thornton.between(steel, 0.01, steel, 0.01, yield_pressure=800e6)
print(f"yields at {law.yield_force:.3g} N, {100 * law.yield_velocity(mass):.2g} cm/s")
fig, ax = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
for style, speed in zip(styles, (0.05, 0.2, 0.5, 1.0)):
    hit = ao.simulate(
        projectile=ao.rigid(mass=mass), target=wall, law=law, velocity=speed, duration=3e-4
    ).at(np.linspace(0, 3e-4, 3000))
    touching = hit.force > 0
    e = ao.restitution(law, mass, speed)
    ax.plot(
        1e6 * hit.indentation[touching],
        hit.force[touching],
        linestyle=style,
        label=f"{speed:g} m/s: e = {e:.3f}",
    )
ax.set(xlabel="indentation (µm)", ylabel="force (N)")
ax.legend()

# %%
# Damping of a body
# -----------------
# A body has Rayleigh's damping, C = α M + β K, or one ratio for all of its modes. Its models inherit it. The restitution
# of an elastic contact on a beam is what the beam keeps; its damping hardly changes that, since the contact is short
# beside the decay.

aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
mesh = ao.box_mesh((0.3, 0.02, 0.01), (24, 2, 2), kind="hexahedron20")
fixed = [("xmin", "xyz"), ("xmax", "xyz")]
fig, ax = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
dampings = {
    "undamped": None,
    "2 % in all modes": ao.ModalDamping(0.02),
    "Rayleigh, β = 2 µs": ao.Rayleigh(alpha=0.0, beta=2e-6),
}
for style, (name, damping) in zip(styles, dampings.items()):
    beam = ao.FEModel.from_mesh(mesh, aluminium, fixed=fixed, damping=damping)
    hit = ao.simulate(
        projectile=ao.ball(0.005, steel),
        target=beam.contact(point=(0.15, 0.01, 0.01)),
        velocity=0.5,
        duration=6e-3,
        quantity="target_displacement",
        rtol=2e-2,
    )
    hit = hit.at(np.linspace(0, 6e-3, 1500))
    print(
        f"{name}: restitution {hit.restitution:.3f} ± {hit.error['restitution'].total:.1%}, "
        f"{1e6 * hit.energy.dissipated[-1]:.0f} µJ dissipated in the beam"
    )
    ax.plot(1e3 * hit.t, 1e6 * hit.target.displacement, linestyle=style, label=name)
ax.set(xlabel="time (ms)", ylabel="displacement of the contact point (µm)")
fig.legend(loc="outside upper center", ncols=3, fontsize=8)
