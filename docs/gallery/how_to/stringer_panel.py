"""
A ball on a stringer panel
==========================

Panels, shells and frames are thin: a mesh of their surfaces is enough. Surface elements become shells
(:class:`aoimpact.Shell`, :class:`aoimpact.Laminate`), line elements beams (:class:`aoimpact.Beam`). Here a steel ball of
10 mm diameter falls on the skin of a carbon panel with three stringers. From the geometry to the stress in a ply these
are 30 lines.
"""

import tempfile

import gmsh
import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

# %%
# The mesh: a skin of 300 × 200 mm and three webs of 20 mm below it, by gmsh. Quadrilaterals bend better than triangles.

length, width, height, size = 0.3, 0.2, 0.02, 0.005
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
geo = gmsh.model.geo
edge, skin, webs = [(0, geo.addPoint(0, 0, 0))], [], []
lines = [geo.extrude(edge, length, 0, 0, [round(length / size)], recombine=True)[1]]
for _ in range(4):
    moved = geo.extrude([lines[-1]], 0, width / 4, 0, [round(width / 4 / size)], recombine=True)
    lines.append(moved[0])
    skin.append(moved[1][1])
for line in lines[1:4]:
    down = geo.extrude([line], 0, 0, -height, [round(height / size)], recombine=True)
    webs.append(down[1][1])
geo.synchronize()
gmsh.model.addPhysicalGroup(2, skin, name="skin")
gmsh.model.addPhysicalGroup(2, webs, name="webs")
gmsh.model.mesh.generate(2)
folder = tempfile.TemporaryDirectory()
gmsh.write(f"{folder.name}/panel.msh")
gmsh.finalize()

# %%
# The panel: 16 plies of carbon in the skin, aluminium webs, and the skin's short edges held. ``fixed`` names displacements
# and, after them, rotations. Plies are stacked along the elements' normals.

carbon = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
angles = (45, 0, -45, 90) * 2
stack = [ao.Ply(0.125e-3, carbon, angle) for angle in (*angles, *reversed(angles))]
alu = ao.Material(E=70e9, nu=0.33, rho=2700)
panel = ao.FEModel.from_mesh(
    f"{folder.name}/panel.msh",
    {"skin": ao.Laminate(stack, fibre_axis=(1, 0, 0)), "webs": ao.Shell(1.5e-3, alu)},
    fixed=[(lambda x: (x[:, 0] < 1e-9) | (x[:, 0] > length - 1e-9), "xyz", "xyz")],
    name="panel",
)
print("frequencies:", panel.frequencies(4).round(), "Hz")

# %%
# The impact, in the middle of a bay. The law is Hertz's, of the ball and the outermost ply. A shell has no thickness that
# could be indented, and its bending under a point depends on its elements; what these make of it is replaced by an elastic
# layer's (:doc:`/theory/shells`).

ball = ao.ball(radius=0.005, material=ao.Material(E=210e9, nu=0.3, rho=7800))
tip = panel.contact(point=(0.15, 0.075, 0.0), direction=(0, 0, -1))
hit = ao.simulate(ball, tip, velocity=2.0, quantity="peak_force", rtol=0.02)
print(hit)

# %%
# Stress when the force is largest: at the top, the middle and the bottom of a shell, in the axes of the body; or in a ply,
# by its number from the bottom, along its fibres.

field = hit.target.field()
fibres = [np.nanmax(abs(field.stress(layer=(ply, "bottom"))["xx"])) for ply in range(16)]
worst = max(range(16), key=fibres.__getitem__)
angle = stack[worst].angle_deg
print(f"largest stress along fibres: {fibres[worst] / 1e6:.0f} MPa in ply {worst}, {angle:g}°")
image = plt.figure(figsize=(9.6, 7.2)).figimage(field.plot().screenshot())

# %%
# ``field.to_vtu("panel")`` writes it for ParaView, with the stress of both faces.

# %%
# A deck of Abaqus, CalculiX or Nastran has sections and materials of its own: see :doc:`/how-to/decks`.
