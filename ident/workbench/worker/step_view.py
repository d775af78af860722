"""What the page shows of the steps of a search: label, errors, and whether the judge accepts the change."""

from collections.abc import Sequence

from ident.diagnosis.document import verdict
from ident.diagnosis.document.document import labels
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import judge
from ident.diagnosis.search.candidates import added_term
from ident.diagnosis.search.selection import SelectionStep
from ident.workbench.worker.views import StepView


def step_views(steps: Sequence[SelectionStep]) -> tuple[StepView, ...]:
    """Return the views of the steps of a search."""
    names = labels([[term.name for term in step.model.terms] for step in steps])
    before = (None, *(step.model for step in steps[:-1]))
    return tuple(map(step_view, names, steps, before))


def step_view(label: str, step: SelectionStep, before: FittedModel | None) -> StepView:
    """Return the view of the `step` from the model `before`, which is None for the first one."""
    model = step.model
    return StepView(
        label=label,
        entry=verdict.step_entry(step.added, model),
        terms=tuple((term.name, tuple(joint + 1 for joint in term.joints)) for term in model.terms),
        x=tuple(model.solution.x.tolist()),
        improvement=step.improvement,
        refusal=_refusal(before, step) if before else "",
    )


def _refusal(before: FittedModel, step: SelectionStep) -> str:
    """Why the judge does not accept what `step` adds to the model `before`; empty if it does, or nothing is added."""
    effect = added_term(before, step.model)
    if step.added is None or step.model.terms[effect].effect.mandatory:
        return ""
    return judge(before, step.model, effect).reason
