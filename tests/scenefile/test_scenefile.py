"""Scene files run what the same calls run in Python."""

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
import scipy
from every_law import LAWS as EVERY_LAW
from every_law import law_of

import aoimpact as ao
from aoimpact.scenefile import SceneFile

from scenes import BAR, ROW, STARS, SWEPT

ROOT = Path(__file__).parents[2]
ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
CARBON = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
CROSSED = ao.Hertz.between(ALU, (0.01, math.inf), ALU, 0.02, angle=0.5)

MATERIALS = """
[materials]
steel = { E = 210e9, nu = 0.3, rho = 7800 }
alu = { E = 70e9, nu = 0.3, rho = 2700 }
sheet = { shell = "steel", thickness = 2e-3 }
bar = { beam = "steel", section = { width = 0.02, height = 0.01 }, orientation = [0, 0, 1] }
tube = { beam = "steel", section = { radius = 0.01, thickness = 1e-3 }, offset = [0, 0] }

[materials.carbon]
orthotropic = { E = [135e9, 9e9, 9e9], G = [5e9, 5e9, 3.2e9], nu = [0.3, 0.3, 0.4] }
rho = 1550

[materials.turned]
orthotropic = { E = [135e9, 9e9, 9e9], G = [5e9, 5e9, 3.2e9], nu = [0.3, 0.3, 0.4] }
rho = 1550
turned = 0.5

[materials.stack]
fibre_axis = [1, 0, 0]
laminate = [
  { thickness = 1e-3, material = "carbon" },
  { thickness = 1e-3, material = "carbon", angle_deg = 90 },
]
"""
IMPACT = """
[impact]
projectile = "ball"
target = "body"
velocity = 1.0
duration = 60e-6
law = { type = "Hertz", k = 1e9 }
"""


def read(folder: Path, text: str) -> SceneFile:
    """The scene file of a text."""
    text = "\ufeff" + text.replace("\n", "\r\n")  # as of Windows
    (folder / "scene.toml").write_bytes(text.encode())
    return ao.read_scene(folder / "scene.toml")


def body_of(folder: Path, text: str) -> ao.FEModel:
    """The finite-element body of a file that has one, called "body"."""
    ball = "[bodies.ball]\nmass = 0.03\n"
    (tip,) = read(folder, MATERIALS + ball + text + IMPACT).case()["target"].tips
    model: ao.FEModel = tip.body
    return model


def same_matrices(one: ao.FEModel, other: ao.FEModel) -> bool:
    return bool((one.K != other.K).nnz == 0 and (one.M != other.M).nnz == 0)


def test_an_impact_is_the_same_as_in_python(tmp_path: Path) -> None:
    hit = read(tmp_path, STARS).simulate()
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


def test_a_body_is_fixed_and_touched_as_in_python(tmp_path: Path) -> None:
    target = read(tmp_path, BAR).case()["target"]
    mesh = ao.box_mesh((0.1, 0.01, 0.01), (4, 1, 1))
    bar = ao.FEModel.from_mesh(mesh, ALU, fixed=[("xmin", "xyz"), ([4, 5], "z")])
    same = ao.antioscillators(bar.contact(point=(0.1, 0, 0), direction=(0, 0, 1), radius=0), n=2)
    assert np.array_equal(target.m, same.m)
    assert np.array_equal(target.k, same.k)


@pytest.mark.parametrize(
    ("model", "label"), [('"full"', "full"), ('"modal", n = 3', "modal(3)"), ("", "AO(")]
)
def test_every_kind_of_model(model: str, label: str, tmp_path: Path) -> None:
    text = BAR.replace('type = "antioscillators", n = 2', f"type = {model}")
    text = text if model else text.replace("model = { type =  }", "")
    assert read(tmp_path, text).simulate().target.label.startswith(label)


def test_a_support_on_planes_is_the_edge_where_they_meet(tmp_path: Path) -> None:
    text = (
        '[bodies.body]\nmaterial = "alu"\nmesh = { box = [0.1, 0.01, 0.01], '
        'divisions = [4, 1, 1] }\nfixed = [{ x = 0.0, z = 0.0, hold = "xyz" }]\n'
        "contact = { dof = 5 }\n"
    )
    mesh = ao.box_mesh((0.1, 0.01, 0.01), (4, 1, 1))
    edge = np.flatnonzero((mesh.nodes[:, 0] == 0.0) & (mesh.nodes[:, 2] == 0.0))
    same = ao.FEModel.from_mesh(mesh, ALU, fixed=[(edge, "xyz")])
    assert same_matrices(body_of(tmp_path, text), same)


