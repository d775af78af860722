"""Which extensions of a model can be claimed."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.candidate_search import CandidateSearch
from ident.diagnosis.search.claims import Claims
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from tests.ident import building

DATA = building.split([building.record(noise=0.05, extra=lambda motion: 0.4 + 0.0 * motion.position)])


def claims() -> Claims:
    return Claims(CandidateSearch(DATA, library()))


def names(model: FittedModel) -> list[str]:
    return [term.name for term in model.terms]


def test_spring_without_stiffness_becomes_the_offset_that_it_contains() -> None:
    assert names(claims().simplified(building.fitted(DATA, "joint_spring"))) == ["torque_offset"]


def test_spring_without_stiffness_joins_the_offset_of_other_joints() -> None:
    recording = building.record(3, noise=0.05, extra=lambda motion: np.full_like(motion.position, 0.4))
    data = building.split([recording])
    before = building.structure(recording, "torque_offset", joints=(2,))
    structure = before.with_term(Term("joint_spring", library()["joint_spring"], (0, 1)))
    model = FittedModel(data, data.fit(structure, building.start(structure)))
    (term,) = Claims(CandidateSearch(data, library())).simplified(model).terms
    assert (term.name, term.joints) == ("torque_offset", (0, 1, 2))


def test_spring_that_a_later_effect_left_without_stiffness_becomes_an_offset() -> None:
    data = building.split(
        [building.record(noise=0.05, extra=lambda motion: 0.4 + motion.velocity * np.abs(motion.velocity))]
    )
    model = building.fitted(data, "joint_spring", "quadratic_friction")
    judged = Claims(CandidateSearch(data, library()))
    assert judged.simplified(model) is model  # only its last effect
    assert names(judged.all_simplified(model)) == ["quadratic_friction", "torque_offset"]


def test_spring_stays_where_the_library_lacks_what_it_contains() -> None:
    model = building.fitted(DATA, "joint_spring")
    without = {name: effect for name, effect in library().items() if name != "torque_offset"}
    assert Claims(CandidateSearch(DATA, without)).all_simplified(model) is model


@pytest.mark.parametrize(("truth", "joints"), [((0.4, 0.0, 0.4), (0, 2)), ((0.4, 0.4, 0.4), (0, 1, 2))])
def test_joints_without_the_effect_are_dropped(truth: tuple[float, ...], joints: tuple[int, ...]) -> None:
    recording = building.record(3, noise=0.05, extra=lambda motion: np.array(truth) + 0.0 * motion.position)
    data = building.split([recording])
    model = building.fitted(data, "torque_offset", "quadratic_friction", joints=(0, 1, 2))
    kept = Claims(CandidateSearch(data, library())).without_zero_joints(model)
    assert kept.terms[0].joints == joints
    assert [entry.name for entry in kept.solution.structure.parameters if entry.term == 0] == [
        f"torque_offset.a{joint + 1}" for joint in joints
    ]


def test_offset_of_a_simplified_spring_is_fitted_anew() -> None:
    model = claims().simplified(building.fitted(DATA, "joint_spring"))
    assert model.solution.x[-1] == pytest.approx(0.4, abs=0.01)


def test_effect_that_needs_no_simplification_stays() -> None:
    model = building.fitted(DATA, "torque_offset")
    assert claims().simplified(model) is model


def test_reason_of_a_refusal_is_kept() -> None:
    judged, model = claims(), building.fitted(DATA, "torque_offset")
    model = replace(model, solution=replace(model.solution, x=model.solution.x * [1.0, 1.0, 1.0, 1e-3]))
    accepted = building.fitted(DATA, "torque_offset")
    assert judged.plausible([accepted], building.fitted(DATA)) == [accepted]
    assert not judged.is_resolved(model)
    assert judged.refused == {"torque_offset": "its strength is zero within its interval"}


def _eccentric(share: float) -> list[FittedModel]:
    """Extensions of a model by the eccentricity of an encoder, too large, and by an offset; the first leaves `share`
    of the mean square of the second on test rows.
    """
    offset, eccentricity = building.fitted(DATA, "torque_offset"), building.fitted(DATA, "encoder_eccentricity")
    structure, x = eccentricity.solution.structure, eccentricity.solution.x.copy()
    x[structure.parameter_mask(0)] = [0.05, 0.05, 1.0]
    large = replace(eccentricity, solution=replace(eccentricity.solution, x=x))
    object.__setattr__(large, "residuals", tuple(np.sqrt(share) * residual for residual in offset.residuals))
    return [large, offset]


@pytest.mark.parametrize(("share", "believed"), [(0.1, True), (0.5, False)])
def test_extraordinary_size_needs_extraordinary_evidence(share: float, believed: bool) -> None:
    large, offset = _eccentric(share)
    judged = claims()
    plausible = judged.plausible([large, offset], building.fitted(DATA))
    assert [names(model) for model in plausible] == [["torque_offset"], *([["encoder_eccentricity"]] * believed)]
    assert "at most 0.0175 is plausible" in judged.refused["encoder_eccentricity"]


@pytest.mark.parametrize(("order", "kept"), [(4.0, False), (40.0, True)])
def test_effect_whose_shape_became_implausible_is_refused(order: float, kept: bool) -> None:
    model, judge = building.with_wave(order, "cogging", "torque_offset"), claims()
    assert judge.keeps_shape(model, 0) is kept
    assert ("cogging" in judge.refused) is not kept


def constant(joints: tuple[float, ...]) -> SplitData:
    return building.split(
        [building.record(3, noise=0.05, extra=lambda motion: np.array(joints) + 0 * motion.position)]
    )


@pytest.mark.parametrize(("truth", "joints"), [((0.4, 0.0, 0.4), (0, 2)), ((0.0, 0.4, 0.0), (1,))])
def test_effect_of_differences_is_claimed_on_the_fewest_joints_that_explain_as_much(
    truth: tuple[float, ...], joints: tuple[int, ...]
) -> None:
    data = constant(truth)
    offset = replace(library()["torque_offset"], differential=True)
    structure = building.structure(data.recordings[0].recording)
    structure = structure.with_term(Term("torque_offset", offset, (0, 2)))
    model = FittedModel(data, data.fit(structure, building.start(structure)))
    result = Claims(CandidateSearch(data, library())).on_fewest_joints(model)
    assert result.terms[0].joints == joints
    assert result.solution.x[-1] == pytest.approx(0.4, abs=0.01)


def test_effect_on_few_joints_is_not_moved_to_more() -> None:
    search = CandidateSearch(DATA, library())
    assert search.on_other_joints(building.fitted(DATA, "torque_offset"), 0) is None
