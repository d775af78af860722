"""Stepwise selection of a model by the user: lists of steps, branches, and the views of the current list of steps."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ident.workbench import views
from ident.workbench.branches import Branches
from ident.workbench.chosen_recordings import ChosenRecordings
from ident.workbench.jobs import Jobs
from ident.workbench.topics import Changes, Topic
from recordings.errors import BadInput

_MAX_ANALYSES = 6
"""Models whose analysis is kept, so that undo, redo and another branch show them at once."""

Update = Callable[[views.StepsView], Branches]
"""Maps a new list of steps to the new branches."""


@dataclass(eq=False)
class Analysis:
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
        self._analyses: dict[views.StepsView, Analysis] = {}
        """Analyses by list of steps; the one that was shown last comes last."""
        jobs.on_end.append(self._complete_analysis)

    @property
    def step_list(self) -> views.StepsView | None:
        """Return the current list of steps."""
        return self.branches.current.step_list if self.branches else None

    @property
    def analysis(self) -> Analysis:
        """Return what is known of the current model."""
        return (self._analyses.get(self.step_list) if self.step_list else None) or Analysis()

    @property
    def series(self) -> tuple[views.TorqueSeries, ...]:
        """Return the torques of the current model."""
        return self.analysis.series

    @property
    def candidates(self) -> views.CandidateList | None:
        """Return the candidates for the current model."""
        return self.analysis.candidates

    @property
    def previews(self) -> views.CandidatePreviews | None:
        """Return the previews of the candidates for the current model."""
        return self.analysis.previews

    @property
    def residuals(self) -> views.ResidualView | None:
        """Return the residual analysis of the current model."""
        return self.analysis.residuals

    @property
    def within_noise(self) -> bool:
        """Whether nothing is left of the residual of the current model but noise."""
        test = self.residuals.model.residual_test if self.residuals else None
        return test is not None and test.verdict == "within-noise"

    @property
    def has_changes(self) -> bool:
        """Whether the user has changed the first model, so that more would be lost than one fit."""
        branches = self.branches
        return branches is not None and (
            len(branches.all) > 1 or len(branches.current.history) > 1 or bool(branches.current.undone)
        )

    def clear(self) -> None:
        """Discard everything."""
        self.branches = self.diagnosis = None
        self._analyses.clear()
        self._changes.mark("step_list", "series", "candidates", "previews", "residuals", "diagnosis")

    def fit(self) -> None:
        """Fit the base model."""
        self._jobs.submit("fit", self._receiver(Branches.start), "fit", *self._recordings.files)

    def add(self, name: str) -> None:
        """Add an effect."""
        self._extend("add", name)

    def remove(self, index: int) -> None:
        """Remove effect `index` (from 0) of the current model."""
        self._extend("remove", index)

    def diagnose(self) -> None:
        """Run the full diagnosis."""
        self._extend("diagnose")

    def undo(self) -> None:
        """Undo the last change."""
        self._change(Branches.undone)

    def redo(self) -> None:
        """Redo the change that was undone last."""
        self._change(Branches.redone)

    def fork(self) -> None:
        """Keep the current list of steps as a branch and continue in a copy."""
        self._change(Branches.forked)

    def switch(self, index: int) -> None:
        """Switch to another branch."""
        self._change(lambda branches: branches.switched(index))

    def drop(self, index: int) -> None:
        """Drop a branch."""
        self._change(lambda branches: branches.dropped(index))

    def resume_analysis(self) -> None:
        """Analyse the current list of steps again after the analysis was cancelled or interrupted."""
        self._change(lambda branches: branches)

    def _change(self, change: Callable[[Branches], Branches]) -> None:
        """Change the branches at once, and let the worker compute what is not known of their current model."""
        with self._jobs.worker.lock:  # no new step_list arrives meanwhile
            self._jobs.check_free()
            self.branches = branches = change(self._require_branches())
            step_list = branches.current.step_list
            self._keep(step_list, self.analysis)
            self._changes.mark("step_list", "series", "candidates", "previews", "residuals")
            if self.residuals is None:
                receive = partial(self._receive, self.analysis, None)
                self._jobs.submit("show", receive, "show", self._spec(step_list), blocking=False)

    def _extend(self, task: str, *arguments: object) -> None:
        """Submit a task that appends to the current branch."""
        with self._jobs.worker.lock:
            branches = self._require_branches()
            receive = self._receiver(branches.extended)
            self._jobs.submit(task, receive, task, self._spec(branches.current.step_list), *arguments)

    def _require_branches(self) -> Branches:
        if self.branches is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self.branches

    def _spec(self, step_list: views.StepsView) -> views.StepsSpec:
        return views.StepsSpec(*self._recordings.files, tuple(step.spec for step in step_list.steps))

    def _keep(self, step_list: views.StepsView, analysis: Analysis) -> None:
        """Keep the `analysis` of `step_list`, and discard the oldest of too many."""
        self._analyses.pop(step_list, None)
        self._analyses[step_list] = analysis
        while len(self._analyses) > _MAX_ANALYSES:
            del self._analyses[next(iter(self._analyses))]

    def _complete_analysis(self, completed: bool) -> None:
        """Resume the analysis of the list of steps if another task has interrupted it."""
        if completed and self.branches and self.residuals is None:
            self.resume_analysis()

    def _receiver(self, update: Update) -> Callable[[views.View], None]:
        """Return the receiver of a task that makes a new list of steps."""
        return partial(self._receive, Analysis(), update)

    def _receive(self, analysis: Analysis, update: Update | None, view: views.View) -> None:
        """Store a view; all views of a task belong to the `analysis` of one step_list, even if another is shown."""
        match view:
            case views.StepsView():
                if update:
                    self._keep(view, analysis)
                    self.branches = update(view)
                    self._changes.mark("step_list", "series", "candidates", "previews", "residuals")
            case tuple():
                analysis.series = view
                self._jobs.unblock()
                self._mark("series", analysis)
            case views.CandidateList():
                analysis.candidates = view
                self._mark("candidates", analysis)
            case views.CandidatePreviews():
                analysis.previews = view
                self._mark("previews", analysis)
            case views.ResidualView():
                analysis.residuals = view
                self._mark("residuals", analysis)
            case views.DiagnosisView():
                self.diagnosis = view
                self._changes.mark("diagnosis")

    def _mark(self, topic: Topic, analysis: Analysis) -> None:
        """Mark `topic` as changed if `analysis` is that of the current model: what is drawn again loses clicks."""
        if analysis is self.analysis:
            self._changes.mark(topic)
