"""Figures 3 to 11 of the paper, recomputed.

The paper's curves are not published as numbers; where it prints some, they are drawn as thin lines.
Every function returns a figure of its own, which belongs to no window.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import COLOURS, legend, styled, with_unit
from .beam import BeamStudy
from .sketch import draw_sketch
from .sphere import (
    LAW,
    RESOLVED_DURATION,
    RESOLVED_FORCE,
    SphereStudy,
    excesses,
    local_over_nonlocal,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FULL: dict[str, Any] = {"color": "black", "linestyle": "-", "linewidth": 1.6}
RIGID: dict[str, Any] = {"color": COLOURS[1], "linestyle": "--", "linewidth": 1.4}
ONE_AO: dict[str, Any] = {"color": COLOURS[0], "linestyle": ":", "linewidth": 2.4}


def new_figure(
    title: str, note: str, *, columns: int = 1, height: float = 4.4
) -> tuple[Figure, list[Axes]]:
    """Return a figure with axes side by side, a title, and a note below them."""
    from matplotlib.figure import Figure

    size = (6.4 if columns == 1 else 10.5, height)
    with styled():
        figure = Figure(figsize=size, dpi=150, layout="constrained")
        axes = figure.subplots(1, columns, squeeze=False)[0]
    figure.suptitle(title, fontsize=11)
    figure.supxlabel(note, fontsize=8, color="0.35")
    return figure, list(axes)


def printed_line(ax: Axes, value: float, text: str, *, side: str = "right") -> None:
    """Draw a number that the paper prints, named at one end."""
    end = {"left": (0.0, 3), "right": (1.0, -3)}[side]
    ax.axhline(value, color="0.55", linewidth=0.8, zorder=0)
    ax.annotate(
        text,
        (end[0], value),
        xycoords=("axes fraction", "data"),
        xytext=(end[1], 2),
        textcoords="offset points",
        ha=side,
        fontsize=8,
        color="0.35",
    )


def figure_3(study: SphereStudy) -> Figure:
    """Impact force of two spheres by three models."""
    note = "The paper prints: full 811.5 N, 72 µs; one AO 812.6 N; rigid 999.9 N."
    figure, (ax,) = new_figure("Figure 3. Two spheres, 1 m/s: impact force", note)
    study.full.plot_force(
        ax, during="record", label=f"full model, 2 × {study.body.n_dofs} dofs", **FULL
    )
    study.rigid.plot_force(ax, during="record", label="rigid masses", **RIGID)
    study.one_ao.plot_force(ax, during="record", label="one AO each, 2 × 2 dofs", **ONE_AO)
    printed_line(ax, 811.5, "paper, full 811.5 N")
    printed_line(ax, 999.9, "paper, rigid 999.9 N")
    ax.set(xlim=(0, 100), ylim=(0, 1100))
    legend(ax)
    return figure


def figure_4(study: SphereStudy) -> Figure:
    """Impact force by the modal series."""
    note = "The paper prints, at 1000 modes: force +7 %, duration −5 %."
    figure, (left, right) = new_figure(
        "Figure 4. Two spheres: impact force by the modal series", note, columns=2
    )
    shown = (6, 100, 500, 1000)
    for n, shade in zip(shown, np.linspace(0.25, 0.9, len(shown)), strict=True):
        colour = {"color": (1.0 - shade, 0.45, shade), "linewidth": 1.2}
        study.modal[n].plot_force(left, during="record", label=f"{n} modes", **colour)
    study.full.plot_force(left, during="record", label=f"full, {study.body.n_dofs}", **FULL)
    left.set(xlim=(0, 90), ylim=(0, 1100))
    full = study.full
    counts = list(study.modal)
    force, time = zip(*(excesses(hit, full) for hit in study.modal.values()), strict=True)
    right.plot(counts, force, "o-", color=COLOURS[0], label="peak force")
    right.plot(counts, time, "s-", color=COLOURS[1], label="duration")
    right.plot([1000, 1000], [7, -5], "x", color="black", markersize=8, label="the paper")
    right.axhline(0.0, color="black", linewidth=0.8)
    right.set(xlabel="number of modes", ylabel="difference from the full model (%)")
    right.margins(x=0.05)
    legend(right)
    return figure


def figure_5(study: SphereStudy) -> Figure:
    """Energies of the sphere initially at rest."""
    note = "The paper: after the impact both deformation energies are negligible."
    title = "Figure 5. Sphere initially at rest, one AO: energies"
    figure, (ax,) = new_figure(title, note)
    study.one_ao.plot_energy(ax, body="target", color="black", linewidth=1.4)
    ax.set(xlim=(0, 100), ylim=(0, None))
    return figure


def figure_6(study: SphereStudy) -> Figure:
    """The model: rigid masses and an interaction law."""
    note = "m0, k1 and the Hertz spring together are the modified interaction law."
    figure, (ax,) = new_figure("Figure 6. Rigid masses and interaction law", note, height=2.6)
    draw_sketch(ax, study.oscillator, LAW.k)
    return figure


def figure_7(study: SphereStudy) -> Figure:
    """Force over approach for several velocities, and the share of nonlocal energy."""
    note = (
        "Left: force over the approach of the centres of mass. "
        "The paper prints, right: local energy 200 times the nonlocal one at 10⁻⁴ m/s."
    )
    figure, (left, right) = new_figure("Figure 7. Modified interaction law", note, columns=2)
    for speed, colour in zip((2.0, 1.0, 0.5, 0.1), COLOURS, strict=False):
        hit = study.by_speed[speed]
        touching = np.flatnonzero(hit.force > 0.0)
        shown, top = slice(0, int(touching[-1]) + 2), int(np.argmax(hit.force))
        style: dict[str, Any] = {"color": colour, "linestyle": ":", "linewidth": 2.0}
        left.plot(1e6 * hit.approach[shown], hit.force[shown], **style)
        where = (1e6 * float(hit.approach[top]), float(hit.force[top]))
        left.plot(*where, "o", color=colour, label=f"one AO each, up to {speed:g} m/s")
    depth = np.linspace(0.0, 32e-6, 200)
    left.plot(1e6 * depth, LAW.force(depth), color="black", label="Hertz's law")
    left.set(xlabel="approach (µm)", ylabel="contact force (N)", xlim=(0, 45), ylim=(0, 2000))
    legend(left)
    speeds = list(study.by_speed)
    ratios = [local_over_nonlocal(hit) for hit in study.by_speed.values()]
    right.loglog(speeds, ratios, "o-", color=COLOURS[0], label="at the peak")
    right.plot([1e-4], [200], "x", color="black", markersize=8, label="the paper")
    right.set(xlabel="velocity (m/s)", ylabel="local / nonlocal deformation energy")
    right.margins(x=0.05)
    right.grid(True, which="both", alpha=0.3)
    legend(right)
    return figure


def figure_8(study: BeamStudy) -> Figure:
    """Masses of the beam's anti-oscillators."""
    note = "The paper prints: static mass 467 g, the first AO 53 % of it, 28 AOs 98 %."
    figure, (ax,) = new_figure("Figure 8. Masses of the beam's anti-oscillators", note)
    number = np.arange(1, study.count + 1)
    lowest, largest = 100.0 * study.lowest.mass_fractions, 100.0 * study.star.mass_fractions
    ax.bar(number, lowest, color=COLOURS[0], label="mass of one AO, by frequency")
    ax.plot(number, np.cumsum(lowest), "o-", color="black", markersize=3, label="summed up")
    ax.plot(number, np.cumsum(largest), ":", color="0.4", label="summed up, largest first")
    printed_line(ax, 98.0, "paper, 28 AOs 98 %", side="left")
    printed_line(ax, 53.0, "paper, first AO 53 %")
    label = f"share of the static mass, {1e3 * study.star.static_mass:.0f} g (%)"
    ax.set(xlabel="anti-oscillator", ylabel=label, ylim=(0, 110), xlim=(0, 29))
    legend(ax)
    return figure


