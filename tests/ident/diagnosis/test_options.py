"""What could be added to a model."""

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
NOTHING = 100.0


def state(effect: str, loss: float, parameters: int) -> Any:
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
def test_what_contains_another_is_none_beside_it_unless_it_explains_more(
    other: str, loss: float, expected: bool
) -> None:
    finder = CandidateSearch(SimpleNamespace(independent_rows=ROWS), library())  # type: ignore[arg-type]
    assert finder.is_redundant("torque_offset", state("torque_offset", ROWS, 13), state(other, loss, 14)) is expected


def _with_springs(motor: float, damping: float, told: bool = True) -> tuple[Any, Any]:
    """A model with springs on all joints, whose shapes are told by the data or not, and the one without."""
    rig = simulated_rig()
    before = ModelStructure(mechanisms.create(rig), rig)
    after = before.with_term(Term("joint_elasticity", library()["joint_elasticity"], (0, 1, 2)))
    own = np.ones(len(before.parameters))
    found = np.concatenate([own, [1e-3, 1e-3, 1e-3, motor, damping]])
    derivatives, weights = np.full((9, 3, len(found)), float(told)), np.ones((9, 3))
    return tuple(
        SimpleNamespace(
            solution=SimpleNamespace(composition=one, x=x, derivatives=(derivatives,), weights=(weights,), loss=27.0),
            terms=one.terms,
        )
        for one, x in ((after, found), (before, own))
    )


@pytest.mark.parametrize(
    ("motor", "damping", "expected"), [(0.4, 0.03, True), (0.0, 0.0, True), (0.98, 0.03, False), (0.4, 0.4, False)]
)
def test_a_search_that_ends_at_the_end_of_its_range_speaks_against_the_effect(
    motor: float, damping: float, expected: bool
) -> None:
    assert is_physical(*_with_springs(motor, damping)) is expected


@pytest.mark.parametrize(("lines", "expected"), [(5.0, False), (5.5, True), (2000.0, True)])
def test_a_wave_that_asks_to_be_slower_than_any_ripple_is_none(lines: float, expected: bool) -> None:
    rig = simulated_rig()
    before = ModelStructure(mechanisms.create(rig), rig)
    after = before.with_term(Term("cogging", library()["cogging"], (0,)))
    own = np.ones(len(before.parameters))
    x = np.concatenate([own, [0.3, 0.1, lines]])
    told: Any = {"derivatives": (np.ones((9, 3, len(x))),), "weights": (np.ones((9, 3)),), "loss": 27.0}
    with_it, without = (
        SimpleNamespace(solution=SimpleNamespace(composition=one, x=values, **told), terms=one.terms)
        for one, values in ((after, x), (before, own))
    )
    assert is_physical(with_it, without) is expected  # type: ignore[arg-type]


def test_a_shape_that_the_data_do_not_tell_may_end_anywhere() -> None:
    assert is_physical(*_with_springs(0.98, 0.12, told=False))


def test_an_effect_may_be_on_one_more_joint() -> None:
    rig, known = simulated_rig(), library()
    narrow = ModelStructure(mechanisms.create(rig), rig, (Term("stribeck", known["stribeck"], (0, 2)),))
    own = np.arange(float(len(mechanisms.create(rig).parameters)))
    solution = SimpleNamespace(composition=narrow, x=np.concatenate([own, [1.0, 3.0, 0.1]]))
    material = SimpleNamespace(
        solve=lambda composition, x: SimpleNamespace(composition=composition, x=x), residuals=lambda solution: ()
    )
    finder = CandidateSearch(material, known)  # type: ignore[arg-type]
    (wider,) = finder.joint_extensions(SimpleNamespace(solution=solution, terms=narrow.terms), [0, 1])  # type: ignore[arg-type]
    assert [term.joints for term in wider.terms] == [(0, 1, 2)]
    np.testing.assert_array_equal(wider.solution.x, [*own, 1.0, 2.0, 3.0, 0.1])


class _Search:
    """Material whose fits begin and end at losses that were told beforehand, start by start."""

    def __init__(self, begun: Sequence[float], found: Sequence[float]) -> None:
        self._begun, self._found, self.searched = [*begun, NOTHING], list(found), list[float]()

    def begun(self, composition: ModelStructure, x: Any) -> Any:
        return SimpleNamespace(loss=self._begun.pop(0), composition=composition, x=x)

    def improved(self, begun: Any) -> Any:
        self.searched.append(begun.loss)
        return SimpleNamespace(loss=self._found.pop(0), composition=begun.composition, x=begun.x)

    def residuals(self, solution: Any) -> Any:
        return ()


@pytest.mark.parametrize(
    ("effect", "begun", "found", "searched", "loss"),
    [
        ("joint_elasticity", (40.0, 90.0), (11.0, 9.0), [40.0], 11.0),  # what was promised has been found
        ("joint_elasticity", (40.0, 90.0), (30.0, 9.0), [40.0, 90.0], 9.0),
        ("joint_elasticity", (101.0, 900.0), (11.0, 9.0), [], NOTHING),  # worse than nothing from everywhere
        ("joint_elasticity", (900.0, 99.0), (50.0, 9.0), [900.0, 99.0], 9.0),
        ("backlash", (101.0, 900.0), (30.0, 9.0), [101.0, 900.0], 9.0),  # a landscape of many valleys
        ("backlash", (40.0, 90.0), (11.0, 9.0), [40.0, 90.0], 9.0),
    ],
)
def test_a_search_goes_on_from_another_start_as_long_as_that_is_worth_it(
    effect: str, begun: Sequence[float], found: Sequence[float], searched: list[float], loss: float
) -> None:
    rig = simulated_rig()
    bare = ModelStructure(mechanisms.create(rig), rig)
    before: Any = SimpleNamespace(
        solution=SimpleNamespace(composition=bare, x=np.zeros(len(bare.parameters)), loss=100.0), terms=()
    )
    term = Term(effect, library()[effect], (0,))
    start = np.zeros(len(bare.with_term(term).parameters) - len(bare.parameters))
    candidate = Candidate(term, (start, start), 10.0, 2, np.ones(1), np.ones((1, 1)), np.ones(0))
    material: Any = _Search(begun, found)
    best = CandidateSearch(material, library()).add(before, candidate)
    assert (material.searched, best.solution.loss) == (searched, loss)
