"""The alarm: evidence that the residual has left what healthy recordings show, since when, and in which joints."""

from collections import deque
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.sequential.change_point import LONGEST, change
from ident.sequential.ranges import RangeEvidence
from ident.watch.baseline import Baseline
from ident.watch.blocks import BlockMaker, Rows, Visit

_PARTS = 4
"""Parts of a cycle by which a change is dated."""
ALARM = 100.0
"""Evidence of an alarm: by chance in at most one of so many runs, however long."""


@dataclass(frozen=True)
class ResidualChange:
    """What changed, as far as the residual tells."""

    joints: tuple[int, ...]
    """From 0, the clearest first."""
    since: float
    """[s]"""
    kind: Literal["sudden", "growing"]
    evidence: float
    """Mean of the e-processes when it exceeded ALARM."""


class Monitor:
    """Follows the blocks of one recording; one alarm is raised, as what comes after it is another robot."""

    def __init__(self, baseline: Baseline) -> None:
        self._baseline, self._maker = baseline, BlockMaker(baseline.period, len(baseline.low))
        self._evidence = RangeEvidence(baseline.low, baseline.high, baseline.std)
        self._cycles = deque(baseline.cycles[-LONGEST // 2 :], LONGEST)
        self._begun: deque[float | None] = deque([None] * len(self._cycles), LONGEST)
        """When each of the cycles began [s]; None: in a healthy recording."""
        self._cycle: int | None = None
        self.alarmed: float | None = None
        """When the evidence exceeded ALARM [s]."""
        self._log_evidence = -np.inf

    def observe(self, rows: Rows) -> None:
        """Take the next rows."""
        for block in self._maker.blocks(rows):
            self._take(block)

    def _take(self, block: Visit) -> None:
        if block.cycle != self._cycle:
            self._cycle = block.cycle
            self._cycles.append(np.full_like(self._baseline.low, np.nan))
            self._begun.append(block.time)
        counted = self._baseline.counts(block)
        self._cycles[-1][block.place] = np.where(counted, block.residual, np.nan)
        self._evidence.observe(block.place, block.residual, counted, block.direction)
        if self.alarmed is None and self._evidence.log_evidence > np.log(ALARM):
            self.alarmed, self._log_evidence = block.time, self._evidence.log_evidence

    def change(self) -> ResidualChange:
        """Describe what changed, as far as it is known by now."""
        assert self.alarmed is not None
        by_joint = np.logaddexp.reduce(self._evidence.log_e.reshape(len(self._evidence.log_e), -1), axis=1)
        order = np.argsort(-by_joint, kind="stable")
        needed = np.log(ALARM * self._evidence.log_e.size)
        joints = tuple(int(joint) for joint in order if joint == order[0] or by_joint[joint] > needed)
        since, kind = self._dated(joints[0])
        return ResidualChange(joints, since, kind, float(np.exp(min(self._log_evidence, 300.0))))

    def _dated(self, joint: int) -> tuple[float, Literal["sudden", "growing"]]:
        """When the residual of a `joint` changed, by the share of its present excess that parts of cycles show."""
        assert self.alarmed is not None
        baseline = self._baseline
        centre = (baseline.low + baseline.high)[:, joint] / 2
        excess = np.nan_to_num(self._evidence.excess()[:, joint])
        shares, times = [], []
        for begun, cycle in zip(self._begun, self._cycles, strict=True):
            shown = np.where(np.isfinite(cycle[:, joint]), excess, 0.0)
            parts = zip(
                *(np.array_split(x, _PARTS) for x in (shown, np.nan_to_num(cycle[:, joint] - centre))), strict=True
            )
            for number, (weight, value) in enumerate(parts):
                if power := float(weight @ weight):
                    shares.append(float(weight @ value) / power)
                    times.append(None if begun is None else begun + number / _PARTS * baseline.period)
        shares, times = shares[-LONGEST:], times[-LONGEST:]
        found = change(np.array(shares), np.arange(float(len(shares))), np.ones((len(shares), 1)))
        if found is None:
            return self.alarmed, "sudden"
        since = times[found.index]
        in_run = [time for time in times if time is not None]
        return min(self.alarmed, in_run[0] if since is None else since), "growing" if found.growing else "sudden"
