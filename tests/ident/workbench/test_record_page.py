"""What the page says of a run is true of simulated drives and of those of a rig file."""

from pathlib import Path

import pytest

from ident.workbench.pages.record import run_summary
from ident.workbench.recorder import RunStatus

SIMULATED = ("daq", "record", "--traj", "fig5a")
REAL = (*SIMULATED, "--rig", "bench.toml")


@pytest.mark.parametrize(
    ("command", "code", "said", "expected"),
    [
        (SIMULATED, 1, "error: SIGTERM received", "The simulated drives were disabled"),
        (REAL, 1, "error: SIGTERM received", "The drives were disabled"),
        (REAL, 1, "error: bus-off; disabling NOT CONFIRMED", "NOT CONFIRMED."),
        (SIMULATED, -9, "", "The simulated drives with it."),
        (REAL, -9, "", "LOOK AT THE DRIVES"),
    ],
)
def test_how_a_run_ended(command: tuple[str, ...], code: int, said: str, expected: str) -> None:
    run = RunStatus(command, Path("run.mcap"), exit_code=code)
    run.messages.append(said)
    assert expected in run_summary(run)
