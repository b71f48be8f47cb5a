"""Places at which the fields of half-spaces are looked at."""

import numpy as np

A = 0.002  # radius of the pressed disc, m

# Inside the body: under the disc, below its rim, near the axis, far off, and close to the surface.
INSIDE = A * np.array(
    [
        [0.3, 0.2, 0.5],
        [0.9, -0.4, 0.05],
        [0.02, 0.01, 1.3],
        [-2.0, 1.0, 0.7],
        [6.0, -5.0, 0.4],
        [0.4, 0.4, 0.02],
        [12.0, 3.0, 20.0],
    ]
)
# Behind the tangent plane, where the surface of a concave body may be.
BEHIND = A * np.array([[2.0, 0.5, -0.3], [-1.5, 1.5, -0.8], [0.3, 0.2, -0.02], [8.0, 1.0, -4.0]])
