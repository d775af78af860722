"""The figures on the screen, each beside what is required."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from benchmarks.hidden_effects.scoring import REACHED, Judgement

_Chosen = Callable[[Judgement], bool]
_SIZES = (0.005, 0.01, 0.03, 0.10)
_LARGE = 0.03
_CHANCE = 0.01
"""Probability below which bad luck is no excuse."""
_WORST = 0.9
"""The quantile that stands beside the median."""


@dataclass(frozen=True)
class Figure:
    """How often something came true."""

    what: str
    hits: Sequence[bool]
    required: float | None = None
    """[%]"""

    @property
    def line(self) -> str:
        """On the screen."""
        if not self.hits:
            return f"{self.what:50} no cases"
        share = 100 * float(np.mean(self.hits))
        missed = self.required is not None and share < self.required
        wanted = "" if self.required is None else f"   required {self.required:g} %{'   MISSED' if missed else ''}"
        return f"{self.what:50} {share:5.1f} % of {len(self.hits)}{wanted}"

    @property
    def clearly_missed(self) -> bool:
        """Whether so few came true that chance does not explain it: a few cases may have bad luck."""
        if not self.hits or self.required is None:
            return False
        return bool(binom.cdf(sum(self.hits), len(self.hits), self.required / 100) < _CHANCE)


def lines(judged: Sequence[Judgement]) -> Iterator[str]:
    """All tables."""
    yield f"{len(judged)} cases"
    yield from (figure.line for figure in figures(judged))
    seconds = [j.seconds for j in judged]
    yield f"{'time for a diagnosis':50} median {np.median(seconds):.1f} s, at most {max(seconds):.1f} s"
    yield from _confusion(judged)
    yield from _parameters(judged)
    yield from _failures(judged)


def figures(judged: Sequence[Judgement]) -> Iterator[Figure]:
    """What is asked of a diagnosis."""
    singles, pairs = _of(judged, "single"), _of(judged, "pair")
    nothing, outside = _of(judged, "nothing"), _of(judged, "outside")
    yield Figure("right effect first, 3 % and more", [j.right for j in singles if _size(j) >= _LARGE], 97)
    for size, required in zip(_SIZES, (None, 85, None, None), strict=True):
        yield Figure(f"  at {100 * size:g} %", [j.right for j in singles if _size(j) == size], required)
    yield Figure("nothing hidden: adequate", [j.right for j in nothing], 98)
    yield Figure("pairs: both found, at most one more", [j.right for j in pairs], 85)
    yield Figure("outside the library: unknown, right variables", [j.right for j in outside], 85)
    yield Figure("  unknown-structure said", [j.verdict == "unknown-structure" for j in outside])
    exact = [set(j.truth[0]["depends_on"]) == set(j.variables) for j in outside]
    yield Figure("  exactly the right variables", exact)
    reached = [j.over_floor <= REACHED for j in (*singles, *pairs)]
    yield Figure(f"held-out error at most {REACHED:g} noise floors", reached, 95)
    said = [j.over_floor <= REACHED or j.beyond for j in (*singles, *pairs)]
    yield Figure("  or said to lie where no training went", said)
    yield Figure("  nothing hidden", [j.over_floor <= REACHED for j in nothing])
    yield Figure("findings with four names at most", [len(f.group) <= 4 for j in judged for f in j.findings], 100)
    yield Figure("on the right joints, where named", [j.right_joints for j in (*singles, *pairs) if j.right])
    yield Figure(
        "95 % intervals of strengths that hold the truth",
        [covered for j in singles if j.right for covered in j.inside],
    )
    yield Figure("nothing said beyond what is there", [j.extra == 0 for j in (*singles, *pairs)])


def _confusion(judged: Sequence[Judgement]) -> Iterator[str]:
    yield "\nhidden: what was said first, how often (in brackets: in a group that holds the right name)"
    rows: dict[str, Counter[str]] = {}
    for j in judged:
        if j.case.kind != "pair":
            row = rows.setdefault(j.case.effects[0] if j.case.effects else "nothing", Counter())
            grouped = j.case.kind == "single" and j.right and j.first != j.case.effects[0]
            row[f"({j.first})" if grouped else j.first] += 1
    for effect in sorted(rows):
        yield f"  {effect:26}" + ", ".join(f"{said} {count}" for said, count in rows[effect].most_common())


def _parameters(judged: Sequence[Judgement]) -> Iterator[str]:
    yield "\nerror of the strength where named, median (90 % are better than)"
    errors: dict[str, list[float]] = {}
    for j in judged:
        for effect, error in j.errors.items():
            errors.setdefault(effect, []).append(error)
    for effect in sorted(errors):
        known = [error for error in errors[effect] if np.isfinite(error)]
        if known:
            median, worst = np.median(known), np.quantile(known, _WORST)
            yield f"  {effect:26}{100 * median:7.1f} % ({100 * worst:.1f} %) of {len(known)}"


def _failures(judged: Sequence[Judgement]) -> Iterator[str]:
    failed = sorted((j for j in judged if not j.right), key=lambda j: j.case.name)
    yield f"\n{len(failed)} cases that were not right"
    for j in failed:
        said = ", ".join("|".join(f.group) + f" {list(f.joints)}" for f in j.findings)
        on = f" on {', '.join(j.variables) or 'nothing'}" if j.verdict == "unknown-structure" else ""
        truth = "; ".join(f"{effect['name']} {effect['joints']} {100 * effect['size']:.1f} %" for effect in j.truth)
        yield f"  {j.case.name}\n      there: {truth or 'nothing'}\n      said: {j.problem or j.verdict + on}: {said}"
        yield f"      held-out error {j.over_floor:.2f} noise floors"


def _of(judged: Sequence[Judgement], kind: str) -> list[Judgement]:
    return [j for j in judged if j.case.kind == kind]


def _size(j: Judgement) -> float:
    return j.case.sizes[0]
