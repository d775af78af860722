"""What a run with missing answers says of them."""

import pytest

from daq.cycle.progress import CycleProgress

RATE, CYCLES, DOF = 500.0, 710, 3


@pytest.mark.parametrize(
    ("lost", "missed", "late", "simulated", "said"),
    [
        (21, 0, 0, False, None),
        (0, 7, 0, False, None),
        (373, 0, 10, False, "373 of 2130 answers are missing (17.5%); the cycles were in time: check the cable"),
        (373, 0, 100, False, "the host was late in 100 cycles, missed 0: close other programs, lower --rate"),
        (0, 40, 0, False, "120 of 2250 answers are missing (5.3%); the host was late in 0 cycles, missed 40"),
        (
            373,
            0,
            0,
            True,
            "simulated drives need a computer with time to spare: close other programs, use --pace lockstep",
        ),
    ],
)
def test_many_missing_answers_are_told_with_the_likely_cause(
    lost: int, missed: int, late: int, simulated: bool, said: str | None
) -> None:
    lateness = [0.5 / RATE] * late + [0.1 / RATE] * (CYCLES - late)
    progress = CycleProgress(cycles=CYCLES, lost=lost, missed=missed, lateness=lateness)
    told = progress.loss(RATE, DOF, simulated=simulated)
    assert (told is None) == (said is None)
    assert said is None or said in str(told)
