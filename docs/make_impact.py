"""The picture of the README: two steel spheres at 1 m/s, and how wrong each way of modelling is.

python docs/make_impact.py      # writes docs/impact.png
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import aoimpact as ao
from aoimpact.base import COLOURS, new_axes

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
    one_ao = ao.antioscillators(node, n=1)
    # A model given by numbers knows of no mesh, so that nothing is taken out of the law.
    by_numbers = ao.AOModel(m0=one_ao.m0, k0=one_ao.k0, m=one_ao.m, k=one_ao.k)
    rigid = ao.ball(RADIUS, STEEL)
    others = {
        "rigid masses": ao.simulate(
            projectile=rigid, target=rigid, velocity=VELOCITY, duration=DURATION
        ),
        "Hertz's spring at one node (the paper's recipe)": ao.simulate(
            projectile=by_numbers,
            target=by_numbers,
            law=hit.law,
            velocity=VELOCITY,
            duration=DURATION,
        ),
    }
    times = np.linspace(0.0, 75e-6, 1500)
    force = hit.at(times).force
    band = total * force.max()
    whole, peak = new_axes(1, 2, figsize=(7.2, 3.8), width_ratios=(2, 1))
    for ax in (whole, peak):
        shaded = {"alpha": 0.3, "color": COLOURS[0], "lw": 0}
        ax.fill_between(1e6 * times, force - band, force + band, **shaded)
        ax.plot(1e6 * times, force, label=f"aoimpact, default, ± {100 * total:.1f} %")
        for label, other in others.items():
            ax.plot(1e6 * times, other.at(times).force, label=label)
        line = {"color": "black", "lw": 0.8, "ls": "-"}
        ax.axhline(RESOLVED, label="peak, contact resolved to 6 µm", **line)
        ax.set(xlabel="time (µs)")
    whole.set(ylabel="force (N)", xlim=(0, 75), ylim=(0, 1100))
    peak.set(xlim=(24, 36), ylim=(980, 1030), title="the peak")
    whole.indicate_inset((24, 980, 12, 50), edgecolor="black")
    names = whole.get_legend_handles_labels()
    whole.figure.legend(*names, loc="outside upper left", ncols=2, frameon=False)
    whole.figure.savefig(Path(__file__).with_name("impact.png"), dpi=150)


if __name__ == "__main__":
    main()
