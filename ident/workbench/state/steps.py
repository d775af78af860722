"""The way through the page: choose recordings, fit, see where the model fails, add what is missing, save."""

from dataclasses import dataclass

from ident.workbench.state.session import WorkbenchSession


@dataclass(frozen=True)
class Step:
    """One step; its tab is where it is done."""

    tab: str
    label: str
    done: bool


def steps(session: WorkbenchSession) -> tuple[Step, ...]:
    """Return the steps in their order."""
    selection = session.selection
    step_list, residuals = selection.step_list, selection.analysis.residuals
    added = step_list is not None and any(name not in step_list.mandatory for name, _ in step_list.steps[-1].terms)
    seen = residuals is not None and "residuals" in session.display.visited
    return (
        Step("data", "Choose", session.recordings.train is not None),
        Step("model", "Fit", step_list is not None),
        Step("residuals", "Where", selection.within_noise or added or seen),
        Step("missing", "Add", selection.within_noise),
        Step("export", "Save", residuals is not None and session.export.saved_name(residuals.model) is not None),
    )
