"""Elastic joints and joints with backlash, compared with analytic solutions."""

from itertools import pairwise

import numpy as np
import pytest

from ident.basics.filters import convolve, low_pass
from ident.dynamics import mechanisms
from ident.dynamics.flexible_joints import FlexibleJoints, change_of_torque, flexible_joints
from ident.dynamics.motion import Motion
from ident.dynamics.platform import platform
from recordings.recording import Floats
from recordings.rig import simulated_rig

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


def _axis(inertia: float) -> FlexibleJoints:
    """One axis without weight."""
    return FlexibleJoints("axes", np.array([inertia, 0.0, 0.0, 0.0]), RATE)


def _sine(omega: float, time: Floats) -> tuple[Floats, Floats, Floats]:
    return np.sin(omega * time), omega * np.cos(omega * time), -(omega**2) * np.sin(omega * time)


def test_stiff_joints_have_the_torque_of_the_mechanism() -> None:
    rig, motion = simulated_rig(), swaying()
    mechanism = mechanisms.create(rig)
    known = np.array([PARAMETERS.get(parameter.name, 0.0) for parameter in mechanism.parameters])
    expected = mechanism.regressor(motion) @ known + PARAMETERS["m_d"] * platform(rig.geometry, motion).torque_of_rods
    stiff = flexible_joints(rig, PARAMETERS, 0.0, RATE).elastic_torque(motion, np.zeros(3), 0.03)
    tight = flexible_joints(rig, PARAMETERS, 0.0, RATE).backlash_torque(motion, np.zeros(3))
    np.testing.assert_allclose(stiff[1:], expected[1:], atol=1e-7)
    np.testing.assert_allclose(tight, expected, atol=1e-9)


def test_the_motor_share_is_no_part_of_the_arm_torque() -> None:
    rig, motion = simulated_rig(), swaying()
    whole, half = (
        flexible_joints(rig, PARAMETERS, share, RATE).backlash_torque(motion, np.zeros(3)) for share in (0.0, 0.5)
    )
    inertias = np.array([PARAMETERS["I_1"], PARAMETERS["I_2"], PARAMETERS["I_3"]])
    np.testing.assert_allclose(whole - half, 0.5 * inertias * motion.acceleration, atol=1e-9)


@pytest.mark.parametrize("natural_frequency", [4.0, 15.0, 40.0])
def test_a_mass_on_a_spring_has_the_analytic_response(natural_frequency: float) -> None:
    """One undamped axis: arm / motor = 1 / (1 - (f / f_0)^2), plus the free oscillation from the initial state."""
    inertia, frequency = 0.2, 2.0
    compliance = 1 / (inertia * (2 * np.pi * natural_frequency) ** 2)
    time, omega = np.arange(0.0, 3.0, 1 / RATE), 2 * np.pi * frequency
    q, v, a = (signal[:, None] for signal in _sine(omega, time))
    torque = _axis(inertia).elastic_torque(Motion(q, v, a, np.sign(v)), np.array([compliance]), 0.0)[:, 0]
    gain = 1 / (1 - (frequency / natural_frequency) ** 2)
    forced = -inertia * omega**2 * gain * np.sin(omega * time)
    omega_0 = 2 * np.pi * natural_frequency
    # Twist and its rate are zero initially; those of the forced solution follow (gain - 1) sin.
    free = inertia * omega_0 * omega * (gain - 1) * np.sin(omega_0 * time)
    np.testing.assert_allclose(torque, forced + free, atol=0.01 * np.abs(forced + free).max())


def test_undamped_oscillations_of_a_delta_keep_their_energy() -> None:
    """Motors at rest after a move do no work, so that the amplitude of the arms stays constant."""
    rig = simulated_rig()
    time = np.arange(0.0, 6.0, 1 / RATE)
    s = np.clip(time / 0.4, 0.0, 1.0)
    angle = 0.3 + 0.2 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    speed = np.gradient(angle, 1 / RATE)
    q, v, a = (np.repeat(signal[:, None], 3, axis=1) for signal in (angle, speed, np.gradient(speed, 1 / RATE)))
    motion = Motion(q, v, a, np.zeros_like(v))
    torque = flexible_joints(rig, PARAMETERS, 0.3, RATE).elastic_torque(motion, np.full(3, 1e-3), 0.0)
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
    torque = _axis(inertia).backlash_torque(motion, np.array([half_gap]))[:, 0]
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
    axis = FlexibleJoints("axes", np.array([0.2, 0.0, 0.0, 0.0]), rate)
    return axis.backlash_torque(Motion(q, v, a, np.sign(v)), np.array([half_gap]), delay)[:, 0]


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
    motion, gap, compliance = Motion(q, v, a, np.sign(v)), np.array([1e-3]), np.array([1e-4])
    heavy = FlexibleJoints("axes", np.array([0.2, 0.0, 0.0, weight]), RATE)
    loaded = FlexibleJoints("axes", np.array([0.2, 0.0, 0.0, 0.0]), RATE, np.full_like(q, weight))
    for torques in (
        [joints.backlash_torque(motion, gap) for joints in (heavy, loaded)],
        [joints.elastic_torque(motion, compliance, 0.03) for joints in (heavy, loaded)],
        [joints.rigid_torque(motion) for joints in (heavy, loaded)],
    ):
        np.testing.assert_allclose(torques[1], torques[0], atol=1e-9)


def test_the_torque_is_nan_in_a_gap_of_the_motion_and_nowhere_else() -> None:
    rig, motion = simulated_rig(), swaying()
    for signal in (motion.position, motion.velocity, motion.acceleration):
        signal[700:710] = np.nan
    joints = flexible_joints(rig, PARAMETERS, 0.3, RATE)
    for torque in (
        joints.elastic_torque(motion, np.full(3, 1e-3), 0.03),
        joints.backlash_torque(motion, np.full(3, 1e-3)),
    ):
        assert np.isnan(torque[700:710]).all()
        assert np.isfinite(torque[710:]).all()


def test_torque_of_a_simulation_that_diverges_is_that_of_stiff_joints() -> None:
    stiff, soft = np.array([[1.0], [2.0], [np.nan], [1.0]]), np.array([[1.5], [1e6], [1.0], [-1e200]])
    np.testing.assert_array_equal(change_of_torque(soft, stiff), [[0.5], [0.0], [0.0], [0.0]])
    assert not change_of_torque(soft, np.full((4, 1), np.nan)).any()
