"""Stepwise selection of a model by the user: the history of models, and what is known of each."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ident.residuals.time_span import TorqueSeries
from ident.workbench.state.chosen_recordings import ChosenRecordings
from ident.workbench.state.history import History
from ident.workbench.topics import Changes, Topic
from ident.workbench.worker import views
from ident.workbench.worker.jobs import Jobs
from recordings.errors import BadInput

_MAX_ANALYSES = 6
"""Models whose analysis is kept, so that undo, redo and another branch show them at once."""
_TOPICS: dict[type, Topic] = {
    tuple: "series",
    views.CandidateList: "candidates",
    views.CandidatePreviews: "previews",
    views.ResidualView: "residuals",
    views.Advice: "advice",
    views.FindingFigures: "diagnosis",
}
"""Topic, which is also the part of an analysis, by what the worker sends."""


@dataclass(eq=False)
class ModelAnalysis:
    """What is known of the last model of a list of steps; the worker computes it in this order."""

    series: tuple[TorqueSeries, ...] = ()
    candidates: views.CandidateList | None = None
    previews: views.CandidatePreviews | None = None
    residuals: views.ResidualView | None = None
    advice: views.Advice | None = None
    diagnosis: views.FindingFigures | None = None
    """Of a model that the full diagnosis has found."""


class Selection:
    """The history, and what is known of its current list of steps."""

    def __init__(self, recordings: ChosenRecordings, jobs: Jobs, changes: Changes) -> None:
        self._recordings, self._jobs, self._changes = recordings, jobs, changes
        self.history: History | None = None
        self._analyses: dict[views.StepsView, ModelAnalysis] = {}
        """Analyses by list of steps; the one that was shown last comes last."""
        jobs.on_end.append(self._complete_analysis)

    @property
    def steps(self) -> views.StepsView | None:
        """Return the current list of steps."""
        return self.history.made if self.history else None

    @property
    def analysis(self) -> ModelAnalysis:
        """Return what is known of the current model."""
        return (self._analyses.get(self.steps) if self.steps else None) or ModelAnalysis()

    @property
    def within_noise(self) -> bool:
        """Whether nothing is left of the residual of the current model but noise."""
        residuals = self.analysis.residuals
        test = residuals.model.residual_test if residuals else None
        return test is not None and test.verdict == "within-noise"

    @property
    def is_fitting(self) -> bool:
        """Whether the base model is being fitted."""
        return self._jobs.current is not None and self._jobs.current.task == "fit"

    @property
    def has_changes(self) -> bool:
        """Whether the user has changed the first model, so that more would be lost than one fit."""
        return self.history is not None and len(self.history.entries) > 1

    def take_up(self, history: History | None = None) -> None:
        """Discard everything, and go on with `history`."""
        self.history = history
        self._analyses.clear()
        self._mark_all()

    def fit(self, model: str | None = None) -> None:
        """Fit the base model, and begin a new history with it; or the effects of the file `model`, in a branch."""
        with self._jobs.worker.lock:
            update = self.history.extended if self.history and model else History.start
            file = self._recordings.model(model) if model else None
            receive = partial(self._receive, ModelAnalysis(), update)
            self._jobs.submit("fit", receive, "fit", *self._recordings.files, file)
        if self.history is None:  # the page no longer asks for it
            self._mark_all()

    def extend(self, task: str, *arguments: object) -> None:
        """Let the engine's `task` (add, remove, diagnose) make a list of steps from the current one.

        Raises:
            BadInput: no model is fitted, or another job is in progress.
        """
        with self._jobs.worker.lock:
            history = self._require_history()
            receive = partial(self._receive, ModelAnalysis(), history.extended)
            self._jobs.submit(task, receive, task, self._spec(history.made), *arguments)

    def go(self, to: Callable[[History], History] = lambda history: history) -> None:
        """Move in the history at once, and let the worker compute what is not known of its current model.

        Raises:
            BadInput: as `extend`, or there is nothing `to` go to.
        """
        with self._jobs.worker.lock:  # no new list of steps arrives meanwhile
            self._jobs.check_free()
            self.history = history = to(self._require_history())
            self._keep(history.made, self.analysis)
            self._mark_all()
            if self.analysis.advice is None:
                receive = partial(self._receive, self.analysis, None)
                self._jobs.submit("show", receive, "show", self._spec(history.made), blocking=False)

    def _require_history(self) -> History:
        if self.history is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self.history

    def _spec(self, steps: views.StepsView) -> views.StepsSpec:
        return views.StepsSpec(*self._recordings.files, steps.steps, steps.findings is not None)

    def _keep(self, steps: views.StepsView, analysis: ModelAnalysis) -> None:
        """Keep the `analysis` of `steps`, and discard the oldest of too many."""
        self._analyses.pop(steps, None)
        self._analyses[steps] = analysis
        while len(self._analyses) > _MAX_ANALYSES:
            del self._analyses[next(iter(self._analyses))]

    def _complete_analysis(self, completed: bool) -> None:
        """Resume the analysis of the list of steps if another task has interrupted it."""
        if completed and self.history and self.analysis.advice is None:
            self.go()
        elif self.history is None:
            self._mark_all()

    def _receive(
        self, analysis: ModelAnalysis, update: Callable[[views.StepsView], History] | None, view: views.View
    ) -> None:
        """Store a view; all views of a task belong to one `analysis`, even if another list of steps is shown."""
        if isinstance(view, views.StepsView):
            if update:
                self._keep(view, analysis)
                self.history = update(view)
                self._mark_all()
            return
        topic = _TOPICS[type(view)]
        setattr(analysis, topic, view)
        if topic == "series":
            self._jobs.unblock()
        if analysis is self.analysis:  # what is drawn again without need loses clicks
            self._changes.mark(topic)

    def _mark_all(self) -> None:
        self._changes.mark("steps", *_TOPICS.values())
