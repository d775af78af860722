"""Section with the parameters and their uncertainty."""

from ident.output.assessment import summary_lines
from ident.output.figures import parameters
from ident.output.report.blocks import Fold, Notes, Plot, ReportBlock, ReportSection
from ident.output.report.contents import ReportContents
from ident.output.tables.parameters import side_by_side


def section(contents: ReportContents) -> ReportSection:
    """Return values with intervals, several models side by side."""
    models = contents.models
    blocks: list[ReportBlock] = [side_by_side(models)]
    if any(parameters.relative_half_width(entry) for model in models.values() for entry in model.all_parameters):
        caption = "Uncertainty of each parameter; beyond the dotted line not even its sign is known."
        blocks.append(Plot("precision", parameters.precision(models), caption))
    for index, (name, model) in enumerate(models.items(), start=1):
        if model.assessment:
            sentences = Notes(tuple(summary_lines(model, model.assessment)))
            caption = "near -1 or 1, this motion determines only a combination of two parameters."
            plot = Plot(
                f"correlation-{index}", parameters.correlation(model), f"Correlation of the errors: {caption}"
            )
            blocks.append(Fold(f"Assessment of {name}", (sentences, plot), open=index == 1))
    return ReportSection("parameters", "Parameters", tuple(blocks))
