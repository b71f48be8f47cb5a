"""The two impacts that speed is reported on, and their study from the command line."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..base import writable_folder
from ..fem import Material
from ..laws import Hertz
from ..reduction import AOModel, rigid
from .speed import work_precision
from .table import WorkPrecision

__all__ = ["SCENES", "beam_star", "report"]


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

    Euler-Bernoulli: the anti-oscillators are half the beam, clamped at midspan and pinned at its
    end, tan x = tanh x, with m_i = 4 M coth²x / x²; static mass 17/35 M, k0 = 48 E I / L³.
    """
    modulus, density, length, width = 70e9, 2400.0, 1.0, 0.02
    mass, bending = density * length * width**2, modulus * width**4 / 12.0
    # tan x = tanh x: x = i π + atan(tanh x), a contraction.
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

# The longest of these runs takes a second or two.
_STEPS = {
    "pair": (1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9, 3e-10, 1e-10),
    "beam": (2e-6, 1e-6, 3e-7, 1e-7, 3e-8),
}


def report(
    scene: str, out: str | os.PathLike[str], *, scipy: bool = False
) -> tuple[WorkPrecision, tuple[Path, Path]]:
    """Study one of the scenes; write its table (CSV) and figure (PNG) to a folder.

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    import matplotlib.pyplot as plt

    folder = writable_folder(out)
    methods = ("DOP853", "LSODA") if scipy else ()
    study = work_precision(**SCENES[scene](), newmark=_STEPS[scene], scipy=methods, repeats=3)
    files = folder / f"study_{scene}.csv", folder / f"study_{scene}.png"
    study.to_csv(files[0])
    study.plot()
    plt.savefig(files[1])
    plt.close()
    return study, files
