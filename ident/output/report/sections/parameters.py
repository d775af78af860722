"""Section with the parameters and their uncertainty."""

from ident.identification.model_file import ModelFile
from ident.output.console import assessment
from ident.output.figures import parameters
from ident.output.figures.theme import number
from ident.output.report.blocks import Fold, Notes, Plot, ReportBlock, ReportSection, ReportTable
from ident.output.report.contents import ReportContents

_KNOWN = {"identifiable": "yes", "weak": "weakly", "not": "no", None: "–"}


def section(contents: ReportContents) -> ReportSection:
    """Return values with intervals, several models side by side."""
    blocks: list[ReportBlock] = [_table(contents)]
    if any(
        parameters.relative_half_width(entry) for model in contents.models.values() for entry in model.all_parameters
    ):
        caption = "Uncertainty of each parameter; beyond the dotted line not even its sign is known."
        blocks.append(Plot("precision", parameters.precision(contents.models), caption))
    for index, (name, model) in enumerate(contents.models.items(), start=1):
        blocks += _assessment(index, name, model)
    return ReportSection("parameters", "Parameters", tuple(blocks))


def _table(contents: ReportContents) -> ReportTable:
    models = contents.models
    by_name = {name: {entry.name: entry for entry in model.all_parameters} for name, model in models.items()}
    units = {entry.name: entry.unit for model in models.values() for entry in model.all_parameters}
    several = len(models) > 1
    rows = []
    for parameter, unit in units.items():
        cells = [parameter]
        for name in models:
            fitted = by_name[name].get(parameter)
            bound = " (at bound)" if fitted and fitted.at_bound else ""
            cells += [
                f"{number(fitted.value, 4)}{bound}" if fitted else "",
                assessment.half_width(fitted) if fitted else "",
                _KNOWN[fitted.status] if fitted else "",
            ]
        rows.append((*cells, unit))
    per_model = [(f"{name}: value" if several else "value", "± 95 %", "identifiable") for name in models]
    head = ("parameter", *(cell for cells in per_model for cell in cells), "unit")
    caption = "Friction is positive where it opposes motion."
    scales = {
        assessment.scale_line(model.assessment.scale_uncertainty, model.relative)
        for model in models.values()
        if model.assessment
    }
    caption = " ".join([caption, *sorted(scales)])
    return ReportTable(head, tuple(rows), caption, words=(0, len(head) - 1))


def _assessment(index: int, name: str, model: ModelFile) -> list[ReportBlock]:
    if model.assessment is None:
        return []
    title = f"Assessment of {name}"
    correlation = Plot(
        f"correlation-{index}",
        parameters.correlation(model),
        "Correlation of the errors: near -1 or 1, this motion determines only a combination of two parameters.",
    )
    return [
        Fold(title, (Notes(tuple(assessment.summary_lines(model, model.assessment))), correlation), open=index == 1)
    ]
