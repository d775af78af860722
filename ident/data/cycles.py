"""The part of a measured motion that repeats from cycle to cycle."""

from dataclasses import replace

import numpy as np

from ident.data import cycle_statistics
from ident.data.prepared_recording import PreparedRecording
from recordings.recording import Floats


def repeating_share(prepared: PreparedRecording) -> Floats:
    """(dof,) repeating share (0 to 1) of the measured position that the low-pass of the motion removes."""
    statistics = cycle_statistics.of_cycles(
        instants_by_cycle(prepared, prepared.samples.position - prepared.as_recorded.motion.position)
    )
    if statistics is None:
        return np.ones(prepared.dataset.torque.shape[1])
    return np.array(
        [min(max(joint.repeating / joint.total, 0.0), 1.0) if joint.total else 0.0 for joint in statistics]
    )


def instants_by_cycle(prepared: PreparedRecording, x: Floats) -> Floats:
    """Arrange `x` (n, dof) as (cycles, phases, dof)."""
    samples = prepared.samples
    at_instants = replace(prepared.dataset, repeat=samples.repeat, phase=samples.phase, rate=samples.rate)
    return cycle_statistics.by_cycle(at_instants, x)
