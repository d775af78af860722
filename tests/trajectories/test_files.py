"""Trajectory files: CSV points and TOML Fourier series."""

from pathlib import Path

import numpy as np
import pytest

from recordings.config import read_toml
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import simulated_rig
from trajectories import load
from trajectories.files import read_motion
from trajectories.fourier import FourierSeries
from trajectories.kinematics import forward

RIG = simulated_rig()


def helix(time: Floats) -> Floats:
    phase = 2 * np.pi * time / 3
    return np.column_stack([0.1 * np.cos(phase), 0.1 * np.sin(phase), -0.7 + 0.05 * np.sin(2 * phase)])


def write_csv(path: Path, time: Floats, points: Floats, header: str = "time,x,y,z") -> Path:
    np.savetxt(path, np.column_stack([time, points]), delimiter=",", header=header, comments="")
    return path


@pytest.mark.parametrize("spread", [0.0, 0.5])
def test_closed_csv_repeats_and_follows_the_curve_also_through_uneven_samples(spread: float, tmp_path: Path) -> None:
    gaps = np.random.default_rng(1).uniform(1 - spread, 1 + spread, 80)
    time = np.concatenate([[0], np.cumsum(gaps)]) * 3 / gaps.sum()
    trajectory = load(write_csv(tmp_path / "helix.csv", time + 5, helix(time)), RIG)
    assert (trajectory.name, trajectory.period, trajectory.cycles) == ("helix.csv", pytest.approx(3.0), 7)
    assert trajectory.platform[trajectory.repeat == 0] == pytest.approx(helix(np.arange(1500) / 500), abs=1e-5)


def test_csv_with_joint_columns_is_a_joint_motion(tmp_path: Path) -> None:
    time = np.linspace(0, 2, 41)
    angles = 0.3 * np.sin(np.pi * time[:, None] + np.arange(3))
    trajectory = load(write_csv(tmp_path / "joints.csv", time, angles, "time,joint_1,joint_2,joint_3"), RIG)
    expected = 0.3 * np.sin(np.pi * np.arange(1000)[:, None] / 500 + np.arange(3))
    assert trajectory.joint_position[trajectory.repeat == 0] == pytest.approx(expected, abs=1e-6)
    assert forward(RIG.geometry, trajectory.joint_position) == pytest.approx(trajectory.platform, abs=1e-12)


@pytest.mark.parametrize("joints", [1, 2, 6])
def test_csv_has_a_column_for_each_joint(joints: int, tmp_path: Path) -> None:
    time = np.linspace(0, 2, 41)
    header = ",".join(["time", *(f"joint_{joint + 1}" for joint in range(joints))])
    path = write_csv(tmp_path / "joints.csv", time, np.sin(np.pi * time[:, None] + np.arange(joints)), header)
    motion = read_motion(path)
    assert (motion.space, motion.sample(time)[0].shape) == ("joint", (41, joints))


def test_spreadsheet_marks_and_blank_lines_are_tolerated(tmp_path: Path) -> None:
    time = np.linspace(0, 3, 61)
    plain = write_csv(tmp_path / "plain.csv", time, helix(time))
    marked = tmp_path / "marked.csv"
    marked.write_bytes(b"\xef\xbb\xbf" + plain.read_bytes().replace(b"\n", b"\r\n") + b"\r\n\r\n")
    assert read_motion(marked).definition == read_motion(plain).definition


ROWS = "".join(f"{0.5 * i},{0.01 * i},0,-0.7\n" for i in range(8))
BAD_CSV: dict[str, tuple[str | bytes | None, str]] = {
    "none": (None, "does not exist; check the path"),
    "binary": (b"\x89MCAP0\r\n\xff\xfe", "text in UTF-8 expected"),
    "empty": ("", "line 1: a header row with the names of the columns expected"),
    "other header": (
        "t,x,y,z\n" + ROWS,
        "line 1: the header 'time,x,y,z' or 'time,joint_1,...,joint_n' expected, 't,x,y,z' found",
    ),
    "no joint": ("time\n" + "0\n1\n", "joint_n' expected, 'time' found"),
    "joints in another order": ("time,joint_2,joint_1\n0,0,0\n", "joint_n' expected, 'time,joint_2,joint_1' found"),
    "no header": (ROWS, "every column needs a name of its own"),
    "short": ("time,x,y,z\n0,0,0,-0.7\n1,0,0,-0.7\n", "at least 7 points expected, 2 found"),
    "only header": ("time,x,y,z\n", "at least 7 points expected, 0 found"),
    "text": ("time,x,y,z\n" + ROWS + "4,left,0,-0.7\n", "line 10, column 'x': a number expected, 'left' found"),
    "nan": ("time,x,y,z\n" + ROWS + "4,nan,0,-0.7\n", "line 10, column 'x': seconds, metres or radians below"),
    "empty cell": ("time,x,y,z\n" + ROWS + "4,,0,-0.7\n", "line 10, column 'x': seconds, metres or radians below"),
    "missing field": ("time,x,y,z\n0,0,0\n" + ROWS, "line 2: 4 cells as in the header expected, 3 found"),
    "extra field": ("time,x,y,z\n0,0,0,0,0\n" + ROWS, "line 2: 4 cells as in the header expected, 5 found"),
    "backwards": ("time,x,y,z\n" + ROWS + "3.5,0,0,-0.7\n", "line 10: time must increase from row to row, 3.5 s"),
}


@pytest.mark.parametrize(("content", "message"), BAD_CSV.values(), ids=BAD_CSV)
def test_bad_csv_is_refused(tmp_path: Path, content: str | bytes | None, message: str) -> None:
    path = tmp_path / "bad.csv"
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(BadInput) as caught:
        load(path, RIG)
    assert message in str(caught.value)


FOURIER = """
kind = "fourier"
space = "platform"
description = 'so "it" is'
period = 4
centre = [0.0, 0.0, -0.7]
cosine = [[0.1, 0.02], [0.0, 0.0], [0.0, 0.03]]
sine = [[0.0, 0.0], [0.1, 0.0], [0.02, 0.0]]
"""


def test_toml_file_is_read_as_fourier_series(tmp_path: Path) -> None:
    path = tmp_path / "series.toml"
    path.write_text(FOURIER)
    trajectory = load(path, RIG, cycles=2)
    phase = np.arange(2000) / 500 * np.pi / 2
    expected = 0.1 * np.cos(phase) + 0.02 * np.cos(2 * phase)
    assert trajectory.name == "series.toml"
    series = read_toml(path, FourierSeries, "trajectory file")
    path.write_text(series.as_toml())
    assert read_toml(path, FourierSeries, "trajectory file") == series
    assert trajectory.platform[trajectory.repeat == 1, 0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("period = 4", "period = -4", "'period'"),
        ("period = 4", "", "key 'period' is missing"),
        ("period = 4", "period = 4\nphase = 1", "unknown key 'phase'"),
        ('"platform"', '"tool"', "'space'"),
        ("[0.1, 0.0], [0.02, 0.0]]", "[0.1], [0.02, 0.0]]", "all of one length"),
        ("[0.0, 0.0, -0.7]", "[0.0, nan, -0.7]", "'centre.1'"),
    ],
)
def test_bad_toml_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "series.toml"
    path.write_text(FOURIER.replace(old, new))
    with pytest.raises(BadInput) as caught:
        load(path, RIG)
    assert message in str(caught.value)
