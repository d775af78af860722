"""Units of the simulated drive against figures worked out by hand: 8192 increments, gear 21."""

import math
from pathlib import Path

import pytest

from drivers.eds import load_dictionary
from drivers.simulated.drive_units import FactorGroup
from drivers.simulated.habits import Habits
from drivers.simulated.objects import Objects
from recordings.rig import Drive
from tests.drivers.simulated.dictionaries import I8, U8, U32, Item, eds

MOTOR = 21 / (2 * math.pi)
"""Motor turns per radian of the joint."""
INCREMENTS = 8192 * MOTOR


def units(folder: Path, values: dict[tuple[int, int], int]) -> FactorGroup:
    path = folder / "drive.eds"
    types = {0x608D: I8, 0x608E: U8}
    path.write_text(
        eds({(0x1000, 0): Item(U32)} | {a: Item(types.get(a[0], U32), default=v) for a, v in values.items()})
    )
    objects = Objects(load_dictionary(path, 1), Habits(), lambda address, value: None, 1, lambda *frame: None)
    return FactorGroup(objects, Drive(node_id=1))


def ratios(**pairs: tuple[int, int]) -> dict[tuple[int, int], int]:
    return {(int(index[1:], 16), sub + 1): pair[sub] for index, pair in pairs.items() for sub in (0, 1)}


@pytest.mark.parametrize(
    ("values", "position", "acceleration"),
    [
        ({}, 1.0, INCREMENTS),
        ({(0x60AA, 0): 0x00C00300}, 1.0, 60 * MOTOR),  # rpm/s
        ({(0x60AA, 0): 0xFDB44703}, 1.0, 60_000 * MOTOR),  # 0.001 rpm/s
        ({(0x60AA, 0): 0x00B45700}, 1.0, MOTOR),  # turns/s^2
        ({(0x60AA, 0): 0x00105700}, 1.0, 21.0),  # rad/s^2 of the motor
        ({(0x60AA, 0): 0x00415700} | ratios(x6091=(21, 1)), 1.0, 180 / math.pi),  # deg/s^2 of the shaft
        (ratios(x608F=(8192, 1), x6091=(21, 1), x6092=(360_000, 1)), 360_000 / 21 / 8192, 360_000 / (2 * math.pi)),
        (ratios(x608F=(1, 1), x6091=(1, 1), x6092=(1, 1)), 1.0, INCREMENTS),
        ({(0x60A8, 0): 0xFF410000}, 3600 / 8192, 3600 * MOTOR),  # 0.1 deg of the motor
        (ratios(x6093=(2, 1), x6097=(100, 1)), 0.5, INCREMENTS / 100),
        ({(0x608E, 0): 0xAE, (0x608D, 0): 3}, 1.0, 21e-3),  # 1000 rad/s^2 of the motor
    ],
)
def test_units(values: dict[tuple[int, int], int], position: float, acceleration: float, tmp_path: Path) -> None:
    of_drive = units(tmp_path, values)
    assert of_drive.position == pytest.approx(position)
    assert of_drive.acceleration == pytest.approx(acceleration)
