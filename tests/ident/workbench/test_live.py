"""The live view distinguishes simulated drives from drives of a rig file, and shows the units of the rig."""

from pathlib import Path

import pytest

from ident.workbench.pages.live import live_figures, run_summary
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


def test_plots_of_a_prismatic_joint_are_in_metres() -> None:
    run = RunStatus(REAL, Path("run.mcap"), "m")
    run.rows.append({"time": 0.0, "position": [0.1], "following_error": [0.002], "voltage": [1.5]})
    titles = {kind: figure["layout"]["yaxis"]["title"]["text"] for kind, figure in live_figures(run).items()}
    assert titles == {
        "position": "position<br>[m]",
        "following error": "following error<br>[mm]",
        "voltage": "voltage<br>[V]",
        "lateness": "lateness<br>[ms]",
    }
