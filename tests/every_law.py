"""One example of every contact law, for tests of properties that all of them share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import aoimpact as ao

K, MASS, SPEED = 1e10, 0.016, 1.0


def damped_hertz(indentation: float, rate: float) -> float:
    return K * indentation**1.5 * (1.0 + 0.5 * rate)


def _table(k: float) -> ao.Tabulated:
    depth = np.linspace(0.0, 1.0, 30) ** 1.5 * 1e-2
    return ao.Tabulated(depth, k * depth**1.5)


# Functions of stiffness, N/m^1.5, restitution and exponent; all laws are similarly stiff at 10 µm.
LAWS: dict[str, Callable[[float, float, float], ao.ContactLaw]] = {
    "Hertz": lambda k, e, n: ao.Hertz(k),
    "PowerLaw": lambda k, e, n: ao.PowerLaw(k * 1e5 ** (n - 1.5), n),
    "Linear": lambda k, e, n: ao.Linear(3e-3 * k),
    "HuntCrossley": lambda k, e, n: ao.HuntCrossley.from_restitution(
        k * 1e5 ** (n - 1.5), e, SPEED, n
    ),
    "Tsuji": lambda k, e, n: ao.Tsuji.from_restitution(k, e, MASS),
    "KuwabaraKono": lambda k, e, n: ao.KuwabaraKono(k, 1e-5 * (1.0 - e)),
    "KelvinVoigt": lambda k, e, n: ao.KelvinVoigt.from_restitution(3e-3 * k, e, MASS),
    "pulling KelvinVoigt": lambda k, e, n: ao.KelvinVoigt.from_restitution(
        3e-3 * k, e, MASS, end="indentation"
    ),
    "Thornton": lambda k, e, n: ao.Thornton(k, 1e-8 * k),
    "ElasticPlastic": lambda k, e, n: ao.ElasticPlastic(k, 1e-8 * k, 0.3 * k, relative_radius=0.01),
    "YangSun": lambda k, e, n: ao.YangSun(k, 4e-6),
    "YangSun with beta": lambda k, e, n: ao.YangSun(k, 4e-6, 0.1),
    "Tabulated": lambda k, e, n: _table(k),
    "UserLaw": lambda k, e, n: ao.UserLaw(damped_hertz),
    "patch Hertz": lambda k, e, n: ao.Hertz(k).within_patch(3.0 / k),
    "patch HuntCrossley": lambda k, e, n: ao.HuntCrossley(k, 0.3).within_patch(0.1 / k),
    "patch Thornton": lambda k, e, n: ao.Thornton(k, 1e-8 * k).within_patch(3.0 / k),
    "patch ElasticPlastic": lambda k, e, n: ao.ElasticPlastic(
        k, 1e-8 * k, 0.3 * k, relative_radius=0.01
    ).within_patch(3.0 / k),
    "patch YangSun": lambda k, e, n: ao.YangSun(k, 4e-6).within_patch(0.1 / k),
}


def law_of(name: str, k: float = K, e: float = 0.6, n: float = 1.5) -> ao.ContactLaw:
    """Return the law of that name."""
    return LAWS[name](k, e, n)
