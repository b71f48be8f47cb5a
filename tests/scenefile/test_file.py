"""Scene files: the same impact as in Python, and errors that name the line."""

from __future__ import annotations

import json
import math
import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from every_law import LAWS as EVERY_LAW
from every_law import law_of

import aoimpact as ao
from aoimpact.batch.sweep import sweep_file
from aoimpact.cli.files import as_json, rows
from aoimpact.scenefile import names as scenefile_schema
from aoimpact.scenefile.schema import Either, Entries, Kind, Listed, Table, Tagged, Tree, Variants

from scenes import BAR, ROW, STARS

ROOT = Path(__file__).parents[2]
ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
CROSSED = ao.Hertz.between(ALU, (0.01, math.inf), ALU, 0.02, angle=0.5)
EXAMPLE = ROOT / "examples" / "sphere_on_beam.toml"


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def line(text: str, start: str) -> int:
    return text[: text.index(start)].count("\n") + 1


# ------------------------------------------------------------------------------ what it means


def test_the_same_as_in_python(tmp_path: Path) -> None:
    hit = ao.read_scene(written(tmp_path, STARS)).simulate()
    same = ao.simulate(
        projectile=ao.rigid(mass=0.03),
        target=ao.AOModel(m0=0.1, k0=1e5, m=[0.2], k=[1e6]),
        law=ao.Hertz(k=1e9),
        velocity=2.0,
        duration=1e-3,
        gap=1e-5,
        solver=ao.Newmark(dt=1e-6),
    )
    assert np.array_equal(hit.force, same.force)


MATRICES = """
[bodies.ball]
mass = 0.03

[bodies.bar]
matrices = { K = "K.mtx", M = ["M.npz", "M"], dofs = "dofs.txt", nodes = "nodes.txt", mass = 2.0 }
contact = { node = 5, direction = [0, 0, -1] }

[impact]
projectile = "ball"
target = "bar"
velocity = 1.0
law = { type = "Hertz", k = 1e9 }
duration = 1e-5
"""


def test_a_body_of_matrices(tmp_path: Path) -> None:
    body = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.02), (4, 1, 1)), ALU)
    ao.write_matrices(body, tmp_path)
    np.savez(tmp_path / "M.npz", M=body.M.toarray(), other=np.eye(3))
    file = ao.read_scene(written(tmp_path, MATRICES))
    target = file.case()["target"].body
    assert target.mass == pytest.approx(2.0 * body.mass)
    tip = body.contact(node=4, direction=(0, 0, -1), radius=0)
    np.testing.assert_array_equal(file.case()["target"].contact_points[0].b, tip.b)


