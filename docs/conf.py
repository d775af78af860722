"""Sphinx configuration of the documentation; `make docs` builds it and fails at the first warning."""

import importlib
import json
import re
from importlib.metadata import version as installed_version
from typing import Any

from click.testing import CliRunner
from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer

from ident.cli import program

project = "delta-workbench"
version = installed_version(project)
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
exclude_patterns = ["examples"]
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
myst_heading_anchors = 3
html_theme = "furo"
html_title = project


def setup(app: Sphinx) -> None:
    """Fill in what comes from the code."""
    app.connect("source-read", _fill_in)
    app.connect("autodoc-process-docstring", _list_arguments)


def _fill_in(app: Sphinx, page: str, source: list[str]) -> None:
    """Replace the comments of a page by the tables that they name."""
    source[0] = re.sub(r"<!-- keys of ([\w.]+)\.(\w+) -->", _keys, source[0])
    source[0] = source[0].replace("<!-- effects of the library -->", _effects())


def _keys(match: re.Match[str]) -> str:
    """Table of the keys of a section of a TOML file, with their defaults and comments."""
    module, name = match.groups()
    section = getattr(importlib.import_module(module), name)
    comments = ModuleAnalyzer.for_module(module).find_attr_docs()
    rows = ["| key | default | meaning |", "|---|---|---|"]
    for key, field in section.model_fields.items():
        default = "required" if field.is_required() else f"`{_default(field.get_default(call_default_factory=True))}`"
        rows.append(f"| `{key}` | {default} | {' '.join(comments.get((name, key), []))} |")
    return "\n".join(rows)


def _default(value: Any) -> str:
    return "..." if hasattr(value, "model_dump") else json.dumps(value)


def _effects() -> str:
    """One section per effect, as `ident effects --json` has it."""
    effects = json.loads(CliRunner().invoke(program, ["effects", "--json"]).stdout)["effects"]
    return "\n".join(line for effect in effects for line in _effect(effect))


def _effect(effect: dict[str, Any]) -> list[str]:
    scope = "one set for the whole robot" if effect["whole_robot"] else "one set per joint"
    rows = [f"| `{q['name']}` | {q['unit']} | {q['meaning']} |" for q in effect["parameters"]]
    return [
        f"## {effect['name']}\n",
        f"{effect['sentence']} {effect['looks']}\n",
        f"- Usual causes: {effect['causes']}.",
        f"- What to do: {effect['remedy']}.",
        f"- Equation: `{effect['equation']}`, {scope}; mechanisms: {', '.join(effect['mechanisms'])}.\n",
        *["| parameter | unit | meaning |", "|---|---|---|", *rows, ""],
    ]


def _list_arguments(app: Sphinx, what: str, name: str, subject: object, options: object, lines: list[str]) -> None:
    """Show the lines `argument: meaning` of a docstring as a list."""
    lines[:] = [re.sub(r"^([a-z_]+(?:, [a-z_]+)*): ", r"* **\1**: ", line) for line in lines]
