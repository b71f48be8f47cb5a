"""Style of all figures: colours, lines, labels with units, legends within the axes.

The colours are those of M. Okabe and K. Ito, *Color Universal Design* (2008), which colour-blind
readers can distinguish. Lines also differ in their dashes, for print without colour.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from .checks import FloatArray
from .errors import InputTypeError
from .units import scale_for, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# A curve: its values, and keywords of ``Axes.plot``.
Curve = tuple[FloatArray, dict[str, Any]]

# COLOURS: blue, vermilion, green, purple, orange, sky blue, black.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)), (0, (3, 1)))


@contextmanager
def styled() -> Iterator[None]:
    """Give new figures and axes the style of this package within the context.

    At the end, only the settings made here are restored. ``rc_context`` would restore all settings:
    a notebook, which becomes interactive with its first figure, would show no further figures.
    """
    import matplotlib.pyplot as plt
    from cycler import cycler  # comes with matplotlib

    count = len(DASHES)
    # Dashes are shifted at each repetition, so that every pair of colour and dash occurs.
    dashes = [DASHES[(i + i // count) % count] for i in range(count * len(COLOURS))]
    look: Any = {
        "axes.prop_cycle": cycler(color=COLOURS * count) + cycler(linestyle=dashes),
        "axes.grid": True,
        "axes.xmargin": 0.0,
        "figure.constrained_layout.h_pad": 0.08,
        "figure.constrained_layout.w_pad": 0.08,
        "axes.spines.right": False,
        "axes.spines.top": False,
        "grid.alpha": 0.3,
        "legend.frameon": False,
    }
    before = {name: plt.rcParams[name] for name in look}
    plt.rcParams.update(look)
    try:
        yield
    finally:
        plt.rcParams.update(before)


def new_axes(rows: int = 1, columns: int = 1, **kwargs: Any) -> Any:
    """Return the axes of a new figure: one, or an array of shape (rows, columns)."""
    import matplotlib.pyplot as plt

    with styled():
        return plt.subplots(rows, columns, layout="constrained", **kwargs)[1]


def given_axes(ax: Any) -> Axes:
    """Return the given axes; for None, return the axes of a new figure.

    Raises
    ------
    InputTypeError
        If `ax` is neither Axes nor None.
    """
    import matplotlib.axes

    if ax is None:
        ax = new_axes()
    if not isinstance(ax, matplotlib.axes.Axes):
        raise InputTypeError(f"ax must be Axes of matplotlib, got {type(ax).__name__}")
    return ax


def label(name: str, unit: str) -> str:
    """Return the label of an axis, such as "time (µs)"."""
    return f"{name} ({unit})" if unit else name


def legend(ax: Axes) -> None:
    """Draw the legend within the axes, at the place where it hides the curves least."""
    if ax.get_legend_handles_labels()[1]:
        ax.legend(loc="best", fontsize="small")


def error_axes(ax: Axes, across: str, up: str) -> Axes:
    """Label the axes of error curves, make both logarithmic, and return them."""
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.margins(x=0.05)  # room for markers at both ends
    ax.set_xlabel(across)
    ax.set_ylabel(up)
    ax.grid(True, which="major", alpha=0.3)
    legend(ax)
    return ax


def draw_curves(
    ax: Any,
    across: tuple[FloatArray, str, str],
    name: str,
    unit: str,
    curves: list[Curve],
    kwargs: dict[str, Any] | None = None,
) -> Axes:
    """Draw curves of one quantity on axes labelled with suitable SI prefixes; return the axes.

    Parameters
    ----------
    ax : Axes or None
        None makes a new figure. Axes that are labelled in the given units keep their prefixes.
    across : (values, name, unit)
        Quantity on the horizontal axis.
    name, unit : str
        Quantity on the vertical axis.
    curves : list of (values, keywords of ``Axes.plot``)
    kwargs : dict, optional
        Keywords of ``Axes.plot`` for all curves.
    """
    axes = given_axes(ax)
    x, x_name, x_unit = across
    largest = max([float(np.nanmax(np.abs(y), initial=0.0)) for y, _ in curves], default=0.0)
    reach = float(np.max(np.abs(x), initial=0.0))
    x_factor, x_shown = scale_of(axes.get_xlabel(), x_unit) or scale_for(reach, x_unit)
    y_factor, y_shown = scale_of(axes.get_ylabel(), unit) or scale_for(largest, unit)
    for y, style in curves:
        axes.plot(x_factor * x, y_factor * y, **style | (kwargs or {}))
    axes.set_xlabel(label(x_name, x_shown))
    axes.set_ylabel(label(name, y_shown))
    axes.grid(True, alpha=0.3)
    if x_unit == "s":
        span = x_factor * np.append(x[:1], x[-1:])  # show the whole record in any case
        axes.update_datalim(np.column_stack([span, 0.0 * span]), updatey=False)
        axes.margins(x=0.0)
    legend(axes)
    return axes