def test_matrices_on_a_mesh(tmp_path: Path) -> None:
    mesh = ao.box_mesh((0.1, 0.04, 0.04), (10, 4, 4), kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALU)
    ao.write_matrices(body, tmp_path)
    deck = [f"{i + 1}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(mesh.nodes.tolist())]
    cells = [",".join(map(str, [i + 1, *(cell + 1)])) for i, cell in enumerate(mesh.cells)]
    lines = ["*NODE", *deck, "*ELEMENT, TYPE=C3D20", *cells, ""]
    (tmp_path / "bar.inp").write_text("\n".join(lines))
    text = MATRICES.replace('["M.npz", "M"]', '"M.mtx"').replace(
        'nodes = "nodes.txt", mass = 2.0', 'mesh = "bar.inp", material = "alu"'
    )
    text = text.replace("node = 5, direction = [0, 0, -1]", "point = [0.05, 0.02, 0.04]")
    text = "[materials.alu]\nE = 70e9\nnu = 0.3\nrho = 2700\n" + text
    tip = ao.read_scene(written(tmp_path, text)).case()["target"].contact_points[0]
    same = body.contact(point=(0.05, 0.02, 0.04))
    np.testing.assert_allclose(tip.b, same.b, atol=1e-12)
    assert tip.patch == same.patch


def test_files_of_matrices_that_are_wrong_are_named_with_their_line(tmp_path: Path) -> None:
    with pytest.raises(ao.SceneFileError, match=r"toml:\d+: .*K.*K\.mtx' does not exist"):
        ao.read_scene(written(tmp_path, MATRICES)).case()
    with pytest.raises(ao.SceneFileError, match=r"bodies\.bar\.matrices: 'K' is missing"):
        ao.read_scene(written(tmp_path, MATRICES.replace('K = "K.mtx", ', "")))


def test_a_meshed_body(tmp_path: Path) -> None:
    target = ao.read_scene(written(tmp_path, BAR)).case()["target"]
    bar = ao.FEModel.from_mesh(
        ao.box_mesh((0.1, 0.01, 0.01), (4, 1, 1)),
        ao.Material(E=70e9, nu=0.3, rho=2700),
        fixed=[("xmin", "xyz"), ([4, 5], "z")],
    )
    same = ao.antioscillators(bar.contact(point=(0.1, 0, 0), direction=(0, 0, 1), radius=0), n=2)
    assert np.array_equal(target.m, same.m)
    assert np.array_equal(target.k, same.k)


def test_every_kind_of_model(tmp_path: Path) -> None:
    for model, label in (("full", "full"), ("modal", "modal(3)"), ("antioscillators", "AO(2)")):
        n = {"full": "", "modal": ", n = 3", "antioscillators": ", n = 2"}[model]
        text = BAR.replace('type = "antioscillators", n = 2', f'type = "{model}"{n}')
        hit = ao.read_scene(written(tmp_path, text)).simulate()
        assert hit.target.label.startswith(label)


def test_a_support_on_planes_is_the_edge_where_they_meet(tmp_path: Path) -> None:
    text = BAR.replace('{ nodes = "xmin", hold = "xyz" }', '{ x = 0.0, z = 0.0, hold = "xyz" }')
    ours = ao.read_scene(written(tmp_path, text)).case()["target"]
    edge = BAR.replace('"xmin"', "[0, 10]")
    mesh = ao.box_mesh((0.1, 0.01, 0.01), (4, 1, 1))
    nodes = np.flatnonzero((mesh.nodes[:, 0] == 0.0) & (mesh.nodes[:, 2] == 0.0))
    edge = BAR.replace('nodes = "xmin"', f"nodes = {nodes.tolist()}")
    assert np.array_equal(ours.k, ao.read_scene(written(tmp_path, edge)).case()["target"].k)


def test_meshes_lie_beside_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = ao.box_mesh((100.0, 10.0, 10.0), (4, 1, 1))  # mm
    folder = tmp_path / "scene"
    folder.mkdir()
    meshio.Mesh(mesh.nodes, [("hexahedron", mesh.cells)]).write(folder / "bar.vtu")
    text = BAR.replace(
        "mesh = { box = [0.1, 0.01, 0.01], divisions = [4, 1, 1] }",
        'mesh = { file = "bar.vtu", scale = 1e-3 }',
    ).replace('{ nodes = "xmin", hold = "xyz" }', '{ x = 0.0, hold = "xyz" }')
    path = written(folder, text)
    monkeypatch.chdir(tmp_path)
    target = ao.read_scene(path).case()["target"]
    same = ao.read_scene(written(tmp_path, BAR)).case()["target"]
    np.testing.assert_allclose(target.k, same.k, rtol=1e-9)


def test_hertz_s_stiffness_of_two_surfaces(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8") + "[bodies.ball]\nmass = 0.03\n"
    for body in ("sphere", "beam"):
        text = text.replace(f'= "{body}"', '= "ball"')
    case = ao.read_scene(written(tmp_path, text)).case()
    steel, alu = ao.Material(210e9, 0.3, 7800), ao.Material(70e9, 0.3, 2400)
    assert case["law"] == ao.Hertz.between(steel, 0.01, alu, math.inf)
    assert case["solver"] == ao.Adaptive(rtol=1e-6)


def toml(value: Any) -> str:
    """A parameter of a law as a scene file has it."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(toml, value))}]"
    return json.dumps(value)


def law_in(tmp_path: Path, text: str) -> ao.ContactLaw:
    """The law of a scene file that has this one."""
    scene = written(tmp_path, BAR.replace('type = "Linear", k = 1e6', text))
    law: ao.ContactLaw = ao.read_scene(scene).case()["law"]
    return law


@pytest.mark.parametrize("name", sorted(EVERY_LAW))
def test_every_law_by_its_parameters(name: str, tmp_path: Path) -> None:
    law: Any = law_of(name)
    if type(law).__name__ not in scenefile_schema.LAWS:  # of functions, or made for patches
        return
    given = {field.name.removesuffix("_values"): getattr(law, field.name) for field in fields(law)}
    pairs = [f"{key} = {toml(value)}" for key, value in given.items() if value is not None]
    assert law_in(tmp_path, ", ".join([f'type = "{type(law).__name__}"', *pairs])) == law


def test_the_stiffness_of_a_law_may_be_that_of_two_surfaces(tmp_path: Path) -> None:
    law = (
        'type = "HuntCrossley", damping = 0.2, k = { between = [{ material = "alu", '
        'radius = [0.01, inf] }, { material = "alu", radius = 0.02 }], angle = 0.5 }'
    )
    same = ao.HuntCrossley(CROSSED.k, damping=0.2, relative_radius=CROSSED.relative_radius)
    assert law_in(tmp_path, law) == same


def test_a_relative_radius_is_given_once(tmp_path: Path) -> None:
    alone = 'type = "Thornton", k = 1e9, yield_force = 10, relative_radius = 0.01'
    text = BAR.replace('type = "Linear", k = 1e6', alone)
    law = ao.read_scene(written(tmp_path, text)).case()["law"]
    assert law == ao.Thornton(1e9, 10.0, relative_radius=0.01)
    surface = '{ material = "alu", radius = 1.0 }'
    twice = f'type = "Hertz", relative_radius = 0.01, k = {{ between = [{surface}, {surface}] }}'
    path = written(tmp_path, BAR.replace('type = "Linear", k = 1e6', twice))
    with pytest.raises(ao.SceneFileError, match="relative_radius: it follows"):
        ao.read_scene(path).case()


def test_two_surfaces_have_hertz_s_power(tmp_path: Path) -> None:
    surface = '{ material = "alu", radius = 1.0 }'
    law = f'type = "HuntCrossley", damping = 0, n = 1.4, k = {{ between = [{surface}, {surface}] }}'
    path = written(tmp_path, BAR.replace('type = "Linear", k = 1e6', law))
    with pytest.raises(ao.SceneFileError, match="belongs to n ="):
        ao.read_scene(path).case()


@pytest.mark.slow
def test_the_example_is_the_paper_s_impact() -> None:
    scene = ao.read_scene(EXAMPLE)
    hit = scene.simulate()
    assert scene.reported == ("peak_force", "contact_duration", "rebound_velocity")
    # The sphere's star and the beam's, by the functions of the package.
    sphere = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), ao.Material(210e9, 0.3, 7800))
    star = ao.antioscillators(
        sphere.contact(point=(0.01, 0, 0), direction=(1, 0, 0), radius=0), n=1
    )
    again = ao.simulate(**scene.case() | {"projectile": star})
    assert hit.peak_force == again.peak_force


def row_of_balls() -> ao.Scene:
    """The scene of ROW."""
    scene = ao.Scene(gravity=9.81)
    first = scene.add(ao.rigid(mass=0.03), velocity=1.0, position=-1e-3)
    second = scene.add(ao.rigid(mass=0.03))
    wall = scene.add(ao.rigid(mass=math.inf), position=2e-3)
    scene.connect(first, second, ao.Hertz(k=1e10))
    scene.connect(second, wall, ao.Linear(k=1e7), gap=1e-3)
    scene.apply(second, force=([0.0, 1e-3], [0.0, 2.0]))
    return scene


def test_a_scene_of_several_bodies(tmp_path: Path) -> None:
    file = ao.read_scene(written(tmp_path, ROW))
    run = file.simulate()
    same = row_of_balls().simulate(duration=1e-2, solver=ao.Adaptive(rtol=1e-9))
    assert np.array_equal(run.t, same.t)
    for ours, theirs in zip(run.contacts, same.contacts, strict=True):
        assert np.array_equal(ours.force, theirs.force)
    assert file.reported[2] == "contacts.1.peak_force"
    (kept,) = ao.simulate_many([file.case()], keep=file.reported)
    assert kept["contacts.1.peak_force"] == same.contacts[1].peak_force


def test_a_scene_may_start_from_rest(tmp_path: Path) -> None:
    """A ball that lies on a spring's stop under gravity stays there: force m g throughout."""
    text = ROW.replace("duration = 1e-2", "duration = 1e-2\npreload = true")
    text = text[: text.index("[[scene.bodies]]")] + (
        '[[scene.bodies]]\nbody = "ball"\n[[scene.bodies]]\nbody = "wall"\n'
        '[[scene.contacts]]\nbetween = ["ball", "wall"]\nlaw = { type = "Linear", k = 1e4 }\n'
    )
    run = ao.read_scene(written(tmp_path, text)).simulate()
    np.testing.assert_allclose(run.contacts[0].force, 0.03 * 9.81, rtol=1e-6)


def test_a_body_touched_in_several_places(tmp_path: Path) -> None:
    contact = "contact = { point = [0.1, 0.0, 0.0], direction = [0, 0, 1], radius = 0 }"
    other = "{ point = [0.05, 0.0, 0.0], direction = [0, 0, 1], radius = 0 }"
    scene = """
[scene]
duration = 1e-3
[[scene.bodies]]
body = "bar"
[[scene.bodies]]
body = "ball"
velocity = 1.0
[[scene.contacts]]
between = ["ball", { body = "bar", port = 1 }]
law = { type = "Linear", k = 1e6 }
"""
    text = BAR[: BAR.index("[impact]")].replace(contact, f"contact = [{contact[10:]}, {other}]")
    model = 'type = "interface", n = 6, contact_time = 1e-4'
    text = text.replace('type = "antioscillators", n = 2', model) + scene
    run = ao.read_scene(written(tmp_path, text)).simulate()
    bar = ao.read_scene(written(tmp_path, BAR.replace(contact, f"contact = {other}"))).simulate()
    assert run.contacts[0].peak_force == pytest.approx(bar.peak_force, rel=0.05)
    # Left to be reduced, as far as the answer allows.
    free = text.replace(f"model = {{ {model} }}", "")
    for quantity in ('"force"', '"ball"', '{ body = "bar", port = 1 }'):
        asked = free.replace("[scene]", f"[scene]\nquantity = {quantity}\nrtol = 0.05")
        chosen = ao.read_scene(written(tmp_path, asked)).simulate()
        assert chosen.contacts[0].peak_force == pytest.approx(run.contacts[0].peak_force, rel=0.1)
        assert chosen.models[0].label.startswith("interface(")
        assert chosen.error.model <= 0.05
    asked = free.replace("[scene]", '[scene]\nquantity = "bal"')
    with pytest.raises(ao.SceneFileError, match="did you mean 'ball'") as error:
        ao.read_scene(written(tmp_path, asked)).simulate()
    assert f":{line(asked, 'quantity')}: " in str(error.value)
    wrong = text.replace(model, 'type = "modal", n = 6')
    with pytest.raises(ao.SceneFileError, match="a list of contacts needs 'interface'"):
        ao.read_scene(written(tmp_path, wrong)).simulate()


def test_a_tolerance_reduces_the_bodies(tmp_path: Path) -> None:
    text = BAR.replace('model = { type = "antioscillators", n = 2 }', "")
    text = text.replace("velocity = 1.0", 'velocity = 1.0\nquantity = "impulse"\nrtol = 0.02')
    scene = ao.read_scene(written(tmp_path, text))
    assert isinstance(scene.case()["target"], ao.FullModel)
    hit = scene.simulate()
    assert hit.target.label.startswith("AO(")
    full = ao.simulate(**scene.case() | {"quantity": None, "rtol": None})
    assert hit.impulse == pytest.approx(full.impulse, rel=0.02)


def test_a_place_may_be_what_is_asked_for(tmp_path: Path) -> None:
    text = BAR.replace('model = { type = "antioscillators", n = 2 }', "")
    place = '{ body = "bar", point = [0.05, 0.0, 0.0], direction = [0, 0, 1] }'
    text = text.replace("velocity = 1.0", f"velocity = 1.0\nquantity = {place}\nrtol = 0.05")
    case = ao.read_scene(written(tmp_path, text)).case()
    assert case["quantity"].body is case["target"].body
    np.testing.assert_allclose(case["quantity"].point, [0.05, 0.0, 0.0], atol=1e-12)
    hit = ao.read_scene(written(tmp_path, text)).simulate()
    assert hit.error.model <= 0.05
    for old, new, message in (
        ('"bar", point', '"baar", point', "did you mean 'bar'"),
        ("rtol = 0.05", "rtol = 5", "rtol must be from"),
    ):
        with pytest.raises(ao.SceneFileError, match=message):
            ao.read_scene(written(tmp_path, text.replace(old, new))).simulate()


@pytest.mark.parametrize(
    ("sensor", "name"),
    [
        ('type = "StressAt", point = [0.05, 0.0, 0.0], component = "xx"', "stress"),
        ('type = "StrainAt", point = [0.05, 0.0, 0.0], component = [1, 0, 0]', "strain"),
        (
            'type = "AccelerationAt", point = [0.05, 0.0, 0.0], direction = [0, 0, 1], cfc = 1e4',
            "acceleration",
        ),
        ('type = "ReactionAt", nodes = "xmin", direction = [0, 0, 1]', "reaction"),
    ],
)
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_a_sensor_may_be_what_is_asked_for(tmp_path: Path, sensor: str, name: str) -> None:
    text = BAR.replace('model = { type = "antioscillators", n = 2 }', "")
    text = text.replace(
        "velocity = 1.0", f'velocity = 1.0\nquantity = {{ body = "bar", {sensor} }}\nrtol = 0.1'
    )
    hit = ao.read_scene(written(tmp_path, text)).simulate()
    assert hit.error.quantity == name
    assert hit.value(name) > 0.0  # its largest value
    for old, new, message in (
        ('type = "', 'type = "x', 'must be one of "StressAt"'),
        ('body = "bar", type', 'body = "baar", type', "did you mean 'bar'"),
    ):
        with pytest.raises(ao.SceneFileError, match=message):
            ao.read_scene(written(tmp_path, text.replace(old, new))).simulate()


PATCHED = """
[materials.steel]
E = 210e9
nu = 0.3
rho = 7800
[bodies.block]
mesh = { box = [0.06, 0.06, 0.03], divisions = [8, 8, 4] }
material = "steel"
damping = { beta = 1e-8 }
fixed = [{ z = 0.0, hold = "xyz" }]
contact = { point = [0.03, 0.03, 0.03], radius = "auto", expected = 0.004 }
[bodies.spring]
m0 = 1.0
k0 = 1e5
damping = { ratio = 0.1 }
[bodies.ball]
mass = 0.02
[impact]
projectile = "ball"
target = "block"
velocity = 0.5
duration = 1e-4
law = { type = "HuntCrossley", k = 1e9, restitution = 0.7, velocity = 0.5 }
"""


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_patches_and_damping(tmp_path: Path) -> None:
    """The radius by itself, the direction by the surface, Rayleigh's damping and modal damping."""
    case = ao.read_scene(written(tmp_path, PATCHED)).case()
    mesh = ao.box_mesh((0.06, 0.06, 0.03), (8, 8, 4))
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    block = ao.FEModel.from_mesh(mesh, steel, fixed=[("zmin", "xyz")])
    same = block.contact(point=(0.03, 0.03, 0.03), radius="auto", expected=0.004)
    (tip,) = case["target"].tips
    assert tip.patch.radius == same.patch.radius
    np.testing.assert_allclose(tip.direction, [0, 0, -1], atol=1e-12)
    assert case["target"].body.damping == ao.Rayleigh(beta=1e-8)
    spring = PATCHED.replace('target = "block"', 'target = "spring"')
    target = ao.read_scene(written(tmp_path, spring)).case()["target"]
    assert target.damping == ao.ModalDamping(ratio=0.1)


@pytest.mark.parametrize(
    ("law", "same"),
    [
        (
            'type = "HuntCrossley", k = 1e9, restitution = 0.7, velocity = 2.0',
            ao.HuntCrossley.from_restitution(1e9, 0.7, 2.0),
        ),
        (
            'type = "Tsuji", k = 1e9, restitution = 0.7, mass = 0.1',
            ao.Tsuji.from_restitution(1e9, 0.7, 0.1),
        ),
        (
            'type = "KuwabaraKono", k = 1e9, restitution = 0.7, velocity = 2.0, mass = 0.1',
            ao.KuwabaraKono.from_restitution(1e9, 0.7, 2.0, 0.1),
        ),
        (
            'type = "KelvinVoigt", k = 1e6, restitution = 0.7, mass = 0.1, end = "indentation"',
            ao.KelvinVoigt.from_restitution(1e6, 0.7, 0.1, end="indentation"),
        ),
        (
            'type = "Thornton", yield_pressure = 2e9, k = { between = ['
            '{ material = "alu", radius = 0.01 }, { material = "alu", radius = inf }] }',
            ao.Thornton.between(ALU, 0.01, ALU, math.inf, yield_pressure=2e9),
        ),
        (
            'type = "ElasticPlastic", hardness = 1e9, k = { between = ['
            '{ material = "alu", radius = 0.01 }, { material = "alu", radius = inf }] }',
            ao.ElasticPlastic.between(ALU, 0.01, ALU, math.inf, hardness=1e9),
        ),
    ],
)
def test_laws_by_what_they_deliver(law: str, same: ao.ContactLaw, tmp_path: Path) -> None:
    text = BAR.replace('type = "Linear", k = 1e6', law)
    assert ao.read_scene(written(tmp_path, text)).case()["law"] == same


def test_linear_solvers_are_taken_and_named(tmp_path: Path) -> None:
    made = '"antioscillators", n = 2, method = "krylov", duration = 1e-3, solver = "superlu"'
    text = BAR.replace('"antioscillators", n = 2', made)
    assert ao.read_scene(written(tmp_path, text)).case()["target"].origin.solver == "superlu"
    linear = 'velocity = 1.0\nlinear_solver = "superlu"'
    text = BAR.replace("velocity = 1.0", linear)
    with pytest.raises(ao.SceneFileError, match=f":{line(text, 'linear')}: .*give quantity or rt"):
        ao.read_scene(written(tmp_path, text)).simulate()
    text = text.replace('model = { type = "antioscillators", n = 2 }', "")
    hit = ao.read_scene(written(tmp_path, text + "rtol = 0.1\n")).simulate()
    assert hit.models is not None
    assert hit.models[1].origin.solver == "superlu"


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_windows_ends_of_lines_and_mark_at_the_start(mark: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_bytes((mark + STARS).replace("\n", "\r\n").encode())
    assert ao.read_scene(path).case()["velocity"] == 2.0
    path.write_bytes((mark + STARS).replace("velocity", "velocty").replace("\n", "\r\n").encode())
    with pytest.raises(ao.SceneFileError, match=r"scene.toml:13: .*did you mean 'velocity'"):
        ao.read_scene(path)


# ---------------------------------------------------------------------------------- what is wrong


def check_blame(folder: Path, wrong: str, at: str, text: str, *, when_read: bool = False) -> None:
    """Check that a file is refused, if not before it is run, with that text and that line."""
    path = written(folder, wrong)
    with pytest.raises(ao.SceneFileError) as error:  # noqa: PT012
        scene = ao.read_scene(path)
        if not when_read:
            scene.simulate()
    assert re.search(text, str(error.value)), str(error.value)
    place = rf"{re.escape(str(path))}:{line(wrong, at)}: "
    assert re.search(place, str(error.value)), str(error.value)


# What is put for what in a right file, the start of the line that is blamed, what is said of it.
WRONG = {
    STARS: [
        ("velocity = 2.0", "velocty = 2.0", "velocty", r"unknown name 'velocty' \(did you mean"),
        (
            "velocity = 2.0",
            'velocity = "2"',
            "velocity",
            r"must be a number \(m/s\), or a list of 3, .* got '2'",
        ),
        ("velocity = 2.0", "velocity = true", "velocity", "must be a number.*got true"),
        ("velocity = 2.0\n", "", "[impact]", "'velocity' is missing, a number"),
        ("velocity = 2.0", "velocity = 0.0", "velocity", "velocity is 0 m/s"),
        ("velocity = 2.0", "velocity = nan", "velocity", "velocity must be a number, got nan"),
        ("duration = 1e-3", "duration = -1e-3", "duration", "duration must be positive"),
        ('"beam"', '"baem"', "target", r"\[bodies\] has no 'baem' \(did you mean 'beam'\?\)"),
        ('"beam"', "7", "target", r"must be a name from \[bodies\], got 7"),
        ("Hertz", "Herz", "law", r"must be one of .*'Herz' \(did you mean 'Hertz'\?\)"),
        ("k = 1e9", "n = 1e9", "law", "unknown name 'n'"),
        ("k = 1e9", "k = -1e9", "law", "k must be positive"),
        ("mass = 0.03", "mass = -0.03", "mass", "mass must be positive"),
        (
            "mass = 0.03",
            "weight = 0.03",
            "[bodies.ball]",
            "one of 'mass', 'wall', 'ball', 'm0', 'mesh', 'matrices' is",
        ),
        ("mass = 0.03", "mass = 0.03\nm0 = 1.0", "[bodies.ball]", "exclude each other"),
        ("m = [0.2]", "m = [0.2, true]", "m = [", r"bodies.beam.m.1: must be a number \(kg\)"),
        ("m = [0.2]", "m = [0.2, 0.3]", "m = [", "must have the same length"),
        ("m = [0.2]", "m = 0.2", "m = 0.2", "must be a list of values"),
        ("dt = 1e-6", "dt = 0", "solver", "dt must be positive"),
        ("dt = 1e-6", 'estimate = "no"', "solver", "must be true or false"),
        ("[bodies.ball]", "[bodies]\nball = 3\n[x]", "ball", "must be a table, got 3"),
        ("[impact]", "report = 1\n[impact]", "report", "unknown name 'report'"),
        ("gap = 1e-5", 'report = ["peak_forc"]', "report", "did you mean 'peak_force'"),
        ("gap = 1e-5", 'quantity = "peak_forc"', "quantity", "did you mean 'peak_force'"),
        ('solver = { type = "Newmark", dt = 1e-6 }', "rtol = 2.0", "rtol", "rtol must"),
    ],
    BAR: [
        ("nu = 0.3", "nu = 0.5", "nu", "nu must lie between"),
        ("nu = 0.3\n", "", "[materials.alu]", "'nu' is missing"),
        ('material = "alu"', 'material = "al"', "material =", "did you mean 'alu'"),
        ("box = [0.1, 0.01, 0.01]", "box = [0.1, 0.01]", "mesh", "must have 3 entries, got 2"),
        ("divisions = [4, 1, 1]", "divisions = [4, 1, 1.5]", "mesh", "must be a whole number"),
        ("divisions = [4, 1, 1]", "divisions = [4, 1, 0]", "mesh", "must be at least 1"),
        ("{ box = [0.1", '{ file = "no.msh", size = [0.1', "mesh", "unknown name 'size'"),
        ('"xmin"', '"xmim"', "fixed", "did you mean 'xmin'"),
        ('nodes = "xmin"', "x = 0.2", "    { x", "no node lies on x = 0.2 m; the mesh spans"),
        ('nodes = "xmin", ', "", "    { hold", "give either nodes, or planes"),
        ("[0.1, 0.0, 0.0]", "[0.2, 0.0, 0.0]", "contact", "off the body"),
        ("[0, 0, 1]", "[0, 0, 0]", "contact", "must not be the zero vector"),
        ("direction = [0, 0, 1]", "dof = 1", "contact", "exclude each other"),
        ("n = 2", "n = -2", "model", "n must be from 0"),
        ("fixed = [", "damping = {}\nfixed = [", "damping", "either ratio.* or alpha and beta"),
        ("fixed = [", "damping = { ratio = -1.0 }\nfixed = [", "damping", "ratio must not be neg"),
        ("radius = 0 }", 'radius = "aut" }', "contact", "did you mean 'auto'"),
        ("radius = 0 }", "radius = 0, expected = 1e-3 }", "contact", "expected is for radius"),
        ('type = "Linear"', 'type = "Tsuji"', "law", "one of 'alpha', 'restitution' is missing"),
        ("n = 2", "m = 2", "model", "unknown name 'm'"),
        ("n = 2", 'n = 2, solver = "pardso"', "model", "did you mean 'pardiso'"),
    ],
    ROW: [
        ('["first", "second"]', '["first", "secnd"]', "[[scene.contacts]]", "'second'"),
        ('["first", "second"]', '["first", "first"]', "[[scene.contacts]]", "cannot touch itself"),
        ('["first", "second"]', '["first"]', "between", "must have 2 entries"),
        ('name = "second"', 'name = "first"', 'name = "first"\nbody = "ball"\n\n', "two bodies"),
        ('body = "wall"', 'body = "wal"', 'body = "wal"', r"\[bodies\] has no 'wal'"),
        ("gap = 1e-3", "gap = -1.0", "[scene]", "overlap"),
        ("forces = [0.0, 2.0]", "forces = [0.0]", "[[scene.loads]]", "as many forces as times"),
        ("forces = [0.0, 2.0]", "force = 1.0", "[[scene.loads]]", "exclude each other"),
        ("gravity = 9.81", "gravity = nan", "gravity", "must be a number"),
        ('"Hertz", k = 1e10', '"Hertz", k = 0', "law", "k must be positive"),
    ],
}


@pytest.mark.parametrize(
    ("right", "old", "new", "at", "text"),
    [
        pytest.param(right, *case, id=f"{case[0]} -> {case[1]}")
        for right, cases in WRONG.items()
        for case in cases
    ],
)
def test_the_line_of_what_is_wrong(
    right: str, old: str, new: str, at: str, text: str, tmp_path: Path
) -> None:
    assert old in right
    check_blame(tmp_path, right.replace(old, new, 1), at, text)


def test_all_problems_at_once(tmp_path: Path) -> None:
    wrong = STARS.replace("mass", "mas").replace("gap", "gab").replace("m0 = 0.1", 'm0 = "x"')
    with pytest.raises(ao.SceneFileError) as error:
        ao.read_scene(written(tmp_path, wrong))
    found = [int(text.split(":")[1]) for text in str(error.value).splitlines()]
    assert {2, 5, 15} <= set(found)


def test_the_first_of_thousands_of_problems_are_shown(tmp_path: Path) -> None:
    """Where the text is long as well, without lines, which would take minutes to find."""
    for count, where in ((3000, r"scene.toml:\d+:"), (30_000, "scene.toml: ")):
        unknown = "\n".join(f"x{i} = {i}" for i in range(count))
        path = written(tmp_path, STARS.replace("[bodies.ball]", f"[bodies.ball]\n{unknown}"))
        with pytest.raises(ao.SceneFileError) as raised:
            ao.read_scene(path)
        *shown, more = str(raised.value).splitlines()
        assert len(shown) == 20
        assert all(re.search(f"{where}.*unknown name", line) for line in shown)
        assert re.search(rf"and {count - 20} more$", more)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = \n", r"scene.toml:1:5: is not TOML: Invalid value"),
        ("", "one of 'impact', 'scene' is missing"),
        ("impact = {}\nscene = {}", "'impact' and 'scene' exclude each other"),
        ("[impact]", "'bodies' is missing"),
        ("bodies = 3\nimpact = {}", ":1: bodies: must be a table, got 3"),
        (
            "materials = []\nbodies = {}\nimpact = {}",
            ":1: materials: must be a table, got a list",
        ),
    ],
)
def test_files_that_are_no_scenes(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ao.SceneFileError, match=message):
        ao.read_scene(written(tmp_path, text))


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ao.SceneFileError, match="cannot be read"):
        ao.read_scene(tmp_path / "none.toml")
    path = tmp_path / "scene.toml"
    path.write_bytes(b"title = '\xff'")
    with pytest.raises(ao.SceneFileError, match="not UTF-8"):
        ao.read_scene(path)


