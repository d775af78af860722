"""The summary of a run distinguishes simulated drives from drives of a rig file."""

from pathlib import Path

import pytest

from ident.workbench.pages.live import run_summary
from ident.workbench.recording_process import RunStatus

SIMULATED = ("daq", "record", "--traj", "fig5a")
REAL = (*SIMULATED, "--rig", "bench.toml")


@pytest.mark.parametrize(
    ("command", "code", "message", "expected"),
    [
        (SIMULATED, 1, "error: SIGTERM received", "The simulated drives were disabled"),
        (REAL, 1, "error: SIGTERM received", "The drives were disabled"),
        (REAL, 1, "error: bus-off; disabling NOT CONFIRMED", "NOT CONFIRMED."),
        (SIMULATED, -9, "", "Its simulated drives ended with it."),
        (REAL, -9, "", "CHECK THE DRIVES"),
    ],
)
def test_summary_of_an_ended_run(command: tuple[str, ...], code: int, message: str, expected: str) -> None:
    run = RunStatus(command, Path("run.mcap"), exit_code=code)
    run.messages.append(message)
    assert expected in run_summary(run)
