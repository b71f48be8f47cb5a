"""Checks of single arguments, and records that check their fields and have read-only arrays.

Every function takes the argument's name first and returns the value in the form that the rest of
the package works with (`float`, `int`, contiguous native float64 arrays).
"""

from __future__ import annotations

import difflib
import functools
import inspect
import math
import numbers
import operator
import os
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from reprlib import repr as _short
from threading import RLock
from typing import Any, TypeVar, dataclass_transform

import numpy as np
import numpy.typing as npt

from .errors import InputError, InputTypeError

T = TypeVar("T")

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
ComplexArray = npt.NDArray[np.complex128]
FilePath = str | os.PathLike[str]
ArrayPair = tuple[FloatArray, FloatArray]

# Function that takes an argument's name and value, and returns the value to be stored.
Check = Callable[[str, Any], Any]

# Largest magnitude of inputs in SI units: products of up to three of these do not overflow.
HUGE = 1e100

# Largest relative differences that count as rounding errors. ROUNDING: for results in double
# precision, above the sum of some thousand errors of 1e-16. PRINTED: for numbers that were printed
# with ten digits.
ROUNDING, PRINTED = 1e-12, 1e-9


def _unit(unit: str) -> str:
    return f" {unit}" if unit else ""


def real(name: str, value: Any, *, unit: str = "", infinite: bool = False) -> float:
    """Return `value` as a float: a real number, finite unless `infinite` is true.

    Raises
    ------
    InputTypeError
        If `value` is not a real number (a bool, a complex, a string, an array).
    InputError
        If `value` is NaN, or if it is infinite and `infinite` is false.
    """
    if type(value) is float and math.isfinite(value):
        return value  # the common case; the checks below take far longer
    if not isinstance(value, numbers.Real) or isinstance(value, (bool, np.bool_)):
        raise InputTypeError(f"{name} must be a real number, got {_short(value)}")
    try:
        number = float(value)
    except OverflowError:
        raise InputError(f"{name} must be finite, got {_short(value)}") from None
    if math.isnan(number):
        raise InputError(f"{name} must be a number, got nan")
    if math.isinf(number) and not infinite:
        raise InputError(f"{name} must be finite, got {number}{_unit(unit)}")
    return number


def positive(name: str, value: Any, *, unit: str = "", infinite: bool = False) -> float:
    """Return `value` as a float > 0; see `real`."""
    number = real(name, value, unit=unit, infinite=infinite)
    if number <= 0.0:
        raise InputError(f"{name} must be positive, got {number:g}{_unit(unit)}")
    return number


def nonnegative(name: str, value: Any, *, unit: str = "", infinite: bool = False) -> float:
    """Return `value` as a float >= 0; see `real`."""
    number = real(name, value, unit=unit, infinite=infinite)
    if number < 0.0:
        raise InputError(f"{name} must not be negative, got {number:g}{_unit(unit)}")
    return number


def within(
    name: str, value: Any, low: float, high: float = math.inf, *, below: bool = False
) -> float:
    """Return `value` as a float in [`low`, `high`], or in [`low`, `high`) if `below`; see `real`.

    Raises
    ------
    InputError
        If `value` lies outside.
    InputTypeError
        If `value` is not a real number.
    """
    number = real(name, value)
    if not low <= number <= high or (below and number == high):
        to = f"below {high:g}" if below else f"{high:g}"
        span = f"at least {low:g}" if high == math.inf else f"from {low:g} to {to}"
        raise InputError(f"{name} must be {span}, got {number:g}")
    return number


def integer(name: str, value: Any, *, low: int | None = None, high: int | None = None) -> int:
    """Return `value` as an int in [`low`, `high`]; floats and bools are refused.

    Raises
    ------
    InputTypeError
        If `value` is not an integer (2.0 is not: a count that was computed may be 1.9999).
    InputError
        If `value` lies outside the bounds.
    """
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise InputTypeError(f"{name} must be an integer, got {_short(value)}") from None
    if (low is not None and number < low) or (high is not None and number > high):
        span = f"at least {low}" if high is None else f"from {low} to {high}"
        raise InputError(f"{name} must be {span}, got {number}")
    return number


