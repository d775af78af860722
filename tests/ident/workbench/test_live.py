"""The live view distinguishes simulated drives from drives of a rig file, and shows the units of the rig."""

from pathlib import Path

import pytest

from ident.workbench.pages.live import has_plots, live_figures, run_summary
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


def test_only_what_moves_has_plots_and_a_jog_at_its_end() -> None:
    row = {"time": 0.0, "position": [0.1]}
    recorded, jog = RunStatus(SIMULATED, Path("run.mcap")), RunStatus(("daq", "jog"), None)
    assert not has_plots(recorded), "nothing has come yet"
    for run in (recorded, jog):
        run.rows.append(row)
    assert has_plots(recorded)
    assert not has_plots(jog)
    jog.exit_code = 0
    assert has_plots(jog)
    assert not has_plots(RunStatus(("daq", "axis-check"), None, exit_code=0)), "it prints a table"


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
