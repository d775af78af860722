"""A signal that comes later."""

import math
from collections import deque


class DelayLine:
    """Delays a sampled signal by any time, straight lines between its samples."""

    def __init__(self, delay: float, dt: float) -> None:
        """`delay` and sampling period `dt` [s]."""
        steps = math.floor(delay / dt)
        self._late = delay / dt - steps
        self._samples: deque[float] = deque([0.0] * (steps + 2), maxlen=steps + 2)

    def push(self, value: float) -> float:
        """Take the newest sample, give the delayed one."""
        samples = self._samples
        samples.append(value)
        return samples[1] + self._late * (samples[0] - samples[1])

    def clear(self) -> None:
        """Forget: all samples are zero."""
        self._samples.extend([0.0] * len(self._samples))
