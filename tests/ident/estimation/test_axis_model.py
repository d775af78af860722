"""The model of an axis against responses that are known, and what a response settles."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.data.frequency_response import Complex, FrequencyResponse
from ident.estimation.axis_model import AxisModel, fit_axis
from ident.estimation.axis_response import AxisResponse
from recordings.errors import BadInput
from recordings.recording import Floats

FREQUENCY = np.geomspace(1, 200, 90)


AT_REST = np.zeros((len(FREQUENCY), 2), complex)


def measured(
    motion: Complex, deviation: float = 0.02, seed: int = 0, others: Complex = AT_REST, torque_age: float = 0.0
) -> FrequencyResponse:
    rng = np.random.default_rng(seed)
    noise = rng.normal(0, deviation, (2, len(motion))) / np.sqrt(2)
    ones = np.ones(len(motion))
    return FrequencyResponse(
        joint=1,
        rate=500.0,
        frequency=FREQUENCY,
        loop=ones + 0j,
        motion=motion * (1 + noise[0] + 1j * noise[1]),
        loop_coherence=ones,
        motion_coherence=ones,
        motion_deviation=deviation * ones,
        others=others,
        torque_age=torque_age,
    )


def two_masses(frequency: Floats, motor: float, load: float, stiffness: float, delay: float) -> Complex:
    """Motor angle over torque of a motor and a load on a spring, written as a 2 x 2 system."""
    s = 2j * np.pi * frequency
    damping = 0.03 * 2 * np.sqrt(stiffness * load)
    spring = stiffness + damping * s
    response: Complex = (load * s**2 + spring) / ((motor * s**2 + spring) * (load * s**2 + spring) - spring**2)
    return response * np.exp(-s * delay)


@settings(max_examples=4)
@given(delay=st.floats(0, 0.004), resonance=st.floats(25, 120), ratio=st.floats(1.5, 8), seed=st.integers(0, 99))
def test_resonance_and_delay_are_told_apart(delay: float, resonance: float, ratio: float, seed: int) -> None:
    motor = 0.1
    load = ratio * motor
    stiffness = (2 * np.pi * resonance) ** 2 / (1 / motor + 1 / load)
    model = fit_axis(measured(two_masses(FREQUENCY, motor, load, stiffness, delay), seed=seed))
    assert model.resonance == pytest.approx(resonance, rel=0.03)
    assert model.antiresonance == pytest.approx(np.sqrt(stiffness / load) / (2 * np.pi), rel=0.03)
    assert model.inertia == pytest.approx(motor + load, rel=0.05)
    assert model.delay == pytest.approx(delay, abs=2e-4)


@settings(max_examples=4)
@given(delay=st.floats(0, 0.005), inertia=st.floats(0.05, 5), seed=st.integers(0, 99))
def test_a_rigid_axis_has_no_resonance(delay: float, inertia: float, seed: int) -> None:
    s = 2j * np.pi * FREQUENCY
    model = fit_axis(measured(np.exp(-s * delay) / (inertia * s**2 + 5 * inertia * s), 0.1, seed))
    assert model.resonance is None
    assert model.delay == pytest.approx(delay, abs=2e-4)
    assert model.inertia == pytest.approx(inertia, rel=0.05)


@settings(max_examples=4)
@given(delay=st.floats(0, 0.004), coupling=st.floats(-0.3, 0.3), seed=st.integers(0, 99))
def test_other_motors_that_give_way_are_no_delay(delay: float, coupling: float, seed: int) -> None:
    """Two joints: [[1, m], [m, 1]] s^2 y = torque - viscous s y; the drive of the other one has a corner at 30 Hz."""
    s, J, viscous = 2j * np.pi * FREQUENCY, 0.6, 8.0
    m = coupling * J
    corner = 2 * np.pi * 30
    loop = J * (2 * corner * s + corner**2)
    other = -m * s**2 / (J * s**2 + viscous * s + loop)
    motion = np.exp(-s * delay) / (J * s**2 + viscous * s + m * s**2 * other)
    others = np.stack([other, 0 * other], axis=1)
    model = fit_axis(measured(motion, 0.05, seed, others))
    assert model.resonance is None
    assert model.delay == pytest.approx(delay, abs=1e-4)
    assert model.inertia == pytest.approx(J, rel=0.05)


def test_the_age_of_the_torque_is_no_delay() -> None:
    s = 2j * np.pi * FREQUENCY
    early = np.exp(s * 2e-4) / (0.6 * s**2 + 5 * s)
    assert fit_axis(measured(early)).delay == pytest.approx(-2e-4, abs=5e-5)
    assert fit_axis(measured(early, torque_age=2e-4)).delay == pytest.approx(0, abs=5e-5)


def test_noise_alone_is_refused() -> None:
    with pytest.raises(BadInput, match="12 or more lines above noise and friction expected, 0 found"):
        fit_axis(measured(np.ones(len(FREQUENCY), complex), deviation=0.8))


def made_up(delay: float, resonance: float | None, corner: float = 20.0) -> AxisResponse:
    """A response with a position loop of first order."""

    def motion(frequency: Floats) -> np.ndarray:
        return -1 / (2 * np.pi * frequency) ** 2 + 0j

    ones = np.ones(len(FREQUENCY))
    measured = FrequencyResponse(
        joint=2,
        rate=500.0,
        frequency=FREQUENCY,
        loop=1 / (1 + 1j * FREQUENCY / corner),
        motion=motion(FREQUENCY),
        loop_coherence=ones,
        motion_coherence=ones,
        motion_deviation=0.02 * ones,
        others=np.zeros((len(FREQUENCY), 2), complex),
    )
    antiresonance = None if resonance is None else resonance / 2
    model = AxisModel(1.0, 5.0, delay, antiresonance, resonance, 30, 99.8, 0.08, motion)
    return AxisResponse(Path("joint2.mcap"), measured, model)


@pytest.mark.parametrize(
    ("delay", "resonance", "sentence"),
    [
        (0.003, None, "It is a delay of 3 ms, not elasticity: no resonance up to 99.8 Hz."),
        (0.0001, 124.2, "It is elasticity (resonance at 124 Hz), not a delay."),
        (0.003, 124.2, "Both elasticity (resonance at 124 Hz) and a delay of 3 ms."),
        (-0.0001, None, "Neither a delay above 0.2 ms nor elasticity: no resonance up to 99.8 Hz."),
        (-0.001, None, "It is a torque that is reported 1 ms late, not elasticity: no resonance up to 99.8 Hz."),
    ],
)
def test_one_sentence_settles_delay_against_elasticity(delay: float, resonance: float | None, sentence: str) -> None:
    response = made_up(delay, resonance)
    assert response.conclusion == sentence
    assert response.as_json()["conclusion"] == sentence


def test_the_bandwidth_is_the_first_line_below_the_corner() -> None:
    response = made_up(0.0, None)
    assert response.bandwidth == FREQUENCY[FREQUENCY > 20][0]
    assert replace(response, measured=made_up(0.0, None, 1e4).measured).bandwidth is None
