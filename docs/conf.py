"""The site, made by sphinx-build -W -n docs site; its numbers and figures are made with it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib

import aoimpact

HERE = Path(__file__).parent
# sitetools; tests/resolved.py; benchmarks/work_precision.py
sys.path[:0] = [str(HERE), *(str(HERE.parent / folder) for folder in ("tests", "benchmarks"))]
matplotlib.use("Agg")

project = "aoimpact"
author = project_copyright = "The aoimpact developers"
version = release = aoimpact.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "mathml",
]
exclude_patterns = ["_build", "gallery", "README.md"]
templates_path = ["_templates"]
nitpicky = True
default_role = "autolink"  # single backticks in docstrings: a link where the name is public

html_theme = "furo"
html_title = f"aoimpact {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_math_renderer = "mathml"
html_theme_options = {"navigation_with_keys": True}

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4

autosummary_generate = True
autodoc_typehints = "none"  # the docstrings say types, with shapes and units
autodoc_member_order = "groupwise"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
# All of numpydoc's rules but those that ask every property for an example, a return section or a
# longer text (public names have examples: a test holds that), and those of style: what starts with
# a symbol, types that are named above, dataclasses whose fields stand under Attributes.
numpydoc_validation_checks = {
    "all", "EX01", "SA01", "ES01", "RT01", "RT03", "RT04", "SS01", "SS02",
    "GL01", "GL02", "GL03", "GL08", "PR01", "PR03", "PR04", "PR07", "PR08",
}  # fmt: skip

sphinx_gallery_conf = {
    "examples_dirs": [f"gallery/{name}" for name in ("start", "how_to", "validation")],
    "gallery_dirs": ["start", "how-to", "validation"],
    "filename_pattern": "/",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "backreferences_dir": "api/_examples",
    "doc_module": ("aoimpact",),
    "reference_url": {"aoimpact": None},
    "inspect_global_variables": False,
    "remove_config_comments": True,
    "image_scrapers": ("sitetools.figures",),
    "ignore_repr_types": "matplotlib|mpl_toolkits",
    "show_signature": False,
    "write_computation_times": False,
    "download_all_examples": False,
    "reset_modules": ("matplotlib", "sitetools.settle"),
}


def setup(app: Any) -> None:
    from sitetools import parameter, returned

    app.connect("missing-reference", parameter)
    app.connect("autodoc-process-signature", returned)
