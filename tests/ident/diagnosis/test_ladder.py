"""Which way the ladder goes up, in a toy world in which it is known what every set of effects would leave."""

from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis import stepwise_selection
from ident.diagnosis.improvement import Improvement

Left = dict[str, float]
"""By effects, a letter each: mean square above the floor, over that of the floor."""


class Toy(stepwise_selection.Selector):
    """Climbs where `left` says."""

    def __init__(self, left: Left, least: float = 0.95) -> None:
        """least: RMS of the floor; what fits see has an RMS of one."""
        self._excess_by, self.least = left, least
        self.finder: Any = SimpleNamespace(
            options=self._extensions, wider=self._none, unlikely=self._none, clear=lambda *arguments: self.clear
        )
        self.clear = False
        """Whether the rows that were fitted tell one model from another by more than noise."""
        rows = np.ones((1, 1), bool)
        self._split: Any = SimpleNamespace(seen=(rows,), judged=(rows,))
        self._progress = lambda text: None

    def state(self, names: Iterable[str]) -> Any:
        terms = tuple(SimpleNamespace(name=name, joints=(0,)) for name in names)
        loss = self._excess_by.get("".join(sorted(names)), np.inf)
        return SimpleNamespace(
            terms=terms, solution=SimpleNamespace(loss=loss, x=terms), residuals=(np.ones((1, 1)),)
        )

    def begin(self, composition: Any, x: Any) -> Any:
        return self.state(""), [stepwise_selection.SelectionStep(None, self.state(""), None)]

    def _extensions(self, state: Any) -> Any:
        names = {term.name for term in state.terms}
        more = [self.state([*names, new]) for new in "abcd" if new not in names]
        known = [one for one in more if np.isfinite(one.solution.loss)]
        return SimpleNamespace(states=sorted(known, key=lambda one: one.solution.loss))

    def _none(self, *arguments: Any) -> list[Any]:
        return []

    def gain(self, before: Any, after: Any) -> Improvement:
        was, now = before.solution.loss, after.solution.loss
        return Improvement((was - now) / was, (0.0, 1.0), 9.0, was - now, now)

    def _simplest(self, state: Any, options: Any) -> Any:
        return options[0]

    def _is_confirmed(self, before: Any, after: Any) -> bool:
        return after.solution.loss < before.solution.loss

    def _pruned(self, state: Any) -> Any:
        return state

    def _review_effect(self, state: Any, index: int) -> Any:
        return None, state

    def floor(self, state: Any) -> Any:
        return SimpleNamespace(rms=np.full(1, self.least))

    def _computed(self, state: Any) -> Any:
        return ()


@pytest.fixture(autouse=True)
def all_is_possible(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stepwise_selection, "possible", lambda state, before: True)


def found(left: Left) -> str:
    climbed = Toy(left).select(None, None)  # type: ignore[arg-type]
    return "".join(term.name for term in climbed.steps[-1].model.terms)


def test_what_explains_most_comes_first() -> None:
    assert found({"": 100.0, "a": 10.0, "b": 50.0, "ab": 0.5}) == "ab"


def test_an_imitation_of_two_effects_gives_way_to_them() -> None:
    assert found({"": 100.0, "a": 40.0, "b": 60.0, "c": 70.0, "ab": 39.0, "ac": 38.0, "bc": 0.2}) == "bc"


def test_an_effect_that_holds_only_beside_another_one_is_tried_if_it_explains_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Alone, held-out rows speak against either."""
    confirmed = Toy._is_confirmed
    single = lambda self, before, after: len(after.terms) != 1 and confirmed(self, before, after)  # noqa: E731
    monkeypatch.setattr(Toy, "_is_confirmed", single)
    assert found({"": 100.0, "a": 40.0, "b": 45.0, "ab": 1.0}) == "ab"
    assert found({"": 100.0, "a": 80.0, "b": 75.0, "ab": 1.0}) == ""


def test_another_beginning_that_is_not_far_better_is_left_alone() -> None:
    assert found({"": 100.0, "a": 40.0, "b": 60.0, "c": 70.0, "bc": 30.0}) == "a"


@pytest.mark.parametrize(("before", "after", "expected"), [(40.0, 37.0, "a"), (40.0, 30.0, "ad"), (2.9, 2.8, "ad")])
def test_a_little_of_much_that_is_not_understood_is_no_finding(before: float, after: float, expected: str) -> None:
    assert found({"": 100.0, "a": before, "ad": after}) == expected


def test_nothing_is_added_below_the_floor() -> None:
    assert found({"": 100.0, "a": -0.1, "ad": -0.5}) == "a"


def test_nothing_is_added_where_what_fits_see_is_at_the_floor() -> None:
    climbed = Toy({"": 100.0, "a": 1.0}, least=1.0).select(None, None)  # type: ignore[arg-type]
    assert [rung.added for rung in climbed.steps] == [None]


def test_what_makes_itself_superfluous_ends_the_climb(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy({"": 100.0, "a": 40.0, "ad": 10.0})
    monkeypatch.setattr(toy, "_pruned", lambda state: toy.state("a"))
    assert [rung.added for rung in toy.select(None, None).steps] == [None, "a"]  # type: ignore[arg-type]


@pytest.mark.parametrize(("left", "spoken_against"), [(0.3, True), (0.04, False), (1e-3, False)])
def test_what_leaves_hardly_more_than_the_floor_is_not_spoken_against(left: float, spoken_against: bool) -> None:
    toy = Toy({"a": left, "b": 1e-4})
    assert toy._is_preferred(toy.state("a"), toy.state("b")) is spoken_against


@pytest.mark.parametrize(
    ("clear", "share", "spoken_against"), [(True, 0.9, True), (True, 0.3, False), (False, 0.9, False)]
)
def test_rows_that_were_fitted_may_speak_where_those_held_out_do_not(
    monkeypatch: pytest.MonkeyPatch, clear: bool, share: float, spoken_against: bool
) -> None:
    judged: list[Any] = []

    def gain(material: Any, before: Any, after: Any, floor: Any, rows: Any) -> Improvement:
        judged.extend(rows)
        return Improvement(share, (0.0, 1.0), 9.0, 0.5, 0.0)

    monkeypatch.setattr(stepwise_selection, "gain", gain)
    toy = Toy({"a": 0.01, "b": 0.01})
    toy.clear = clear
    assert toy._is_preferred(toy.state("a"), toy.state("b")) is spoken_against
    assert all(rows.all() for rows in judged)
    assert bool(judged) is clear
