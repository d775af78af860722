"""The first sentence of a comparison names what the model lacks, and nothing where there is only noise."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from ident.identification.model_file import FloorVerdict, ResidualTest
from ident.identification.prediction import Prediction
from ident.residuals.analysis import analyse
from recordings.recording import Floats
from tests.ident import building
from tests.ident.residuals.conftest import Planted


def _load_reversed(motion: Motion) -> Floats:
    load: Floats = np.abs(building.INERTIA * motion.acceleration[:, 0]) * motion.direction[:, 0]
    return load


@pytest.mark.parametrize(
    ("shape", "size", "torque", "expected"),
    [
        (
            1,
            0.5,
            lambda motion: np.sin(14 * motion.position[:, 0]),
            "a wave over its position explains 99 % of the squared residual: 14.0 periods",
        ),
        (3, 1.0, lambda motion: motion.position[:, 0], "over its position"),
        (
            6,
            0.4,
            lambda motion: np.exp(-((motion.velocity[:, 0] / 0.3) ** 2)) * motion.direction[:, 0],
            "over its velocity",
        ),
        (8, 1.0, _load_reversed, "computed load, reversed with"),
        (13, 0.4, lambda motion: motion.acceleration[:, 1], "over joint 2's acceleration"),
    ],
)
def test_the_first_sentence_names_the_variable_of_the_one_cause(
    shape: int, size: float, torque: Callable[[Motion], Floats], expected: str
) -> None:
    """The cause acts on the first of two axes; `shape` is that of the motion, `size` the RMS of its torque [N m]."""
    cause = torque(building.motion_of(2, shape=shape))
    extra = np.stack([size * cause / np.sqrt(np.mean(cause**2)), np.zeros_like(cause)], axis=1)
    recording = building.record(2, noise=0.05, seed=shape, shape=shape, extra=lambda motion: extra)
    model = building.fitted(building.split([recording]))
    prediction = Prediction(building.prepared(recording), model.computed[0], model.split.scored[0])
    assert expected in analyse(None, [prediction]).sentences[0]


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
