"""Models of one set of recordings, each fitted once, and the effects of a library that may extend them.

The library is screened by linear algebra, and what promises enough is fitted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ident.basics.threads import in_threads
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.paying_joints import paying_joints
from ident.diagnosis.judge.price import is_significant
from ident.diagnosis.judge.rules.limits import plausible_joints
from ident.diagnosis.judge.rules.mechanism import driven_joints
from ident.diagnosis.search.screening import Candidate, ColumnsKey, Screener, Screening
from ident.diagnosis.search.selection import WIDTH
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.shape_parameters import guess_scales, suggestions
from recordings.recording import Floats

MIN_PROMISE = 0.8
"""Further candidates are fitted if screening promises this share of the best reduction: optimizing their shapes
hardly adds more (97 effects of the part `chosen`: 0.8 to 1.2 times what was promised)."""
Key = tuple[tuple[str, tuple[int, ...], tuple[str, ...]], ...]
"""The effects of a model, each with its joints, in any order; the lines of a spectrum also with their shapes."""


def key_of(structure: ModelStructure, x: Floats) -> Key:
    """Identify a model with the parameters `x` (K,) by its effects."""
    lines = [
        tuple(f"{value:.3g}" for value in structure.shape_values(index, x)) if term.effect.repeated else ()
        for index, term in enumerate(structure.terms)
    ]
    return tuple(sorted((term.name, term.joints, line) for term, line in zip(structure.terms, lines, strict=True)))


class Fits:
    """Fits models, and keeps the best fit of each."""

    def __init__(self, split: SplitData) -> None:
        self.split = split
        self._best: dict[Key, FittedModel] = {}

    def best(self, model: FittedModel) -> FittedModel:
        """The best fit so far of the effects of `model`, which counts from now on."""
        key = key_of(model.solution.structure, model.solution.x)
        self._best[key] = min(self._best.get(key, model), model, key=lambda each: each.solution.loss)
        return self._best[key]

    def at(self, structure: ModelStructure, x: Floats) -> FittedModel:
        """The model of `structure` with the very parameters `x` (K,), which counts as a fit from now on."""
        known = self._best.get(key_of(structure, x))
        if known is not None and np.array_equal(known.solution.x, x):
            return known
        model = FittedModel(self.split, self.split.at(structure, x))
        self.best(model)
        return model

    def fit(self, structure: ModelStructure, x: Floats) -> FittedModel:
        """Fit `structure` starting from `x` (K,), or return the best known fit if it leaves no more than x."""
        known = self._best.get(key_of(structure, x))
        if known is not None and not structure.searched.any():
            return known
        start = self.split.fit_linear(structure, x)
        if known is not None and known.solution.loss <= start.loss:
            return known
        return self.best(FittedModel(self.split, self.split.fit_nonlinear(start)))

    def with_term(self, model: FittedModel, term: Term) -> FittedModel:
        """`model` with a `term` whose values start at 0."""
        structure, x = model.solution.structure.with_term(term), model.solution.x
        return self.fit(structure, np.concatenate([x, np.zeros(len(structure.parameters) - len(x))]))

    def without_effect(self, model: FittedModel, index: int) -> FittedModel:
        """Refit `model` without its effect number `index`."""
        structure = model.solution.structure
        return self.fit(structure.without_term(index), model.solution.x[~structure.parameter_mask(index)])

    def on_joints(self, model: FittedModel, index: int, joints: Sequence[int]) -> FittedModel:
        """The effect number `index` of `model` on `joints` instead.

        A joint that it did not act on starts from the mean of the others as multiples of their initial guesses, and
        from the opposite where it acts on none of the former ones: two lighter arms are one heavier arm.
        """
        structure, x, term = model.solution.structure, model.solution.x, model.terms[index]
        local, entries = structure.local_values(index, x), np.flatnonzero(structure.parameter_mask(index))
        kept, moved = dict(zip(term.joints, local, strict=True)), replace(term, joints=tuple(joints))
        former, scales = (
            guess_scales(each, self.split.train_predictors[0], model.solution) for each in (term, moved)
        )
        mean = (local / former).mean(axis=0) * (1 if kept.keys() & set(joints) else -1)
        values = np.concatenate([kept.get(joint, mean * scale) for joint, scale in zip(joints, scales, strict=True)])
        shapes = structure.shape_values(index, x)
        if term.effect.local_shapes:
            suggested = suggestions(
                term.effect, self.split.train_predictors, model.solution, model.solution.residuals
            )
            shapes = moved.shape_guesses(suggested)[0]
        terms = (*structure.terms[:index], moved, *structure.terms[index + 1 :])
        start = np.concatenate([x[: entries[0]], values, shapes, x[entries[-1] + 1 :]])
        fitted = self.fit(replace(structure, terms=terms), start)
        if kept.keys() < {*joints} and fitted.solution.loss > model.solution.loss:
            # What contains a model leaves no more than it: this fit is stuck, as at a resonance that is not there.
            start[entries[0] :][: values.size] = np.concatenate([kept.get(joint, 0 * mean) for joint in joints])
            return self.fit(replace(structure, terms=terms), start)
        return fitted

    def on_paying_joints(self, before: FittedModel, after: FittedModel, index: int) -> FittedModel:
        """`after` with its effect number `index`, which `before` lacks, where it pays; `after` if it pays nowhere."""
        moved = after
        while (joints := paying_joints(before, moved, index)) != moved.terms[index].joints:
            if not joints:
                return after
            moved = self.on_joints(moved, index, joints)
        return moved


def added_term(before: FittedModel, after: FittedModel) -> int:
    """Number of the effect that `after` has in addition to, or on other joints than, the model `before`."""
    present = [(term.name, term.joints) for term in before.terms]
    for index, term in enumerate(after.terms):
        if (term.name, term.joints) not in present:
            return index
        present.remove((term.name, term.joints))
    return len(after.terms) - 1


class Candidates:
    """Extends models by effects of a library."""

    def __init__(self, fits: Fits, library: Mapping[str, Effect]) -> None:
        self.fits, self.library, self.split = fits, library, fits.split
        self._screened: dict[Key, Screening] = {}
        self._added: dict[tuple[Key, Candidate], FittedModel] = {}
        self._columns: dict[ColumnsKey, tuple[Floats, ...]] = {}

    def screen(self, model: FittedModel) -> Screening:
        """Screen the library for effects that could be added to `model`; done once."""
        key = key_of(model.solution.structure, model.solution.x)
        if key not in self._screened:
            library = {
                name: effect for name, effect in self.library.items() if name not in model.names or effect.repeated
            }
            self._screened[key] = Screener(self.split, model.solution, self._columns).screen(library)
        return self._screened[key]

    def extensions(self, model: FittedModel) -> list[FittedModel]:
        """`model` with each of the effects that promise most and show more than chance would, refitted.

        The best comes first.
        """
        models, before = list[FittedModel](), model.solution.loss
        for candidate in self.screen(model).candidates:
            if candidate.term.effect.curve or not self.is_significant(model, candidate):
                continue
            best = before - min((each.solution.loss for each in models), default=before)
            if before - candidate.loss >= MIN_PROMISE * best or len(models) < WIDTH:
                models.append(self.add(model, candidate))
        return sorted(models, key=lambda extended: extended.solution.loss)

    def curves(self, model: FittedModel) -> list[FittedModel]:
        """`model` with each curve of the library that shows, refitted."""
        return [
            self.add(model, each)
            for each in self.screen(model).candidates
            if each.term.effect.curve and self.is_significant(model, each)
        ]

    def named(self, model: FittedModel, name: str) -> Candidate | None:
        """The effect `name` as screening finds it beside `model`; None where that shows nothing of it."""
        return Screener(self.split, model.solution, self._columns).screen({name: self.library[name]}).best.get(name)

    def add(self, model: FittedModel, candidate: Candidate) -> FittedModel:
        """Add the `candidate` to `model` and refit all parameters; done once."""
        key = key_of(model.solution.structure, model.solution.x), candidate
        if key not in self._added:
            fitted = (self._best_fit(model, each) for each in (candidate, *candidate.elsewhere))
            best = min(fitted, key=lambda each: each.solution.loss)
            best = self.fits.best(self._on_possible_joints(best))
            # A fit that was known may have its effects in another order.
            self._added[key] = self.fits.on_paying_joints(model, best, added_term(model, best))
        return self._added[key]

    def is_significant(self, model: FittedModel, candidate: Candidate) -> bool:
        """Whether the `candidate` promises more of the loss of `model` than its parameters are worth."""
        return is_significant(
            model.solution.loss, candidate.loss, candidate.parameter_count, self.split.independent_rows
        )

    def _best_fit(self, model: FittedModel, candidate: Candidate) -> FittedModel:
        """Fit `model` with the `candidate` from its best initial guess, or from several if its shapes need it."""
        structure = model.solution.structure.with_term(candidate.term)
        starts = in_threads(
            lambda guess: self.split.fit_linear(structure, np.concatenate([model.solution.x, guess])),
            candidate.initial_guesses,
        )
        promising = sorted(starts, key=lambda start: start.loss)[: candidate.term.effect.multistart]
        best = min(map(self.split.fit_nonlinear, promising), key=lambda solution: solution.loss)
        if best.loss < model.solution.loss:
            return FittedModel(self.split, self.split.escape_local_minima(best))
        return self.zero(model, candidate.term, candidate.shapes)

    def zero(self, model: FittedModel, term: Term, shapes: Floats | None = None) -> FittedModel:
        """`model` with a `term` of no strength, where nothing of it leaves less."""
        structure = model.solution.structure.with_term(term)
        guesses = [shape.initial_guesses[0] if shape.initial_guesses else shape.upper for shape in term.shapes]
        values = np.zeros(term.instances * len(term.local_parameters)), guesses if shapes is None else shapes
        return FittedModel(self.split, self.split.at(structure, np.concatenate([model.solution.x, *values])))

    def _on_possible_joints(self, model: FittedModel) -> FittedModel:
        """`model` without the joints on which the last effect is not plausible, or friction beside it is not."""
        index, term = len(model.terms) - 1, model.terms[-1]
        driven = driven_joints(model, index)
        joints = tuple(joint for joint in plausible_joints(model, index) if joint not in driven)
        if term.effect.whole_robot or joints in ((), term.joints):
            return model
        return self.fits.on_joints(model, index, joints)
