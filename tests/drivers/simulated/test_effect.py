"""Properties of all hidden effects that are discovered."""

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, build, discover, library, out_of_library
from ident.dynamics.effects.library import library as candidates
from recordings.errors import BadInput
from tests.drivers.simulated.swinging import powered

VARIABLES = {"position", "velocity", "acceleration", "load", "time", "frequency", "joint_1", "joint_2", "joint_3"}
every = pytest.mark.parametrize("kind", [pytest.param(kind, id=name) for name, kind in sorted(discover().items())])


def test_library_has_a_twin_of_every_effect_that_a_diagnosis_tries_and_others_have_none() -> None:
    # The plant always has the inertia of its rods; it has no single axes or couplings, and its drives no thermometer.
    without = {"rod_inertia", "axis_weight", "temperature_friction", "coupled_joint_friction"}
    assert set(library()) == set(candidates(())) - without
    assert len(out_of_library()) >= 3
    assert set(out_of_library()) == set(discover()) - set(candidates(()))


@every
def test_dependences_parameters_and_joints_are_valid(kind: type[HiddenEffect]) -> None:
    rng = np.random.default_rng(2)
    assert set(kind().depends_on()) <= VARIABLES
    assert kind().depends_on() or kind.name() == "torque_offset"
    candidate = candidates(()).get(kind.name())
    if candidate and candidate.max_amplitude:
        assert kind.largest() <= candidate.max_amplitude
    for name in kind.model_fields.keys() - {"joints"}:
        with pytest.raises(BadInput, match=f"effect {kind.name()}: '{name}'"):
            build(EffectSpec(name=kind.name(), parameters={name: 1e9}))
    for _ in range(10):
        spec = EffectSpec(name=kind.name(), joints=kind.draw_joints(rng), parameters=kind.draw_shape(rng))
        assert build(build(spec).spec()) == build(spec)


@every
def test_strength_changes_the_machine_and_none_leaves_it_as_it_is(kind: type[HiddenEffect]) -> None:
    assert _moved(kind().scaled(0.0)) == pytest.approx(_moved(), abs=1e-9)
    assert _moved(kind().at(0.05)) != pytest.approx(_moved(), abs=1e-6)


def test_machine_runs_with_all_effects() -> None:
    assert np.all(np.abs(_moved(*(kind() for kind in discover().values()))) < 20.0)


def _moved(*effects: HiddenEffect) -> list[float]:
    """Positions and torques after a motion of 0.2 s without load reversal."""
    config = SimConfig(effects=tuple(effect.spec() for effect in effects))
    machine = powered(config)
    start = np.array(machine.position())
    ease = 0.5 - 0.5 * np.cos(np.linspace(0.0, 3.0, 1000))
    machine.advance((start + ease[:, None] * np.array([0.2, 0.1, -0.1])).tolist())
    return machine.position() + machine.reported_torque()


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        (EffectSpec(name="stribek"), "stribeck.*'stribek' found"),
        (EffectSpec(name="stribeck", parameters={"vs": 1.0}), "unknown key 'vs'"),
        (EffectSpec(name="base_tilt", joints=(1,)), "whole robot"),
        (EffectSpec(name="cogging", joints=()), "joints"),
        (EffectSpec(name="cogging", joints=(2, 2)), "joints"),
        (EffectSpec(name="hose_drag", joints=(2,)), r"two or three expected, \[2\] found"),
        (EffectSpec(name="cogging", size=0.02), "its size must be converted"),
    ],
)
def test_bad_effect_is_explained(spec: EffectSpec, complaint: str) -> None:
    with pytest.raises(BadInput, match=complaint):
        powered(SimConfig(effects=(spec,)))
