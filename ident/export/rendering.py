"""Texts of exports from the templates in `templates/`: C, and XML."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import jinja2

from ident.export.xml_file import text


def rendered(name: str, values: Mapping[str, Any]) -> str:
    """The template `name` with these `values`; its filter `text` writes numbers as attributes."""
    return _environment().get_template(name).render(values)


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,  # C, and XML of numbers and known names
    )
    environment.filters["text"] = text
    return environment
