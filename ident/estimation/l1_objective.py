"""The sum of absolute residuals, Eq. (33), of a whole swarm at once: the hot path of every swarm.

A block of particles stays in the processor's vector registers (the lanes are particles) while the rows stream by
once; blocks are shared out over the cores. Each particle's sum runs over the rows in their order whatever the number
of threads, so results are repeatable bit for bit.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numba
import numpy as np

from ident.numba_cache import compiled
from recordings.recording import Floats

_LANES = 16
"""Particles per block: two registers of eight doubles for each parameter, which fits the 32 there are."""

_MIN_PARALLEL_WORK = 5_000_000
"""Rows times particles: about a millisecond of one core."""


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
    """All threads, or one where waiting for the others on a busy machine would cost more than they save."""
    usual = numba.get_num_threads()
    numba.set_num_threads(1 if work < _MIN_PARALLEL_WORK else usual)
    try:
        yield
    finally:
        numba.set_num_threads(usual)


@lru_cache
def _kernel(k: int) -> Callable[[Floats, Floats, Floats], Floats]:
    """The kernel for k parameters: only with k known to the compiler do the parameters stay in registers."""

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

    # One process may take several kernels from disk that different ones have left there, and numba keeps what belongs
    # to them apart by their names alone.
    sums.__qualname__ = f"{sums.__qualname__}_{k}"
    # Contraction to fused multiply-adds is all that is allowed: nothing that would reorder the sums. `parallel` does
    # more than share out the blocks: it says that the arrays do not overlap, without which registers would go unused.
    return compiled(sums, parallel=True, fastmath={"contract", "nsz"}, error_model="numpy")
