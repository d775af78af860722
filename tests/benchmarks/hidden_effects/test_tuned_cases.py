"""Cases on which the diagnosis was tuned."""

import pytest

from benchmarks.hidden_effects.cases import Case, PlantName
from benchmarks.hidden_effects.tuned_cases import tuned_cases
from drivers.simulated.effect import library


@pytest.fixture(params=["simulated", "foreign"])
def listed(request: pytest.FixtureRequest) -> list[Case]:
    plant: PlantName = request.param
    return tuned_cases(plant)


def test_list_is_reproducible_with_unique_names_and_seeds(listed: list[Case]) -> None:
    assert listed == tuned_cases(listed[0].plant)
    assert len({case.name for case in listed}) == len(listed)
    assert len({case.seed for case in listed}) == len(listed)


def test_first_cases_are_a_representative_sample(listed: list[Case]) -> None:
    share = sum(case.kind == "single" for case in listed) / len(listed)
    assert sum(case.kind == "single" for case in listed[:60]) / 60 == pytest.approx(share, abs=0.2)
    assert {case.kind for case in listed[:60]} == {"nothing", "single", "pair", "outside"}


def test_each_library_effect_is_hidden_on_every_robot_at_one_and_three_percent(listed: list[Case]) -> None:
    combinations = {(case.effects[0], case.sizes[0], case.robot) for case in listed if case.kind == "single"}
    for effect in library():
        for size in (0.01, 0.03):
            assert {robot for name, case_size, robot in combinations if (name, case_size) == (effect, size)} == {
                "default",
                "heavy",
                "light",
            }


def test_simulated_rig_has_six_hundred_cases_and_all_resolutions_and_rates() -> None:
    listed = tuned_cases("simulated")
    assert len(listed) >= 600
    nothing = [case for case in listed if case.kind == "nothing"]
    assert {case.bits for case in nothing} >= set(range(12, 21))
    assert min(case.rate for case in nothing) == 200
    assert max(case.rate for case in nothing) >= 900


def test_amplifier_effects_are_hidden_only_where_commanded_voltages_are_reported(listed: list[Case]) -> None:
    for case in listed:
        if {"amplifier_deadband", "amplifier_saturation"} & set(case.effects):
            assert case.reports_command
    command_flags = [case.reports_command for case in listed if case.effects == ("stribeck",)]
    assert len(set(command_flags)) == 2
