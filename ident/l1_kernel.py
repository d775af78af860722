"""The sum of absolute residuals, Eq. (33), of a whole swarm at once: the hot path of every swarm.

A block of particles stays in the processor's vector registers (the lanes are particles) while the rows stream by
once; blocks are shared out over the cores. Each particle's sum runs over the rows in their order whatever the number
of threads, so results are repeatable bit for bit.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from ident.compiled import compiled
from recordings.recording import Floats

_LANES = 16
"""Particles per block: two registers of eight doubles for each parameter, which fits the 32 there are."""
_WORTH_A_THREAD = 1_000_000
"""Rows times particles; below that, starting a thread takes longer than it saves."""


class L1Objective:
    """The objective (33) of one data set: regressor (m, k), torque (m,) [N m]."""

    def __init__(self, regressor: Floats, torque: Floats, threads: int | None = None) -> None:
        self._regressor = np.ascontiguousarray(regressor)
        self._torque = np.ascontiguousarray(torque)
        self._kernel = _kernel(regressor.shape[1])
        self._threads = threads or _cores()

    def __call__(self, particles: Floats) -> Floats:
        """Sums of absolute residuals (n,) [N m] at the parameters `particles` (n, k)."""
        n, k = particles.shape
        blocks = -(-n // _LANES)
        padded = np.zeros((blocks * _LANES, k))
        padded[:n] = particles
        lanes = np.ascontiguousarray(padded.reshape(blocks, _LANES, k).transpose(0, 2, 1))
        sums = np.empty((blocks, _LANES))
        shares = self._threads if n * len(self._torque) > _WORTH_A_THREAD else 1
        edges = [blocks * share // shares for share in range(shares + 1)]
        others = [
            _pool().submit(self._kernel, self._regressor, self._torque, lanes[first:last], sums[first:last])
            for first, last in pairwise(edges[1:])
        ]
        self._kernel(self._regressor, self._torque, lanes[: edges[1]], sums[: edges[1]])
        for other in others:
            other.result()
        return sums.ravel()[:n]


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@lru_cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor()


@lru_cache
def _kernel(k: int) -> Callable[[Floats, Floats, Floats, Floats], None]:
    """The kernel for k parameters: only with k known to the compiler do the parameters stay in registers."""

    def sums(regressor: Any, torque: Any, particles: Any, out: Any) -> None:
        for block in range(particles.shape[0]):
            parameters = particles[block]
            total = np.zeros(_LANES)
            for row in range(regressor.shape[0]):
                for lane in range(_LANES):
                    residual = torque[row]
                    for j in range(k):
                        residual -= regressor[row, j] * parameters[j, lane]
                    total[lane] += abs(residual)
            out[block] = total

    # Contraction to fused multiply-adds is all that is allowed: nothing that would reorder the sums.
    return compiled(sums, nogil=True, fastmath={"contract", "nsz"}, error_model="numpy")
