"""Section with the steps of the selection and the error of each."""

from ident.diagnosis.document.result import DiagnosisResult
from ident.output.figures import steps
from ident.output.report.blocks import Fold, Plot, ReportBlock, ReportSection, ReportTable
from ident.output.report.sections import parameter_values


def error(result: DiagnosisResult) -> ReportSection:
    """Return the fall of the error from model to model."""
    document = result.document
    caption = (
        f"Error of each model on the rows it was fitted to, and on rows held out ({document.held_out}). A bar that "
        "falls in training only is overfitting. The dashed line is the error of a correct model."
    )
    return ReportSection("steps", "How far the error falls", (Plot("steps", steps.error_steps(document), caption),))


def candidates(result: DiagnosisResult) -> ReportSection:
    """Return what each effect would explain, the effects that were not added, and the last model."""
    diagnosis, document = result.diagnosis, result.document
    blocks: list[ReportBlock] = []
    if diagnosis.selection.first_reductions or diagnosis.selection.last_reductions:
        caption = "Predicted share of the residual that each effect explains; added effects in bold."
        blocks.append(Plot("candidates", steps.candidates(diagnosis), caption))
    rejected = tuple((entry.effect, entry.status, entry.why) for entry in document.rejected)
    blocks.append(
        Fold("Effects that were not added", (ReportTable(("effect", "status", "why"), rejected, words=(0, 1, 2)),))
    )
    blocks.append(Fold("Parameters of the last model", (parameter_values.table(document.steps[-1].parameters),)))
    return ReportSection("candidates", "Other effects", tuple(blocks))
