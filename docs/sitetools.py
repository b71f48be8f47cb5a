"""What the building of the site needs of its own; conf.py names it."""

from __future__ import annotations

import logging
import re
import warnings
from typing import Any

from aoimpact.base import styled

_kept: list[Any] = []  # a context that nobody holds ends


def settle(_conf: Any = None, _file: str = "") -> None:
    """Let an example's warnings stand among what it prints, and figures look as the package's."""
    _kept.append(styled())  # Matplotlib's settings are reset before the next example
    _kept[-1].__enter__()
    logging.getLogger("skfem").setLevel(logging.WARNING)
    # Not showwarning, which sphinx-gallery replaces around each block.
    warnings.formatwarning = lambda message, kind, *_, **__: f"{kind.__name__}: {message}\n"


def figures(block: Any, variables: Any, conf: Any, **kwargs: Any) -> str:
    """Save figures as sphinx-gallery does, with what is drawn as the text for who cannot see it."""
    import matplotlib.pyplot as plt
    from sphinx_gallery.scrapers import matplotlib_scraper

    told = [_told(plt.figure(number)) for number in plt.get_fignums()]
    written = matplotlib_scraper(block, variables, conf, **kwargs)
    return re.sub("(?<=:alt: ).*", lambda _: told.pop(0), written)


def _told(figure: Any) -> str:
    drawn = [" over ".join(filter(None, (ax.get_ylabel(), ax.get_xlabel()))) for ax in figure.axes]
    return " ".join("; ".join(dict.fromkeys(filter(None, drawn))).split())


def parameter(app: Any, env: Any, node: Any, text: Any) -> Any:
    """Leave a parameter's name in single backticks as it is; a name with a dot must be there."""
    return text if node["reftype"] == "obj" and "." not in node["reftarget"] else None


def returned(app: Any, what: str, name: str, *_: Any) -> tuple[str, None] | None:
    """Leave out how a class is constructed of which users only meet what calls return."""
    own = name in ("aoimpact.Run", "aoimpact.Result", "aoimpact.Handle")
    within = name.removeprefix("aoimpact.testrig.").count(".") > 1
    return ("", None) if what == "class" and (own or within) else None
