"""
Plots, tables, movies
=====================

A result draws itself, and gives its histories to pandas, xarray, CSV files, ParaView and movies.
"""

import matplotlib.pyplot as plt

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
mesh = ao.box_mesh((0.1, 0.08, 0.01), (20, 16, 3), kind="hexahedron20")
plate = ao.FEModel.from_mesh(
    mesh, aluminium, fixed=[("xmin", "xyz"), ("xmax", "xyz")], name="plate"
)
middle = plate.contact(point=(0.05, 0.04, 0.01))
hit = ao.simulate(projectile=ao.ball(0.01, steel, name="ball"), target=middle, velocity=1.0)

# %%
# Plots
# -----
# ``plot`` has four panels. They show the contact, with a little before and after it; ``during="record"`` shows all, and
# ``during=(start, end)`` any part, in seconds. A curve has twenty points in a period of the fastest mode of the models.

axes = hit.plot()

# %%
# Each panel is a method of its own, which draws on axes that it is given and hands keywords to ``Axes.plot``. So are
# the energies of one body, and the force over the approach of the centres of mass:

ax = hit.plot_energy(body="target", during="record")

# %%
# Tables
# ------
# ``to_dataframe`` gives pandas the columns that ``to_csv`` writes; ``to_xarray`` has dimensions time and body, and
# units with every history.

print(hit.to_dataframe().iloc[::40, :3])

data = hit.to_xarray()
print(data.velocity.sel(body="plate").isel(time=[0, 100, 200]).values, data.velocity.attrs["units"])

# %%
# Bodies in motion
# ----------------
# A field is the whole body at some times. ``to_vtu`` writes it for ParaView. ``plot`` and ``movie`` draw it by PyVista,
# without a window. ``hit.movie`` draws both bodies as they meet. Displacements are enlarged by the factor that the
# picture names::
#
#     pip install aoimpact[movie]
#
#     hit.movie("impact.gif")  # or .mp4
#     hit.target.field(times).movie("plate.mp4", scale=500)
#     hit.target.to_vtu("plate", times)

image = plt.figure(figsize=(9.6, 7.2)).figimage(hit.target.field().plot().screenshot())
