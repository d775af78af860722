import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers import canopen_setup
from recordings.errors import BadInput
from recordings.rig import Drive, simulated_rig


@pytest.mark.parametrize(
    ("rate", "period"),
    [(500, (2, -3)), (1000, (1, -3)), (200, (5, -3)), (400, (25, -4)), (250, (4, -3)), (4000, (25, -5))],
)
def test_interpolation_period(rate: float, period: tuple[int, int]) -> None:
    assert canopen_setup.interpolation_period(rate) == period


def test_period_that_the_object_cannot_hold_is_refused() -> None:
    with pytest.raises(BadInput, match="choose a rate such as"):
        canopen_setup.interpolation_period(333.0)


def test_pdo_map_is_written_switched_off() -> None:
    entries = canopen_setup.setup(simulated_rig(), Drive(node_id=5))
    rpdo = [(e.index, e.sub, e.value) for e in entries if e.index in (0x1400, 0x1600)]
    assert rpdo == [
        (0x1400, 1, 0x8000_0205),
        (0x1400, 2, 1),
        (0x1600, 0, 0),
        (0x1600, 1, 0x6040_0010),
        (0x1600, 2, 0x607A_0020),
        (0x1600, 0, 2),
        (0x1400, 1, 0x205),
    ]


@given(st.sampled_from([1, -1]), st.floats(-1, 1), st.floats(-2, 2))
def test_counts_of_an_angle(sign: int, zero: float, angle: float) -> None:
    drive = Drive(node_id=1, counts_per_turn=1000, gear=10.0, sign=sign, zero_offset=zero)
    counts = canopen_setup.joint_to_counts(drive, angle)
    assert drive.zero_offset + counts / drive.counts_per_radian == pytest.approx(angle, abs=1e-12)


def test_position_limits_are_ordered_for_a_drive_that_counts_backwards() -> None:
    entries = {(e.index, e.sub): e.value for e in canopen_setup.setup(simulated_rig(), Drive(node_id=1, sign=-1))}
    assert entries[0x607D, 1] < entries[0x607D, 2]
