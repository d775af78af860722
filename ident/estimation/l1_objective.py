"""The sum of absolute residuals, Eq. (33), for a whole swarm: the hot path of the particle swarms.

A block of particles stays in the vector registers (one particle per lane) during a single pass over the rows; blocks
are distributed over the cores. The sum of each particle runs over the rows in order for any number of threads, so
results are repeatable bit for bit.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numba
import numpy as np

from ident.basics.numba_cache import compiled
from recordings.recording import Floats

_LANES = 16
"""Particles per block: two registers of eight doubles for each parameter, of 32 available registers."""

_MIN_PARALLEL_WORK = 5_000_000
"""Rows times particles from which on several threads are used: about a millisecond on one core."""


class L1Objective:
    """The objective (33) of one data set: regressor (m, k), torque (m,) [N m]."""

    def __init__(self, regressor: Floats, torque: Floats) -> None:
        self._regressor = np.ascontiguousarray(regressor)
        self._torque = np.ascontiguousarray(torque)
        self._kernel = _kernel(regressor.shape[1])

    def __call__(self, particles: Floats) -> Floats:
        """Sums of absolute residuals (n,) [N m] at the parameters `particles` (n, k)."""
        n, k = particles.shape
        blocks = -(-n // _LANES)
        padded = np.zeros((blocks * _LANES, k))
        padded[:n] = particles
        lanes = np.ascontiguousarray(padded.reshape(blocks, _LANES, k).transpose(0, 2, 1))
        with _threads(n * len(self._torque)):
            sums: Floats = self._kernel(self._regressor, self._torque, lanes)
        return sums.ravel()[:n]


@contextmanager
def _threads(work: int) -> Iterator[None]:
    """Use all threads, or a single one if the work is too small for their synchronisation to pay off."""
    default = numba.get_num_threads()
    numba.set_num_threads(1 if work < _MIN_PARALLEL_WORK else default)
    try:
        yield
    finally:
        numba.set_num_threads(default)


@lru_cache
def _kernel(k: int) -> Any:
    """Compile the kernel for k parameters: with k constant, the compiler keeps the parameters in registers."""

    def sums(regressor: Any, torque: Any, particles: Any) -> Any:
        blocks = particles.shape[0]
        out = np.zeros((blocks, _LANES))
        for block in numba.prange(blocks):
            parameters = particles[block]
            total = np.zeros(_LANES)
            for row in range(regressor.shape[0]):
                for lane in range(_LANES):
                    residual = torque[row]
                    for j in range(k):
                        residual -= regressor[row, j] * parameters[j, lane]
                    total[lane] += abs(residual)
            out[block] = total
        return out

    # A process may load several cached kernels, and numba distinguishes their symbols only by name.
    sums.__qualname__ = f"{sums.__qualname__}_{k}"
    # Only contraction to fused multiply-adds is allowed, since other options would reorder the sums. `parallel` also
    # declares that the arrays do not overlap, without which the registers would not be used.
    return compiled(sums, parallel=True, fastmath={"contract", "nsz"})
