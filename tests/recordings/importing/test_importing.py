"""Import of CSV files: values, and error messages for invalid files."""

import json
from pathlib import Path

import numpy as np
import pytest

from daq.commands.import_ import command
from recordings.importing import Description, import_data
from recordings.importing.repetitions import mean_step
from recordings.reader import read
from tests.running import invoke, printed

AXES = Description(mechanism="axes")
NAN = np.nan
NO_DATE = "1970-01-01T00:00:00.000+00:00"


def imported(folder: Path, text: str, description: Description = AXES, mapping: tuple[str, ...] = ()) -> Path:
    (folder / "data.csv").write_bytes(text.encode())
    import_data(folder / "data.csv", out := folder / "data.mcap", description, mapping)
    return out


def test_repetitions_are_detected_without_a_cycle_column(tmp_path: Path) -> None:
    """The time steps are uneven, so the motion repeats only between the samples."""
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.002, 0.006, size=4000))
    angle = np.sin(2 * np.pi * time / 2.0) + 0.5 * np.cos(2 * np.pi * 3 * time / 2.0)
    rows = "".join(f"{t!r},{x!r},1\n" for t, x in zip(time.tolist(), angle.tolist(), strict=True))
    recording = read(imported(tmp_path, "time,position_1,effort_1\n" + rows))
    assert recording.run.period == pytest.approx(2.0, abs=0.005)
    assert recording.run.cycles == int((time[-1] - time[0]) / 2.0)
    begin = [recording.time[np.argmax(recording.repeat == k)] for k in range(recording.run.cycles)]
    np.testing.assert_allclose(np.diff(begin), 2.0, atol=0.012)
    np.testing.assert_allclose(recording.time, time - time[0], atol=1e-9)


TABLES: dict[str, tuple[str, Description, tuple[str, ...], dict[str, list[float]]]] = {
    "gaps, cycles and other columns": (
        "\ufefftime, position_1 ,effort_1,velocity_1,cycle,temperature\r\n"
        "10,1,2,,1,20.5\r\n10.5,,3,0.1,1,\r\n11.25,3,NaN,0.2,4,21\r\n",
        Description(mechanism="axes", joints=("prismatic",)),
        (),
        {
            **{"time": [0, 0.5, 1.25], "position": [1, NAN, 3], "effort": [2, 3, NAN], "velocity": [NAN, 0.1, 0.2]},
            **{"voltage": [NAN] * 3, "repeat": [0, 0, 1], "extra temperature": [20.5, NAN, 21]},
        },
    ),
    "efforts before currents": (
        "time,position_1,current_1,effort_1\n0,1,2,3\n0.1,1.5,-1,4\n",
        AXES,
        (),
        {"effort": [3, 4], "extra current_1": [2, -1]},
    ),
    "mapped columns": (
        "t;q;i;T;position_1\n0;90;1000;300;7\n10;180;;301;8\n",
        Description(mechanism="axes", torque={"per_ampere": [0.5]}, gravity=True),
        ("time=t:ms", "position_1=q:deg", "current_1=i:mA", "temperature_1=T:K"),
        {
            **{
                "time": [0, 0.01],
                "position": [np.pi / 2, np.pi],
                "effort": [0.5, NAN],
                "temperature": [26.85, 27.85],
            },
            **{"extra current_1": [1, NAN], "extra position_1 (not used)": [7, 8]},
        },
    ),
    "rows in the place of times": (
        "position_1,effort_1\n1,2\n2,3\n3,4\n",
        AXES,
        ("time=row:s*0.001",),
        {"time": [0, 0.001, 0.002]},
    ),
}
"""A file, what it is, its mapping, and the arrays of the recording, or its extra channels."""


@pytest.mark.parametrize("name", TABLES)
def test_columns_become_arrays(name: str, tmp_path: Path) -> None:
    text, description, mapping, expected = TABLES[name]
    recording = read(imported(tmp_path, text, description, mapping))
    for array, values in expected.items():
        kind, _, channel = array.partition(" ")
        found = recording.extra[channel] if channel else np.ravel(getattr(recording, kind))
        np.testing.assert_allclose(found, values, err_msg=array)
    assert (recording.complete, recording.run.reason) == (True, "imported from data.csv")
    assert (recording.rig.joint_types, recording.rig.axes[0].gravity) == (description.joints, description.gravity)
    assert recording.rig.torque.gain_source == "calibrated", (
        "efforts were measured, or the torque per ampere is known"
    )


