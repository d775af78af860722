"""Rules of plausibility: what cannot be true, whatever the fit says."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Improvement
from ident.diagnosis.judge.price import EXTRAORDINARY_RATIO, score
from ident.diagnosis.judge.rules import OF_INTERVALS, OF_VALUES, objection
from ident.diagnosis.judge.rules.strength import local_entries, resolved_instances
from ident.diagnosis.search.search import Search
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics import mechanisms
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from ident.dynamics.torque_map import voltage_from_torque
from recordings.recording import Floats
from recordings.rig import simulated_rig
from tests.ident import building


def implausibility(after: Any, before: Any, index: int = -1) -> str | None:
    found = objection(OF_VALUES, before, after, index % len(after.terms))
    return found and found[1]


def is_physical(after: Any, before: Any) -> bool:
    return implausibility(after, before) is None


def unresolved(after: FittedModel) -> str | None:
    """The reason by the intervals of the last effect of `after`."""
    found = objection(OF_INTERVALS, after, after, len(after.terms) - 1)
    return found and found[1]


def _with_springs(motor: float, damping: float, supported: bool = True) -> tuple[Any, Any]:
    """A model with springs on all joints, and the model without springs.

    supported: whether test rows confirm the model over one with a shape inside of its range.
    """
    rig = simulated_rig()
    before = ModelStructure(mechanisms.create(rig), rig)
    after = before.with_term(Term("joint_elasticity", library()["joint_elasticity"], (0, 1, 2)))
    mechanism = np.ones(len(before.parameters))
    x = np.concatenate([mechanism, [1e-3, 1e-3, 1e-3, motor, damping]])
    derivatives, weights = np.ones((9, 3, len(x))), np.ones((9, 3))
    return tuple(
        SimpleNamespace(
            solution=SimpleNamespace(
                structure=structure, x=values, derivatives=(derivatives,), weights=(weights,), loss=27.0
            ),
            terms=structure.terms,
            split=SimpleNamespace(fit=lambda structure, x: SimpleNamespace(x=x)),
            improvement_over=partial(_improvement, supported),
        )
        for structure, values in ((after, x), (before, mechanism))
    )


def _improvement(supported: bool, inside: FittedModel) -> Improvement:
    """Of a spring with a shape at the end of its range over one in which it has the nearest initial guess."""
    assert tuple(inside.solution.x[-2:]) in {(0.7, 0.03), (0.7, 0.12), (0.4, 0.2)}
    return Improvement(0.5, (0.3, 0.7), 9.0, 1.0, 1.0) if supported else Improvement(0.0, (-0.1, 0.1), 0.2, 0.0, 1.0)


@pytest.mark.parametrize(
    ("motor", "damping", "expected"), [(0.4, 0.03, True), (0.0, 0.0, True), (0.98, 0.03, False), (0.4, 0.4, False)]
)
def test_effect_with_a_shape_at_the_limit_of_its_range_is_rejected(
    motor: float, damping: float, expected: bool
) -> None:
    assert is_physical(*_with_springs(motor, damping)) is expected


def test_shape_that_the_data_do_not_tell_may_end_anywhere() -> None:
    assert is_physical(*_with_springs(0.98, 0.12, supported=False))


def data(noise: float = 0.05, extra: building.Torque | None = None) -> SplitData:
    return building.split([building.record(noise=noise, extra=extra, seed=3)])


def with_values(before: FittedModel, name: str, effect: Effect, *values: float) -> FittedModel:
    """`before` with one more effect of the given parameters."""
    structure = before.solution.structure.with_term(Term(name, effect, (0,)))
    return FittedModel(
        before.split, replace(before.solution, structure=structure, x=np.append(before.solution.x, values))
    )


@pytest.mark.parametrize(
    ("name", "values", "reason"),
    [
        ("encoder_eccentricity", (0.012, 0.012, 1.0), None),
        ("thermal_drift", (0.1, 0.1, -40.0), None),
        ("thermal_drift", (0.1, 0.1, -6014.0), "far longer than the recording of 1"),
        ("amplifier_saturation", (0.6, 6.0), None),
        ("amplifier_saturation", (0.001, 6.0), "never approached"),
        ("joint_spring", (-0.1, 0.2), "a sign that is not possible"),
        ("joint_spring", (0.1, -0.2), None),
    ],
)
def test_effect_beyond_its_plausible_limits_is_refused_with_the_reason(
    name: str, values: tuple[float, ...], reason: str | None
) -> None:
    before = building.fitted(data())
    refused = implausibility(with_values(before, name, library()[name], *values), before)
    assert refused is None if reason is None else reason in str(refused)


@pytest.mark.parametrize("held_out", [True, False])
def test_level_is_known_where_held_out_recordings_approach_it(held_out: bool) -> None:
    slow, fast = building.record(noise=0.05, size=0.2, seed=3), building.record(noise=0.05, shape=1, seed=4)
    split = building.split([slow], [fast] if held_out else [])
    largest = np.nanmax(np.abs(voltage_from_torque(building.prepared(fast).torque, fast.rig.torque)))
    before = building.fitted(split)
    after = with_values(before, "amplifier_saturation", library()["amplifier_saturation"], 0.6 / largest, 6.0)
    assert ("never approached" in str(implausibility(after, before))) is not held_out


@pytest.mark.parametrize(("periods", "plausible"), [(0.9, False), (1.1, True)])
def test_wave_with_a_period_longer_than_the_travel_is_no_ripple(periods: float, plausible: bool) -> None:
    before = building.fitted(data())
    position = before.split.recordings[0].motion.position
    travel = float(np.nanmax(position) - np.nanmin(position))
    # Any lower end of the range: the rule is not that of the range.
    cogging = replace(library()["cogging"], shapes=(replace(library()["cogging"].shapes[0], lower=0.1),))
    model = with_values(before, "cogging", cogging, 0.1, 0.1, 2 * np.pi * periods / travel)
    model = replace(
        model, solution=replace(model.solution, derivatives=(np.zeros((9, 1, 6)),), weights=(np.zeros((9, 1)),))
    )
    assert is_physical(model, before) is plausible


@pytest.mark.parametrize(("order", "reason"), [(4.0, "end of the plausible range"), (40.0, None)])
def test_shape_of_each_effect_is_judged_whatever_stands_behind_it(order: float, reason: str | None) -> None:
    model = building.with_wave(order, "cogging", "joint_spring")
    before = building.fitted(model.split, "joint_spring")
    refused = implausibility(model, before, 0)
    assert refused is None if reason is None else reason in str(refused)


def test_extraordinary_size_has_a_price() -> None:
    before = building.fitted(data())
    usual, large = (
        with_values(before, "encoder_eccentricity", library()["encoder_eccentricity"], 0.0, size, 1.0)
        for size in (0.017, 0.018)
    )
    for model in (usual, large):
        object.__setattr__(model, "residuals", before.residuals)
        object.__setattr__(model, "noise_floor", before.noise_floor)
    rows = float(before.split.independent(before.split.scored).sum())
    assert score(large) - score(usual) == pytest.approx(rows * np.log(EXTRAORDINARY_RATIO))


@pytest.mark.parametrize(("noise", "refused"), [(0.05, True), (20.0, False)])
def test_effect_that_surely_makes_friction_drive_the_motion_is_refused(noise: float, refused: bool) -> None:
    recording = building.record(noise=noise, extra=lambda motion: -2.0 * np.sign(motion.velocity))
    after = building.fitted(building.split([recording]), "torque_offset")
    before = building.fitted(after.split)
    coulomb = [entry.name == "c_c1" for entry in before.solution.structure.parameters]
    before = replace(before, solution=replace(before.solution, x=np.where(coulomb, 0.1, before.solution.x)))
    reason = implausibility(after, before)
    assert reason == ("c_c1 would get a value that is not possible" if refused else None)


def drag(motion: Motion) -> Floats:
    return 0.3 * motion.velocity * np.abs(motion.velocity)


@pytest.mark.parametrize(("extra", "reason"), [(drag, None), (None, "its strength is zero within its interval")])
def test_strength_that_may_be_zero_is_not_resolved(extra: building.Torque | None, reason: str | None) -> None:
    assert unresolved(building.fitted(data(extra=extra), "quadratic_friction")) == reason


@pytest.mark.parametrize(("size", "encoder_step", "resolved"), [(0.3, 1e-3, True), (0.05, 3e-3, False)])
def test_knots_of_a_curve_err_together(size: float, encoder_step: float, resolved: bool) -> None:
    """The first curve is there, though each of its knots may be zero; the second is made by coarse encoders."""

    def curve(motion: Motion) -> Floats:
        return size * np.sin(2.2 * motion.position)

    recording = building.record(noise=0.05, encoder_step=encoder_step, extra=curve)
    search = Search(building.split([recording]), {"position_torque": library()["position_torque"]}, lambda text: None)
    structure = building.structure(recording)
    model = search.add(search.start(structure, building.start(structure))[0], "position_torque")
    entries = local_entries(model, 0)[0]
    assert (np.abs(model.solution.x[entries]) < 2 * model.standard_errors[entries]).all() == resolved
    assert resolved_instances(model, 0) == [resolved]


def test_effect_is_not_named_on_joints_where_its_reported_interval_holds_zero() -> None:
    """Encoder steps repeat with the motion: the residual's noise alone makes a strength of the first joint."""
    coarse = building.split([building.record(3, noise=0.01, encoder_step=0.001)])
    model = building.fitted(coarse, "quadratic_friction")
    assert abs(model.solution.x[-3]) > model.uncertainty.half_width()[-3]
    assert resolved_instances(model, 0) == [False, False, False]


