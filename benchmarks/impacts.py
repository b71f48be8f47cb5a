"""The two impacts on which speed is measured; tests use their models as well."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aoimpact import AOModel, Hertz, Material, rigid


def pair() -> dict[str, Any]:
    """Two of the paper's spheres, one anti-oscillator each (Table 3), at 1 m/s."""
    mass = 4.0 / 3.0 * math.pi * 0.01**3 * 7800.0
    steel = Material(E=210e9, nu=0.3, rho=7800.0)
    sphere = AOModel(m0=0.001 * mass, m=np.array([0.999 * mass]), k=np.array([275.7e6]))
    return {
        "projectile": sphere,
        "target": sphere,
        "law": Hertz.between(steel, 0.01, steel, 0.01),
        "velocity": 1.0,
        "duration": 200e-6,
    }


def beam_star(n: int = 28) -> AOModel:
    """Return `n` anti-oscillators of the paper's beam, simply supported, seen from midspan.

    By Euler-Bernoulli theory the anti-oscillators are modes of half the beam, clamped at midspan
    and pinned at its end. Their wavenumbers 2 x / L satisfy tan x = tanh x, and their masses are
    m_i = 4 M coth²x / x². The static mass is 17/35 M, and k0 = 48 E I / L³.
    """
    modulus, density, length, width = 70e9, 2400.0, 1.0, 0.02
    mass, bending = density * length * width**2, modulus * width**4 / 12.0
    # Fixed-point iteration of tan x = tanh x: x = i π + atan(tanh x) is a contraction.
    turns = math.pi * np.arange(1, n + 1)
    x = turns + math.pi / 4.0
    for _ in range(20):
        x = turns + np.arctan(np.tanh(x))
    m = 4.0 * mass / np.tanh(x) ** 2 / x**2
    k = m * (2.0 * x / length) ** 4 * bending * length / mass
    m0 = 17.0 / 35.0 * mass - m.sum()
    return AOModel(m0=m0, k0=48.0 * bending / length**3, m=m, k=k)


def sphere_on_beam() -> dict[str, Any]:
    """The rigid sphere on the beam of 28 anti-oscillators, 20 ms: contact, then ringing."""
    return {
        "projectile": rigid(mass=0.0326725636),
        "target": beam_star(),
        "law": Hertz(k=1e10),
        "velocity": 1.0,
        "duration": 20e-3,
    }


SCENES = {"pair": pair, "beam": sphere_on_beam}
