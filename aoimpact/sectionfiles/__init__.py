"""Sections and materials of decks: what their groups of elements are made of, for `from_mesh`.

A format a file. Public.
"""

from .read import read_sections