@pytest.mark.parametrize(("dry", "reason"), [(0.5, None), (-0.5, "its parts would need opposite signs")])
def test_friction_that_fades_in_one_part_and_grows_in_the_other_is_not_believed(
    dry: float, reason: str | None
) -> None:
    def fading(motion: Motion) -> Floats:
        time = np.arange(len(motion.position))[:, None] / building.RATE
        return (0.5 * motion.velocity + dry * np.sign(motion.velocity)) * np.exp(-time / 6.0)

    assert unresolved(building.fitted(data(extra=fading), "thermal_drift")) == reason


def test_drift_whose_direction_in_time_is_unknown_is_not_believed() -> None:
    """Its time constant may be negative, with so little of it in the noise."""
    model = building.fitted(data(extra=lambda motion: 0.02 * np.sign(motion.velocity)), "thermal_drift")
    strong = np.where([entry.name == "thermal_drift.b1" for entry in model.solution.structure.parameters], 50.0, 0.0)
    model = replace(model, solution=replace(model.solution, x=model.solution.x + strong))
    assert unresolved(model) == "its T is zero within its interval"


@pytest.mark.parametrize(("stiffness", "reason"), [(0.0, "it does not differ from torque_offset"), (0.5, None)])
def test_spring_without_stiffness_is_an_offset(stiffness: float, reason: str | None) -> None:
    split = data(extra=lambda motion: 0.4 + stiffness * motion.position)
    assert unresolved(building.fitted(split, "joint_spring")) == reason
