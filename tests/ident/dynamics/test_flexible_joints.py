"""Arms that do not follow their motors, against what is known of springs and free flight."""

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.flexible_joints import FlexibleJoints, flexible_joints
from ident.dynamics.motion import Motion
from ident.dynamics.rods import torque as forearms
from recordings.recording import Floats
from recordings.rig import simulated_rig

RATE = 1000.0
OWN = {"m_p": 1.3, "T_g": 5.0, "I_1": 0.21, "I_2": 0.22, "I_3": 0.23, "m_d": 0.4}


def _swaying(duration: float = 2.0) -> Motion:
    """Three joints, each with a frequency and a phase of its own."""
    time = np.arange(0.0, duration, 1 / RATE)[:, None]
    omega, phase = 2 * np.pi * np.array([1.1, 1.6, 2.3]), np.array([0.0, 1.0, 2.0])
    angle = omega * time + phase
    return Motion(
        0.3 + 0.25 * np.sin(angle), 0.25 * omega * np.cos(angle), -0.25 * omega**2 * np.sin(angle), np.cos(angle)
    )


def _axis(inertia: float) -> FlexibleJoints:
    """One axis without weight."""
    return FlexibleJoints(False, np.array([inertia, 0.0, 0.0, 0.0]), RATE)


def _sine(omega: float, time: Floats) -> tuple[Floats, Floats, Floats]:
    return np.sin(omega * time), omega * np.cos(omega * time), -(omega**2) * np.sin(omega * time)


def test_arms_that_follow_take_what_the_mechanism_says() -> None:
    rig, motion = simulated_rig(), _swaying()
    mechanism = mechanisms.create(rig)
    known = np.array([OWN.get(one.name, 0.0) for one in mechanism.parameters])
    expected = mechanism.regressor(motion) @ known + OWN["m_d"] * forearms(rig.geometry, motion)
    stiff = flexible_joints(rig, OWN, 0.0, RATE).elastic_torque(motion, np.zeros(3), 0.03)
    tight = flexible_joints(rig, OWN, 0.0, RATE).backlash_torque(motion, np.zeros(3))
    np.testing.assert_allclose(stiff[1:], expected[1:], atol=1e-7)
    np.testing.assert_allclose(tight, expected, atol=1e-9)


def test_the_motors_share_stays_with_the_motors() -> None:
    rig, motion = simulated_rig(), _swaying()
    whole, half = (
        flexible_joints(rig, OWN, share, RATE).backlash_torque(motion, np.zeros(3)) for share in (0.0, 0.5)
    )
    own = np.array([OWN["I_1"], OWN["I_2"], OWN["I_3"]])
    np.testing.assert_allclose(whole - half, 0.5 * own * motion.acceleration, atol=1e-9)


@pytest.mark.parametrize("swing", [4.0, 15.0, 40.0])
def test_a_mass_on_a_spring_answers_as_it_must(swing: float) -> None:
    """Of one axis: arm / motor = 1 / (1 - (f / swing)^2) without damping, once what it began with is added."""
    inertia, frequency = 0.2, 2.0
    compliance = 1 / (inertia * (2 * np.pi * swing) ** 2)
    time, omega = np.arange(0.0, 3.0, 1 / RATE), 2 * np.pi * frequency
    q, v, a = (one[:, None] for one in _sine(omega, time))
    taken = _axis(inertia).elastic_torque(Motion(q, v, a, np.sign(v)), np.array([compliance]), 0.0)[:, 0]
    gain = 1 / (1 - (frequency / swing) ** 2)
    forced = -inertia * omega**2 * gain * np.sin(omega * time)
    own = 2 * np.pi * swing
    # At the beginning twist and its speed are zero; forced, they would be those of (gain - 1) sin.
    free = inertia * own * omega * (gain - 1) * np.sin(own * time)
    np.testing.assert_allclose(taken, forced + free, atol=0.01 * np.abs(forced + free).max())


