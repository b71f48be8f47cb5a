"""The picture of the README: two steel spheres at 1 m/s, and how wrong each way of modelling is.

python docs/make_impact.py      # writes docs/impact.png
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
RADIUS, VELOCITY, DURATION = 0.01, 1.0, 120e-6

# N, of both spheres resolved to 6 µm at the contact by axisymmetric elements (tests/resolved.py).
RESOLVED = 1014.7


def main() -> None:
    ball = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), STEEL)
    tip = ball.contact(point=(RADIUS, 0, 0))
    hit = ao.simulate(projectile=tip, target=tip, velocity=VELOCITY, duration=DURATION)
    total = hit.error.total
    assert total is not None
    node = ball.contact(point=(RADIUS, 0, 0), radius=0)
    rigid = ao.ball(RADIUS, STEEL)
    others = {
        "rigid masses": ao.simulate(
            projectile=rigid, target=rigid, velocity=VELOCITY, duration=DURATION
        ),
        "one node touched (the paper's recipe)": ao.simulate(
            projectile=ao.antioscillators(node, n=1),
            target=ao.antioscillators(node, n=1),
            law=hit.law.law,
            velocity=VELOCITY,
            duration=DURATION,
        ),
    }
    times = np.linspace(0.0, DURATION, 400)
    force = hit.at(times).force
    _, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    band = total * force.max()
    ax.fill_between(1e6 * times, force - band, force + band, alpha=0.3, color="C0", lw=0)
    ax.plot(1e6 * times, force, color="C0", label=f"aoimpact, default, ± {100 * total:.1f} %")
    for (label, other), style in zip(others.items(), (("C1", "--"), ("C2", ":")), strict=True):
        ax.plot(1e6 * times, other.at(times).force, color=style[0], ls=style[1], label=label)
    ax.axhline(RESOLVED, color="0.4", lw=0.8)
    ax.annotate("contact resolved by elements of 6 µm", (119, RESOLVED), ha="right", va="bottom")
    ax.set(xlabel="time (µs)", ylabel="force (N)", xlim=(0, 120), ylim=(0, 1150))
    ax.legend(frameon=False, loc="upper right", bbox_to_anchor=(1.0, 0.87))
    plt.savefig(Path(__file__).with_name("impact.png"), dpi=150)


if __name__ == "__main__":
    main()
