"""Name and seed of a case."""

from dataclasses import replace

from benchmarks.hidden_effects.cases import Case

CASE = Case("foreign", "single", ("stribeck",), (0.03,), "default", 2)


def test_tuned_case_is_named_by_its_robot_and_drawn_cases_by_their_part() -> None:
    assert CASE.name == "single-stribeck-3%-default-2"
    assert replace(CASE, part="chosen", robot="any").name == "chosen-single-stribeck-3%-2"
    assert replace(CASE, part="locked", digest="1a2b", robot="any").name == "locked-1a2b-single-stribeck-3%-2"


def test_seed_depends_on_part_and_digest() -> None:
    drawn = [replace(CASE, part="locked", digest=digest) for digest in ("1a2b", "3c4d")]
    assert len({CASE.seed, replace(CASE, part="chosen").seed, *(case.seed for case in drawn)}) == 4
