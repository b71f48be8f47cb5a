"""
An impact on a deck of Abaqus, CalculiX or Nastran
==================================================

A deck holds more than a mesh: thickness, plies, beams and materials. :func:`aoimpact.read_sections` reads them by the
groups that the mesh has, in the deck's units, so that a deck is a body without a second description.
"""

import tempfile
from pathlib import Path

import aoimpact as ao

# %%
# A small deck of Abaqus, in millimetres, newtons, tonnes and seconds: a plate of 200 × 120 × 2 mm with a rib of
# 20 × 4 mm along its middle line, half above and half below it, and the set EDGE of the nodes on its short edges. Yours is
# a file already.

nx, ny, size = 40, 24, 5
node = [[1 + i + (nx + 1) * j for i in range(nx + 1)] for j in range(ny + 1)]
nodes = [f"{node[j][i]}, {i * size}, {j * size}, 0" for j in range(ny + 1) for i in range(nx + 1)]
quads = [
    f"{1 + i + nx * j}, {node[j][i]}, {node[j][i + 1]}, {node[j + 1][i + 1]}, {node[j + 1][i]}"
    for j in range(ny)
    for i in range(nx)
]
bars = [f"{5001 + i}, {node[ny // 2][i]}, {node[ny // 2][i + 1]}" for i in range(nx)]
cards = """*MATERIAL, NAME=ALU
*ELASTIC
70000, 0.33
*DENSITY
2.7E-9
*SHELL SECTION, ELSET=SKIN, MATERIAL=ALU
2.
*BEAM SECTION, ELSET=RIB, MATERIAL=ALU, SECTION=RECT
20., 4.
0, 0, 1
"""
lines = ["*NODE", *nodes, "*ELEMENT, TYPE=S4, ELSET=SKIN", *quads]
lines += ["*ELEMENT, TYPE=B31, ELSET=RIB", *bars, "*NSET, NSET=EDGE"]
lines += [f"{row[0]}, {row[-1]}" for row in node]
deck = Path(tempfile.mkdtemp()) / "plate.inp"
_ = deck.write_text("\n".join([*lines, cards]))

# %%
# From the deck to an answer these are six lines. ``scale`` is the deck's unit of length in metres; ``force`` and ``time``
# are 1 N and 1 s unless you say otherwise. Loads, steps and supports of a deck are not read: ``fixed`` names its sets.

sections = ao.read_sections(deck, scale=1e-3)
mesh = ao.read_mesh(deck, scale=1e-3, part=list(sections))
plate = ao.FEModel.from_mesh(mesh, sections, fixed=[("EDGE", "xyz", "xyz")])
tip = plate.contact(point=(0.1, 0.03, 0.0), direction=(0, 0, -1))
ball = ao.ball(radius=0.005, material=ao.Material(E=210e9, nu=0.3, rho=7800))
hit = ao.simulate(ball, tip, velocity=2.0, quantity="peak_force", rtol=0.02)

# %%
# The answer, and the force:

print(hit)
ax = hit.plot_force()

# %%
# Look at what was read, in SI units, before you believe the rest:

for name, section in sections.items():
    print(name, section)
print(plate)
print("frequencies:", plate.frequencies(4).round(), "Hz")

# %%
# What a deck says in another way
# -------------------------------
# A card that is not understood, and would change the answer, is refused by its line. ``given=`` takes the place of such a
# card: a material by its name, or a whole section by that of its group. Here the rib is said to be a tube:

tube = ao.Beam(ao.TubularSection(radius=8e-3, thickness=1e-3), ao.Material(70e9, 0.33, 2700))
print(ao.read_sections(deck, scale=1e-3, given={"RIB": tube})["RIB"])
