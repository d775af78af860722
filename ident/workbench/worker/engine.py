"""Manual stepwise selection in the worker process: fit the base model, rate candidates, add and remove effects.

Every task is a generator of views, the most urgent first. A task names the steps from which it starts: a process that
has them continues at once, a new process rebuilds them. Models, errors and improvements are those of
`ident diagnose` (`ident.diagnosis.search`), one step at a time.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np

from ident.data.samples import holds_torque
from ident.diagnosis.diagnosis import DiagnosisInputs, DiagnosisOptions, diagnose, prepare_inputs
from ident.diagnosis.document import verdict
from ident.diagnosis.document.formula import with_formula
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.screening import Candidate
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import SelectionStep
from ident.diagnosis.unknown.residual_test import UnexplainedResidual
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from ident.output.figures.finding import before_after
from ident.workbench.figure import to_dict
from ident.workbench.worker import views
from ident.workbench.worker.model_views import candidate_previews, residual_view, torque_series
from ident.workbench.worker.recording_view import mismatch, recording_views
from ident.workbench.worker.selection_state import FittedStep, SelectionState, fitted_step, fitted_steps
from ident.workbench.worker.swarm_task import run_swarm
from ident.workbench.worker.views import ModelSpec, StepsSpec, View
from recordings.errors import BadInput


class SelectionEngine:
    """Executes the tasks of one session."""

    def __init__(
        self,
        progress: Callable[[str], None],
        effect_files: Sequence[Path] = (),
        on_swarm_progress: Callable[[views.SwarmProgress], None] = lambda progress: None,
    ) -> None:
        """`on_swarm_progress`: called while the swarm searches."""
        self._progress, self._on_swarm_progress = progress, on_swarm_progress
        self._library = library(effect_files)
        self._selection: SelectionState | None = None
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

    def fit(self, train: Path, validate: Path | None) -> Iterator[View]:
        """Fit the base model with the mandatory effects."""
        self._selection = selection = self._start(train, validate)
        yield from self._views(selection)

    def show(self, base: StepsSpec) -> Iterator[View]:
        """Yield the views of the list of steps `base`."""
        yield from self._views(self._selection_at(base))

    def add(self, base: StepsSpec, name: str) -> Iterator[View]:
        """Add an effect and refit all parameters."""
        selection = self._selection_at(base)
        candidates, _ = self._screen(selection)
        if name not in candidates:
            raise BadInput(
                f"an effect that this motion excites, with an admissible sign, expected, '{name}' found; "
                "choose another card"
            )
        self._progress(f"fitting everything with {name}")
        selection.push(f"+ {name}", name, selection.selector.candidates.add(selection.model, candidates[name]))
        yield from self._views(selection)

    def remove(self, base: StepsSpec, index: int) -> Iterator[View]:
        """Remove effect `index` (from 0) of the current model and refit; the result is appended as a new step."""
        selection = self._selection_at(base)
        if not 0 <= index < len(selection.model.terms):
            raise BadInput(f"an effect of the model expected, number {index + 1} found; reload the page")
        name = selection.model.terms[index].name
        self._progress(f"fitting everything without {name}")
        selection.push(f"− {name}", None, selection.selector.fits.without_effect(selection.model, index))
        yield from self._views(selection)

    def diagnose(self, base: StepsSpec) -> Iterator[View]:
        """Run `ident diagnose`; its steps become the current list of steps."""
        selection = self._selection_at(base)
        held_out = [base.validate] if base.validate else []
        diagnosis = diagnose([base.train], held_out, self._library, DiagnosisOptions(), self._progress)
        self._progress("searching a formula for what is left")
        document, law = with_formula(diagnosis, verdict.to_document(diagnosis))
        self._progress("writing the diagnosis")
        findings = {finding.term.name: finding for finding in reversed(diagnosis.selection.findings)}
        figures = {name: to_dict(before_after(diagnosis, finding)) for name, finding in findings.items()}
        yield views.DiagnosisView(document.as_json(), figures, law)
        changed = {name: getattr(diagnosis, name) for name in ("split", "effects", "excerpt_share")}
        selection = self._selection = self._state(selection.files, replace(selection.inputs, **changed))
        selection.set_steps(*fitted_steps(diagnosis.selection.steps))
        self._unexplained[selection.model] = diagnosis.unexplained
        yield from self._views(selection)

    def swarm(self, train: Path, validate: Path | None, request: views.SwarmRequest) -> Iterator[View]:
        """Fit the parameters by the paper's particle swarm, as `ident fit` does."""
        self._progress("reading and preparing the recordings for the swarm")
        yield run_swarm(train, validate, request, self._library, self._on_swarm_progress)

    def _selection_at(self, base: StepsSpec) -> SelectionState:
        """Return the selection state at the list of steps `base`."""
        selection = self._selection
        if selection is None or selection.files != (base.train, base.validate):
            selection = self._start(base.train, base.validate)
        if selection.specs != base.steps:
            selection.set_steps(*self._rebuild(selection, base.steps))
        self._selection = selection
        return selection

    def _start(self, train: Path, validate: Path | None) -> SelectionState:
        self._progress("reading and preparing the recordings")
        inputs = prepare_inputs([train], [validate] if validate else [], self._library, DiagnosisOptions())
        selection = self._state((train, validate), inputs)
        self._progress("fitting the base model")
        model, steps = selection.selector.start(*inputs.initial_model(self._library))
        selection.set_steps(*fitted_steps(steps))
        if selection.model is not model:  # mandatory effects are in the model whether or not they improve it
            name = model.terms[-1].name
            selection.push(f"+ {name}", name, model)
        return selection

    def _state(self, files: tuple[Path, Path | None], inputs: DiagnosisInputs) -> SelectionState:
        return SelectionState(files, inputs, Search(inputs.split, inputs.effects.observable, self._progress))

    def _rebuild(self, selection: SelectionState, specs: tuple[ModelSpec, ...]) -> Iterator[FittedStep]:
        """Yield the steps of a list of steps from their `specs`; solve only the unknown ones."""
        base_structure = replace(selection.model.solution.structure, terms=())
        before: FittedModel | None = None
        for number, (label, terms, x) in enumerate(specs, start=1):
            step = selection.known_steps.get(specs[:number])
            if step is None:
                made = (
                    Term(name, self._library[name], tuple(joint - 1 for joint in joints)) for name, joints in terms
                )
                model = selection.selector.fits.fit(replace(base_structure, terms=tuple(made)), np.array(x))
                improvement = model.improvement_over(before) if before else None
                added = terms[-1][0] if label.startswith("+") else None
                step = fitted_step(label, SelectionStep(added, model, improvement), before)
            yield step
            before = step.model

    def _views(self, selection: SelectionState) -> Iterator[View]:
        yield self._steps_view(selection)
        yield torque_series(selection)
        self._progress("rating every effect of the library")
        candidates, view = self._screen(selection)
        yield view
        self._progress("drawing the candidate previews")
        yield candidate_previews(selection, candidates)
        self._progress("analysing the residual")
        yield residual_view(selection.model, self._unexplained.get(selection.model))

    def _steps_view(self, selection: SelectionState) -> views.StepsView:
        split, (train, validate) = selection.inputs.split, selection.files
        recording = split.recordings[0].recording
        return views.StepsView(
            train=train.name,
            validate=validate.name if validate else None,
            digests=selection.digests,
            steps=tuple(step.view for step in selection.steps),
            noise_rms=tuple(selection.model.noise_floor.rms.tolist()),
            units=recording.rig.effort_units,
            position_units=recording.rig.position_units,
            relative=recording.rig.torque.gain_source == "assumed" and not holds_torque(recording),
            simulated=any(data.recording.run.simulated for data in split.recordings),
            bandwidth=split.recordings[0].bandwidth,
            held_out=verdict.describe_test_data(split),
            excerpt=selection.inputs.excerpt_share,
            mandatory=tuple(
                name
                for name, effect in self._library.items()
                if effect.mandatory and recording.rig.mechanism in effect.mechanisms
            ),
            diagnosed=selection.model in self._unexplained,
        )

    def _screen(self, selection: SelectionState) -> tuple[dict[str, Candidate], views.CandidateList]:
        """Rate the effects that could be added to the current model; return them by name, and their view."""
        if selection.model not in self._screened:
            screening = selection.selector.candidates.screen(selection.model)
            candidates: dict[str, Candidate] = {}
            for candidate in screening.candidates:
                candidates.setdefault(candidate.term.name, candidate)  # of several spectral lines the best
            cards = []
            for name, candidate in candidates.items():
                term = candidate.term
                joints = () if term.effect.whole_robot else tuple(joint + 1 for joint in term.joints)
                cards.append(views.CandidateCard(name, joints, screening.reductions[name]))
            effects = selection.inputs.effects
            view = views.CandidateList(
                tuple(cards), tuple(screening.excluded), {**effects.unobservable, **effects.untested}
            )
            self._screened[selection.model] = candidates, view
        return self._screened[selection.model]
