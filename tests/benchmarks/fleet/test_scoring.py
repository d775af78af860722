"""An alarm is right if robot, effect, joint and date are; another one is false."""

from typing import Any

from benchmarks.fleet import scoring

EVENT = {"robot": "r01", "effect": "stribeck", "joint": 2, "night": 12, "since": "2026-01-17", "growing": False}


def smallest(event: dict[str, Any]) -> float:
    """A tenth of the final size, which is reached after 20 nights."""
    assert event["nights"] - event["night"] == 20
    return 0.1


def scored(alarms: list[dict[str, Any]], event: dict[str, Any] = EVENT) -> tuple[scoring.Score, list[dict[str, Any]]]:
    (entry,), false = scoring.score({"events": [event], "nights": 32}, alarms, smallest)
    return entry, false


def alarm(**other: Any) -> dict[str, Any]:
    content = {
        "robot": "r01",
        "effect": "stribeck",
        "confusable_with": [],
        "joints": [2],
        "since": "2026-01-18",
        "since_ci95": ["2026-01-18", "2026-01-18"],
    }
    return {**content, **other}


def test_right_and_false_alarms() -> None:
    other = alarm(robot="r02")
    entry, false = scored([other, alarm()])
    assert entry.right
    assert entry.nights_off == 1
    assert false == [other]


def test_what_is_wrong() -> None:
    for content, wrong in (
        ({"effect": "cogging"}, "named"),
        ({"joints": [1]}, "joint"),
        ({"since": "2026-01-25"}, "dated"),
    ):
        entry, _ = scored([alarm(**content)])
        assert [name for name in ("raised", "named", "joint", "dated") if not getattr(entry, name)] == [wrong]
    assert scored([alarm(effect="cogging", confusable_with=["stribeck"])])[0].right
    assert not scored([])[0].raised


def test_growing_event_is_dated_before_it_is_twice_the_smallest_size() -> None:
    growing = {**EVENT, "growing": True}
    for since, dated in (("2026-01-14", False), ("2026-01-15", True), ("2026-01-20", True), ("2026-01-21", False)):
        assert scored([alarm(since=since)], growing)[0].dated is dated


def test_outside_effect_has_no_name_but_a_variable() -> None:
    event = {**EVENT, "effect": "tangled_cables", "joints": [2, 3], "outside": ["position", "joint_2", "joint_3"]}
    unknown = alarm(effect=None, joints=[3], depends_on=["joint_2", "position"])
    assert scored([unknown], event)[0].right
    assert not scored([{**unknown, "depends_on": ["load"]}], event)[0].named
    assert not scored([{**unknown, "effect": "joint_spring"}], event)[0].named
