"""What is the same in all repetitions of a measured motion."""

from dataclasses import replace

import numpy as np

from ident.data import cycle_statistics
from ident.data.prepared_recording import PreparedRecording
from recordings.recording import Floats


def repeating_share(course: PreparedRecording) -> Floats:
    """(dof,) share of the finest part of the measured motion that is the same in all repetitions, 0 to 1."""
    splits = cycle_statistics.of_cycles(instants_by_cycle(course, course.samples.position - course.as_recorded.motion.position))
    if splits is None:
        return np.ones(course.dataset.torque.shape[1])
    return np.array([min(max(one.repeating / one.total, 0.0), 1.0) if one.total else 0.0 for one in splits])


def instants_by_cycle(course: PreparedRecording, x: Floats) -> Floats:
    """`x` (n, dof) as (cycles, phases, dof)."""
    samples = course.samples
    every = replace(course.dataset, repeat=samples.repeat, phase=samples.phase, rate=samples.rate)
    return cycle_statistics.by_cycle(every, x)
