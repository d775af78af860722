"""The user's models while tasks come and go: no view gets lost, none ends up at another model. No worker runs."""

import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from ident.workbench import model_selection, views
from ident.workbench.chosen_recordings import ChosenRecordings
from ident.workbench.jobs import Jobs
from ident.workbench.model_selection import ModelSelection
from ident.workbench.topics import Changes
from ident.workbench.worker import TaskEnd, WorkerEnd
from recordings.errors import BadInput


class WorkerDouble:
    """Takes tasks and computes nothing."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.tasks: list[str] = []

    def submit(self, task: str, *arguments: object) -> None:
        self.tasks.append(task)

    def cancel(self) -> None: ...

    def resume(self) -> None: ...


class RecordingsDouble:
    """The chosen recordings, which may have been deleted."""

    deleted = False

    @property
    def files(self) -> tuple[Path, None]:
        if self.deleted:
            raise BadInput("a file expected, none found; choose another")
        return Path("a.mcap"), None


class Bench:
    """A selection without a worker; the test sends the views of the tasks."""

    def __init__(self) -> None:
        self.changes, self.recordings, self.worker = Changes(), RecordingsDouble(), WorkerDouble()
        self.jobs = Jobs(self.changes, ())
        self.jobs.worker = cast(Any, self.worker)
        self.selection = ModelSelection(cast(ChosenRecordings, self.recordings), self.jobs, self.changes)

    def send(self, *messages: object) -> None:
        for message in messages:
            self.jobs.receive(cast(Any, message))

    def complete(self, label: str) -> views.StepsView:
        """Send all views of a task that makes the model `label`, and its end."""
        step_list = steps_view(label)
        self.send(step_list, SERIES, CANDIDATES, PREVIEWS, residual_view(label), TaskEnd())
        return step_list


def steps_view(label: str) -> views.StepsView:
    view = object.__new__(views.StepsView)
    object.__setattr__(view, "steps", (SimpleNamespace(label=label, spec=label, terms=()),))
    object.__setattr__(view, "mandatory", ())
    return view


def residual_view(sentence: str, verdict: str = "above-noise") -> views.ResidualView:
    model = cast(Any, SimpleNamespace(residual_test=SimpleNamespace(verdict=verdict)))
    return views.ResidualView(model, (), "N m", (sentence,), (), {}, views.CausesView((), {}, "", (), ()))


SERIES: tuple[()] = ()
CANDIDATES = views.CandidateList((), (), {})
PREVIEWS = views.CandidatePreviews({}, {})


@pytest.fixture
def bench() -> Bench:
    """Return a bench with a fitted model, to which an effect was added."""
    bench = Bench()
    bench.selection.fit()
    bench.complete("base")
    bench.selection.add("stribeck")
    bench.complete("added")
    assert bench.worker.tasks == ["fit", "add"]
    return bench


def analysed(selection: ModelSelection) -> str | None:
    """Return the label of the model whose residual is shown."""
    return selection.residuals.sentences[0] if selection.residuals else None


def test_undo_redo_and_branches_compute_nothing_that_is_known(bench: Bench) -> None:
    selection = bench.selection
    shown = []
    for change in (selection.undo, selection.redo, selection.fork, selection.undo, lambda: selection.switch(0)):
        change()
        shown.append(analysed(selection))
        assert bench.jobs.current is None
        assert selection.candidates is CANDIDATES
    assert shown == ["base", "added", "added", "base", "added"]
    assert bench.worker.tasks == ["fit", "add"]


def test_oldest_analysis_is_computed_again(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model_selection, "_MAX_ANALYSES", 1)
    bench.selection.undo()
    assert analysed(bench.selection) == "base"
    bench.selection.redo()
    assert analysed(bench.selection) is None
    assert bench.worker.tasks == ["fit", "add", "show"]
    bench.complete("added")
    assert analysed(bench.selection) == "added"
    assert bench.selection.branches
    assert len(bench.selection.branches.current.history) == 2, "showing a model again adds none"


def test_late_views_belong_to_the_model_they_were_computed_for(bench: Bench) -> None:
    bench.selection.add("cogging")
    bench.send(steps_view("late"), SERIES)
    bench.selection.undo()
    before = bench.changes.count(("candidates", "previews", "residuals"))
    bench.send(CANDIDATES, PREVIEWS, residual_view("late"))
    assert analysed(bench.selection) == "added"
    assert bench.changes.count(("candidates", "previews", "residuals")) == before, "nothing is drawn again"
    bench.selection.redo()
    assert analysed(bench.selection) == "late"


def test_interrupted_analysis_is_resumed_afterwards(bench: Bench) -> None:
    bench.selection.add("cogging")
    bench.send(steps_view("interrupted"), SERIES)
    bench.jobs.submit("swarm", lambda view: None, "swarm")
    bench.send(CANDIDATES, TaskEnd())
    assert bench.worker.tasks[-1] == "swarm"
    bench.send(TaskEnd())
    assert bench.worker.tasks[-1] == "show"
    assert not bench.jobs.blocked
    bench.complete("again")
    assert bench.jobs.current is None
    assert analysed(bench.selection) == "again"


def test_last_view_of_an_interrupted_task_does_not_unblock_the_next(bench: Bench) -> None:
    bench.selection.add("cogging")
    bench.send(steps_view("first"), SERIES)
    bench.selection.resume_analysis()
    bench.selection.remove(0)
    assert bench.jobs.blocked
    bench.send(SERIES)
    with pytest.raises(BadInput, match="no other job"):
        bench.selection.add("joint_spring")


def test_reading_a_recording_does_not_unblock_a_fit(bench: Bench) -> None:
    """Else an effect could be added to the old step_list, and the new one would be lost."""
    bench.selection.add("cogging")
    bench.jobs.submit("reading", lambda view: None, "view_recording", blocking=False)
    for change in (bench.selection.undo, bench.selection.fork, lambda: bench.selection.add("joint_spring")):
        with pytest.raises(BadInput, match="no other job"):
            change()


def test_deleted_recording_does_not_end_the_listener(bench: Bench) -> None:
    bench.selection.add("cogging")
    bench.send(steps_view("added"), SERIES)
    bench.jobs.submit("reading", lambda view: None, "view_recording", blocking=False)
    bench.recordings.deleted = True
    before = bench.changes.count(("job",))
    bench.send(TaskEnd(), TaskEnd())
    assert bench.jobs.current is None
    assert "a file expected" in bench.jobs.message
    assert bench.changes.count(("job",)) == before + 2


@pytest.mark.parametrize(
    ("views_sent", "message"),
    [((), "nothing has changed"), ((steps_view("new"), SERIES), "what is shown stays")],
)
def test_cancel_says_what_has_changed(views_sent: tuple[object, ...], message: str, bench: Bench) -> None:
    bench.selection.add("cogging")
    bench.send(*views_sent)
    bench.jobs.cancel()
    assert message in bench.jobs.message
    assert bench.jobs.current is None
    if views_sent:
        bench.selection.resume_analysis()
        assert bench.worker.tasks[-1] == "show", "there is a way on"


def test_lost_worker_is_reported_and_the_analysis_can_be_resumed(bench: Bench) -> None:
    bench.selection.add("cogging")
    bench.send(steps_view("new"), SERIES, WorkerEnd("The worker process has ended."))
    assert bench.jobs.message == "The worker process has ended."
    assert bench.jobs.current is None
    bench.selection.resume_analysis()
    assert bench.jobs.current


def test_only_changes_by_the_user_are_worth_a_question() -> None:
    bench = Bench()
    assert not bench.selection.has_changes
    bench.selection.fit()
    bench.complete("base")
    assert not bench.selection.has_changes
    bench.selection.fork()
    assert bench.selection.has_changes
    bench.selection.drop(0)
    assert not bench.selection.has_changes
    bench.selection.add("stribeck")
    bench.complete("added")
    assert bench.selection.has_changes
    bench.selection.undo()
    assert bench.selection.has_changes, "redo would be lost"


def test_verdict_of_the_current_model(bench: Bench) -> None:
    assert not bench.selection.within_noise
    bench.selection.add("cogging")
    bench.send(steps_view("right"), SERIES, CANDIDATES, PREVIEWS, residual_view("", "within-noise"), TaskEnd())
    assert bench.selection.within_noise
    bench.selection.undo()
    assert not bench.selection.within_noise
