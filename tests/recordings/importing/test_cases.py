"""Files as people have them, after reports about other programs: never a wrong number without a word."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing import Description, Imported, converted
from recordings.importing.proposal import propose
from recordings.recording import Floats

RATE = 250.0
N = 500
TIME = np.arange(N) / RATE
EPOCH = 1_767_600_000


def axis(k: int, time: Floats = TIME) -> tuple[Floats, Floats, Floats]:
    """Position, velocity and torque (n,) of joint `k`."""
    phase = 3 * time + 0.4 * k
    return 0.6 * np.sin(phase), 1.8 * np.cos(phase), np.cos(phase) + 0.1 * k


def write(folder: Path, head: Sequence[str] | str, columns: Sequence[Sequence[object]], delimiter: str = ",") -> Path:
    lines = [head if isinstance(head, str) else delimiter.join(head)] if head else []
    lines += [delimiter.join(map(str, row)) for row in zip(*columns, strict=True)]
    path = folder / "data.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def accepted(path: Path) -> Imported:
    """What `daq import --guess --yes --mechanism axes --kt 1` imports; raises BadInput with what it asks for."""
    proposal = propose(path, ["--mechanism", "axes", "--kt", "1"])
    if proposal.missing:
        raise BadInput("\n".join([*proposal.missing, proposal.command]))
    words = proposal.arguments
    mapping = [words[k + 1] for k, word in enumerate(words) if word == "--map"]
    torque = {"per_ampere": [1.0]} if any("current_1" in entry for entry in mapping) else None
    return converted(path, Description(mechanism="axes", torque=torque), mapping)


def test_joints_have_one_unit_told_by_the_one_that_decides(tmp_path: Path) -> None:
    """KUKA's log says no units; A3 hardly moves, A1 rests."""
    q, _, tau = axis(0)
    angles = [0 * q, -90 + 69 * q, 90 + 5 * q]
    stamps = [f"2026-01-05 08:00:{t:09.6f}" for t in TIME]
    counter = (4208163634 + 4 * np.arange(N)).tolist()
    names = ["Timestamp", "IPOC", *(f"Receive.AI{kind}.A{k}" for kind in ("Pos", "MACur") for k in (1, 2, 3))]
    samples = accepted(write(tmp_path, names, [stamps, counter, *angles, tau, 2 * tau, 3 * tau])).samples
    np.testing.assert_allclose(samples.position, np.deg2rad(angles).T)
    np.testing.assert_allclose(samples.stamp / 1e9, TIME, atol=1e-6)


@pytest.mark.parametrize("rows", [1200, 9000])
def test_a_rate_of_two_units_is_asked_for(rows: int, tmp_path: Path) -> None:
    time = np.arange(rows) / 10
    q, _, tau = axis(0, time)
    path = write(tmp_path, "t,q,tau", [time, q, tau])
    with pytest.raises(BadInput, match=r"which may be s or ms(.|\n)*time=t:UNIT"):
        accepted(path)