def figure_9(study: BeamStudy) -> Figure:
    """Impact force of the sphere on the beam."""
    note = (
        f"Dots: Newmark's steps of {with_unit(study.dt, 's')}. The beam by {study.count} AOs; "
        f"grey: its {study.body.n_dofs} dofs."
    )
    figure, (ax,) = new_figure("Figure 9. Sphere on the beam, 1 m/s: impact force", note)
    grey = {"color": "0.75", "linewidth": 4.0, "linestyle": "-"}
    study.hit("full", study.short).plot_force(
        ax, during="record", label="one-AO sphere, full beam", **grey
    )
    for hit, name, style in (
        (study.hit("ao", study.short), "one-AO sphere", FULL),
        (study.hit("rigid", study.short), "rigid sphere", RIGID),
    ):
        steps = style | {"linewidth": 1.0, "marker": ".", "markersize": 4}
        hit.plot_force(ax, during="record", label=name, **steps)
    ax.set(xlim=(0, 105), ylim=(0, None))
    legend(ax)
    return figure


def figure_10(study: BeamStudy) -> Figure:
    """Displacements of the centres of mass of sphere and beam, and of the beam's middle."""
    note = "The paper prints: the beam's maximum displacement is only 25 µm."
    title = "Figure 10. Displacements of sphere and beam"
    figure, (ax,) = new_figure(title, note)
    for hit, name, style in (
        (study.hit("ao", study.short), "one-AO sphere", FULL),
        (study.hit("rigid", study.short), "rigid sphere", RIGID),
    ):
        micro = 1e6 * hit.t
        ax.plot(
            micro, 1e6 * hit.projectile.centre_displacement, **style, label=f"centre of the {name}"
        )
        thin = style | {"linewidth": 0.8, "marker": ".", "markersize": 3, "markevery": 4}
        ax.plot(
            micro,
            1e6 * hit.target.centre_displacement,
            **thin,
            label=f"beam's centre of mass, {name}",
        )
        middle = style | {"color": COLOURS[0], "linewidth": 1.0}
        ax.plot(micro, 1e6 * hit.target.displacement, **middle, label=f"beam's middle, {name}")
    printed_line(ax, 25.0, "paper, beam 25 µm")
    ax.set(xlabel="time (µs)", ylabel="displacement (µm)", xlim=(0, 200))
    legend(ax)
    return figure


