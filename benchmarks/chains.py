"""A wave along rows of balls: what a ball and a contact cost in a row of 10, of 100 and of 1000.

    python benchmarks/chains.py

A ball is passed once and has one contact: a longer row may cost no more than twice as
much for each. Where contacts touch twice, the engine runs once more, to a tenth of the tolerance,
and that is counted as well. Takes half a minute.
"""

from __future__ import annotations

import itertools
import os
import warnings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from measuring import Line, best_times, print_table

import aoimpact as ao

# Of the wave that a blow of 1 m/s makes, s.
FROM_BALL_TO_BALL = 30.29e-6
MASS, LAW = 0.0327, ao.Hertz(k=1e10)


def row(count: int) -> ao.Scene:
    scene = ao.Scene()
    ball = ao.rigid(mass=MASS)
    balls = [scene.add(ball, velocity=1.0 if i == 0 else 0.0) for i in range(count)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, LAW)
    return scene


def main() -> None:
    warnings.simplefilter("ignore", ao.AOImpactWarning)
    counts = 10, 100, 1000
    for rtol in (1e-6, 1e-9):
        calls = []
        for count in counts:
            scene, duration = row(count), FROM_BALL_TO_BALL * count + 1e-4
            calls.append(
                lambda s=scene, d=duration, r=rtol: s.simulate(
                    duration=d, solver=ao.Adaptive(rtol=r), energies=False
                )
            )
        each = [t / n for t, n in zip(best_times(*calls, enough=10.0), counts, strict=True)]
        lines = [
            Line(f"a ball of {count}", seconds, "a ball of 10", each[0])
            for count, seconds in zip(counts, each, strict=True)
        ]
        print_table(f"A wave along rows of balls, rtol={rtol:g}", lines)


if __name__ == "__main__":
    main()
