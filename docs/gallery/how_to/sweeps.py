"""
A sweep, on one core or on a cluster
====================================

A model is built once and then costs a fraction of a millisecond for each impact. So thousands of impacts are a matter of
seconds: over velocities, gaps, laws and masses.
"""

import numpy as np

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
ball = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), steel)
sphere = ao.antioscillators(ball.contact(point=(0.01, 0, 0)), n=1)
target = ao.AOModel(m0=0.01, k0=1e5, m=[0.2, 0.1], k=[1e6, 2e8])
law = ao.Hertz.between(steel, 0.01, steel, 0.01)

# %%
# A table over a grid
# -------------------
# ``sweep`` runs all combinations. The first argument has what all of them share, as for `simulate`.

case = {"projectile": sphere, "target": target, "law": law, "duration": 2e-3}
table = ao.sweep(case, {"velocity": [0.5, 1, 2], "gap": [0, 1e-4]}, workers=2)
print(table)

# %%
# Its columns are NumPy arrays. ``table.to_csv`` writes them, ``table.to_pandas`` makes a data frame of them, and
# ``table.to_xarray`` arrays over the parameters, which xarray draws and interpolates.

fine = ao.sweep(
    case, {"velocity": np.geomspace(0.05, 5, 60)}, keep=["peak_force", "contact_duration"]
)
fine.to_xarray()["peak_force"].plot()

# %%
# A list of cases
# ---------------
# ``simulate_many`` takes any list of cases, scenes included. With ``keep=`` it keeps numbers instead of histories, and
# plain impacts then run by the ten thousand a second. A case that fails is its own exception and stops no others.

rng = np.random.default_rng(1)
cases = [case | {"velocity": speed} for speed in rng.uniform(0.1, 2.0, 3000)]
cases[7] = case | {"velocity": float("nan")}
results = ao.simulate_many(cases, keep=("peak_force", "restitution"))
forces = np.array([each["peak_force"] for each in results if not isinstance(each, Exception)])
print(f"{forces.mean():.1f} N ± {forces.std():.1f} N over {len(forces)} impacts")
print(repr(results[7]))

# %%
# Many impacts on one body
# ------------------------
# Impacts on the same contact point share its models: those whose contacts last about as long and are about as wide have one.
# Once they are made, a case takes about twenty milliseconds of one core with all its errors. Balls and speeds may be random:

mesh = ao.box_mesh((0.1, 0.1, 0.01), (8, 8, 1), kind="hexahedron20")
point = ao.FEModel.from_mesh(mesh, steel).contact(point=(0.055, 0.045, 0.01))
study = [
    {"projectile": ao.ball(radius, steel), "target": point, "velocity": speed}
    for radius, speed in rng.uniform((0.006, 0.5), (0.012, 3.0), (500, 2)).tolist()
]
kept = ao.simulate_many(study, keep=("peak_force", "restitution"))
forces = np.array([numbers["peak_force"] for numbers in kept])
errors = np.array([numbers["peak_force_error"] for numbers in kept])
print(f"{forces.mean():.0f} N ± {forces.std():.0f} N, each to {100 * errors.max():.2g} % or better")

# %%
# More than one core
# ------------------
# ``workers=2`` are threads of this process. ``workers=`` also takes an executor: of ``concurrent.futures``, of
# ``dask.distributed``, of ``mpi4py.futures``. All give the same bits.
#
# .. code-block:: python
#
#     from dask.distributed import Client  # pip install '.[cluster]'
#
#     with Client("scheduler:8786").get_executor() as cluster:
#         table = ao.sweep(case, grid, workers=cluster, checkpoint="cases")
#
# ``checkpoint=`` names a file for finished cases: a sweep that was stopped goes on where it was. Where a case or
# ``keep=`` has functions of your own, ``key=`` is a text that you change with them. From the command line
# the same is a scene file with a ``[sweep]`` and ``aoimpact run file.toml --workers 8 --checkpoint cases``
# (:doc:`/scene-files`).

from concurrent.futures import ThreadPoolExecutor

with ThreadPoolExecutor(2) as executor:
    again = ao.sweep(case, {"velocity": [0.5, 1, 2], "gap": [0, 1e-4]}, workers=executor)
print("the same bits:", bool(np.all(again.data["peak_force"] == table.data["peak_force"])))
