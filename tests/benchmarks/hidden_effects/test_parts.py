"""The parts of the benchmark: each always the same cases, none in two parts, the first ones a sample of all."""

from collections import Counter

import pytest

from benchmarks.hidden_effects.cases import (
    ADDED,
    COMMAND_ONLY,
    VOLTAGE_ONLY,
    HiddenCase,
    Part,
    PlantName,
    drawn_effects,
)
from benchmarks.hidden_effects.parts import PARTS, cases
from tests.foreign.out_of_library import KINDS

DIGESTS = ("1a2b", "3c4d")


@pytest.fixture(params=[("simulated", "tuned"), *(("foreign", part) for part in PARTS)], ids="-".join)
def listed(request: pytest.FixtureRequest) -> list[HiddenCase]:
    plant: PlantName
    part: Part
    plant, part = request.param
    return cases(plant, part, DIGESTS[0])


def test_cases_are_reproducible_with_names_and_seeds_of_their_own(listed: list[HiddenCase]) -> None:
    assert listed == cases(listed[0].plant, listed[0].part, DIGESTS[0])
    assert len({case.name for case in listed}) == len(listed)
    assert len({case.seed for case in listed}) > 0.99 * len(listed)


def test_first_cases_are_a_representative_sample(listed: list[HiddenCase]) -> None:
    shares = [sum(case.kind == "single" for case in part) / len(part) for part in (listed, listed[:60])]
    assert shares[1] == pytest.approx(shares[0], abs=0.2)
    assert {case.kind for case in listed[:60]} == {"nothing", "single", "pair", "outside"}


def test_effects_are_hidden_only_where_the_signal_can_show_them(listed: list[HiddenCase]) -> None:
    for case in listed:
        assert case.signal == "voltage" or not set(case.effects) & set(VOLTAGE_ONLY)
        assert case.reports_command or not set(case.effects) & set(COMMAND_ONLY)
        assert not (case.reports_command and case.signal == "effort")
    assert {case.reports_command for case in listed if case.effects == ("stribeck",)} == {True, False}


def test_each_effect_of_the_library_is_hidden_about_equally_often(listed: list[HiddenCase]) -> None:
    for size in (0.01, 0.03):
        counts = Counter(case.effects[0] for case in listed if case.kind == "single" and case.sizes == (size,))
        assert set(counts) == set(drawn_effects())
        assert max(counts.values()) - min(counts.values()) <= 1


def test_effects_that_came_later_are_drawn_last_in_a_kind_of_their_own(listed: list[HiddenCase]) -> None:
    kinds = [case.kind for case in listed]
    last = kinds.index("added")
    assert set(kinds[last:]) == {"added"}
    counts = Counter(case.effects[0] for case in listed[last:])
    assert set(counts) == set(ADDED)
    assert len(set(counts.values())) == 1
    assert {case.sizes for case in listed[last:]} == {(0.03,)}


def test_only_the_locked_part_depends_on_the_digest_and_parts_have_no_case_in_common() -> None:
    drawn = {part: [cases("foreign", part, digest) for digest in DIGESTS] for part in PARTS}
    assert {part: one == other for part, (one, other) in drawn.items()} == {
        "tuned": True,
        "chosen": True,
        "locked": False,
    }
    names = [{case.name for case in one} for one, _ in drawn.values()]
    assert len(set.union(*names)) == sum(map(len, names))
    assert [bool(cases("simulated", part)) for part in PARTS] == [True, False, False]


def test_drawn_conditions_cover_repetition_rates_signals_and_coarse_steps() -> None:
    drawn = cases("foreign", "chosen")
    assert Counter(case.kind for case in drawn) == {
        "single": 600,
        "nothing": 100,
        "pair": 100,
        "outside": 100,
        "added": 60,
    }
    assert {case.effects[0] for case in drawn if case.kind == "outside"} == set(KINDS)
    assert {case.repeats for case in drawn} == {True, False}
    assert (min(case.rate for case in drawn), max(case.rate for case in drawn)) == (100, 1000)
    signals = {(signal, bits) for signal in ("voltage", "effort") for bits in (10, None)}
    assert {(case.signal, case.signal_bits) for case in drawn} == signals
