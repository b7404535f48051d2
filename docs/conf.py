"""The documentation site: Sphinx with MyST, so that the pages stay Markdown. `make docs` builds it strictly."""

from __future__ import annotations

import tomllib
from pathlib import Path

import tatamu

URLS = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text())["project"].get("urls", {})

project = "tatamu"
author = "The tatamu developers"
copyright = f"2026, {author}"
release = tatamu.__version__
root_doc = "index"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["_build"]

myst_enable_extensions = ["attrs_inline", "colon_fence", "dollarmath"]
myst_heading_anchors = 4

# The notebooks of docs/notebooks are run when they or tatamu have changed; a cell that fails fails the site.
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 1800
nb_merge_streams = True
nb_output_stderr = "remove"  # warnings of libraries about the terminal

autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True  # a default such as a lambda is shown as its source
maximum_signature_line_length = 80  # longer signatures have one parameter a line
autodoc_default_options = {"members": True, "undoc-members": False, "show-inheritance": True}
napoleon_google_docstring = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"tatamu {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {
    "source_repository": URLS.get("Repository", ""),
    "source_branch": "main",
    "source_directory": "docs/",
    "navigation_with_keys": True,
}
