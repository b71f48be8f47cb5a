"""The package as a whole: its name, the names it promises, how its modules hang together."""

from __future__ import annotations

import inspect
import os
import pickle
import re
import subprocess
import sys
import tomllib
from functools import cached_property
from importlib import metadata
from pathlib import Path

import pytest

import aoimpact as ao

PACKAGE = Path(str(ao.__file__)).parent


def test_version_is_that_of_the_distribution() -> None:
    assert ao.__version__ == metadata.version("aoimpact")
    assert metadata.metadata("aoimpact")["Requires-Python"] == ">=3.11"


def test_types_are_published() -> None:
    assert (PACKAGE / "py.typed").is_file()
    assert (PACKAGE / "_core.pyi").is_file()


def test_command_is_installed() -> None:
    (command,) = metadata.entry_points(group="console_scripts", name="aoimpact")
    assert callable(command.load())


@pytest.mark.slow
def test_examples_of_the_readme_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = Path(__file__).parents[2].joinpath("README.md").read_text("utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    hit = names["hit"]
    assert isinstance(hit, ao.Result)
    (shown,) = re.findall(r"^peak force .*$", text, re.M)
    (printed,) = re.findall(r"^ *(peak force .*)$", str(hit), re.M)
    number = re.compile(r"\d+(?:\.\d+)?")
    assert number.sub("#", shown) == number.sub("#", printed)
    # Processors round differently, and may end with other models: each answer is within the sum of
    # both claims of the other.
    force, error, *_, time, of_time = map(float, number.findall(shown))
    found, found_error, *_, found_time, of_found_time = map(float, number.findall(printed))
    assert found == pytest.approx(force, rel=(error + found_error) / 100.0)
    assert found_time == pytest.approx(time, rel=(of_time + of_found_time) / 100.0)


def test_contributing_names_every_folder_in_its_order_and_only_files_that_are_there() -> None:
    root = Path(__file__).parents[2]
    page = (root / "CONTRIBUTING.md").read_text("utf-8")
    table = page.partition("## The folders")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (`\w+`(?:, `\w+`)*) \|", table, re.M)
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    linter = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]
    assert named == linter["contracts"][0]["layers"][::-1]
    for file in re.findall(r"`([\w/.]+\.(?:py|c|h|md))`", page):
        assert (root / file).exists() or (PACKAGE / file).exists(), file


def test_contributing_names_only_functions_that_are_there() -> None:
    root = Path(__file__).parents[2]
    page = " ".join((root / "CONTRIBUTING.md").read_text("utf-8").split())
    named = re.findall(
        r"`([\w/]+\.py)` \((`\w+`(?:, `\w+`)*)\)", page
    )  # `file.py` (`name`, `name`)
    named += [(file, name) for name, file in re.findall(r"(`\w+`) (?:of|in) `([\w/]+\.py)`", page)]
    named += [("_core.pyi", f"`{name}`") for name in re.findall(r"`_core\.(\w+)`", page)]
    assert len(named) > 30
    for file, names in named:
        folder = PACKAGE if (PACKAGE / file).exists() else root
        text = (folder / file).read_text("utf-8")
        for name in re.findall(r"\w+", names):
            assert re.search(rf"\b(?:def|class) {name}\b|^{name}\b.* = ", text, re.M), (file, name)


def own_members(thing: object) -> set[str]:
    """Public methods and properties of a class, its own or of bases within the package.

    Not its fields, which the docstring of the class explains.
    """
    bases = thing.__mro__ if isinstance(thing, type) else ()
    fields = getattr(thing, "__dataclass_fields__", {})
    return {
        name
        for base in bases
        if base.__module__.startswith("aoimpact")
        for name, value in vars(base).items()
        if not name.startswith("_")
        and name not in fields
        and (callable(value) or isinstance(value, (property, cached_property, classmethod)))
    }


def test_every_public_name_says_what_it_is() -> None:
    assert len(set(ao.__all__)) == len(ao.__all__)
    for name in ao.__all__:
        thing = getattr(ao, name)
        assert inspect.getdoc(thing), name
        for member in own_members(thing):
            assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


def test_every_public_name_is_in_the_help_and_on_the_site() -> None:
    pages = Path(__file__).parents[2].glob("docs/api/*.rst")
    listed = {line.strip() for page in pages for line in page.read_text("utf-8").splitlines()}
    for name in set(ao.__all__) - {"__version__"}:
        assert re.search(rf"\b{name}\b", ao.__doc__ or ""), f"aoimpact/__init__.py: no {name}"
        assert name in listed, f"docs/api/ does not list {name}"
    assert set(dir(ao)) == set(ao.__all__)


def test_every_public_name_has_an_example() -> None:
    for name in set(ao.__all__) - {"__version__"}:
        thing = getattr(ao, name)
        if not (isinstance(thing, type) and issubclass(thing, Exception)):
            assert ">>> " in (inspect.getdoc(thing) or ""), name


def test_a_misspelt_keyword_names_the_one_that_was_meant() -> None:
    public = [*(getattr(ao, name) for name in ao.__all__), *vars(ao.testrig).values()]
    for thing in filter(inspect.isfunction, public):
        *_, keyword = inspect.signature(thing).parameters or ["none"]
        with pytest.raises(ao.InputTypeError, match=rf"{thing.__name__}.*\b{keyword}\b"):
            thing(**{keyword + "s": 1.0})
        assert pickle.loads(pickle.dumps(thing)) is thing
    for made in (ao.Hertz, ao.Material, ao.Shell, ao.Scene, ao.Newmark, ao.AOModel, ao.FEModel):
        with pytest.raises(ao.InputTypeError, match=made.__name__):
            made(mispelt=1.0)
    with pytest.raises(ao.InputTypeError, match="radius"):
        ao.FEModel.contact(radios=1e-3)


