"""Pairs of effects that show only together."""

from typing import Any

import numpy as np
import pytest

from ident.diagnosis.search.candidate_search import CandidateSearch
from ident.diagnosis.search.pair_screening import screen_pairs
from ident.diagnosis.search.screening import Screener
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Quantity
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building


def first(motion: Motion) -> Floats:
    return np.cos(4 * motion.position)


def second(motion: Motion) -> Floats:
    """Nearly the opposite of the first."""
    return -np.cos(4 * motion.position) + 0.3 * np.sin(7 * motion.position)


def other(motion: Motion) -> Floats:
    return np.sin(2 * motion.position)


EFFECTS = {name: building.effect(column) for name, column in (("a", first), ("b", second), ("c", other))}


def data() -> SplitData:
    """Both effects of the size 2, which leave 0.6 sin 7 q."""
    return building.split(
        [building.record(noise=0.05, extra=lambda motion: 2 * first(motion) + 2 * second(motion), seed=1)]
    )


def screened(effects: dict[str, Any] = EFFECTS) -> tuple[CandidateSearch, Any, list[Any]]:
    split = data()
    search, structure = CandidateSearch(split, effects), building.structure(split.recordings[0].recording)
    model = search.fit(structure, building.start(structure))
    screener = Screener(split, model.solution)
    return search, model, screen_pairs(screener, screener.screen(effects)[0])


def test_pair_that_nearly_cancels_is_first() -> None:
    _, model, pairs = screened()
    assert {candidate.term.name for candidate in pairs[0].effects} == {"a", "b"}
    assert pairs[0].loss < 0.2 * model.solution.loss < 0.5 * min(pair.loss for pair in pairs[1:])


def test_loss_is_that_of_the_fit() -> None:
    search, model, pairs = screened()
    (fitted,) = search.pairs(model, 0.5 * model.solution.loss)
    assert fitted.solution.loss == pytest.approx(pairs[0].loss, rel=1e-6)
    np.testing.assert_allclose(fitted.solution.x[-2:], 2.0, rtol=0.05)


def test_initial_guess_has_the_coefficients_of_both() -> None:
    guesses = [candidate.initial_guesses for candidate in screened()[2][0].effects]
    np.testing.assert_allclose(np.ravel(guesses), 2.0, rtol=0.05)


def test_pair_with_an_impossible_sign_is_left_out() -> None:
    negative = Quantity(name="a", unit="{effort}", meaning="size", upper=0.0)
    effects = {**EFFECTS, "b": building.effect(second, coefficients=(negative,))}
    pairs = screened(effects)[2]
    assert all({candidate.term.name for candidate in pair.effects} != {"a", "b"} for pair in pairs)


def test_without_two_candidates_there_is_no_pair() -> None:
    split = data()
    structure = building.structure(split.recordings[0].recording)
    screener = Screener(split, split.fit(structure, building.start(structure)))
    assert screen_pairs(screener, []) == []
    assert screen_pairs(screener, screener.screen({"c": EFFECTS["c"]})[0]) == []
