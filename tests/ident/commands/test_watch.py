"""`ident watch` as a user types it, and as `daq record --watch` starts it."""

import json
import sys
from functools import partial
from pathlib import Path
from subprocess import PIPE, Popen

import pytest

from ident.program import program
from tests.ident.conftest import write_recording
from tests.ident.watch.test_watching import ONSET, changed, friction, record
from tests.running import ran

run = partial(ran, program)
IDENT = [sys.executable, "-c", "from ident.cli import main; main()"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a model, the recording it was validated with, a healthy one, and one with a change."""
    folder = tmp_path_factory.mktemp("watched")
    for name, recording in {
        "train": record(1, 6, shape=1),
        "valid": record(2),
        "well": record(3, 4),
        "worn": changed(worn := record(4), friction(worn, 0.4)),
    }.items():
        object.__setattr__(recording, "path", folder / f"{name}.mcap")
        write_recording(recording)
    run("fit", folder / "train.mcap", "--validate", folder / "valid.mcap", "--method", "ls")
    (folder / "train.model.json").rename(folder / "m.json")
    return folder


def test_healthy_robot_against_the_recording_of_the_validation(folder: Path) -> None:
    result = run("watch", folder / "m.json", folder / "well.mcap")
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert len(lines) == 16
    assert set(lines[0]) == {"time", "delay", "residual_rms", "floor_rms", "alarm"}


def test_alarm_of_a_stream_from_stdin(folder: Path) -> None:
    command = [*IDENT, "watch", str(folder / "m.json"), "-", "--healthy", str(folder / "valid.mcap")]
    with Popen(command, stdin=PIPE, stdout=PIPE) as process:
        output, _ = process.communicate((folder / "worn.mcap").read_bytes())
    assert process.returncode == 3
    (alarm,) = (line for line in map(json.loads, output.splitlines()) if line["alarm"])
    assert alarm["time"] > alarm["alarm"]["since"] > ONSET - 4
    assert alarm["alarm"]["joints"] == [2]


def test_file_that_is_not_there_yet_is_followed(folder: Path) -> None:
    path = folder / "coming.mcap"
    command = [*IDENT, "watch", str(folder / "m.json"), str(path), "--follow", "--samples", "10"]
    with Popen(command, stdout=PIPE) as process:
        content = (folder / "well.mcap").read_bytes()
        with path.open("wb") as file:
            for start in range(0, len(content), 10_000):
                file.write(content[start : start + 10_000])
                file.flush()
        output, _ = process.communicate()
    assert process.returncode == 0
    lines = [json.loads(line) for line in output.splitlines()]
    assert len(lines) == 16
    assert {"time", "measured", "model", "residual", "terms"} == set(lines[-1]["samples"])
