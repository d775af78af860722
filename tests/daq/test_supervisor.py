import math
from dataclasses import replace

from daq.supervisor import MAX_SILENCE, Supervisor
from drivers.protocol import Power, Sample
from recordings.rig import simulated_rig

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


def test_a_good_sample_passes() -> None:
    supervisor = Supervisor(simulated_rig())
    assert supervisor.drives(GOOD) is None
    assert supervisor.motion(GOOD, GOOD.position) is None


def test_following_error_names_the_joint_and_the_figures() -> None:
    supervisor = Supervisor(simulated_rig())
    reason = supervisor.motion(GOOD, (0.0, 0.1, 0.26))
    assert reason is not None
    assert reason.startswith("joint 3: following error 0.0600 rad, limit 0.05 rad")
    assert supervisor.worst_following_error > 0.0599


def test_a_lost_answer_is_borne_silence_is_not() -> None:
    supervisor = Supervisor(simulated_rig())
    for _ in range(3):
        for _ in range(MAX_SILENCE - 1):
            assert supervisor.drives(LOST) is None
            assert supervisor.motion(LOST, GOOD.position) is None
        assert supervisor.drives(GOOD) is None
    reasons = [supervisor.drives(LOST) for _ in range(MAX_SILENCE)]
    assert reasons[-2] is None
    assert reasons[-1] == f"joint 2: no answer for {MAX_SILENCE} cycles; check the cable and the drive"


def test_a_drive_that_leaves_operation_is_seen() -> None:
    reason = Supervisor(simulated_rig()).motion(replace(GOOD, power=(Power.ON, Power.OFF, Power.ON)), GOOD.position)
    assert reason == "joint 2: the drive left operation by itself (now off)"


def test_the_drives_own_words_come_first() -> None:
    assert Supervisor(simulated_rig()).drives(replace(LOST, trouble="joint 1: drive fault")) == "joint 1: drive fault"
