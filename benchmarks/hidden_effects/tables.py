"""Print the scores with the required values."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from benchmarks.hidden_effects.scoring import REACHED, Judgement

_SIZES = (0.005, 0.01, 0.03, 0.10)
_LARGE = 0.03
_CHANCE = 0.01
"""Significance level of a missed requirement."""
_WORST = 0.9
"""Quantile that is printed with the median."""


@dataclass(frozen=True)
class Figure:
    """Share of cases in which a criterion is met."""

    criterion: str
    hits: Sequence[bool]
    required: float | None = None
    """[%]"""

    @property
    def line(self) -> str:
        """Printed line."""
        if not self.hits:
            return f"{self.criterion:50} no cases"
        share = 100 * float(np.mean(self.hits))
        missed = self.required is not None and share < self.required
        wanted = "" if self.required is None else f"   required {self.required:g} %{'   MISSED' if missed else ''}"
        return f"{self.criterion:50} {share:5.1f} % of {len(self.hits)}{wanted}"

    @property
    def clearly_missed(self) -> bool:
        """Whether the share is significantly below the required one (binomial test)."""
        if not self.hits or self.required is None:
            return False
        return bool(binom.cdf(sum(self.hits), len(self.hits), self.required / 100) < _CHANCE)


def lines(judgements: Sequence[Judgement]) -> Iterator[str]:
    """Yield the lines of all tables."""
    yield f"{len(judgements)} cases"
    yield from (figure.line for figure in figures(judgements))
    seconds = [j.seconds for j in judgements]
    yield f"{'time for a diagnosis':50} median {np.median(seconds):.1f} s, at most {max(seconds):.1f} s"
    yield from _confusion(judgements)
    yield from _parameters(judgements)
    yield from _failures(judgements)


def figures(judgements: Sequence[Judgement]) -> Iterator[Figure]:
    """Yield the scores of a benchmark."""
    singles, pairs = _of(judgements, "single"), _of(judgements, "pair")
    nothing, outside = _of(judgements, "nothing"), _of(judgements, "outside")
    yield Figure("right effect first, 3 % and more", [j.right for j in singles if _size(j) >= _LARGE], 97)
    for size, required in zip(_SIZES, (None, 85, None, None), strict=True):
        yield Figure(f"  at {100 * size:g} %", [j.right for j in singles if _size(j) == size], required)
    yield Figure("nothing hidden: adequate", [j.right for j in nothing], 98)
    yield Figure("pairs: both found, at most one more", [j.right for j in pairs], 85)
    yield Figure("outside the library: unknown, right variables", [j.right for j in outside], 85)
    yield Figure("  verdict unknown-structure", [j.verdict == "unknown-structure" for j in outside])
    exact = [set(j.truth[0]["depends_on"]) == set(j.variables) for j in outside]
    yield Figure("  exactly the right variables", exact)
    known = [j for j in (*singles, *pairs) if not np.isnan(j.over_floor)]
    reached = [j.over_floor <= REACHED for j in known]
    yield Figure(f"held-out error at most {REACHED:g} noise floors", reached, 95)
    diagnosed = [j.over_floor <= REACHED or j.extrapolates for j in known]
    yield Figure("  or cautioned as outside of the training range", diagnosed)
    yield Figure("  nothing hidden", [j.over_floor <= REACHED for j in nothing if not np.isnan(j.over_floor)])
    yield Figure("findings with four names at most", [len(f.group) <= 4 for j in judgements for f in j.findings], 100)
    yield Figure("on the right joints, where named", [j.right_joints for j in (*singles, *pairs) if j.right])
    yield Figure(
        "95 % intervals of strengths that hold the truth",
        [covered for j in singles if j.right for covered in j.covered],
    )
    yield Figure("nothing said beyond what is there", [j.extra == 0 for j in (*singles, *pairs)])


def _confusion(judgements: Sequence[Judgement]) -> Iterator[str]:
    yield "\nhidden effect: first finding and count (in brackets: its group contains the right effect)"
    rows: dict[str, Counter[str]] = {}
    for j in judgements:
        if j.case.kind != "pair":
            row = rows.setdefault(j.case.effects[0] if j.case.effects else "nothing", Counter())
            grouped = j.case.kind == "single" and j.right and j.first != j.case.effects[0]
            row[f"({j.first})" if grouped else j.first] += 1
    for effect in sorted(rows):
        yield f"  {effect:26}" + ", ".join(f"{diagnosed} {count}" for diagnosed, count in rows[effect].most_common())


def _parameters(judgements: Sequence[Judgement]) -> Iterator[str]:
    yield "\nrelative error of the strength: median (90 % quantile)"
    errors: dict[str, list[float]] = {}
    for j in judgements:
        for effect, error in j.errors.items():
            errors.setdefault(effect, []).append(error)
    for effect in sorted(errors):
        finite = [error for error in errors[effect] if np.isfinite(error)]
        if finite:
            median, worst = np.median(finite), np.quantile(finite, _WORST)
            yield f"  {effect:26}{100 * median:7.1f} % ({100 * worst:.1f} %) of {len(finite)}"


def _failures(judgements: Sequence[Judgement]) -> Iterator[str]:
    failed = sorted((j for j in judgements if not j.right), key=lambda j: j.case.name)
    yield f"\n{len(failed)} cases that were not right"
    for j in failed:
        diagnosed = ", ".join("|".join(f.group) + f" {list(f.joints)}" for f in j.findings)
        variables = f" on {', '.join(j.variables) or 'nothing'}" if j.verdict == "unknown-structure" else ""
        truth = "; ".join(f"{effect['name']} {effect['joints']} {100 * effect['size']:.1f} %" for effect in j.truth)
        yield f"  {j.case.name}\n      hidden: {truth or 'nothing'}"
        yield f"      found: {j.problem or j.verdict + variables}: {diagnosed}"
        yield f"      held-out error {j.over_floor:.2f} noise floors"


def _of(judgements: Sequence[Judgement], kind: str) -> list[Judgement]:
    return [j for j in judgements if j.case.kind == kind]


def _size(j: Judgement) -> float:
    return j.case.sizes[0]
