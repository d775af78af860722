"""Comparison on the simulated rig: how well it follows fig5b without, and with a model as feed-forward."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ident.data.following_error import Following, following
from ident.identification.model_file import ModelFile
from ident.output.figures.following import over_time
from ident.workbench import plots
from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.plots import Figure
from ident.workbench.recording_process import RecordingProcess, RunStatus
from ident.workbench.topics import Changes
from recordings.errors import BadInput
from recordings.reader import read

MOTION = "fig5b"
_CYCLES = "2"
WITHOUT, WITH = "without feed-forward", "with the model"


@dataclass(frozen=True, eq=False)
class ComparisonResult:
    """Two runs of the same motion."""

    model: ModelFile
    files: tuple[str, str]
    """Recordings without and with the model's torque."""
    runs: tuple[Following, Following]
    """In the same order."""
    figure: Figure
    """Following error of both over time."""


class FeedforwardComparison:
    """Records twice, one after the other; STOP ends a recording, and the comparison with it."""

    def __init__(self, folder: Folder, recorder: RecordingProcess, changes: Changes) -> None:
        self._folder, self._recorder, self._changes = folder, recorder, changes
        self.results: list[ComparisonResult] = []
        """Comparisons of this session."""
        self.state: str | None = None
        """What is being done; None between two comparisons."""
        self.problem: str | None = None
        """Why the last one was not completed."""

    def of(self, model: ModelFile) -> ComparisonResult | None:
        """Return the last comparison with `model`."""
        return next((result for result in reversed(self.results) if result.model is model), None)

    def start(self, model: ModelFile, model_name: str, machine: Mapping[str, str]) -> None:
        """Record without feed-forward, then with `model`, which is saved as `model_name`.

        machine: `--sim` and `--hidden` of `daq record`.

        Raises:
            BadInput: a recording is in progress, or cannot be started.
        """
        options = {"--traj": MOTION, "--cycles": _CYCLES, "--pace": "lockstep", **machine}
        names = [self._folder.free_name(f"{MOTION}-{kind}", SUFFIX) for kind in ("plain", "feedforward")]
        plain, fed = (self._folder.new_file(name, SUFFIX) for name in names)

        def record_with_model(run: RunStatus) -> None:
            if self._ended_early(run):
                return
            try:
                self._recorder.start({**options, "--feedforward": model_name}, fed, evaluate)
                self._show(f"Recording {MOTION} {WITH} …")
            except (BadInput, OSError) as error:
                self._end(str(error))

        def evaluate(run: RunStatus) -> None:
            if not self._ended_early(run):
                self._compare(model, (plain, fed))

        self._recorder.start(options, plain, record_with_model)
        self.problem = None
        self._show(f"Recording {MOTION} {WITHOUT} …")

    def _ended_early(self, run: RunStatus) -> bool:
        if run.exit_code != 0:
            self._end(f"{run.name} ended early: {run.reason}")
        return run.exit_code != 0

    def _compare(self, model: ModelFile, files: tuple[Path, Path]) -> None:
        try:
            recordings = [read(path) for path in files]
            first, second = map(following, recordings)
            figure = plots.to_dict(over_time(dict(zip((WITHOUT, WITH), recordings, strict=True))))
            names = (files[0].name, files[1].name)
            self.results.append(ComparisonResult(model, names, (first, second), figure))
            self._end(None)
        except BadInput as error:
            self._end(str(error))

    def _show(self, state: str) -> None:
        self.state = state
        self._changes.mark("use", "folder")

    def _end(self, problem: str | None) -> None:
        self.state, self.problem = None, problem
        self._changes.mark("use", "folder")
