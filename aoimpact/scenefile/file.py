"""Scene files: impacts and scenes in TOML, with errors by line."""

from __future__ import annotations

import copy
import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..accuracy import keeper
from ..base import (
    AOImpactError,
    FloatArray,
    InputError,
    InputTypeError,
    SceneFileError,
    checked,
    choice,
    file_path,
    texts,
)
from ..impact import simulate
from ..results import COLUMNS, Result, Run
from .build import Builder, Kept, member_name
from .names import SCENE_FILE
from .probes import read_probe
from .ranges import at_place, check_apart, grid_of, sweep_problems
from .toml_lines import Place, holds, line_of

# Message of tomllib for a text that is not TOML.
_UNREADABLE = re.compile(r"(.*) \(at line (\d+), column (\d+)\)", re.DOTALL)

# Problems of a file that are shown: as many as fit on a screen.
_SHOWN = 20


def read_scene(path: str | os.PathLike[str]) -> SceneFile:
    """Read a scene file and check all of its names and types.

    Parameters
    ----------
    path : path
        TOML; docs/scene-files.md lists what it may hold. Paths in it are relative to its folder.

    Raises
    ------
    SceneFileError
        If the file cannot be read or is wrong: every problem with its line.

    Examples
    --------
    >>> import pathlib
    >>> import tempfile
    >>> text = '''
    ... [bodies.ball]
    ... mass = 0.03
    ...
    ... [impact]
    ... projectile = "ball"
    ... target = "ball"
    ... velocity = 1.0
    ... duration = 1e-3
    ... law = { type = "Hertz", k = 1e9 }
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "two.toml")
    ...     _ = path.write_text(text)
    ...     hit = ao.read_scene(path).simulate()
    >>> round(hit.restitution, 6)
    1.0
    """
    file = file_path("path", path)
    try:
        text = file.read_text(encoding="utf-8-sig")  # with a mark at its start, or without
    except OSError as error:
        raise SceneFileError(f"{file}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise SceneFileError(f"{file}: is not UTF-8 text ({error.reason})") from None
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = _UNREADABLE.fullmatch(str(error))
        where, what = (f":{found[2]}:{found[3]}", found[1]) if found else ("", str(error))
        raise SceneFileError(f"{file}{where}: is not TOML: {what}") from None
    except (ValueError, RecursionError) as error:  # numbers of thousands of digits, deep nesting
        raise SceneFileError(f"{file}: cannot be read: {error}") from None
    return SceneFile(file, data, text)


@dataclass(frozen=True, eq=False, repr=False)
class SceneFile:
    """A scene file that has been read.

    Attributes
    ----------
    path : Path
    data : dict
        As tomllib gives it.
    text : str
        All of it, by which errors name lines.

    Examples
    --------
    >>> import pathlib
    >>> import tempfile
    >>> text = '''
    ... [bodies.ball]
    ... mass = 0.03
    ...
    ... [impact]
    ... projectile = "ball"
    ... target = "ball"
    ... velocity = 1.0
    ... duration = 1e-3
    ... law = { type = "Hertz", k = 1e9 }
    ...
    ... [sweep.over]
    ... velocity = [0.5, 1.0]
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "two.toml")
    ...     _ = path.write_text(text)
    ...     file = ao.read_scene(path)
    ...     table = ao.sweep(file, file.grid)
    >>> table.shape
    (2,)
    """

    path: Path
    data: Mapping[str, Any]
    text: str
    _kept: Kept = field(default_factory=Kept)

    def __post_init__(self) -> None:
        checked(self, path=file_path, data=(Mapping,), text=(str,))
        self.check()

    def __repr__(self) -> str:
        return f"SceneFile({str(self.path)!r})"

    @property
    def title(self) -> str:
        """The file's title, or its name."""
        return str(self.data.get("title", self.path.stem))

    @property
    def kind(self) -> str:
        """Kind of the file: "impact" of two bodies, or "scene" of any number."""
        return "impact" if "impact" in self.data else "scene"

    @property
    def reported(self) -> tuple[str, ...]:
        """Names of the numbers that the file reports; by default those of each contact."""
        reported = self.data[self.kind].get("report")
        if reported is not None:
            return tuple(reported)
        if self.kind == "impact":
            return COLUMNS
        count = len(self.data["scene"].get("contacts", ()))
        return tuple(
            f"contacts.{i}.{name}" for i in range(count) for name in ("peak_force", "impulse")
        )

    @property
    def grid(self) -> dict[str, list[Any]]:
        """The grid of [sweep] as `sweep` takes it: values by place; empty without such a table."""
        return grid_of(self.data["sweep"]["over"]) if "sweep" in self.data else {}

    @property
    def swept(self) -> tuple[str, ...]:
        """Names of the numbers that the sweep keeps: those reported if it names none."""
        return tuple(self.data.get("sweep", {}).get("keep", self.reported))

    @property
    def members(self) -> tuple[tuple[str, str], ...]:
        """Name of the output files of each body, and its name in [bodies].

        Its name in its scene; in an impact that in [bodies], or its role if both bodies are one.
        """
        table = self.data[self.kind]
        if self.kind == "impact":
            roles = ("projectile", "target")
            alike = table["projectile"] == table["target"]
            return tuple((role if alike else table[role], table[role]) for role in roles)
        return tuple((member_name(member), member["body"]) for member in table["bodies"])

    def has_mesh(self, body: str) -> bool:
        """True if a body of [bodies] is made of finite elements.

        :meta private:
        """
        return "mesh" in self.data["bodies"][choice("body", body, tuple(self.data["bodies"]))]

    def check(self) -> None:
        """Refuse unknown names, missing keys and wrong types.

        Raises
        ------
        SceneFileError
            With the line of each.

        :meta private:
        """
        found = list(SCENE_FILE.problems(self.data, (), self.data))
        if not found and "sweep" in self.data:
            found = list(sweep_problems(self.data, self.kind))
        if found:
            lines = [self._at(*problem) for problem in found[:_SHOWN]]
            if len(found) > _SHOWN:
                lines.append(f"{self.path}: and {len(found) - _SHOWN} more")
            raise SceneFileError("\n".join(lines))
        with self._located(self.kind, "report"):
            if self.reported:
                keeper(self.reported)
        with self._located("sweep", "keep"):
            if self.swept:
                keeper(self.swept)

    def replaced(self, values: Mapping[str, Any]) -> SceneFile:
        """Return the file with other values at dotted places, and without its sweep.

        Parameters
        ----------
        values : mapping
            By place, such as "bodies.ball.mass", "scene.contacts.0.gap" or "scene.bodies.ball.
            velocity"; what begins with no table of the file is in its impact or scene: "velocity".

        Raises
        ------
        SceneFileError
            If there is no such place, or the value is of the wrong type.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> text = '''
        ... [bodies.ball]
        ... mass = 0.03
        ... [impact]
        ... projectile = "ball"
        ... target = "ball"
        ... velocity = 1.0
        ... law = { type = "Hertz", k = 1e9 }
        ... '''
        >>> path = pathlib.Path(tempfile.mkdtemp(), "two.toml")
        >>> _ = path.write_text(text)
        >>> file = ao.read_scene(path)
        >>> heavier = file.replaced({"bodies.ball.mass": 0.2})
        """
        if not isinstance(values, Mapping):
            raise InputTypeError(f"values must be a dict of places and values, got {values!r}")
        texts("values", values.keys())
        data = copy.deepcopy({name: of for name, of in self.data.items() if name != "sweep"})
        places = [name.split(".") for name in values]
        for number, (name, value) in enumerate(values.items()):
            try:
                check_apart(self.data, self.kind, places[: number + 1])
                table, last = at_place(data, self.kind, places[number])
            except InputError as error:
                raise SceneFileError(f"{self.path}: {name}: {error}") from None
            table[last] = np.asarray(value).tolist() if hasattr(value, "dtype") else value
        return SceneFile(self.path, data, self.text, self._kept)

    def case(self) -> Any:
        """Build the bodies, and return a case of `simulate_many`.

        Raises
        ------
        SceneFileError
            If a value makes no sense, with its line.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> text = '''
        ... [bodies.ball]
        ... mass = 0.03
        ... [impact]
        ... projectile = "ball"
        ... target = "ball"
        ... velocity = 1.0
        ... law = { type = "Hertz", k = 1e9 }
        ... '''
        >>> path = pathlib.Path(tempfile.mkdtemp(), "two.toml")
        >>> _ = path.write_text(text)
        >>> file = ao.read_scene(path)
        >>> results = ao.simulate_many([file.case()])
        """
        builder = Builder(self.data, self.path.parent, self._kept, self._located)
        return builder.impact() if self.kind == "impact" else builder.scene()

    def simulate(self) -> Result | Run:
        """Build the scene and run it; a Result of an impact, a Run of a scene.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> text = '''
        ... [bodies.ball]
        ... mass = 0.03
        ... [impact]
        ... projectile = "ball"
        ... target = "ball"
        ... velocity = 1.0
        ... law = { type = "Hertz", k = 1e9 }
        ... '''
        >>> path = pathlib.Path(tempfile.mkdtemp(), "two.toml")
        >>> _ = path.write_text(text)
        >>> file = ao.read_scene(path)
        >>> round(file.simulate().restitution, 6)
        1.0
        """
        case = self.case()
        with self._located(self.kind):
            if self.kind == "impact":
                return simulate(**case)
            scene, duration = case
            run: Run = scene.simulate(duration=duration)
            return run

    def probes(self, result: Run) -> dict[str, FloatArray]:
        """Return what each of the file's probes reads over the times of a result, in SI units.

        Parameters
        ----------
        result : Run
            From `simulate`.

        Returns
        -------
        dict of str to ndarray, shape (times,)

        Raises
        ------
        InputError, InputTypeError
            If it is not a result of this file; with the line if a probe makes no sense.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> text = '''
        ... [bodies.ball]
        ... mass = 0.03
        ... [impact]
        ... projectile = "ball"
        ... target = "ball"
        ... velocity = 1.0
        ... law = { type = "Hertz", k = 1e9 }
        ... '''
        >>> path = pathlib.Path(tempfile.mkdtemp(), "two.toml")
        >>> _ = path.write_text(text)
        >>> file = ao.read_scene(path)
        >>> file.probes(file.simulate())
        {}
        """
        names = [member[1 if self.kind == "impact" else 0] for member in self.members]
        if not isinstance(result, Run):
            raise InputTypeError(f"result must come from simulate(), got {result!r}")
        if len(result.bodies) != len(names):
            raise InputError(f"result has {len(result.bodies)} bodies, and the file {len(names)}")
        found = {}
        for name, wanted in self.data[self.kind].get("probes", {}).items():
            with self._located(self.kind, "probes", name):
                body = result.bodies[names.index(wanted["body"])]
                found[name] = read_probe(body, wanted, result.t)
        return found

    # ------------------------------------------------------------------------- messages

    def _at(self, place: Place, message: str) -> str:
        line = line_of(self.text, place)
        where = str(self.path) if line is None else f"{self.path}:{line}"
        dotted = ".".join(map(str, place)) + ": " if place else ""
        return f"{where}: {dotted}{message}"

    @contextmanager
    def _located(self, *place: str | int) -> Iterator[None]:
        """Add the line to errors of bad input; other errors keep their class."""
        try:
            yield
        except SceneFileError:
            raise
        except (InputError, InputTypeError) as error:
            # The argument that a message begins with is a key of the table more often than not.
            word = str(error).partition(" ")[0].partition("=")[0].rstrip(":")
            finer = (*place, word) if holds(self.data, (*place, word)) else place
            raise SceneFileError(self._at(finer, str(error))) from error
        except AOImpactError as error:
            raise type(error)(self._at(place, str(error))) from error
