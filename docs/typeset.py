"""Sphinx extension: formulas as MathML, which browsers render without a script and without network."""

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

_TAG = re.compile(r"\\tag\{(.*?)\}")
_UNKNOWN = re.compile(r"\\\w+|<mi>&</mi>")
"""What the converter leaves where it does not know a command."""


def setup(app: Sphinx) -> None:
    """Register the renderer `mathml`."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))


def mathml(latex: str, display: str) -> str:
    """The formula `latex` as MathML; `display`: `inline` or `block`.

    Raises:
        ValueError: a command that is not known.
    """
    converted: str = convert(latex, display=display)
    if unknown := _UNKNOWN.findall(converted):
        raise ValueError(f"LaTeX that becomes MathML expected, found {', '.join(unknown)} in {latex!r}")
    return converted


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    latex = node.astext()
    numbers = _TAG.findall(latex)
    ids = "".join(f'<span id="eq-{number}"></span>' for each in numbers for number in each.split(", "))
    number = "".join(f'<span class="equation-number">({each})</span>' for each in numbers)
    formula = mathml(_TAG.sub("", latex), "block")
    writer.body.append(f'<div class="equation">{ids}<div class="formula">{formula}</div>{number}</div>')
    raise nodes.SkipNode
