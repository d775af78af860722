"""Stepwise selection in a toy world where the residual of every set of effects is known."""

from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis import stepwise_selection
from ident.diagnosis.improvement import Improvement

Excess = dict[str, float]
"""Mean square above the noise floor, in units of the squared floor, by effects; each effect is a letter."""


class Toy(stepwise_selection.Selector):
    """A selector with known residuals."""

    def __init__(self, excess: Excess, floor: float = 0.95) -> None:
        """floor: RMS of the noise floor; the training residual has an RMS of one."""
        self._excess_by, self.floor = excess, floor
        self.search: Any = SimpleNamespace(
            extensions=self._extensions,
            joint_extensions=self._none,
            skipped_extensions=self._none,
            is_significant=lambda *arguments: self.significant,
        )
        self.significant = False
        """Whether models differ significantly on the training rows."""
        rows = np.ones((1, 1), bool)
        self._split: Any = SimpleNamespace(train=(rows,), scored=(rows,))
        self._progress = lambda text: None

    def model(self, names: Iterable[str]) -> Any:
        terms = tuple(SimpleNamespace(name=name, joints=(0,)) for name in names)
        loss = self._excess_by.get("".join(sorted(names)), np.inf)
        return SimpleNamespace(
            terms=terms, solution=SimpleNamespace(loss=loss, x=terms), residuals=(np.ones((1, 1)),)
        )

    def start(self, structure: Any, x: Any) -> Any:
        return self.model(""), [stepwise_selection.SelectionStep(None, self.model(""), None)]

    def _extensions(self, model: Any) -> Any:
        names = {term.name for term in model.terms}
        extensions = [self.model([*names, new]) for new in "abcd" if new not in names]
        known = [extension for extension in extensions if np.isfinite(extension.solution.loss)]
        return SimpleNamespace(models=sorted(known, key=lambda extension: extension.solution.loss))

    def _none(self, *arguments: Any) -> list[Any]:
        return []

    def improvement(self, before: Any, after: Any) -> Improvement:
        was, now = before.solution.loss, after.solution.loss
        return Improvement((was - now) / was, (0.0, 1.0), 9.0, was - now, now)

    def _simplest(self, model: Any, candidates: Any) -> Any:
        return candidates[0]

    def _is_confirmed(self, before: Any, after: Any) -> bool:
        return after.solution.loss < before.solution.loss

    def _pruned(self, model: Any) -> Any:
        return model

    def _review_effect(self, model: Any, index: int) -> Any:
        return None, model

    def noise_floor(self, model: Any) -> Any:
        return SimpleNamespace(rms=np.full(1, self.floor))

    def _computed(self, model: Any) -> Any:
        return ()


@pytest.fixture(autouse=True)
def all_models_are_physical(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stepwise_selection, "is_physical", lambda model, before: True)


def select(excess: Excess) -> str:
    selection = Toy(excess).select(None, None)  # type: ignore[arg-type]
    return "".join(term.name for term in selection.steps[-1].model.terms)


def test_best_effect_is_added_first() -> None:
    assert select({"": 100.0, "a": 10.0, "b": 50.0, "ab": 0.5}) == "ab"


def test_effect_that_imitates_two_others_is_replaced_by_them() -> None:
    assert select({"": 100.0, "a": 40.0, "b": 60.0, "c": 70.0, "ab": 39.0, "ac": 38.0, "bc": 0.2}) == "bc"


def test_effect_supported_only_beside_another_is_tried_if_it_explains_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Alone, neither is supported by the test rows."""
    confirmed = Toy._is_confirmed
    single = lambda self, before, after: len(after.terms) != 1 and confirmed(self, before, after)  # noqa: E731
    monkeypatch.setattr(Toy, "_is_confirmed", single)
    assert select({"": 100.0, "a": 40.0, "b": 45.0, "ab": 1.0}) == "ab"
    assert select({"": 100.0, "a": 80.0, "b": 75.0, "ab": 1.0}) == ""


def test_alternative_start_that_is_not_far_better_is_rejected() -> None:
    assert select({"": 100.0, "a": 40.0, "b": 60.0, "c": 70.0, "bc": 30.0}) == "a"


@pytest.mark.parametrize(("before", "after", "expected"), [(40.0, 37.0, "a"), (40.0, 30.0, "ad"), (2.9, 2.8, "ad")])
def test_minor_effect_is_not_added_while_a_large_error_remains(before: float, after: float, expected: str) -> None:
    assert select({"": 100.0, "a": before, "ad": after}) == expected


def test_nothing_is_added_below_the_floor() -> None:
    assert select({"": 100.0, "a": -0.1, "ad": -0.5}) == "a"


def test_nothing_is_added_if_the_training_residual_is_at_the_floor() -> None:
    selection = Toy({"": 100.0, "a": 1.0}, floor=1.0).select(None, None)  # type: ignore[arg-type]
    assert [step.added for step in selection.steps] == [None]


def test_selection_stops_when_the_added_effect_is_pruned(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy({"": 100.0, "a": 40.0, "ad": 10.0})
    monkeypatch.setattr(toy, "_pruned", lambda model: toy.model("a"))
    assert [step.added for step in toy.select(None, None).steps] == [None, "a"]  # type: ignore[arg-type]


@pytest.mark.parametrize(("excess", "preferred"), [(0.3, True), (0.04, False), (1e-3, False)])
def test_model_close_to_the_floor_is_not_ruled_out(excess: float, preferred: bool) -> None:
    toy = Toy({"a": excess, "b": 1e-4})
    assert toy._is_preferred(toy.model("a"), toy.model("b")) is preferred


@pytest.mark.parametrize(
    ("significant", "share", "preferred"), [(True, 0.9, True), (True, 0.3, False), (False, 0.9, False)]
)
def test_all_rows_may_decide_if_the_test_rows_do_not(
    monkeypatch: pytest.MonkeyPatch, significant: bool, share: float, preferred: bool
) -> None:
    scored: list[Any] = []

    def measure_improvement(split: Any, before: Any, after: Any, floor: Any, rows: Any) -> Improvement:
        scored.extend(rows)
        return Improvement(share, (0.0, 1.0), 9.0, 0.5, 0.0)

    monkeypatch.setattr(stepwise_selection, "measure_improvement", measure_improvement)
    toy = Toy({"a": 0.01, "b": 0.01})
    toy.significant = significant
    assert toy._is_preferred(toy.model("a"), toy.model("b")) is preferred
    assert all(rows.all() for rows in scored)
    assert bool(scored) is significant
