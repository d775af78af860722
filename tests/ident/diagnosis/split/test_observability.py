"""Which effects recordings can show, and why not the others."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.split.observability import MIN_TEMPERATURE_CHANGE, Observability, observability
from ident.dynamics.effects.library import library
from recordings.recording import Recording
from recordings.rig import Axis, Rig
from tests.ident import building

NAME = "temperature_friction"


def of(recording: Recording, without: tuple[str, ...] = ()) -> Observability:
    return observability(building.split([recording]), library(), without)


def warmed(*change: float) -> Recording:
    """A recording whose joints get warmer by `change` [K]; NaN: not measured."""
    share = np.linspace(0, 1, len(building.motion_of().position))[:, None]
    return building.record(len(change), temperature=30 + share * np.array(change))


def test_an_effect_that_the_user_leaves_out_is_not_tested() -> None:
    result = of(building.record(), ("stribeck",))
    assert "stribeck" not in result.observable
    assert result.untested["stribeck"] == "Left out by the user."


def test_effects_of_other_mechanisms_are_not_sorted() -> None:
    result = of(building.record())
    names = {*result.observable, *result.unobservable, *result.untested}
    assert names == {name for name, effect in library().items() if "axes" in effect.mechanisms}


def test_a_temperature_that_was_not_measured_shows_nothing() -> None:
    assert "temperature_1" in of(building.record()).unobservable[NAME]


@pytest.mark.parametrize(
    ("change", "tested"), [(0.9 * MIN_TEMPERATURE_CHANGE, False), (1.1 * MIN_TEMPERATURE_CHANGE, True)]
)
def test_a_temperature_that_hardly_changes_is_not_tested(change: float, tested: bool) -> None:
    result = of(warmed(change))
    assert (NAME in result.observable) == tested
    assert (NAME in result.untested) != tested


def test_an_effect_is_restricted_to_the_joints_that_show_it() -> None:
    assert of(warmed(10.0, np.nan, 0.1)).observable[NAME].joints == (0,)
    assert of(warmed(10.0, 10.0)).observable[NAME].joints is None


def test_friction_over_the_position_takes_both_directions() -> None:
    name = "position_dependent_friction"
    assert name in of(building.record()).observable
    assert "one of its directions" in of(building.record(drift=20.0)).untested[name]


def test_a_prismatic_axis_has_neither_turns_nor_a_lever() -> None:
    recording = building.record()
    prismatic = Rig(name="slide", mechanism="axes", axes=(Axis(type="prismatic"),))
    result = of(replace(recording, rig=prismatic))
    assert {"axis_weight", "encoder_eccentricity"} <= set(result.unobservable)
    assert "arm_com_offset" not in result.observable
