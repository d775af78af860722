"""The memory of a worker is measured on a recording as long as asked for, and only if it could be analysed."""

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.fleet import memory, plan, record
from recordings.errors import RunFailed

pytestmark = pytest.mark.slow


def test_long_recording_is_analysed_in_a_worker(tmp_path: Path) -> None:
    record.make(tmp_path, replace(plan.draw(1, 1, 1, events=0), missing=frozenset(), faults={}))
    (recording,) = tmp_path.rglob("*.mcap")
    result = CliRunner().invoke(memory.main, [str(recording), "--seconds", "30"], catch_exceptions=False)
    assert result.output.startswith("30 s, ")
    assert result.output.endswith(" MiB in a worker with 2 GiB\n")


def test_recording_that_cannot_be_analysed_is_an_error() -> None:
    with pytest.raises(RunFailed, match="30 s: start: a date expected, 1970-01-01 found"):
        CliRunner().invoke(memory.main, ["recordings/samples/fig5a.mcap", "--seconds", "30"], catch_exceptions=False)
