"""How the error fell, effect by effect."""

from ident.output.figures import ladder
from ident.output.report.blocks import ReportBlock, Fold, Plot, ReportSection, ReportTable
from ident.output.report.contents import ReportContents
from ident.output.report.sections import parameter_values


def section(material: ReportContents) -> ReportSection | None:
    """The ladder, the model at its top, and what was not added; None where nobody asked."""
    found, document = material.diagnosis, material.document
    if found is None or document is None:
        return None
    caption = (
        f"Error of each model on the rows it was fitted to, and on rows held out ({document.held_out}). A bar that "
        "falls in training only is overfitting. The dashed line is what a right model reaches."
    )
    blocks: list[ReportBlock] = [Plot("ladder", ladder.ladder(document), caption)]
    if found.selection.first_extensions.loss_reductions or found.selection.last_extensions.loss_reductions:
        promised = "What each effect would explain at first sight; in bold what was added in the end."
        blocks.append(Plot("candidates", ladder.candidates(found), promised))
    rejected = tuple((one.effect, one.status, one.why) for one in document.rejected)
    blocks.append(
        Fold("Effects that were not added", (ReportTable(("effect", "status", "why"), rejected, words=(0, 1, 2)),))
    )
    blocks.append(Fold("Parameters of the model at the top", (parameter_values.table(document.rungs[-1].parameters),)))
    return ReportSection("ladder", "The ladder", tuple(blocks))
