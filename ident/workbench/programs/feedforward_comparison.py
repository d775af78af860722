"""Comparison on the simulated rig: how well it follows fig5b without, and with a model as feed-forward."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ident.data.following_error import Following, following
from ident.identification.model_file import ModelFile
from ident.output.figures.quality import following_errors
from ident.workbench.figure import Figure, to_dict
from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.programs.recording_process import RecordingProcess, RunStatus
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

        def record_with_model() -> None:
            self._recorder.start({**options, "--feedforward": model_name}, fed, self._then(compare))
            self._show(f"Recording {MOTION} {WITH} …")

        def compare() -> None:
            recordings = [read(path) for path in (plain, fed)]
            first, second = map(following, recordings)
            figure = to_dict(following_errors(dict(zip((WITHOUT, WITH), recordings, strict=True))))
            self.results.append(ComparisonResult(model, (plain.name, fed.name), (first, second), figure))
            self._show(None)

        self._recorder.start(options, plain, self._then(record_with_model))
        self._show(f"Recording {MOTION} {WITHOUT} …")

    def _then(self, go_on: Callable[[], None]) -> Callable[[RunStatus], None]:
        """Return what follows a recording: `go_on`, or the end of the comparison where something went wrong."""

        def follow(run: RunStatus) -> None:
            if run.exit_code != 0:
                self._show(None, f"{run.name} ended early: {run.reason}")
                return
            try:
                go_on()
            except (BadInput, OSError) as error:
                self._show(None, str(error))

        return follow

    def _show(self, state: str | None, problem: str | None = None) -> None:
        self.state, self.problem = state, problem
        self._changes.mark("use", "folder")
