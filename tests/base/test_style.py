"""The look of figures, and what of Matplotlib's settings it leaves alone."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt

from aoimpact.base import COLOURS, new_axes, styled


def test_a_new_figure_has_the_look_and_later_ones_have_not() -> None:
    (line,) = new_axes().plot([0.0, 1.0])
    assert line.get_color() == COLOURS[0]
    (later,) = plt.subplots()[1].plot([0.0, 1.0])
    assert later.get_color() != COLOURS[0]
    plt.close("all")


def test_what_a_backend_sets_while_a_figure_is_made_stays() -> None:
    """A notebook's turns interactive with its first figure, else it would show no further one."""
    before = mpl.is_interactive()
    try:
        with styled():
            mpl.interactive(not before)
        assert mpl.is_interactive() is not before
    finally:
        mpl.interactive(before)
