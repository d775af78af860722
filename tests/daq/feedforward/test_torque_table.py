from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.feedforward.torque_table import read_torque_table
from recordings.errors import BadInput
from recordings.rig import simulated_rig

RIG = simulated_rig()
NAMES = ["time", *(f"{quantity}_{joint}" for quantity in ("position", "torque") for joint in (1, 2, 3))]
TIME = np.linspace(0, 1, 11)
ROWS = np.column_stack([TIME, *[0.1 * TIME] * 3, *[5 + TIME] * 3])


def table(folder: Path, rows: NDArray[np.float64] = ROWS, names: list[str] = NAMES) -> Path:
    path = folder / "torque.csv"
    np.savetxt(path, rows, "%.9g", ",", header=",".join(names), comments="")
    return path


def test_torque_between_the_rows_is_interpolated(tmp_path: Path) -> None:
    time = np.array([0.0, 0.25, 1.0])
    torque = read_torque_table(table(tmp_path), RIG).along(time, np.tile(0.1 * time[:, None], 3))
    np.testing.assert_allclose(torque[:, 0], [5.0, 5.25, 6.0])


def test_table_of_another_motion_is_refused(tmp_path: Path) -> None:
    read = read_torque_table(table(tmp_path), RIG)
    with pytest.raises(BadInput, match=r"joint 2 is 0\.0020 rad away from it at t = 1\.000 s"):
        read.along(TIME, np.tile(0.1 * TIME[:, None], 3) + np.outer(TIME == 1, [0, 0.002, 0]))
    with pytest.raises(BadInput, match=r"a table from 0 to 1\.1 s expected, as long as the motion, 0 to 1 s found"):
        read.along(1.1 * TIME, np.tile(0.1 * TIME[:, None], 3))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((3, 0, 9.0), "increasing times expected"),
        ((3, 5, np.nan), "line 5, column 'torque_2': a number expected, a gap found"),
        (
            (3, 6, -61.0),
            r"torque within ±60 N m expected \(limits.torque\), -61\.0 N m found for joint 3 at t = 0\.300",
        ),
    ],
)
def test_table_that_must_not_be_fed_forward_is_refused(
    tmp_path: Path, change: tuple[int, int, float], message: str
) -> None:
    rows = ROWS.copy()
    rows[change[0], change[1]] = change[2]
    with pytest.raises(BadInput, match=message):
        read_torque_table(table(tmp_path, rows), RIG)
    with pytest.raises(BadInput, match="no torque_3 found"):
        read_torque_table(table(tmp_path, ROWS[:, :-1], NAMES[:-1]), RIG)
