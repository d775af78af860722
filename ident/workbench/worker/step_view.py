"""What the page shows of the steps of a search: label, errors, and whether the judge accepts the change."""

from collections.abc import Sequence
from dataclasses import replace

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
        refusal=refusal(before, model) if before and step.added else "",
    )


def on_rows_of(last: FittedModel, steps: Sequence[StepView], models: Sequence[FittedModel]) -> tuple[StepView, ...]:
    """Return the views of the steps to the `models` with the errors on the rows that the `last` one can be judged by.

    So all errors of one table can be compared, as in the document of a diagnosis.
    """
    split = last.on_judged_rows.split
    entries = (verdict.on_rows(split, step.entry, model) for step, model in zip(steps, models, strict=True))
    return tuple(replace(step, entry=entry) for step, entry in zip(steps, entries, strict=True))


def refusal(before: FittedModel, after: FittedModel) -> str:
    """Return why the judge does not accept the effect that `after` adds to `before`; empty if it does."""
    effect = added_term(before, after)
    return "" if after.terms[effect].effect.mandatory else judge(before, after, effect).reason