# ------------------------------------------------------------------------------------- imports


def test_folders_are_entered_by_their_door() -> None:
    """From another folder only what its __init__ offers, and nothing private.

    The paper is recomputed by the public names.
    """
    for path in PACKAGE.glob("*/*.py"):
        text = path.read_text("utf-8")
        whole = set(re.findall(r"^ *import (aoimpact[.\w]*)", text, re.M))
        assert whole <= ({"aoimpact"} if path.parent.name == "paper" else set()), path
        entered = re.findall(r"^ *from (\.*)([.\w]*) import (\([^)]*\)|.*)$", text, re.M)
        assert len(entered) == len(re.findall(r"^ *from .*\bimport\b", text, re.M)), path
        for dots, module, names in entered:
            assert set(re.findall(r"(?<!as )\b_\w+", names)) <= {"_core", "__version__"}, path
            assert module.partition(".")[0] != "aoimpact", path
            assert len(dots) < 3, path
            assert len(dots) < 2 or "." not in module, path


def test_tests_import_rooms_and_not_their_files() -> None:
    """So that files of a room can be merged and split: `from aoimpact.fem import ...`."""
    opening = re.compile(r"^ *from aoimpact\.\w+\.\w.* import ", re.M)
    tests = Path(__file__).parents[1].rglob("*.py")
    opened = [path for path in tests if opening.search(path.read_text("utf-8"))]
    assert not opened


FIRST_CALLS = """
import sys
import numpy, scipy.sparse
before = set(sys.modules)
import aoimpact as ao
print(*set(sys.modules) - before)
ball = ao.rigid(mass=1.0)
law = ao.Hertz(k=1e10)
ao.simulate(projectile=ball, target=ball, law=law, velocity=1.0, duration=1e-3).peak_force
ao.antioscillators
print(*set(sys.modules) - before)
"""

# What takes long to import and has nothing to do with two bodies that are given by numbers.
WAITING = {
    *{"matplotlib", "tqdm", "IPython", "pandas", "gmsh", "pytest", "meshio", "skfem", "urllib"},
    *{"scipy.linalg", "scipy.sparse.linalg", "scipy.sparse.csgraph", "scipy.spatial"},
    *{"scipy.optimize", "scipy.special", "scipy.integrate", "scipy.interpolate"},
}


def test_imports_wait_until_they_are_needed() -> None:
    """`import aoimpact` takes a quarter of the time of numpy and scipy.sparse, which it leaves out.

    The first use of `simulate` takes 1.5 times as long as those, with them; half of the rest is
    spent on making dataclasses. Where no bytecode is kept (PYTHONDONTWRITEBYTECODE) it takes twice
    as long. The first call whose law has to be solved needs scipy.optimize.
    """
    command = [sys.executable, "-W", "error", "-c", FIRST_CALLS]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    imported, called = (set(line.split()) for line in done.stdout.splitlines())
    assert {name for name in imported if name.startswith("aoimpact")} == {"aoimpact"}
    assert "aoimpact.impact" in called
    assert not called & WAITING


# What finds an editable install: it is on no path, and is asked for each module after all paths.
FINDER = """
import sys
from importlib.machinery import PathFinder
class Finder:
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] == "aoimpact":
            return PathFinder.find_spec(name, [{package!r} if "." in name else {folder!r}])
sys.meta_path.append(Finder)
"""


@pytest.mark.parametrize("editable", [False, True])
def test_a_script_in_the_source_folder_runs_the_installed_package(
    tmp_path: Path, editable: bool
) -> None:
    source = tmp_path / "aoimpact"
    source.mkdir()
    for name in ("__init__.py", "__init__.pyi"):  # as in a clone, where no core was built
        source.joinpath(name).write_bytes(PACKAGE.joinpath(name).read_bytes())
    script = tmp_path / "first.py"
    script.write_text("import aoimpact as ao\nprint(ao.__file__, ao.rigid(mass=2.0).m0)")
    command = [sys.executable, str(script)]
    place = PACKAGE.parent
    if editable:
        place = tmp_path / "site"
        finder = FINDER.format(package=str(PACKAGE), folder=str(PACKAGE.parent))
        for name, text in (
            ("sitecustomize.py", finder),
            ("aoimpact-1.dist-info/METADATA", "Name: aoimpact\nVersion: 1\n"),
        ):
            place.joinpath(name).parent.mkdir(parents=True, exist_ok=True)
            place.joinpath(name).write_text(text)
    installed = os.environ | {"PYTHONPATH": str(place), "PYTHONSAFEPATH": ""}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=installed)
    assert done.stdout.split() == [str(PACKAGE / "__init__.py"), "2.0"]
    nothing = [sys.executable, "-S", str(script)]  # a Python without any package
    done = subprocess.run(
        nothing, capture_output=True, text=True, env=installed | {"PYTHONPATH": ""}
    )
    assert "aoimpact is not installed for" in done.stderr
    assert ".venv/bin/python" in done.stderr
