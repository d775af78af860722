"""The cases of the payload benchmark."""

from benchmarks.payload import COUNT, CYCLES, instant


def test_instants_hold_the_middle_and_the_seams() -> None:
    instants = [instant(number) for number in range(COUNT)]
    assert {CYCLES / 2, *range(1, CYCLES)} <= set(instants)
    assert len(set(instants)) >= COUNT - 1
    assert min(instants) > 0
    assert max(instants) < CYCLES