# ---------------------------------------------------------------------------------------- sweeps


SWEPT = """
[sweep]
keep = ["peak_force"]

[sweep.over]
velocity = [1.0, 2.0]
law.k = { from = 1e8, to = 1e10, count = 3, spacing = "log" }
bodies.beam.m0 = { from = 0.1, to = 0.3, count = 3 }
"""


def test_a_sweep_in_a_file(tmp_path: Path) -> None:
    """A row is the run of a file that has its values in it."""
    file = ao.read_scene(written(tmp_path, STARS + SWEPT))
    assert file.grid["velocity"] == [1.0, 2.0]
    assert file.grid["law.k"] == pytest.approx([1e8, 1e9, 1e10], rel=1e-15)
    assert file.grid["bodies.beam.m0"] == pytest.approx([0.1, 0.2, 0.3], rel=1e-15)
    table = sweep_file(file, workers=2)
    assert table.shape == (2, 3, 3)
    by_hand = STARS.replace("velocity = 2.0", "velocity = 1.0").replace("m0 = 0.1", "m0 = 0.3")
    last = ao.read_scene(written(tmp_path, by_hand.replace("1e9", "1e10"))).simulate()
    assert table["peak_force"].reshape(table.shape)[0, 2, 2] == last.peak_force


def test_a_sweep_over_places_in_lists(tmp_path: Path) -> None:
    over = """
[sweep.over]
scene.bodies.first.velocity = [0.0, 1.0]
scene.contacts.0.gap = { from = 0, to = 2, count = 3 }
"""
    file = ao.read_scene(written(tmp_path, ROW + over))
    assert file.grid["scene.contacts.0.gap"] == [0, 1, 2]
    changed = file.replaced({"scene.bodies.first.velocity": 1.0, "scene.contacts.0.gap": 2})
    assert changed.data["scene"]["bodies"][0]["velocity"] == 1.0
    assert changed.data["scene"]["contacts"][0]["gap"] == 2


