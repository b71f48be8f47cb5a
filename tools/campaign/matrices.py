"""Damaged stiffness and mass matrices: structure, numbers, shapes and types."""

from __future__ import annotations

import pickle
import random
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

import aoimpact as ao

from .inputs import trials

_FORMATS = ("csr", "csc", "coo", "bsr", "dia", "lil", "dok")

_ARGUMENT = re.compile(
    r"\b(K|M|nodes?|free|dof|damping|body|functional|n|k0|m0|m|k|mass|stiffness|contact_time)\b"
)

_WORDS = """
    -1 -2 0 1 5 255 1000000
    -0x80000000 0x40000000 0x7ffffffe 0x7fffffff
    -0x8000000000000000 0x4000000000000000 0x7fffffffffffffff
"""
_INDICES = [int(word, 0) for word in _WORDS.split()]
_FLOATS = "0 -0 -1 1e308 -1e308 1e-308 5e-324 1e200 1e-200 nan inf -inf"
_NUMBERS = [float(word) for word in _FLOATS.split()]

_KINDS = """
    f2 f4 g c16
    i1 i8 u8 ?
    >f8 >i4
    O U8 S8 M8[s]
"""
_TYPES = [*_KINDS.split(), [("a", "f8")]]

_ODD = [None, 0, 1.5, "K", b"K", True, 1j, [], {}, (), [[]], object(), len, set()]
_ODD += [10**400, [[10**400]], float("nan"), range(4), np.datetime64("2026-01-01")]
_ODD += [[[1.0, 2.0], [3.0]], [[1.0, None], [0.0, 1.0]], [["1", "0"], ["0", "1"]], np.array(1.0)]
_ODD += [np.zeros(shape) for shape in ((0, 0), (2, 3), 4, (2, 2, 2))]
_ODD += [np.ma.masked_array(np.eye(2), np.eye(2) > 0)]


def _of_star(star: ao.AOModel) -> list[float]:
    return [star.m0, star.k0, *star.m, *star.k]


# Reduced models of a body, each with a function that returns the model's numbers.
_MODELS = {
    "eigen": lambda tip: _of_star(ao.antioscillators(tip, n=1)),
    "krylov": lambda tip: _of_star(ao.antioscillators(tip, n=1, method="krylov")),
    "modal": lambda tip: _of_star(ao.modal(tip, 1).star),
    "interface": lambda tip: ao.interface([tip], 3, contact_time=0.1).omega,
}


