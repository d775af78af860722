"""The swarm over nonlinear parameters, on a recording of one joint with a known law of friction."""

from typing import Any

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from ident.estimation import estimators, nonlinear_swarm
from ident.estimation.nonlinear_swarm import SwarmSearch
from recordings.errors import BadInput
from recordings.recording import Floats
from tests.ident import building
from tests.ident.estimation.test_nonlinear_fit import BUMP, SPEED, stribeck

BRIEF = {"particles": 8, "neighbours": 4, "iterations": 14}


def search(*names: str, seed: int = 1, settings: dict[str, Any] = BRIEF, **options: Any) -> SwarmSearch:
    recording = building.record(cycles=2, **options)
    terms = building.structure(recording, *names).terms
    chosen, generator = estimators.settings("pso_nonlinear", settings), np.random.default_rng(seed)
    return nonlinear_swarm.search([building.prepared(recording)], terms, chosen, generator, lambda *_: None)


def delayed(motion: Motion) -> Floats:
    """What a torque that comes 4 ms late differs by from one that does not."""
    regressor = mechanisms.create(building.bench()).regressor(motion)
    torque = (regressor @ building.parameters())[:, 0]
    at = np.arange(len(torque)) / building.RATE
    late: Floats = np.interp(at - 0.004, at, torque)[:, None] - torque[:, None]
    return late


def test_shape_and_linear_parameters_are_found_without_initial_guesses() -> None:
    result = search("stribeck", extra=stribeck, noise=0.01, settings={**BRIEF, "iterations": 24})
    np.testing.assert_allclose(result.x, [*building.parameters(), BUMP, SPEED], rtol=0.05)
    assert (np.diff(result.history) <= 0).all()
    assert result.evaluations == BRIEF["particles"] * len(result.history)


def test_the_same_seed_gives_the_same_result() -> None:
    settings = {**BRIEF, "iterations": 2}
    first, second = (search("stribeck", extra=stribeck, settings=settings) for _ in range(2))
    np.testing.assert_array_equal(first.x, second.x)
    other = search("stribeck", extra=stribeck, settings=settings, seed=2)
    assert not np.array_equal(first.x, other.x)


def test_a_parameter_of_the_measurement_is_found() -> None:
    result = search("actuation_delay", extra=delayed, noise=0.01, settings={**BRIEF, "iterations": 6})
    value = dict(zip((entry.name for entry in result.structure.parameters), result.x, strict=True))
    assert abs(value["actuation_delay.delta1"]) == pytest.approx(0.004, rel=0.2)


@pytest.mark.parametrize(
    ("names", "message"),
    [((), "an effect with shapes or signal parameters"), (("payload_change",), "whose t_e comes from the data")],
)
def test_effects_that_a_swarm_cannot_search_are_refused(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        search(*names)