def test_command_prints_a_summary_and_one_gain_stands_for_all_joints(tmp_path: Path) -> None:
    header = ",".join(f"{name}_{k}" for name in ("position", "voltage") for k in (1, 2))
    (tmp_path / "data.csv").write_text(f"time,{header}\n0,1,1,2,2\n0.1,1.5,1.5,2.5,2\n0.3,2,2,3,3\n")
    options = ["--mechanism", "axes", "--torque-map", "linear", "--gain", "2.5", "--kt", "0.5"]
    options += ["--start", "2026-01-05T09:00:00+01:00", "--robot", "r07"]
    result = invoke(command, tmp_path / "data.csv", *options, "--out", tmp_path / "a.mcap")
    assert "steps: 150 ms, from 100 ms to 200 ms" in result.stdout
    assert "cycles: none found" in result.stdout
    assert "torque gain" not in result.stderr, "it was given"
    figures = json.loads(printed(command, tmp_path / "data.csv", *options, "--out", tmp_path / "b.mcap", "--json"))
    assert (figures["samples"], figures["joints"], figures["cycles"], figures["gaps"]) == (3, 2, 0, [0, 0])
    recording = read(tmp_path / "b.mcap")
    torque, run = recording.rig.torque, recording.run
    assert (torque.map, torque.gain, torque.gain_source) == ("linear", (2.5, 2.5), "calibrated")
    assert torque.per_ampere == (0.5, 0.5)
    assert (run.start, run.robot) == (figures["start"], figures["robot"]) == ("2026-01-05T08:00:00.000+00:00", "r07")


@pytest.mark.parametrize(
    ("gap", "empty", "line"), [(0, 0, "none"), (4, 0, "in time"), (0, 2, "2"), (4, 1, "1; in time")]
)
def test_gaps_are_named_in_one_place_as_in_the_other(gap: float, empty: int, line: str, tmp_path: Path) -> None:
    rows = "".join(f"{0.01 * i + gap * (i > 9)!r},{'' if i < empty else i},1\n" for i in range(30))
    (tmp_path / "data.csv").write_text(f"time,position_1,effort_1\n{rows}")
    output = printed(command, tmp_path / "data.csv", "--out", tmp_path / "r.mcap", "--mechanism", "axes")
    assert f"gaps: {line}\n" in output
    assert ("1 gap in time, the longest 4.01 s" in output) == (gap > 0)


@pytest.mark.parametrize(
    ("times", "start"),
    [
        (("2026-01-05T08:00:00Z", "2026-01-05T08:00:00.5Z"), "2026-01-05T08:00:00.000+00:00"),
        (("1767600000", "1767600000.5"), "2026-01-05T08:00:00.000+00:00"),
        (("08:00:00", "08:00:00.5"), NO_DATE),
        (("5", "5.5"), NO_DATE),
    ],
)
def test_start_is_that_of_the_file(times: tuple[str, str], start: str, tmp_path: Path) -> None:
    recording = read(imported(tmp_path, f"time,position_1,effort_1\n{times[0]},1,2\n{times[1]},2,3\n"))
    assert recording.run.start == start
    np.testing.assert_array_equal(recording.time, [0, 0.5])


def test_short_recording_with_a_long_gap_is_not_searched_for_repetitions(tmp_path: Path) -> None:
    """The grid of the search would fill the memory."""
    recording = read(imported(tmp_path, "time,position_1,effort_1\n0,1,2\n1e-9,2,3\n2e-9,1,2\n2e9,2,3\n"))
    assert recording.run.period == 0


def test_columns_of_text_and_infinity_are_left_out_and_noted(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("time,position_1,effort_1,state,load\n0,1,2,on,inf\n1,2,3,off,2\n")
    result = import_data(tmp_path / "data.csv", tmp_path / "r.mcap", AXES)
    assert result.notes == ("left out, because not finite numbers throughout: state, load",)
    assert not read(tmp_path / "r.mcap").extra


@pytest.mark.parametrize("unit", [1, 10, 256, 1000, 100_000])
def test_rounded_times_do_not_change_the_step(unit: int) -> None:
    stamp = np.rint(np.arange(5000) * 2_000_000 / unit).astype(np.int64) * unit
    assert mean_step(stamp) == pytest.approx(2_000_000, rel=1e-5)


def test_a_gap_holds_several_steps() -> None:
    stamp = np.delete(np.arange(5000) * 2_000_000, slice(1000, 3500)) + np.random.default_rng(0).integers(
        0, 300, 2500
    )
    assert mean_step(stamp) == pytest.approx(2_000_000, rel=1e-6)
