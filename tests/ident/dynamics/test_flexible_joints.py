"""Elastic joints and joints with backlash, compared with analytic solutions."""

from collections.abc import Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from benchmarks import flexible_arms
from ident.basics.filters import convolve, low_pass
from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.mechanism_motion import MechanismMotion
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from ident.dynamics.platform import platform
from recordings.recording import Floats
from recordings.rig import Axis, Rig, simulated_rig
from tests.ident.dynamics.loops import joint, link, rig, robot

pytest.importorskip("pinocchio")

RATE = 1000.0
PARAMETERS = {"m_p": 1.3, "T_g": 5.0, "I_1": 0.21, "I_2": 0.22, "I_3": 0.23, "m_d": 0.4}


def swaying(duration: float = 2.0, rate: float = RATE) -> Motion:
    """Three joints, each with its own frequency and phase."""
    time = np.arange(0.0, duration, 1 / rate)[:, None]
    omega, phase = 2 * np.pi * np.array([1.1, 1.6, 2.3]), np.array([0.0, 1.0, 2.0])
    angle = omega * time + phase
    return Motion(
        0.3 + 0.25 * np.sin(angle),
        0.25 * omega * np.cos(angle),
        -0.25 * omega**2 * np.sin(angle),
        np.sign(np.cos(angle)),
    )


def inputs_along(
    motion: Motion, parameters: Mapping[str, float], rig: Rig | None = None, rate: float = RATE, load: float = 0.0
) -> EffectInputs:
    """Inputs of effects at the full bandwidth; load: further torque on all arms [N m]."""
    rig = rig or simulated_rig()
    mechanism = mechanisms.create(rig)
    known = np.array([*(parameters.get(each.name, 0.0) for each in mechanism.parameters), parameters.get("m_d", 0.0)])
    moved, time = MechanismMotion(rig, motion, mechanism), np.arange(len(motion.position)) / rate
    on_arms = np.full_like(motion.position, load)
    return moved.effect_inputs(rate, time, rate / 2, known, arm_load_at=lambda _: on_arms)


SLIDE = rig(
    {
        "urdf": robot([link("base"), link("mass", 1.0), joint("slide", "base", "mass", "0 0 1", kind="prismatic")]),
        "joints": ("slide",),
        "motor_inertia": False,
    }
)
"""The axis as a URDF."""
AXIS = Rig(name="axis", mechanism="axes", axes=(Axis(type="prismatic", gravity=True),))


def springs(inputs: EffectInputs, compliance: float, damping: float = 0.0, share: float = 0.0) -> Floats:
    """Torque (n, dof) of springs between motors and arms."""
    everywhere = np.full(inputs.motion.position.shape[1], compliance)
    joints = inputs.flexible_joints(share, compliance=everywhere)
    return joints.torque + joints.change_by_springs(everywhere, damping)


def gaps(inputs: EffectInputs, half_gap: float, share: float = 0.0, delay: float = 0.0) -> Floats:
    """Torque (n, dof) between motors and arms with backlash."""
    joints = inputs.flexible_joints(share)
    return joints.torque + joints.change_by_backlash(np.full(joints.torque.shape[1], half_gap), delay)


def _sine(omega: float, time: Floats) -> tuple[Floats, Floats, Floats]:
    return np.sin(omega * time), omega * np.cos(omega * time), -(omega**2) * np.sin(omega * time)


def test_stiff_joints_have_the_torque_of_the_mechanism() -> None:
    rig, motion = simulated_rig(), swaying()
    mechanism = mechanisms.create(rig)
    known = np.array([PARAMETERS.get(parameter.name, 0.0) for parameter in mechanism.parameters])
    expected = mechanism.regressor(motion) @ known + PARAMETERS["m_d"] * platform(rig.geometry, motion).torque_of_rods
    inputs = inputs_along(motion, PARAMETERS)
    np.testing.assert_allclose(springs(inputs, 0.0), expected, atol=1e-9)
    np.testing.assert_allclose(gaps(inputs, 0.0), expected, atol=1e-9)


def test_the_motor_share_is_no_part_of_the_arm_torque() -> None:
    motion = swaying()
    whole, half = (gaps(inputs_along(motion, PARAMETERS), 0.0, share) for share in (0.0, 0.5))
    inertias = np.array([PARAMETERS["I_1"], PARAMETERS["I_2"], PARAMETERS["I_3"]])
    np.testing.assert_allclose(whole - half, 0.5 * inertias * motion.acceleration, atol=1e-9)