def boolean(name: str, value: Any) -> bool:
    """Return `value` as a bool; anything but a bool is refused."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputTypeError(f"{name} must be True or False, got {_short(value)}")
    return bool(value)


def instance(name: str, value: Any, *kinds: type[Any]) -> Any:
    """Return `value` if it is an instance of one of the classes `kinds`."""
    if not isinstance(value, kinds):
        listed = " or ".join("None" if kind is type(None) else kind.__name__ for kind in kinds)
        raise InputTypeError(f"{name} must be of type {listed}, got {_short(value)}")
    return value


def text(name: str, value: Any) -> str:
    """Return `value` if it is a string."""
    return str(instance(name, value, str))


def texts(name: str, value: Any) -> tuple[str, ...]:
    """Return `value`, a sequence of strings, as a tuple; a string by itself is refused."""
    return instances(name, value, str)


def instances(name: str, value: Any, kind: type[Any]) -> tuple[Any, ...]:
    """Return `value`, a sequence of objects of one class, as a tuple."""
    entries = sequence(name, value)
    return tuple(instance(f"{name}[{i}]", entry, kind) for i, entry in enumerate(entries))


def nearest(value: str, options: Iterable[str]) -> str:
    """Return " (did you mean 'x'?)" for the option most like `value`, or an empty string."""
    found = difflib.get_close_matches(value, list(options), n=1, cutoff=0.5)
    return f" (did you mean {found[0]!r}?)" if found else ""


def spelled(made: Any, module: str) -> Any:
    """Return a public function or class that suggests similar names for misspelt keywords.

    Parameters
    ----------
    made : callable
        Function or class; a class and its methods are changed in place.
    module : str
        Public module in which pickle finds the function.
    """
    if isinstance(made, type):
        for name, of in list(vars(made).items()):
            if inspect.isfunction(of) and (name == "__init__" or not name.startswith("_")):
                setattr(made, name, spelled(of, of.__module__))
            elif isinstance(of, classmethod) and not name.startswith("_"):
                setattr(made, name, classmethod(spelled(of.__func__, module)))
        return made
    parameters = inspect.signature(made).parameters
    if any(one.kind is one.VAR_KEYWORD for one in parameters.values()):
        return made
    known = [name for name in parameters if name not in ("self", "cls")]

    @functools.wraps(made)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name in kwargs:
            if name not in parameters:
                called = made.__qualname__.removesuffix(".__init__")
                hint = nearest(name, known) or f"; it has {', '.join(known) or 'none'}"
                raise InputTypeError(f"{called} has no keyword {name!r}{hint}")
        return made(*args, **kwargs)

    checked.__module__ = module
    return checked


def called(value: str, options: Iterable[str]) -> str | None:
    """Return the option equal to `value`, else the only one that differs in case alone, or None."""
    same = [option for option in options if option.casefold() == value.casefold()]
    return value if value in same else same[0] if len(same) == 1 else None


def choice(name: str, value: Any, options: Sequence[str]) -> str:
    """Return `value` if it is one of `options`; the error names the most similar option."""
    listed = ", ".join(repr(option) for option in options)
    if not isinstance(value, str):
        raise InputTypeError(f"{name} must be one of {listed}, got {_short(value)}")
    if value not in options:
        raise InputError(f"{name} must be one of {listed}, got {value!r}{nearest(value, options)}")
    return value


def file_path(name: str, value: Any) -> Path:
    """Return `value`, a str or an os.PathLike, as a path.

    Raises
    ------
    InputTypeError
        If `value` is neither.
    InputError
        If `value` has a null character, or a character that the system cannot write in a file's
        name.
    """
    if not isinstance(value, (str, os.PathLike)):
        raise InputTypeError(f"{name} must be a path, got {_short(value)}")
    path = os.fsdecode(value)
    try:
        if "\0" in path:
            raise ValueError
        os.fsencode(path)
    except ValueError:  # also raised by os.fsencode
        raise InputError(f"{name} must be a path, got {path!r}, which no file can have") from None
    return Path(path)


@contextmanager
def written_file(path: Any, name: str = "path") -> Iterator[Path]:
    """Yield the path of a file or folder to write; failures within the context raise InputError.

    Raises
    ------
    InputTypeError
        If `path` is no path; see `file_path`.
    InputError
        If the file or folder cannot be written to.
    """
    file = file_path(name, path)
    try:
        yield file
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{name}={str(file)!r} cannot be written to: {reason}") from None


def sequence(name: str, value: Any) -> list[Any]:
    """Return the entries of an iterable as a list; a text or a mapping is refused.

    Raises
    ------
    InputTypeError
    """
    try:
        if isinstance(value, (str, bytes, Mapping)) or np.ma.is_masked(value):
            raise TypeError
        return list(value)
    except TypeError:
        raise InputTypeError(f"{name} must be a list of values, got {_short(value)}") from None


def finite_array(
    name: str,
    value: Any,
    *,
    shape: Sequence[int | None] | None = None,
    unit: str = "",
    most: float = math.inf,
) -> FloatArray:
    """Return `value` as a C-contiguous native float64 array without NaN or infinity.

    Integer, float32, big-endian and strided arrays are converted; an array in the right form
    already is returned as it is, not copied.

    Parameters
    ----------
    shape : sequence of int or None, optional
        Required shape; None stands for any length of an axis.
    most : float, optional
        Largest magnitude allowed.

    Raises
    ------
    InputTypeError
        If `value` is complex, boolean, text, masked or not an array of numbers at all.
    InputError
        If the shape is wrong or an entry is not finite (the first such entry is named), or too
        large.
    """
    given = _array(name, value, "an array of real numbers", "iuf", shape)
    with np.errstate(over="ignore"):  # numbers beyond float64 are reported below
        array = np.asarray(given, dtype=np.float64, order="C")
    if array.size and not np.isfinite(array).all():
        bad = np.argwhere(~np.isfinite(array))
        first = tuple(int(i) for i in bad[0])
        where = f"{name}[{', '.join(map(str, first))}]" if first else name
        which = f"{where} is {array[first]}{_unit(unit)}, one of {len(bad)} that are not"
        raise InputError(f"{name} must be finite: {which}")
    if most < math.inf and float(np.abs(array).max(initial=0.0)) > most:
        raise InputError(f"{name} must not exceed {most:g}{_unit(unit)} to be computed with")
    return array


def unit_vector(name: str, value: Any) -> FloatArray:
    """Return `value` (3,) scaled to length one.

    Raises
    ------
    InputError
        If `value` has another shape, is not finite, or is zero.
    """
    vector = finite_array(name, value, shape=(3,))
    scale = float(np.abs(vector).max())
    if scale == 0.0:
        raise InputError(f"{name} must not be the zero vector")
    # Scaled first: the square of 1e-200 would underflow.
    scaled = vector / scale
    return scaled / np.linalg.norm(scaled)


def place(name: str, value: Any) -> FloatArray:
    """Return `value` as a point, shape (3,), m; distances between such points do not overflow.

    Raises
    ------
    InputError
        If `value` has another shape, is not finite, or a coordinate exceeds 1e100 m.
    """
    return finite_array(name, value, shape=(3,), unit="m", most=HUGE)


def plain(vector: FloatArray) -> str:
    """Return a point or direction as text, "(0.01, 0, 0)", with 0 for rounding errors."""
    noise = 1e-9 * np.abs(vector).max()
    return f"({', '.join(f'{x if abs(x) > noise else 0.0:.6g}' for x in vector)})"


def integers(
    name: str, value: Any, what: str, *, shape: Sequence[int | None] | None = None
) -> IntArray:
    """Return `value` as a new array of integers with the given `shape`; None: any length.

    `what`: description of `value` for messages.

    Raises
    ------
    InputTypeError, InputError
    """
    return _array(name, value, what, "iu", shape).astype(np.int64)


def inertia_tensor(name: str, value: Any, *, most: float) -> FloatArray:
    """Return the inertia tensor, kg m², shape (3, 3), given as a tensor or as three moments.

    Raises
    ------
    InputTypeError, InputError
        If no body can have such a tensor, or an entry exceeds `most`.
    """
    given = finite_array(name, value, unit="kg m²", most=most)
    if given.shape not in ((3,), (3, 3)):
        raise InputError(f"{name} must have shape (3,) or (3, 3), got {given.shape}")
    tensor = np.diag(given) if given.ndim == 1 else given
    largest = float(np.abs(tensor).max())
    if np.abs(tensor - tensor.T).max() > PRINTED * largest:
        raise InputError(f"{name} must be symmetric, got {given.tolist()}")
    low, middle, high = np.linalg.eigvalsh(tensor).tolist()
    if low < -PRINTED * largest or high > (1.0 + PRINTED) * (low + middle):
        got = f"principal moments {low:g}, {middle:g}, {high:g} kg m² are impossible"
        raise InputError(f"{name}: {got}: none may be negative, or exceed the sum of the other two")
    return tensor


def node_ids(name: str, value: Any, count: int | None, what: str = "node") -> IntArray:
    """Return `value` as sorted unique node numbers in [0, `count`); bools are refused.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : array_like of int
    count : int or None
        Number of nodes; None if `value` has labels, which may be any integers.
    what : str, optional
        Noun for messages.

    Raises
    ------
    InputTypeError
        If the entries are not integers.
    InputError
        If there are no numbers, or a number is out of range (negative ones do not count backwards).
    """
    array = np.atleast_1d(integers(name, value, f"integer {what} numbers"))
    if array.ndim != 1 or not array.size:
        raise InputError(f"{name} must be a flat list of {what} numbers, got shape {array.shape}")
    low, high = int(array.min()), int(array.max())
    if count is not None and (low < 0 or high >= count):
        wrong = low if low < 0 else high
        raise InputError(f"{name} must be from 0 to {count - 1}, got {what} {wrong}")
    return np.unique(array)


def _array(
    name: str, value: Any, what: str, kinds: str, shape: Sequence[int | None] | None
) -> npt.NDArray[Any]:
    """Return `value` as an array; refuse a dtype whose kind is not in `kinds`, and other shapes."""
    if np.ma.is_masked(value):
        raise InputTypeError(f"{name} has masked entries; fill or remove them first")
    try:
        array = np.asarray(value)
    except (ValueError, TypeError) as error:
        raise InputTypeError(f"{name} must be {what}: {error}") from None
    if array.size and array.dtype.kind not in kinds:
        raise InputTypeError(f"{name} must be {what}, got {_short(value)}")
    wanted = array.shape if shape is None else shape
    if len(wanted) != array.ndim or any(
        size not in (None, length) for size, length in zip(wanted, array.shape, strict=True)
    ):
        sizes = str(tuple(wanted)).replace("None", "any")
        raise InputError(f"{name} must have shape {sizes}, got {array.shape}")
    return array


def writable_folder(path: FilePath) -> Path:
    """Make a folder unless it exists, and check that files can be made in it.

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    with written_file(path, "folder") as folder:
        folder.mkdir(parents=True, exist_ok=True)
        trial = folder / ".aoimpact"
        trial.touch()
        trial.unlink()
    return folder


