"""Sphinx configuration of the documentation; `make docs` builds it and fails at the first warning."""

import importlib
import inspect
import json
import os
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import click
from click.testing import CliRunner
from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer

import ident.program
from ident.dynamics.effects.library import library

sys.path.insert(0, str(Path(__file__).parent))  # for `typeset` and the two below
import effect_pictures
import gallery

project = "delta-workbench"
version = installed_version(project)
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "typeset"]
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["equations.css"]
myst_enable_extensions = ["dollarmath"]
exclude_patterns = ["examples"]
autodoc_typehints_format = "short"
default_role = "code"
html_show_copyright = False
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}
myst_heading_anchors = 3
html_theme = "furo"
html_title = project


def setup(app: Sphinx) -> None:
    """Fill in what comes from the code."""
    app.connect("source-read", _fill_in)
    app.connect("autodoc-process-docstring", _list_arguments)
    app.connect("autodoc-process-signature", _plain_aliases)


def _fill_in(app: Sphinx, page: str, source: list[str]) -> None:
    """Replace the comments of a page by what they name."""
    for comment, text in (
        (r"keys of ([\w.]+)\.(\w+)", _keys),
        (r"commands of (\w+): ([\w.]+)", _commands),
        (r"effects of the library", lambda: _effects(app, page)),
        (r"example (\w+)", lambda name: _example(app, page, name)),
    ):
        source[0] = re.sub(f"<!-- {comment} -->", lambda match, text=text: text(*match.groups()), source[0])


def _example(app: Sphinx, page: str, name: str) -> str:
    """An example of the gallery, run now in a folder beside the site."""
    folder = Path(app.outdir).parent / "gallery" / name
    return gallery.shown(name, folder, os.path.relpath(folder, (Path(app.srcdir) / page).parent))


def _commands(name: str, module: str) -> str:
    """Help of each command, and of each command of a group."""
    program: click.Group = importlib.import_module(module).program
    return "\n\n".join(
        f"### {name} {' '.join(words)}\n\n```text\n{_help(name, program, words)}```" for words in _names(program)
    )


def _names(group: click.Group) -> Iterator[list[str]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        further = _names(command) if isinstance(command, click.Group) else [[]]
        yield from ([name, *words] for words in further)


def _help(name: str, program: click.Group, words: list[str]) -> str:
    return CliRunner().invoke(program, [*words, "--help"], prog_name=name).stdout


def _keys(module: str, name: str) -> str:
    """Purpose and table of the keys of a section of a TOML file."""
    section = getattr(importlib.import_module(module), name)
    comments = ModuleAnalyzer.for_module(module).find_attr_docs()
    rows = ["| key | default | meaning |", "|---|---|---|"]
    for key, field in section.model_fields.items():
        if key not in section.__annotations__:  # of its base, which has a table of its own
            continue
        choices = get_args(field.annotation) if get_origin(field.annotation) is Literal else ()
        meaning = [", ".join(f"`{json.dumps(choice)}`" for choice in choices), *comments.get((name, key), [])]
        default = "required" if field.is_required() else _default(field.get_default(call_default_factory=True))
        rows.append(f"| `{key}` | {default} | {' '.join(meaning)} |")
    return "\n".join([" ".join(inspect.getdoc(section).split()), "", *rows])


def _default(value: Any) -> str:
    """A value as it would stand in the file, with six digits; nothing for what has no value of its own."""
    if value is None or hasattr(value, "model_dump"):
        return "section" if value else "none"
    return f"`{re.sub(r'[0-9.]{8,}', lambda match: f'{float(match[0]):.6g}', json.dumps(value))}`"


def _effects(app: Sphinx, page: str) -> str:
    """One section per effect, as `ident effects --json` has it, with its picture and what imitates it."""
    described = json.loads(CliRunner().invoke(ident.program.program, ["effects", "--json"]).stdout)["effects"]
    checked = {each.effect: each.confusable_with for each in ident.check(effect_pictures.SAMPLE).effects}
    folder = Path(app.outdir).parent / "effects"
    link = os.path.relpath(folder, (Path(app.srcdir) / page).parent)
    for name, effect in library().items():
        if _drawn(effect.mechanisms):
            effect_pictures.draw(name, effect, folder / f"{name}.png")
    return "\n".join(line for each in described for line in _effect(each, checked.get(each["name"], ()), link))


def _drawn(mechanisms: Sequence[str]) -> bool:
    """Whether the robot or the axis of the pictures can have an effect of these mechanisms."""
    return not {"delta", "axes"}.isdisjoint(mechanisms)


def _effect(effect: dict[str, Any], imitations: Sequence[str], link: str) -> list[str]:
    scope = "one set for the whole robot" if effect["whole_robot"] else "one set per joint"
    rows = [f"| `{q['name']}` | {q['unit']} | {q['meaning']} |" for q in effect["parameters"]]
    others = {"Contains": effect["contains"], "On this motion also explained by": imitations}
    named = [f"- {title} {', '.join(f'`{name}`' for name in names)}." for title, names in others.items() if names]
    return [
        f"## {effect['name']}\n",
        f"{effect['sentence']}\n",
        *([f"![Torque of {effect['name']}]({link}/{effect['name']}.png)\n"] if _drawn(effect["mechanisms"]) else []),
        f"- In the residual: {effect['symptom']}",
        *named,
        f"- To see it, record: {effect['record']}.",
        f"- Usual causes: {effect['causes']}.",
        f"- What to do: {effect['remedy']}.",
        f"- Equation: {_equation(effect)}, {scope}; mechanisms: {', '.join(effect['mechanisms'])}.\n",
        *["| parameter | unit | meaning |", "|---|---|---|", *rows, ""],
    ]


def _equation(effect: dict[str, Any]) -> str:
    """The effect's formula as it is typeset, or its equation as text where it has none."""
    return f"${effect['latex']}$" if effect["latex"] else f"`{effect['equation']}`"


def _list_arguments(app: Sphinx, what: str, name: str, subject: object, options: object, lines: list[str]) -> None:
    """Show the lines `argument: meaning` of a docstring as a list."""
    lines[:] = [re.sub(r"^([a-z_]+(?:, [a-z_]+)*): ", r"* **\1**: ", line) for line in lines]


def _plain_aliases(
    app: Sphinx, what: str, name: str, subject: object, options: object, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Name a type alias also where Sphinx shows its own wrapper of it, as in `ArrayLike | None`."""
    return signature and re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", signature), returns
