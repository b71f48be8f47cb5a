"""Wrong scene files are refused by line, by the name of the key, and before any work."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from rows import each

import aoimpact as ao
from aoimpact.base import SceneFileError

from scenes import BAR, ROW, STARS, SWEPT

SHEET = """
[materials]
steel = { E = 210e9, nu = 0.3, rho = 7800 }
sheet = { shell = "steel", thickness = 1e-3 }
carbon = { orthotropic = { E = [1e11, 1e10, 1e10], G = [5e9, 5e9, 3e9], nu = [0.3, 0.3, 0.4] }, rho = 1550 }
[bodies.ball]
ball = 0.005
material = "steel"
[bodies.plate]
mesh = { sheet = [0.1, 0.1], divisions = [2, 2] }
material = "sheet"
fixed = [{ nodes = "rim", hold = "xyz", hold_rotations = "xyz" }]
contact = { point = [0.05, 0.05, 0.0] }
[impact]
projectile = "ball"
target = "plate"
velocity = 1.0
[impact.probes]
moved = { body = "plate", point = [0.05, 0.05, 0.0], direction = [0, 0, 1] }
strain = { type = "StrainAt", body = "plate", point = [0.05, 0.05, 0.0] }
"""  # noqa: E501

# Refused when the file is read: what is put for what, the start of the line, the name that is said.
READ = {
    STARS: [
        ("velocity = 2.0", "velocty = 2.0", "velocty", "did you mean 'velocity'"),
        ("velocity = 2.0", 'velocity = "2"', "velocity", "impact.velocity"),
        ("velocity = 2.0", "velocity = true", "velocity", "impact.velocity"),
        ("velocity = 2.0\n", "", "[impact]", "'velocity'"),
        ("velocity = 2.0", f"velocity = 1{400 * '0'}", "velocity", "impact.velocity"),
        ('"beam"', '"baem"', "target", "did you mean 'beam'"),
        ('"beam"', "7", "target", "impact.target"),
        ("Hertz", "Herz", "law", "did you mean 'Hertz'"),
        ('"Hertz"', "[]", "law", "impact.law.type"),
        ("k = 1e9", "n = 1e9", "law", "'n'"),
        ("mass = 0.03", "weight = 0.03", "weight", "'weight'"),
        ("mass = 0.03", "mass = 0.03\nm0 = 1.0", "m0", "'m0'"),
        ("m = [0.2]", "m = [0.2, true]", "m = [", "bodies.beam.m.1"),
        ("dt = 1e-6", 'estimate = "no"', "solver", "impact.solver.estimate"),
        ("[bodies.ball]", "[bodies]\nball = 3\n[x]", "ball", "bodies.ball"),
        ("[impact]", "report = 1\n[impact]", "report", "'report'"),
        ("gap = 1e-5", 'report = ["peak_forc"]', "report", "did you mean 'peak_force'"),
    ],
    BAR: [
        ("divisions = [4, 1, 1]", "divisions = [4, 1, 1.5]", "mesh", "bodies.bar.mesh.divisions.2"),
        ("{ box = [0.1", '{ file = "no.msh", size = [0.1', "mesh", "'size'"),
        ('type = "Linear"', 'type = "Tsuji"', "law", "'alpha'"),
        ('hold = "xyz"', 'helt = "xyz"', "    { nodes", "did you mean 'hold'"),
    ],
    ROW: [
        ('["first", "second"]', '["first", "secnd"]', "between", "did you mean 'second'"),
        ('["first", "second"]', '["first"]', "between", "scene.contacts.0.between"),
        ('name = "second"', 'name = "first"', 'name = "first"\nbody = "ball"\n\n', "name"),
        ("forces = [0.0, 2.0]", "force = 1.0", "times", "'times'|'force'"),
    ],
    SHEET: [
        ('shell = "steel"', 'shell = "sheet"', "sheet", "'sheet'"),
        ('body = "plate", point', 'body = "plat", point', "moved", "did you mean 'plate'"),
        ('body = "plate", ', "", "moved", "'body'"),
    ],
    STARS + SWEPT: [
        ("velocity = [1.0", "velocty = [1.0", "velocty", "did you mean 'velocity'"),
        ("bodies.beam.m0", "bodies.bea.m0", "bodies.bea.", "did you mean 'beam'"),
        ("[1.0, 2.0]", "[]", "velocity = []", "sweep.over.velocity"),
        ("[1.0, 2.0]", '[1.0, "fast"]', 'velocity = [1.0, "', "sweep.over.velocity"),
        ("[1.0, 2.0]", "1.0", "velocity = 1.0", "sweep.over.velocity"),
        ("to = 1e10, ", "", "law.k", "'to'"),
        ("count = 3, s", "count = 0, s", "law.k", "count"),
        ("from = 1e8", "from = 0", "law.k", "from"),
        ('"log"', '"lag"', "law.k", "spacing"),
        ('["peak_force"]', '["peak_forc"]', "keep", "did you mean 'peak_force'"),
        ('["peak_force"]', "[]", "keep", "sweep.keep"),
        ("[sweep]", "[sweep]\nworkers = 0", "workers", "sweep.workers"),
        (SWEPT, "\n[sweep]\nover = {}\n", "over = {}", "sweep.over"),
        ("1e8, to", f"{10**400}, to", "law.k", "sweep.over.law.k.from"),
        ("law.k", "impact.velocity", "impact.velocity", "'velocity'"),
        ("bodies.beam.m0", "impact.law", "impact.law", "'impact.law'"),
    ],
}

# Refused by the functions that are called, with the line of the table or of the argument.
MADE = {
    STARS: [
        ("velocity = 2.0", "velocity = 0.0", "velocity", "velocity"),
        ("k = 1e9", "k = -1e9", "law", "k"),
        ("m = [0.2]", "m = [0.2, 0.3]", "m = [", "m"),
        ("dt = 1e-6", "dt = 0", "solver", "dt"),
        ("gap = 1e-5", 'quantity = "peak_forc"', "quantity", "did you mean 'peak_force'"),
    ],
    BAR: [
        ("nu = 0.3", "nu = 0.5", "nu", "nu"),
        ("divisions = [4, 1, 1]", "divisions = [4, 1, 0]", "mesh", "divisions"),
        ('"xmin"', '"xmim"', "    { nodes", "did you mean 'xmin'"),
        ('nodes = "xmin"', "x = 0.2", "    { x", "fixed"),
        ('nodes = "xmin", ', "", "    { hold", "nodes"),
        ("[0.1, 0.0, 0.0]", "[0.2, 0.0, 0.0]", "contact", "point"),
        ("n = 2", 'n = 2, solver = "pardso"', "model", "did you mean 'pardiso'"),
        ("mesh = {", 'mesh = "no.msh" #', "mesh", "no.msh"),
    ],
    ROW: [
        ('["first", "second"]', '["first", "first"]', "[[scene.contacts]]", "itself"),
        ("gap = 1e-3", "gap = -1.0", "[scene]", "overlap"),
        ("forces = [0.0, 2.0]", "forces = [0.0]", "forces = [0.0]", "forces"),
    ],
    SHEET: [
        ("thickness = 1e-3", "thickness = -1e-3", "sheet", "thickness"),
        ('material = "sheet"', 'material = "steel" #', 'material = "steel" #', "material"),
        ('body = "plate", point', 'body = "ball", point', "moved", "body"),
        ("StrainAt", 'StressAt", component = "aa', "strain", "component"),
    ],
}


def rows(table: dict[str, list[Any]]) -> list[Any]:
    return [(right, *row) for right, cases in table.items() for row in cases]


def refused(folder: Path, text: str, at: str, name: str, *, run: bool) -> None:
    """Check that a file is refused with the line that starts so, and that name."""
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    number = text[: text.index(at)].count("\n") + 1
    if run:
        file = ao.read_scene(path)
    with pytest.raises(SceneFileError) as error:
        file.simulate() if run else ao.read_scene(path)
    assert f"{path}:{number}: " in str(error.value), str(error.value)
    assert re.search(rf"(?<!\w)({name})(?!\w)" if name.isidentifier() else name, str(error.value))


@each("right, old, new, at, name", rows(READ))
def test_when_it_is_read(
    right: str, old: str, new: str, at: str, name: str, tmp_path: Path
) -> None:
    assert old in right
    name = name.replace("[", r"\[")
    refused(tmp_path, right.replace(old, new, 1), at, name, run=False)


@each("right, old, new, at, name", rows(MADE))
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_when_it_is_run(right: str, old: str, new: str, at: str, name: str, tmp_path: Path) -> None:
    assert old in right
    refused(tmp_path, right.replace(old, new, 1), at, name, run=True)


def test_all_problems_at_once(tmp_path: Path) -> None:
    wrong = STARS.replace("mass", "mas").replace("gap", "gab").replace("m0 = 0.1", 'm0 = "x"')
    (tmp_path / "a.toml").write_text(wrong)
    with pytest.raises(SceneFileError) as error:
        ao.read_scene(tmp_path / "a.toml")
    assert {2, 5, 15} <= {int(text.split(":")[1]) for text in str(error.value).splitlines()}


def test_all_wrong_values_at_once(tmp_path: Path) -> None:
    wrong = STARS.replace("mass = 0.03", "mass = -1").replace("k = 1e9", "k = -1e9")
    (tmp_path / "a.toml").write_text(wrong)
    with pytest.raises(SceneFileError) as error:
        ao.read_scene(tmp_path / "a.toml").simulate()
    assert len(str(error.value).splitlines()) == 2


@each("key", ["velocity", '"velocity"', '"impact.velocity"', "impact.velocity"])
def test_a_key_of_a_sweep_has_its_line_however_it_is_written(key: str, tmp_path: Path) -> None:
    text = f'{STARS}[sweep.over]\n"bodies.ball.mass" = [1.0]\n{key} = ["x"]\n'
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(SceneFileError, match=f"toml:{len(text.splitlines())}: "):
        ao.read_scene(tmp_path / "a.toml")


@each("name", ["contacts.3.peak_force", "bodies.bal.label", "error.x", "bodies"])
def test_names_of_no_numbers_are_refused_before_the_run(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(ROW.replace("[scene]", f'[scene]\nreport = ["{name}"]'))
    with pytest.raises(SceneFileError, match="report"):
        ao.read_scene(tmp_path / "a.toml")


@each("count", [3000, 30_000])
def test_the_first_of_thousands_of_problems_are_shown(count: int, tmp_path: Path) -> None:
    """Where the text is long as well, without lines, which would take minutes to find."""
    unknown = "\n".join(f"x{i} = {i}" for i in range(count))
    (tmp_path / "a.toml").write_text(STARS.replace("[bodies.ball]", f"[bodies.ball]\n{unknown}"))
    with pytest.raises(SceneFileError) as raised:
        ao.read_scene(tmp_path / "a.toml")
    *shown, more = str(raised.value).splitlines()
    assert len(shown) == 20
    assert str(count - 20) in more


@each(
    "text",
    [
        b"",
        b"a = \n",
        b"[impact]",
        b"bodies = 3\nimpact = {}",
        b"materials = []\nbodies = {}\nimpact = {}",
        b"bodies = {}\nimpact = {}\nscene = {}",
        b"title = '\xff'",
        b"a = " + 3000 * b"[" + 3000 * b"]",
        b"a = 1" + 5000 * b"0",
        b"a = '\0'",
    ],
)
def test_files_that_are_no_scenes(text: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_bytes(text)
    with pytest.raises(SceneFileError, match=r"a\.toml"):
        ao.read_scene(tmp_path / "a.toml")


@each("path", [None, 3, b"a.toml", ["a.toml"]])
def test_what_is_no_path_is_refused(path: Any) -> None:
    with pytest.raises(ao.InputTypeError, match="path"):
        ao.read_scene(path)


def test_a_file_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneFileError, match=r"none\.toml"):
        ao.read_scene(tmp_path / "none.toml")


def test_errors_of_a_computation_keep_their_class_and_have_the_line(tmp_path: Path) -> None:
    text = BAR.replace("[0.1, 0.01, 0.01]", "[0.1, 0.02, 1e-6]").replace(
        "point = [0.1, 0.0, 0.0], direction = [0, 0, 1], radius = 0", "dof = 5"
    )
    text = re.sub(r"fixed = \[.*?\n\]", "", text, flags=re.S)
    (tmp_path / "a.toml").write_text(text)
    number = text[: text.index("model")].count("\n") + 1
    with pytest.raises(ao.SingularError, match=rf"a\.toml:{number}: bodies\.bar"):
        ao.read_scene(tmp_path / "a.toml").case()
