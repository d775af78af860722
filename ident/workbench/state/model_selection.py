"""Stepwise selection of a model by the user: lists of steps, branches, and the views of the current list of steps."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ident.workbench.state.branches import Branches
from ident.workbench.state.chosen_recordings import ChosenRecordings
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
}
"""Topic, which is also the part of an analysis, by what the worker sends."""

Update = Callable[[views.StepsView], Branches]
"""Maps a new list of steps to the new branches."""


@dataclass(eq=False)
class ModelAnalysis:
    """What is known of the last model of a list of steps; the worker computes it in this order."""

    series: tuple[views.TorqueSeries, ...] = ()
    candidates: views.CandidateList | None = None
    previews: views.CandidatePreviews | None = None
    residuals: views.ResidualView | None = None


class ModelSelection:
    """The branches, and what is known of the current list of steps."""

    def __init__(self, recordings: ChosenRecordings, jobs: Jobs, changes: Changes) -> None:
        self._recordings, self._jobs, self._changes = recordings, jobs, changes
        self.branches: Branches | None = None
        self.diagnosis: views.DiagnosisView | None = None
        self._analyses: dict[views.StepsView, ModelAnalysis] = {}
        """Analyses by list of steps; the one that was shown last comes last."""
        jobs.on_end.append(self._complete_analysis)

    @property
    def step_list(self) -> views.StepsView | None:
        """Return the current list of steps."""
        return self.branches.current.step_list if self.branches else None

    @property
    def analysis(self) -> ModelAnalysis:
        """Return what is known of the current model."""
        return (self._analyses.get(self.step_list) if self.step_list else None) or ModelAnalysis()

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
        return self.branches is not None and self.branches.has_changes

    def clear(self, branches: Branches | None = None) -> None:
        """Discard everything, and go on with `branches`."""
        self.branches, self.diagnosis = branches, None
        self._analyses.clear()
        self._mark_all()
        self._changes.mark("diagnosis")

    def fit(self) -> None:
        """Fit the base model."""
        receive = partial(self._receive, ModelAnalysis(), Branches.start)
        self._jobs.submit("fit", receive, "fit", *self._recordings.files)
        if self.branches is None:  # the page no longer asks for it
            self._mark_all()

    def extend(self, task: str, *arguments: object) -> None:
        """Let the engine's `task` (add, remove, diagnose) append to the current branch.

        Raises:
            BadInput: no model is fitted, or another job is in progress.
        """
        with self._jobs.worker.lock:
            branches = self._require_branches()
            receive = partial(self._receive, ModelAnalysis(), branches.extended)
            self._jobs.submit(task, receive, task, self._spec(branches.current.step_list), *arguments)

    def change(self, change: Callable[[Branches], Branches] = lambda branches: branches) -> None:
        """Change the branches at once, and let the worker compute what is not known of their current model.

        Raises:
            BadInput: as `extend`, or the change is not possible.
        """
        with self._jobs.worker.lock:  # no new step_list arrives meanwhile
            self._jobs.check_free()
            self.branches = branches = change(self._require_branches())
            step_list = branches.current.step_list
            self._keep(step_list, self.analysis)
            self._mark_all()
            if self.analysis.residuals is None:
                receive = partial(self._receive, self.analysis, None)
                self._jobs.submit("show", receive, "show", self._spec(step_list), blocking=False)

    def _require_branches(self) -> Branches:
        if self.branches is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self.branches

    def _spec(self, step_list: views.StepsView) -> views.StepsSpec:
        return views.StepsSpec(*self._recordings.files, tuple(step.spec for step in step_list.steps))

    def _keep(self, step_list: views.StepsView, analysis: ModelAnalysis) -> None:
        """Keep the `analysis` of `step_list`, and discard the oldest of too many."""
        self._analyses.pop(step_list, None)
        self._analyses[step_list] = analysis
        while len(self._analyses) > _MAX_ANALYSES:
            del self._analyses[next(iter(self._analyses))]

    def _complete_analysis(self, completed: bool) -> None:
        """Resume the analysis of the list of steps if another task has interrupted it."""
        if completed and self.branches and self.analysis.residuals is None:
            self.change()
        elif self.branches is None:
            self._mark_all()

    def _receive(self, analysis: ModelAnalysis, update: Update | None, view: views.View) -> None:
        """Store a view; all views of a task belong to the `analysis` of one step_list, even if another is shown."""
        match view:
            case views.StepsView():
                if update:
                    self._keep(view, analysis)
                    self.branches = update(view)
                    self._mark_all()
            case views.DiagnosisView():
                self.diagnosis = view
                self._changes.mark("diagnosis")
            case _:
                topic = _TOPICS[type(view)]
                setattr(analysis, topic, view)
                if topic == "series":
                    self._jobs.unblock()
                if analysis is self.analysis:  # what is drawn again without need loses clicks
                    self._changes.mark(topic)

    def _mark_all(self) -> None:
        self._changes.mark("step_list", *_TOPICS.values())
