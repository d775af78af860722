"""Candidate effects for a model."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.candidate_search import MIN_SIGNIFICANCE, CandidateSearch, is_physical
from ident.diagnosis.screening import Candidate
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from recordings.rig import simulated_rig

ROWS = 1000.0
ZERO_EFFECT_LOSS = 100.0


def fitted_model(effect: str, loss: float, parameters: int) -> Any:
    solution = SimpleNamespace(loss=loss, x=np.zeros(parameters))
    return SimpleNamespace(solution=solution, terms=(Term(effect, library()[effect], (1,)),))


@pytest.mark.parametrize(
    ("other", "loss", "expected"),
    [
        ("joint_spring", ROWS, True),
        ("joint_spring", ROWS - 0.9 * MIN_SIGNIFICANCE, True),
        ("joint_spring", ROWS - 1.1 * MIN_SIGNIFICANCE, False),
        ("arm_mass_mismatch", ROWS, False),
    ],
)
def test_effect_that_contains_another_is_redundant_unless_it_explains_more(
    other: str, loss: float, expected: bool
) -> None:
    search = CandidateSearch(SimpleNamespace(independent_rows=ROWS), library())  # type: ignore[arg-type]
    assert (
        search.is_redundant("torque_offset", fitted_model("torque_offset", ROWS, 13), fitted_model(other, loss, 14))
        is expected
    )


def _with_springs(motor: float, damping: float, identifiable: bool = True) -> tuple[Any, Any]:
    """A model with springs on all joints, whose shapes are identifiable or not, and the model without springs."""
    rig = simulated_rig()
    before = ModelStructure(mechanisms.create(rig), rig)
    after = before.with_term(Term("joint_elasticity", library()["joint_elasticity"], (0, 1, 2)))
    mechanism = np.ones(len(before.parameters))
    x = np.concatenate([mechanism, [1e-3, 1e-3, 1e-3, motor, damping]])
    derivatives, weights = np.full((9, 3, len(x)), float(identifiable)), np.ones((9, 3))
    return tuple(
        SimpleNamespace(
            solution=SimpleNamespace(
                structure=structure, x=values, derivatives=(derivatives,), weights=(weights,), loss=27.0
            ),
            terms=structure.terms,
        )
        for structure, values in ((after, x), (before, mechanism))
    )


@pytest.mark.parametrize(
    ("motor", "damping", "expected"), [(0.4, 0.03, True), (0.0, 0.0, True), (0.98, 0.03, False), (0.4, 0.4, False)]
)
def test_effect_with_a_shape_at_the_limit_of_its_range_is_rejected(
    motor: float, damping: float, expected: bool
) -> None:
    assert is_physical(*_with_springs(motor, damping)) is expected


@pytest.mark.parametrize(("lines", "expected"), [(5.0, False), (5.5, True), (2000.0, True)])
def test_cogging_slower_than_any_ripple_is_rejected(lines: float, expected: bool) -> None:
    rig = simulated_rig()
    before = ModelStructure(mechanisms.create(rig), rig)
    after = before.with_term(Term("cogging", library()["cogging"], (0,)))
    mechanism = np.ones(len(before.parameters))
    x = np.concatenate([mechanism, [0.3, 0.1, lines]])
    derivatives: Any = {"derivatives": (np.ones((9, 3, len(x))),), "weights": (np.ones((9, 3)),), "loss": 27.0}
    with_it, without = (
        SimpleNamespace(solution=SimpleNamespace(structure=structure, x=values, **derivatives), terms=structure.terms)
        for structure, values in ((after, x), (before, mechanism))
    )
    assert is_physical(with_it, without) is expected  # type: ignore[arg-type]


def test_unidentifiable_shape_may_end_anywhere() -> None:
    assert is_physical(*_with_springs(0.98, 0.12, identifiable=False))


def test_effect_is_extended_to_one_more_joint() -> None:
    rig, known = simulated_rig(), library()
    narrow = ModelStructure(mechanisms.create(rig), rig, (Term("stribeck", known["stribeck"], (0, 2)),))
    mechanism = np.arange(float(len(mechanisms.create(rig).parameters)))
    solution = SimpleNamespace(structure=narrow, x=np.concatenate([mechanism, [1.0, 3.0, 0.1]]))
    split = SimpleNamespace(
        fit=lambda structure, x: SimpleNamespace(structure=structure, x=x), residuals=lambda solution: ()
    )
    search = CandidateSearch(split, known)  # type: ignore[arg-type]
    (extended,) = search.joint_extensions(SimpleNamespace(solution=solution, terms=narrow.terms), [0, 1])  # type: ignore[arg-type]
    assert [term.joints for term in extended.terms] == [(0, 1, 2)]
    np.testing.assert_array_equal(extended.solution.x, [*mechanism, 1.0, 2.0, 3.0, 0.1])


class _Search:
    """Data with given losses before and after the optimization from each start."""

    def __init__(self, initial: Sequence[float], final: Sequence[float]) -> None:
        self._initial, self._final, self.optimized = [*initial, ZERO_EFFECT_LOSS], list(final), list[float]()

    def fit_linear(self, structure: ModelStructure, x: Any) -> Any:
        return SimpleNamespace(loss=self._initial.pop(0), structure=structure, x=x)

    def fit_nonlinear(self, solution: Any) -> Any:
        self.optimized.append(solution.loss)
        return SimpleNamespace(loss=self._final.pop(0), structure=solution.structure, x=solution.x)

    def residuals(self, solution: Any) -> Any:
        return ()


@pytest.mark.parametrize(
    ("effect", "initial", "final", "optimized", "loss"),
    [
        ("joint_elasticity", (40.0, 90.0), (11.0, 9.0), [40.0], 11.0),  # reaches what screening promised
        ("joint_elasticity", (40.0, 90.0), (30.0, 9.0), [40.0, 90.0], 9.0),
        ("joint_elasticity", (101.0, 900.0), (11.0, 9.0), [], ZERO_EFFECT_LOSS),  # every start increases the loss
        ("joint_elasticity", (900.0, 99.0), (50.0, 9.0), [900.0, 99.0], 9.0),
        ("backlash", (101.0, 900.0), (30.0, 9.0), [101.0, 900.0], 9.0),  # multistart
        ("backlash", (40.0, 90.0), (11.0, 9.0), [40.0, 90.0], 9.0),
    ],
)
def test_further_starts_are_optimized_only_if_needed(
    effect: str, initial: Sequence[float], final: Sequence[float], optimized: list[float], loss: float
) -> None:
    rig = simulated_rig()
    bare = ModelStructure(mechanisms.create(rig), rig)
    before: Any = SimpleNamespace(
        solution=SimpleNamespace(structure=bare, x=np.zeros(len(bare.parameters)), loss=100.0), terms=()
    )
    term = Term(effect, library()[effect], (0,))
    start = np.zeros(len(bare.with_term(term).parameters) - len(bare.parameters))
    candidate = Candidate(term, (start, start), 10.0, 2, np.ones(1), np.ones((1, 1)), np.ones(0))
    split: Any = _Search(initial, final)
    best = CandidateSearch(split, library()).add(before, candidate)
    assert (split.optimized, best.solution.loss) == (optimized, loss)
