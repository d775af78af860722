"""State of the user's work: one session, shared by all browser tabs and kept when the page is reloaded."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ident.dynamics.effects.library import library
from ident.workbench import views
from ident.workbench.branches import Branches
from ident.workbench.cli_equivalent import effect_options
from ident.workbench.folder import Folder
from ident.workbench.recording_process import RecordingProcess
from ident.workbench.topics import LADDER_TOPICS, TOPIC_OF_VIEW, Job, Topic
from ident.workbench.views import SwarmRequest
from ident.workbench.worker import Worker
from recordings.errors import BadInput

UNATTENDED_TIMEOUT = 20.0
"""Time without a browser after which moving drives are stopped; long enough to reload the page [s]."""


class WorkbenchSession:
    """State behind the page. `versions` counts the changes of each topic."""

    def __init__(self, folder: Folder, effect_files: Sequence[Path] = ()) -> None:
        self.folder = folder
        self.library = library(effect_files)
        self.versions: Counter[Topic] = Counter()
        self.train: str | None = None
        self.validate: str | None = None
        self.tab = "data"
        self.joint = 0
        self.dark = False
        self.requested_span: tuple[str, float, float] | None = None
        """Span to be shown next: name of the recording, start and end [s]."""
        self.job: Job | None = None
        self.message = ""
        self.recording: views.RecordingView | None = None
        self.branches: Branches | None = None
        self.series: tuple[views.TorqueSeries, ...] = ()
        self.candidates: views.CandidateList | None = None
        self.previews: views.CandidatePreviews | None = None
        self.residuals: views.ResidualView | None = None
        self.diagnosis: views.DiagnosisView | None = None
        self.swarm_progress: views.SwarmProgress | None = None
        """Progress of the running swarm."""
        self.swarm_result: views.SwarmResult | None = None
        self.saved_model: tuple[str, views.ResidualView] | None = None
        """File name and view of the model that was saved last."""
        self._last_seen = 0.0
        self.recorder = RecordingProcess(
            folder.root,
            lambda: self.mark_changed("run"),
            lambda: self.mark_changed("run", "folder"),
            self._is_attended,
        )
        self._worker = Worker(self._on_message, effect_files)
        self._pending_tasks = 0
        """Number of tasks that the worker has not finished."""
        self._analysis_interrupted = False
        """Whether another task interrupted the analysis of the current ladder."""
        self._update_branches: Callable[[views.LadderView], Branches] = Branches.start
        """Maps the next ladder from the worker to the new branches."""

    @property
    def ladder(self) -> views.LadderView | None:
        """Return the current ladder."""
        return self.branches.current.ladder if self.branches else None

    def mark_changed(self, *topics: Topic) -> None:
        """Mark `topics` as changed; the pages that show them redraw."""
        self.versions.update(topics)

    def mark_seen(self) -> None:
        """Record that a browser shows the page now."""
        self._last_seen = time.monotonic()

    def _is_attended(self) -> bool:
        return time.monotonic() - self._last_seen < UNATTENDED_TIMEOUT

    def prepare(self) -> None:
        """Start the worker before the first click."""
        self._worker.prepare()

    def close(self) -> None:
        """Stop the recording and the worker."""
        self.recorder.close()
        self._worker.cancel()

    # Recordings

    def choose(self, train: str | None, validate: str | None) -> None:
        """Set the recordings to work with and discard all results of the previous ones."""
        for name in (train, validate):
            if name is not None:
                self.folder.existing_file(name)
        if train is not None and train == validate:
            raise BadInput(
                "another recording expected for validation, the training recording found; "
                "errors on training data are too optimistic"
            )
        self.train, self.validate = train, validate
        if self.job:
            self._stop_worker()
        self.recording = self.diagnosis = self.swarm_progress = self.swarm_result = None
        self._clear_ladder()
        self.mark_changed("folder", "job", "recording", "diagnosis", "swarm_progress", "swarm_result")
        if train is not None:
            self._submit_side_task("reading", False, "view_recording", *self._files())

    def _clear_ladder(self) -> None:
        self.branches = self.candidates = self.previews = self.residuals = None
        self.series = ()
        self.mark_changed(*LADDER_TOPICS)

    def show_recording(self, name: str) -> None:
        """Show a recording without a fit."""
        path = self.folder.existing_file(name)
        self._check_not_paused()
        self._submit_side_task("reading", False, "view_recording", path)

    # Model selection

    def fit(self) -> None:
        """Fit the base model."""
        self._submit_ladder_task(Branches.start, "fit", *self._files())

    def add(self, name: str) -> None:
        """Add an effect."""
        branches = self._require_branches()
        self._submit_ladder_task(branches.extended, "add", self._ladder_spec(branches), name)

    def remove(self, index: int) -> None:
        """Remove effect `index` (from 0) of the current model."""
        branches = self._require_branches()
        self._submit_ladder_task(branches.extended, "remove", self._ladder_spec(branches), index)

    def diagnose(self) -> None:
        """Run the full diagnosis."""
        branches = self._require_branches()
        self._submit_ladder_task(branches.extended, "diagnose", self._ladder_spec(branches))

    def undo(self) -> None:
        """Undo the last change."""
        self._show_branches(self._require_branches().undone())

    def redo(self) -> None:
        """Redo the change that was undone last."""
        self._show_branches(self._require_branches().redone())

    def fork(self) -> None:
        """Keep the current ladder as a branch and continue in a copy."""
        self._check_not_busy()
        self.branches = self._require_branches().forked()
        self.mark_changed("ladder")

    def switch(self, index: int) -> None:
        """Switch to another branch."""
        self._show_branches(self._require_branches().switched(index))

    def drop(self, index: int) -> None:
        """Drop a branch."""
        self._check_not_busy()
        self.branches = self._require_branches().dropped(index)
        self.mark_changed("ladder")

    def resume_analysis(self) -> None:
        """Resume the analysis of the current ladder after it was cancelled or interrupted."""
        self._show_branches(self._require_branches())

    def fit_whole_recording(self) -> None:
        """Fit the current model to entire long recordings, so that it can be saved."""
        self._check_not_busy()
        base, ladder = self._ladder_spec(self._require_branches()), self._require_branches().current.ladder
        self._stop_worker()  # a new process has enough memory; it rebuilds the ladder when needed
        self._submit_side_task("whole recording", True, "fit_whole_recording", base, ladder.bandwidth)

    def swarm(self, seed: int) -> None:
        """Fit the parameters of the current model, or of the base model, by particle swarm."""
        self._check_not_busy()
        effects = effect_options(self.ladder) if self.ladder else ()
        cutoff = self.ladder.bandwidth if self.ladder else None
        self._submit_side_task("swarm", True, "swarm", *self._files(), SwarmRequest(effects, cutoff, seed))

    def pause(self) -> None:
        """Pause the current job."""
        with self._worker.lock:
            if self.job and self.job.paused_at is None:
                self._worker.pause()
                self.job = replace(self.job, paused_at=time.monotonic())
                self.mark_changed("job")

    def resume(self) -> None:
        """Resume the paused job."""
        with self._worker.lock:
            if self.job and self.job.paused_at is not None:
                self.job = replace(self.job, start_time=time.monotonic() - self.job.seconds, paused_at=None)
                self._worker.resume()
                self.mark_changed("job")

    def cancel(self) -> None:
        """Cancel the current job; earlier results stay."""
        self._stop_worker()
        self._set_message("Cancelled; nothing has changed.")
        self._end_job()

    def _require_branches(self) -> Branches:
        if self.branches is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self.branches

    def _ladder_spec(self, branches: Branches) -> views.LadderSpec:
        return views.LadderSpec(*self._files(), tuple(step.spec for step in branches.current.ladder.steps))

    def _show_branches(self, branches: Branches) -> None:
        """Show the current ladder of `branches`."""
        self._submit_ladder_task(lambda ladder: branches, "show", self._ladder_spec(branches))

    def _files(self) -> tuple[Path, Path | None]:
        if self.train is None:
            raise BadInput("a training recording expected, none chosen; choose one with Train")
        return self.folder.existing_file(self.train), self.folder.existing_file(
            self.validate
        ) if self.validate else None

    def _submit_ladder_task(
        self, update_branches: Callable[[views.LadderView], Branches], task: str, *arguments: Any
    ) -> None:
        with self._worker.lock:
            self._check_not_busy()
            self._update_branches = update_branches
            self._begin_job(task, blocking=True)
            self._submit(task, *arguments)

    def _submit_side_task(self, text: str, blocking: bool, task: str, *arguments: Any) -> None:
        """Submit a task that leaves the ladder unchanged but may interrupt its analysis."""
        with self._worker.lock:
            self._analysis_interrupted = self.ladder is not None and self.residuals is None
            self._begin_job(text, blocking)
            self._submit(task, *arguments)

    def _check_not_busy(self) -> None:
        self._check_not_paused()
        if self.job and self.job.blocking:
            raise BadInput(f"no other job expected, '{self.job.text}' is in progress; wait for it, or cancel it")

    def _check_not_paused(self) -> None:
        if self.job and self.job.paused_at is not None:
            raise BadInput(f"no paused job expected, '{self.job.text}' is paused; resume or cancel it")

    def _submit(self, task: str, *arguments: Any) -> None:
        self._pending_tasks += 1
        self._worker.submit(task, *arguments)

    def _stop_worker(self) -> None:
        with self._worker.lock:
            self._worker.cancel()
            self._pending_tasks, self.job, self._analysis_interrupted = 0, None, False

    def _begin_job(self, text: str, blocking: bool) -> None:
        self.message = ""
        self.job = Job(text, time.monotonic(), blocking)
        self.mark_changed("job", "message")

    def _end_job(self) -> None:
        """Redraw the views that will not arrive any more; existing ones stay."""
        self.swarm_progress = None
        awaited: tuple[Topic, ...] = ("candidates", "residuals")
        self.mark_changed("job", "swarm_progress", *(topic for topic in awaited if getattr(self, topic) is None))

    # Messages from the worker

    def _on_message(self, kind: str, value: Any) -> None:
        if kind == "progress" and self.job:
            self.job = replace(self.job, text=value)
        elif kind == "view":
            self._store_view(value)
        elif kind in ("idle", "failed"):
            self._pending_tasks -= 1
            if self._pending_tasks <= 0:
                self._pending_tasks, self.job = 0, None
                self._worker.resume()  # it may have been paused just after its last message
            if kind == "failed":
                self._set_message(value)
                self._end_job()
            elif self.job is None and self._analysis_interrupted:
                self._analysis_interrupted = False
                self.resume_analysis()
        self.mark_changed("job")

    def _store_view(self, value: Any) -> None:
        if isinstance(value, views.LadderView):
            self.branches = self._update_branches(value)
            self.candidates = self.previews = self.residuals = None
            self.mark_changed("ladder", "candidates", "previews", "residuals")
        elif isinstance(value, views.Mismatch):
            self.validate = None
            self.mark_changed("folder")
            self._set_message(value.reason)
        elif isinstance(value, tuple):
            self.series = value
            if self.job:
                self.job = replace(self.job, blocking=False)
            self.mark_changed("series")
        else:
            topic = TOPIC_OF_VIEW[type(value)]
            setattr(self, topic, value)
            self.mark_changed(topic)
        if isinstance(value, views.SwarmResult):
            self.swarm_progress = None
            self.mark_changed("swarm_progress")

    def _set_message(self, text: str) -> None:
        self.message = text
        self.mark_changed("message")
