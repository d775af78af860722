"""Comparison without and with feed-forward: two recordings in a row; a failure ends it with its reason."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

import pytest

from ident.workbench.feedforward_comparison import FeedforwardComparison
from ident.workbench.folder import Folder
from ident.workbench.recording_process import RunStatus
from ident.workbench.topics import Changes
from recordings.errors import BadInput

SAMPLE = Path(__file__).parents[3] / "recordings" / "samples" / "fig5b.mcap"
MODEL, OTHER = cast(Any, object()), cast(Any, object())


class Recorder:
    """Stands for the process that records; `end` ends it."""

    def __init__(self) -> None:
        self.runs: list[tuple[Mapping[str, str], Path, Callable[[RunStatus], None]]] = []
        self.refuses = False

    def start(self, options: Mapping[str, str], file: Path, then: Callable[[RunStatus], None]) -> None:
        if self.refuses:
            raise BadInput("no other recording expected, one is in progress; stop it first")
        self.runs.append((options, file, then))

    def end(self, exit_code: int = 0, message: str = "") -> None:
        _, file, then = self.runs[-1]
        if exit_code == 0:
            shutil.copy(SAMPLE, file)
        run = RunStatus(("daq",), file, exit_code=exit_code)
        run.messages.append(message)
        then(run)


@pytest.fixture
def recorder() -> Recorder:
    return Recorder()


@pytest.fixture
def comparison(tmp_path: Path, recorder: Recorder) -> FeedforwardComparison:
    return FeedforwardComparison(Folder.at(tmp_path), cast(Any, recorder), Changes())


def test_two_recordings_of_the_same_machine_are_compared(
    comparison: FeedforwardComparison, recorder: Recorder
) -> None:
    comparison.start(MODEL, "a.model.json", {"--hidden": "7"})
    assert "without" in (comparison.state or "")
    recorder.end()
    assert "with the model" in (comparison.state or "")
    recorder.end()
    assert comparison.state is None
    assert comparison.problem is None
    (plain, _, _), (fed, _, _) = recorder.runs
    assert fed == {**plain, "--feedforward": "a.model.json"}
    assert plain["--hidden"] == "7"
    result = comparison.of(MODEL)
    assert result is not None
    assert result.files == ("fig5b-plain.mcap", "fig5b-feedforward.mcap")
    assert result.runs[0].overall == result.runs[1].overall > 0
    assert len(result.figure["data"]) == 6
    assert comparison.of(OTHER) is None
    comparison.start(OTHER, "b.model.json", {})
    assert recorder.runs[-1][1].name == "fig5b-plain-2.mcap"


@pytest.mark.parametrize("failing", [1, 2])
def test_failure_ends_it_with_its_reason(comparison: FeedforwardComparison, recorder: Recorder, failing: int) -> None:
    comparison.start(MODEL, "a.model.json", {})
    if failing == 2:
        recorder.end()
    recorder.end(1, "error: stopped by SIGTERM")
    assert len(recorder.runs) == failing
    assert comparison.state is None
    assert "SIGTERM" in (comparison.problem or "")
    assert comparison.of(MODEL) is None


def test_recorder_that_refuses(comparison: FeedforwardComparison, recorder: Recorder) -> None:
    recorder.refuses = True
    with pytest.raises(BadInput):
        comparison.start(MODEL, "a.model.json", {})
    assert comparison.state is None
    recorder.refuses = False
    comparison.start(MODEL, "a.model.json", {})
    recorder.refuses = True
    recorder.end()
    assert "no other recording" in (comparison.problem or "")
