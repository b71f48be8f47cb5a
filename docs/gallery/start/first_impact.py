"""
The first impact in ten minutes
===============================

A steel ball falls on an aluminium plate with a hole, clamped at one side. How large is the force, and how wrong may
that number be? From nothing to the answer there are four steps: install, make a mesh, describe the bodies, simulate.

Install the package from the folder of its source, and gmsh to make the mesh of this page::

    python3 -m venv .venv
    .venv/bin/pip install . gmsh

Write what follows into a file, ``first.py``, in any folder, and run it by the Python of that environment,
``.venv/bin/python first.py``. (If ``import gmsh`` fails because ``libGLU.so.1`` is missing, see
:doc:`/install`.) All units are SI.
"""

# %%
# 1. A mesh
# ---------
# Any volume mesh will do: of Gmsh, Abaqus, Nastran, Exodus, MED, VTK and others. Quadratic elements (``tetra10``,
# ``hexahedron20``, ``hexahedron27``, ``wedge15``, ``pyramid13``) are worth their cost, since linear ones are far too stiff
# in bending; ``FEModel.from_mesh(..., order=2)`` makes them of linear ones. This plate is 200 mm × 150 mm × 6 mm with a hole of 50 mm. The side x = 0 gets a name, a
# *physical group*, to be found again. Around the point that will be struck the elements are small.

import tempfile

import gmsh

struck = (0.07, 0.06, 0.006)

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.ElementOrder", 2)
plate = gmsh.model.occ.addBox(0, 0, 0, 0.2, 0.15, 0.006)
hole = gmsh.model.occ.addCylinder(0.14, 0.075, 0, 0, 0, 0.006, 0.025)
gmsh.model.occ.cut([(3, plate)], [(3, hole)])
gmsh.model.occ.synchronize()

tiny = 1e-6
side = gmsh.model.getEntitiesInBoundingBox(-tiny, -tiny, -tiny, tiny, 0.151, 0.007, 2)
gmsh.model.addPhysicalGroup(2, [tag for _, tag in side], name="clamped")
gmsh.model.addPhysicalGroup(3, [plate], name="plate")

size = gmsh.model.mesh.field.add("Ball")
settings = {"Radius": 0.006, "Thickness": 0.03, "VIn": 0.003, "VOut": 0.01}
for name, value in {**settings, **dict(zip(("XCenter", "YCenter", "ZCenter"), struck))}.items():
    gmsh.model.mesh.field.setNumber(size, name, value)
gmsh.model.mesh.field.setAsBackgroundMesh(size)
gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
gmsh.model.mesh.generate(3)
folder = tempfile.TemporaryDirectory()
gmsh.write(f"{folder.name}/plate.msh")
gmsh.finalize()

# %%
# 2. The bodies
# -------------
# The plate is its mesh, a material and a support: all of "clamped" is fixed in x, y and z. (A mesh in millimetres is
# read by ``ao.read_mesh("plate.msh", scale=1e-3)``.) The ball is taken as rigid, but it knows its radius and material,
# so that the contact law follows from them. (Supports may also be node numbers, or a function of the nodes' coordinates;
# "x", "y" and "z" may be fixed one by one: :meth:`aoimpact.FEModel.from_mesh`.)

import aoimpact as ao

aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
steel = ao.Material(E=210e9, nu=0.3, rho=7800)

plate = ao.FEModel.from_mesh(f"{folder.name}/plate.msh", aluminium, fixed=[("clamped", "xyz")])
ball = ao.ball(0.01, steel)
print(plate)

# %%
# A look at the first natural frequencies, in Hz, shows whether units, material and support are what they should be.

print(plate.frequencies(4))

# %%
# 3. The impact
# -------------
# The ball hits the plate at 1 m/s, which is a fall from 51 mm.

hit = ao.simulate(projectile=ball, target=plate.contact(point=struck), velocity=1.0)
print(hit)

# %%
# Read the *peak force* first. After ± stands its error, in brackets the sources of that error.
#
# - *mesh*: the elements are too large or too stiff;
# - *contact*: the contact grows from a point to its largest width; how the body gives way under it changes a little;
# - *model*: the plate was reduced to few oscillators;
# - *time*: integration in time.
#
# The row *error* is the largest error of the force at any time in the record. The models are chosen so that their part of
# it is below 0.2 %, or below 1 % where the largest models that are tried do not give 0.2 %.
#
# The contact lasts some 0.1 ms and the ball loses most of its energy to the vibration of the plate: it comes back with
# a fraction of its velocity, the *restitution*. Every number has its own error. In a script ``plt.show()`` opens the
# window with the figure; a notebook shows it without.

import matplotlib.pyplot as plt

hit.plot_force()
plt.show()

# %%
# Single numbers and histories are attributes.

print(f"peak force         {hit.peak_force:.1f} N at {1e6 * hit.peak_time:.1f} µs")
print(f"its error          {100 * hit.error['peak_force'].total:.1f} %")
print(f"contact duration   {1e6 * hit.contact_duration:.1f} µs")
print(f"largest deflection in this record {1e6 * abs(hit.target.displacement).max():.1f} µm")

# %%
# 4. A better answer
# ------------------
# The largest part of the error is the mesh. Where it matters, make the elements around the contact half as large
# (``VIn``) and run again; the error that is printed shows whether that was enough. Another velocity
# needs no new mesh; its model is made anew, in some seconds (:doc:`/how-to/sweeps` has what makes it once):

for velocity in (0.2, 0.5, 1.0):
    other = ao.simulate(projectile=ball, target=plate.contact(point=struck), velocity=velocity)
    print(
        f"{velocity} m/s: {other.peak_force:7.1f} N ± {100 * other.error['peak_force'].total:.1f} %"
    )

# %%
# Where to go from here
# ---------------------
# - Where is the stress largest? :doc:`/how-to/stress`
# - Is a rigid ball good enough? :doc:`/how-to/choosing_a_model`
# - The matrices come from Abaqus, Ansys or Nastran: :doc:`/how-to/other_programs`; from a script of mine:
#   :doc:`/how-to/own_matrices`
# - Several materials, plies, added masses, springs: :doc:`/how-to/materials_masses_springs`
# - The same from a file and the command line, without Python: :doc:`/scene-files`
