import math
from dataclasses import replace

import pytest

from daq.cycle.supervisor import Supervisor
from drivers.protocol import Power, Sample
from recordings.rig import simulated_rig

RIG = simulated_rig()

GOOD = Sample(
    position=(0.0, 0.1, 0.2),
    voltage=(1.0, 1.0, 1.0),
    statusword=(0x1237,) * 3,
    error_code=(0,) * 3,
    power=(Power.ON,) * 3,
    missing=0,
    trouble=None,
)
LOST = replace(GOOD, position=(0.0, math.nan, 0.2), missing=1)


def test_normal_sample_passes_all_checks() -> None:
    supervisor = Supervisor(RIG)
    assert supervisor.drives(GOOD) is None
    assert supervisor.motion(GOOD, GOOD.position) is None


def test_following_error_message_names_joint_error_and_limit() -> None:
    supervisor = Supervisor(RIG)
    reason = supervisor.motion(GOOD, (0.0, 0.1, 0.26))
    assert reason is not None
    assert reason.startswith("joint 3: following error 0.0600 rad, limit 0.05 rad")
    assert supervisor.worst_following_error > 0.0599


def test_drive_without_answers_is_reported_only_after_the_silence_limit() -> None:
    supervisor = Supervisor(RIG)
    for _ in range(3):
        for _ in range(24):
            assert supervisor.drives(LOST) is None
            assert supervisor.motion(LOST, GOOD.position) is None
        assert supervisor.drives(GOOD) is None
    reasons = [supervisor.drives(LOST) for _ in range(25)]
    assert reasons[-2] is None
    assert reasons[-1] == "joint 2: no answer for 50 ms; check the cable and the drive"


def test_fault_reported_by_the_drive_takes_precedence() -> None:
    assert Supervisor(RIG).drives(replace(LOST, trouble="joint 1: drive fault")) == "joint 1: drive fault"


def _follow(positions: list[float]) -> list[str | None]:
    """Move joint 1 through `positions` exactly as commanded; return the reason of each sample."""
    supervisor, samples = Supervisor(RIG), [replace(GOOD, position=(q, 0.1, 0.2)) for q in positions]
    return [supervisor.motion(sample, sample.position) for sample in samples]


def test_position_jump_is_reported() -> None:
    reasons = _follow([0.0, 0.01, 0.02, 0.2])
    assert reasons[:3] == [None] * 3
    assert reasons[3] == "joint 1: position jump of 0.1800 rad in 1 cycles, 0.0480 rad possible; check the encoder"


def test_motion_across_missing_answers_is_not_reported_as_a_jump() -> None:
    assert _follow([0.0, math.nan, math.nan, math.nan, math.nan, 0.06])[-1] is None


def test_mean_speed_above_the_limit_is_reported() -> None:
    step = 13.0 / RIG.rate
    reasons = _follow([k * step for k in range(8)])
    assert reasons[:4] == [None] * 4
    assert "joint 1: speed 13.00 rad/s, limit 12 rad/s" in reasons


NONE = math.nan


@pytest.mark.parametrize(
    ("volts", "effort", "stopped"),
    [
        (7.0, None, False),
        (8.0, None, True),
        (-8.0, None, True),
        (NONE, None, False),
        (NONE, (59.0, 0.0, 0.0), False),
        (NONE, (-61.0, 0.0, 0.0), True),
        (NONE, (NONE, 0.0, 0.0), False),
    ],
)
def test_torque_above_the_limit_for_ten_milliseconds_is_reported(
    volts: float, effort: tuple[float, ...] | None, stopped: bool
) -> None:
    supervisor, sample = Supervisor(RIG), replace(GOOD, voltage=(volts, 1.0, 1.0), effort=effort)
    reasons = [supervisor.motion(sample, sample.position) for _ in range(5)]
    assert reasons[:4] == [None] * 4
    assert (reasons[4] is not None and "joint 1: torque" in reasons[4]) == stopped


def test_joint_outside_its_range_is_reported_at_standstill() -> None:
    supervisor = Supervisor(RIG)
    assert supervisor.standstill((-1.2, 0.2, 1.4)) is None
    assert "joint 2 stands at 1.900 rad, -1.2 to 1.4 rad expected" in str(supervisor.standstill((0.2, 1.9, 0.2)))