# ------------------------------------------------------------------------------- records


def checked(record: Any, /, **checks: Check | tuple[type[Any], ...]) -> None:
    """Check the fields of a frozen dataclass.

    `checks`: for each field, the permitted classes, or a function that returns the value to store.
    """
    for name, check in checks.items():
        value = getattr(record, name)
        if isinstance(check, tuple):
            instance(name, value, *check)
        else:
            object.__setattr__(record, name, check(name, value))


def read_only(array: FloatArray) -> FloatArray:
    """Return an array after making it read-only."""
    array.flags.writeable = False
    return array


@dataclass_transform(frozen_default=True, eq_default=False)
def record(made: type[T]) -> type[T]:
    """Return a frozen dataclass whose objects compare by identity, since arrays lack a plain ==."""
    return dataclass(frozen=True, eq=False)(made)


class Frozen:
    """Base class that makes the arrays of a dataclass, and of its tuples and mappings, read-only.

    NumPy makes unpickled and copied arrays writeable, so they are made read-only again. A derived
    class with its own `__post_init__` must call this class's method at the end.
    """

    def __post_init__(self) -> None:
        _freeze(vars(self))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        Frozen.__post_init__(self)


def _freeze(items: tuple[Any, ...] | dict[Any, Any]) -> None:
    for item in items.values() if isinstance(items, dict) else items:
        if isinstance(item, np.ndarray):
            item.flags.writeable = False
        elif isinstance(item, tuple | dict):
            _freeze(item)