@pytest.mark.parametrize("rig", [AXIS, SLIDE], ids=["axes", "urdf"])
@pytest.mark.parametrize("natural_frequency", [4.0, 15.0, 40.0])
def test_a_mass_on_a_spring_has_the_analytic_response(natural_frequency: float, rig: Rig) -> None:
    """One undamped axis: arm / motor = 1 / (1 - (f / f_0)^2), plus the free oscillation from the initial state."""
    inertia, frequency = 0.2, 2.0
    compliance = 1 / (inertia * (2 * np.pi * natural_frequency) ** 2)
    time, omega = np.arange(0.0, 3.0, 1 / RATE), 2 * np.pi * frequency
    q, v, a = (signal[:, None] for signal in _sine(omega, time))
    inputs = inputs_along(Motion(q, v, a, np.sign(v)), {"m_1": inertia}, rig)
    torque = springs(inputs, compliance)[:, 0] - inputs.flexible_joints(1.0).torque[:, 0]
    gain = 1 / (1 - (frequency / natural_frequency) ** 2)
    forced = -inertia * omega**2 * gain * np.sin(omega * time)
    omega_0 = 2 * np.pi * natural_frequency
    # Twist and its rate are zero initially; those of the forced solution follow (gain - 1) sin.
    free = inertia * omega_0 * omega * (gain - 1) * np.sin(omega_0 * time)
    np.testing.assert_allclose(torque, forced + free, atol=0.01 * np.abs(forced + free).max())


def test_undamped_oscillations_of_a_delta_keep_their_energy() -> None:
    """Motors at rest after a move do no work, so that the amplitude of the arms stays constant."""
    time = np.arange(0.0, 6.0, 1 / RATE)
    s = np.clip(time / 0.4, 0.0, 1.0)
    angle = 0.3 + 0.2 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    speed = np.gradient(angle, 1 / RATE)
    q, v, a = (np.repeat(signal[:, None], 3, axis=1) for signal in (angle, speed, np.gradient(speed, 1 / RATE)))
    motion = Motion(q, v, a, np.zeros_like(v))
    torque = springs(inputs_along(motion, PARAMETERS), 1e-3, share=0.3)
    early, late = (np.ptp(torque[rows], axis=0) for rows in (slice(500, 2000), slice(4500, 6000)))
    assert (early > 0.5).all()
    np.testing.assert_allclose(late, early, rtol=0.02)


def test_an_arm_moves_freely_through_the_gap() -> None:
    """When the motor brakes, the torque is zero until the gap is crossed; the impact then transfers the momentum."""
    inertia, half_gap, brake = 0.1, 0.004, -50.0
    time = np.arange(0.0, 0.2, 1 / RATE)
    acceleration = np.where(time < 0.1, 20.0, brake)
    speed = np.cumsum(acceleration) / RATE
    q, v, a = (signal[:, None] for signal in (np.cumsum(speed) / RATE, speed, acceleration))
    motion = Motion(q, v, a, np.sign(v))
    torque = gaps(inputs_along(motion, {"m_1": inertia}, AXIS), half_gap)[:, 0]
    flight = np.sqrt(2 * 2 * half_gap / -brake)
    flying = (time > 0.102) & (time < 0.1 + flight - 0.002)
    assert np.allclose(torque[time < 0.099], inertia * 20.0)
    assert np.allclose(torque[flying], 0.0)
    assert np.allclose(torque[time > 0.1 + flight + 0.003], inertia * brake)
    # The impact transfers the momentum that was missing during the free motion.
    missing = (inertia * acceleration - torque).sum() / RATE
    assert abs(missing) < 0.05 * inertia * -brake * flight


def _axis_with_impacts(rate: float, half_gap: float, delay: float = 0.0) -> Floats:
    """Torque (n,) of one axis that sways, at `rate` [Hz]."""
    q, v, a = (signal[:, None] for signal in _sine(2 * np.pi * 2.0, np.arange(0.0, 3.0, 1 / rate)))
    return gaps(inputs_along(Motion(q, v, a, np.sign(v)), {"m_1": 0.2}, AXIS, rate), half_gap, delay=delay)[:, 0]


@pytest.mark.parametrize("rate", [125.0, 400.0, 2000.0])
def test_the_low_passed_torque_changes_steadily_with_the_gap(rate: float) -> None:
    """Impacts do not jump from sample to sample: a search would be stuck between jumps. Equal steps of the gap change
    the torque by similar amounts."""
    taps = low_pass(25.0, rate)
    torques = [convolve(_axis_with_impacts(rate, gap), taps) for gap in 1e-3 * np.linspace(1.0, 1.05, 51)]
    changes = [float(np.sqrt(np.nanmean(np.diff(pair, axis=0) ** 2))) for pair in pairwise(torques)]
    assert max(changes) < 3 * np.mean(changes)


@pytest.mark.parametrize(("rate", "error"), [(125.0, 0.03), (250.0, 0.005)])
def test_free_flight_is_the_same_at_low_rates(rate: float, error: float) -> None:
    """Except for impacts beside the end of a sample, which are spread over two: the median does not see these.

    Arms would leave their teeth too late or too early, by up to half a sample, if their load were constant over each.
    """
    step = round(4000 / rate)
    window = np.r_[0.5, np.ones(step - 1), 0.5] / step
    without_gap, errors = _axis_with_impacts(rate, 0.0), []
    for half_gap in np.geomspace(2e-4, 2e-3, 9):
        exact = np.convolve(_axis_with_impacts(4000.0, half_gap), window, "same")[::step]
        torque = _axis_with_impacts(rate, half_gap)
        errors.append(np.std((torque - exact)[20:-20]) / np.std((torque - without_gap)[20:-20]))
    assert np.median(errors) < error


