from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident import discovery, mechanisms, preprocess
from ident.dataset import build
from recordings.errors import BadInput
from recordings.recording import Floats, Recording

Make = Callable[..., Recording]


def relative_residual(recording: Recording, parameters: Floats, method: str, cutoff: float | None = None) -> float:
    regressor, torque = build(recording, mechanisms.create(recording.rig), method, cutoff).rows()
    return float(np.sqrt(np.mean((torque - regressor @ parameters) ** 2)) / torque.std())


@pytest.mark.parametrize(("rate", "cutoff"), [(500, None), (500, 10), (1000, 40), (200, None)])
def test_parallel_filtering_of_exact_motion_leaves_next_to_nothing(
    make: Make, truth: Floats, rate: float, cutoff: float | None
) -> None:
    assert relative_residual(make(rate=rate, cycles=1), truth, "parallel", cutoff) < 2e-3 * (200 / rate)


def test_parallel_filtering_survives_the_encoder(make: Make, truth: Floats) -> None:
    made = make()
    counts = made.rig.drives[0].counts_per_radian
    coarse = replace(made, position=np.round(made.position * counts) / counts)
    assert relative_residual(coarse, truth, "parallel") < 0.01
    # The paper's differences of the same angles bury the torque in noise.
    assert relative_residual(coarse, truth, "central") > 0.1


def test_central_differences_are_the_papers() -> None:
    t = np.arange(50) / 100
    position, torque = np.sin(3 * t)[:, None], np.cos(t)[:, None]
    prepared = preprocess.load("central")(position, torque, 100.0, None)
    inner = slice(1, -1)
    np.testing.assert_allclose(prepared.motion.velocity[inner], (position[2:] - position[:-2]) * 50)
    np.testing.assert_allclose(
        prepared.motion.acceleration[inner], (position[2:] - 2 * position[1:-1] + position[:-2]) * 1e4, atol=1e-9
    )
    np.testing.assert_array_equal(prepared.motion.direction[inner], np.sign(prepared.motion.velocity[inner]))
    np.testing.assert_array_equal(prepared.condition(torque), torque)
    assert np.isnan(prepared.motion.velocity[[0, -1]]).all()


@pytest.mark.parametrize("method", discovery.names("preprocess"))
@pytest.mark.parametrize("signal", ["position", "voltage"])
def test_a_gap_is_masked_and_spoils_no_more_than_the_filters_reach(
    recording: Recording, truth: Floats, method: str, signal: str
) -> None:
    gap = slice(1000, 1003)
    values = getattr(recording, signal).copy()
    values[gap, 1] = np.nan
    gapped = replace(recording, **{signal: values})
    mechanism = mechanisms.create(recording.rig)
    whole, part = (build(made, mechanism, method, None) for made in (recording, gapped))
    lost = np.isfinite(whole.torque) & np.isnan(part.torque)
    # Parallel at 30 Hz: 25 samples to either side, 9 more of the light filter and 4 of the derivatives.
    lost_time = whole.time[lost.any(axis=1)]
    assert abs(lost_time - 1001 / 500).max() < 0.081
    # Without its voltage one joint is lost, without its position the whole platform.
    assert lost.any(axis=0).tolist() == ([False, True, False] if signal == "voltage" else [True] * 3)
    np.testing.assert_array_equal(part.torque[~lost], whole.torque[~lost])
    assert relative_residual(gapped, truth, method) == pytest.approx(relative_residual(recording, truth, method), 0.1)


@pytest.mark.parametrize("cutoff", [0, -5, 101, np.nan])
def test_a_cutoff_out_of_reach_is_refused(recording: Recording, cutoff: float) -> None:
    with pytest.raises(BadInput, match="cut-off"):
        build(recording, mechanisms.create(recording.rig), "parallel", cutoff)


def test_central_differences_take_no_cutoff(recording: Recording) -> None:
    with pytest.raises(BadInput, match="no cut-off"):
        build(recording, mechanisms.create(recording.rig), "central", 30.0)


def test_unknown_method_is_refused_with_those_there_are() -> None:
    with pytest.raises(BadInput, match="central, parallel"):
        preprocess.load("magic")
