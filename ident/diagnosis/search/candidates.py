"""Effects that may extend a model: the library is screened by linear algebra, and what promises enough is fitted."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ident.basics.threads import in_threads
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.price import is_significant
from ident.diagnosis.judge.rules.limits import plausible_instances
from ident.diagnosis.search.fits import Fits, Key, key_of
from ident.diagnosis.search.screening import Candidate, ColumnsKey, Screener
from ident.diagnosis.search.selection import Exclusion
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Term
from recordings.recording import Floats

WIDTH = 3
"""Number of models that stay open, of candidates that are fitted in any case, and of alternatives that are named: one
that imitates another, the other, and a third that contains it."""
MIN_PROMISE = 0.8
"""Further candidates are fitted if screening promises this share of the best reduction: optimizing their shapes
hardly adds more (97 effects of the part `chosen`: 0.8 to 1.2 times what was promised)."""


@dataclass(frozen=True, eq=False)
class Screening:
    """What the library could add to one model."""

    candidates: tuple[Candidate, ...]
    """The most promising first."""
    excluded: Mapping[str, Exclusion]
    """Effects that cannot be added, with the reason."""
    loss: float
    """Of the model."""

    @cached_property
    def best(self) -> dict[str, Candidate]:
        """The most promising candidate of each effect."""
        return {candidate.term.name: candidate for candidate in reversed(self.candidates)}

    @property
    def reductions(self) -> dict[str, float]:
        """Relative reduction of the loss that each effect promises."""
        return {name: 1 - candidate.loss / self.loss for name, candidate in self.best.items()}


class Candidates:
    """Extends models by effects of a library."""

    def __init__(self, fits: Fits, library: Mapping[str, Effect]) -> None:
        self.fits, self.library, self.split = fits, library, fits.split
        self._screened: dict[Key, Screening] = {}
        self._added: dict[tuple[Key, Candidate], FittedModel] = {}
        self._columns: dict[ColumnsKey, tuple[Floats, ...]] = {}

    def screen(self, model: FittedModel) -> Screening:
        """Screen the library for effects that could be added to `model`; done once."""
        key = key_of(model.solution.structure)
        if key not in self._screened:
            present = model.names
            library = {
                name: effect for name, effect in self.library.items() if name not in present or effect.repeated
            }
            candidates, excluded = Screener(self.split, model.solution, self._columns).screen(library)
            self._screened[key] = Screening(tuple(candidates), excluded, model.solution.loss)
        return self._screened[key]

    def extensions(self, model: FittedModel) -> list[FittedModel]:
        """`model` with each of the effects that promise most and show more than chance would, refitted.

        The best comes first.
        """
        models: list[FittedModel] = []
        before = model.solution.loss
        for candidate in self.screen(model).candidates:
            if candidate.term.effect.curve or not self.is_significant(model, candidate):
                continue
            best = before - min((each.solution.loss for each in models), default=before)
            if before - candidate.loss >= MIN_PROMISE * best or len(models) < WIDTH:
                models.append(self.add(model, candidate))
        return sorted(models, key=lambda extended: extended.solution.loss)

    def curves(self, model: FittedModel) -> list[FittedModel]:
        """`model` with each curve of the library that shows, refitted."""
        candidates = [each for each in self.screen(model).candidates if each.term.effect.curve]
        return [self.add(model, each) for each in candidates if self.is_significant(model, each)]

    def named(self, model: FittedModel, name: str) -> Candidate | None:
        """The effect `name` as screening finds it beside `model`; None where that shows nothing of it."""
        candidates = Screener(self.split, model.solution, self._columns).screen({name: self.library[name]})[0]
        return candidates[0] if candidates else None

    def add(self, model: FittedModel, candidate: Candidate) -> FittedModel:
        """Add the `candidate` to `model` and refit all parameters; done once."""
        key = key_of(model.solution.structure), candidate
        if key not in self._added:
            self._added[key] = self.fits.best(self._on_possible_joints(self._best_fit(model, candidate)))
        return self._added[key]

    def is_significant(self, model: FittedModel, candidate: Candidate) -> bool:
        """Whether the `candidate` promises more of the loss of `model` than its parameters are worth."""
        losses = model.solution.loss, candidate.loss
        return is_significant(*losses, candidate.parameter_count, self.split.independent_rows)

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
        zeros = np.zeros(term.instances * len(term.local_parameters))
        x = np.concatenate([model.solution.x, zeros, np.array(guesses) if shapes is None else shapes])
        return FittedModel(self.split, self.split.at(structure, x))

    def _on_possible_joints(self, model: FittedModel) -> FittedModel:
        """`model` without the joints on which the coefficients of the last effect are not plausible."""
        index, term = len(model.terms) - 1, model.terms[-1]
        within = plausible_instances(term, model.solution.structure.local_values(index, model.solution.x))
        if term.effect.whole_robot or all(within) or not any(within):
            return model
        joints = [joint for joint, inside in zip(term.joints, within, strict=True) if inside]
        return self.fits.on_joints(model, index, joints)


def mandatory_terms(library: Mapping[str, Effect], model: FittedModel) -> list[Term]:
    """Terms of the mandatory effects of the `library` that `model` lacks."""
    rig = model.solution.structure.rig
    return [
        Term.on_all_joints(name, effect, rig)
        for name, effect in library.items()
        if effect.mandatory and name not in model.names
    ]
