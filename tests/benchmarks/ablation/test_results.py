"""The file of results: what was tried is not tried again, and an interruption loses a line at most."""

from pathlib import Path

import pytest

from benchmarks.ablation.results import Results
from benchmarks.ablation.subjects import TODAY, Subject, Trial, VariantOutcome

VARIANTS = ("b.SHARE*2", "a.LIMIT/2", "a.LIMIT*2", "b.IDLE/2")


def _adequate() -> VariantOutcome:
    return VariantOutcome("adequate", 1)


ROBOT, AXIS = Subject("robot", _adequate), Subject("axis", _adequate)


def _watched(case: str, near: set[str], used: frozenset[str] = frozenset()) -> Trial:
    return Trial(case, TODAY, 2.0, VariantOutcome("missing-effect; cogging\t1", 10), frozenset(near), used)


@pytest.fixture
def results(tmp_path: Path) -> Results:
    found = Results(tmp_path / "results.tsv", "1a2b", VARIANTS)
    found.add(_watched("robot", {"b.SHARE*2", "a.LIMIT/2"}))
    found.add(_watched("axis", {"a.LIMIT/2"}, frozenset({"a.LIMIT/2", "a.LIMIT*2"})))
    return found


def _again(tmp_path: Path) -> Results:
    return Results(tmp_path / "results.tsv", "1a2b", VARIANTS)


def test_pairs_are_those_that_can_matter(results: Results) -> None:
    pairs = {pair.name for pair in results.todo([ROBOT, AXIS], 1)}
    assert pairs == {"robot b.SHARE*2", "robot a.LIMIT/2", "axis a.LIMIT/2", "axis a.LIMIT*2"}
    assert {pair.name for pair in results.todo([AXIS], 1)} == {"axis a.LIMIT/2", "axis a.LIMIT*2"}


def test_each_variant_is_tried_once_before_any_is_tried_twice(results: Results) -> None:
    first = [pair.variant for pair in results.todo([ROBOT, AXIS], 1)][:3]
    assert sorted(first) == sorted(VARIANTS[:3])


def test_what_was_tried_is_kept_and_not_tried_again(results: Results, tmp_path: Path) -> None:
    results.add(Trial("robot", "a.LIMIT/2", 1.5, VariantOutcome("adequate", 0)))
    results.add(Trial("axis", "a.LIMIT*2", 0.5, results.today["axis"].outcome))
    again = _again(tmp_path)
    assert (again.today, again.tried, again.seconds) == (results.today, results.tried, 2.0)
    assert {pair.name for pair in again.todo([ROBOT, AXIS], 1)} == {"robot b.SHARE*2", "axis a.LIMIT/2"}


def test_interrupted_line_is_dropped(results: Results, tmp_path: Path) -> None:
    path = tmp_path / "results.tsv"
    whole = path.read_text(encoding="utf-8")
    path.write_text(f"{whole}robot\ta.LIM", encoding="utf-8")
    assert _again(tmp_path).today == results.today
    assert path.read_text(encoding="utf-8") == whole


def test_results_of_other_sources_are_refused(results: Results, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="move the file away"):
        Results(tmp_path / "results.tsv", "ffff", VARIANTS)


def test_table_counts_what_changed_and_names_who_needs_it(results: Results) -> None:
    results.add(Trial("robot", "a.LIMIT/2", 1.0, VariantOutcome("adequate", 0)))
    results.add(Trial("axis", "a.LIMIT/2", 1.0, results.today["axis"].outcome))
    results.add(Trial("robot", "b.SHARE*2", 1.0, VariantOutcome("adequate", 11)))
    rows = [line.split() for line in results.table(1)]
    assert rows[0][1:9] == ["near", "used", "tried", "not", "tried", "changed", "better", "worse"]
    assert rows[1:] == [
        ["b.SHARE*2", "1", "0", "1", "0", "1", "1", "0"],
        ["a.LIMIT/2", "2", "0", "2", "0", "1", "0", "1", "robot"],
        ["a.LIMIT*2", "0", "1", "0", "1", "0", "0", "0"],
        ["in", "no", "case", "near", "or", "used:", "b.IDLE/2"],
    ]
