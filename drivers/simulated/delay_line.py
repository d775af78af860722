"""Delay of a sampled signal."""

import math
from collections import deque


class DelayLine:
    """Delays a sampled signal by any time, with linear interpolation between samples."""

    def __init__(self, delay: float, dt: float) -> None:
        """`delay` and sampling period `dt` [s]."""
        steps = math.floor(delay / dt)
        self._fraction = delay / dt - steps
        self._samples: deque[float] = deque([0.0] * (steps + 2), maxlen=steps + 2)

    def push(self, value: float) -> float:
        """Add the newest sample; returns the delayed one."""
        samples = self._samples
        samples.append(value)
        return samples[1] + self._fraction * (samples[0] - samples[1])

    def clear(self) -> None:
        """Set all samples to zero."""
        self._samples.extend([0.0] * len(self._samples))
