"""What a search has found: each effect with its evidence and its alternatives, and why the others are not there."""

from collections.abc import Iterator, Sequence

from ident.basics.threads import in_threads
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import Evidence, Rejection, judge
from ident.diagnosis.judge.price import is_preferred, is_significant, slack
from ident.diagnosis.judge.rules import OF_VALUES, objection
from ident.diagnosis.judge.rules.limits import extraordinary_joints
from ident.diagnosis.judge.rules.simpler import simpler_effect
from ident.diagnosis.search.candidates import Candidates, added_term
from ident.diagnosis.search.largest_gain import LargestGain
from ident.diagnosis.search.selection import WIDTH, Exclusion, Finding, Selection, SelectionStep

_EXCLUDED: dict[Exclusion, Rejection] = {
    "collinear": Rejection("not-tested", "This motion does not show it: other parameters reproduce its torque."),
    "sign": Rejection("refuted", "It would need an impossible sign.", Evidence(0.0, "screening")),
}


def review(
    candidates: Candidates,
    steps: Sequence[SelectionStep],
    reason: str = "that is worth less than its parameters",
    requested: bool = False,
) -> Selection:
    """The selection that ends with the last of `steps`.

    reason: why what the judge would accept is not added; requested: whether the user chose the effects, so that no
    interval allows for the choice.
    """
    model = steps[-1].model
    added = [*(term.name for term in steps[0].model.terms), *(step.added for step in steps)]
    in_order = sorted(range(len(model.terms)), key=lambda index: added.index(model.terms[index].name))
    all_findings = [_finding(candidates, model, index, requested) for index in in_order]
    # Every robot has a mandatory effect, but not every recording shows it: then it is in the steps alone.
    findings = tuple(
        each for each in all_findings if requested or each.judgement.accepted or not each.term.effect.mandatory
    )
    others = list(_extensions(candidates, model))
    likely = tuple(each for each in others if each.judgement.likely)
    judged = {each.term.name: each.judgement.rejection(reason) for each in others if not each.judgement.likely}
    bare = [step.model for step in steps if all(term.effect.mandatory for term in step.model.terms)]
    start = [steps[0].model, *bare][-1]  # the last one with nothing but what every robot has, if there is one
    first, last = (candidates.screen(each).reductions for each in (start, model))
    return Selection(tuple(steps), findings, likely, _screened_out(candidates, model) | judged, first, last)


def _extensions(candidates: Candidates, model: FittedModel) -> Iterator[Finding]:
    """What the judge says of each effect that `model` could have in addition."""
    for candidate in candidates.screen(model).best.values():
        if candidates.is_significant(model, candidate):
            extended = candidates.add(model, candidate)
            index = added_term(model, extended)
            yield Finding(extended.terms[index], model, extended, judge(model, extended, index))


def _finding(candidates: Candidates, model: FittedModel, index: int, requested: bool) -> Finding:
    """The contribution and the alternatives of the effect `index`."""
    term = model.terms[index]
    reduced = candidates.fits.without_effect(model, index)
    lines = sum(present.name == term.name for present in model.terms)  # one of a spectrum has no alternative
    rivals = [] if term.effect.mandatory or lines > 1 else _rivals(candidates, reduced, model, index)
    compared = 1 if requested else len(rivals) + 1
    judgement = judge(reduced, model, index, compared)
    names = [rival.terms[added_term(reduced, rival)].name for rival in _equivalent(reduced, model, index, rivals)]
    return Finding(term, reduced, model, judgement, tuple(names[:WIDTH]), compared)


def _rivals(candidates: Candidates, reduced: FittedModel, model: FittedModel, index: int) -> list[FittedModel]:
    """Extensions of `reduced` by other effects than that number `index` of `model`, which can be true."""
    return [
        rival
        for rival in candidates.extensions(reduced)
        if rival.terms[added := added_term(reduced, rival)].name != model.terms[index].name
        and objection(OF_VALUES, reduced, rival, added) is None
    ]


def _equivalent(
    reduced: FittedModel, model: FittedModel, index: int, rivals: Sequence[FittedModel]
) -> list[FittedModel]:
    """The `rivals` that these data cannot tell from `model`; none where one of them is much better.

    What is better, but seldom, is one of them: where not the data but its price decided, both are named.
    """
    likely = [rival for rival in rivals if not extraordinary_joints(rival, added_term(reduced, rival))]
    best = min(each.solution.loss for each in (model, *likely))
    reachable = best + slack(reduced.solution.loss, best, model.split.independent_rows)
    if model.solution.loss > reachable:
        return []
    return [
        rival
        for rival in rivals
        if rival.solution.loss <= reachable
        and not is_preferred(model, rival)
        and not _is_redundant(model, index, rival, added_term(reduced, rival))
    ]


def _is_redundant(model: FittedModel, index: int, rival: FittedModel, added: int) -> bool:
    """Whether the other effect only contains, or reduces to, the one that was found."""
    name, parameters = model.terms[index].name, max(len(rival.solution.x) - len(model.solution.x), 0)
    contained = name in rival.terms[added].effect.contains and not is_significant(
        model.solution.loss, rival.solution.loss, parameters, model.split.independent_rows
    )
    return contained or simpler_effect(rival, added) == name


def _screened_out(candidates: Candidates, model: FittedModel) -> dict[str, Rejection]:
    """Effects that screening alone rules out beside `model`: with the most that held-out rows could show of each."""
    screening = candidates.screen(model)
    rejected = {name: _EXCLUDED[exclusion] for name, exclusion in screening.excluded.items()}
    weak = [each for each in screening.best.values() if not candidates.is_significant(model, each)]
    for candidate, gain in zip(weak, in_threads(LargestGain(model).of, weak), strict=True):
        rejected[candidate.term.name] = Rejection(
            "not-confirmed",
            "The rows of the fit show hardly more of it than chance would. On held-out data it could explain at most "
            f"{gain:.1%} of what is left above the noise floor.",
            Evidence(gain, "screening"),
        )
    return rejected
