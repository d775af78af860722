"""Heartbeats of one node are never taken for those of two, however late a host reads them."""

from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.presence import Presence

_PERIOD, _INTERVAL = 0.002, 0.1
"""Of cycles and of heartbeats [s]."""


def _second(phases: list[float], pauses: dict[int, float], interval: float = _INTERVAL, cycles: int = 1500) -> str:
    """What shows a second node, where nodes begin to send heartbeats at `phases` [s] and the host pauses [s]."""
    presence, now, due = Presence(1), 0.0, list(phases)
    for cycle in range(cycles):
        now += _PERIOD + pauses.get(cycle, 0.0)
        presence.begin_cycle(now, answered=True)
        while (earliest := min(due)) <= now:
            due[due.index(earliest)] += interval
            presence.hear(b"\x05", cycle, now)
        presence.end_cycle(cycle, answered=True)
    return presence.trouble


@given(
    st.floats(0, _INTERVAL),
    st.floats(0.8, 1.2),
    st.dictionaries(st.integers(0, 1499), st.floats(0, 0.2) | st.floats(0, 3), max_size=30),
)
def test_one_node_is_one_on_any_host(phase: float, drift: float, pauses: dict[int, float]) -> None:
    assert _second([phase], pauses, drift * _INTERVAL) == ""


@given(st.floats(0, _INTERVAL), st.floats(0, _INTERVAL), st.dictionaries(st.integers(0, 1499), st.floats(0, 0.05)))
def test_two_nodes_are_found(first: float, second: float, pauses: dict[int, float]) -> None:
    assert _second([first, second], pauses) != ""


def test_two_nodes_are_found_within_a_second_after_the_second_one_appears() -> None:
    assert _second([0.0, 2.0], {}, cycles=1000) == ""
    assert _second([0.0, 2.0], {}, cycles=1450) != ""
