"""Stepwise selection: add the effect that explains most, refit all parameters, and repeat until nothing is left."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.confirmation import MIN_T
from ident.diagnosis.judge.physical_limits import flipped_parameter, is_physical, simpler_effect
from ident.diagnosis.judge.steps import Extensions, Finding, FittedModel, Selection, SelectionStep
from ident.diagnosis.search.acceptance import MAX_ALTERNATIVE_RATIO, Acceptance
from ident.diagnosis.search.candidate_search import CandidateSearch, effect_key
from ident.diagnosis.search.repeated_search import has_shapes, searched_again
from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure, Term
from recordings.errors import BadInput
from recordings.recording import Floats

MAX_EFFECTS = 16
"""Maximum number of effects."""
MAX_ROUNDS = 3
"""Maximum number of times that the selected effects are reviewed."""
MAX_FLOOR_RATIO = 1.1
"""Joints with an error above this multiple of the noise floor may need effects of other joints."""


class Selector:
    """Selects effects of a library for given data."""

    def __init__(self, split: SplitData, library: Mapping[str, Effect], progress: Callable[[str], None]) -> None:
        self._split, self._library, self._progress = split, library, progress
        self.search = CandidateSearch(split, library)
        self._acceptance = Acceptance(split, self.search)

    def select(self, structure: ModelStructure, x: Floats) -> Selection:
        """Select effects step by step, starting from `structure` with the parameters `x` (K,)."""
        model, steps = self.start(structure, x)
        extensions = self.search.extensions(model)
        selection = self._select_from(model, list(steps), extensions)
        final = selection.model
        if not self._acceptance.leaves_much(final):
            return selection
        extension = self._alternative_start(model, extensions, final)
        starts = [extension] if extension else self._pair_start(model, final)
        if not starts:
            return selection
        for start in starts:
            _append(steps, start.terms[-1].name, start)
        alternative = self._select_from(steps[-1].model, steps, extensions)
        return alternative if self._acceptance.is_far_better(alternative.steps[-1].model, final) else selection

    def _select_from(self, model: FittedModel, steps: list[SelectionStep], first_extensions: Extensions) -> Selection:
        """Continue the selection from `model`, the last of `steps`, until no step improves it."""
        reviewed_keys = set()
        for last in (False,) * (MAX_ROUNDS - 1) + (True,):
            model, extensions = self._add_effects(model, steps)
            reviews = [self._review_effect(model, index) for index in range(len(model.terms))]
            better = next((other for _, other in reviews if other is not model and not _is_worse(other, model)), None)
            reviewed_keys.add(effect_key(model))
            if better is None or last:
                break
            pruned = self._pruned(better)
            # Two models that each look better beside the other: the one with the smaller test error stays.
            if effect_key(pruned) in reviewed_keys and pruned.improvement_over(model).reduction <= 0:
                break
            model = pruned
            _append(steps, better.terms[-1].name, model)
        findings = tuple(finding for finding, _ in reviews)
        return Selection(tuple(steps), findings, first_extensions, extensions, self._acceptance.claims.refused)

    def _alternative_start(
        self, model: FittedModel, extensions: Extensions, final: FittedModel
    ) -> FittedModel | None:
        """Another first effect after `model`, if the selection that ended at `final` leaves a large excess error.

        The best single effect may imitate two effects together, and neither of them improves the model beside it.
        Therefore the second step decides which first step was right.
        """
        self._progress("large residual error; trying another first effect")
        selected, alternatives = final.names, []
        for extension in extensions.models:
            if (
                extension.terms[-1].name in selected
                or not is_physical(extension, model)
                or not self._acceptance.is_promising(model, extension)
            ):
                continue
            second = self._acceptance.first_confirmed(extension, self._searched_extensions(extension))
            if second is not None and self._is_worth_both(model, final, second):
                alternatives.append((second.solution.loss, extension))
        return min(alternatives, key=lambda entry: entry[0])[1] if alternatives else None

    def _pair_start(self, model: FittedModel, final: FittedModel) -> list[FittedModel]:
        """`model` with one and with both of two effects that show only together; empty if no pair is confirmed."""
        self._progress("large residual error; trying pairs of effects")
        worth = []
        for pair in self.search.pairs(model, MAX_ALTERNATIVE_RATIO * final.solution.loss):
            if not self._is_worth_both(model, final, pair):
                continue
            first, second = (self.search.without_effect(pair, len(pair.terms) - number) for number in (1, 2))
            turned = self.search.moved_to_end(pair, len(pair.terms) - 2)
            if all(
                is_physical(both, single) and self._acceptance.is_confirmed(single, both)
                for both, single in ((pair, first), (turned, second))
            ):
                worth.append([first, pair])
        return min(worth, key=lambda models: models[1].solution.loss, default=[])

    def start(self, structure: ModelStructure, x: Floats) -> tuple[FittedModel, list[SelectionStep]]:
        """Fit the initial model from `x` (K,) and add the mandatory effects; returns the model and its steps."""
        base = self.search.fit(structure, x)
        steps = [SelectionStep(None, base, None)]
        return self.with_mandatory_effects(base, steps), steps

    def select_forced(self, structure: ModelStructure, x: Floats, names: Sequence[str]) -> Selection:
        """Add the effects `names` in this order and no others, starting from `structure` and `x` (K,).

        Raises:
            BadInput: the motion does not show one of them.
        """
        model, steps = self.start(structure, x)
        for name in names:
            candidates, excluded, _ = self.search.screen(model)
            by_name = {candidate.term.name: candidate for candidate in reversed(candidates)}
            if name not in by_name:
                present = name in model.names
                reason = "is in the model already" if present else "does not show in this motion"
                reason = "would need an impossible sign" if excluded.get(name) == "sign" else reason
                raise BadInput(
                    f"effect: one of {', '.join(sorted(by_name))} expected; '{name}' {reason}; leave it out"
                )
            model = self.search.add(model, by_name[name])
            _append(steps, name, model)
        extensions = Extensions((), *self.search.screen(model)[1:])
        findings = tuple(self._review_effect(model, index)[0] for index in range(len(model.terms)))
        return Selection(tuple(steps), findings, extensions, extensions)

    def or_earlier(self, selection: Selection, earlier: Selection) -> Selection:
        """`selection`, or an `earlier` one, chosen when other rows were scored, if that is far better on these."""
        if not self._acceptance.leaves_much(selection.model):
            return selection
        models = [FittedModel(self._split, step.model.solution) for step in earlier.steps]  # fitted to the same rows
        final = models[-1]
        if not self._acceptance.is_far_better(final, selection.model):
            return selection
        if effect_key(self._pruned(final)) != effect_key(final):
            return selection
        steps: list[SelectionStep] = []
        for step, model in zip(earlier.steps, models, strict=True):
            _append(steps, step.added, model)
        return self.truncated(replace(earlier, steps=tuple(steps)), len(steps) - 1)

    def truncated(self, selection: Selection, number: int) -> Selection:
        """The `selection` up to step `number`."""
        model = selection.steps[number].model
        findings = tuple(self._review_effect(model, index)[0] for index in range(len(model.terms)))
        extensions = self.search.extensions(model)
        steps = selection.steps[: number + 1]
        return Selection(steps, findings, selection.first_extensions, extensions, self._acceptance.claims.refused)

    def _add_effects(self, model: FittedModel, steps: list[SelectionStep]) -> tuple[FittedModel, Extensions]:
        """Add effects until no extension is accepted; returns the model and its remaining extensions."""
        visited = {effect_key(model)}
        while True:
            extensions = self.search.extensions(model)
            extension = self._next_model(model, extensions.models) if len(model.terms) < MAX_EFFECTS else None
            if extension is None:
                return model, extensions
            added = self._pruned(searched_again(self.search, extension))
            again = effect_key(added) in visited
            # Where two models lead to each other, what one of them does without is not needed.
            if again and len(added.terms) >= len(model.terms):
                return model, extensions
            model = added
            _append(steps, extension.terms[-1].name, model)
            if again:
                return model, self.search.extensions(model)
            visited.add(effect_key(model))
            self._progress(f"{steps[-1].added} added; searching for more")

    def with_mandatory_effects(self, model: FittedModel, steps: list[SelectionStep]) -> FittedModel:
        """Add the mandatory effects, whatever their coefficients: other effects may still bias these.

        steps: those that the test rows confirm are appended.
        """
        present = [term.name for term in model.terms]
        for name, effect in self._library.items():
            if not effect.mandatory or name in present:
                continue
            structure = model.solution.structure
            structure = structure.with_term(Term.on_all_joints(name, effect, structure.rig))
            zeros = np.zeros(len(structure.parameters) - len(model.solution.x))
            extended = self.search.fit(structure, np.concatenate([model.solution.x, zeros]))
            if self._acceptance.is_confirmed(model, extended):
                steps.append(SelectionStep(name, extended, extended.improvement_over(model)))
            model = extended
        return model

    def _next_model(self, model: FittedModel, candidates: Sequence[FittedModel]) -> FittedModel | None:
        """The next extension. The best one may not be supported before a smaller effect is included."""
        train_rms, floor = rms(model.residuals, self._split.train), model.noise_floor.rms
        # A correct model reaches the noise floor. A lower error means that quantization errors are fitted.
        if model.noise_floor.known and (self._acceptance.excess(model) <= 0 or (train_rms <= floor).all()):
            return None
        largest_rms = np.maximum(train_rms, rms(model.residuals, self._split.test))
        joints = np.flatnonzero(largest_rms > MAX_FLOOR_RATIO * floor)
        candidates = [*candidates, *self.search.joint_extensions(model, joints.tolist())]
        extension = self._acceptance.first_confirmed(model, candidates)
        return (
            extension
            or (
                self._acceptance.first_confirmed(model, self.search.skipped_extensions(model)) if candidates else None
            )
            or self._widened(model, joints.tolist())
            or self._beside_wrong_shapes(model)
        )

    def _beside_wrong_shapes(self, model: FittedModel) -> FittedModel | None:
        """The best extension if the effects of `model` have shapes that imitate it, and much is left."""
        if not self._acceptance.leaves_much(model) or not has_shapes(model):
            return None
        return self._acceptance.first_confirmed(model, self._searched_extensions(model))

    def _searched_extensions(self, model: FittedModel) -> list[FittedModel]:
        """The extensions of `model`, each with the shapes of all effects searched beside it."""
        return [searched_again(self.search, extension) for extension in self.search.extensions(model).models]

    def _widened(self, model: FittedModel, joints: Sequence[int]) -> FittedModel | None:
        """The best extension after an effect of `model` acts on more of the `joints`, if both leave far less error.

        On a joint with two effects, neither may show without the other, although other joints have shown one of them.
        """
        if not self._acceptance.leaves_much(model):
            return None
        acceptance = self._acceptance
        promising = (
            wider
            for wider in self.search.joint_extensions(model, joints)
            if acceptance.may_be_far_better(wider, model)
        )
        pairs = (acceptance.first_confirmed(wider, self.search.extensions(wider).models) for wider in promising)
        better = [pair for pair in pairs if pair is not None and self._is_worth_both(model, model, pair)]
        return min(better, key=lambda pair: pair.solution.loss, default=None)

    def _pruned(self, model: FittedModel) -> FittedModel:
        """Remove effects, and joints of effects, that later ones made unnecessary or impossible; the last first."""
        for index in range(len(model.terms) - 1, -1, -1):
            if model.terms[index].effect.mandatory:
                continue
            reduced = self.search.without_effect(model, index)
            if (
                not self._acceptance.claims.keeps_shape(model, index)
                or flipped_parameter(model, reduced)
                or not self._acceptance.is_confirmed(reduced, model)
            ):
                return self._pruned(reduced)
        claims = self._acceptance.claims
        model = self._acceptance.without_minor_joints(claims.without_zero_joints(claims.all_simplified(model)))
        return claims.on_fewest_joints(model)

    def _is_worth_both(self, model: FittedModel, reference: FittedModel, pair: FittedModel) -> bool:
        """Whether `pair`, two effects more than `model`, is confirmed and leaves far less than the `reference`."""
        return self._acceptance.is_far_better(pair, reference) and self._acceptance.is_confirmed(model, pair)

    def _review_effect(self, model: FittedModel, index: int) -> tuple[Finding, FittedModel]:
        """The contribution and the alternatives of the effect `index`; and the best of all these models."""
        reduced = self.search.without_effect(model, index)
        term = model.terms[index]
        compared = self._acceptance.compared.get(term.name, 1)
        improvement = model.improvement_over(reduced, compared=compared)
        lines = sum(present.name == term.name for present in model.terms)
        if term.effect.mandatory or lines > 1:  # a single line of a spectrum has no alternative
            return Finding(term, improvement, (), reduced.residuals, model.residuals, compared), model
        alternatives = self.search.alternatives(term.name, reduced)
        candidates = [candidate for candidate in alternatives if is_physical(candidate, reduced)]
        equivalent = self._acceptance.equivalent(reduced.solution.loss, [model, *candidates])
        best = self._acceptance.simplest(reduced, [model, *candidates])
        if best is not model:
            accepted = self._acceptance.accepted(reduced, best)
            best = accepted if accepted is not None and not self._acceptance.is_minor(reduced, accepted) else model
        if effect_key(best) == effect_key(model):
            best = model
        names = [
            candidate.terms[-1].name
            for candidate in equivalent
            if candidate is not model
            and not self._acceptance.is_preferred(candidate, model)
            and not self.search.is_redundant(term.name, model, candidate)
            and simpler_effect(candidate) != term.name
        ]
        names = (
            names if any(candidate is model for candidate in equivalent) else []
        )  # a much better effect is no alternative
        return Finding(term, improvement, tuple(names[:3]), reduced.residuals, model.residuals, compared), best


def _append(steps: list[SelectionStep], added: str | None, model: FittedModel) -> None:
    """Append a step to the `model`, judged against the last of the `steps`, if any."""
    steps.append(SelectionStep(added, model, model.improvement_over(steps[-1].model) if steps else None))


def _is_worse(model: FittedModel, other: FittedModel) -> bool:
    """Whether the test rows clearly prefer the `other` model."""
    return model.improvement_over(other).t_statistic < -MIN_T
