"""Every table and figure of the paper, recomputed and shown beside its printed numbers.

``python -m aoimpact paper`` runs :func:`reproduce`; notebooks/paper.ipynb does the same step by
step. The paper's curves are not published as numbers. Numbers that it prints are drawn as thin
lines and crosses. Figures are drawn without windows.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base import (
    COLOURS,
    FilePath,
    bar,
    draw_curves,
    held_warnings,
    legend,
    styled,
    with_unit,
    writable_folder,
    write_csv,
)
from . import beam, sphere
from .sphere import BALL, SPEEDS, pair
from .table import Row, markdown, texts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FULL, RIGID, ONE_AO, WIDE, LINE, CROSS = texts()["styles"].values()

# Labels and styles of the runs of Figs. 9 to 11.
ON_BEAM = {
    "full": ("one-AO sphere, full beam", WIDE),
    "ao": ("one-AO sphere", FULL),
    "rigid": ("rigid sphere", RIGID),
}


def figure(draw: Callable[..., None]) -> Figure:
    """Return the figure that a function draws, with its texts from data/paper.toml."""
    from matplotlib.figure import Figure

    text = texts()[draw.__name__]
    with styled():
        figure = Figure(figsize=text["size"], dpi=150, layout="constrained")
        axes = figure.subplots(1, len(text["axes"]), squeeze=False)[0]
    figure.suptitle(text["title"], fontsize=11)
    figure.supxlabel(text["note"], fontsize=8, color="0.35")
    draw(*axes)
    for ax, look in zip(axes, text["axes"], strict=True):
        for value, name in look.get("lines", ()):
            ax.axhline(value, label=f"paper, {name}", **LINE)
        if "cross" in look:
            ax.plot(*look["cross"], label="the paper", **CROSS)
        ax.set(**look["set"])
        legend(ax)
    return figure


def figure_03(ax: Axes) -> None:
    """Impact force of two spheres with three models."""
    for body, name, style in (
        (sphere.all_dofs(), f"full model, 2 × {sphere.all_dofs().dofs} dofs", FULL),
        (BALL, "rigid masses", RIGID),
        (sphere.one_ao(), "one AO each, 2 × 2 dofs", ONE_AO),
    ):
        pair(body).plot_force(ax, during="record", label=name, **style)


def figure_04(left: Axes, right: Axes) -> None:
    """Impact force by the modal series."""
    hits, full = sphere.by_modes(), pair(sphere.all_dofs())
    for n, shade in ((6, 0.25), (100, 0.47), (500, 0.68), (1000, 0.9)):
        colour = (1.0 - shade, 0.45, shade)
        hits[n].plot_force(left, during="record", label=f"{n} modes", color=colour, linewidth=1.2)
    full.plot_force(left, during="record", label=f"full, {sphere.all_dofs().dofs}", **FULL)
    force, time = zip(*(sphere.excesses(hit, full) for hit in hits.values()), strict=True)
    right.plot([*hits], force, "o-", color=COLOURS[0], label="peak force")
    right.plot([*hits], time, "s-", color=COLOURS[1], label="duration")
    right.axhline(0.0, color="black", linewidth=0.8)


def figure_05(ax: Axes) -> None:
    """Energies of the sphere initially at rest."""
    pair(sphere.one_ao()).plot_energy(ax, body="target", color="black", linewidth=1.4)


def figure_06(ax: Axes) -> None:
    """Masses and springs of both AO models; all but the outer masses form the modified law."""
    model, law = sphere.one_ao(), ("F = k δ^1.5\nk", sphere.LAW.k, "N/m^1.5")
    m0, m1, k1 = ("m0", model.m0, "kg"), ("m1", model.m[0], "kg"), ("k1", model.k[0], "N/m")
    ax.axhline(0.0, color="black")
    for x, (name, value, unit) in enumerate((m1, k1, m0, law, m0, k1, m1)):
        box = {"facecolor": "0.9" if unit == "kg" else "white", "boxstyle": "square"}
        said = f"{name} = {with_unit(value, unit, 3)}".replace(" = ", "\n", unit == "kg")
        ax.text(x, 0.0, said, ha="center", va="center", bbox=box, fontsize=8)
    ax.annotate("V", (0.5, 0.7), (-0.5, 0.7), va="center", arrowprops={"arrowstyle": "->"})
    ax.annotate("", (5.6, -0.6), (0.4, -0.6), arrowprops={"arrowstyle": "<->"})
    ax.text(3.0, -0.55, "modified interaction law", ha="center", va="bottom")
    ax.axis("off")


def figure_07(left: Axes, right: Axes) -> None:
    """Force against approach for several velocities, and the ratio of local to nonlocal energy."""
    for speed, colour in zip((2.0, 1.0, 0.5, 0.1), COLOURS, strict=False):
        hit = pair(sphere.one_ao(), speed)
        end = int(np.flatnonzero(hit.force > 0.0)[-1]) + 2
        top = {"marker": "o", "markevery": [int(np.argmax(hit.force))]}
        style = {"color": colour, "linestyle": ":", "label": f"one AO each, up to {speed:g} m/s"}
        across = hit.approach[:end], "approach", "m"
        draw_curves(left, across, "contact force", "N", [(hit.force[:end], style | top)])
    depth = np.linspace(0.0, 32e-6, 200)
    law = sphere.LAW.force(depth), {"color": "black", "label": "Hertz's law"}
    draw_curves(left, (depth, "approach", "m"), "contact force", "N", [law])
    ratios = list(map(sphere.local_over_nonlocal, SPEEDS))
    right.loglog(SPEEDS, ratios, "o-", color=COLOURS[0], label="at the peak")


def figure_08(ax: Axes) -> None:
    """Masses of the beam's anti-oscillators."""
    number = np.arange(1, beam.COUNT + 1)
    largest, lowest = (100.0 * beam.star(by).mass_fractions for by in ("mass", "frequency"))
    ax.bar(number, lowest, color=COLOURS[0], label="mass of one AO, by frequency")
    ax.plot(number, np.cumsum(lowest), "o-", color="black", markersize=3, label="summed up")
    ax.plot(number, np.cumsum(largest), ":", color="0.4", label="summed up, largest first")


