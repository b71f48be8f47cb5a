"""A wave along rows of balls: time per contact in a row of 10, of 100 and of 1000.

    python benchmarks/chains.py

The wave passes each ball once, and each contact acts once. In a longer row a contact may take at
most twice as long as in a shorter one. The time includes the whole call and the reading of the
final velocities and all peak forces. It is processor time, since other load of the machine adds to
the wall time of long calls more than to the shortest of many short calls. Takes half a minute.
"""

from __future__ import annotations

import itertools
import math
import os
import time
import warnings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from measuring import Line, best_times, print_table

import aoimpact as ao

# Travel time from ball to ball of the wave that a blow of 1 m/s makes, s.
FROM_BALL_TO_BALL = 30.29e-6
MASS, LAW = 0.0327, ao.Hertz(k=1e10)

COUNTS = 10, 100, 1000


def row(count: int) -> ao.Scene:
    scene = ao.Scene()
    ball = ao.rigid(mass=MASS)
    balls = [scene.add(ball, velocity=1.0 if i == 0 else 0.0) for i in range(count)]
    for one, other in itertools.pairwise(balls):
        scene.connect(one, other, LAW)
    return scene


def pass_on(scene: ao.Scene, count: int, rtol: float) -> int:
    """Run the wave along a row, read what it did, and return how many contacts acted."""
    duration = FROM_BALL_TO_BALL * count + 1e-4
    run = scene.simulate(duration=duration, solver=ao.Adaptive(rtol=rtol), energies=False)
    end = run.at([duration])
    assert math.isclose(sum(body.velocity[-1] for body in end.bodies), 1.0)  # momentum / mass
    return sum(contact.peak_force > 0.0 for contact in end.contacts)


def main() -> None:
    warnings.simplefilter("ignore", ao.AOImpactWarning)
    for rtol in (1e-6, 1e-8, 1e-10):
        acted, calls = [], []
        for count in COUNTS:
            scene = row(count)
            acted.append(pass_on(scene, count, rtol))
            calls.append(lambda s=scene, n=count, r=rtol: pass_on(s, n, r))
        times = best_times(*calls, enough=10.0, clock=time.process_time)
        each = [seconds / contacts for seconds, contacts in zip(times, acted, strict=True)]
        lines = [
            Line(f"a contact of a row of {count}", seconds, "one of a row of 10", each[0])
            for count, seconds in zip(COUNTS, each, strict=True)
        ]
        print_table(f"A wave along rows of balls, rtol={rtol:g}", lines)
        print(f"  a row of 1000 costs {each[-1] / each[0]:.2f} times as much a contact (2 allowed)")


if __name__ == "__main__":
    main()
