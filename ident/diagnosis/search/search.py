"""The search of a diagnosis: named effects first, curves for what they leave, and the steps that led there."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import chain, pairwise

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import judge
from ident.diagnosis.judge.price import score
from ident.diagnosis.search.best_first import BestFirst
from ident.diagnosis.search.candidates import Candidates, Fits, added_term
from ident.diagnosis.search.review import review
from ident.diagnosis.search.selection import Selection, SelectionStep
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure, Term
from recordings.errors import BadInput
from recordings.recording import Floats


class Search:
    """Searches the models of given data that the effects of a library can form."""

    def __init__(self, split: SplitData, library: Mapping[str, Effect], progress: Callable[[str], None]) -> None:
        self.fits, self._progress = Fits(split), progress
        self.candidates = Candidates(self.fits, library)

    def start(self, structure: ModelStructure, x: Floats) -> tuple[FittedModel, list[SelectionStep]]:
        """Fit the initial model from `x` (K,) and add the mandatory effects; returns the model and its steps."""
        model = self.fits.fit(structure, x)
        steps = [SelectionStep(None, model, None)]
        for name, effect in self.candidates.library.items():
            if effect.mandatory and name not in model.names:
                before, model = model, self.fits.with_term(model, Term.on_all_joints(name, effect, structure.rig))
                steps.append(_step(name, model, before))
        return model, steps

    def select(self, structure: ModelStructure, x: Floats) -> Selection:
        """Find what `structure`, fitted from `x` (K,), lacks."""
        model, steps = self.start(structure, x)
        best_first = BestFirst(self.candidates, self._progress)
        answer = best_first.search(model)
        while (with_curve := self._with_curve(answer)) is not None:
            further = best_first.search(with_curve)
            if score(further) >= score(answer):  # beside what else was found, the judge refuses the curve
                break
            answer = further
        return review(self.candidates, [*steps, *self._way(model, answer)])

    def select_forced(self, structure: ModelStructure, x: Floats, names: Sequence[str]) -> Selection:
        """Add the effects `names` in this order and no others, starting from `structure` and `x` (K,).

        Raises:
            BadInput: the motion does not show one of them.
        """
        model, steps = self.start(structure, x)
        for name in names:
            if not self.candidates.library[name].mandatory:  # these are there from the start
                before, model = model, self.add(model, name)
                steps.append(_step(name, model, before))
        return review(self.candidates, steps, "it was not requested", requested=True)

    def without(self, selection: Selection, name: str, reason: str) -> Selection:
        """The `selection` without the effect `name`; `reason`: why it is no finding."""
        library, answer = self.candidates.library, self._without(selection.model, {name})
        start = [step for step in selection.steps if step.added is None or library[step.added].mandatory]
        return review(self.candidates, [*start, *self._way(start[-1].model, answer)], reason)

    def add(self, model: FittedModel, name: str) -> FittedModel:
        """Add the effect `name` to `model` and refit all parameters.

        Raises:
            BadInput: the motion does not show it.
        """
        screening = self.candidates.screen(model)
        if name in screening.best:
            return self.candidates.add(model, screening.best[name])
        if screening.excluded.get(name) == "sign":  # the best that its limits allow is none of it
            term = Term.on_all_joints(name, self.candidates.library[name], model.solution.structure.rig)
            return self.candidates.zero(model, term)
        reason = "is in the model already" if name in model.names else "does not show in this motion"
        raise BadInput(
            f"effect: one of {', '.join(sorted(screening.best))} expected; '{name}' {reason}; leave it out"
        )

    def _with_curve(self, model: FittedModel) -> FittedModel | None:
        """`model` with a curve in addition, or in place of the effects that it contains, if the judge accepts it."""
        tried = chain(((model, each) for each in self.candidates.curves(model)), self._exchanged(model))
        accepted = [
            curved
            for before, curved in tried
            if score(curved) < score(model) and judge(before, curved, added_term(model, curved)).accepted
        ]
        return min(accepted, key=score, default=None)

    def _exchanged(self, model: FittedModel) -> Iterator[tuple[FittedModel, FittedModel]]:
        """`model` with a curve in place of the effects that it contains, and of one other that helps to imitate it.

        With each comes the model before it: that with the best of the effects that it replaces alone.
        """
        for name, effect in self.candidates.library.items():
            contained = model.names & set(effect.contains)
            others = [{term.name} for term in model.terms if not term.effect.mandatory and term.name not in contained]
            for replaced in [contained, *map(contained.union, others)] if effect.curve and contained else []:
                bare = self._without(model, replaced)
                if (candidate := self.candidates.named(bare, name)) is not None:
                    alone = (self._without(model, replaced - {each}) for each in replaced)
                    yield min(alone, key=score), self._in_place(model, bare, self.candidates.add(bare, candidate))

    def _in_place(self, model: FittedModel, bare: FittedModel, curved: FittedModel) -> FittedModel:
        """`curved` with its curve on all joints of the effects of `model` that it contains."""
        curve = curved.terms[index := added_term(bare, curved)]
        joints = {joint for term in model.terms if term.name in curve.effect.contains for joint in term.joints}
        return self.fits.on_joints(curved, index, sorted(joints.union(curve.joints)))

    def _without(self, model: FittedModel, names: Collection[str]) -> FittedModel:
        while (index := next((i for i, term in enumerate(model.terms) if term.name in names), None)) is not None:
            model = self.fits.without_effect(model, index)
        return model

    def _way(self, start: FittedModel, answer: FittedModel) -> list[SelectionStep]:
        """Steps from `start` to `answer`: the effect that the rest misses least came last."""
        models = [answer]
        while extra := [i for i, term in enumerate(models[-1].terms) if term.name not in start.names]:
            models.append(min((self.fits.without_effect(models[-1], index) for index in extra), key=score))
        return [
            _step(after.terms[added_term(before, after)].name, after, before)
            for before, after in pairwise(reversed(models))
        ]


def _step(added: str, model: FittedModel, before: FittedModel) -> SelectionStep:
    return SelectionStep(added, model, model.improvement_over(before))
