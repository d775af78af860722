"""The first sentence of a comparison names what the model lacks: the first cases of the benchmark, and noise."""

import numpy as np
import pytest

from benchmarks.compare_sentences import CASES, Axes, Delta
from ident.identification.model_file import FloorVerdict, ResidualTest
from ident.residuals.analysis import analyse
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted

FAST = [CASES[index] for index in (0, 2, 5, 7, 12)]


@pytest.mark.parametrize("case", FAST, ids=lambda case: case.expected)
def test_the_first_sentence_names_the_variable(case: Axes | Delta) -> None:
    assert case.expected in case.sentence()


def test_the_order_of_a_wave_is_that_of_the_cause() -> None:
    assert CASES[0].sentence().endswith(": 14.0 periods per turn.")


def test_a_curve_over_one_quantity_does_not_explain_noise(planted: Planted, noise: Floats) -> None:
    first, *_ = analyse(None, [planted(noise)]).sentences
    assert first == "No quantity explains 20 % of the squared residual of any joint."


def test_nothing_explains_a_residual_of_zero(planted: Planted, noise: Floats) -> None:
    assert all(influence.explained == 0 for influence in analyse(None, [planted(np.zeros_like(noise))]).influences)


@pytest.mark.parametrize("verdict", ["within-noise", "above-noise", "unknown"])
def test_only_a_residual_above_the_noise_is_explained(planted: Planted, noise: Floats, verdict: FloorVerdict) -> None:
    wave = np.nan_to_num(np.cos(4 * planted(noise).prepared.motion.position)) * [0, 1, 0]
    known = (0.1, 0.1, 0.1)
    test = ResidualTest(
        verdict=verdict,
        bandwidth_hz=30.0,
        noise_rms=known,
        repetition_rms=known,
        quantization_rms=known,
        structured_rms=known,
        structured_share=0.5,
        recordings=(),
    )
    sentences = analyse(None, [planted(noise + wave)], test).sentences
    assert test.sentence in sentences
    assert sentences[0].startswith("Joint 2:") == (verdict != "within-noise")
