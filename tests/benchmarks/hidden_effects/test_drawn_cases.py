"""Cases that are drawn for the chosen and the locked part."""

from collections import Counter

import pytest

from benchmarks.hidden_effects.cases import COMMAND_ONLY, VOLTAGE_ONLY, Case
from benchmarks.hidden_effects.drawn_cases import drawn_cases
from drivers.simulated.effect import library
from tests.foreign.out_of_library import KINDS


@pytest.fixture(scope="module")
def drawn() -> list[Case]:
    return drawn_cases("chosen")


def test_number_of_cases_of_each_kind(drawn: list[Case]) -> None:
    sizes = Counter(case.sizes for case in drawn if case.kind == "single")
    assert sizes == {(0.03,): 300, (0.01,): 300}
    assert Counter(case.kind for case in drawn) == {"single": 600, "nothing": 100, "pair": 100, "outside": 100}


def test_each_effect_is_hidden_about_equally_often(drawn: list[Case]) -> None:
    for size in (0.01, 0.03):
        counts = Counter(case.effects[0] for case in drawn if case.kind == "single" and case.sizes == (size,))
        assert set(counts) == set(library())
        assert max(counts.values()) - min(counts.values()) <= 1
    assert {case.effects[0] for case in drawn if case.kind == "outside"} == set(KINDS)


def test_list_is_reproducible_and_depends_on_the_digest(drawn: list[Case]) -> None:
    assert drawn_cases("chosen") == drawn
    assert drawn_cases("locked", "1a2b") == drawn_cases("locked", "1a2b")
    seeds = [
        {case.seed for case in cases} for cases in (drawn, drawn_cases("locked", "1a2b"), drawn_cases("locked", "3c"))
    ]
    assert all(len(part) == 900 for part in seeds)
    assert len(set.union(*seeds)) > 2690


def test_first_cases_are_a_representative_sample(drawn: list[Case]) -> None:
    first = drawn[:60]
    assert {case.kind for case in first} == {"nothing", "single", "pair", "outside"}
    assert sum(case.kind == "single" for case in first) / 60 == pytest.approx(2 / 3, abs=0.2)


def test_conditions_cover_repetition_rates_signals_and_coarse_steps(drawn: list[Case]) -> None:
    assert {case.robot for case in drawn} == {"any"}
    assert {case.repeats for case in drawn} == {True, False}
    assert (min(case.rate for case in drawn), max(case.rate for case in drawn)) == (100, 1000)
    assert {(case.signal, case.signal_bits) for case in drawn} == {
        (signal, bits) for signal in ("voltage", "effort") for bits in (10, None)
    }


def test_effects_are_hidden_only_where_the_signal_can_show_them(drawn: list[Case]) -> None:
    for case in drawn:
        if set(case.effects) & set(VOLTAGE_ONLY):
            assert case.signal == "voltage"
        if set(case.effects) & set(COMMAND_ONLY):
            assert case.reports_command
        assert not (case.reports_command and case.signal == "effort")