def figure_09(ax: Axes) -> None:
    """Impact force of the sphere on the beam."""
    for models, (name, style) in ON_BEAM.items():
        beam.hit(models).plot_force(ax, during="record", label=name, marker=".", **style)


def figure_10(ax: Axes) -> None:
    """Displacements of the centres of mass of sphere and beam, and of the beam's middle."""
    for models in ("ao", "rigid"):
        hit, (name, style) = beam.hit(models), ON_BEAM[models]
        for values, what, look in (
            (hit.projectile.centre_displacement, "centre of the", {}),
            (hit.target.centre_displacement, "beam's centre,", {"marker": ".", "markevery": 4}),
            (hit.target.displacement, "beam's middle,", {"color": COLOURS[0]}),
        ):
            curve = values, style | look | {"label": f"{what} {name}"}
            draw_curves(ax, (hit.t, "time", "s"), "displacement", "m", [curve])


def figure_11(ax: Axes) -> None:
    """Displacement of the beam's centre of mass over 20 ms."""
    for models, (name, style) in ON_BEAM.items():
        hit = beam.hit(models, beam.LONG)
        curve = hit.target.centre_displacement, style | {"label": name}
        draw_curves(ax, (hit.t, "time", "s"), "displacement", "m", [curve])


FIGURES = [draw for name, draw in globals().items() if name.startswith("figure_")]


TABLES = (
    *(sphere.table_1, sphere.table_2, sphere.table_3, sphere.impact, sphere.method),
    *(sphere.modal_series, sphere.energy, beam.table_4, beam.table_5, beam.oscillators),
    *(beam.force, beam.displacement, sphere.resolved),
)


def reproduce(out: FilePath, *, progress: bool = True) -> list[Path]:
    """Recompute all tables and Figures 3 to 11 of the paper, and write them to a folder.

    Parameters
    ----------
    out : path
        Folder for ``results.csv``, ``results.md``, ``figure_03.png`` ... ``figure_11.png``;
        made if there is none.
    progress : bool, optional
        True to show a progress bar (only ever on a terminal).

    Returns
    -------
    list of Path
        The files, in that order.

    Raises
    ------
    InputError
        If the folder cannot be made or written to.
    """
    folder, rows = writable_folder(out), list[Row]()
    files = [folder / "results.csv", folder / "results.md"]
    total = len(TABLES) + len(FIGURES)
    # The coarse meshes of the paper would warn with every figure.
    with bar("the paper", total, unit="part", wanted=progress) as shown, held_warnings():
        for table in TABLES:
            rows += table()
            shown.update()
        write_csv(files[0], Row._fields, rows)
        files[1].write_text(markdown(rows), encoding="utf-8")
        for draw in FIGURES:
            files.append(folder / f"{draw.__name__}.png")
            figure(draw).savefig(files[-1])
            shown.update()
    return files
