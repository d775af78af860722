"""Rules of plausibility: what cannot be true, whatever the fit says; and what parameters cost."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.price import EXTRAORDINARY_RATIO, PRICE, is_significant, score
from ident.diagnosis.judge.rules import OF_INTERVALS, OF_VALUES, objection
from ident.diagnosis.judge.rules.limits import extraordinary_joints
from ident.diagnosis.judge.rules.strength import local_entries, resolved_instances
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from ident.dynamics.torque_map import voltage_from_torque
from recordings.recording import Floats
from tests.ident import building

LIBRARY = library()


def implausibility(after: FittedModel, before: FittedModel, index: int = -1) -> str | None:
    """The reason against the effect `index` of `after` by its values."""
    found = objection(OF_VALUES, before, after, index % len(after.terms))
    return found and found[1]


def unresolved(after: FittedModel) -> str | None:
    """The reason by the intervals of the last effect of `after`."""
    found = objection(OF_INTERVALS, after, after, len(after.terms) - 1)
    return found and found[1]


def says(reason: str | None, expected: str | None) -> bool:
    return reason is None if expected is None else expected in str(reason)


def data(noise: float = 0.05, extra: building.Torque | None = None) -> SplitData:
    return building.split([building.record(noise=noise, extra=extra, seed=3)])


def with_values(before: FittedModel, name: str, effect: Effect, *values: float) -> FittedModel:
    """`before` with one more effect of the given parameters."""
    structure = before.solution.structure.with_term(Term(name, effect, (0,)))
    return FittedModel(before.split, before.split.at(structure, np.append(before.solution.x, values)))


@pytest.mark.parametrize(
    ("name", "values", "reason"),
    [
        ("encoder_eccentricity", (0.012, 0.012, 1.0), None),
        ("thermal_drift", (0.1, 0.1, -40.0), None),
        ("thermal_drift", (0.1, 0.1, -6014.0), "far longer than the recording of 1"),
        ("thermal_drift", (0.1, 0.1, 0.5), "shorter than the 2 s that it takes"),
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
    assert says(implausibility(with_values(before, name, LIBRARY[name], *values), before), reason)


@pytest.mark.parametrize("held_out", [True, False])
def test_level_is_known_where_held_out_recordings_approach_it(held_out: bool) -> None:
    slow, fast = building.record(noise=0.05, size=0.2, seed=3), building.record(noise=0.05, shape=1, seed=4)
    split = building.split([slow], [fast] if held_out else [])
    largest = np.nanmax(np.abs(voltage_from_torque(building.prepared(fast).torque, fast.rig.torque)))
    before = building.fitted(split)
    after = with_values(before, "amplifier_saturation", LIBRARY["amplifier_saturation"], 0.6 / largest, 6.0)
    assert ("never approached" in str(implausibility(after, before))) is not held_out


@pytest.mark.parametrize(("periods", "reason"), [(0.9, "a curve over the angle, no ripple"), (1.1, None)])
def test_wave_with_a_period_longer_than_the_travel_is_no_ripple(periods: float, reason: str | None) -> None:
    before = building.fitted(data())
    position = before.split.recordings[0].motion.position
    travel = float(np.nanmax(position) - np.nanmin(position))
    # Any lower end of the range: the rule is not that of the range.
    cogging = replace(LIBRARY["cogging"], shapes=(replace(LIBRARY["cogging"].shapes[0], lower=0.1),))
    model = with_values(before, "cogging", cogging, 0.1, 0.1, 2 * np.pi * periods / travel)
    model = replace(
        model, solution=replace(model.solution, derivatives=(np.zeros((9, 1, 6)),), weights=(np.zeros((9, 1)),))
    )
    assert says(implausibility(model, before), reason)


@pytest.mark.parametrize(
    ("bound", "plausible_range", "guess", "noise", "refused"),
    [
        ("upper", (1.0, 1.4), 1.2, 0.05, True),
        ("upper", (1.0, 1.4), 1.2, 50.0, False),  # the data do not tell the shape
        ("lower", (1.0, 1.4), 1.2, 0.05, False),  # the other end
        ("lower", (2.2, 2.6), 2.4, 0.05, True),
        ("upper", (1.0, 2.6), 1.2, 0.05, False),
    ],
)
def test_shape_at_the_implausible_end_of_its_range_is_no_shape(
    bound: Any, plausible_range: tuple[float, float], guess: float, noise: float, refused: bool
) -> None:
    """Friction that grows with the power 1.8 of the speed."""

    def friction(motion: Motion) -> Floats:
        torque: Floats = np.abs(motion.velocity) ** 1.8 * motion.direction - building.VISCOUS * motion.velocity
        return torque

    before = building.fitted(data(noise, friction))
    law, (lower, upper) = LIBRARY["power_law_friction"], plausible_range
    shape = replace(law.shapes[0], lower=lower, upper=upper, initial_guesses=(guess,), implausible_bound=bound)
    structure = before.solution.structure.with_term(Term("law", replace(law, shapes=(shape,)), (0,)))
    after = FittedModel(before.split, before.split.fit(structure, np.array([*building.parameters(), 1.0, guess])))
    reason = "the search for its alpha ended at the end of the plausible range"
    assert implausibility(after, before) == (reason if refused else None)


@pytest.mark.parametrize(("order", "reason"), [(4.0, "end of the plausible range"), (40.0, None)])
def test_shape_of_each_effect_is_judged_whatever_stands_behind_it(order: float, reason: str | None) -> None:
    model = building.with_wave(order, "cogging", "joint_spring")
    assert says(implausibility(model, building.fitted(model.split, "joint_spring"), 0), reason)


def test_extraordinary_size_has_a_price() -> None:
    before = building.fitted(data())
    usual, large = (
        with_values(before, "encoder_eccentricity", LIBRARY["encoder_eccentricity"], 0.0, size, 1.0)
        for size in (0.017, 0.018)
    )
    for model in (usual, large):
        object.__setattr__(model, "residuals", before.residuals)
        object.__setattr__(model, "noise_floor", before.noise_floor)
    rows = float(before.split.independent(before.split.scored).sum())
    assert score(large) - score(usual) == pytest.approx(rows * np.log(EXTRAORDINARY_RATIO))


@pytest.mark.parametrize(
    ("name", "values", "drift", "seldom"),
    [
        ("actuation_delay", (0.002,), 0.0, False),
        ("actuation_delay", (0.009,), 0.0, True),
        ("joint_spring", (0.1, 0.0), 0.0, False),
        ("joint_spring", (0.001, 0.0), 1.0, True),  # over more than two turns
        ("axis_weight", (0.5, 0.5), 0.0, False),
        ("axis_weight", (50.0, 50.0), 0.0, True),  # the drive gives less
    ],
)
def test_what_hardware_seldom_has(name: str, values: tuple[float, ...], drift: float, seldom: bool) -> None:
    before = building.fitted(building.split([building.record(noise=0.05, drift=drift)]))
    model = with_values(before, name, LIBRARY[name], *values)
    assert bool(extraordinary_joints(model, len(model.terms) - 1)) is seldom


@pytest.mark.parametrize("parameters", [1, 7])
def test_every_parameter_has_to_earn_its_price(parameters: int) -> None:
    """Each explains 1 in 1,000 of the loss that is left by fitting noise alone, with 1,000 independent rows."""
    worth = PRICE * parameters / 1000
    assert is_significant(1.01 + worth, 1.0, parameters, 1000)
    assert not is_significant(0.99 + worth, 1.0, parameters, 1000)


@pytest.mark.parametrize(("noise", "refused"), [(0.05, True), (20.0, False)])
def test_effect_that_surely_makes_friction_drive_the_motion_is_refused(noise: float, refused: bool) -> None:
    recording = building.record(noise=noise, extra=lambda motion: -2.0 * np.sign(motion.velocity))
    after = building.fitted(building.split([recording]), "torque_offset")
    before = building.fitted(after.split)
    coulomb = [entry.name == "c_c1" for entry in before.solution.structure.parameters]
    before = replace(before, solution=replace(before.solution, x=np.where(coulomb, 0.1, before.solution.x)))
    reason = implausibility(after, before)
    assert reason == ("c_c1 would get a value that is not possible" if refused else None)


def spring(stiffness: float) -> building.Torque:
    """A spring with a rest angle, or an offset alone."""
    return lambda motion: 0.4 + stiffness * motion.position


def fading(dry: float) -> building.Torque:
    """Friction that fades, with a dry part of any sign."""

    def torque(motion: Motion) -> Floats:
        time = np.arange(len(motion.position))[:, None] / building.RATE
        return (0.5 * motion.velocity + dry * np.sign(motion.velocity)) * np.exp(-time / 6.0)

    return torque


@pytest.mark.parametrize(
    ("effect", "extra", "reason"),
    [
        ("quadratic_friction", building.drag, None),
        ("quadratic_friction", None, "its strength is zero within its interval"),
        ("thermal_drift", fading(0.5), None),
        ("thermal_drift", fading(-0.5), "its parts would need opposite signs"),
        ("joint_spring", spring(0.5), None),
        ("joint_spring", spring(0.0), "it does not differ from torque_offset"),
    ],
)
def test_intervals_leave_no_doubt_of_what_is_found(
    effect: str, extra: building.Torque | None, reason: str | None
) -> None:
    assert unresolved(building.fitted(data(extra=extra), effect)) == reason


def test_drift_whose_direction_in_time_is_unknown_is_not_believed() -> None:
    """Its time constant may be negative, with so little of it in the noise."""
    model = building.fitted(data(extra=lambda motion: 0.02 * np.sign(motion.velocity)), "thermal_drift")
    strong = np.where([entry.name == "thermal_drift.b1" for entry in model.solution.structure.parameters], 50.0, 0.0)
    model = replace(model, solution=replace(model.solution, x=model.solution.x + strong))
    assert unresolved(model) == "its T is zero within its interval"


@pytest.mark.parametrize(("size", "encoder_step", "resolved"), [(0.3, 1e-3, True), (0.05, 3e-3, False)])
def test_knots_of_a_curve_err_together(size: float, encoder_step: float, resolved: bool) -> None:
    """The first curve is there, though each of its knots may be zero; the second is made by coarse encoders."""
    recording = building.record(
        noise=0.05, encoder_step=encoder_step, extra=lambda motion: size * np.sin(2.2 * motion.position)
    )
    search, begin = building.search(building.split([recording]), {"position_torque": LIBRARY["position_torque"]})
    model = search.add(search.start(*begin)[0], "position_torque")
    entries = local_entries(model, 0)[0]
    assert (np.abs(model.solution.x[entries]) < 2 * model.standard_errors[entries]).all() == resolved
    assert resolved_instances(model, 0) == [resolved]


def test_effect_is_not_named_on_joints_where_its_reported_interval_holds_zero() -> None:
    """Encoder steps repeat with the motion: the residual's noise alone makes a strength of the first joint."""
    coarse = building.split([building.record(3, noise=0.01, encoder_step=0.001)])
    model = building.fitted(coarse, "quadratic_friction")
    assert abs(model.solution.x[-3]) > model.uncertainty.half_width()[-3]
    assert resolved_instances(model, 0) == [False, False, False]
