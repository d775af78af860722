"""Quantization errors: of the encoders, and of the signal that the drives report.

Errors that are smaller than a step repeat with the motion, so that neither repetitions nor the residual's scatter
show them as noise. Their size is found by simulation: readings are drawn that the recorded ones could have been.
"""

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import drive_signal, holds_torque
from ident.dynamics.torque_map import torque_from_voltage, voltage_from_torque
from recordings.recording import Floats
from recordings.rig import Torque

_SEED = 0
"""Fixed, so that results are reproducible."""
_SAME = 1e-10
"""Readings closer than this are the same [rad, m, V or N m]."""
DRIVE_DRAWS = 8
"""Number of pairs of `drive_errors` that give a variance."""
_DITHER = 0.5
"""Noise of more than this share of a step makes quantization errors random: they are then a part of the noise."""
_MEDIAN_DIFFERENCE = 0.9539
"""Median of the absolute difference of two standard normal variables."""


def resolution(signal: Floats) -> Floats:
    """(dof,) step of the readings in `signal` (n, dof): the smallest difference between them; 0 for a constant."""
    steps = []
    for readings in signal.T:
        differences = np.diff(np.unique(readings[np.isfinite(readings)]))
        differences = differences[differences > _SAME]
        steps.append(float(differences.min()) if len(differences) else 0.0)
    return np.array(steps)


def with_encoder_errors(prepared: PreparedRecording, draw: int = 0) -> PreparedRecording:
    """The recording with random encoder errors of at most half a step."""
    measured = prepared.samples.position
    error = np.random.default_rng(_SEED + draw).uniform(-0.5, 0.5, measured.shape) * resolution(measured)
    return prepared.with_positions(lambda position: position + error)


def drive_errors(prepared: PreparedRecording, torque: Floats, draw: int = 0) -> tuple[Floats, Floats]:
    """Simulate twice what the resolution of the drives' signal does to the torque: two (m, dof) errors [N m].

    Both belong to the same motion, so that the mean of their product contains only what repeats with the motion. They
    are conditioned as the torque, and 0 for a joint whose noise exceeds the steps.

    torque: (n, dof) torque of a model [N m], before it is conditioned.
    """
    is_torque, torque_map = holds_torque(prepared.recording), prepared.recording.rig.torque
    signal = torque if is_torque else voltage_from_torque(torque, torque_map)
    step = resolution(drive_signal(prepared.recording))
    noise = _noise(prepared.samples.drive[prepared.preprocessed.instants] - signal, step)
    coarse = (step > 0) & (noise < _DITHER * step)
    if not coarse.any():
        return np.zeros_like(prepared.torque), np.zeros_like(prepared.torque)
    rng = np.random.default_rng([_SEED, draw])
    signal, step = signal + rng.uniform(-0.5, 0.5, len(step)) * step, np.where(coarse, step, 1.0)
    first, second = (
        _rounding_error(signal + noise * rng.standard_normal(signal.shape), step, None if is_torque else torque_map)
        for _ in range(2)
    )
    return prepared.condition(first * coarse), prepared.condition(second * coarse)


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
    std: Floats = np.sqrt(np.maximum(np.minimum(median, mean) - step**2 / 12, 0.0))
    return std
