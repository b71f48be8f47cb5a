"""
Matrices from Abaqus, Ansys, CalculiX and Nastran, and back
===========================================================

A company's model often exists as matrices of Abaqus, Ansys, CalculiX or Nastran. :func:`aoimpact.read_matrices` makes a
body of them, whose nodes keep their numbers; :func:`aoimpact.write_matrices` takes a body, a contact point or an AO model
back. Without files, K and M are given as in :doc:`/how-to/own_matrices`. A deck with sections and materials is a body
without matrices (:doc:`/how-to/decks`).
"""

import tempfile
import warnings
from pathlib import Path

import numpy as np

import aoimpact as ao

# %%
# What the programs write
# -----------------------
# The format is found from the content, whatever the file is called.
#
# .. list-table::
#    :header-rows: 1
#
#    * - program
#      - how it writes K and M
#      - which dof a row is
#    * - Abaqus
#      - ``*MATRIX GENERATE, STIFFNESS, MASS`` and ``*MATRIX OUTPUT, STIFFNESS, MASS`` (``FORMAT=MATRIX INPUT`` or
#        ``COORDINATE``)
#      - in MATRIX INPUT itself
#    * - Ansys
#      - ``*SMAT, K, D, IMPORT, FULL, file.full, STIFF``, ``*EXPORT, K, MMF, K.mtx``; likewise MASS
#      - ``dofs=``: the mapping file that ``HBMAT`` writes of the same ``.full``, or an array
#    * - CalculiX
#      - ``*FREQUENCY, SOLVER=MATRIXSTORAGE``: ``.sti`` and ``.mas``
#      - in the ``.dof`` beside them
#    * - Nastran
#      - OUTPUT4 (text or binary), or DMIG punched by EXTSEOUT or MATPCH
#      - in DMIG itself; of OP4 ``dofs=``
#    * - SciPy, NumPy
#      - ``scipy.sparse.save_npz``, ``numpy.savez``, ``scipy.io.mmwrite``
#      - ``dofs=``: an array of node and component
#
# CalculiX integrates the mass of all its solid elements but C3D8 and C3D20 at few points, which leaves some motions without
# mass. Such a body is read and struck as any other; the elements C3D8I have inner nodes, which no coordinates belong to:
# leave ``nodes`` out, or take another element.
#
# Here CalculiX' files are imitated: a bar in millimetres, tonnes and newtons, clamped at one end, its nodes called 101,
# 102, ...

folder = Path(tempfile.mkdtemp())
mesh = ao.box_mesh((0.2, 0.02, 0.02), (16, 2, 2), kind="hexahedron20")
made = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700), fixed=[("xmin", "xyz")])
for suffix, matrix in ((".sti", made.K), (".mas", made.M)):
    entries = matrix.tocoo()
    upper = entries.row <= entries.col
    table = np.column_stack([entries.row + 1, entries.col + 1, 1e-3 * entries.data])[upper]
    np.savetxt(folder / f"bar{suffix}", table, fmt="%d %d %.13e")
_ = (folder / "bar.dof").write_text("".join(f"{101 + i // 3}.{i % 3 + 1}\n" for i in made.free))
deck = [f"{101 + i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(1e3 * mesh.nodes)]
_ = (folder / "bar.inp").write_text("\n".join(["*NODE", *deck, ""]))

# %%
# You state the units
# -------------------
# A file of numbers has no units: ``length`` and ``mass`` are the file's, in m and kg (time is in seconds). Values that no
# real body has cause a warning, which names the unit that was probably meant:


with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    ao.read_matrices(folder / "bar.sti", folder / "bar.mas", nodes=folder / "bar.inp")
print(warned[0].message)

# %%
# With the right units, ``audit`` shows which rigid motions are free, and the lowest frequencies. Compare these with the
# frequencies that the program itself prints.

bar = ao.read_matrices(
    folder / "bar.sti", folder / "bar.mas", nodes=folder / "bar.inp", length=1e-3, mass=1e3
)
print(bar.audit(frequencies=4))

# %%
# Nodes keep their numbers
# ------------------------
# Matrices have no surface: the contact is a node, in a direction, and the law has to be given.

corner = 101 + int(np.argmax(mesh.nodes @ [1, 1, 1]))
tip = bar.contact(node=corner, direction=(0, 0, -1))
print(tip)

# %%
# A single node is softer than the surface that it stands for, the more so the finer the mesh. Without the elements nothing
# is known of that, and nothing is taken out of the law. So spread the contact over the nodes of the face by a functional
# ``b=``. Here it is the mean of the nodes on the last 30 mm of the upper side:

upper = np.flatnonzero((mesh.nodes[:, 2] > 0.0199) & (mesh.nodes[:, 0] > 0.17))
rows = np.isin(bar.labels[:, 0], 101 + upper) & (bar.labels[:, 1] == 3)
hit = ao.simulate(
    projectile=ao.rigid(mass=0.02),
    target=bar.contact(b=np.where(rows, -1.0 / rows.sum(), 0.0)),
    law=ao.Hertz(k=1e8),
    velocity=1.0,
    duration=3e-3,
)
print(f"{hit.peak_force:.1f} N")

# %%
# With the mesh of the same model
# -------------------------------
# With ``mesh=`` (a file in the same unit, or a mesh in metres) and the ``material`` of its surface, the matrices stay as
# they are, and the surface is known: the contact is a patch, the law may be left out, and stresses are available.

on_mesh = ao.read_matrices(
    folder / "bar.sti",
    folder / "bar.mas",
    nodes=folder / "bar.inp",
    length=1e-3,
    mass=1e3,
    mesh=mesh,
    material=ao.Material(E=70e9, nu=0.33, rho=2700),
)
steel = ao.Material(E=210e9, nu=0.3, rho=7800)
hit = ao.simulate(
    projectile=ao.ball(radius=0.01, material=steel),
    target=on_mesh.contact(point=(0.19, 0.01, 0.02)),
    velocity=1.0,
)
print(hit)
ax = hit.plot_force()

# %%
# An AO model in another program
# ------------------------------
# The AO model of a body consists of the contact mass m0 on a ground spring k0, and on it, each by a spring k_i, the masses
# m_i. Any program with point masses and springs can take it in place of the body; its contact law then acts between
# node 1 and the projectile.

model = ao.antioscillators(tip, n=3)
files = ao.write_matrices(model, folder / "model")
print(files["json"].read_text())

# %%
# The same as a deck of CalculiX or Abaqus; the project's tests run it through CalculiX and get the model's K and M back.

print(files["deck"].read_text())

# %%
# A body, or a contact point with its b, is written as Matrix Market, with files that list the degree of freedom of each row
# and the coordinates of the nodes:

print(sorted(ao.write_matrices(bar, folder / "bar")))
