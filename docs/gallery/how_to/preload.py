"""
Preload: a start from rest under load
=====================================

A structure that carries a load, or its own weight, is pressed before the impact. ``preload=True`` starts the scene in
static equilibrium under gravity and the loads at t = 0; the impact is superposed.
"""

import matplotlib.pyplot as plt

import aoimpact as ao

# %%
# A stack that is struck
# ----------------------
# Three balls of 0.1 kg lie on each other on a hard floor. The top one gets a velocity of 0.2 m/s downwards.

law = ao.Hertz(k=1e9)
scene = ao.Scene(gravity=9.81)
floor = scene.add(ao.rigid(mass=float("inf"), name="floor"))
low, high = (scene.add(ao.rigid(mass=0.1, name=name)) for name in ("low", "high"))
top = scene.add(ao.rigid(mass=0.1, name="top"), velocity=0.2)
scene.connect(top, high, law, name="top")
scene.connect(high, low, law, name="between")
scene.connect(low, floor, law, name="floor")
run = scene.simulate(duration=2e-3, preload=True)
print(run)

# %%
# At t = 0 the forces are those at rest: the weights of what lies above.

for number, contact in enumerate(run.contacts, start=1):
    print(f"{contact.name:8s} {contact.force[0]:.6f} N, weight above {number * 0.1 * 9.81:.6f} N")

# %%
# The displacement of a body is measured from its unloaded position, so that it starts with the static displacement.

run.plot_force()

# %%
# A beam under a service load
# ---------------------------
# The load acts at the contact; stress and displacement of the whole body contain the static part. A constant force
# that presses the beam down at midspan by a pad is applied before the ball comes.

steel = ao.Material(E=210e9, nu=0.3, rho=7800)
aluminium = ao.Material(E=70e9, nu=0.33, rho=2700)
beam = ao.FEModel.from_mesh(
    ao.box_mesh((0.5, 0.02, 0.01), (40, 2, 2), kind="hexahedron20"),
    aluminium,
    fixed=[("xmin", "xyz"), ("xmax", "xyz")],
    name="beam",
)


def struck(load):
    """The ball on the beam under a load, N; the stress below the contact over time, MPa."""
    scene = ao.Scene()
    point = beam.contact(point=(0.25, 0.01, 0.01))
    target = scene.add(
        ao.antioscillators(point, 32, method="krylov", contact_time=100e-6, duration=400e-6)
    )
    scene.connect(scene.add(ao.ball(0.01, steel), velocity=1.0), target)
    scene.apply(target, force=load)
    run = scene.simulate(duration=400e-6, preload=load != 0.0)
    probe = run[target].probe((0.25, 0.01, 0.0))
    return run, probe.stress["xx"] / 1e6


_, ax = plt.subplots(layout="constrained")
for load, style in ((0.0, "-"), (20.0, "--")):
    run, stress = struck(load)
    ax.plot(1e6 * run.t, stress, style, label=f"load {load:g} N")
    print(
        f"load {load:4g} N: peak {run.contacts[0].peak_force:.2f} N, stress at t = 0 {abs(stress[0]):.3f} MPa"
    )
ax.set(xlabel="time (µs)", ylabel="σ_xx opposite to the contact (MPa)")
ax.legend()

# %%
# The ball starts where the unloaded beam would touch it, so that it reaches a beam that is bent away later. The force is
# the same, since everything is linear but the contact; the stress is that of the load and of the impact together. By
# beam theory the clamped beam under F at midspan has the moment F L/8 there:

theory = 20 * 0.5 / 8 / (0.02 * 0.01**2 / 6) / 1e6
print(f"static stress under 20 N: computed {stress[0]:.3f} MPa, by beam theory {theory:.3f} MPa")

# %%
# Can I preload a bolt?
# ---------------------
# In part. The bodies are linear, so that a clamping force changes neither their stiffness nor their frequencies: stress
# stiffening, a joint that opens or slips, and a clamping that is lost are not in the package. What can be done:
#
# - *The joint stays closed.* Mesh the bolted parts as one body (:doc:`/how-to/materials_masses_springs`) and simulate the
#   impact without the clamping force. The stress of the preload, from a static analysis, adds to that of the impact. Where
#   the sum at the joint would be tension, the joint opens, and this model no longer holds.
# - *Two bodies pressed together.* A contact between them, with an external force that presses them and ``preload=True``,
#   as above: the contact may open during the impact, in the normal direction. The force acts at a contact point along the
#   direction of travel and keeps its value; the bolt's own stiffness beside the contact is not modelled.
# - *A stiffness under preload.* Another program's K of the preloaded state, with its geometric stiffness, can be read and
#   used like any other: :doc:`/how-to/other_programs`.
#
# Where there is no equilibrium
# -----------------------------
# A body that nothing supports is named by its number in the scene:

scene = ao.Scene(gravity=9.81)
a = scene.add(ao.rigid(mass=1.0, name="lid"))
b = scene.add(ao.rigid(mass=1.0, name="box"))
scene.connect(a, b, law)
try:
    scene.simulate(duration=1e-3, preload=True)
except ao.AOImpactError as error:
    print(error)