def test_meshes_lie_beside_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = ao.box_mesh((100.0, 10.0, 10.0), (4, 1, 1))  # mm
    folder = tmp_path / "scene"
    folder.mkdir()
    meshio.Mesh(mesh.nodes, [("hexahedron", mesh.cells)]).write(folder / "bar.vtu")
    monkeypatch.chdir(tmp_path)
    text = '[bodies.body]\nmesh = { file = "bar.vtu", scale = 1e-3 }\nmaterial = "alu"\n'
    body = body_of(folder, text + "contact = { dof = 5 }\n")
    assert body.mass == pytest.approx(2700 * 0.1 * 0.01**2)


MATRICES = """
[bodies.body]
matrices = { K = "K.mtx", M = "M.npz", dofs = "dofs.txt", nodes = "nodes.txt", mass = 2.0 }
contact = { node = 5, direction = [0, 0, -1] }
damping = { ratio = 0.01 }
"""


def test_a_body_of_matrices(tmp_path: Path) -> None:
    body = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.02), (4, 1, 1)), ALU)
    ao.write_matrices(body, tmp_path)
    scipy.sparse.save_npz(tmp_path / "M.npz", body.M)
    found = body_of(tmp_path, MATRICES)
    assert found.mass == pytest.approx(2.0 * body.mass)
    assert found.damping == ao.ModalDamping(ratio=0.01)


def test_a_body_of_groups_with_masses_and_springs(tmp_path: Path) -> None:
    """A bar along z of two groups, and a third body beside it in the same file."""
    bar = ao.box_mesh((0.02, 0.02, 0.04), (2, 2, 4))
    low = bar.nodes[bar.cells].mean(axis=1)[:, 2] < 0.01
    cells = [bar.cells[low], bar.cells[~low], bar.cells + bar.n_nodes]
    tags = [np.full(len(part), i + 1) for i, part in enumerate(cells)]
    raw = meshio.Mesh(
        np.vstack([bar.nodes, bar.nodes + np.array([1.0, 0.0, 0.0])]),
        [("hexahedron", part) for part in cells],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={n: np.array([i + 1, 3]) for i, n in enumerate(("nose", "rest", "other"))},
    )
    raw.write(tmp_path / "tup.msh", file_format="gmsh22", binary=False)
    text = """
[bodies.body]
mesh = "tup.msh"
part = ["nose", "rest"]
material = { nose = "steel", rest = "turned" }
masses = [
    { z = 0.04, mass = 5.0 },
    { nodes = [1, 8, 21, 31], mass = 1.0, centre = [0, 0, 0.1], inertia = [1e-3, 1e-3, 1e-3] },
]
springs = [{ nodes = "rest", along = "z", stiffness = 1e4 }]
contact = { point = [0.01, 0.01, 0.0], direction = [0, 0, -1], radius = 0.0 }
"""
    same = ao.FEModel.from_mesh(
        tmp_path / "tup.msh",
        {"nose": STEEL, "rest": CARBON.turned(0.5)},
        masses=[
            (lambda x: np.abs(x[:, 2] - 0.04) < 1e-9, 5.0),
            ao.RigidMass([1, 8, 21, 31], 1.0, (0, 0, 0.1), (1e-3, 1e-3, 1e-3)),
        ],
        springs=[("rest", "z", 1e4)],
        part=["nose", "rest"],
    )
    assert same_matrices(body_of(tmp_path, text), same)
    finer = body_of(tmp_path, text.replace("[bodies.body]", "[bodies.body]\norder = 2"))
    assert finer.mesh is not None
    assert finer.mesh.kind == "hexahedron20"


@pytest.mark.parametrize(
    ("name", "layers"),
    [
        ("sheet", ao.Shell(2e-3, STEEL)),
        ("stack", ao.Laminate([ao.Ply(1e-3, CARBON), ao.Ply(1e-3, CARBON, 90)], (1, 0, 0))),
    ],
)
def test_shells_and_laminates(name: str, layers: ao.Shell, tmp_path: Path) -> None:
    text = f"""
[bodies.body]
mesh = {{ sheet = [0.1, 0.1], divisions = [10, 10] }}
material = "{name}"
fixed = [{{ nodes = "rim", hold = "xyz", hold_rotations = "xyz" }}]
contact = {{ point = [0.05, 0.05, 0.0] }}
"""
    mesh = ao.sheet_mesh((0.1, 0.1), (10, 10))
    same = ao.FEModel.from_mesh(mesh, layers, fixed=[("rim", "xyz", "xyz")])
    assert same_matrices(body_of(tmp_path, text), same)


