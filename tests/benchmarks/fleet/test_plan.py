"""A planned fleet is the same for the same seed, and its events leave a baseline."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.fleet import plan


@given(st.integers(0, 50), st.integers(2, 12), st.integers(12, 40))
def test_events_leave_a_baseline_and_reach_their_size(seed: int, robots: int, nights: int) -> None:
    drawn = plan.draw(seed, robots, nights, events=2)
    assert len({event.robot for event in drawn.events}) == 2
    for event in drawn.events:
        assert min(10, nights // 3) <= event.night < nights
        assert event.share(event.night - 1, nights) == 0.0
        assert event.share(nights - 1, nights) == 1.0
        shares = [event.share(night, nights) for night in range(nights)]
        assert np.all(np.diff(shares) >= 0)
    assert drawn.events[1].effect == plan.EXCHANGED_DRIVE
    assert all(abs(error) <= 3.0 for error in drawn.clock.values())
    again = plan.draw(seed, robots, nights, events=2)
    assert again.events == drawn.events
    np.testing.assert_array_equal(again.temperature, drawn.temperature)


def test_outside_effects_take_turns() -> None:
    count = len(plan.OUTSIDE)
    assert [event.effect for event in plan.draw(1, count, 20, count, outside=True).events] == list(plan.OUTSIDE)
