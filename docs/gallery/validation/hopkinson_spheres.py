"""
Measured: two spheres in a Hopkinson bar
========================================

*Source*: J. Burgoyne, C. Daraio, *Strain-rate-dependent model for the dynamic compression of elastoplastic spheres*, Phys. Rev. E
89, 032203 (2014), with the data published with the paper (Daraio-lab/Burgoyne_PRE_2014, CC BY 4.0). Repeats scatter by 10 %.

*In*: two truncated spheres of 3.175 mm radius, pressed together between steel bars (192 GPa, 4865.5 m/s, radius 9.525 mm) at 2.7 to
5.6 m/s: of 440C steel (200 GPa, yields at 1896 MPa), 302 steel (200 GPa, 600 MPa) and aluminium (76 GPa, 276 MPa).
*Measured*: force over approach, and force over time of one run of each.
"""

import matplotlib.pyplot as plt
import numpy as np

import aoimpact as ao

R = 3.175e-3
approach = 1e-6 * np.array([20, 40, 60, 80, 100, 120, 150, 180, 200, 230])
metals = {  # E, σ_y, Pa; slope of the force from 60 µm on, N/m; forces, N; largest force at, m
    "440C steel": (200e9, 1896e6, 55.7e6, [542, 1538, 2599, 3743, 4509, 5779, 7484, 9158, 10495, 11927], (233e-6, 12280)),
    "302 steel": (200e9, 600e6, 24.0e6, [323, 851, 979, 1777, 2133, 2615, 3307, 4128, 4512, 5139], (260e-6, 5735)),
    "aluminium": (76e9, 276e6, 9.6e6, [72, 394, 505, 754, 976, 1204, 1522, 1561, 1833, 2274], (320e-6, 3086)),
}  # fmt: skip


def laws(E, strength, slope):
    metal = ao.Material(E=E, nu=0.3, rho=7800, yield_strength=strength)
    measured = slope / (np.pi * R)  # 2πR* of the slope
    return {
        "ElasticPlastic, hardness measured": ao.ElasticPlastic.between(metal, R, metal, R, hardness=measured),
        "ElasticPlastic, 2.8 yield strengths": ao.ElasticPlastic.between(metal, R, metal, R),
        "Thornton, 1.6 yield strengths": ao.Thornton.between(metal, R, metal, R, yield_pressure=1.6 * strength),
        "Hertz": ao.Hertz.between(metal, R, metal, R),
    }  # fmt: skip


# %%
# Force over approach
# -------------------
# Of all that lies beyond 80 µm: the ratio of the law's force to the measured one, least and largest.

fig, axes = plt.subplots(1, 3, figsize=(10, 3.8), layout="constrained")
for ax, (name, (E, strength, slope, force, largest)) in zip(axes, metals.items()):
    x, y = np.append(approach, largest[0]), np.append(force, largest[1])
    ax.plot(1e6 * x, 1e-3 * y, "ko", ms=4, label="measured")
    d = np.linspace(0, largest[0], 200)
    print(f"{name}: slope of {slope / (np.pi * R * strength):.1f} yield strengths")
    for law_name, law in laws(E, strength, slope).items():
        ratio = law.force(x[3:]) / y[3:]
        print(f"  {law_name:36s} {ratio.min():.2f} to {ratio.max():.2f}")
        ax.plot(1e6 * d, 1e-3 * law.force(d), label=law_name)
    ax.set(title=name, xlabel="approach (µm)", ylabel="force (kN)", ylim=(0, 1.6e-3 * y.max()))
fig.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)

# %%
# With one hardness for each metal, taken from the measured slope, all forces are within 11 %, about as much as repeats scatter.
# With Tabor's 2.8 yield strengths those of the two softer metals are too small by up to 28 %: they harden by strain and its rate.
#
# The runs over time
# ------------------
# Elastic bars of the impedance Z let the spheres approach by dδ/dt = 2(σ A - F)/Z, with the stress σ that arrives.

area = np.pi * 9.525e-3**2
impedance = 192e9 * area / 4865.5
arriving = {  # MPa each 5 µs, and the largest force, N
    "440C steel": ("0.5 3.8 9.6 15.6 23.8 33.8 47.1 63 77 90.9 100.4 106.1 109.3 110 112.2 112.3 111.7 110.9 108.7 103.2 97.7 90.8", 15223),
    "302 steel": ("0.4 4.1 10.5 17.1 21.8 30.4 39.8 54.6 68.2 80.7 87.1 90.4 91.9 93.6 94.9 95.1 94.2 94.5 92 87.4 80.9 75.1 67.9", 7034),
    "aluminium": ("0.5 3.5 8.8 15.1 18.6 24.9 30.2 38.8 47 57.5 65.8 72.4 76.4 78.4 79.6 80.2 81.4 80.2 78.2 74.2 69.5 64.4 59.7 53.8", 2821),
}  # fmt: skip
for name, (text, measured) in arriving.items():
    stress = 1e6 * np.array(text.split(), float)
    law = laws(*metals[name][:3])["ElasticPlastic, hardness measured"]
    times, delta, force = 5e-6 * np.arange(len(stress)), 0.0, 0.0
    for t in np.arange(0, times[-1], 2e-8):
        rate = 2 * (np.interp(t, times, stress) * area - float(law.force(delta))) / impedance
        if rate < 0 and t > 2e-5:
            break
        delta += 2e-8 * rate
        force = max(force, float(law.force(delta)))
    print(
        f"{name:10s} largest force {force:6.0f} N, measured {measured} N: {100 * (force / measured - 1):+.0f} %"
    )

# %%
# *Not understood*: below 60 µm the measured forces of the soft metals scatter by tens of percent, and why is not said. The hardness
# that fits is 4.0 and 3.5 yield strengths of the two softer metals; no hardness of theirs was measured.
