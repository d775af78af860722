"""Events of a fleet: all that are there, at their dates, and none by chance, season or motion."""

from typing import Any

import numpy as np

from ident.fleet.discoveries import Event, e_bh
from recordings.recording import Floats
from tests.ident.fleet.conftest import events_of, rows_of, series_of

NIGHTS = 30


def scatter(seed: int, size: float = 0.01) -> Floats:
    return np.random.default_rng(seed).normal(0, size, NIGHTS)


def since(night: int) -> Floats:
    return (np.arange(NIGHTS) >= night).astype(float)


def search(values: dict[str, dict[str, Floats]], **options: Any) -> list[Event]:
    rows = [row for robot, of_robot in values.items() for row in rows_of(robot, of_robot, **options)]
    return events_of(series_of(rows)[1])


def test_quiet_fleet_has_no_events() -> None:
    fleet = {
        f"r{robot}": {f"c_c{joint}": 1 + scatter(10 * robot + joint) for joint in (1, 2, 3)} for robot in range(12)
    }
    assert search(fleet) == []


def test_event_of_one_robot_unites_its_series_and_names_the_strongest_first() -> None:
    fleet = {f"r{robot}": {"c_c1": 1 + scatter(robot), "c_v1": 1 + scatter(50 + robot)} for robot in range(4)}
    fleet["r2"]["c_c1"] += 0.5 * since(17)
    fleet["r2"]["c_v1"] -= 0.1 * since(17)
    (event,) = search(fleet)
    assert event.robot == "r2"
    assert event.change.index == 17
    assert [each.name for each in event.changes] == ["c_c1", "c_v1"]


def test_two_events_of_one_robot_are_both_found() -> None:
    first, second = search({"r1": {"c_c1": 1 + scatter(1) + 0.4 * since(9) - 0.6 * since(20)}})
    assert (first.change.index, second.change.index) == (9, 20)


def test_temperature_and_motion_explain() -> None:
    temperature = 20 + 8 * np.sin(np.arange(NIGHTS) / 10)
    warm = np.exp(-0.02 * (temperature - 20)) * (1 + scatter(2))
    assert search({"r1": {"c_v1": warm}}, temperature=temperature) == []
    assert len(search({"r1": {"c_v1": warm * (1 + 0.3 * since(15))}}, temperature=temperature)) == 1
    motion = [[4.0, 0.5] if night < 15 else [4.0, 0.8] for night in range(NIGHTS)]
    assert search({"r1": {"c_v1": 1 + scatter(3) + 0.3 * since(15)}}, motion=motion) == []


def test_change_within_the_intervals_is_none() -> None:
    tiny = 1 + scatter(4, 1e-5)
    assert search({"r1": {"c_c1": tiny + 5e-4 * since(15)}}) == []
    assert len(search({"r1": {"c_c1": tiny + 5e-2 * since(15)}})) == 1


def test_two_nights_are_too_few_for_an_alarm() -> None:
    assert search({"r1": {"c_c1": 1 + scatter(5) + 3 * since(NIGHTS - 2)}}) == []


def test_nights_since_a_repair_are_a_new_baseline() -> None:
    values = 1 + scatter(6) + 0.4 * since(9) - 0.4 * since(16) + 0.4 * since(24)
    _, series = series_of(rows_of("r1", {"c_c1": values}))
    repaired = series[0].nights.day[16] - 0.5
    assert [event.change.index for event in events_of(series)] == [9, 16, 24]
    assert [event.change.index for event in events_of(series, {"r1": [repaired]})] == [9, 24]


def test_e_bh_takes_the_largest_set_that_is_large_enough() -> None:
    log_e = np.log([1e4, 3e2, 250.0, 1.0])
    assert e_bh(log_e, 4) == [0, 1, 2]  # 250 of at least 4 / (3 * 0.01)
    assert e_bh(np.log([300.0, 1.0, 1.0, 1.0]), 4) == []
    assert e_bh([], 0) == []
