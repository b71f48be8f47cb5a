"""
Measured: a ball on a stretched membrane
========================================

*Source*: E. A. Agüero, L. Alventosa, D. M. Harris, C. A. Galeano-Rios, *Impact of a rigid sphere onto an elastic
membrane*, arXiv 2208.11089. Balls of 2.38 mm radius fall on the middle of a round membrane that is stretched over a
frame. The largest deflection and the ratio of rebound to impact velocity were measured, with uncertainties of 2 to 5 %.

This is no case that the package was made for: a membrane has no bending stiffness and no solid elements, and Hertz's law
has nothing to do with it. It enters by its matrices (:doc:`/how-to/own_matrices`), and with a law of its own.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
import skfem
from skfem.helpers import dot, grad

import aoimpact as ao

tension, area_mass = 107.0, 0.3  # N/m, kg/m²
edge, ball_radius, gravity = 52.5e-3, 2.38e-3, 9.81  # m, m, m/s²

# Density of the ball, kg/m³; velocity, m/s; largest deflection, mm; rebound ratio.
measured = [
    (3250, 0.4764, 0.490, 0.635),
    (3250, 0.6312, 0.639, 0.611),
    (3250, 0.7466, 0.743, 0.606),
    (7930, 0.3702, 0.677, 0.610),
    (7930, 0.6125, 1.052, 0.552),
    (7930, 0.7330, 1.233, 0.561),
]

# %%
# The membrane
# ------------
# The deflection w of a membrane under the tension T has the energy ½ ∫ T (∇w)² and the mass µ per area. Scalar elements of
# second order of scikit-fem make K and M of that; the mesh is finer in the middle.


def membrane(radius):
    """The body, the basis of its shape functions, and its free degrees of freedom."""
    disc = skfem.MeshTri.init_circle(5)
    points = radius * disc.p * (0.02 + 0.98 * np.hypot(*disc.p))
    basis = skfem.Basis(skfem.MeshTri(points, disc.t), skfem.ElementTriP2(), intorder=4)
    K = tension * skfem.BilinearForm(lambda u, v, _: dot(grad(u), grad(v))).assemble(basis)
    M = area_mass * skfem.BilinearForm(lambda u, v, _: u * v).assemble(basis)
    free = np.setdiff1d(np.arange(basis.N), basis.get_dofs().flatten())
    body = ao.FEModel(K=K[free][:, free], M=M[free][:, free], name="membrane")
    return body, basis, free


body, basis, free = membrane(edge)
print(body)
print(
    body.frequencies(1),
    "Hz;",
    2.404826 / (2 * np.pi * edge) * np.sqrt(tension / area_mass),
    "in closed form",
)

# %%
# The contact
# -----------
# A rigid ball shapes the membrane around its lowest point over a disc whose radius a grows with the force F. At rest the
# slope F/(2πTa) at the edge of the disc is the ball's, a/R, so that a² = FR/(2πT). The functional of an AO model is one
# and the same at all forces: here the mean over a disc of a fixed radius r. The difference of the two is the contact law,
# as with the patches of solids (:doc:`/theory/contact`). From the deflection of the membrane outside,
# F/(2πT) log(edge/ρ), the ball's lowest point is deeper than the mean over the disc by
#
# δ = F/(2πT) · (log(r/a) + 1/4),
#
# which is a law F(δ) as long as the contact is narrower than the disc. It is given as a table.


def mean_over_disc(basis, radius):
    """The functional b of the mean displacement within a radius."""
    x, weights = np.polynomial.legendre.leggauss(12)
    rho, angle = radius * np.sqrt((x + 1) / 2), 2 * np.pi * np.arange(24) / 24 + 0.05
    points = np.array([np.outer(rho, np.cos(angle)), np.outer(rho, np.sin(angle))]).reshape(2, -1)
    return basis.probes(points).T @ np.repeat(weights / 2 / angle.size, angle.size)


def table_of(radius):
    """F(δ) of the ball on that disc, up to where it would be too steep."""
    widest = radius**2 * 2 * np.pi * tension / ball_radius  # the force of a contact of that radius
    force = widest * np.geomspace(1e-6, 0.55, 400)
    depth = force / (2 * np.pi * tension) * (0.25 + 0.5 * np.log(widest / force))
    return ao.Tabulated(indentation=[0, *depth], force=[0, *force])


# %%
# The impacts
# -----------
# The radius of the disc is 1.5 times that of the contact at its largest force, which is estimated from a ball on an
# infinite membrane. The ball's weight acts on it all the time.


def strike(density, velocity, on, widened=1.5):
    body, basis, free = on
    mass = 4 / 3 * np.pi * ball_radius**3 * density
    largest = 0.9 * velocity * np.sqrt(mass * np.pi * tension / 2)
    radius = widened * np.sqrt(largest * ball_radius / (2 * np.pi * tension))
    tip = body.contact(b=mean_over_disc(basis, radius)[free])
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=mass, name="ball"), velocity=velocity)
    struck = scene.add(
        ao.antioscillators(tip, 40, method="krylov", contact_time=4e-3, duration=15e-3)
    )
    scene.connect(ball, struck, table_of(radius))
    scene.apply(ball, force=mass * gravity)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the second fall of the ball is not looked at
        run = scene.simulate(duration=12e-3, solver=ao.Adaptive(rtol=1e-6))
    run = run.at(np.linspace(0, 12e-3, 4801))
    end = run.contacts[0].intervals[0][1]
    rebound = -np.interp(end, run.t, run[ball].velocity) / velocity
    return run, ball, 1e3 * run[ball].displacement.max(), rebound, end


def show(on):
    print("density  velocity   deflection (mm)            rebound ratio         contact")
    print("g/cm³    m/s        measured  here   error     measured  here  error  ms")
    errors = []
    for density, velocity, deflection, ratio in measured:
        _, _, deep, rebound, end = strike(density, velocity, on)
        errors.append((deep / deflection - 1, rebound / ratio - 1))
        print(
            f"{density / 1e3:.2f}     {velocity:.4f}     {deflection:.3f}     {deep:.3f}  "
            f"{100 * (deep / deflection - 1):+5.1f} %   {ratio:.3f}     {rebound:.3f} "
            f"{100 * (rebound / ratio - 1):+5.1f} %  {1e3 * end:.2f}"
        )
    return np.array(errors)


errors = show((body, basis, free))
assert np.abs(errors[:3]).max() < 0.03  # the light ball
assert np.abs(errors[3:, 0]).max() < 0.03  # the heavy ball's deflection

# %%
# The radius of the disc does not matter:

for widened in (1.35, 2.0):
    _, _, deep, rebound, _ = strike(3250, 0.7466, (body, basis, free), widened)
    print(f"{widened} times the contact's: {deep:.3f} mm, {rebound:.3f}")

# %%
# Agreement and differences
# -------------------------
# *The light ball* agrees in deflection and rebound within the uncertainty of the measurement. Nothing was fitted.
#
# *The deflection of the heavy ball* is 2 to 3 % too small, about the uncertainty.
#
# *The rebound of the heavy ball* is too large by a fifth. Its contact lasts longer than a wave takes to the frame and
# back, 2·52.5 mm/√(T/µ) = 5.6 ms. In the model the frame reflects it without loss, and it pushes the ball once more. To
# see how much of the difference this is, the same balls strike a membrane of four times the radius, from whose frame
# nothing comes back in time:

print(f"there and back: {2e3 * edge / np.sqrt(tension / area_mass):.2f} ms")
assert np.abs(show(membrane(4 * edge))).max() < 0.13

# %%
# Without the reflected wave the light ball's rebound is the same, and the heavy ball's comes to within 4 to 13 % of the
# measured one. So most of the difference is what the model lacks: losses in membrane and frame, and the air that
# moves with the membrane. They could be given as damping, but nothing is known of them here, and a value that is fitted
# to the rebound would prove nothing. What remains cannot be told from these numbers. One candidate is the geometry: at
# 1.2 mm deflection the membrane's slope at the edge of the contact is a third, where a linear membrane is no longer
# exact.

_, ax = plt.subplots(layout="constrained")
for on, label, style in (
    ((body, basis, free), "reflecting frame", "-"),
    (membrane(4 * edge), "no reflected wave", "--"),
):
    run, ball, *_ = strike(7930, 0.6125, on)
    ax.plot(1e3 * run.t, 1e3 * run[ball].displacement, style, label=f"ball, {label}")
ax.axhline(1.052, color="0.4", lw=0.8)
ax.annotate("measured largest deflection", (12, 1.052), ha="right", va="bottom")
ax.set(
    xlabel="time (ms)", ylabel="displacement (mm)", ylim=(-2.4, 1.4), title="7.93 g/cm³, 0.6125 m/s"
)
ax.legend()
