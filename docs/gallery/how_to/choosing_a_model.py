"""
Which model do I need?
======================

The force, the stress and the deflection of one impact need different models. A rigid mass may be enough for one
number and far off for another. There are two ways to know: let the tolerance choose, or compare.

The example is the ball of E. Jacquelin's paper on an aluminium beam with hinged ends, struck at midspan.
"""

import aoimpact as ao

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.3, rho=2400)

ball = ao.FEModel.from_mesh(ao.sphere_mesh(radius=0.01, size=0.003), steel, name="ball")
beam = ao.FEModel.from_mesh(
    ao.box_mesh((1.0, 0.02, 0.02), (50, 2, 2), kind="hexahedron20"),
    aluminium,
    fixed=[("xmin", "xyz"), ("xmax", "yz")],
    name="beam",
)
tip = ball.contact(point=(0, 0, -0.01))
middle = beam.contact(point=(0.5, 0.01, 0.02))

# %%
# Let the tolerance choose
# ------------------------
# A contact point is reduced to a few oscillators, as the *quantity of interest* allows. By default that is the force
# over the whole record, to 0.2 %, or to as little as 1 % where the largest models that are tried do not give 0.2 %.

hit = ao.simulate(projectile=tip, target=middle, velocity=1.0)
print(hit)

# %%
# Another quantity of interest leads to other models, here the deflection of the beam to 3 %:

for_deflection = ao.simulate(
    projectile=tip, target=middle, velocity=1.0, quantity="target_displacement", rtol=3e-2
)
for quantity, result in (("force", hit), ("deflection", for_deflection)):
    ball_model, beam_model = result.models
    print(f"{quantity:10s} ball: {ball_model.n} oscillators, beam: {beam_model.n}")

# %%
# Only the quantity of interest is right to the tolerance. The errors of the other numbers are estimated, too,
# each with its sources:

for name in for_deflection.error:
    print(f"{name:20s} {for_deflection.error[name]}")

# %%
# Compare
# -------
# `compare` runs the same impact with models from rigid to more and more oscillators, and shows what each costs and how
# wrong it is. Here the errors are relative to the model of most oscillators; with ``full=True`` they are relative to
# the finite elements themselves, which takes longer.

table = ao.compare(
    projectile=tip,
    target=middle,
    law=hit.law,
    velocity=1.0,
    duration=hit.duration,
    oscillators=(0, 1, 2, 4, 8, 16),
    modes=(6, 11, 19),
    full=False,
)
print(table)

# %%
# Anti-oscillators that are fitted to the contact's duration converge much faster than natural modes: a mode shape does
# not know where the body is touched. With very few of them, one more need not help: AO(1) ends the contact at the wrong
# time, as the column of the duration shows, and while one force has ended and the other has not, the error is large.
# The time to build the first row includes the factorisation of the ball's matrices, which the rows below share.

ax = table.plot()

# %%
# Solids or shells
# ----------------
# Another discretisation of the target is compared as ``other_targets``, by the label of its row. Here a sheet of 2 mm is
# meshed by bricks of second order, and by shells; the default model of the shells is run beside those of the bricks.

sheet = ao.FEModel.from_mesh(
    ao.box_mesh((0.06, 0.06, 0.002), (24, 24, 1), kind="hexahedron20"),
    steel,
    fixed=[("xmin", "xyz"), ("xmax", "xyz")],
    name="bricks",
)
shell = ao.FEModel.from_mesh(
    ao.sheet_mesh((0.06, 0.06), (24, 24)),
    ao.Shell(0.002, steel),
    fixed=[("xmin", "xyz", "xyz"), ("xmax", "xyz", "xyz")],
)
print(
    ao.compare(
        projectile=ao.ball(0.005, steel),
        target=sheet.contact(point=(0.03, 0.03, 0.002)),
        velocity=1.0,
        oscillators=(2, 5, 20),
        modes=(),
        full=False,
        other_targets={"shell": shell.contact(point=(0.03, 0.03, 0))},
    )
)

# %%
# They differ by 2 % in the force over the record and by less than 1 % in the impulse, and the shells cost a fraction of the
# time. A contact point on solids moves by their indentation as well, so that its displacement is not that of the shells.

# %%
# Give the model yourself
# -----------------------
# - ``ao.rigid(mass=...)`` and ``ao.ball(radius, material)``: rigid; a ball also knows its surface;
# - ``ao.antioscillators(tip, n, method="krylov", contact_time=100e-6)``: few oscillators, fitted to the contact; without
#   ``method`` the paper's, of largest mass, of which the same accuracy takes some six times as many;
# - ``ao.modal(tip, n)``: natural modes;
# - ``ao.full(tip)``: all finite elements.
#
# A model that is given stays as it is. An AO model may also be given by numbers: contact mass, ground spring, and the
# masses and springs that hang on the contact mass.

spring = ao.AOModel(m0=0.1, k0=1e5, m=[0.2, 0.1], k=[1e6, 5e6])
print(spring.frequencies, "Hz")
print(spring.receptance(100.0), "m/N at 100 rad/s")
