"""The user's models while tasks come and go: no view gets lost, none ends up at another model. No worker runs."""

import threading
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import Mock, PropertyMock

import pytest

from ident.output.tables import ResultTable
from ident.workbench.state import selection
from ident.workbench.state.history import History
from ident.workbench.state.selection import Selection
from ident.workbench.topics import Changes
from ident.workbench.worker import views
from ident.workbench.worker.jobs import Jobs
from ident.workbench.worker.process import TaskEnd, WorkerEnd
from recordings.errors import BadInput


class Bench:
    """A selection without a worker; the test sends the views of the tasks."""

    def __init__(self) -> None:
        self.changes = Changes()
        self.jobs = Jobs(self.changes, ())
        self.jobs.worker = self._worker = Mock(lock=threading.RLock())
        self.files = PropertyMock(return_value=(Path("a.mcap"), None))
        self.recordings = type("Recordings", (), {"files": self.files})()
        self.selection = Selection(self.recordings, self.jobs, self.changes)

    @property
    def tasks(self) -> list[str]:
        """The tasks that the worker got."""
        return [call.args[0] for call in self._worker.submit.call_args_list]

    def send(self, *messages: object) -> None:
        for message in messages:
            self.jobs.receive(cast(Any, message))

    def complete(self, label: str) -> views.StepsView:
        """Send all views of a task that makes the model `label`, and its end."""
        made = steps_view(label)
        self.send(made, SERIES, CANDIDATES, PREVIEWS, residual_view(label), views.Advice(None), TaskEnd())
        return made


def steps_view(label: str, *added: str) -> views.StepsView:
    """A list of steps with what branches and the selection use of it."""
    view = object.__new__(views.StepsView)
    terms = tuple((name, (1, 2, 3)) for name in ("rod_inertia", *(added or (label,))))
    object.__setattr__(view, "steps", (SimpleNamespace(label=label, terms=terms),))
    object.__setattr__(view, "mandatory", ("rod_inertia",))
    object.__setattr__(view, "findings", None)
    return view


def residual_view(sentence: str, verdict: str = "above-noise") -> views.ResidualView:
    model = cast(Any, SimpleNamespace(residual_test=SimpleNamespace(verdict=verdict)))
    nothing = ResultTable((), ())
    return views.ResidualView(model, (), (sentence,), (), nothing, {}, nothing, (), {})


SERIES: tuple[()] = ()
CANDIDATES = views.CandidateList((), (), {})
PREVIEWS = views.CandidatePreviews({}, {})


@pytest.fixture
def bench() -> Bench:
    """Return a bench with a fitted model, to which an effect was added."""
    bench = Bench()
    bench.selection.fit()
    bench.complete("base")
    bench.selection.extend("add", "stribeck")
    bench.complete("added")
    assert bench.tasks == ["fit", "add"]
    return bench


def analysed(selection: Selection) -> str | None:
    """Return the label of the model whose residual is shown."""
    return selection.analysis.residuals.sentences[0] if selection.analysis.residuals else None


def undo(history: History) -> History:
    return history.at(history.undo)


def redo(history: History) -> History:
    return history.at(history.redo)


def test_the_way_through_the_history_computes_nothing_that_is_known(bench: Bench) -> None:
    selection = bench.selection
    selection.go(undo)
    selection.extend("add", "backlash")
    bench.complete("other")
    shown = []
    for change in (undo, redo, undo, lambda history: history.at(1), undo, redo):
        selection.go(change)
        shown.append(analysed(selection))
        assert bench.jobs.current is None
        assert selection.analysis.candidates is CANDIDATES
    assert shown == ["base", "other", "base", "added", "base", "added"], "redo stays in the branch"
    assert bench.tasks == ["fit", "add", "add"]


