"""Long tables become wide, whatever the order of their rows, and others stay as they are."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.errors import BadInput
from recordings.importing.long_tables import widened
from recordings.importing.table import Table

N = 40
TIME = np.arange(N) * 0.01
JOINTS = ("left", "right", "rear")
Q = np.column_stack([np.sin((k + 1) * TIME) for k in range(3)])
TAU = 10 * Q


def table(columns: dict[str, np.ndarray]) -> Table:
    """As the formats read it: text is labels."""
    numbers = {name: values.astype(float) for name, values in columns.items() if values.dtype.kind != "U"}
    texts = {name: values for name, values in columns.items() if values.dtype.kind == "U"}
    return Table(Path("a.csv"), numbers, {"q": "deg"}, invalid=dict.fromkeys(texts, "text"), labels=texts)


def rows(key: np.ndarray) -> dict[str, np.ndarray]:
    return {"time": np.repeat(TIME, 3), "joint": np.tile(key, N), "q": Q.ravel(), "tau": TAU.ravel()}


@given(st.randoms(use_true_random=False), st.booleans(), st.integers(0, 30))
def test_rows_in_any_order_become_a_column_per_joint(random: object, text: bool, lost: int) -> None:
    columns = rows(np.array(JOINTS) if text else np.array([0, 1, 2]))
    order = list(range(3 * N))
    random.shuffle(order)  # type: ignore[attr-defined]
    kept = np.array(order[lost:])
    wide = widened(table({name: values[kept] for name, values in columns.items()}))
    names = JOINTS if text else ("1", "2", "3")
    assert set(wide.columns) == {"time", *(f"{value}_{name}" for value in ("q", "tau") for name in names)}
    expected = np.full((N, 3), np.nan)
    expected.ravel()[kept] = Q.ravel()[kept]
    present = np.isfinite(expected).any(axis=1)
    np.testing.assert_array_equal(wide.column("time"), TIME[present])
    np.testing.assert_array_equal(np.column_stack([wide.column(f"q_{name}") for name in names]), expected[present])
    assert wide.units == {f"q_{name}": "deg" for name in names}
    assert wide.notes[-1].startswith("a row for each time and joint")


def test_a_column_may_say_the_quantity_as_well() -> None:
    stacked = np.stack([Q, TAU], axis=2)
    columns = {
        "time": np.repeat(TIME, 6),
        "axis": np.tile(np.repeat([1, 2, 3], 2), N),
        "variable": np.tile(np.array(["position", "effort"]), 3 * N),
        "value": stacked.ravel(),
    }
    wide = widened(table(columns))
    for joint in range(3):
        np.testing.assert_array_equal(wide.column(f"position_{joint + 1}"), Q[:, joint])
        np.testing.assert_array_equal(wide.column(f"effort_{joint + 1}"), TAU[:, joint])


def test_joints_with_times_of_their_own_are_interpolated() -> None:
    columns = rows(np.array([1, 2, 3]))
    columns["time"] = columns["time"] + np.tile([0, 0.001, 0.002], N)
    wide = widened(table(columns))
    np.testing.assert_array_equal(wide.column("time"), TIME)
    np.testing.assert_allclose(wide.column("q_3")[1:], Q[1:, 2], atol=0.01)
    assert "interpolated" in wide.notes[-1]


def test_a_joint_that_stands_twice_is_refused() -> None:
    columns = {name: np.insert(values, 5, values[4]) for name, values in rows(np.array([1, 2, 3])).items()}
    with pytest.raises(
        BadInput, match=r"row 6: one row for each time and joint expected, joint 2 at 0\.01 twice found"
    ):
        widened(table(columns))


@pytest.mark.parametrize(
    "columns",
    [
        {"time": TIME, "q": Q[:, 0], "state": np.array(["run", "stop"] * (N // 2))},
        {"time": TIME, "q": Q[:, 0], "joint": np.repeat([1, 2], N // 2)},
        {"time": np.repeat(TIME[: N // 2], 2), "q": Q[:, 0]},
        {"q": Q[:, 0], "joint": np.tile([1, 2], N // 2)},
        {"time": TIME, "position_1": Q[:, 0], "name": np.tile([0, 1], N // 2)},
    ],
)
def test_other_tables_stay(columns: dict[str, np.ndarray]) -> None:
    same = table(columns)
    assert widened(same) is same