def test_a_sweep_as_far_as_a_wall_is_written_as_json(tmp_path: Path) -> None:
    swept = "\n[sweep.over]\nbodies.beam.m0 = [0.1, inf]\nvelocity = [2.0, nan]\n"
    table = sweep_file(ao.read_scene(written(tmp_path, STARS + swept)))
    found = json.loads(as_json(rows(table)))["rows"]
    assert [row["bodies.beam.m0"] for row in found] == [0.1, 0.1, "inf", "inf"]
    assert [row["velocity"] for row in found] == [2.0, "nan"] * 2
    assert found[1]["peak_force"] is None
    assert found[0]["peak_force"] == table["peak_force"].ravel()[0]


def test_a_place_is_swept_once_whatever_it_is_called(tmp_path: Path) -> None:
    """The second would write over the first, and rows would bear the values of neither."""
    file = ao.read_scene(written(tmp_path, ROW))
    grid = {"scene.bodies.first.velocity": [0.0], "scene.bodies.0.velocity": [1.0]}
    with pytest.raises(ao.SceneFileError, match=r"same place as 'scene\.bodies\.first"):
        ao.sweep(file, grid)


@pytest.mark.parametrize(
    ("old", "new", "at", "text"),
    [
        ("velocity = [1.0", "velocty = [1.0", "velocty", "did you mean 'velocity'"),
        ("bodies.beam", "bodies.bea", "bodies.bea.", "no table 'bea' there .did you mean 'beam'"),
        ("[1.0, 2.0]", "[]", "velocity = []", "has no values"),
        ("[1.0, 2.0]", '["fast"]', 'velocity = ["', r"over.velocity: must be a number"),
        ("[1.0, 2.0]", "1.0", "velocity = 1.0", "must be a list of values, or a range such as"),
        ("to = 1e10, ", "", "law.k", "'to' is missing"),
        ("count = 3, s", "count = 0, s", "law.k", "count: must be from 1 to"),
        ("from = 1e8", "from = 0", "law.k", "'log' needs from and to above 0"),
        ('"log"', '"lag"', "law.k", "did you mean 'log'"),
        ('["peak_force"]', '["peak_forc"]', "keep", "did you mean 'peak_force'"),
        ('["peak_force"]', "[]", "keep", "sweep.keep: names nothing"),
        ("[sweep]", "[sweep]\nworkers = 0", "workers", "sweep.workers: must be at least 1, got 0"),
        (SWEPT, "\n[sweep]\nover = {}\n", "over = {}", "nothing to sweep over"),
        ("1e8, to", f"{10**400}, to", "law.k", "from: must be finite"),
        ("law.k", "impact.velocity", "impact.velocity", "is in the same place as 'velocity'"),
        ("bodies.beam.m0", "impact.law", "impact.law", "is in the same place as 'law.k'"),
    ],
)
def test_what_is_wrong_with_a_sweep(old: str, new: str, at: str, text: str, tmp_path: Path) -> None:
    assert old in SWEPT
    check_blame(tmp_path, STARS + SWEPT.replace(old, new, 1), at, text, when_read=True)


