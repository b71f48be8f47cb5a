"""The axes that a figure is drawn on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .errors import InputTypeError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["error_axes", "given_axes"]


def given_axes(ax: Any) -> Axes:
    """Return the axes that a caller gave, or those of a new figure for None.

    Raises
    ------
    InputTypeError
        If it is no Axes.
    """
    import matplotlib.axes
    import matplotlib.pyplot as plt

    if ax is None:
        return plt.subplots(layout="constrained")[1]
    if not isinstance(ax, matplotlib.axes.Axes):
        raise InputTypeError(
            f"ax must be the Axes to draw on, such as plt.subplots()[1], got {type(ax).__name__}"
        )
    return ax


def error_axes(ax: Axes, across: str, up: str) -> Axes:
    """Return axes with curves of errors on them, labelled, both logarithmic."""
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel(across)
    ax.set_ylabel(up)
    ax.grid(True, which="major", alpha=0.3)
    ax.legend()
    return ax