DECK = """*NODE
1, 0, 0, 0
2, 100., 0, 0
3, 100., 100., 0
4, 0, 100., 0
*ELEMENT, TYPE=S4, ELSET=SKIN
1, 1, 2, 3, 4
*ELEMENT, TYPE=B31, ELSET=RIB
2, 1, 2
"""
CARDS = """*MATERIAL, NAME=ALU
*ELASTIC
70000., 0.33
*DENSITY
2.7E-9
*SHELL SECTION, ELSET=SKIN, MATERIAL=ALU
2.
*BEAM SECTION, ELSET=RIB, MATERIAL=ALU, SECTION=PIPE
5., 1.
"""


def test_a_deck_has_sections_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "a.inp").write_text(DECK + CARDS)
    text = '[bodies.body]\nmesh = { file = "a.inp", scale = 1e-3 }\ncontact = { node = 3 }\n'
    mass = 2700 * (0.1 * 0.1 * 2e-3 + 0.1 * np.pi * (5e-3**2 - 4e-3**2))
    assert body_of(tmp_path, text).mass == pytest.approx(mass, rel=1e-9)


# ------------------------------------------------------------------------------------------ laws


def law_in(folder: Path, text: str) -> ao.ContactLaw:
    """The law of a scene file that has this one."""
    law: ao.ContactLaw = read(folder, BAR.replace('type = "Linear", k = 1e6', text)).case()["law"]
    return law


def toml(value: Any) -> str:
    """A parameter of a law as a scene file has it."""
    return f"[{', '.join(map(toml, value))}]" if isinstance(value, tuple) else json.dumps(value)


# All but those of functions, and those made for patches.
@pytest.mark.parametrize("name", [n for n in sorted(EVERY_LAW) if n[:5] not in ("UserL", "patch")])
def test_every_law_by_its_parameters(name: str, tmp_path: Path) -> None:
    law: Any = law_of(name)
    given = {field.name.removesuffix("_values"): getattr(law, field.name) for field in fields(law)}
    pairs = [f"{key} = {toml(value)}" for key, value in given.items() if value is not None]
    assert law_in(tmp_path, ", ".join([f'type = "{type(law).__name__}"', *pairs])) == law


PAIR = '{ material = "alu", radius = 0.01 }, { material = "alu", radius = inf }'
OVAL = '{ material = "alu", radius = [0.01, inf] }, { material = "alu", radius = 0.02 }'


@pytest.mark.parametrize(
    ("law", "same"),
    [
        (
            '"HuntCrossley", k = 1e9, restitution = 0.7, velocity = 2.0',
            ao.HuntCrossley.from_restitution(1e9, 0.7, 2.0),
        ),
        (
            '"KelvinVoigt", k = 1e6, restitution = 0.7, mass = 0.1, end = "indentation"',
            ao.KelvinVoigt.from_restitution(1e6, 0.7, 0.1, end="indentation"),
        ),
        (
            f'"Thornton", yield_pressure = 2e9, k = {{ between = [{PAIR}] }}',
            ao.Thornton.between(ALU, 0.01, ALU, math.inf, yield_pressure=2e9),
        ),
        (
            f'"ElasticPlastic", hardness = 1e9, k = {{ between = [{PAIR}] }}',
            ao.ElasticPlastic.between(ALU, 0.01, ALU, math.inf, hardness=1e9),
        ),
        (f'"Hertz", k = {{ between = [{OVAL}], angle = 0.5 }}', CROSSED),
        (
            f'"HuntCrossley", damping = 0.2, k = {{ between = [{OVAL}], angle = 0.5 }}',
            ao.HuntCrossley(CROSSED.k, 0.2, relative_radius=CROSSED.relative_radius),
        ),
    ],
)
def test_laws_by_what_they_deliver(law: str, same: ao.ContactLaw, tmp_path: Path) -> None:
    assert law_in(tmp_path, f"type = {law}") == same


# ----------------------------------------------------------------------------- impacts and scenes