@dataclass(frozen=True)
class Given:
    """Arguments of `FEModel`, K and M among them, and the kind of reduced model to make."""

    arguments: dict[str, Any]
    reduced: str

    def run(self) -> None:
        body = ao.FEModel(**self.arguments)
        body.frequencies(min(3, body.n_dofs))
        tip = body.contact(dof=body.n_dofs // 2)
        numbers = _MODELS[self.reduced](tip)
        if not np.isfinite(numbers).all():
            raise ArithmeticError(f"numbers of the model are not finite: {numbers}")

    def named(self, message: str) -> bool:
        return bool(_ARGUMENT.search(message))


def seeds(folder: Path) -> list[Any]:
    """Return sound triples of K, M, and nodes or None."""
    found = list[Any]()
    for n in (1, 2, 3, 8, 40):
        K = sp.diags_array([-1e6, 2e6, -1e6], offsets=[-1, 0, 1], shape=(n, n)).toarray()
        found.append((K, np.diag(np.linspace(1.0, 2.0, n)), None))
        if n > 1:
            K = K.copy()
            K[0, 0] = K[-1, -1] = 1e6  # a chain without supports
            found.append((K, np.eye(n), None))
    box = ao.box_mesh((0.1, 0.05, 0.05), (2, 1, 1))
    body = ao.FEModel.from_mesh(box, ao.Material(E=1e9, nu=0.3, rho=1e3))
    found.append((body.K.toarray(), body.M.toarray(), np.array(box.nodes)))
    long = sp.diags_array([-1e6, 2e6, -1e6], offsets=[-1, 0, 1], shape=(600, 600)).toarray()
    found.append((long, np.eye(600), None))
    return found


def make(rng: random.Random, sound: list[Any], folder: Path) -> Given:
    """Return damaged matrices, and pickle them to a file."""
    K, M, nodes = sound[-1] if rng.random() < 0.02 else rng.choice(sound[:-1])
    given = {"K": K.copy(), "M": M.copy()}
    if nodes is not None and rng.random() < 0.7:
        given["nodes"] = nodes.copy()
    names = ["K", "M"]
    for _ in range(rng.choice((0, 1, 1, 2))):
        name = rng.choice(names)
        given[name] = _values(rng, given[name])
    for name in names:
        given[name] = _stored(rng, given[name])
    # Each matrix is broken once at most: SciPy itself may crash on changes to a broken one.
    for name in rng.sample(names, rng.choice((0, 1, 1, 1, 2))):
        given[name] = _broken(rng, given[name])
    n = K.shape[0]
    numbers = [np.arange(n), np.arange(n)[::-1], np.zeros(n, int), np.arange(n) - 1]
    numbers += [np.arange(n) * 1.0, np.full(n, 2**62)]
    way = rng.randrange(30)
    if way == 0:
        given["K"], given["M"] = given["M"], given["K"]
    elif way == 1:
        given["nodes"] = _broken_dense(rng, nodes if nodes is not None else np.zeros((2, 3)))
    elif way <= 5:
        name = (rng.choice(names), "free", "nodes", "damping")[way - 2]
        given[name] = rng.choice([*_ODD, *(numbers if name == "free" else ())])
    with suppress(Exception):  # some odd values cannot be pickled
        (folder / "matrices.pickle").write_bytes(pickle.dumps(given))
    return Given(given, rng.choice(("eigen", *_MODELS)))


def _values(rng: random.Random, dense: Any) -> Any:
    """Return a dense matrix with numbers that are wrong, or out of range."""
    n = min(dense.shape)
    if n == 0 or n < max(dense.shape):
        return dense
    i, j, way = rng.randrange(n), rng.randrange(n), rng.randrange(9)
    if way <= 1:
        dense[i, j] = rng.choice(_NUMBERS)
        dense[j, i] = dense[i, j] if way else dense[j, i]
    elif way == 2:
        dense *= rng.choice((1e-300, 1e300, -1.0, 0.0, 1e-160, 1e160))
    elif way == 3:
        dense[i, j] += rng.choice((1.0, 1e9, -1e9, 1e-3))
    elif way <= 5:
        dense[i] *= rng.choice((1e200, 1e-200, -1.0)) if way == 4 else 0.0
        dense[:, i] = dense[i]
    elif way == 6:
        dense = dense[: rng.randrange(n + 1), : rng.randrange(n + 1)]
        dense = dense if dense.size else np.zeros((rng.randrange(3), rng.randrange(3)))
    elif way == 7:
        scale = 10.0 ** np.array([rng.uniform(-150, 150) for _ in range(n)])
        dense = dense * scale * scale[:, None]
    else:
        dense = np.round(dense / np.abs(dense).max(initial=1e-300), rng.randrange(4))
    return dense


def _stored(rng: random.Random, dense: Any) -> Any:
    if rng.random() < 0.25:
        return _broken_dense(rng, dense) if rng.random() < 0.3 else dense
    maker = getattr(sp, f"{rng.choice(_FORMATS)}_{rng.choice(('array', 'matrix'))}")
    return maker(dense)


def _broken_dense(rng: random.Random, dense: Any) -> Any:
    ways: tuple[Callable[[], Any], ...] = (
        lambda: dense.astype(rng.choice(_TYPES)),
        lambda: dense.tolist(),
        lambda: np.ma.masked_array(dense, dense > 0.0),
        lambda: np.asfortranarray(dense)[::-1],
        lambda: dense.reshape(-1),
        lambda: np.asmatrix(dense),
    )
    try:
        return rng.choice(ways)()
    except (TypeError, ValueError):
        return dense


# The index arrays of each format.
_INDEX = {
    "csr": ("indices", "indptr"),
    "csc": ("indices", "indptr"),
    "bsr": ("indices", "indptr"),
    "coo": ("row", "col"),
    "dia": ("offsets",),
}

_SHAPES = [(0, 0), (5, 5), (2, 40), (40, 40), (41, 41), (10**9, 10**9), (3, -1), (1,)]
_SHAPES += [(2**40, 2**40)]


def _broken(rng: random.Random, matrix: Any) -> Any:
    """Return a sparse matrix whose arrays do not fit together, as if overwritten by a program."""
    if not sp.issparse(matrix) or matrix.format not in _INDEX:
        return matrix
    matrix = matrix.copy()
    names = _INDEX[matrix.format]
    name = rng.choice((*names, *names, "data"))
    array = np.array(getattr(matrix, name))
    way = rng.randrange(8)
    if way < 6:
        array = _broken_array(rng, way, array, is_index=name != "data")
    elif way == 6:
        matrix._shape = rng.choice(_SHAPES)
    else:
        flag = rng.choice(("has_sorted_indices", "has_canonical_format"))
        if hasattr(matrix, flag):
            setattr(matrix, flag, rng.choice((True, False)))
        array = array[::-1] if array.ndim == 1 and rng.random() < 0.5 else array
    with suppress(AttributeError, ValueError, TypeError):
        if name in ("row", "col"):
            coords = list(matrix.coords)
            coords[name == "col"] = array
            matrix.coords = tuple(coords)
        else:
            setattr(matrix, name, array)
    return matrix


def _broken_array(rng: random.Random, way: int, array: Any, *, is_index: bool) -> Any:
    """Return an array with one wrong entry, of another length, or of another kind."""
    if way <= 2 and array.size:
        at = rng.randrange(array.size)
        number = rng.choice(_INDICES if is_index else _NUMBERS)
        if is_index and not np.iinfo(array.dtype).min <= number <= np.iinfo(array.dtype).max:
            array = array.astype(np.int64)
        array.reshape(-1)[at] = number
        return array
    if way == 3:
        return array[: rng.randrange(len(array) + 1)]
    if way == 4:
        return np.concatenate([array, array[: rng.choice((1, 2, 3))]])
    if way != 5:
        return array
    made = [array.astype(kind) for kind in (float, object, np.uint8)]
    made += [array.reshape(-1, 1), array[::-1], array.tolist(), None, np.zeros(0, array.dtype)]
    return rng.choice(made)


trial = trials(seeds, make)
