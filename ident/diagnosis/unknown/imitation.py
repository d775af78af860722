"""Check whether something unknown explains the data in place of the effects that imitate it.

Several known effects together approximate one that is in no library, and held-out rows confirm each of them. What
they leave shows what the unknown one depends on. Beside curves over that, a true effect still explains what no curve
does; an imitation explains nothing more. What the judge refuses beside the rest goes first.
"""

from collections.abc import Sequence

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE
from ident.diagnosis.judge.price import likelihood_score
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Finding, Selection
from ident.diagnosis.split.split_data import TINY
from ident.diagnosis.unknown.residual_dependence import NonparametricFit, fit_curves
from ident.diagnosis.unknown.residual_test import UnexplainedResidual, estimate_unexplained


def analyse_unexplained(
    search: Search, selection: Selection, forced: bool
) -> tuple[Selection, UnexplainedResidual, NonparametricFit | None]:
    """The `selection` without imitations, its unexplained residual, and curves in place of what is unknown.

    forced: whether the user chose the effects, which then stay, as those of a given model do.
    """
    given = selection.steps[0].model.names
    while True:
        in_question = [
            each for each in selection.findings if not (each.term.effect.mandatory or each.term.name in given)
        ]
        # What the judge does not accept beside the others: an effect that it needed is gone.
        refused = [each.term.name for each in in_question if not each.judgement.accepted]
        if refused and not forced:
            selection = search.without(selection, refused[0], "held-out rows do not confirm it beside the others")
            continue
        unexplained = estimate_unexplained(model := selection.model.on_judged_rows)
        if not (unexplained.significant and unexplained.dependences):
            return selection, unexplained, None
        learned = fit_curves(model, unexplained.dependences)
        variables = list(dict.fromkeys(name for each in learned.dependences for name in each.variables))
        doubtful = [each for each in in_question if not (forced or _is_over(each, variables))]
        imitation = _imitation(doubtful, learned.model)
        if imitation is None:
            return selection, unexplained, learned
        selection = search.without(
            selection, imitation, f"curves over {', '.join(variables)} leave nothing of it to explain"
        )


def _is_over(finding: Finding, variables: Sequence[str]) -> bool:
    """Whether the effect is itself a curve over the `variables`: what repeats it does not refute it."""
    return finding.term.effect.curve and {*variables} <= {finding.term.effect.axis, "direction"}


def _imitation(findings: Sequence[Finding], curves: FittedModel) -> str | None:
    """The effect of which most is gone beside `curves`, if they explain almost all of what it does without.

    In its place, they have to be the better model at their price: a curve approximates a part of every effect.
    """
    in_place = [_without(curves, finding.term.name) for finding in findings]
    left = {
        finding.term.name: curves.improvement_over(without).reduction / max(finding.improvement.reduction, TINY)
        for finding, without in zip(findings, in_place, strict=True)
        if _is_better(without, finding.after)
    }
    name = min(left, key=lambda each: left[each], default=None)
    return name if name and left[name] < MIN_SHARE else None


def _is_better(curves: FittedModel, model: FittedModel) -> bool:
    """Whether `curves` leave less than a `model` at their price, in the rows that curves can be judged by.

    Neither their size matters, as other parameters balance what curves share with them, nor their noise floor, which
    steep curves raise.
    """
    known, floor = curves.on_judged_rows, model.noise_floor.certain
    return likelihood_score(known, floor) < likelihood_score(FittedModel(known.split, model.solution), floor)


def _without(model: FittedModel, name: str) -> FittedModel:
    """Refit `model` without the effect `name`; not kept, as curves over different variables have one name."""
    structure, x = model.solution.structure, model.solution.x
    for index in reversed([i for i, term in enumerate(model.terms) if term.name == name]):
        x, structure = x[~structure.parameter_mask(index)], structure.without_term(index)
    return FittedModel(model.split, model.split.fit(structure, x))
