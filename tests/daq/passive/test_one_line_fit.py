"""Drives on one line are read one after the other; a fit that knows the measurement times is better."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from recordings import blocks
from recordings.buses import SerialBus
from recordings.reader import read
from recordings.rig import Drive, Rig
from tests.conftest import Runner
from tests.daq.passive.listening import SAMPLE
from tests.daq.passive.wire_time import OneLine
from trajectories import load

RIG = Rig(name="one line", rate=80.0, bus=SerialBus(baud=460800), drives=tuple(Drive(node_id=i) for i in (1, 2, 3)))


def fitted(ident: Runner, file: Path) -> dict[str, Any]:
    # Residuals are compared in the same band.
    done = ident("fit", file, "--method", "ls", "--without", "rod_inertia", "--cutoff", "15")
    assert done.code == 0, done.err
    model: dict[str, Any] = json.loads(file.with_suffix(".model.json").read_text())
    return model


@pytest.mark.slow
def test_individual_measurement_times_reduce_the_residual(ident: Runner, tmp_path: Path) -> None:
    trajectory = load("fig5a", RIG, 4)
    samples = OneLine(RIG).run(trajectory)
    update = {"rate": RIG.rate, "cycles": 4, "pace": "realtime"}
    run = read(SAMPLE).run.model_copy(update=update)
    residual = {}
    for name, table in (("with_delays", samples), ("without_delays", replace(samples, extra={}))):
        blocks.write(tmp_path / f"{name}.mcap", RIG, run, table)
        model = fitted(ident, tmp_path / f"{name}.mcap")
        residual[name] = model["train"]["fitted"]["rms"]
        inertia = [parameter["value"] for parameter in model["parameters"] if parameter["name"].startswith("I_")]
        assert inertia == pytest.approx([0.225] * 3, rel=0.05)
    assert all(
        known < unknown for known, unknown in zip(residual["with_delays"], residual["without_delays"], strict=True)
    )
    # Joint 3 is read last.
    assert residual["with_delays"][2] < 0.75 * residual["without_delays"][2]
