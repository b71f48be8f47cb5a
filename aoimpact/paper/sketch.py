"""The sketch of Figure 6: two rigid masses, and between them what makes the modified law."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import COLOURS, with_unit
from ..reduction import AOModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BIG, _SMALL = 1.0, 0.36  # sides of the boxes for m1 and m0


def draw_sketch(ax: Axes, model: AOModel, hertz: float) -> None:
    """Draw m1 - k1 - m0 - Hertz - m0 - k1 - m1 of two like one-AO bodies, with their numbers."""
    ax.set(xlim=(-0.2, 8.2), ylim=(-1.5, 1.6), aspect="equal")
    ax.axis("off")
    mass, residual = with_unit(float(model.m[0]), "kg", 3), with_unit(model.m0, "kg", 2)
    _box(ax, 0.5, _BIG, f"m1\n{mass}")
    _box(ax, 7.5, _BIG, f"m1\n{mass}")
    _box(ax, 2.6, _SMALL, "")
    _box(ax, 5.4, _SMALL, "")
    stiffness = with_unit(float(model.k[0]), "N/m", 3)
    for start, end, label in (
        (1.0, 2.42, f"k1\n{stiffness}"),
        (2.78, 5.22, f"F = k δ^1.5\nk = {with_unit(hertz, 'N/m^1.5', 3)}"),
        (5.58, 7.0, f"k1\n{stiffness}"),
    ):
        _spring(ax, start, end)
        ax.text(0.5 * (start + end), 0.32, label, ha="center", va="bottom", fontsize=8)
    for x in (2.6, 5.4):
        ax.text(x, -0.3, f"m0 = {residual}", ha="center", va="top", fontsize=8)
    ax.annotate("", (1.5, 1.15), (0.0, 1.15), arrowprops={"arrowstyle": "->"})
    ax.text(0.75, 1.25, "V", ha="center", fontsize=10)
    ax.annotate(
        "", (1.0, -0.85), (7.0, -0.85), arrowprops={"arrowstyle": "<->", "color": COLOURS[1]}
    )
    ax.text(4.0, -1.2, "modified interaction law", ha="center", color=COLOURS[1], fontsize=10)


def _box(ax: Axes, x: float, side: float, label: str) -> None:
    from matplotlib.patches import Rectangle

    corner = (x - 0.5 * side, -0.5 * side)
    ax.add_patch(Rectangle(corner, side, side, facecolor="0.9", edgecolor="black"))
    ax.text(x, 0.0, label, ha="center", va="center", fontsize=9)


def _spring(ax: Axes, start: float, end: float) -> None:
    turns = 12
    x = np.linspace(start, end, turns + 5)
    y = np.zeros_like(x)
    y[2:-2] = 0.16 * (-1.0) ** np.arange(turns + 1)
    ax.plot(x, y, "-", color="black", linewidth=1.0)
