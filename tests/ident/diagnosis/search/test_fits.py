"""Models that are fitted once, and the changes that lead from one to another."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.fits import Fits, added_term
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from tests.ident import building


def constant(*joints: float) -> SplitData:
    """Three joints with these offsets."""
    return building.split(
        [building.record(3, noise=0.05, extra=lambda motion: np.array(joints) + 0 * motion.position)]
    )


def test_each_model_is_fitted_once_and_the_best_fit_counts() -> None:
    data = constant(0.4, 0.4, 0.4)
    fits, model = Fits(data), building.fitted(data, "torque_offset")
    assert fits.best(model) is model
    assert fits.fit(model.solution.structure, model.solution.x) is model
    worse = replace(model, solution=replace(model.solution, residuals=tuple(2 * r for r in model.solution.residuals)))
    assert fits.best(worse) is model


def test_effect_moves_to_the_other_joints() -> None:
    data, joints = constant(0.0, 0.4, 0.0), (1,)
    offset = library()["torque_offset"]
    structure = building.structure(data.recordings[0].recording)
    structure = structure.with_term(Term("torque_offset", offset, (0, 2)))
    model = FittedModel(data, data.fit(structure, building.start(structure)))
    other = Fits(data).on_joints(model, 0, joints)
    assert other.terms[0].joints == joints
    assert other.solution.x[-1] == pytest.approx(0.4, abs=0.01)


def test_effect_on_more_joints_starts_from_those_that_have_it() -> None:
    data = constant(0.4, 0.4, 0.0)
    model = building.fitted(data, "stribeck", "torque_offset", joints=(0,))
    wider = Fits(data).on_joints(model, 1, (0, 1, 2))
    assert wider.terms[added_term(model, wider)].joints == (0, 1, 2)
    np.testing.assert_allclose(wider.solution.x[-3:], [0.4, 0.4, 0.0], atol=0.02)


def test_effect_on_fewer_joints_keeps_the_values_of_the_others() -> None:
    data = constant(0.4, 0.0, -0.4)
    model = building.fitted(data, "torque_offset", "quadratic_friction")
    narrow = Fits(data).on_joints(model, 0, (0, 2))
    names = [entry.name for entry in narrow.solution.structure.parameters if entry.term == 0]
    assert names == ["torque_offset.a1", "torque_offset.a3"]
    np.testing.assert_allclose(narrow.solution.x[[9, 10]], [0.4, -0.4], atol=0.02)
