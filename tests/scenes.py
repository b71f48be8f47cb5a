"""Texts of valid scene files."""

from __future__ import annotations

STARS = """\
[bodies.ball]
mass = 0.03

[bodies.beam]
m0 = 0.1
k0 = 1e5
m = [0.2]
k = [1e6]

[impact]
projectile = "ball"
target = "beam"
velocity = 2.0
duration = 1e-3
gap = 1e-5
law = { type = "Hertz", k = 1e9 }
solver = { type = "Newmark", dt = 1e-6 }
"""

BAR = """\
[materials.alu]
E = 70e9
nu = 0.3
rho = 2700

[bodies.bar]
mesh = { box = [0.1, 0.01, 0.01], divisions = [4, 1, 1] }
material = "alu"
fixed = [
    { nodes = "xmin", hold = "xyz" },
    { nodes = [4, 5], hold = "z" },
]
contact = { point = [0.1, 0.0, 0.0], direction = [0, 0, 1], radius = 0 }
model = { type = "antioscillators", n = 2 }

[bodies.ball]
mass = 0.001

[impact]
projectile = "ball"
target = "bar"
velocity = 1.0
duration = 1e-3
law = { type = "Linear", k = 1e6 }
"""

ROW = """\
[bodies.ball]
mass = 0.03

[bodies.wall]
mass = inf

[scene]
duration = 1e-2
gravity = 9.81
solver = { type = "Adaptive", rtol = 1e-9 }

[[scene.bodies]]
name = "first"
body = "ball"
velocity = 1.0
position = -1e-3

[[scene.bodies]]
name = "second"
body = "ball"

[[scene.bodies]]
body = "wall"
position = 2e-3

[[scene.contacts]]
between = ["first", "second"]
law = { type = "Hertz", k = 1e10 }

[[scene.contacts]]
between = ["second", "wall"]
gap = 1e-3
law = { type = "Linear", k = 1e7 }

[[scene.loads]]
body = "second"
times = [0.0, 1e-3]
forces = [0.0, 2.0]
"""

# Sweep to append to STARS.
SWEPT = """
[sweep]
keep = ["peak_force"]

[sweep.over]
velocity = [1.0, 2.0]
law.k = { from = 1e8, to = 1e10, count = 3, spacing = "log" }
bodies.beam.m0 = { from = 0.1, to = 0.3, count = 3 }
"""
