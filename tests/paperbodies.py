"""The paper's spheres and beam, their contact laws, and a resolved force of the spheres."""

from __future__ import annotations

import math

import numpy as np

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2400)
RADIUS, LENGTH, WIDTH = 0.01, 1.0, 0.02
BALL_MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * STEEL.rho
SPHERES_LAW = ao.Hertz.between(STEEL, RADIUS, STEEL, RADIUS)
LAW = ao.Hertz.between(STEEL, RADIUS, ALUMINIUM, math.inf)

# Peak force, N, and duration, s, of the impact of both spheres by resolved contact mechanics:
# converged explicit simulation with axisymmetric finite elements (6 ... 40 µm at the contact) and
# unilateral contact; force ± 0.5 N.
RESOLVED_FORCE, RESOLVED_DURATION = 1014.7, 59.41e-6


def beam_model() -> ao.FEModel:
    """Return the beam, with one bottom edge pinned and the other one on rollers."""
    mesh = ao.box_mesh((LENGTH, WIDTH, WIDTH), (50, 2, 2))
    bottom = np.flatnonzero(mesh.nodes[:, 2] == 0.0)
    pinned, rollers = (np.intersect1d(mesh.node_sets[end], bottom) for end in ("xmin", "xmax"))
    return ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[(pinned, "xyz"), (rollers, "yz")])
