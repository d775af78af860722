"""The report as one HTML page that needs nothing else: no network, no other file."""

import base64
import hashlib
import importlib.resources
import json
from collections.abc import Iterator
from typing import Any

import jinja2
import plotly.offline
from markupsafe import Markup

from ident.output.figures import theme
from ident.output.report import blocks
from ident.output.report.blocks import ReportSection
from ident.output.report.headline import headline
from ident.output.report.contents import ReportContents
from ident.output.report.sections import (
    findings,
    parameters,
    quality,
    reproduce,
    residuals,
    rig,
    selection,
    torque,
    unexplained_residual,
)

_HARMLESS = {ord(letter): f"\\u{ord(letter):04x}" for letter in "<>&\u2028\u2029"}
"""Inside a script element; JSON reads them all the same."""


def render(material: ReportContents) -> str:
    """The whole page."""
    folder = importlib.resources.files("ident.output.report") / "assets"
    sections = list(_sections(material))
    scripts = [plotly.offline.get_plotlyjs(), (folder / "page.js").read_text(encoding="utf-8")]
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    template = environment.from_string((folder / "page.html").read_text(encoding="utf-8"))
    return template.render(
        title=f"Report: {', '.join(material.models)}",
        files=[source.name for source in material.sources],
        headline=headline(material),
        sections=sections,
        figures=[
            (plot.id, _embedded(plot.figure.to_json())) for one in sections for plot in blocks.plots(one.blocks)
        ],
        templates=_embedded(_templates()),
        data=_embedded(json.dumps(material.as_json(), allow_nan=False)),
        style=Markup((folder / "page.css").read_text(encoding="utf-8")),
        # Ours, and the hash of each stands in the page's policy: no other script runs in it.
        scripts=[Markup(script) for script in scripts],
        hashes=[_hash(script) for script in scripts],
    )


def _sections(material: ReportContents) -> Iterator[ReportSection]:
    makers = (
        torque.section,
        residuals.section,
        findings.section,
        selection.section,
        parameters.section,
        unexplained_residual.remaining,
        unexplained_residual.next_recording,
        quality.section,
        rig.section,
        reproduce.section,
    )
    for make in makers:
        section = make(material)
        if section:
            yield section


def _templates() -> str:
    both: dict[str, Any] = {"light": theme.LIGHT.to_plotly_json(), "dark": theme.DARK.to_plotly_json()}
    return json.dumps(both)


def _embedded(text: str) -> Markup:
    """JSON that may stand in a script element."""
    return Markup(text.translate(_HARMLESS))


def _hash(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
