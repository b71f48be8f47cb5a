"""The C core: csrc/python binds it, the headers of csrc and include/aoimpact.h specify it.

Arrays are C-contiguous, outputs written.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

_F = npt.NDArray[np.float64]
_I = npt.NDArray[np.int32]
_Pattern = object
_Track = object
_S = npt.NDArray[np.float32]
_Blocks = tuple[_Pattern, _S, _S]
_Part = tuple[int, int]
_Sparse = tuple[_I, _I, _F]
_Law = tuple[Any, ...]
_Modes = tuple[Any, ...]  # what MODES names, as ModalBody.for_core and SteppedBody.for_core make it
_Contact = tuple[int, int, int, int, float, _Law]  # body and port of each side, gap
# Peak force, its time, impulse, intervals (start, end) and touches (impulse, pace) of a contact.
_Pairs = list[tuple[float, float]]
_Found = tuple[float, float, float, _Pairs, _Pairs]

MODES: str

def law_force(
    law: _Law,
    indentation: _F,
    rate: _F,
    force: _F,
    stiffness: _F,
    damping: _F,
    along: bool,
    /,
) -> None: ...
def law_potential(law: _Law, indentation: _F, energy: _F, /) -> None: ...
def star_from_constraint_modes(
    phi_st: _F,
    m_phi_st: _F,
    k0: float,
    phi: _F,
    m_phi: _F,
    omega2: _F,
    m: _F,
    k: _F,
    c: _F,
    of: _I,
    /,
) -> tuple[int, float]: ...
def star_to_modal(
    m0: float, k0: float, m: _F, k: _F, omega2: _F, participation: _F, work: _F, /
) -> int: ...
def star_from_modal(omega2: _F, weight: _F, m: _F, k: _F, /) -> tuple[float, float]: ...
def blocks_pattern(order: _I, start: _I, indices: _I, size: int, /) -> _Pattern: ...
def blocks_multiply(
    matrix: tuple[_Pattern, _F], part: _Part, stage: int, x: _F, y: _F, work: _F, /
) -> None: ...
def blocks_subtract(
    matrix: _Blocks, part: _Part, stage: int, x: _S, r: _S, work: _S, /
) -> None: ...
def blocks_smooth(
    matrix: _Blocks,
    part: _Part,
    stage: int,
    steps: int,
    low: float,
    high: float,
    finish: bool,
    x: _S,
    r: _S,
    work: _S,
    /,
) -> None: ...
def graph_aggregate(start: _I, indices: _I, aggregate: _I, /) -> int: ...
def newmark(
    bodies: tuple[_Modes, ...],
    contacts: tuple[_Contact, ...],
    dt: float,
    beta: float,
    gamma: float,
    x: _F,
    v: _F,
    force: _F | None,
    force_rate: _F | None,
    record: _F,
    energies: bool,
    /,
) -> None: ...
def adaptive(
    bodies: tuple[_Modes, ...],
    contacts: tuple[_Contact, ...],
    rtol: float,
    duration: float,
    x: _F | None,
    moving: tuple[_F, ...],
    velocities: tuple[float, ...],
    most_steps: int,
    /,
) -> tuple[_Track, tuple[_Found, ...], int, int]: ...
def track_open(
    bodies: tuple[_Modes, ...],
    contacts: tuple[_Contact, ...],
    values: bytes,
    places: bytes,
    /,
) -> _Track: ...
def track_bytes(track: _Track, /) -> tuple[bytes, bytes]: ...
def track_rows(track: _Track, /) -> bytes: ...
def track_slips(track: _Track, /) -> bytes: ...

# what: 0 and 1 of the record, without energies or with them; 2 of the contact forces; 3 of the
# states of a body.
def track_read(track: _Track, times: _F, what: int, body: int, out: _F, /) -> None: ...
def briefs(
    bodies: tuple[Any, ...],
    moving: tuple[_F, ...],
    laws: tuple[Any, ...],
    which: _I,
    numbers: _F,
    answers: _F,
    /,
) -> None: ...