def test_a_delay_moves_the_torque_of_impacts_only() -> None:
    first, second, third = (_axis_with_impacts(1000.0, 1e-3, delay) for delay in (0.0, 1e-3, 2e-3))
    assert np.abs(second - first).max() > 1.0
    np.testing.assert_allclose((third - second)[1:], (second - first)[:-1], atol=1e-9)


def test_a_load_on_the_arms_is_transmitted_like_a_weight_of_the_mechanism() -> None:
    """An axis with a constant weight, of the mechanism or as a further load."""
    weight, (q, v, a) = 3.0, (x[:, None] for x in _sine(2 * np.pi * 2.0, np.arange(0.0, 3.0, 1 / RATE)))
    motion = Motion(q, v, a, np.sign(v))
    heavy = inputs_along(motion, {"m_1": 0.2, "G_1": weight}, AXIS)
    loaded = inputs_along(motion, {"m_1": 0.2}, AXIS, load=weight)
    np.testing.assert_allclose(gaps(loaded, 1e-3), gaps(heavy, 1e-3), atol=1e-9)
    np.testing.assert_allclose(springs(loaded, 1e-4, 0.03), springs(heavy, 1e-4, 0.03), atol=1e-9)


ARM = {"upper": (4.0, 0.3, 0.05), "fore": (2.0, 0.25, 0.02)}
"""Mass [kg], place of the centre [m] and moment of inertia about it [kg m^2] of two links of 0.5 m."""


def _arm() -> tuple[EffectInputs, Any, Floats]:
    """Two links that swing in a vertical plane: inputs, MuJoCo's model of them, and the time."""
    parts, bodies, at = [link("base")], "", (0.0, 0.0, 0.0)
    for parent, (name, (mass, centre, moment)) in zip(("base", "upper"), ARM.items(), strict=True):
        parts += [link(name, mass, (centre, 0, 0), (moment,) * 3), joint(name, parent, name, "0 1 0", at)]
        bodies += (
            f'<body pos="{at[0]} 0 0"><joint axis="0 1 0"/><inertial pos="{centre} 0 0" mass="{mass}" '
            f'diaginertia="{moment} {moment} {moment}"/>'
        )
        at = (0.5, 0.0, 0.0)
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</body></body></worldbody></mujoco>")
    described = rig({"urdf": robot(parts), "joints": tuple(ARM), "motor_inertia": False})
    mechanism, time = mechanisms.create(described), np.arange(0.0, 3.0, 1 / RATE)
    assert isinstance(mechanism, Urdf)
    base = mechanism.base.combination @ mechanism.links.nominal_parameters
    known = {each.name: float(x) for each, x in zip(mechanism.parameters, base, strict=False)}
    started = np.clip(time / 1.5, 0, 1)[:, None]
    swell = started**4 * (35 - 84 * started + 70 * started**2 - 20 * started**3)
    path = CubicSpline(time, swell * 0.3 * np.sin(2 * np.pi * np.array([1.4, 2.1]) * time[:, None]))
    q, v, a = path(time), path(time, 1), path(time, 2)
    return inputs_along(Motion(q, v, a, np.sign(v)), known, described), model, time


@pytest.mark.parametrize("coupling", ["springs", "gaps"])
def test_an_arm_behind_springs_or_gaps_moves_as_in_mujoco(coupling: str) -> None:
    inputs, model, time = _arm()
    motors = (inputs.motion.position, inputs.motion.velocity, inputs.motion.acceleration)
    if coupling == "springs":
        size, error = np.array([2e-4, 0.0]), 0.02
        joints = inputs.flexible_joints(0.0, compliance=size)
        changed = joints.change_by_springs(size, 0.04)
        expected = flexible_arms.arm_torque(model, time, motors, [0], partial(flexible_arms.spring, 2e-4))
    else:
        joints, error = inputs.flexible_joints(0.0), 0.35  # the other's stops give way
        changed = joints.change_by_backlash(np.array([0.0, 2e-3]))
        expected = flexible_arms.arm_torque(model, time, motors, [1], partial(flexible_arms.gap, 2e-3))
    taps = low_pass(25.0, RATE)
    difference, change = (convolve(each, taps) for each in (joints.torque + changed - expected, changed))
    assert np.nanstd(difference[500:]) < error * np.nanstd(change[500:])


def test_the_torque_is_nan_in_a_gap_of_the_motion_and_nowhere_else() -> None:
    motion = swaying()
    for signal in (motion.position, motion.velocity, motion.acceleration):
        signal[700:710] = np.nan
    inputs = inputs_along(motion, PARAMETERS)
    for torque in (springs(inputs, 1e-3, 0.03, 0.3), gaps(inputs, 1e-3, 0.3)):
        assert np.isnan(torque[700:710]).all()
        assert np.isfinite(torque[710:]).all()
