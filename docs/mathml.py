"""Equations as MathML, which browsers draw: the site needs no Internet."""

from __future__ import annotations

import re
from typing import Any

from docutils.nodes import SkipNode
from latex2mathml.converter import convert


def inline(translator: Any, node: Any) -> None:
    translator.body.append(convert(node.astext()))
    raise SkipNode


def displayed(translator: Any, node: Any) -> None:
    """With the number that ``\\tag`` gives at the right margin, as Sphinx has it."""
    tags = re.findall(r"\\tag\{(.*?)\}", node.astext())
    equation = convert(re.sub(r"\\tag\{.*?\}", "", node.astext()), display="block")
    number = "".join(f'<span class="eqno">({tag})</span>' for tag in tags)
    translator.body.append(f'<div class="math">{number}{equation}</div>')
    raise SkipNode


def setup(app: Any) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
