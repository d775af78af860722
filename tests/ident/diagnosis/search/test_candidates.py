"""Candidate effects for a model."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.search.candidates import Candidates
from ident.diagnosis.search.fits import Fits
from ident.diagnosis.search.screening import Candidate
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from recordings.rig import simulated_rig

ZERO_EFFECT_LOSS = 100.0
ESCAPE = 1.0
"""Reduction of the loss by an escape from a local minimum, from a fit that has reduced it."""


class _Search:
    """Data with given losses before and after the optimization from each start."""

    def __init__(self, initial: Sequence[float], final: Sequence[float]) -> None:
        self._initial, self._final, self.optimized = list(initial), list(final), list[float]()

    def fit_linear(self, structure: ModelStructure, x: Any) -> Any:
        return SimpleNamespace(loss=self._initial.pop(0), structure=structure, x=x)

    def fit_nonlinear(self, solution: Any) -> Any:
        self.optimized.append(solution.loss)
        return SimpleNamespace(loss=self._final.pop(0), structure=solution.structure, x=solution.x)

    def at(self, structure: ModelStructure, x: Any) -> Any:
        return SimpleNamespace(loss=ZERO_EFFECT_LOSS, structure=structure, x=x)

    def escape_local_minima(self, solution: Any) -> Any:
        return SimpleNamespace(loss=solution.loss - ESCAPE, structure=solution.structure, x=solution.x)

    def residuals(self, solution: Any) -> Any:
        return ()


@pytest.mark.parametrize(
    ("effect", "initial", "final", "optimized", "loss"),
    [
        ("joint_elasticity", (90.0, 40.0), (11.0, 9.0), [40.0], 11.0 - ESCAPE),  # the best start alone
        ("joint_elasticity", (101.0, 900.0), (99.0,), [101.0], 99.0 - ESCAPE),
        ("joint_elasticity", (101.0, 900.0), (100.1,), [101.0], ZERO_EFFECT_LOSS),  # no start leads below
        ("backlash", (101.0, 900.0), (30.0, 9.0), [101.0, 900.0], 9.0 - ESCAPE),  # multistart
    ],
)
def test_best_start_is_optimized_or_all_of_a_multistart(
    effect: str, initial: Sequence[float], final: Sequence[float], optimized: list[float], loss: float
) -> None:
    rig = simulated_rig()
    bare = ModelStructure(mechanisms.create(rig), rig)
    before: Any = SimpleNamespace(
        solution=SimpleNamespace(structure=bare, x=np.zeros(len(bare.parameters)), loss=100.0), terms=()
    )
    term = Term(effect, library()[effect], (0,))
    start = np.zeros(len(bare.with_term(term).parameters) - len(bare.parameters))
    candidate = Candidate(term, (start, start), 10.0, np.ones(1), np.ones((1, 1)), np.ones(0))
    split: Any = _Search(initial, final)
    best = Candidates(Fits(split), library()).add(before, candidate)
    assert (split.optimized, best.solution.loss) == (optimized, loss)
