"""`daq home` on simulated drives: one joint searches, the others hold, all end disabled."""

from typing import Any

import pytest

from daq.commissioning.homing import Homed, home
from daq.simulation import simulated
from drivers.simulated.config import SimConfig
from drivers.simulated.service import Service
from recordings.config import validated
from recordings.errors import BadInput, RunFailed
from recordings.rig import Rig, simulated_rig

HABITS = {"habits": {"referenced": False, "referenced_mask": 0x8000, "home_distance": 0.01}}
HOMED = {"homed": {"index": 0x6041, "mask": 0x8000}}


def rig_with(*drives: dict[str, Any], **changes: Any) -> Rig:
    keys = [{"node_id": i, **drive} for i, drive in enumerate(drives, start=1)]
    bus = {"interface": "virtual", "channel": "homing"}
    return validated(
        simulated_rig().model_dump(mode="json") | {"drives": keys, "rate": 100.0, "bus": bus} | changes, Rig, "rig"
    )


def run(
    rig: Rig, joints: list[int], again: bool = False, habits: dict[str, Any] = HABITS
) -> tuple[list[Homed], Service]:
    config = validated({"drives": [habits]}, SimConfig, "sim file")
    with simulated(rig, config, "lockstep", 0) as machine:
        try:
            return list(home(rig, joints, "lockstep", lambda *line: None, again=again)), machine
        finally:
            assert not any(machine.machine.enabled)


def test_each_drive_is_homed_as_the_rig_file_says() -> None:
    rig = rig_with({"homing": {"method": 18, "speed": 0.1}, **HOMED}, {"homing": {"method": 35}}, {})
    outcomes, _ = run(rig, [1, 2, 3])
    assert [outcome.method for outcome in outcomes] == [18, 35, None]
    assert "absolute encoder" in outcomes[2].reason
    start = outcomes[1].position  # joint 2 did not move
    assert outcomes[0].position - start == pytest.approx(0.01, abs=2e-3)


def test_drive_that_has_its_reference_is_homed_only_again() -> None:
    rig, habits = rig_with({"homing": {"method": 35}, **HOMED}, {}, {}), {"habits": {"referenced_mask": 0x8000}}
    assert "--again" in run(rig, [1], habits=habits)[0][0].reason
    assert run(rig, [1], again=True, habits=habits)[0][0].method == 35


@pytest.mark.parametrize(
    ("homing", "habits", "error", "reason"),
    [
        ({"method": 17}, {"values": {"6099:1": 0}}, RunFailed, "homing error"),
        ({"method": 17, "speed": 0.01, "timeout": 0.2}, HABITS["habits"], RunFailed, r"not homed within 0\.2 s"),
        ({"method": 17}, {"values": {"6502": 0xC0}}, BadInput, "no mode 6"),
    ],
)
def test_homing_that_fails_ends_disabled(
    homing: dict[str, Any], habits: dict[str, Any], error: type[Exception], reason: str
) -> None:
    with pytest.raises(error, match=reason):
        run(rig_with({"homing": homing}, {}, {}), [1], habits={"habits": habits})