def test_patches_damping_and_linear_solvers(tmp_path: Path) -> None:
    """The radius by itself, the direction by the surface, Rayleigh's damping."""
    text = """
[bodies.body]
mesh = { box = [0.06, 0.06, 0.03], divisions = [8, 8, 4] }
material = "steel"
damping = { beta = 1e-8 }
contact = { point = [0.03, 0.03, 0.03], radius = "auto", expected = 0.004 }
model = { type = "antioscillators", n = 2, method = "krylov", duration = 1e-3, solver = "superlu" }
"""
    ball = "[bodies.ball]\nmass = 0.03\n"
    target = read(tmp_path, MATERIALS + ball + text + IMPACT).case()["target"]
    block = ao.FEModel.from_mesh(ao.box_mesh((0.06, 0.06, 0.03), (8, 8, 4)), STEEL)
    same = block.contact(point=(0.03, 0.03, 0.03), radius="auto", expected=0.004)
    (tip,) = target.tips
    assert tip.patch.radius == same.patch.radius
    np.testing.assert_allclose(tip.direction, [0, 0, -1], atol=1e-12)
    assert target.damping == ao.Rayleigh(beta=1e-8)
    assert target.origin.linear_solver == "superlu"


SENSORS = """
moved = { body = "bar", point = [0.05, 0.005, 0], direction = [0, 0, 1] }
gauge = { type = "StrainAt", body = "bar", point = [0.05, 0.005, 0], component = [1, 0, 0], length = 3e-3 }
strain = { type = "StrainAt", body = "bar", point = [0.05, 0.005, 0], component = "xx" }
stress = { type = "StressAt", body = "bar", point = [0.05, 0.005, 0] }
shock = { type = "AccelerationAt", body = "bar", point = [0.05, 0.005, 0], direction = [0, 0, 2], cfc = 4000 }
held = { type = "ReactionAt", body = "bar", nodes = [0, 1, 2], direction = [0, 0, 1] }
"""  # noqa: E501
SCENE = (
    BAR[: BAR.index("[impact]")]
    + """
[scene]
duration = 1e-3
bodies = [{ body = "ball", velocity = 1.0 }, { body = "bar" }]
[[scene.contacts]]
between = ["ball", "bar"]
law = { type = "ElasticPlastic", k = 1e9, yield_force = 1.0, hardness = 4e8, relative_radius = 1e-2}
"""
)


@pytest.mark.parametrize(("kind", "text"), [("impact", BAR), ("scene", SCENE)])
@pytest.mark.filterwarnings("ignore:.*may be off by", "ignore:.*known behind the filter")
def test_probes_read_what_the_sensors_of_a_result_read(
    kind: str, text: str, tmp_path: Path
) -> None:
    file = read(tmp_path, f"{text}\n[{kind}.probes]\n{SENSORS}")
    run = file.simulate()
    bar, t, at = run.bodies[1], run.t, (0.05, 0.005, 0.0)
    probe = bar.probe(at, (0, 0, 1), times=t)
    known = {
        "moved": probe.displacement,
        "gauge": bar.gauge(at, (1, 0, 0), 3e-3, times=t).strain,
        "strain": probe.strain["xx"],
        "stress": probe.stress.von_mises,
        "shock": probe.filtered(cfc=4000).acceleration,
        "held": bar.reaction([0, 1, 2], times=t).force[:, 2],
    }
    found = file.probes(run)
    assert list(found) == list(known)
    for name, values in known.items():
        np.testing.assert_allclose(
            found[name], values, rtol=0, atol=1e-9 * np.nanmax(np.abs(values))
        )


@pytest.mark.parametrize(
    "name", ["stress", pytest.param("shock", marks=pytest.mark.slow), "held", "moved"]
)
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_a_sensor_may_be_what_is_asked_for(name: str, tmp_path: Path) -> None:
    sensor = re.search(rf"{name} = (.*)", SENSORS)[1].replace("4000", "10000")  # type: ignore[index]
    text = BAR.replace('model = { type = "antioscillators", n = 2 }', "")
    hit = read(tmp_path, text + f"quantity = {sensor}\nrtol = 0.1\n").simulate()
    assert hit.error.model <= 0.1
    assert hit.target.label.startswith("AO(")


def test_a_scene_of_several_bodies(tmp_path: Path) -> None:
    file = read(tmp_path, ROW)
    scene = ao.Scene(gravity=9.81)
    first = scene.add(ao.rigid(mass=0.03), velocity=1.0, position=-1e-3)
    second = scene.add(ao.rigid(mass=0.03))
    wall = scene.add(ao.rigid(mass=math.inf), position=2e-3)
    scene.connect(first, second, ao.Hertz(k=1e10))
    scene.connect(second, wall, ao.Linear(k=1e7), gap=1e-3)
    scene.apply(second, force=([0.0, 1e-3], [0.0, 2.0]))
    same = scene.simulate(duration=1e-2, solver=ao.Adaptive(rtol=1e-9))
    for ours, theirs in zip(file.simulate().contacts, same.contacts, strict=True):
        assert np.array_equal(ours.force, theirs.force)
    (kept,) = ao.simulate_many([file.case()], keep=file.reported)
    assert kept["contacts.1.peak_force"] == same.contacts[1].peak_force


