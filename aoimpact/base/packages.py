"""Packages that not everyone has installed."""

from __future__ import annotations

import importlib
from typing import Any

from .errors import MissingPackageError


def optional_package(name: str, what: str, otherwise: str = "") -> Any:
    """Import a package that `what` needs.

    Parameters
    ----------
    name : str
        Name of the module, of the package for pip, and of an extra of aoimpact.
    what : str
        The function that needs it, such as "to_dataframe".
    otherwise : str, optional
        The alternative, such as "take .to_csv(path)".

    Raises
    ------
    MissingPackageError
        If it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        more = f", or {otherwise}" if otherwise else ""
        raise MissingPackageError(
            f"{what} needs {name}, which is not installed: pip install {name}{more}"
        ) from None
