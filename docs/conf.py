"""Sphinx settings of the documentation: `make docs`."""

import re
import shutil
from importlib.metadata import version as _version
from pathlib import Path

project = "estexp_jax"
author = "The estexp_jax developers"
copyright = "The estexp_jax developers, Apache-2.0"
release = version = _version("estexp_jax")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon"]
templates_path = ["_templates"]
exclude_patterns = ["_build", "**.ipynb_checkpoints"]
html_theme = "furo"
html_title = "estexp_jax"

# Pages show code; a test runs it (tests/test_docs.py), so that building the pages stays cheap.
nb_execution_mode = "off"
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_google_docstring, napoleon_numpy_docstring = True, False
napoleon_use_ivar = True  # attributes are told with the class, once
nitpicky = False
suppress_warnings = ["ref.python"]  # annotations name classes without their modules, and two are called Simulator


def _plain(app, what, name, obj, options, lines):
    """Docstrings are plain text with `code` in it, not reStructuredText: bars and stars are just that."""
    fenced = False
    for index, line in enumerate(lines):
        if line.strip().startswith("```"):
            fenced = not fenced
            lines[index] = f"{line[: len(line) - len(line.lstrip())]}.. code-block:: python\n" if fenced else ""
            continue
        if fenced:
            lines[index] = f"    {line}"
            continue
        parts = re.split(r"`+([^`]*)`+", line)
        words = [part if k % 2 else re.sub(r"([|*\\]|(?<=\w)_(?!\w))", r"\\\1", part) for k, part in enumerate(parts)]
        lines[index] = "".join(f"``{word}``" if k % 2 else word for k, word in enumerate(words))
    lines[:] = "\n".join(lines).split("\n")


def _bring_in(app):
    """Notebooks, with the outputs that they hold, which stand elsewhere in the repository."""
    folder = Path(app.srcdir) / "_notebooks"
    folder.mkdir(exist_ok=True)
    for path in (Path(app.srcdir).parent / "experiments" / "notebooks").glob("*.ipynb"):
        shutil.copy(path, folder / path.name)


def setup(app):
    """Before napoleon, which has the default priority."""
    app.connect("builder-inited", _bring_in)
    app.connect("autodoc-process-docstring", _plain, priority=400)