@pytest.mark.parametrize("quantity", ['"force"', '"ball"', '{ body = "bar", port = 1 }'])
def test_a_body_touched_in_several_places(quantity: str, tmp_path: Path) -> None:
    contact = "contact = { point = [0.1, 0.0, 0.0], direction = [0, 0, 1], radius = 0 }"
    other = "{ point = [0.05, 0.0, 0.0], direction = [0, 0, 1], radius = 0 }"
    scene = f"""
[scene]
duration = 1e-3
quantity = {quantity}
rtol = 0.05
bodies = [{{ body = "bar" }}, {{ body = "ball", velocity = 1.0 }}]
[[scene.contacts]]
between = ["ball", {{ body = "bar", port = 1 }}]
law = {{ type = "Linear", k = 1e6 }}
"""
    text = BAR[: BAR.index("[impact]")].replace('model = { type = "antioscillators", n = 2 }', "")
    both = text.replace(contact, f"contact = [{contact[10:]}, {other}]")
    run = read(tmp_path, both + scene).simulate()
    assert run.models[0].label.startswith("interface(")
    one = text.replace(contact, f"contact = {other}")
    bar = read(tmp_path, one + BAR[BAR.index("[impact]") :]).simulate()
    assert run.contacts[0].peak_force == pytest.approx(bar.peak_force, rel=0.1)


# ---------------------------------------------------------------------------------------- sweeps


def test_a_row_of_a_sweep_is_the_run_of_a_file_with_its_values(tmp_path: Path) -> None:
    file = read(tmp_path, STARS + SWEPT)
    assert file.grid["velocity"] == [1.0, 2.0]
    assert file.grid["law.k"] == pytest.approx([1e8, 1e9, 1e10], rel=1e-15)
    table = ao.sweep(file, file.grid, keep=file.swept)
    assert table.shape == (2, 3, 3)
    by_hand = STARS.replace("velocity = 2.0", "velocity = 1.0").replace("m0 = 0.1", "m0 = 0.3")
    last = read(tmp_path, by_hand.replace("1e9", "1e10")).simulate()
    assert table["peak_force"].reshape(table.shape)[0, 2, 2] == last.peak_force


def test_a_file_reports_every_number_of_a_run(tmp_path: Path) -> None:
    run = read(tmp_path, ROW).simulate()
    names = ", ".join(f'"{name}"' for name in run.numbers)
    file = read(tmp_path, ROW.replace("[scene]", f"[scene]\nreport = [{names}]"))
    assert file.reported == tuple(run.numbers)


def test_places_in_lists_go_by_number_or_name(tmp_path: Path) -> None:
    over = """
[sweep.over]
scene.bodies.first.velocity = [0.0, 1.0]
scene.contacts.0.gap = { from = 0, to = 2, count = 3 }
"""
    file = read(tmp_path, ROW + over)
    assert file.grid["scene.contacts.0.gap"] == [0, 1, 2]
    changed = file.replaced({"scene.bodies.first.velocity": 1.0, "scene.contacts.0.gap": 2})
    assert changed.data["scene"]["bodies"][0]["velocity"] == 1.0
    assert changed.data["scene"]["contacts"][0]["gap"] == 2


# -------------------------------------------------------------------------------- documents


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.toml")), ids=lambda p: p.stem)
def test_the_examples_are_right(path: Path) -> None:
    assert ao.read_scene(path).reported


@pytest.mark.slow
def test_the_example_is_the_paper_s_impact() -> None:
    scene = ao.read_scene(ROOT / "examples" / "sphere_on_beam.toml")
    sphere = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), STEEL)
    tip = sphere.contact(point=(0.01, 0, 0), direction=(1, 0, 0), radius=0)
    again = ao.simulate(**scene.case() | {"projectile": ao.antioscillators(tip, n=1)})
    assert scene.simulate().peak_force == again.peak_force


def test_the_examples_of_the_documents_are_right(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "scene-files.md").read_text("utf-8")
    blocks: list[Any] = re.findall(r"```toml\n(.*?)```", text, re.S)
    assert blocks
    for block in blocks:
        if block.startswith("[sweep]"):
            assert len(read(tmp_path, blocks[0] + block).grid) == 4
        elif "duration" in block:
            read(tmp_path, block).case()
