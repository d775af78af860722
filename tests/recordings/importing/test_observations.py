"""What an import sees in the measurements."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from recordings.importing import Description, import_data
from recordings.importing.observations import Observation, observe

N, RATE = 4000, 250.0
TIME = np.arange(N) / RATE
RNG = np.random.default_rng(0)
ANGLE = np.sin(2 * np.pi * 0.5 * TIME) + 0.3 * np.sin(2 * np.pi * 1.3 * TIME)
SPEED = np.pi * np.cos(2 * np.pi * 0.5 * TIME) + 0.78 * np.pi * np.cos(2 * np.pi * 1.3 * TIME)
EFFORT = 3 * SPEED + RNG.normal(scale=0.1, size=N)


def seen(folder: Path, joints: str = "revolute", **columns: np.ndarray) -> dict[str, Observation]:
    """Observations by name; columns that are not given are those of a good recording."""
    table = {"time": TIME, "position_1": ANGLE, "effort_1": EFFORT} | columns
    rows = np.column_stack(list(table.values())).tolist()
    (folder / "a.csv").write_text("\n".join([",".join(table), *(",".join(map(repr, row)) for row in rows)]))
    (folder / "a.mcap").unlink(missing_ok=True)
    description = Description(mechanism="axes", joints=(joints,))  # type: ignore[arg-type]
    return {o.name: o for o in observe(import_data(folder / "a.csv", folder / "a.mcap", description))}


def warnings(observations: dict[str, Observation]) -> list[str]:
    return [name for name, observation in observations.items() if observation.level == "warning"]


def test_good_recording_gives_no_warning(tmp_path: Path) -> None:
    observations = seen(tmp_path, velocity_1=SPEED + RNG.normal(scale=0.05, size=N))
    assert warnings(observations) == []
    assert warnings(seen(tmp_path, "prismatic", position_1=57.3 * ANGLE)) == [], "slides may go far"
    assert observations["rate"].says.startswith("rate 250 Hz, even steps")


BAD: dict[str, tuple[dict[str, np.ndarray], str, str]] = {
    "slow": ({"time": TIME * 20}, "low-rate", "12.5 Hz is below 20 Hz"),
    "jitter": ({"time": TIME + RNG.uniform(0, 0.002, N)}, "jitter", "time steps vary by 2. %"),
    "rest": ({"position_1": np.full(N, 0.3)}, "joint-at-rest", "joint 1 does not move .0.3 throughout"),
    "degrees": ({"position_1": 57.3 * ANGLE}, "degrees", "position 1 spans 1.. rad: degrees are likely"),
    "turns": ({"position_1": 8 * ANGLE}, "beyond-a-turn", "reaches 10.* beyond one turn"),
    "factor 2": ({"velocity_1": 2 * SPEED}, "velocity", "velocity 1 is 2 times the derivative"),
    "sign": ({"velocity_1": -SPEED}, "velocity", "velocity 1 is -1 times the derivative"),
    "other velocity": ({"velocity_1": ANGLE}, "velocity", "velocity 1 is not the derivative of position 1"),
    "one way": ({"position_1": TIME + 0.1 * ANGLE}, "one-direction", "joint 1 moves in one direction only"),
    "one speed": ({"position_1": TIME + 1e-6 * ANGLE}, "one-speed", "joint 1 moves at one speed only"),
    "filtered": ({"effort_1": filtfilt(*butter(4, 0.2), EFFORT)}, "filtered", "effort holds hardly any noise above"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_seen(name: str, tmp_path: Path) -> None:
    columns, expected, says = BAD[name]
    observations = seen(tmp_path, **columns)
    assert observations[expected].level == "warning"
    assert re.search(says, observations[expected].says), observations[expected].says
    assert not (name == "rest" and "one-speed" in observations)


def test_outlying_angle_is_not_taken_for_degrees(tmp_path: Path) -> None:
    angle = ANGLE.copy()
    angle[[1000, 2000]] = 1e5, -1e5
    assert warnings(seen(tmp_path, position_1=angle)) == []


def test_gaps_and_resolution_are_noted(tmp_path: Path) -> None:
    time = TIME + (np.arange(N) > 500) * 0.5
    step = 2 * np.pi / 8192
    angle = np.rint(ANGLE / step) * step
    angle[7] = np.nan
    observations = seen(tmp_path, time=time, position_1=angle)
    assert observations["time-gaps"].says.startswith("1 gap in time, the longest 0.504 s")
    assert observations["gaps"].says == "position 1: 1 gap"
    assert observations["resolution"].says == "resolution of position: 0.000767 rad"


@given(st.integers(2, 30), st.integers(0, 1000))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=25)
def test_no_recording_is_too_odd_to_be_looked_at(tmp_path: Path, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.choice([0.0, 1.0, np.nan, 1e6, -3.0, 1e-200], size=(count, 3)) * [1, 1000, 1000]
    values[0] = 1.0
    time = np.cumsum(rng.choice([1e-6, 1.0, 1e3], size=count))
    columns = dict(zip(("position_1", "effort_1", "velocity_1"), values.T, strict=True))
    assert all(observation.says for observation in seen(tmp_path, time=time, **columns).values())
