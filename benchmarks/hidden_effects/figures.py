"""The figures of the benchmark: shares of cases in which a criterion is met, with what is required."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.stats import binom, binomtest

from benchmarks.hidden_effects.scoring import REACHED, ScoredCase

_REQUIRED = {0.01: 98.5, 0.03: 99.0}
"""Share [%] of single effects named first, by size."""
_SIZES = (0.03, 0.01, 0.005, 0.10)
_CHANCE = 0.01
"""Significance level of a missed requirement."""


@dataclass(frozen=True)
class Figure:
    """Share of cases in which a criterion is met."""

    MISSED: ClassVar[str] = "!"

    criterion: str
    hits: Sequence[bool]
    required: float | None = None
    """[%]"""
    limit: float = 100.0
    """Largest share that is right [%]."""

    @property
    def requirement(self) -> str:
        """The required share as text."""
        if self.required is None:
            return ""
        return f"{self.required:g} %" if self.limit == 100 else f"{self.required:g}-{self.limit:g} %"

    @property
    def cell(self) -> str:
        """Printed share with its 95 % interval (Wilson) and the number of cases."""
        if not self.hits:
            return "no cases"
        low, high = (100 * limit for limit in self._interval)
        missed = self.required is not None and not self.required <= self._share <= self.limit
        share = f"{self._share:.1f} % ({low:.1f}-{high:.1f}) of {len(self.hits)}"
        return f"{share} {self.MISSED}" if missed else share

    @property
    def clearly_missed(self) -> bool:
        """Whether the share is significantly outside of the required ones (binomial test)."""
        if not self.hits or self.required is None:
            return False
        hits, count = sum(self.hits), len(self.hits)
        below = binom.cdf(hits, count, self.required / 100)
        above = binom.sf(hits - 1, count, self.limit / 100)
        return bool(min(below, above) < _CHANCE)

    @property
    def _share(self) -> float:
        return 100 * float(np.mean(self.hits))

    @property
    def _interval(self) -> tuple[float, float]:
        interval = binomtest(sum(self.hits), len(self.hits)).proportion_ci(method="wilson")
        return interval.low, interval.high


def figures(judgements: Sequence[ScoredCase]) -> Iterator[Figure]:
    """Yield the scores of a part; always the same criteria in the same order."""
    singles, pairs = _of(judgements, "single"), _of(judgements, "pair")
    nothing, outside = _of(judgements, "nothing"), _of(judgements, "outside")
    for size in _SIZES:
        hits = [j.right for j in singles if j.case.sizes[0] == size]
        yield Figure(f"right effect first, at {100 * size:g} %", hits, _REQUIRED.get(size))
    yield Figure("effect that was added later first, at 3 %", [j.right for j in _of(judgements, "added")], 95)
    yield Figure("nothing hidden: no finding, right verdict", [j.right for j in nothing], 99)
    yield Figure("  no finding", [not j.findings and not j.problem for j in nothing])
    yield Figure("pairs: both found, at most one more", [j.right for j in pairs], 97)
    yield Figure("outside the library: unknown, right variables", [j.right for j in outside], 95)
    yield Figure("  verdict unknown-structure", [j.verdict == "unknown-structure" for j in outside])
    exact = [set(j.truth[0]["depends_on"]) == set(j.variables) for j in outside]
    yield Figure("  exactly the right variables", exact)
    yield Figure("  no effect named", [not j.findings and not j.problem for j in outside])
    named = [j.is_hidden(finding) for j in judgements for finding in j.findings]
    yield Figure("names of whose group an effect is hidden", named, 99)
    known = [j for j in (*singles, *pairs) if j.case.repeats]
    yield Figure(f"held-out error at most {REACHED:g} noise floors", [j.over_floor <= REACHED for j in known], 95)
    diagnosed = [j.over_floor <= REACHED or j.extrapolates for j in known]
    yield Figure("  or cautioned as outside of the training range", diagnosed)
    reached = [j.over_floor <= REACHED for j in nothing if j.case.repeats]
    yield Figure("  nothing hidden", reached)
    yield Figure("findings with four names at most", [len(f.group) <= 4 for j in judgements for f in j.findings], 100)
    yield Figure("on the right joints, where named", [j.right_joints for j in (*singles, *pairs) if j.right], 99)
    covered = [covered for j in singles if j.right for covered in j.covered]
    yield Figure("95 % intervals of strengths that hold the truth", covered, 93, 97)
    yield Figure("nothing said beyond what is there", [j.extra == 0 for j in (*singles, *pairs)])


def _of(judgements: Sequence[ScoredCase], kind: str) -> list[ScoredCase]:
    return [j for j in judgements if j.case.kind == kind]
