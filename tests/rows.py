"""Statements over many rows, each as one test."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any


def each(names: str, rows: Iterable[Any]) -> Callable[[Any], Any]:
    """Call a test once per row, as `pytest.mark.parametrize` does, but as a single test.

    All rows share the test's fixtures, except that each has a `tmp_path` of its own. The traceback
    of a failure ends with its row.
    """
    keys, rows = names.split(", "), list(rows)

    def decorate(test: Any) -> Any:
        @functools.wraps(test)
        def run(**fixtures: Any) -> None:
            assert rows
            for index, row in enumerate(rows):
                given, own = dict(zip(keys, row if len(keys) > 1 else [row], strict=True)), fixtures
                if "tmp_path" in fixtures:
                    own = fixtures | {"tmp_path": fixtures["tmp_path"] / str(index)}
                    own["tmp_path"].mkdir()
                try:
                    test(**own, **given)
                except BaseException as failure:
                    failure.add_note(f"Row: {given}")
                    raise

        signature = inspect.signature(test)
        left = [of for name, of in signature.parameters.items() if name not in keys]
        run.__signature__ = signature.replace(parameters=left)  # type: ignore[attr-defined]
        return run

    return decorate
