"""What a response settles."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.data.frequency_response import FrequencyResponse
from ident.estimation.axis_model import AxisModel
from ident.estimation.axis_response import AxisResponse
from recordings.recording import Floats

FREQUENCY = np.geomspace(1, 200, 30)


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