# ---------------------------------------------------------------------------------------- documents


def names(kind: Kind) -> set[str]:
    """Every name that a kind of value knows."""
    if isinstance(kind, Table):
        inside = {name for field in kind.fields.values() for name in names(field)}
        return set(kind.fields) | inside
    if isinstance(kind, Variants):
        tables = [*kind.tables.values(), *([kind.otherwise] if kind.otherwise else [])]
        return {name for table in tables for name in names(table)}
    if isinstance(kind, Tagged):
        below = {name for table in kind.tables.values() for name in names(table)}
        return {kind.key} | set(kind.tables) | below
    if isinstance(kind, Either):
        return {name for one in kind.kinds for name in names(one)}
    if isinstance(kind, (Listed, Entries, Tree)):
        return names(kind.of)
    return set()


def test_every_name_is_documented() -> None:
    text = (ROOT / "docs" / "scene-files.md").read_text("utf-8")
    documented = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]*)`|^    .*$", text, re.M))))
    documented |= set(re.findall(r"\w+", " ".join(re.findall(r"```toml(.*?)```", text, re.S))))
    assert names(scenefile_schema.SCENE_FILE) <= documented


def test_the_examples_are_right() -> None:
    for path in (ROOT / "examples").glob("*.toml"):
        ao.read_scene(path)


def test_the_examples_of_the_documents_are_right(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "scene-files.md").read_text("utf-8")
    blocks: list[Any] = re.findall(r"```toml\n(.*?)```", text, re.S)
    assert blocks
    for block in blocks:
        if block.startswith("[sweep]"):
            assert len(ao.read_scene(written(tmp_path, blocks[0] + block)).grid) == 4
        elif "duration" in block:
            ao.read_scene(written(tmp_path, block)).case()


@pytest.mark.parametrize("kind", ["[]", "{}", "3", "[1, 2]", "1979-05-27"])
def test_a_type_that_is_no_word_is_refused_where_it_stands(tmp_path: Path, kind: str) -> None:
    file = tmp_path / "a.toml"
    file.write_text(
        "[bodies]\na = { mass = 1.0 }\n[impact]\nprojectile = 'a'\ntarget = 'a'\nvelocity = 1.0\n"
        f"duration = 0.01\nlaw = {{ k = 1e9, type = {kind} }}\n"
    )
    with pytest.raises(ao.SceneFileError, match=r"a\.toml:8: impact\.law\.type: must be one"):
        ao.read_scene(file)


@pytest.mark.parametrize(
    "text", ["a = " + 3000 * "[" + 3000 * "]", "a = 1" + 5000 * "0", "a = '\0'"]
)
def test_what_no_reader_of_toml_stands_is_refused_with_the_file(tmp_path: Path, text: str) -> None:
    file = tmp_path / "deep.toml"
    file.write_text(text)
    with pytest.raises(ao.SceneFileError, match=r"deep\.toml"):
        ao.read_scene(file)


@pytest.mark.parametrize("path", [None, 3, b"a.toml", ["a.toml"]])
def test_what_is_no_path_is_refused(path: Any) -> None:
    with pytest.raises(ao.InputTypeError, match="path must be a path"):
        ao.read_scene(path)


def test_an_integer_beyond_floats_is_refused_where_it_stands(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text(
        "[bodies]\na = { mass = 1" + 400 * "0" + " }\n[impact]\nprojectile = 'a'\ntarget = 'a'\n"
        "velocity = 1.0\nduration = 0.01\nlaw = { k = 1e9, type = 'Hertz' }\n"
    )
    with pytest.raises(
        ao.SceneFileError, match=r"a\.toml:2: bodies\.a\.mass: must be finite, got an integer"
    ):
        ao.read_scene(file)


def test_a_body_that_cannot_be_built_is_named_whatever_goes_wrong(tmp_path: Path) -> None:
    body = """\
[materials.steel]
E = 210e9
nu = 0.3
rho = 7800

[bodies.bar]
mesh = { box = [0.1, 0.02, 1e-6], divisions = [2, 1, 1] }
material = "steel"
contact = { dof = 5 }
"""
    text = (
        body + 'model = { type = "antioscillators", n = 2 }\n' + BAR[BAR.index("[bodies.ball]") :]
    )
    file = written(tmp_path, text)
    with pytest.raises(ao.SingularError, match=rf"scene.toml:{line(text, 'model')}: bodies.bar"):
        ao.read_scene(file).case()


def test_what_is_left_out_follows_from_the_bodies(tmp_path: Path) -> None:
    text = """
[materials]
steel = { E = 210e9, nu = 0.3, rho = 7800 }
[bodies]
ball = { ball = 0.01, material = "steel" }
[bodies.block]
mesh = { box = [0.03, 0.03, 0.03], divisions = [3, 3, 3], kind = "hexahedron20" }
material = "steel"
contact = { point = [0.015, 0.015, 0.03] }
"""
    impact = '[impact]\nprojectile = "ball"\ntarget = "block"\nvelocity = 0.5\nrtol = 0.05\n'
    hit = ao.read_scene(written(tmp_path, text + impact)).simulate()
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    mesh = ao.box_mesh((0.03,) * 3, (3,) * 3, kind="hexahedron20")
    block = ao.FEModel.from_mesh(mesh, steel)
    same = ao.simulate(
        ao.ball(0.01, steel), block.contact(point=(0.015, 0.015, 0.03)), 0.5, rtol=0.05
    )
    assert hit.peak_force == same.peak_force
    assert hit.duration == same.duration
    scene = """
[scene]
rtol = 0.05
bodies = [{ body = "ball", velocity = 0.5 }, { body = "block" }]
contacts = [{ between = ["ball", "block"] }]
"""
    run = ao.read_scene(written(tmp_path, text + scene)).simulate()
    assert run.contacts[0].peak_force == pytest.approx(hit.peak_force, rel=0.05)


# ------------------------------------------------------------- several materials, masses, springs

TUP = """
[materials.steel]
E = 210e9
nu = 0.3
rho = 7800

[materials.ply]
orthotropic = { E = [135e9, 9e9, 9e9], G = [5e9, 5e9, 3.2e9], nu = [0.3, 0.3, 0.4] }
rho = 1550
turned = 0.5

[bodies.tup]
mesh = "tup.msh"
part = ["nose", "body"]
material = { nose = "steel", body = "ply" }
masses = [
    { z = 0.04, mass = 5.0 },
    { nodes = [1, 8, 21, 31], mass = 1.0, centre = [0, 0, 0.1], inertia = [1e-3, 1e-3, 1e-3] },
]
springs = [{ nodes = "body", along = "z", stiffness = 1e4 }]
contact = { point = [0.01, 0.01, 0.0], direction = [0, 0, -1], radius = 0.0 }
model = { type = "antioscillators", n = 2, method = "krylov", contact_time = 1.6e-3 }

[bodies.wall]
mass = inf

[impact]
projectile = "tup"
target = "wall"
velocity = 1.0
duration = 5e-3
law = { type = "Hertz", k = 1e9 }
"""


def write_tup(folder: Path) -> ao.Mesh:
    """A bar along z of two groups, and a third body beside it in the same file."""
    bar = ao.box_mesh((0.02, 0.02, 0.04), (2, 2, 4))
    cells = [bar.cells[bar.nodes[bar.cells].mean(axis=1)[:, 2] < 0.01]]
    cells += [bar.cells[bar.nodes[bar.cells].mean(axis=1)[:, 2] > 0.01], bar.cells + bar.n_nodes]
    tags = [np.full(len(part), i + 1) for i, part in enumerate(cells)]
    raw = meshio.Mesh(
        np.vstack([bar.nodes, bar.nodes + np.array([1.0, 0.0, 0.0])]),
        [("hexahedron", part) for part in cells],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={n: np.array([i + 1, 3]) for i, n in enumerate(("nose", "body", "other"))},
    )
    raw.write(folder / "tup.msh", file_format="gmsh22", binary=False)
    return bar


def test_a_body_of_groups_with_masses_and_springs(tmp_path: Path) -> None:
    write_tup(tmp_path)
    (tmp_path / "tup.toml").write_text(TUP)
    scene = ao.read_scene(tmp_path / "tup.toml")
    assert scene.simulate().peak_force > 0.0
    body = scene.case()["projectile"].origin.tip.body
    ply = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), 1550).turned(0.5)
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    assert body.mass == pytest.approx(7800 * 4e-6 + 1550 * 12e-6 + 6.0)
    same = ao.FEModel.from_mesh(
        tmp_path / "tup.msh",
        {"nose": steel, "body": ply},
        masses=[
            (lambda x: np.abs(x[:, 2] - 0.04) < 1e-9, 5.0),
            ao.RigidMass([1, 8, 21, 31], 1.0, (0, 0, 0.1), (1e-3, 1e-3, 1e-3)),
        ],
        springs=[("body", "z", 1e4)],
        part=["nose", "body"],
    )
    assert (same.K != body.K).nnz == 0
    assert (same.M != body.M).nnz == 0
    (tmp_path / "tup.toml").write_text(TUP.replace("[bodies.tup]", "[bodies.tup]\norder = 2"))
    finer = ao.read_scene(tmp_path / "tup.toml").case()["projectile"].origin.tip.body
    assert finer.mesh.kind == "hexahedron20"


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ('nose = "steel", ', "", "material =", "4 of 16 elements have none.*'nose'"),
        ('nose = "steel"', 'noze = "steel"', "material =", "did you mean 'nose'"),
        ('body = "ply" }', 'body = "plie" }', "material =", "did you mean 'ply'"),
        ('["nose", "body"]', '["nos"]', "mesh =", "no group of elements 'nos'"),
        ("mass = 5.0", "mass = -5.0", "[bodies.tup]", "mass must be positive"),
        ('along = "z"', 'along = "w"', "[bodies.tup]", 'letters must be of "x"'),
        ("nu = [0.3, 0.3, 0.4]", "nu = [0.3, 0.4]", "orthotropic =", "must have 3 entries"),
        ("stiffness = 1e4", "k = 1e4", "springs =", "unknown name 'k'|'stiffness' is missing"),
    ],
)
def test_wrong_groups_masses_and_springs_name_the_line(
    tmp_path: Path, old: str, new: str, line: str, said: str
) -> None:
    write_tup(tmp_path)
    assert old in TUP
    text = TUP.replace(old, new)
    (tmp_path / "tup.toml").write_text(text)
    number = next(i for i, row in enumerate(text.splitlines(), 1) if row.startswith(line))
    with pytest.raises(ao.SceneFileError, match=rf"tup.toml:{number}: .*({said})"):
        ao.read_scene(tmp_path / "tup.toml").simulate()
