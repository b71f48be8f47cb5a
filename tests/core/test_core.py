"""The binding of the C core: what it refuses, what it gives back, and how it shares the machine."""

from __future__ import annotations

import array
import ast
import ctypes
import functools
import gc
import math
import operator
import os
import platform
import random
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from rows import each

import aoimpact as ao
from aoimpact import _core
from aoimpact.base import errors
from aoimpact.linalg import factorize

STATM = Path("/proc/self/statm")
HEADER = Path(__file__).parents[2] / "include" / "aoimpact.h"
REFUSALS = (TypeError, ValueError, BufferError)
F, S = np.float64, np.float32
PARTS = _core.MODES.split()


def star(n: int = 3, velocity: float = 0.0) -> dict[str, Any]:
    """A star as the core takes it, by the names of its parts, and how it starts."""
    made = ao.AOModel(m0=0.01, m=np.full(n, 0.1), k=1e6 * np.arange(1.0, n + 1.0))
    modes = made.modal
    parts = dict(zip(PARTS, modes.for_core(), strict=True)) | {"decay": np.ones(n + 1)}
    return parts | {"x": np.zeros(n + 1), "v": velocity * modes.whole.moving}


def chain(n: int) -> tuple[Any, Any]:
    """Stiffness and mass of n unit masses on springs, held at both ends."""
    K = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n), format="csr")
    return 1e6 * K, sp.identity(n, format="csr")


def upper() -> tuple[Any, ...]:
    """Rows, columns and entries of a chain of 6 on and right of the diagonal."""
    return rows(sp.triu(chain(6)[0], format="csr"))


def pattern_arguments() -> list[Any]:
    return [np.arange(6, dtype=np.int32), *upper()[:2], 2]


def blocks() -> tuple[Any, ...]:
    """A chain of 6 nodes with two dofs each, as blocks on and right of the diagonal."""
    wide = np.kron(upper()[2].astype(S), np.eye(2, dtype=S).reshape(-1))
    pattern = _core.blocks_pattern(*pattern_arguments())
    return pattern, wide, np.tile(np.eye(2, dtype=S).reshape(-1) / S(2e6), 6)


def rows(matrix: Any) -> tuple[Any, ...]:
    return matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data


