"""A mechanism with effects as one vector of parameters."""

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effects.library import load
from ident.dynamics.structure import ModelStructure, Term
from recordings.rig import simulated_rig
from tests.ident import building

RIG = simulated_rig()
BARE = ModelStructure(mechanisms.create(RIG), RIG)
STRIBECK = Term("stribeck", load("stribeck"), (0, 2))
OFFSETS = Term("encoder_zero_offset", load("encoder_zero_offset"), (1,))


def test_parameters_are_the_mechanisms_then_each_terms_by_joint_then_its_shapes() -> None:
    structure = BARE.with_term(STRIBECK).with_term(OFFSETS)
    names = [entry.name for entry in structure.parameters[len(BARE.parameters) :]]
    assert names == ["stribeck.a1", "stribeck.a3", "stribeck.v_s", "encoder_zero_offset.c2"]
    assert [entry.linear for entry in structure.parameters[-4:]] == [True, True, False, False]
    assert [parameter.name for parameter in structure.linear_parameters[-2:]] == names[:2]


def test_values_of_a_term_are_found_in_the_vector() -> None:
    structure = BARE.with_term(OFFSETS).with_term(STRIBECK)
    x = np.arange(float(len(structure.parameters)))
    np.testing.assert_array_equal(structure.local_values(1, x), x[-3:-1, None])
    np.testing.assert_array_equal(structure.shape_values(1, x), x[-1:])
    np.testing.assert_array_equal(structure.signal_values(0, x)["c"], [0.0, x[-4], 0.0])
    shorter = structure.without_term(0)
    assert [term.name for term in shorter.terms] == ["stribeck"]
    np.testing.assert_array_equal(shorter.local_values(0, x[~structure.parameter_mask(0)]), x[-3:-1, None])


def test_an_effect_takes_the_place_of_friction_on_its_joints() -> None:
    model = building.structure(building.record(2), "power_law_friction", joints=(1,))
    motion = building.motion_of(2)
    columns = model.mechanism_columns(model.mechanism.regressor(motion))
    assert [parameter.name for parameter in model.linear_parameters] == [
        *("I_1", "I_2", "c_v1", "c_c1", "c_c2"),
        "power_law_friction.c2",
    ]
    np.testing.assert_array_equal(columns, np.delete(model.mechanism.regressor(motion), 3, axis=2))
    np.testing.assert_array_equal(model.mechanism_values(np.arange(1.0, 7.0)), [1, 2, 3, 0, 4, 5])
    replaced = model.parameters[3]
    assert (replaced.name, replaced.linear, replaced.free) == ("c_v2", False, False)


def test_a_repeated_effect_is_numbered() -> None:
    line = Term("cogging", load("cogging"), (0,))
    names = [entry.name for entry in BARE.with_term(line).with_term(line).parameters[-6:]]
    assert names == ["cogging.a1", "cogging.b1", "cogging.N", "cogging#2.a1", "cogging#2.b1", "cogging#2.N"]


def test_reports_follow_in_the_order_of_the_terms() -> None:
    structure = BARE
    for name in ("torque_gain_mismatch", "stribeck", "amplifier_deadband"):
        structure = structure.with_term(Term(name, load(name), (0, 1, 2)))
    assert [term.name for term, _ in structure.reports(np.zeros(len(structure.parameters)))] == [
        "torque_gain_mismatch",
        "amplifier_deadband",
    ]


def test_joints_may_have_shapes_of_their_own() -> None:
    term = Term("position_dependent_friction", load("position_dependent_friction"), (0, 2))
    structure = BARE.with_term(term).with_term(OFFSETS)
    names = [entry.name.partition(".")[2] for entry in structure.parameters[len(BARE.parameters) :]]
    assert names[18:] == ["low1", "high1", "low3", "high3", "c2"]
    x = np.arange(float(len(structure.parameters)))
    shapes = structure.shapes_by_name(0, x)
    low1, high1, low3, high3 = x[-5:-1]
    np.testing.assert_array_equal(shapes["low"], [low1, low1, low3])
    np.testing.assert_array_equal(shapes["high"], [high1, high1, high3])
    first, third = structure.instance_entries(0)
    np.testing.assert_array_equal(x[first], [*x[-23:-14], low1, high1])
    np.testing.assert_array_equal(x[third], [*x[-14:-5], low3, high3])
    np.testing.assert_array_equal(structure.instance_entries(1), [[len(x) - 1]])