def figure_11(study: BeamStudy) -> Figure:
    """Displacement of the beam's centre of mass over 20 ms."""
    note = "The paper: the same for both models; to design the structure a rigid sphere will do."
    title = "Figure 11. Beam: displacement of the centre of mass"
    figure, (ax,) = new_figure(title, note)
    grey = {"color": "0.75", "linewidth": 4.0}
    for hit, name, style in (
        (study.hit("full", study.long), "one-AO sphere, full beam", grey),
        (study.hit("ao", study.long), "one-AO sphere", FULL),
        (study.hit("rigid", study.long), "rigid sphere", RIGID),
    ):
        ax.plot(1e3 * hit.t, 1e6 * hit.target.centre_displacement, label=name, **style)
    ax.set(xlabel="time (ms)", ylabel="displacement (µm)", xlim=(0, 20))
    legend(ax)
    return figure


def figure_mesh(study: SphereStudy) -> Figure:
    """Not in the paper: k1 and the force follow the mesh, and not towards the truth."""
    note = (
        "One AO each, contact at one node. Resolved contact mechanics: "
        f"{RESOLVED_FORCE} N, {1e6 * RESOLVED_DURATION:.2f} µs."
    )
    title = "The force of the paper's recipe belongs to the mesh"
    figure, (left, right) = new_figure(title, note, columns=2)
    cases = study.meshes.values()
    own = (len(study.body.nodes if study.body.nodes is not None else ()), study.one_ao)
    nodes = [case.nodes for case in cases]
    left.semilogx(nodes, [1e-6 * case.k1 for case in cases], "o-", color=COLOURS[0])
    left.plot([own[0]], [1e-6 * float(study.oscillator.k[0])], "D", color=COLOURS[1])
    left.plot([1053], [275.7], "x", color="black", markersize=8)
    left.set(xlabel="nodes", ylabel="k1 (MN/m)", ylim=(0, None))
    forces = [case.peak_force for case in cases]
    right.semilogx(nodes, forces, "o-", color=COLOURS[0], label="meshes of this package")
    right.plot([own[0]], [own[1].peak_force], "D", color=COLOURS[1], label="the shipped mesh")
    right.plot([1053], [812.6], "x", color="black", markersize=8, label="the paper")
    right.axhline(RESOLVED_FORCE, color="black", linewidth=1.2, label="resolved contact")
    right.axhline(study.rigid.peak_force, **RIGID, label="rigid masses")
    right.set(xlabel="nodes", ylabel="peak force (N)", ylim=(0, 1100))
    legend(right)
    for ax in (left, right):
        ax.set_xticks([300, 1000, 3000, 10000], ["300", "1000", "3000", "10 000"])
        ax.minorticks_off()
        ax.set_xlim(200, 10_000)
    return figure


SPHERE_FIGURES = (figure_3, figure_4, figure_5, figure_6, figure_7)
BEAM_FIGURES = (figure_8, figure_9, figure_10, figure_11)
