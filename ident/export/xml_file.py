"""XML as exports write it."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from recordings.files import replacement
from recordings.recording import Floats


def text(values: Sequence[float] | Floats) -> str:
    """The `values` as an attribute."""
    return " ".join(repr(float(value)) for value in values)


def write_xml(root: Element, out: Path) -> None:
    """Write the document `root`, indented, as a whole or not at all."""
    ElementTree.indent(root)
    with replacement(out) as partial:
        partial.write_text(ElementTree.tostring(root, encoding="unicode") + "\n", encoding="utf-8")
