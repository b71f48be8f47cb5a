"""The package's exceptions and its one warning.

Each exception is also the built-in kind that a caller expects, so that ``except ValueError``
works for whoever has never heard of `AOImpactError`.
"""

from __future__ import annotations

__all__ = [
    "AOImpactError",
    "AOImpactWarning",
    "ConvergenceError",
    "InputError",
    "InputTypeError",
    "MeshError",
    "SingularError",
]


class AOImpactError(Exception):
    """Base of every error that this package raises on purpose."""


class InputError(AOImpactError, ValueError):
    """An argument has a value that cannot be used."""


class InputTypeError(AOImpactError, TypeError):
    """An argument is of a type that cannot be used."""


class MeshError(InputError):
    """A mesh cannot be read or cannot be computed with."""


class SingularError(AOImpactError, RuntimeError):
    """A matrix that has to be inverted is singular: a mechanism, or a body that is not held."""


class ConvergenceError(AOImpactError, RuntimeError):
    """An iteration did not reach its tolerance."""


class AOImpactWarning(UserWarning):
    """Something looks wrong, but may be meant."""


# --- The codes of the C core: one table, code -> exception (function `core_error`). ---
