"""Manual stepwise selection in the worker process: fit the base model, rate candidates, add and remove effects.

Every task is a generator of views, the most urgent first. A task brings the steps from which it starts: a process
that has fitted their models continues at once, another one takes them from their parameters. Models, errors and
improvements are those of `ident diagnose` (`ident.diagnosis.search`), one step at a time.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np

from ident.data.samples import is_relative
from ident.diagnosis.diagnosis import DiagnosisInputs, DiagnosisOptions, diagnose, prepare_inputs
from ident.diagnosis.document import verdict
from ident.diagnosis.document.formula import with_formula
from ident.diagnosis.document.warnings import unjudged_rows
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE
from ident.diagnosis.search.screening import Candidate
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import WIDTH, SelectionStep
from ident.diagnosis.unknown.residual_test import UnexplainedResidual
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from ident.identification import model_file
from ident.output.figures.finding import before_after
from ident.workbench.figure import to_dict
from ident.workbench.worker import views
from ident.workbench.worker.model_views import candidate_previews, residual_view, torque_series
from ident.workbench.worker.recording_view import mismatch, recording_views
from ident.workbench.worker.step_view import on_rows_of, refusal, step_view, step_views
from ident.workbench.worker.views import StepsSpec, StepView, View
from recordings.errors import BadInput
from recordings.files import sha256


@dataclass(frozen=True, eq=False)
class _Data:
    """Recordings, and the search that has fitted models to them."""

    files: tuple[Path, Path | None]
    inputs: DiagnosisInputs
    search: Search

    @cached_property
    def digests(self) -> tuple[str, ...]:
        """The SHA-256 of the files."""
        return tuple(sha256(file) for file in self.files if file)


class SelectionEngine:
    """Executes the tasks of one session."""

    def __init__(self, progress: Callable[[str], None], effect_files: Sequence[Path] = ()) -> None:
        self._progress = progress
        self._library = library(effect_files)
        self._data: _Data | None = None
        self._screened: WeakKeyDictionary[FittedModel, tuple[dict[str, Candidate], views.CandidateList]]
        self._screened = WeakKeyDictionary()
        self._unexplained: WeakKeyDictionary[FittedModel, UnexplainedResidual] = WeakKeyDictionary()
        """What the full diagnosis has said of its last model."""

    def view_recording(self, path: Path, validate: Path | None = None) -> Iterator[View]:
        """Yield the view of a recording; before it a `Mismatch` if `validate` comes from another rig."""
        self._progress(f"reading {path.name}")
        if validate is not None:
            yield from mismatch(path, validate)
        yield from recording_views(path)

    def fit(self, train: Path, validate: Path | None, model: Path | None = None) -> Iterator[View]:
        """Fit the base model, or the effects of the file `model`, with the mandatory effects."""
        data = self._read(train, validate)
        self._progress("fitting the base model" if model is None else f"fitting the model of {model.name}")
        known = None if model is None else model_file.load(model)
        _, steps = data.search.start(*data.inputs.initial_model(self._library, known))
        yield from self._made(data, step_views(steps), [step.model for step in steps])

    def show(self, base: StepsSpec) -> Iterator[View]:
        """Yield the views of the last model of `base`."""
        data = self._data_of(base)
        yield from self._views(data, self._models(data, base), base.diagnosed)

    def add(self, base: StepsSpec, name: str) -> Iterator[View]:
        """Add an effect and refit all parameters."""
        data = self._data_of(base)
        models = self._models(data, base)
        candidates, _ = self._screen(data, models[-1])
        if name not in candidates:
            raise BadInput(
                f"an effect that this motion excites, with an admissible sign, expected, '{name}' found; "
                "choose another card"
            )
        self._progress(f"fitting everything with {name}")
        extended = data.search.candidates.add(models[-1], candidates[name])
        yield from self._changed(data, base, f"+ {name}", name, [*models, extended])

    def remove(self, base: StepsSpec, index: int) -> Iterator[View]:
        """Remove effect `index` (from 0) of the current model and refit; the result is appended as a new step."""
        data = self._data_of(base)
        models = self._models(data, base)
        if not 0 <= index < len(models[-1].terms):
            raise BadInput(f"an effect of the model expected, number {index + 1} found; reload the page")
        name = models[-1].terms[index].name
        self._progress(f"fitting everything without {name}")
        without = data.search.fits.without_effect(models[-1], index)
        yield from self._changed(data, base, f"− {name}", None, [*models, without])

    def diagnose(self, base: StepsSpec) -> Iterator[View]:
        """Run `ident diagnose`; its steps become the current list of steps."""
        data = self._data_of(base)
        held_out = [base.validate] if base.validate else []
        diagnosis = diagnose([base.train], held_out, self._library, DiagnosisOptions(), self._progress)
        self._progress("searching a formula for what is left")
        document, law = with_formula(diagnosis, verdict.to_document(diagnosis))
        self._progress("writing the diagnosis")
        findings = {finding.term.name: finding for finding in reversed(diagnosis.selection.findings)}
        figures = {name: to_dict(before_after(diagnosis, finding)) for name, finding in findings.items()}
        changed = {name: getattr(diagnosis, name) for name in ("split", "effects", "excerpt_share")}
        data = self._data = self._searched(data.files, replace(data.inputs, **changed))
        steps, models = diagnosis.selection.steps, [step.model for step in diagnosis.selection.steps]
        for model in models:
            data.search.fits.best(model)
        self._unexplained[models[-1]] = diagnosis.unexplained
        said = views.Findings(document.as_json(), law)
        yield from self._made(data, step_views(steps), models, said, views.FindingFigures(figures))

    def _data_of(self, base: StepsSpec) -> _Data:
        if self._data is None or self._data.files != (base.train, base.validate):
            return self._read(base.train, base.validate)
        return self._data

    def _read(self, train: Path, validate: Path | None) -> _Data:
        self._progress("reading and preparing the recordings")
        inputs = prepare_inputs([train], [validate] if validate else [], self._library, DiagnosisOptions())
        self._data = self._searched((train, validate), inputs)
        return self._data

    def _searched(self, files: tuple[Path, Path | None], inputs: DiagnosisInputs) -> _Data:
        return _Data(files, inputs, Search(inputs.split, inputs.effects.observable, self._progress))

    def _models(self, data: _Data, base: StepsSpec) -> list[FittedModel]:
        """Return the models of `base`, with the very parameters that they had."""
        bare, models = data.inputs.split.recordings[0].base_structure, []
        for step in base.steps:
            terms = (Term(name, self._library[name], tuple(j - 1 for j in joints)) for name, joints in step.terms)
            models.append(data.search.fits.at(replace(bare, terms=tuple(terms)), np.array(step.x)))
        return models

    def _changed(
        self, data: _Data, base: StepsSpec, label: str, added: str | None, models: Sequence[FittedModel]
    ) -> Iterator[View]:
        """Yield the views of the last of `models`, which a change, called `label`, has made of that before it."""
        before, model = models[-2:]
        step = step_view(label, SelectionStep(added, model, model.improvement_over(before)), before)
        steps = on_rows_of(model, (*base.steps, step), models)
        yield from self._made(data, steps, models)

    def _made(
        self,
        data: _Data,
        steps: tuple[StepView, ...],
        models: Sequence[FittedModel],
        said: views.Findings | None = None,
        figures: views.FindingFigures | None = None,
    ) -> Iterator[View]:
        """Yield the `steps` to the last of the `models`, what the diagnosis has `said` of it, and its views."""
        yield self._steps_view(data, steps, models[-1], said)
        yield from () if figures is None else (figures,)
        yield from self._views(data, models, said is not None)

    def _views(self, data: _Data, models: Sequence[FittedModel], diagnosed: bool) -> Iterator[View]:
        model, judged = models[-1], models[-1].on_judged_rows
        yield torque_series(judged, models[-2] if len(models) > 1 else None)
        self._progress("rating every effect of the library")
        candidates, view = self._screen(data, model)
        yield view
        self._progress("drawing the candidate previews")
        yield candidate_previews(model, candidates)
        self._progress("analysing the residual")
        residuals = residual_view(judged, diagnosed, self._unexplained.get(model))
        yield residuals
        test = residuals.model.residual_test
        yield views.Advice(None) if test and test.verdict == "within-noise" else self._advice(data, model)

    def _advice(self, data: _Data, model: FittedModel) -> views.Advice:
        """Return the best effect that the judge accepts beside `model`, or else why it refuses the best one."""
        candidates, view = self._screen(data, model)
        advice = []
        for card in view.cards[:WIDTH]:
            if card.improvement < MIN_SHARE:
                break
            self._progress(f"testing {card.name}")
            extended = data.search.candidates.add(model, candidates[card.name])
            advice.append(views.Advice(card.name, card.improvement, refusal(model, extended)))
            if not advice[-1].refusal:
                return advice[-1]
        return advice[0] if advice else views.Advice(None)

    def _steps_view(
        self, data: _Data, steps: tuple[StepView, ...], model: FittedModel, said: views.Findings | None
    ) -> views.StepsView:
        split, (train, validate) = data.inputs.split, data.files
        recording = split.recordings[0].recording
        return views.StepsView(
            train=train.name,
            validate=validate.name if validate else None,
            digests=data.digests,
            steps=steps,
            noise_rms=tuple(model.noise_floor.rms.tolist()),
            units=recording.rig.effort_units,
            position_units=recording.rig.position_units,
            relative=is_relative(recording),
            simulated=any(each.recording.run.simulated for each in split.recordings),
            bandwidth=split.recordings[0].bandwidth,
            held_out=verdict.describe_test_data(split),
            excerpt=data.inputs.excerpt_share,
            mandatory=tuple(
                name
                for name, effect in self._library.items()
                if effect.mandatory and recording.rig.mechanism in effect.mechanisms
            ),
            warnings=tuple(unjudged_rows(model.on_judged_rows.split)),
            findings=said,
        )

    def _screen(self, data: _Data, model: FittedModel) -> tuple[dict[str, Candidate], views.CandidateList]:
        """Rate the effects that could be added to `model`; return them by name, and their view."""
        if model not in self._screened:
            screening = data.search.candidates.screen(model)
            candidates: dict[str, Candidate] = {}
            for candidate in screening.candidates:
                candidates.setdefault(candidate.term.name, candidate)  # of several spectral lines the best
            cards = []
            for name, candidate in candidates.items():
                term = candidate.term
                joints = () if term.effect.whole_robot else tuple(joint + 1 for joint in term.joints)
                cards.append(views.CandidateCard(name, joints, screening.reductions[name]))
            effects = data.inputs.effects
            view = views.CandidateList(
                tuple(cards), tuple(screening.excluded), {**effects.unobservable, **effects.untested}
            )
            self._screened[model] = candidates, view
        return self._screened[model]
