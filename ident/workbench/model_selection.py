"""Stepwise selection of a model by the user: ladders, branches, and the views of the current ladder."""

from collections.abc import Callable
from functools import partial

from ident.workbench import views
from ident.workbench.branches import Branches
from ident.workbench.chosen_recordings import ChosenRecordings
from ident.workbench.jobs import Jobs
from ident.workbench.topics import Changes
from recordings.errors import BadInput


class ModelSelection:
    """The branches, and what is known of the current ladder."""

    def __init__(self, recordings: ChosenRecordings, jobs: Jobs, changes: Changes) -> None:
        self._recordings, self._jobs, self._changes = recordings, jobs, changes
        self.branches: Branches | None = None
        self.series: tuple[views.TorqueSeries, ...] = ()
        self.candidates: views.CandidateList | None = None
        self.previews: views.CandidatePreviews | None = None
        self.residuals: views.ResidualView | None = None
        self.diagnosis: views.DiagnosisView | None = None
        jobs.on_end.append(self._complete_analysis)

    @property
    def ladder(self) -> views.LadderView | None:
        """Return the current ladder."""
        return self.branches.current.ladder if self.branches else None

    def clear(self) -> None:
        """Discard everything."""
        self.branches = self.candidates = self.previews = self.residuals = self.diagnosis = None
        self.series = ()
        self._changes.mark("ladder", "series", "candidates", "previews", "residuals", "diagnosis")

    def fit(self) -> None:
        """Fit the base model."""
        self._jobs.submit("fit", partial(self._receive, Branches.start), "fit", *self._recordings.files)

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
        self._show(self._require_branches().undone())

    def redo(self) -> None:
        """Redo the change that was undone last."""
        self._show(self._require_branches().redone())

    def fork(self) -> None:
        """Keep the current ladder as a branch and continue in a copy."""
        self._replace_branches(self._require_branches().forked())

    def switch(self, index: int) -> None:
        """Switch to another branch."""
        self._show(self._require_branches().switched(index))

    def drop(self, index: int) -> None:
        """Drop a branch."""
        self._replace_branches(self._require_branches().dropped(index))

    def resume_analysis(self) -> None:
        """Analyse the current ladder again after the analysis was cancelled or interrupted."""
        self._show(self._require_branches())

    def _require_branches(self) -> Branches:
        if self.branches is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self.branches

    def _spec(self, branches: Branches) -> views.LadderSpec:
        return views.LadderSpec(*self._recordings.files, tuple(step.spec for step in branches.current.ladder.steps))

    def _extend(self, task: str, *arguments: object) -> None:
        """Submit a task that appends to the current branch."""
        branches = self._require_branches()
        self._jobs.submit(task, partial(self._receive, branches.extended), task, self._spec(branches), *arguments)

    def _show(self, branches: Branches) -> None:
        """Show the current ladder of `branches`, and then make these the branches."""
        self._jobs.submit("show", partial(self._receive, lambda ladder: branches), "show", self._spec(branches))

    def _replace_branches(self, branches: Branches) -> None:
        """Make `branches`, with the same current ladder, the branches."""
        self._jobs.check_free()
        self.branches = branches
        self._changes.mark("ladder")

    def _complete_analysis(self, completed: bool) -> None:
        """Resume the analysis of the ladder if another task has interrupted it."""
        if completed and self.branches and self.residuals is None:
            self.resume_analysis()

    def _receive(self, update: Callable[[views.LadderView], Branches], view: views.View) -> None:
        """Store a view; `update` maps a new ladder to the new branches."""
        match view:
            case views.LadderView():
                self.branches = update(view)
                self.candidates = self.previews = self.residuals = None
                self._changes.mark("ladder", "candidates", "previews", "residuals")
            case tuple():
                self.series = view
                self._jobs.unblock()
                self._changes.mark("series")
            case views.CandidateList():
                self.candidates = view
                self._changes.mark("candidates")
            case views.CandidatePreviews():
                self.previews = view
                self._changes.mark("previews")
            case views.ResidualView():
                self.residuals = view
                self._changes.mark("residuals")
            case views.DiagnosisView():
                self.diagnosis = view
                self._changes.mark("diagnosis")
