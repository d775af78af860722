"""Quantization errors: of the encoders, and of the signal that the drives report.

Errors that are smaller than a step repeat with the motion, so that neither repetitions nor the residual's scatter
show them as noise. Their size is found by simulation: readings are drawn that the recorded ones could have been.
"""

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import holds_torque
from ident.dynamics.torque_map import torque_from_voltage, voltage_from_torque
from recordings.recording import Floats
from recordings.rig import Torque

_SEED = 0
"""Fixed, so that results are reproducible."""
DRIVE_DRAWS = 20
"""Number of pairs of `drive_errors` that give a variance."""
_DITHER = 0.5
"""Noise of more than this share of a step makes quantization errors random: they are then a part of the noise."""
_MEDIAN_DIFFERENCE = 0.9539
"""Median of the absolute difference of two standard normal variables."""


def with_encoder_errors(prepared: PreparedRecording, draw: int = 0) -> PreparedRecording:
    """The recording with random encoder errors of at most half a step."""
    measured = prepared.samples.position
    error = np.random.default_rng(_SEED + draw).uniform(-0.5, 0.5, measured.shape) * prepared.encoder_step
    return prepared.with_positions(lambda position: position + error)


def drive_errors(prepared: PreparedRecording, torque: Floats) -> list[tuple[Floats, Floats]]:
    """Simulate what the resolution of the drives' signal does to the torque: DRIVE_DRAWS pairs of (m, dof) [N m].

    Both errors of a pair belong to the same motion, so that the mean of their product contains only what repeats with
    the motion. They are conditioned as the torque, and 0 for a joint whose noise exceeds the steps; if that of all
    joints does, there are no pairs.

    torque: (n, dof) torque of a model [N m], before it is conditioned.
    """
    torque_map = None if holds_torque(prepared.recording) else prepared.recording.rig.torque
    signal, step = torque if torque_map is None else voltage_from_torque(torque, torque_map), prepared.drive_step
    noise = _noise(prepared.samples.drive[prepared.preprocessed.instants] - signal, step)
    coarse = (step > 0) & (noise < _DITHER * step)
    if not coarse.any():
        return []
    step, rng, pairs = np.where(coarse, step, 1.0), np.random.default_rng(_SEED), []
    for _ in range(DRIVE_DRAWS):
        shifted = signal + rng.uniform(-0.5, 0.5, len(step)) * step
        first, second = (
            _rounding_error(shifted + noise * rng.standard_normal(signal.shape), step, torque_map) * coarse
            for _ in range(2)
        )
        pairs.append((prepared.condition(first), prepared.condition(second)))
    return pairs


def _rounding_error(signal: Floats, step: Floats, torque_map: Torque | None) -> Floats:
    """(n, dof) error of the torque [N m] when `signal` is read in steps (dof,); torque_map: None for a torque."""
    read = step * np.rint(signal / step)
    if torque_map is None:
        return read - signal
    return torque_from_voltage(read, torque_map) - torque_from_voltage(signal, torque_map)


def _noise(residual: Floats, step: Floats) -> Floats:
    """(dof,) standard deviation of white noise in the drives' signal, from the differences of neighbours."""
    difference = np.abs(np.diff(residual, axis=0))
    # Steps bias the median, jumps of the residual the mean.
    median, mean = (np.nanmedian(difference, axis=0) / _MEDIAN_DIFFERENCE) ** 2, np.nanmean(difference**2, axis=0) / 2
    return np.sqrt(np.maximum(np.minimum(median, mean) - step**2 / 12, 0.0))