def test_swinging_arms_of_a_delta_keep_their_energy() -> None:
    """Motors that stand still after a move do no work: the amplitude of the arms' swing does not grow or fade."""
    rig = simulated_rig()
    time = np.arange(0.0, 6.0, 1 / RATE)
    up = np.clip(time / 0.4, 0.0, 1.0)
    angle = 0.3 + 0.2 * (10 * up**3 - 15 * up**4 + 6 * up**5)
    speed = np.gradient(angle, 1 / RATE)
    q, v, a = (np.repeat(one[:, None], 3, axis=1) for one in (angle, speed, np.gradient(speed, 1 / RATE)))
    motion = Motion(q, v, a, np.zeros_like(v))
    taken = flexible_joints(rig, OWN, 0.3, RATE).elastic_torque(motion, np.full(3, 1e-3), 0.0)
    early, late = (np.ptp(taken[part], axis=0) for part in (slice(500, 2000), slice(4500, 6000)))
    assert (early > 0.5).all()
    np.testing.assert_allclose(late, early, rtol=0.02)


def test_an_arm_flies_freely_through_the_gap() -> None:
    """A motor that brakes leaves its arm behind: no torque until the gap is crossed, then the speed at one blow."""
    inertia, half, brake = 0.1, 0.004, -50.0
    time = np.arange(0.0, 0.2, 1 / RATE)
    acceleration = np.where(time < 0.1, 20.0, brake)
    speed = np.cumsum(acceleration) / RATE
    q, v, a = (one[:, None] for one in (np.cumsum(speed) / RATE, speed, acceleration))
    motion = Motion(q, v, a, np.sign(v))
    taken = _axis(inertia).backlash_torque(motion, np.array([half]))[:, 0]
    flight = np.sqrt(2 * 2 * half / -brake)
    flying = (time > 0.102) & (time < 0.1 + flight - 0.002)
    assert np.allclose(taken[time < 0.099], inertia * 20.0)
    assert np.allclose(taken[flying], 0.0)
    assert np.allclose(taken[time > 0.1 + flight + 0.003], inertia * brake)
    # The momentum that it has lost by flying is what the blow takes.
    missing = (inertia * acceleration - taken).sum() / RATE
    assert abs(missing) < 0.05 * inertia * -brake * flight


def test_play_is_recognised_by_a_first_look() -> None:
    rig, motion = simulated_rig(), _swaying(6.0)
    own = np.array([OWN["I_1"], OWN["I_2"], OWN["I_3"]])
    light = {**OWN, "m_p": 0.3, "T_g": 0.3, "m_d": 0.0}
    geared = flexible_joints(rig, light, 0.5, RATE)
    residual = geared.backlash_torque(motion, np.array([0.0, 1e-3, 0.0])) - geared.backlash_torque(
        motion, np.zeros(3)
    )
    smooth: Floats = np.apply_along_axis(lambda one: np.convolve(one, [0.25, 0.5, 0.25], "same"), 0, residual)
    shares, halves = np.linspace(0.0, 0.9, 10), np.geomspace(1e-4, 1e-2, 9)
    falls = flexible_joints(rig, light, 0.0, RATE).cost_reductions(motion, own, smooth, shares, halves)[:, :, 1]
    best = np.unravel_index(np.argmax(falls), falls.shape)
    assert shares[best[0]] == pytest.approx(0.5)
    assert halves[best[1]] == pytest.approx(1e-3)


def test_a_gap_in_the_motion_is_one_in_the_torque() -> None:
    rig, motion = simulated_rig(), _swaying()
    for signal in (motion.position, motion.velocity, motion.acceleration):
        signal[700:710] = np.nan
    both = flexible_joints(rig, OWN, 0.3, RATE)
    for taken in (
        both.elastic_torque(motion, np.full(3, 1e-3), 0.03),
        both.backlash_torque(motion, np.full(3, 1e-3)),
    ):
        assert np.isnan(taken[700:710]).all()
        assert np.isfinite(taken[710:]).all()
