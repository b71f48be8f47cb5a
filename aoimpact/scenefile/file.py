"""Scene files: impacts and scenes in TOML; errors name the line."""

from __future__ import annotations

import copy
import itertools
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..accuracy import AccelerationAt
from ..base import (
    AOImpactError,
    FilePath,
    FloatArray,
    InputError,
    InputTypeError,
    SceneFileError,
    checked,
    file_path,
    instance,
    texts,
)
from ..contact import ContactPoint
from ..impact import simulate
from ..results import COLUMNS, Result, Run
from .binding import Call, calls
from .lines import Place, holds, line_of
from .tables import SceneBinder, place_of

# Pattern of tomllib's message for a text that is not TOML.
_UNREADABLE = re.compile(r"(.*) \(at line (\d+), column (\d+)\)", re.DOTALL)

# Pattern of the argument's name at the beginning of a message: "n must be ...", "fixed[0]: ...".
_ARGUMENT = re.compile(r"(\w+)(?:\[(\d+)\])?")

# Maximum number of a file's problems in the message: as many as fit on a screen.
_SHOWN = 20

# Maximum number of objects kept for the next runs of a sweep; otherwise all meshes of the sweep
# would stay in memory.
_MOST_KEPT = 8


def read_scene(path: FilePath) -> SceneFile:
    """Read a scene file and check all of its names and types.

    Parameters
    ----------
    path : path
        TOML; docs/scene-files.md lists what it may hold. Paths in it are relative to its folder.

    Raises
    ------
    SceneFileError
        If the file cannot be read or is wrong; the message lists every problem with its line.

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
        text = file.read_text(encoding="utf-8-sig")  # with or without a byte order mark
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = _UNREADABLE.fullmatch(str(error))
        where, what = (f":{found[2]}:{found[3]}", found[1]) if found else ("", str(error))
        raise SceneFileError(f"{file}{where}: is not TOML: {what}") from None
    except (OSError, ValueError, RecursionError) as error:  # also if not UTF-8 or nested too deeply
        raise SceneFileError(f"{file}: cannot be read: {error}") from None
    return SceneFile(file, data, text)


@dataclass(frozen=True, eq=False, repr=False)
class SceneFile:
    """A scene file that has been read.

    Attributes
    ----------
    path : Path
    data : dict
        Content of the file as tomllib gives it.
    text : str
        Text of the file; errors take their line numbers from it.

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
    _kept: dict[str, Any] = field(default_factory=dict)
    _bound: SceneBinder = field(init=False)

    def __post_init__(self) -> None:
        checked(self, path=file_path, data=(Mapping,), text=(str,))
        bound = SceneBinder(self.data, self.path.parent)
        object.__setattr__(self, "_bound", bound)
        problems: list[Any] = list(bound.problems)
        if not any(place[:1] in ((), ("sweep",)) for place, _ in problems):
            problems += self._sweep_problems()
        self._refuse(problems)

    def __repr__(self) -> str:
        return f"SceneFile({str(self.path)!r})"

    @property
    def title(self) -> str:
        """The file's title; by default, its name without suffix."""
        return str(self.data.get("title", self.path.stem))

    @property
    def kind(self) -> str:
        """Kind of the file: "impact" of two bodies, or "scene" of any number."""
        return "impact" if "impact" in self.data else "scene"

    @property
    def reported(self) -> tuple[str, ...]:
        """Names of the numbers that the file reports; default: results of each contact."""
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
        """The argument `grid` of `sweep`: values by place in the file; {} without [sweep]."""
        sweep = self._bound.bound.get("sweep")
        return {} if sweep is None else dict(self._made(sweep, {}))

    @property
    def swept(self) -> tuple[str, ...]:
        """Names of the numbers that the sweep keeps; by default `reported`."""
        return tuple(self.data.get("sweep", {}).get("keep", self.reported))

    @property
    def members(self) -> tuple[str, ...]:
        """Names of the bodies that take part: in the scene or, for an impact, in [bodies]."""
        return tuple(name for name, _ in self._bound.taking)

    def _refuse(self, problems: Sequence[tuple[Place, str] | SceneFileError]) -> None:
        """Raise an error that lists all problems with their lines, if there are any."""
        shown = problems[:_SHOWN]
        lines = [self._at(*of) if isinstance(of, tuple) else str(of) for of in shown]
        if len(problems) > _SHOWN:
            lines.append(f"{self.path}: and {len(problems) - _SHOWN} more")
        if lines:
            raise SceneFileError("\n".join(lines))

    def _sweep_problems(self) -> Iterator[Any]:
        """Yield the problems of [sweep], and problems that its values cause elsewhere in the file.

        Items: pairs of place and message, or `SceneFileError`.
        """
        before: dict[str, Any] = {}
        try:
            grid = self.grid
        except SceneFileError as error:
            yield error
            return
        for name, values in grid.items():
            told: dict[str, None] = {}
            kinds = {type(of) if isinstance(of, int | float) else repr(of): of for of in values}
            for value in kinds.values():
                try:
                    found = SceneBinder(self._with(before | {name: value}), self.path.parent)
                    new = [of for of in found.problems if of not in self._bound.problems]
                    told |= {text: None for _, text in new}
                except InputError as error:
                    told[str(error)] = None
            if not told:
                before[name] = values[0]
            yield from ((self._bound.swept[name], text) for text in told)

    def replaced(self, values: Mapping[str, Any]) -> SceneFile:
        """Return the file without its sweep and with other values at the given places.

        Parameters
        ----------
        values : mapping
            Values by dotted place, such as "bodies.ball.mass", "scene.contacts.0.gap" or
            "scene.bodies.ball.velocity". A place that does not begin with a top-level table, such
            as "velocity", is in [impact] or [scene].

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
        texts("values", instance("values", values, Mapping).keys())
        with self._located():
            data = self._with(values)
        return SceneFile(self.path, data, self.text, self._kept)

    def _with(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return a copy of the data without the sweep and with `values` at their dotted places."""
        data = copy.deepcopy({name: of for name, of in self.data.items() if name != "sweep"})
        places = {name: place_of(self.data, self.kind, name) for name in values}
        for (name, place), (other, longer) in itertools.permutations(places.items(), 2):
            if place == longer[: len(place)]:
                raise InputError(f"{other} is in the same place as {name!r}: keep one of them")
        for name, place in places.items():
            inside: Any = data
            for part in place[:-1]:
                inside = inside[part]
            value = values[name]
            inside[place[-1]] = np.asarray(value).tolist() if hasattr(value, "dtype") else value
        return data

    def case(self) -> Any:
        """Build the bodies, and return a case of `simulate_many`.

        Raises
        ------
        SceneFileError
            If a value is invalid; the message has the line.

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
        case, made = self._bound.bound[self.kind], dict[int, Any]()
        problems: dict[int, SceneFileError] = {}
        for call in calls(case):  # quick calls first, to report all their errors
            late = call.keep or "self" in call.arguments
            if not late and all(id(of) in made for of in calls(call.arguments)):
                try:
                    self._made(call, made)
                except SceneFileError as error:
                    problems[id(call)] = error
        self._refuse(list(problems.values()))
        return self._made(case, made)

    def _made(self, node: Any, made: dict[int, Any]) -> Any:
        """Return a value with each call replaced by its result; `made`: results by id of a call."""
        if isinstance(node, Mapping):
            return {key: self._made(value, made) for key, value in node.items()}
        if isinstance(node, list | tuple):
            return type(node)(self._made(value, made) for value in node)
        if not isinstance(node, Call):
            return node
        if id(node) not in made:
            key = repr(node) if node.keep else ""
            found = self._kept.pop(key, None)
            if found is None:
                arguments = self._made(node.arguments, made)
                with self._located(*node.place):
                    found = node.function(**arguments)
            if key:
                self._kept[key] = found  # moved to the end: most recently used
                if len(self._kept) > _MOST_KEPT:
                    del self._kept[next(iter(self._kept))]
            made[id(node)] = found
        return made[id(node)]

    def simulate(self) -> Result | Run:
        """Build the bodies and run the file; return a Result for an impact, a Run for a scene.

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
            scene, keywords = case
            run: Run = scene.simulate(**keywords)
            return run

    def probes(self, result: Run) -> dict[str, FloatArray]:
        """Return the history of each probe in the file, at the times of a result, in SI units.

        Parameters
        ----------
        result : Run
            Result of `simulate`.

        Returns
        -------
        dict of str to ndarray, shape (times,)

        Raises
        ------
        InputError, InputTypeError
            If `result` is not a result of this file, or a probe is invalid; the message has the
            line.

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
        instance("result", result, Run)
        if len(result.bodies) != len(self.members):
            raise InputError(
                f"result must have the file's {len(self.members)} bodies, got {len(result.bodies)}"
            )
        probes = self._bound.bound[self.kind].arguments.get("probes") or {}
        found = {}
        for name, sensor in self._made(probes, {}).items():
            number = self.members.index(self.data[self.kind]["probes"][name]["body"])
            if not isinstance(sensor, ContactPoint | AccelerationAt):
                found[name] = sensor.quantity(sensor.body, number).history(result, result.t)[0]
                continue
            probe = result.bodies[number].probe(sensor.point, sensor.direction, times=result.t)
            if isinstance(sensor, ContactPoint):
                found[name] = probe.displacement
            else:
                found[name] = probe.filtered(cfc=sensor.cfc, corner=sensor.corner).acceleration
        return found

    # ------------------------------------------------------------------- error messages

    def _at(self, place: Place, message: str) -> str:
        line = line_of(self.text, place)
        where = str(self.path) if line is None else f"{self.path}:{line}"
        dotted = ".".join(map(str, place)) + ": " if place else ""
        return f"{where}: {dotted}{message}"

    @contextmanager
    def _located(self, *place: str | int) -> Iterator[None]:
        """Add the line in the file to errors; errors of input become `SceneFileError`."""
        try:
            yield
        except SceneFileError:
            raise
        except (InputError, InputTypeError) as error:
            # The argument named at the beginning of a message is usually a key of the table.
            named = _ARGUMENT.match(str(error))
            word, number = named.groups() if named else ("", None)
            finer: list[Place] = [(*place, word, int(number or 0)), (*place, word), place]
            at = next(one for one in finer[number is None :] if holds(self.data, one))
            raise SceneFileError(self._at(at, str(error))) from error
        except AOImpactError as error:
            raise type(error)(self._at(place, str(error))) from error