def test_a_counter_is_no_time_and_sec_and_nanosec_are_one(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    stamp = 250_000_000 + np.rint(TIME * 1e9).astype(np.int64)
    columns = [range(1000, 1000 + N), EPOCH + stamp // 10**9, stamp % 10**9, q, tau]
    imported = accepted(write(tmp_path, "seq,secs,nsecs,position,effort", columns))
    np.testing.assert_allclose(imported.samples.stamp / 1e9, TIME, atol=1e-9)
    assert imported.run.start == "2026-01-05T08:00:00.250+00:00"
    assert "seq" in imported.samples.extra


def test_a_counter_alone_is_asked_for(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    with pytest.raises(BadInput, match="no column increases as time does"):
        accepted(write(tmp_path, ",q,tau", [range(N), q, tau]))


def test_time_of_two_columns_without_names_is_proposed(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    stamp = np.rint(TIME * 1e9).astype(np.int64)
    path = write(tmp_path, "", [EPOCH + stamp // 10**9, stamp % 10**9, ["left"] * N, q, tau])
    assert "--map 'time=#1:s+#2:ns'" in propose(path).command
    mapping = ["time=#1:s+#2:ns", "position_1=#4", "effort_1=#5"]
    samples = converted(path, Description(mechanism="axes"), mapping).samples
    np.testing.assert_allclose(samples.stamp / 1e9, TIME, atol=1e-9)


def test_names_with_indices_are_lists_also_where_they_stand_twice(tmp_path: Path) -> None:
    """libfranka's log: seven joints, q_d twice, and a time in ms that only the speeds tell."""
    seven = [axis(k, np.arange(N) / 1000) for k in range(7)]
    groups = {"q": 0, "q_d": 0, "dq": 1, "tau_J": 2}
    head = ["duration", *(f"{name}[{k}]" for name in (*groups, "q_d") for k in range(7))]
    columns = [joint[place] for place in (*groups.values(), 0) for joint in seven]
    samples = accepted(write(tmp_path, head, [range(52817000, 52817000 + N), *columns])).samples
    for found, place in ((samples.position, 0), (samples.velocity, 1), (samples.effort, 2)):
        np.testing.assert_allclose(found, np.column_stack([joint[place] for joint in seven]))
    np.testing.assert_allclose(samples.stamp / 1e9, np.arange(N) / 1000, atol=1e-9)


@pytest.mark.parametrize(
    ("head", "cells"),
    [("time,position_1,Torque, Request,effort_1", 4), ("time,position_1", 4), ("time,position_1,effort_1", 6)],
)
def test_a_header_of_other_width_is_refused_with_both_counts(head: str, cells: int, tmp_path: Path) -> None:
    columns = [TIME, *[axis(k)[0] for k in range(cells - 1)]]
    with pytest.raises(BadInput, match=rf"line 1: names of {cells} columns.*{head.count(',') + 1} found"):
        accepted(write(tmp_path, head, columns))


def euro(values: Floats, digits: int) -> list[str]:
    return [f"{value:,.{digits}f}".translate(str.maketrans(",.", ".,")) for value in values]


def test_thousands_separators_are_read(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    columns = [euro(1000 * TIME, 0), euro(1e6 * np.rad2deg(q), 1), euro(1e6 * tau, 1)]
    samples = accepted(write(tmp_path, "Zeit [ms];Position [1e-3 mdeg];Moment [1e-3 mNm]", columns, ";")).samples
    np.testing.assert_allclose(samples.position[:, 0], q, atol=1e-8)
    np.testing.assert_allclose(samples.effort[:, 0], tau, atol=1e-6)


@pytest.mark.parametrize("mark", [".", ","])
def test_what_may_be_thousands_or_decimals_is_refused(mark: str, tmp_path: Path) -> None:
    counts = [f"{k + 900:,}".replace(",", mark) for k in range(N)]
    with pytest.raises(BadInput, match=f"'1{mark}000' found, which may have thousands separators as well"):
        accepted(write(tmp_path, "t [ms];position [counts/8192];tau", [range(N), counts, [1] * N], ";"))


def test_rows_of_topics_between_each_other_are_joined(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    rows = [(t, angle, "") for t, angle in zip(TIME, q, strict=True)]
    rows += [(t + 0.001, "", torque) for t, torque in zip(TIME, tau, strict=True)]
    columns = list(zip(*sorted(rows), strict=True))
    imported = accepted(write(tmp_path, "time,/joint/position,/joint/effort", columns))
    np.testing.assert_allclose(imported.samples.position[:, 0], q)
    np.testing.assert_allclose(imported.samples.effort[1:, 0], np.interp(TIME, TIME + 0.001, tau)[1:])
    assert any("rows of several topics stand between each other" in note for note in imported.notes)


def test_a_topic_that_is_silent_leaves_a_gap_also_where_stamps_are_equal(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    rows = [(t, angle, "") for t, angle in zip(TIME, q, strict=True)]
    rows += [(t, "", torque) for t, torque in zip(TIME, tau, strict=True) if not 1 < t < 1.4]
    columns = list(zip(*sorted(rows, key=lambda row: row[0]), strict=True))
    effort = accepted(write(tmp_path, "time,/joint/position,/joint/effort", columns)).samples.effort[:, 0]
    np.testing.assert_array_equal(np.isnan(effort), (TIME > 1) & (TIME < 1.4))


@pytest.mark.parametrize(
    ("name", "change", "expected", "kind"),
    [
        ("set back", lambda t: np.where(t > 1, t - 0.51, t), TIME, "clock-set-back"),
        ("to zero", lambda t: np.where(t > 1, t - t[251], t + EPOCH), TIME, "clock-set-back"),
        ("16 bits", lambda t: (t * 1e3 + 65000) % 2**16, TIME, "counter-wrapped"),
        ("32 bits", lambda t: (t * 1e6 + 2**32 - 9e5) % 2**32, TIME, "counter-wrapped"),
        ("first 0", lambda t: np.where(t == 0, 0, t + EPOCH), TIME[1:] - TIME[1], "clock-set-back"),
    ],
)
def test_a_clock_that_jumps_is_continued_and_named(
    name: str, change: object, expected: Floats, kind: str, tmp_path: Path
) -> None:
    q, _, tau = axis(0)
    unit = {"16 bits": "ms", "32 bits": "us"}.get(name, "s")
    cells = [f"{value:.6f}" for value in np.round(change(TIME), 6)]  # type: ignore[operator]
    imported = accepted(write(tmp_path, f"t [{unit}],q,tau", [cells, q, tau]))
    np.testing.assert_allclose(imported.samples.stamp / 1e9, expected, atol=2e-6)
    (problem,) = imported.healed
    assert (problem.kind, problem.blocks) == (kind, False)
    assert "line " in problem.why


@pytest.mark.parametrize("late", [0.0, 1e-6])
@pytest.mark.parametrize("every", [1, 2])
def test_rows_that_stand_twice_are_taken_once(late: float, every: int, tmp_path: Path) -> None:
    rows = np.sort(np.concatenate([np.arange(len(TIME)), np.arange(0, len(TIME), every)]))
    time = TIME[rows] + late * np.append(False, np.diff(rows) == 0)
    columns = [[f"{value:.6f}" for value in time], *(values[rows] for values in axis(0)[::2])]
    path = write(tmp_path, "t [s],q,tau,row", [*columns, np.arange(len(rows))])
    imported = accepted(path)
    np.testing.assert_allclose(imported.samples.stamp / 1e9, TIME, atol=1e-6)
    (problem,) = imported.healed
    assert (problem.kind, problem.blocks) == ("repeated-rows", False)
    assert f"{len(rows) - len(TIME)} rows stand twice" in problem.why


def test_two_values_at_one_time_are_refused(tmp_path: Path) -> None:
    q, _, tau = axis(0)
    with pytest.raises(BadInput, match=r"line 4, column 't': a time after 0\.\d+ s expected"):
        accepted(write(tmp_path, "t [s],q,tau", [np.append(TIME[:2], TIME[1:-1]), q, tau]))


def test_a_wrong_time_among_right_ones_is_refused_with_its_line(tmp_path: Path) -> None:
    cells = TIME.copy()
    cells[200] = 99.0
    q, _, tau = axis(0)
    with pytest.raises(BadInput, match=r"line 203, column 't': a time after 99\.0 s expected"):
        accepted(write(tmp_path, "t [s],q,tau", [cells, q, tau]))
