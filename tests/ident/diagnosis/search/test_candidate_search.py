"""Candidate effects for a model."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.search.candidate_search import MIN_SIGNIFICANCE, CandidateSearch
from ident.diagnosis.search.screening import Candidate
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from recordings.rig import simulated_rig

ROWS = 1000.0
ZERO_EFFECT_LOSS = 100.0
ESCAPE = 1.0
"""Reduction of the loss by an escape from a local minimum, from a fit that has reduced it."""


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


@pytest.mark.parametrize(
    ("present", "joints", "sets"),
    [((0, 2), [0, 1], [(0, 1, 2)]), ((1,), [0, 1, 2], [(0, 1), (0, 1, 2), (1, 2)]), ((0, 1, 2), [0, 1, 2], [])],
)
def test_effect_is_extended_to_each_further_joint_and_to_all_of_them(
    present: tuple[int, ...], joints: list[int], sets: list[tuple[int, ...]]
) -> None:
    rig, known = simulated_rig(), library()
    narrow = ModelStructure(mechanisms.create(rig), rig, (Term("stribeck", known["stribeck"], present),))
    mechanism = np.arange(float(len(mechanisms.create(rig).parameters)))
    coefficients = np.arange(1.0, 1 + len(present))
    solution = SimpleNamespace(structure=narrow, x=np.concatenate([mechanism, coefficients, [0.1]]))
    split = SimpleNamespace(
        fit=lambda structure, x: SimpleNamespace(structure=structure, x=x), residuals=lambda solution: ()
    )
    search = CandidateSearch(split, known)  # type: ignore[arg-type]
    extended = search.joint_extensions(SimpleNamespace(solution=solution, terms=narrow.terms), joints)  # type: ignore[arg-type]
    assert [model.terms[-1].joints for model in extended] == sets
    by_joint = dict(zip(present, coefficients, strict=True))
    for model in extended:
        expected = [by_joint.get(joint, coefficients.mean()) for joint in model.terms[-1].joints]
        np.testing.assert_array_equal(model.solution.x, [*mechanism, *expected, 0.1])


class _Search:
    """Data with given losses before and after the optimization from each start."""

    def __init__(self, initial: Sequence[float], final: Sequence[float]) -> None:
        self._initial, self._final, self.optimized = [*initial, ZERO_EFFECT_LOSS], list(final), list[float]()

    def fit_linear(self, structure: ModelStructure, x: Any) -> Any:
        return SimpleNamespace(loss=self._initial.pop(0), structure=structure, x=x)

    def fit_nonlinear(self, solution: Any) -> Any:
        self.optimized.append(solution.loss)
        return SimpleNamespace(loss=self._final.pop(0), structure=solution.structure, x=solution.x)

    def adapted(self, solution: Any, entries: Any) -> Any:
        np.testing.assert_array_equal(entries, np.arange(len(entries)) < len(entries) - 1)  # all but the gain
        return SimpleNamespace(loss=0.1 * solution.loss, structure=solution.structure, x=solution.x)

    def escape_local_minima(self, solution: Any) -> Any:
        return SimpleNamespace(loss=solution.loss - ESCAPE, structure=solution.structure, x=solution.x)

    def residuals(self, solution: Any) -> Any:
        return ()


@pytest.mark.parametrize(
    ("effect", "initial", "final", "optimized", "loss"),
    [
        ("joint_elasticity", (40.0, 90.0), (11.0, 9.0), [40.0], 11.0 - ESCAPE),  # reaches what screening promised
        ("joint_elasticity", (40.0, 90.0), (30.0, 9.0), [40.0, 90.0], 9.0 - ESCAPE),
        ("joint_elasticity", (101.0, 900.0), (11.0, 9.0), [], ZERO_EFFECT_LOSS),  # every start increases the loss
        ("joint_elasticity", (900.0, 99.0), (50.0, 9.0), [900.0, 99.0], 9.0 - ESCAPE),
        ("backlash", (101.0, 900.0), (30.0, 9.0), [101.0, 900.0], 9.0 - ESCAPE),  # multistart
        ("backlash", (40.0, 90.0), (11.0, 9.0), [40.0, 90.0], 9.0 - ESCAPE),
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


def test_nonlinear_parameters_of_the_model_move_with_an_effect_that_increases_the_loss_alone() -> None:
    rig, known = simulated_rig(), library()
    mechanism = mechanisms.create(rig)
    bent = ModelStructure(mechanism, rig, (Term("torque_map_exponent", known["torque_map_exponent"], (2,)),))
    x = np.zeros(len(bent.parameters))
    before: Any = SimpleNamespace(solution=SimpleNamespace(structure=bent, x=x, loss=100.0), terms=bent.terms)
    gain = Term("torque_gain_mismatch", known["torque_gain_mismatch"], (2,))
    candidate = Candidate(gain, (np.array([0.1]),), 10.0, 1, np.ones(1), np.ones((1, 1)), np.ones(0))
    split: Any = _Search((400.0,), (9.0,))
    best = CandidateSearch(split, known).add(before, candidate)
    assert (split.optimized, best.solution.loss) == ([40.0], 9.0 - ESCAPE)