def full(n: int = 6, dt: float = 1e-5, velocity: float = 0.0) -> dict[str, Any]:
    """A finite-element body."""
    K, M = chain(n)
    inverse = factorize(M + 0.25 * dt**2 * K).of_bytes
    b = np.eye(n)[n // 2][None]
    parts = {"shape": b, "push": b, "centre": np.full(n, 1.0 / n), "gravity": np.ones(n)}
    parts["full"] = rows(K), rows(M), 0.0, 0.0, inverse
    return parts | {"x": np.zeros(n), "v": np.full(n, velocity)}


def law(name: str = "hertz", *parameters: float) -> tuple[Any, ...]:
    """A law as the core takes it."""
    return name, parameters or (1e9,), 0.0, math.inf, np.full(3, np.nan), None


def steps_arguments(projectile: Any, target: Any, steps: int = 9, dt: float = 1e-5) -> list[Any]:
    """Two bodies and their contact."""
    both = projectile, target
    described = tuple(in_modes(**{k: v for k, v in of.items() if k in PARTS}) for of in both)
    x, v = (np.concatenate([of[name] for of in both]) for name in "xv")
    record = np.zeros((4 + 2 * 8, steps + 1))
    contacts = ((0, 0, 1, 0, 0.0, law()),)
    force = np.zeros(1)
    return [described, contacts, dt, 0.25, 0.5, x, v, force, force.copy(), record, True]


def zeros(*sizes: int) -> list[Any]:
    return [np.zeros(size) for size in sizes]


def in_modes(**parts: Any) -> tuple[Any, ...]:
    """A body in modes as the core takes it; None for what is not given."""
    assert set(parts) <= set(PARTS)
    return tuple(parts.get(name) for name in PARTS)


def two_ports(n: int = 3) -> tuple[Any, ...]:
    """A body in modes with all that aoi_modes may have."""
    shape = np.array([np.ones(n), np.linspace(1.0, -1.0, n)])
    modes = {"omega": 1e3 * np.arange(n), "decay": np.full(n, 3.0), "shape": shape, "push": shape}
    residual = {"residual": 1e-9 * np.eye(2), "centre_residual": np.zeros(2)}
    masses = {"inertia": np.ones(n), "centre": np.eye(n)[0], "gravity": np.ones(n)}
    load = {"load_time": np.array([0.0, 1e-3]), "load_force": np.ones((2, 2))}
    return in_modes(**modes, **residual, **masses, **load)


def bodies() -> tuple[Any, ...]:
    """A ball, a body of two ports, and a held star, as the core takes them."""
    target = ao.AOModel(m0=0.01, k0=1e5, m=[0.1, 0.2], k=[1e6, 1e7])
    return ao.rigid(mass=1.0).modal.for_core(), two_ports(), target.modal.for_core()


def joints() -> tuple[Any, ...]:
    return (0, 0, 1, 0, 0.0, law()), (1, 1, 2, 0, 1e-4, law())


def adaptive_arguments(duration: float = 1e-3) -> list[Any]:
    sizes = [len(body[0]) for body in bodies()]
    moving, speeds = tuple(np.ones(n) for n in sizes), (1.0, 0.0, 0.0)
    return [bodies(), joints(), 1e-6, duration, np.zeros(sum(sizes)), moving, speeds, sys.maxsize]


def adaptive_bytes(arguments: list[Any]) -> list[Any]:
    """What an adaptive run returns, the track as its bytes."""
    made, *others = _core.adaptive(*arguments)
    return [_core.track_bytes(made), *others]


def track() -> Any:
    return _core.adaptive(*adaptive_arguments())[0]


def sample_arguments() -> list[Any]:
    record = np.zeros((2 * 4 + 3 * 6 + 4 * 2, 7))
    return [track(), np.linspace(0.0, 1e-3, 7), 1, 0, record]


def open_arguments() -> list[Any]:
    return [bodies(), joints(), *_core.track_bytes(track())]


def briefs_arguments(duration: float = 1e-3) -> list[Any]:
    """A ball on a held star, twice."""
    ball, _, target = bodies()
    which = np.array([[0, 1, 0], [0, 1, 0]], np.int32)
    numbers = np.array([[1.0, 0.0, duration, 1e-6], [2.0, 1e-4, duration, 1e-8]])
    moving = np.ones(len(ball[0])), np.ones(len(target[0]))
    return [(ball, target), moving, (law(),), which, numbers, np.zeros((2, 10))]


# A good call of every function, and which of its arrays are written.
CALLS: dict[str, tuple[Callable[[], list[Any]], set[int]]] = {
    "law_force": (
        lambda: [law(), np.ones(4), *zeros(4, 4, 4, 4), False],
        {3, 4, 5},
    ),
    "law_potential": (lambda: [law("linear"), np.ones(4), np.zeros(4)], {2}),
    "star_from_constraint_modes": (
        lambda: [
            *[np.ones(4), np.ones(4), 1.0, np.eye(2, 4), np.eye(2, 4), np.arange(1.0, 3.0)],
            *zeros(2, 2, 2),
            np.zeros(2, dtype=np.int32),
        ],
        {6, 7, 8, 9},
    ),
    "star_to_modal": (
        lambda: [1.0, 0.0, np.ones(3), np.arange(1.0, 4.0), *zeros(4, 4, 3)],
        {4, 5, 6},
    ),
    "star_from_modal": (lambda: [np.arange(4.0), np.ones(4), np.zeros(3), np.zeros(3)], {2, 3}),
    "blocks_pattern": (pattern_arguments, set()),
    "blocks_multiply": (
        lambda: [
            (blocks()[0], blocks()[1].astype(float)),
            (0, 6),
            1,
            np.ones(12),
            np.zeros(12),
            np.zeros(54),
        ],
        {4, 5},
    ),
    "blocks_subtract": (
        lambda: [blocks(), (0, 6), 1, np.ones(12, S), np.zeros(12, S), np.zeros(54, S)],
        {4, 5},
    ),
    "blocks_smooth": (
        lambda: [
            *(blocks(), (0, 6), 1, 3, 0.2, 2.0, True),
            *(np.zeros(12, S), np.ones(12, S), np.zeros(54, S)),
        ],
        {7, 8, 9},
    ),
    "graph_aggregate": (lambda: [*upper()[:2], np.zeros(6, np.int32)], {2}),
    "adaptive": (adaptive_arguments, set()),
    "track_open": (open_arguments, set()),
    "track_bytes": (lambda: [track()], set()),
    "track_rows": (lambda: [track()], set()),
    "track_slips": (lambda: [track()], set()),
    "track_read": (sample_arguments, {4}),
    "briefs": (briefs_arguments, {5}),
    "newmark": (lambda: steps_arguments(star(velocity=1.0), star()), {5, 6, 9}),
}

# Functions with arrays that may be None: at the start, modes or contact forces.
MAY_BE_NONE = "adaptive", "newmark"

BAD_ARRAYS: dict[str, Callable[[Any], Any]] = {
    "a list": lambda a: a.tolist(),
    "None": lambda _: None,
    "a number": lambda _: 1.0,
    "text": lambda _: "1.0",
    "bytes": lambda a: a.tobytes(),
    "half the precision": lambda a: a.astype("f4" if a.dtype == F else "i2"),
    "the other kind": lambda a: np.nan_to_num(a).astype("i8" if a.dtype == F else F),
    "complex": lambda a: a.astype(complex),
    "bool": lambda a: a.astype(bool),
    "objects": lambda a: a.astype(object),
    "the other byte order": lambda a: a.astype(a.dtype.newbyteorder()),
    "every other entry": lambda a: np.repeat(a, 2, axis=-1)[..., ::2],
    "backwards": lambda a: np.concatenate([a, a])[::-1][: len(a)],
    "Fortran order": lambda a: np.asfortranarray(np.stack([a.ravel(), a.ravel()], axis=1)),
    "one entry more": lambda a: np.append(a, a.ravel()[-1]),
    "nothing": lambda a: a[:0],
}


def function(name: str) -> Callable[..., Any]:
    return getattr(_core, name)


def within(value: Any, path: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """Where arrays are in arguments and the tuples among them."""
    if isinstance(value, np.ndarray):
        yield path
    for i, part in enumerate(value) if isinstance(value, (tuple, list)) else ():
        yield from within(part, (*path, i))


def exchanged(value: Any, path: tuple[int, ...], new: Any) -> Any:
    if not path:
        return new
    parts = list(value)
    parts[path[0]] = exchanged(parts[path[0]], path[1:], new)
    return type(value)(parts)


def same_buffer(a: Any, b: np.ndarray) -> bool:
    """Whether a core that sees buffers sees the same: one entry backwards is that entry."""
    return (
        isinstance(a, np.ndarray)
        and a.dtype == b.dtype
        and a.size == b.size
        and a.flags.c_contiguous
    )


FULL: dict[str, Any] = {
    "newmark of matrices": (lambda: steps_arguments(star(velocity=1.0), full()), set())
}


@functools.cache
def good_call(name: str) -> list[Any]:
    """The arguments, to be copied."""
    return (CALLS | FULL)[name][0]()


@each("bad", BAD_ARRAYS)
@each("name", CALLS | FULL)
def test_wrong_array_is_refused_and_nothing_written(name: str, bad: str) -> None:
    before, call = good_call(name), function(name.partition(" ")[0])
    for path in within(before):
        if bad == "None" and (len(path) > 1 or name.startswith(MAY_BE_NONE)):
            continue
        arguments = copied(before)
        good = functools.reduce(operator.getitem, path, arguments)
        wrong = BAD_ARRAYS[bad](good)
        if same_buffer(wrong, good):
            continue
        with pytest.raises((*REFUSALS, ao.InputError)):
            call(*exchanged(arguments, path, wrong))
        for place in within(arguments):
            one, other = (
                functools.reduce(operator.getitem, place, of) for of in (arguments, before)
            )
            assert np.array_equal(one, other, equal_nan=True)


@each("name", CALLS)
def test_read_only_output_is_refused_and_read_only_input_is_not(name: str) -> None:
    make, written = CALLS[name]
    for position in [path[0] for path in within(make()) if len(path) == 1]:
        arguments = make()
        arguments[position].flags.writeable = False
        if position in written:
            with pytest.raises((ValueError, BufferError)):
                function(name)(*arguments)
        else:
            function(name)(*arguments)


def test_bodies_at_rest_and_undeformed_need_no_modes() -> None:
    arguments = adaptive_arguments()
    given = adaptive_bytes(arguments)
    arguments[4] = None
    assert adaptive_bytes(arguments) == given


def test_tracks_that_are_not_whole_are_refused() -> None:
    good = open_arguments()
    table, index = np.frombuffer(good[2]), np.frombuffer(good[3], dtype=np.uintp)
    wrong: list[tuple[Any, bytes]] = [(table[:-1].copy(), good[3]), (table, b""), (table, b"1234")]
    for place in (2**63, len(table), 1):
        spoilt = index.copy()
        spoilt[-1] = place
        wrong.append((table, spoilt.tobytes()))
    for values, rows_of in wrong:
        with pytest.raises(ao.InputError):
            _core.track_open(*good[:2], values.tobytes(), rows_of)


def test_a_track_that_was_stored_is_the_same() -> None:
    one, again = track(), _core.track_open(*open_arguments())
    assert _core.track_bytes(one) == _core.track_bytes(again)
    records = [np.zeros((34, 7)) for _ in range(2)]
    for of, record in zip((one, again), records, strict=True):
        _core.track_read(of, np.linspace(0.0, 1e-3, 7), 1, 0, record)
    assert np.array_equal(*records)


@each(
    "name, at, wrong",
    [
        *(("track_read", at, (-1, 4, 2**62)) for at in (2, 3)),
        *((name, 2, (-1, 4)) for name in CALLS if name.startswith("blocks_") and name[-1] != "n"),
    ],
)
def test_numbers_of_what_is_not_there_are_refused(
    name: str, at: int, wrong: tuple[int, ...]
) -> None:
    for number in wrong:
        arguments = CALLS[name][0]()
        arguments[at] = number
        with pytest.raises((ValueError, ao.InputError)):
            function(name)(*arguments)


@each(
    "solve, error",
    [
        (lambda rhs: rhs[8:], ValueError),
        (lambda rhs: None, TypeError),
        (lambda rhs: 1 / 0, ArithmeticError),
    ],
)
def test_what_the_solver_of_a_body_raises_comes_through(solve: Any, error: type) -> None:
    matrices = (*full()["full"][:4], solve)
    with pytest.raises(error):
        _core.newmark(*steps_arguments(full() | {"full": matrices}, star()))


@each("which", ["K", "M"])
@each("part, index, value", [(0, 2, -3), (0, 6, 99), (1, 0, -1), (1, 3, 6)])
def test_matrices_that_point_outside_are_refused(
    which: str, part: int, index: int, value: int
) -> None:
    matrices = list(full()["full"])
    matrix = [values.copy() for values in matrices["KM".index(which)]]
    matrix[part][index] = value
    matrices["KM".index(which)] = tuple(matrix)
    with pytest.raises(ao.InputError):
        _core.newmark(*steps_arguments(full() | {"full": tuple(matrices)}, star()))


# Things that a confused caller, or an unlucky one, may hand over.
ODD_THINGS: list[Any] = [
    None, True, -1, 2**70, 1.5, float("nan"), 1j, "hertz", "star", "", "\0", "é" * 9, b"hertz", (),
    [], {}, object(), np.ones(3), np.ones(0), np.ones((2, 3)), np.array(1.0), np.zeros(3, np.int32),
    np.ones(3, np.float32), array.array("d", [1.0] * 3), array.array("i", [0] * 4),
    bytearray(24), memoryview(b"12345678"), np.float64(2.0), np.ones(3, ">f8"), star(), full(),
    bodies(), joints(), two_ports(), rows(chain(3)[0]), {"kind": "star"},
    (np.ones(3),) * 6,
    range(3), np.ma.ones(3), law("linear", 1.0, 2.0), (law()[0], "12", *law()[2:]),
]  # fmt: skip


def copied(value: Any) -> Any:
    """Arrays, and the tuples, lists and dicts that hold them, once more; anything else itself."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if type(value) is dict:
        return {name: copied(part) for name, part in value.items()}
    return type(value)(map(copied, value)) if type(value) in (tuple, list) else value


@each("name", CALLS)
def test_nonsense_raises_and_never_crashes(name: str) -> None:
    dice = random.Random(name)
    good = CALLS[name][0]()
    for trial in range(600):
        arguments = copied(good)
        for position in range(len(arguments)):
            if trial % 2 or dice.random() < 0.3:
                arguments[position] = dice.choice(ODD_THINGS)
        if name == "adaptive" and type(arguments[3]) is int and arguments[3] > 1:
            continue  # to run for ages is no nonsense: it goes on until memory is full
        try:
            function(name)(*arguments)
        except (*REFUSALS, OverflowError, ao.AOImpactError):
            pass


# ------------------------------------------------------------------------------------- errors


def test_the_header_has_the_version_of_the_package() -> None:
    assert f'#define AOI_VERSION "{ao.__version__}"' in HEADER.read_text()


def core_statuses() -> dict[str, int]:
    """The enum aoi_status as the header has it."""
    body = re.search(r"typedef enum aoi_status \{(.*?)\} aoi_status;", HEADER.read_text(), re.S)
    assert body is not None
    text = re.sub(r"/\*.*?\*/", "", body[1], flags=re.S)
    names = [entry.split("=")[0].strip() for entry in text.split(",")]
    return {name: code for code, name in enumerate(filter(None, names))}


def test_every_status_of_the_core_has_its_exception() -> None:
    statuses = core_statuses()
    assert statuses.pop("AOI_OK") == 0
    assert set(errors._CORE) == set(statuses.values())
    for code in statuses.values():
        error = errors.core_error(code, "what", 1.5e-6)
        assert type(error) is not ao.AOImpactError
        assert isinstance(error, ao.AOImpactError)
        assert isinstance(error, (ValueError, RuntimeError))
        assert "1.5e-06 s" in str(error)
        assert "unknown" not in str(error)


def test_failing_step_says_its_time_and_leaves_the_bodies_as_they_were() -> None:
    arguments = steps_arguments(star(velocity=1.0), star())
    arguments[1] = ((0, 0, 1, 0, 0.0, (*law()[:3], 1.5e-5, *law()[4:])),)
    before = arguments[6].copy()
    with pytest.raises(errors.LawLimitError, match=r"^contact"):
        _core.newmark(*arguments)
    assert not arguments[5].any()
    assert np.array_equal(arguments[6], before)


# --------------------------------------------------------------------------------------- stub


def public_functions() -> set[str]:
    return {name for name, value in vars(_core).items() if callable(value) and name[0] != "_"}


def test_stub_has_the_functions_and_their_arguments() -> None:
    stub = ast.parse((Path(str(_core.__file__)).parent / "_core.pyi").read_text())
    declared = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
    assert set(declared) == public_functions()
    for name, node in declared.items():
        assert not node.args.args, f"{name}: its arguments have no names"
        count = len(node.args.posonlyargs)
        assert count == len(CALLS[name][0]())


# ------------------------------------------------------------------------------------ memory


def doubles(*values: float) -> array.array[float]:
    """An array that refuses to grow while anyone still holds its buffer."""
    return array.array("d", values)


@each("name", ["hertz", "no such law"])
def test_buffers_are_given_back(name: str) -> None:
    record, one, none = doubles(*np.zeros(10 * 20)), doubles(1.0), doubles(0.0)
    parts = {"omega": none, "shape": one, "push": one, "inertia": one, "centre": one}
    ball = in_modes(**parts, gravity=doubles(0.0))
    rest = in_modes(**parts, load_time=doubles(0.0), load_force=doubles(0.0))
    note, x, v, force = doubles(0.0, 0.0, 0.0), doubles(0.0, 0.0), doubles(1.0, 0.0), doubles(0.0)
    contacts = ((0, 0, 1, 0, 0.0, (name, (1e9,), 0.0, math.inf, note, None)),)
    arguments = (ball, rest), contacts, 1e-5, 0.25, 0.5, x, v, force, None, record, True
    if name == "hertz":
        _core.newmark(*arguments)
        assert max(record[:10]) > 0.0
    else:
        with pytest.raises(ao.InputError):
            _core.newmark(*arguments)
    held = {id(part): part for part in (record, note, x, v, force, *ball, *rest) if part}
    for buffer in held.values():
        buffer.append(0.0)


def resident() -> int:
    """Memory of this process, bytes."""
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not STATM.exists(), reason="reads the process's memory from /proc")
@pytest.mark.parametrize("times", [250, pytest.param(10_000, marks=pytest.mark.slow)])
def test_many_calls_leak_nothing(times: int) -> None:
    """Good calls, and such as fail at their last array; in a large body, and in a step."""
    brief = {"adaptive": lambda: adaptive_arguments(1e-5), "briefs": lambda: briefs_arguments(1e-5)}
    calls = []
    for name, (make, _) in CALLS.items():
        good = brief.get(name, make)()
        calls.append((name, good))
        for wrong in ([1.0], np.ones(3, complex)):
            bad = list(good)
            bad[{"newmark": 9, "track_read": 4}.get(name, -1)] = wrong
            calls.append((name, bad))
    big = star(300)
    calls.append(("newmark", steps_arguments(big, star(300, velocity=-1.0), steps=1)))
    calls.append(("newmark", steps_arguments(star(velocity=1.0), full(500), steps=1)))
    calls.append(("newmark", steps_arguments(star(velocity=np.nan), big, steps=1)))

    def cycle(times: int) -> tuple[int, int]:
        for _ in range(times):
            for name, arguments in calls:
                with suppress(*REFUSALS, RuntimeError):
                    function(name)(*copied(arguments))
        gc.collect()
        return sys.getallocatedblocks(), resident()

    cycle(20)
    blocks, memory = cycle(20)
    blocks_after, memory_after = cycle(times)
    # One object a call would be 250 blocks; one work space a call, 80 kB each, 20 MB.
    assert blocks_after - blocks < 200
    assert memory_after - memory < 8_000_000


# -------------------------------------------------------- what outlives a call, and what it costs


@pytest.mark.skipif(
    not sys.platform.startswith("linux") or platform.machine() != "x86_64",
    reason="knows the floating-point environment of x86-64 and glibc only",
)
@each("bits", [0x8040, 0x4000])
def test_what_other_libraries_do_to_arithmetic_is_harmless(bits: int) -> None:
    libm = ctypes.CDLL("libm.so.6")
    kept, changed = (ctypes.c_char * 32)(), (ctypes.c_char * 32)()
    law = "hertz", (1e300,), 0.0, np.inf, np.full(3, np.nan), None
    depth, zero, run = np.array([1e-310, 0.1]), np.zeros(2), adaptive_arguments(duration=0.01)

    def answers() -> list[Any]:
        force = np.zeros(2)
        _core.law_force(law, depth, zero, force, np.zeros(2), np.zeros(2), False)
        return [force.tobytes(), adaptive_bytes(run)]

    wanted = answers()
    libm.fegetenv(kept)
    control = int.from_bytes(kept.raw[28:], "little") | bits  # the register MXCSR
    changed.raw = kept.raw[:28] + control.to_bytes(4, "little")
    libm.fesetenv(changed)
    try:
        found = answers()
        left = (ctypes.c_char * 32)()
        libm.fegetenv(left)
    finally:
        libm.fesetenv(kept)
    assert found == wanted
    assert int.from_bytes(left.raw[28:], "little") & 0xFFC0 == control & 0xFFC0, "as it was"


# ------------------------------------------------------------------------- threads and signals


def test_python_runs_on_while_the_core_does() -> None:
    pause, over = 0.0, threading.Event()

    def watch() -> None:
        nonlocal pause
        last = time.perf_counter()
        while not over.is_set():
            now = time.perf_counter()
            pause, last = max(pause, now - last), now

    thread = threading.Thread(target=watch)
    arguments = steps_arguments(star(1000), star(1000, velocity=-1.0), steps=9000)
    thread.start()
    start = time.perf_counter()
    _core.newmark(*arguments)
    took = time.perf_counter() - start
    over.set()
    thread.join()
    # Had the core kept the interpreter's lock, the watch would have stood still all the while.
    assert pause < 0.5 * took


def test_threads_do_not_disturb_each_other() -> None:
    def run(store: dict[int, Any], key: int) -> None:
        pair = (star(20 + key, velocity=1.0 + key), full(40 + key))
        arguments = steps_arguments(*pair, steps=2000)
        _core.newmark(*arguments)
        store[key] = arguments[9]

    alone: dict[int, Any] = {}
    together: dict[int, Any] = {}
    for key in range(4):
        run(alone, key)
    threads = [threading.Thread(target=run, args=(together, key)) for key in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(alone[key], together[key]) for key in range(4))
