import math
from collections.abc import Iterable
from dataclasses import replace

import pytest

from daq.cycle.supervisor import Supervisor
from drivers.protocol import Power, Sample
from recordings.rig import Axis, Drive, Rig, Torque, simulated_rig

RIG = simulated_rig()
NONE = math.nan

GOOD = Sample(
    position=(0.0, 0.1, 0.2),
    voltage=(1.0, 1.0, 1.0),
    statusword=(0x1237,) * 3,
    error_code=(0,) * 3,
    power=(Power.ON,) * 3,
    missing=0,
    trouble=None,
)
LOST = replace(GOOD, position=(0.0, NONE, 0.2), missing=1)


@pytest.mark.parametrize(
    ("samples", "first", "reason"),
    [
        # Answers are missed for a while; then for as long as the limits permit.
        ([*[LOST] * 24, GOOD] * 3, None, ""),
        ([GOOD, *[LOST] * 25], 25, "joint 2: no answer for 50 ms; check the cable and the drive"),
        (
            [GOOD, *[replace(LOST, absence=("", "its TPDO is short", ""))] * 25],
            25,
            "joint 2: no valid answer for 50 ms: its TPDO is short;",
        ),
        # The drive's own reason is the better one.
        ([*[LOST] * 24, replace(LOST, trouble="joint 1: drive fault")], 24, "joint 1: drive fault"),
    ],
)
def test_silence_and_faults_of_drives_are_reported(samples: list[Sample], first: int | None, reason: str) -> None:
    supervisor = Supervisor(RIG)
    assert_reported([supervisor.drives(sample) for sample in samples], first, reason)


def assert_reported(reasons: list[str | None], first: int | None, reason: str) -> None:
    """The first of the reasons that is one comes at this index and begins with these words; None: there is none."""
    reported = [index for index, each in enumerate(reasons) if each is not None]
    assert reported[:1] == ([] if first is None else [first]), reasons
    assert first is None or str(reasons[first]).startswith(reason)


def moved(angles: Iterable[float]) -> list[Sample]:
    """Joint 1 at these angles [rad]."""
    return [replace(GOOD, position=(angle, 0.1, 0.2)) for angle in angles]


def loaded(volts: float, effort: tuple[float, ...] | None = None) -> list[Sample]:
    return [replace(GOOD, voltage=(volts, 1.0, 1.0), effort=effort)] * 5


@pytest.mark.parametrize(
    ("samples", "first", "reason"),
    [
        (
            moved([0.0, 0.01, 0.02, 0.2]),
            3,
            "joint 1: position jump of 0.1800 rad in 1 cycles, 0.0480 rad possible; check the encoder",
        ),
        (moved([0.0, NONE, NONE, NONE, NONE, 0.06]), None, ""),
        (moved(k * 13.0 / RIG.rate for k in range(8)), 5, "joint 1: speed 13.00 rad/s, limit 12 rad/s"),
        # Torque is judged over 10 ms; that of the voltage comes first.
        (loaded(7.0), None, ""),
        (loaded(8.0), 4, "joint 1: torque"),
        (loaded(-8.0), 4, "joint 1: torque"),
        (loaded(NONE), None, ""),
        (loaded(NONE, (59.0, 0.0, 0.0)), None, ""),
        (loaded(NONE, (-61.0, 0.0, 0.0)), 4, "joint 1: torque"),
        (loaded(NONE, (NONE, 0.0, 0.0)), None, ""),
    ],
)
def test_violation_in_a_motion_as_commanded_is_reported(
    samples: list[Sample], first: int | None, reason: str
) -> None:
    supervisor = Supervisor(RIG)
    assert_reported([supervisor.motion(sample, sample.position) for sample in samples], first, reason)


@pytest.mark.parametrize(
    ("lost", "then", "reason"),
    [
        (10, 1, "joint 2: no answer for 20 ms; check the cable and the drive (then joint 3: following error"),
        (10, 40, "joint 3: following error"),
        (2, 1, "joint 3: following error"),
        (0, 1, "joint 3: following error"),
    ],
)
def test_a_silence_comes_before_its_consequences(lost: int, then: int, reason: str) -> None:
    supervisor = Supervisor(RIG)
    for sample in [GOOD, *[LOST] * lost, *[GOOD] * then]:
        assert supervisor.drives(sample) is None
    assert str(supervisor.motion(GOOD, (0.0, 0.1, 0.26))).startswith(reason)


def test_the_longest_silence_is_named() -> None:
    """On a busy host others may have missed a few answers, too."""
    supervisor = Supervisor(RIG)
    late = replace(LOST, position=(NONE, NONE, 0.2), missing=2)
    for sample in [GOOD, *[LOST] * 5, *[late] * 5, GOOD]:
        assert supervisor.drives(sample) is None
    assert str(supervisor.after_silence("following error")).startswith("joint 2: no answer for 20 ms")


@pytest.mark.parametrize(
    ("missed", "then", "reason"),
    [
        (10, 1, "the host missed 10 cycles; close other programs (then joint 3: following error"),
        (10, 40, "joint 3: following error"),
        (2, 1, "joint 3: following error"),
    ],
)
def test_a_late_host_comes_before_its_consequences(missed: int, then: int, reason: str) -> None:
    supervisor = Supervisor(RIG)
    for count in (missed, *[0] * (then - 1)):
        supervisor.note_missed(count)
    assert str(supervisor.motion(GOOD, (0.0, 0.1, 0.26))).startswith(reason)


def test_following_error_and_a_joint_outside_its_range_are_named_with_value_and_limit() -> None:
    supervisor = Supervisor(RIG)
    reason = supervisor.motion(GOOD, (0.0, 0.1, 0.26))
    assert str(reason).startswith("joint 3: following error 0.0600 rad, limit 0.05 rad")
    assert supervisor.worst_following_error > 0.0599
    assert supervisor.standstill((-1.2, 0.2, 1.4)) is None
    assert "joint 2 stands at 1.900 rad, -1.2 to 1.4 rad expected" in str(supervisor.standstill((0.2, 1.9, 0.2)))


def test_a_prismatic_joint_is_told_in_metres() -> None:
    axes, drives = (Axis(type="prismatic"),), (Drive(node_id=1),)
    supervisor = Supervisor(Rig(name="slide", mechanism="axes", axes=axes, drives=drives, torque=Torque(gain=(1.0,))))
    assert "joint 1 stands at 1.900 m, -1.2 to 1.4 m expected" in str(supervisor.standstill((1.9,)))
    sample = Sample((0.1,), (1.0,), (0x1237,), (0,), (Power.ON,), 0, None)
    assert "following error 0.0600 m, limit 0.05 m" in str(supervisor.motion(sample, (0.16,)))
