"""The C core; csrc/aoimpact.h is its specification. Arrays are C-contiguous, outputs written."""

import numpy as np
import numpy.typing as npt

_F = npt.NDArray[np.float64]
_I = npt.NDArray[np.int32]
_Sparse = tuple[_I, _I, _F]
_Factors = tuple[_I, _I, _F, _F, _I, _I]
_Relative = tuple[_F, _F, _F, int, _F, float]
_Star = tuple[str, float, float, _F, _F, _F, _F, _F]
_Full = tuple[str, _Sparse, _Sparse, _F, _Factors, _F, _F, _F]

def law_force(
    name: str,
    parameters: _F,
    indentation: _F,
    rate: _F,
    force: _F,
    stiffness: _F,
    damping: _F,
    /,
) -> None: ...
def law_potential(name: str, parameters: _F, indentation: _F, energy: _F, /) -> None: ...
def static_held(b: _F, x: _F, /) -> float: ...
def static_free(rigid: _F, b: _F, phi_st: _F, /) -> float: ...
def constraint_project(b: _F, z: _F, x: _F, /) -> None: ...
def constraint_reflector(b: _F, h: _F, /) -> None: ...
def constraint_congruence(h: _F, a: _F, work: _F, /) -> None: ...
def oscillators_project(
    phi: _F, modal_masses: _F, omega2: _F, m_phi_st: _F, c: _F, m: _F, k: _F, /
) -> None: ...
def star_receptance(m0: float, k0: float, m: _F, k: _F, omega: _F, receptance: _F, /) -> None: ...
def star_to_modal(
    m0: float, k0: float, m: _F, k: _F, omega2: _F, participation: _F, work: _F, /
) -> int: ...
def star_from_modal(omega2: _F, weight: _F, m: _F, k: _F, /) -> tuple[float, float]: ...
def factors_find_panels(start: _I, rows: _I, panel: _I, /) -> int: ...
def factors_solve(factors: _Factors, work: _F, x: _F, /) -> None: ...
def impact(
    projectile: _Star | _Full,
    target: _Star | _Full,
    law: str,
    parameters: _F,
    gap: float,
    dt: float,
    beta: float,
    gamma: float,
    record: _F,
    energies: bool,
    /,
) -> None: ...
def adaptive(
    relative: _Relative,
    law: str,
    parameters: _F,
    rtol: float,
    duration: float,
    x: _F,
    v: _F,
    /,
) -> tuple[bytes, int, float, float, float, int, int]: ...
def track_sample(
    relative: _Relative,
    law: str,
    parameters: _F,
    centre: _F,
    centre_residual: _F,
    track: _F,
    times: _F,
    record: _F,
    /,
) -> None: ...
def record_rows() -> int: ...