def test_oldest_analysis_is_computed_again(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(selection, "_MAX_ANALYSES", 1)
    bench.selection.go(undo)
    assert analysed(bench.selection) == "base"
    bench.selection.go(redo)
    assert analysed(bench.selection) is None
    assert bench.tasks == ["fit", "add", "show"]
    bench.complete("added")
    assert analysed(bench.selection) == "added"
    bench.selection.go(undo)
    with pytest.raises(BadInput, match="another model of the history"):  # showing a model again has added none
        bench.selection.go(undo)


def test_late_views_belong_to_the_model_they_were_computed_for(bench: Bench) -> None:
    bench.selection.extend("add", "cogging")
    bench.send(steps_view("late"), SERIES)
    bench.selection.go(undo)
    before = bench.changes.count(("candidates", "previews", "residuals"))
    bench.send(CANDIDATES, PREVIEWS, residual_view("late"))
    assert analysed(bench.selection) == "added"
    assert bench.changes.count(("candidates", "previews", "residuals")) == before, "nothing is drawn again"
    bench.selection.go(redo)
    assert analysed(bench.selection) == "late"


def test_interrupted_analysis_is_resumed_afterwards(bench: Bench) -> None:
    bench.selection.extend("add", "cogging")
    bench.send(steps_view("interrupted"), SERIES)
    bench.jobs.submit("swarm", lambda view: None, "swarm")
    bench.send(CANDIDATES, TaskEnd(), TaskEnd())
    assert bench.tasks[-2:] == ["swarm", "show"]
    assert not bench.jobs.blocked
    bench.complete("again")
    assert bench.jobs.current is None
    assert analysed(bench.selection) == "again"


def test_last_view_of_an_interrupted_task_does_not_unblock_the_next(bench: Bench) -> None:
    bench.selection.extend("add", "cogging")
    bench.send(steps_view("first"), SERIES)
    bench.selection.go()
    bench.selection.extend("remove", 0)
    assert bench.jobs.blocked
    bench.send(SERIES)
    with pytest.raises(BadInput, match="no other job"):
        bench.selection.extend("add", "joint_spring")


def test_reading_a_recording_does_not_unblock_a_fit(bench: Bench) -> None:
    """Else an effect could be added to the old made, and the new one would be lost."""
    bench.selection.extend("add", "cogging")
    bench.jobs.submit("reading", lambda view: None, "view_recording", blocking=False)
    for action in (bench.selection.go, partial(bench.selection.extend, "add", "joint_spring")):
        with pytest.raises(BadInput, match="no other job"):
            action()


def test_deleted_recording_does_not_end_the_listener(bench: Bench) -> None:
    bench.selection.extend("add", "cogging")
    bench.send(steps_view("added"), SERIES)
    bench.jobs.submit("reading", lambda view: None, "view_recording", blocking=False)
    bench.files.side_effect = BadInput("a file expected, none found; choose another")
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
    bench.selection.extend("add", "cogging")
    bench.send(*views_sent)
    bench.jobs.cancel()
    assert message in bench.jobs.message
    assert bench.jobs.current is None


def test_lost_worker_is_reported_and_the_analysis_can_be_resumed(bench: Bench) -> None:
    bench.selection.extend("add", "cogging")
    bench.send(steps_view("new"), SERIES, WorkerEnd("The worker process has ended."))
    assert bench.jobs.message == "The worker process has ended."
    assert bench.jobs.current is None
    bench.selection.go()
    assert bench.tasks[-1] == "show", "there is a way on"


def test_only_changes_by_the_user_are_worth_a_question() -> None:
    bench = Bench()
    bench.selection.fit()
    bench.complete("base")
    assert not bench.selection.has_changes
    bench.selection.extend("add", "stribeck")
    bench.complete("added")
    bench.selection.go(undo)
    assert bench.selection.has_changes, "redo would be lost"


def test_a_model_of_the_folder_is_a_branch(bench: Bench) -> None:
    bench.recordings.model = lambda name: Path(name)
    bench.selection.fit("fig5a.model.json")
    opened = bench.complete("opened")
    history = bench.selection.history
    assert history
    assert (history.made, history.undo) == (opened, 1), "the way back leads to what was shown before"


def test_progress_is_that_of_the_last_time(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("ident.workbench.worker.jobs.time", SimpleNamespace(monotonic=lambda: now))
    said = []
    bench.jobs.durations.clear()
    for seconds, error in ((8.0, "no such effect"), (10.0, None), (4.0, None), (9.0, None)):
        bench.jobs.submit("adding", lambda view: None, "add")
        now += seconds
        assert bench.jobs.current
        said.append(bench.jobs.current.progress)
        bench.send(TaskEnd(error))
    assert said == ["8 s", "10 s", "4 s, 40%, about 6 s left", "9 s"]


def test_page_asks_for_no_fit_while_one_goes_on() -> None:
    bench = Bench()
    seen = []
    for action in (lambda: None, bench.selection.fit, bench.jobs.cancel):
        before = bench.changes.count(("series", "made"))
        action()
        seen.append((bench.selection.is_fitting, bench.changes.count(("series", "made")) > before))
    assert seen == [(False, False), (True, True), (False, True)]
