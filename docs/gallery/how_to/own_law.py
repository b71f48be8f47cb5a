"""
A contact law of my own
=======================

The package has :doc:`the laws </api/laws>` of elastic, damped and yielding contacts. A law that is not among them is given
as points of a measured curve, as a Python function, or as a C function.
"""

import ctypes
import subprocess
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy import LowLevelCallable

import aoimpact as ao

# %%
# A measured curve
# ----------------
# Suppose that a rubber pad between hammer and structure was pressed slowly, and these points were measured.
# ``ao.Tabulated`` interpolates between them, monotonically.

indentation = 1e-3 * np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2])  # m
force = np.array([0.0, 41.6, 92.8, 163.2, 262.4, 400.0, 585.6])  # N
measured = ao.Tabulated(indentation=indentation, force=force)

hammer, anvil = ao.rigid(mass=0.2, name="hammer"), ao.rigid(mass=float("inf"), name="anvil")
hit = ao.simulate(projectile=hammer, target=anvil, law=measured, velocity=1.0)
print(hit)

# %%
# A deeper indentation than the table's last is refused, not extrapolated:

try:
    ao.simulate(projectile=hammer, target=anvil, law=measured, velocity=2.0)
except ao.AOImpactError as error:
    print(error)

# %%
# A Python function
# -----------------
# ``ao.UserLaw`` takes the force as a function of indentation (m, positive) and its rate (m/s, positive while the bodies
# approach). The same pad as a formula: F = k δ + k₃ δ³.

k, cubic = 2e5, 2e11  # N/m, N/m³


def pad(depth, rate):
    return k * depth + cubic * depth**3


elastic = ao.UserLaw(pad, depends_on_rate=False)
hit = ao.simulate(projectile=hammer, target=anvil, law=elastic, velocity=1.0)

# %%
# Check a new law by a case with a known solution. Here all kinetic energy is in the pad at its deepest,
# ½ m V² = ½ k δ² + ¼ k₃ δ⁴, and a rigid pair parts as fast as it met.

square = (np.sqrt(k**2 + 2 * cubic * 0.2 * 1.0**2) - k) / cubic
peak = pad(np.sqrt(square), 0.0)
print(f"peak {hit.peak_force:.4f} N, closed form {peak:.4f} N; restitution {hit.restitution:.6f}")
assert abs(hit.peak_force / peak - 1) < 1e-4

# %%
# With a loss that grows with the rate. Negative forces are cut to zero, so that the pad never pulls (``pulls=True`` allows
# it). ``ao.restitution`` gives the restitution of two rigid bodies under any law:


def damped_pad(depth, rate):
    return pad(depth, rate) * (1 + 0.3 * rate)


damped = ao.UserLaw(damped_pad)
for velocity in (0.2, 0.5, 1.0):
    e = ao.restitution(damped, mass=0.2, velocity=velocity)
    print(f"{velocity} m/s: restitution {e:.4f}")

depth = np.linspace(0, 1.2e-3, 200)
_, ax = plt.subplots(layout="constrained")
ax.plot(1e3 * indentation, force, "o", mfc="none", label="measured")
ax.plot(1e3 * depth, measured.force(depth), "-", label="Tabulated")
ax.plot(1e3 * depth, [damped.force(d, 0.5) for d in depth], "--", label="damped, at 0.5 m/s")
ax.set(xlabel="indentation (mm)", ylabel="force (N)", xlim=(0, None), ylim=(0, None))
ax.legend()

# %%
# A C function
# ------------
# A Python function is called at every evaluation of the force, which takes most of the time of a run. A C function
# ``double f(double indentation, double rate)`` has no such cost. It is given as a ``scipy.LowLevelCallable``, which takes
# functions of ctypes and cffi, and numba's ``cfunc.ctypes``. Compiled here:

folder = Path(tempfile.mkdtemp())
(folder / "pad.c").write_text("""
double pad(double depth, double rate)
{
    return (2e5 * depth + 2e11 * depth * depth * depth) * (1.0 + 0.3 * rate);
}
""")
subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", "pad.so", "pad.c"], cwd=folder, check=True)

function = ctypes.CDLL(str(folder / "pad.so")).pad
function.argtypes, function.restype = [ctypes.c_double, ctypes.c_double], ctypes.c_double
compiled = ao.UserLaw(LowLevelCallable(function))
for law in (damped, compiled):
    hit = ao.simulate(projectile=hammer, target=anvil, law=law, velocity=0.5)
    print(f"{hit.peak_force:.6f} N, run {1e3 * hit.cost.run:.2f} ms")

# %%
# Bodies with meshes
# ------------------
# A law between elastic bodies contains the local indentation of both, as Hertz's does: over a patch the compliance that
# the meshes have there is taken out of it (:doc:`/theory/contact`). A pad has the indentation of the pad alone: with
# ``radius=0`` a law that is not like Hertz's is left as it is.
#
# A law that remembers, such as one with plastic indentation, cannot be a ``UserLaw``; ``ao.Thornton`` is one. To add a law
# to the package itself, with its formulas in C: :doc:`/contributing`.
