"""Render the report as one HTML page without references to the network or other files."""

import base64
import hashlib
import importlib.resources
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2
import plotly.offline
from markupsafe import Markup

from ident.output.figures import theme
from ident.output.report import blocks
from ident.output.report.blocks import ReportSection
from ident.output.report.contents import ReportContents
from ident.output.report.headline import Headline, headline
from ident.output.report.sections import causes, comparison, diagnosis, reproduce, response
from recordings.errors import BadInput
from recordings.files import replacement

_SCRIPT_ESCAPES = {ord(letter): f"\\u{ord(letter):04x}" for letter in "<>&\u2028\u2029"}
"""Escapes for characters that could end or break a script element; JSON decodes them."""


def write(contents: ReportContents, out: Path) -> None:
    """Write the whole page to `out`, or nothing; errors as `write_page`."""
    write_page(render(contents), out)


def write_page(page: str, out: Path) -> None:
    """Write a `page` to `out`, or nothing.

    Raises:
        BadInput: the file cannot be written.
    """
    try:
        with replacement(out) as partial:
            partial.write_text(page, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{out} cannot be written: {error.strerror}; choose another place") from None


def render(contents: ReportContents) -> str:
    """Return the whole page."""
    title = f"Report: {', '.join(contents.models)}" if contents.models else "Diagnosis"
    files = [source.name for source in contents.sources]
    return assembled(title, files, headline(contents), list(_sections(contents)), contents.as_json())


def assembled(
    title: str, files: Sequence[str], top: Headline, sections: Sequence[ReportSection], data: Mapping[str, Any]
) -> str:
    """Return a page with this headline and these sections; `data` is embedded as JSON."""
    folder = importlib.resources.files("ident.output.report") / "assets"
    figures = [
        (plot.id, _script_json(plot.figure.to_json()))
        for section in sections
        for plot in blocks.plots(section.blocks)
    ]
    scripts = [
        *([plotly.offline.get_plotlyjs()] if figures else []),
        theme.narrow_javascript(),
        (folder / "page.js").read_text(encoding="utf-8"),
    ]
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    templates = {"light": theme.LIGHT.to_plotly_json(), "dark": theme.DARK.to_plotly_json()}
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    template = environment.from_string((folder / "page.html").read_text(encoding="utf-8"))
    return template.render(
        title=title,
        files=files,
        headline=top,
        sections=sections,
        figures=figures,
        templates=_script_json(json.dumps(templates)),
        data=_script_json(json.dumps(data, allow_nan=False)),
        style=Markup((folder / "page.css").read_text(encoding="utf-8")),
        # Own scripts; the page's policy lists their hashes, so that no other script runs.
        scripts=[Markup(script) for script in scripts],
        hashes=hashes,
    )


def _sections(contents: ReportContents) -> Iterator[ReportSection]:
    """The order of the story: how far the error falls, what explains it, before and after; then all the rest."""
    if contents.diagnosis:
        yield diagnosis.error(contents.diagnosis)
        yield diagnosis.findings(contents.diagnosis)
        yield diagnosis.before_and_after(contents.diagnosis)
        yield diagnosis.remaining(contents.diagnosis)
        yield diagnosis.next_recording(contents.diagnosis)
    if contents.models:
        yield comparison.over_time(contents)
        yield comparison.failures(contents)
    if contents.responses:
        yield response.section(contents.responses)
    if contents.diagnosis:
        yield diagnosis.candidates(contents.diagnosis)
    if contents.models:
        yield comparison.fitted_parameters(contents)
        yield comparison.data_quality(contents)
        yield causes.section(contents)
        yield comparison.rig_and_runs(contents)
    yield reproduce.section(contents)


def _script_json(text: str) -> Markup:
    """Return JSON `text` escaped for a script element."""
    return Markup(text.translate(_SCRIPT_ESCAPES))
