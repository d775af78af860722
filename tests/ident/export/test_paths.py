"""Paths: trajectories, tables, recordings; in chunks or at once."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.estimation.predicted_torque import TorquePredictor
from ident.export import paths
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Axis, Rig, simulated_rig
from tests.ident.kept_models import MODELS
from trajectories import library

RIG = simulated_rig()


@pytest.fixture(scope="module")
def model() -> Model:
    return ident.load_model(MODELS / "stateful.model.json")


def table(path: Path, columns: dict[str, Floats]) -> Path:
    np.savetxt(path, np.column_stack(list(columns.values())), "%.12g", ",", header=",".join(columns), comments="")
    return path


def joints(name: str, values: Floats) -> dict[str, Floats]:
    return {f"{name}_{joint}": column for joint, column in enumerate(values.T, start=1)}


@pytest.mark.parametrize("kind", ["position", "joint", "platform", "all"])
def test_a_table_of_positions_gives_the_motion_of_the_trajectory(kind: str, tmp_path: Path) -> None:
    streamed = library.load("fig5b", RIG, 1, 500.0)
    columns = {"time": streamed.time + 3.0}
    if kind == "platform":
        columns |= dict(zip("xyz", streamed.platform.T, strict=True))
    else:
        columns |= joints("joint" if kind == "joint" else "position", streamed.joint_position)
    if kind == "all":
        columns |= joints("velocity", streamed.joint_velocity) | joints("acceleration", streamed.joint_acceleration)
    path = paths.from_table(table(tmp_path / "path.csv", columns), RIG)
    assert path.rate == pytest.approx(500.0)
    assert path.time[0] == 3.0
    np.testing.assert_allclose(path.motion.position, streamed.joint_position, atol=1e-9)
    np.testing.assert_allclose(path.motion.velocity, streamed.joint_velocity, atol=1e-5)
    np.testing.assert_allclose(path.motion.acceleration, streamed.joint_acceleration, atol=0.02)


def test_a_joint_at_rest_has_no_direction(tmp_path: Path) -> None:
    time = np.arange(400) / 500
    position = np.tile([0.1, 0.2, 0.3], (400, 1)) + 1e-12 * np.random.default_rng(0).standard_normal((400, 3))
    path = paths.from_table(table(tmp_path / "rest.csv", {"time": time} | joints("position", position)), RIG)
    assert not path.motion.direction.any()


def test_chunks_give_the_torque_of_the_whole(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    path = paths.from_trajectory("fig5b", RIG, 2, 250.0)
    motion = path.motion
    whole = model.torque(motion.position, motion.velocity, motion.acceleration, 1 / 250.0, path.time)
    monkeypatch.setattr(paths, "CHUNK_ROWS", 700)
    chunks = list(path.chunks())
    assert len(chunks) == 3
    parts = [model.dynamics.torque(chunk.inputs_of(model.dynamics))[chunk.used] for chunk in chunks]
    np.testing.assert_allclose(np.concatenate(parts), whole, atol=1e-6)
    np.testing.assert_array_equal(np.concatenate([chunk.time[chunk.used] for chunk in chunks]), path.time)


def test_growing_friction_ends_with_the_path_and_not_with_a_chunk(monkeypatch: pytest.MonkeyPatch) -> None:
    path = paths.from_trajectory("fig5b", RIG, 1, 250.0)
    monkeypatch.setattr(paths, "CHUNK_LENGTH", 500)
    model = ident.load_model(MODELS / "lad.model.json")
    ends = {chunk.inputs_of(model.dynamics).end for chunk in path.chunks()}
    assert ends == {path.time[-1]}


def test_a_recording_has_the_torque_that_is_compared_with_it(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    file = write(make(cycles=1, rate=250.0, path=tmp_path / "a.mcap"))
    for name in ("stateful", "stribeck"):
        loaded = ident.load_model(MODELS / f"{name}.model.json")
        path = paths.from_recording(file, loaded.file)
        (chunk,) = path.chunks()
        torque = loaded.dynamics.torque(chunk.inputs_of(loaded.dynamics))[chunk.used]
        dynamics = loaded.dynamics
        expected = TorquePredictor(path.prepared).unfiltered(dynamics.structure, dynamics.values)
        assert np.isfinite(expected).mean() > 0.8
        np.testing.assert_allclose(torque, expected, rtol=1e-9, atol=1e-9)


def _swap(columns: dict[str, Floats], name: str, row: int, value: float) -> dict[str, Floats]:
    changed = columns | {name: columns[name].copy()}
    changed[name][row] = value
    return changed


GOOD = {"time": np.arange(20) / 100} | joints("position", np.full((20, 3), 0.1))


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({name: column for name, column in GOOD.items() if name != "time"}, "a column 'time'"),
        (
            {name: column for name, column in GOOD.items() if name != "position_2"},
            "position_3 or x, y, z",
        ),
        (_swap(GOOD, "time", 7, 0.0755), r"line 9, column 'time': even steps expected"),
        (_swap(GOOD, "time", 7, 0.02), r"even steps expected"),
        (_swap(GOOD, "position_3", 4, np.nan), r"line 6, column 'position_3': a number expected"),
        (_swap(GOOD, "position_1", 5, -3.0), r"line 7: the joint angles tear the mechanism apart"),
        ({name: column[:4] for name, column in GOOD.items()}, "at least 6 rows"),
        ({"time": GOOD["time"]} | dict.fromkeys("xyz", np.full(20, 5.0)), r"line 2: limb 3 cannot reach"),
    ],
)
def test_a_table_that_is_no_path_is_refused_with_its_line(
    columns: dict[str, Floats], message: str, tmp_path: Path
) -> None:
    with pytest.raises(BadInput, match=message):
        paths.from_table(table(tmp_path / "path.csv", columns), RIG)


def test_axes_have_no_platform(tmp_path: Path) -> None:
    rig = Rig(name="bench", mechanism="axes", axes=(Axis(),))
    file = table(tmp_path / "path.csv", {"time": np.arange(20) / 100, "position_1": np.full(20, 9.0)})
    assert paths.from_table(file, rig).motion.position.shape == (20, 1)
    with pytest.raises(BadInput, match="position_1 expected"):
        paths.from_table(table(tmp_path / "p.csv", {"time": np.arange(20) / 100, "x": np.zeros(20)}), rig)
