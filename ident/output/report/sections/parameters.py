"""Parameters and how well they are known."""

from ident.identification.model import Model
from ident.output.console import assessment
from ident.output.figures import parameters
from ident.output.figures.theme import number
from ident.output.report.blocks import ReportBlock, Fold, Notes, Plot, ReportSection, ReportTable
from ident.output.report.contents import ReportContents

_KNOWN = {"identifiable": "yes", "weak": "weakly", "not": "no", None: "–"}


def section(material: ReportContents) -> ReportSection:
    """Values with intervals, side by side where there are several models."""
    blocks: list[ReportBlock] = [_table(material)]
    if any(parameters.relative_half_width(one) for model in material.models.values() for one in model.parameters):
        caption = "How well each parameter is known; beyond the dotted line not even its sign is."
        blocks.append(Plot("precision", parameters.precision(material.models), caption))
    for place, (name, model) in enumerate(material.models.items(), start=1):
        blocks += _trust(place, name, model)
    return ReportSection("parameters", "Parameters", tuple(blocks))


def _table(material: ReportContents) -> ReportTable:
    models = material.models
    known = {name: {one.name: one for one in model.parameters} for name, model in models.items()}
    units = {one.name: one.unit for model in models.values() for one in model.parameters}
    several = len(models) > 1
    rows = []
    for parameter, unit in units.items():
        cells = [parameter]
        for name in models:
            one = known[name].get(parameter)
            bound = " (at bound)" if one and one.at_bound else ""
            cells += [
                f"{number(one.value, 4)}{bound}" if one else "",
                assessment.half_width(one) if one else "",
                _KNOWN[one.status] if one else "",
            ]
        rows.append((*cells, unit))
    per_model = [(f"{name}: value" if several else "value", "± 95 %", "identifiable") for name in models]
    head = ("parameter", *(cell for cells in per_model for cell in cells), "unit")
    relative = any(model.relative for model in models.values())
    caption = "Friction is positive where it opposes motion."
    caption += " Relative: known up to one common factor." if relative else ""
    return ReportTable(head, tuple(rows), caption, words=(0, len(head) - 1))


def _trust(place: int, name: str, model: Model) -> list[ReportBlock]:
    if model.trust is None:
        return []
    title = f"How far to trust {name}"
    correlation = Plot(
        f"correlation-{place}",
        parameters.correlation(model),
        "Correlation of the errors: of two parameters near -1 or 1, this motion tells only a combination.",
    )
    return [Fold(title, (Notes(tuple(assessment.summary_lines(model, model.trust))), correlation), open=place == 1)]