class Kept:
    """Cache of the `most` most recently used results, by key."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._found: dict[Hashable, Any] = {}
        self._lock = RLock()

    def __reduce__(self) -> Any:
        """Copy and pickle the cache without its results."""
        return Kept, (self._most,)

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return the result with a key; if there is none, call `make` and keep its result."""
        with self._lock:
            found: T = self._found.pop(key) if key in self._found else make()
            self._found[key] = found
            while len(self._found) > self._most:
                del self._found[next(iter(self._found))]
        return found


class Found(Mapping[str, Any]):
    """Mapping of names to values, each of which is computed when it is first read.

    Parameters
    ----------
    names : callable
        Function that returns all names.
    find : callable
        Function that returns the value of a name, or raises KeyError for an unknown name.
    known : mapping, optional
        Values that are known already. Their names come last if `names` does not return them.
    """

    def __init__(
        self,
        names: Callable[[], Iterable[str]],
        find: Callable[[str], Any],
        known: Mapping[str, Any] | None = None,
    ) -> None:
        self._names, self._find, self._found = names, find, dict(known or {})

    def __getitem__(self, name: str) -> Any:
        if name not in self._found:
            self._found[name] = self._find(name)
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._names(), *self._found]))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        return f"<{', '.join(self)}: each by its name>"

    def __reduce__(self) -> Any:
        return dict, (dict(self),)
