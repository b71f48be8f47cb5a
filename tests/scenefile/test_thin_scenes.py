"""Shells, laminates and beams in scene files are those of Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

MATERIALS = """
[materials.carbon]
orthotropic = { E = [135e9, 9e9, 9e9], G = [5e9, 5e9, 3.2e9], nu = [0.3, 0.3, 0.4] }
rho = 1550

[materials]
steel = { E = 210e9, nu = 0.3, rho = 7800 }
sheet = { shell = "steel", thickness = 2e-3 }
bar = { beam = "steel", section = { width = 0.02, height = 0.01 }, orientation = [0, 0, 1] }
tube = { beam = "steel", section = { radius = 0.01, thickness = 1e-3 }, offset = [0, 0] }

[materials.stack]
fibre_axis = [1, 0, 0]
laminate = [
  { thickness = 1e-3, material = "carbon" },
  { thickness = 1e-3, material = "carbon", angle_deg = 90 },
]
"""

IMPACT = """
[bodies.ball]
ball = 0.005
material = "steel"

[bodies.plate]
mesh = { sheet = [0.1, 0.1], divisions = [20, 20] }
material = "MATERIAL"
fixed = [{ nodes = "rim", hold = "xyz", hold_rotations = "xyz" }]
contact = { point = [0.05, 0.05, 0.0] }

[impact]
projectile = "ball"
target = "plate"
velocity = 1.0
duration = 60e-6
quantity = "peak_force"
"""

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
CARBON = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)


@pytest.mark.parametrize(
    ("name", "layers"),
    [
        ("sheet", ao.Shell(2e-3, STEEL)),
        ("stack", ao.Laminate([ao.Ply(1e-3, CARBON), ao.Ply(1e-3, CARBON, 90)], (1, 0, 0))),
    ],
)
@pytest.mark.filterwarnings("ignore:.*the record of:aoimpact.AOImpactWarning")
def test_a_plate_of_a_file(name: str, layers: ao.Shell, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(MATERIALS + IMPACT.replace("MATERIAL", name))
    found = ao.read_scene(tmp_path / "a.toml").simulate()
    plate = ao.FEModel.from_mesh(
        ao.sheet_mesh((0.1, 0.1), (20, 20)), layers, fixed=[("rim", "xyz", "xyz")]
    )
    hit = ao.simulate(
        ao.ball(0.005, STEEL),
        plate.contact(point=(0.05, 0.05, 0)),
        1.0,
        duration=60e-6,
        quantity="peak_force",
    )
    assert found.peak_force == pytest.approx(hit.peak_force, rel=1e-12)


DECK = """*NODE
1, 0, 0, 0
2, 0.1, 0, 0
3, 0.1, 0.1, 0
4, 0, 0.1, 0
*ELEMENT, TYPE=S4, ELSET=SKIN
1, 1, 2, 3, 4
*ELEMENT, TYPE=B31, ELSET=RIB
2, 1, 2
"""


@pytest.mark.parametrize(
    ("sensor", "layer", "part"),
    [
        ('"StressAt", layer = [1, "bottom"]', (1, "bottom"), None),
        ('"StressAt", layer = [0.0, 0.005], part = "RIB"', (0.0, 0.005), "RIB"),
        ('"StrainAt", layer = "bottom", part = "SKIN"', "bottom", "SKIN"),
    ],
)
def test_a_layer_and_a_part_of_a_sensor(
    sensor: str, layer: Any, part: str | None, tmp_path: Path
) -> None:
    (tmp_path / "a.inp").write_text(DECK)
    text = MATERIALS + IMPACT.replace('"MATERIAL"', '{ SKIN = "stack", RIB = "bar" }')
    text = text.replace("{ sheet = [0.1, 0.1], divisions = [20, 20] }", '"a.inp"')
    text = text.replace('nodes = "rim"', "nodes = [3, 4]")
    wanted = f"{{ type = {sensor}, component = 'xx', body = 'plate', point = [0.05, 0, 0] }}"
    (tmp_path / "a.toml").write_text(text.replace('"peak_force"', wanted))
    found = ao.read_scene(tmp_path / "a.toml").case()["quantity"]
    assert (type(layer)(found.layer), found.part) == (layer, part)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('shell = "steel"', 'shell = "stack"', "'sheet' is made of 'stack', which is no material"),
        ('shell = "steel"', 'shell = "sheet"', "'sheet' is made of 'sheet', which is no material"),
        ('shell = "steel"', 'shell = "stele"', "steel"),
        ("thickness = 2e-3 }", "thickness = -2e-3 }", "thickness"),
        ('"plate"\nvelocity', '"plate"\nvelocity', "needs ao.Shell"),
        ("hold_rotations", "hold_turns", "hold_rotations"),
    ],
)
def test_refusals(old: str, new: str, words: str, tmp_path: Path) -> None:
    name = "bar" if words == "needs ao.Shell" else "sheet"
    text = (MATERIALS + IMPACT.replace("MATERIAL", name)).replace(old, new)
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(ao.AOImpactError, match=words):
        ao.read_scene(tmp_path / "a.toml").simulate()


CARDS = """*MATERIAL, NAME=ALU
*ELASTIC
70000., 0.33
*DENSITY
2.7E-9
*SHELL SECTION, ELSET=SKIN, MATERIAL=ALU, OFFSET=SPOS
2.
*BEAM SECTION, ELSET=RIB, MATERIAL=ALU, SECTION=PIPE
5., 1.
"""


def test_a_deck_has_sections_of_its_own(tmp_path: Path) -> None:
    deck = DECK.replace("0.1", "100.") + CARDS
    (tmp_path / "a.inp").write_text(deck)
    text = MATERIALS + IMPACT.replace('material = "MATERIAL"\n', "")
    text = text.replace('nodes = "rim"', "nodes = [3, 4]")
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(
        ao.SceneFileError, match=r"a\.toml:24: bodies.plate.mesh: material is missing"
    ):
        ao.read_scene(tmp_path / "a.toml").case()
    text = text.replace(
        "{ sheet = [0.1, 0.1], divisions = [20, 20] }", '{ file = "a.inp", scale = 1e-3 }'
    )
    (tmp_path / "a.toml").write_text(text)
    body = ao.read_scene(tmp_path / "a.toml").case()["target"].contact_points[0].body
    mass = 2700 * (0.1 * 0.1 * 2e-3 + 0.1 * np.pi * (5e-3**2 - 4e-3**2))
    assert body.mass == pytest.approx(mass, rel=1e-9)
