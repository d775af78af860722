"""Frequency response of one axis from a periodic multisine: position loop, and torque to motion.

The excited lines of the spectrum are those of the command. What is between them (noise, quantisation, friction) is
also on them: its level gives the standard deviation of each line and the coherence (Pintelon and Schoukens, System
Identification, 2012, chapters 2 and 4). Both responses are ratios of spectra, so the feedback does not bias them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ident.data.samples import drive_signal, holds_torque
from ident.dynamics.torque_map import torque_from_voltage
from recordings.errors import BadInput
from recordings.recording import Floats, Recording

Complex = NDArray[np.complex128]

_EXCITED = 1e-2
"""Least acceleration of an excited line of the command, relative to that of the strongest one."""
_NEIGHBOURS = 20
"""Number of bins on each side of a line in which the level between the lines is measured."""
_MOST_LINES = 0.5
"""Largest share of excited bins: without bins between the lines there is no level."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Responses of one joint at n frequencies."""

    joint: int
    """1 ... dof."""
    rate: float
    """[Hz]."""
    frequency: Floats
    """(n,) [Hz]."""
    loop: Complex
    """(n,) measured over commanded position."""
    motion: Complex
    """(n,) position over torque [rad/(N m)]."""
    loop_coherence: Floats
    """(n,) coherence of position with the command, 0 to 1."""
    motion_coherence: Floats
    """(n,) coherence of position and torque with the command."""
    motion_deviation: Floats
    """(n,) relative standard deviation of `motion`."""
    others: Complex
    """(n, dof - 1) position of each other joint over that of this one: their drives do not hold them ideally."""
    torque_age: float = 0.0
    """By how much the reported torque is older than the position of the same sample [s], where the recording says
    so."""


def frequency_response(recording: Recording) -> FrequencyResponse:
    """Estimate the responses from all repetitions but the first, in which the motion settles.

    Raises:
        BadInput: the motion does not repeat, not exactly one joint moves, samples are missing, or the command is no
            multisine.
    """
    rows = _rows(recording)
    command = recording.command[rows]
    joint = _moving_joint(recording, command)
    drive = drive_signal(recording)
    torque = drive if holds_torque(recording) else torque_from_voltage(drive, recording.rig.torque)
    position = recording.position[rows]
    signals = (command[..., joint], position[..., joint], torque[rows][..., joint])
    for name, signal in zip(("command", "position", "torque"), signals, strict=True):
        if not np.isfinite(signal).all():
            raise BadInput(
                f"{recording.path}: every sample of joint {joint + 1} expected, the {name} has gaps; record anew"
            )
    spectra = [_spectrum(signal) for signal in signals]
    frequency = np.arange(len(spectra[0])) * recording.run.rate / rows.shape[1]
    excited = _excited(recording, frequency, spectra[0])
    levels = [_level_between(spectrum, excited) for spectrum in spectra[1:]]
    R, Y, T = (spectrum[excited] for spectrum in spectra)
    noise = [level / np.abs(line) for level, line in zip(levels, (Y, T), strict=True)]
    return FrequencyResponse(
        joint=joint + 1,
        rate=recording.run.rate,
        frequency=frequency[excited],
        loop=Y / R,
        motion=Y / T,
        loop_coherence=1 / (1 + noise[0] ** 2),
        motion_coherence=1 / (1 + noise[0] ** 2 + noise[1] ** 2),
        motion_deviation=np.hypot(*noise),
        others=_others(recording, position, joint)[excited] / Y[:, None],
        torque_age=recording.run.torque_age or 0.0,
    )


def _spectrum(signal: Floats) -> Complex:
    """Amplitudes of the mean repetition; `signal`: (cycles, samples, ...)."""
    return 2 * np.fft.rfft(signal.mean(axis=0), axis=0) / signal.shape[1]


def _others(recording: Recording, position: Floats, joint: int) -> Complex:
    """Spectra (bins, dof - 1) of the other joints; `position`: (cycles, samples, dof)."""
    others = np.delete(position, joint, axis=2)
    if not np.isfinite(others).all():
        raise BadInput(
            f"{recording.path}: every sample of the joints that hold expected, their position has gaps; record anew"
        )
    return _spectrum(others)


def _rows(recording: Recording) -> NDArray[np.intp]:
    """(cycles - 1, samples) rows of the repetitions but the first."""
    cycles = [np.flatnonzero(recording.repeat == cycle) for cycle in range(1, recording.run.cycles)]
    if not cycles or recording.run.period == 0 or len({len(cycle) for cycle in cycles}) != 1 or len(cycles[0]) < 3:
        raise BadInput(
            f"{recording.path}: at least two whole repetitions of a motion expected, others found; record with "
            "`daq response`"
        )
    return np.array(cycles)


def _moving_joint(recording: Recording, command: Floats) -> int:
    moves = np.ptp(command, axis=(0, 1)) > 1e-9
    if np.count_nonzero(moves) != 1:
        raise BadInput(
            f"{recording.path}: a motion of one joint expected, {np.count_nonzero(moves)} joints move; record with "
            "`daq response`"
        )
    return int(np.argmax(moves))


def _excited(recording: Recording, frequency: Floats, command: Complex) -> NDArray[np.bool_]:
    acceleration = np.abs(command) * frequency**2
    excited: NDArray[np.bool_] = acceleration > _EXCITED * acceleration.max()
    if np.mean(excited) > _MOST_LINES or np.count_nonzero(excited) < _NEIGHBOURS:
        raise BadInput(
            f"{recording.path}: {_NEIGHBOURS} or more lines with gaps between them expected in the spectrum of the "
            "command, another motion found; record with `daq response`"
        )
    return excited


def _level_between(spectrum: Complex, excited: NDArray[np.bool_]) -> Floats:
    """Root mean square of the bins around each excited line that are not excited."""
    levels = []
    for line in np.flatnonzero(excited):
        near = slice(max(1, int(line) - _NEIGHBOURS), int(line) + _NEIGHBOURS + 1)
        power = np.abs(spectrum[near][~excited[near]]) ** 2
        # The median of an exponential distribution is ln 2 of its mean, and ignores single disturbances.
        levels.append(np.sqrt(np.median(power) / np.log(2)))
    return np.array(levels)
