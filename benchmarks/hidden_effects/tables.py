"""The figures on the screen, each beside what is required."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from benchmarks.hidden_effects.scoring import REACHED, Judgement

_Chosen = Callable[[Judgement], bool]
_SIZES = (0.005, 0.01, 0.03, 0.10)
_LARGE = 0.03
_WORST = 0.9
"""The quantile that stands beside the median."""


def lines(judged: Sequence[Judgement]) -> Iterator[str]:
    """All tables."""
    yield from _figures(judged)
    yield from _confusion(judged)
    yield from _parameters(judged)
    yield from _failures(judged)


def _figures(judged: Sequence[Judgement]) -> Iterator[str]:
    singles, pairs = _of(judged, "single"), _of(judged, "pair")
    nothing, outside = _of(judged, "nothing"), _of(judged, "outside")
    yield f"{len(judged)} cases"
    yield _figure("right effect first, 3 % and more", [j.right for j in singles if _size(j) >= _LARGE], 97)
    for size, required in zip(_SIZES, (None, 85, None, None), strict=True):
        here = [j for j in singles if _size(j) == size]
        yield _figure(f"  at {100 * size:g} %", [j.right for j in here], required)
    yield _figure("nothing hidden: adequate", [j.right for j in nothing], 98)
    yield _figure("pairs: both found, at most one more", [j.right for j in pairs], 85)
    yield _figure("outside the library: unknown, right variables", [j.right for j in outside], 85)
    yield _figure("  unknown-structure said", [j.verdict == "unknown-structure" for j in outside], None)
    exact = [set(j.truth[0]["depends_on"]) == set(j.variables) for j in outside]
    yield _figure("  exactly the right variables", exact, None)
    reached = [j.over_floor <= REACHED for j in (*singles, *pairs)]
    yield _figure(f"held-out error at most {REACHED:g} noise floors", reached, 95)
    yield _figure("  nothing hidden", [j.over_floor <= REACHED for j in nothing], None)
    small = [len(f.group) <= 4 for j in judged for f in j.findings]
    yield _figure("findings with four names at most", small, 100)
    named = [j for j in (*singles, *pairs) if j.right]
    yield _figure("on the right joints, where named", [j.right_joints for j in named], None)
    yield _figure("nothing said beyond what is there", [j.extra == 0 for j in (*singles, *pairs)], None)
    seconds = [j.seconds for j in judged]
    yield f"{'time for a diagnosis':50} median {np.median(seconds):.1f} s, at most {max(seconds):.1f} s"


def _figure(what: str, hits: Sequence[bool], required: float | None) -> str:
    if not hits:
        return f"{what:50} no cases"
    share = 100 * float(np.mean(hits))
    wanted = "" if required is None else f"   required {required:g} %{'' if share >= required else '   MISSED'}"
    return f"{what:50} {share:5.1f} % of {len(hits)}{wanted}"


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
    found: dict[str, list[float]] = {}
    for j in judged:
        for effect, error in j.errors.items():
            found.setdefault(effect, []).append(error)
    for effect in sorted(found):
        known = [error for error in found[effect] if np.isfinite(error)]
        if known:
            median, worst = np.median(known), np.quantile(known, _WORST)
            yield f"  {effect:26}{100 * median:7.1f} % ({100 * worst:.1f} %) of {len(known)}"


def _failures(judged: Sequence[Judgement]) -> Iterator[str]:
    failed = sorted((j for j in judged if not j.right), key=lambda j: j.case.name)
    yield f"\n{len(failed)} cases that were not right"
    for j in failed:
        said = ", ".join("|".join(f.group) + f" {list(f.joints)}" for f in j.findings)
        on = f" on {', '.join(j.variables) or 'nothing'}" if j.verdict == "unknown-structure" else ""
        truth = "; ".join(f"{one['name']} {one['joints']} {100 * one['size']:.1f} %" for one in j.truth)
        yield f"  {j.case.name}\n      there: {truth or 'nothing'}\n      said: {j.problem or j.verdict + on}: {said}"
        yield f"      held-out error {j.over_floor:.2f} noise floors"


def _of(judged: Sequence[Judgement], kind: str) -> list[Judgement]:
    return [j for j in judged if j.case.kind == kind]


def _size(j: Judgement) -> float:
    return j.case.sizes[0]
