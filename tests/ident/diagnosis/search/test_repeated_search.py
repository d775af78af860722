"""Shapes that were searched while another effect was missing are searched again beside it."""

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.candidate_search import CandidateSearch
from ident.diagnosis.search.repeated_search import has_shapes, searched_again
from ident.dynamics.effects.base import Quantity
from ident.dynamics.structure import Term
from tests.ident import building

ORDER, WRONG = 3.0, 9.0
DATA = building.split(
    [building.record(noise=0.02, extra=lambda motion: 0.8 * np.sin(ORDER * motion.position) + 2.0 * motion.position)]
)
WAVE = building.effect(
    lambda motion: motion.position,
    columns=lambda inputs, shapes: np.sin(shapes["k"] * inputs.motion.position)[:, :, None],
    shapes=(
        Quantity(name="k", unit="1/rad", meaning="order", lower=0.5, upper=20.0, initial_guesses=(WRONG, ORDER)),
    ),
)
EFFECTS = {"wave": WAVE, "spring": building.effect(lambda motion: motion.position)}


def model(search: CandidateSearch, order: float, *names: str) -> FittedModel:
    """A wave of this `order` and the effects `names`, fitted to a wave of the true order and a spring."""
    recording = DATA.recordings[0].recording
    structure = building.structure(recording)
    for name in ("wave", *names):
        structure = structure.with_term(Term(name, EFFECTS[name], (0,)))
    x = building.start(structure)
    x[[entry.name for entry in structure.parameters].index("wave.k")] = order
    return search.fit(structure, x)


def test_shape_leaves_its_local_minimum_once_the_other_effect_is_there() -> None:
    search = CandidateSearch(DATA, EFFECTS)
    stuck = model(search, WRONG, "spring")
    assert abs(stuck.solution.x[-2] - ORDER) > 1  # the fit of all parameters together stays where it was
    again = searched_again(search, stuck)
    assert [term.name for term in again.terms] == ["wave", "spring"]
    values = dict(zip((e.name for e in again.solution.structure.parameters), again.solution.x, strict=True))
    assert values["wave.k"] == pytest.approx(ORDER, abs=0.02)
    assert values["spring.a1"] == pytest.approx(2.0, abs=0.02)


def test_shape_at_the_global_minimum_stays() -> None:
    search = CandidateSearch(DATA, EFFECTS)
    right = model(search, ORDER, "spring")
    assert searched_again(search, right) is right


def test_last_effect_was_searched_beside_all_others() -> None:
    search = CandidateSearch(DATA, EFFECTS)
    alone = model(search, WRONG)
    assert searched_again(search, alone) is alone


def test_only_effects_with_shapes_are_searched() -> None:
    search = CandidateSearch(DATA, EFFECTS)
    assert has_shapes(model(search, ORDER))
    structure = building.structure(DATA.recordings[0].recording)
    linear = structure.with_term(Term("spring", EFFECTS["spring"], (0,)))
    assert not has_shapes(search.fit(linear, building.start(linear)))
