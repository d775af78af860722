"""Coulomb friction and a constant offset, if a joint moves mainly in one direction."""

import numpy as np
import pytest

from ident.diagnosis.split.friction_offset_confounding import confounding_warnings, rarer_direction_share
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from tests.ident import building

OFFSET = library()["torque_offset"]
DRIFT = 2.3
"""Speed [rad/s] at which the joint seldom moves backwards."""


def test_oscillation_moves_in_both_directions_equally() -> None:
    data = building.split([building.record(2)])
    np.testing.assert_allclose(rarer_direction_share(data), 0.5, atol=0.15)
    assert list(confounding_warnings(data, building.fitted(data).solution, OFFSET)) == []


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_share_does_not_depend_on_the_main_direction(sign: float) -> None:
    data = building.split([building.record(drift=sign * DRIFT, cycles=6)])
    (share,) = rarer_direction_share(data)
    assert 0.0 < share < 0.25


def test_one_direction_cannot_distinguish_them() -> None:
    data = building.split([building.record(2, drift=20.0)])
    sentences = list(confounding_warnings(data, building.fitted(data).solution, OFFSET))
    assert [sentence.split(" so ")[0] for sentence in sentences] == [
        "Joint 1 moves in one direction only,",
        "Joint 2 moves in one direction only,",
    ]


def test_rare_direction_gives_both_estimates() -> None:
    recording = building.record(
        drift=DRIFT, cycles=6, noise=0.02, extra=lambda motion: np.full_like(motion.position, 0.7)
    )
    data = building.split([recording])
    (sentence,) = confounding_warnings(data, building.fitted(data).solution, OFFSET)
    numbers = [float(word) for word in sentence.replace("±", " ").split() if word.replace(".", "", 1).isdigit()]
    friction, constant = numbers[1], numbers[3]
    assert friction == pytest.approx(building.COULOMB, abs=0.05)
    assert constant == pytest.approx(0.7, abs=0.05)
    assert "their errors correlate by -0." in sentence


def test_offset_of_the_model_is_used() -> None:
    recording = building.record(drift=DRIFT, cycles=6, noise=0.02)
    data = building.split([recording])
    bare, with_offset = building.fitted(data), building.fitted(data, "torque_offset")
    assert list(confounding_warnings(data, bare.solution, OFFSET)) == list(
        confounding_warnings(data, with_offset.solution, OFFSET)
    )


def test_without_the_effect_only_one_direction_is_reported() -> None:
    data = building.split([building.record(drift=DRIFT, cycles=6)])
    assert list(confounding_warnings(data, building.fitted(data).solution, None)) == []


def test_offset_may_be_a_second_term_of_the_model() -> None:
    data = building.split([building.record(2, drift=DRIFT, cycles=6, noise=0.02)])
    model = building.structure(data.recordings[0].recording, "torque_offset", joints=[0])
    model = model.with_term(Term("torque_offset", OFFSET, (1,)))
    sentences = list(confounding_warnings(data, data.fit(model, building.start(model)), OFFSET))
    assert [sentence[:7] for sentence in sentences] == ["Joint 1", "Joint 2"]
